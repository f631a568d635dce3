"""A zarr store that compares each chunk of a sweep with its digest when it is read."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from zarr.storage import LocalStore, WrapperStore

from .batch_files import DIGEST, BatchFiles

if TYPE_CHECKING:
    from zarr.abc.buffer import Buffer, BufferPrototype
    from zarr.abc.store import ByteRequest


def checked_store(files: BatchFiles) -> WrapperStore[LocalStore]:
    """Open the folder of a sweep as a zarr store.

    Reading a chunk raises `InputError` if its file was changed after it was written.  Chunks of
    batches that are not done are empty.
    """
    return _CheckedStore(LocalStore(files.folder), files)


class _CheckedStore(WrapperStore[LocalStore]):
    def __init__(self, store: LocalStore, files: BatchFiles) -> None:
        super().__init__(store)
        self.files = files

    def _with_store(self, store: LocalStore) -> _CheckedStore:
        return type(self)(store, self.files)

    async def get(
        self, key: str, prototype: BufferPrototype, byte_range: ByteRequest | None = None
    ) -> Buffer | None:
        place = self.files.place(key)
        if place is None or place[0] == DIGEST:
            return await super().get(key, prototype, byte_range)
        # Chunks are read as a whole, since their digests cover the whole file.
        content = await asyncio.to_thread(self.files.content, *place)
        return None if content is None else prototype.buffer.from_bytes(content)

"""A lock file: only one process may write to a store or folder."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from ..errors import InputError
from .writing import cannot_write


@contextlib.contextmanager
def lock(file: Path, place: str | os.PathLike[str]) -> Iterator[None]:
    """Hold a lock of the operating system on a separate file during a ``with`` block.

    The lock ends with the process.
    """
    import filelock

    held = filelock.FileLock(file, timeout=0)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        # A folder that is not writable would otherwise be reported as locked.
        file.open("a").close()
        held.acquire()
    except filelock.Timeout:
        raise InputError(
            f"another process is writing to {os.fspath(place)!r}; wait for it, or choose another "
            "place"
        ) from None
    except OSError as error:
        raise cannot_write(place, error) from None
    try:
        yield
    finally:
        held.release()

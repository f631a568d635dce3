"""Write files completely or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
import uuid
from pathlib import Path
from typing import Final

from ..errors import InputError, StoreError

# Errors of the disk rather than of the input: it is full, over quota or broken.
DISK_ERRORS: Final = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)


def write_bytes(target: Path, content: bytes) -> None:
    """Write a file completely or not at all; it is on the disk when the function returns."""
    beside = target.with_name(f".{target.name}.{os.getpid()}.partial")
    try:
        replace_file(beside, target, content)
    except OSError as error:
        raise cannot_write(target, error) from None


def replace_file(beside: Path, target: Path, content: bytes) -> None:
    """Write a temporary file, wait for the disk, and rename it."""
    try:
        with beside.open("wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        beside.replace(target)
    except BaseException:
        with contextlib.suppress(OSError):
            beside.unlink(missing_ok=True)
        raise


def temporary_name(target: Path) -> Path:
    """Name of a temporary file next to another, in the form that zarr uses."""
    return target.with_name(f"{target.name}.{uuid.uuid4().hex}.partial")


def cannot_write(
    place: str | os.PathLike[str], error: OSError, hint: str = "choose another place"
) -> InputError | StoreError:
    """The error for a file or folder that cannot be written, to be raised by the caller."""
    reason = error.strerror or str(error)
    if error.errno in DISK_ERRORS:
        return StoreError(f"cannot write {os.fspath(place)!r} ({reason})")
    return InputError(f"cannot write {os.fspath(place)!r} ({reason}); {hint}")

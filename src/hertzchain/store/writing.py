"""Write files whole or not at all, and raise one error when that fails."""

from __future__ import annotations

import contextlib
import errno
import os
import uuid
from pathlib import Path
from typing import Final

from hertzchain.errors import InputError, StoreError

# The request was sound, and the disk failed: it is full, over quota or broken.
DISK_ERRORS: Final = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)


def write_bytes(target: Path, content: bytes) -> None:
    """Write a file whole or not at all; when the function returns, it is on the disk.

    Parameters
    ----------
    target : pathlib.Path
        File to write.
    content : bytes
        All of its content.

    Raises
    ------
    InputError
        If there can be no such file.
    StoreError
        If the disk is full.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_bytes(Path(folder) / "a.txt", b"done")
    """
    beside = target.with_name(f".{target.name}.{os.getpid()}.partial")
    try:
        replace_file(beside, target, content)
    except OSError as error:
        raise cannot_write(target, error) from None


def replace_file(beside: Path, target: Path, content: bytes) -> None:
    """Write into a temporary file, wait for the disk, and rename it.

    Parameters
    ----------
    beside : pathlib.Path
        The temporary file; removed if anything fails.
    target : pathlib.Path
        File to write or replace.
    content : bytes
        All of its content.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     replace_file(Path(folder) / "a.partial", Path(folder) / "a", b"done")
    ...     [file.name for file in Path(folder).iterdir()]
    ['a']
    """
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
    """Name of a temporary file beside another, as zarr forms it.

    Parameters
    ----------
    target : pathlib.Path
        File to write.

    Returns
    -------
    pathlib.Path

    Examples
    --------
    >>> len(temporary_name(Path("velocity/c/0")).name)
    42
    """
    return target.with_name(f"{target.name}.{uuid.uuid4().hex}.partial")


def cannot_write(
    place: str | os.PathLike[str], error: OSError, hint: str = "choose another place"
) -> InputError | StoreError:
    """The error for a file or folder that cannot be written, to be raised by the caller.

    Parameters
    ----------
    place : path-like
        The file or folder that the user gave.
    error : OSError
        Why it cannot be written.
    hint : str
        What to try if there can be no such file.

    Returns
    -------
    InputError or StoreError
        `StoreError` (exit code 1) if the disk failed, otherwise `InputError` (exit code 2).

    Examples
    --------
    >>> print(cannot_write("a/b.csv", PermissionError(errno.EACCES, "Permission denied")))
    cannot write 'a/b.csv' (Permission denied); choose another place
    """
    reason = error.strerror or str(error)
    if error.errno in DISK_ERRORS:
        return StoreError(f"cannot write {os.fspath(place)!r} ({reason})")
    return InputError(f"cannot write {os.fspath(place)!r} ({reason}); {hint}")

"""Keep others out of what one process writes."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from hertzchain.errors import InputError
from hertzchain.store.writing import cannot_write


@contextlib.contextmanager
def lock(file: Path, place: str | os.PathLike[str]) -> Iterator[None]:
    """Hold a lock for the time of a ``with`` block.

    It is the operating system's, on a file of its own: it ends with the process.

    Parameters
    ----------
    file : pathlib.Path
        The file, made if it does not exist.
    place : path-like
        What it stands for, for the error.

    Raises
    ------
    InputError
        If another process has it, or the file cannot be made.
    StoreError
        If the disk is full.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder, lock(Path(folder) / ".lock", folder):
    ...     pass
    """
    import filelock

    held = filelock.FileLock(file, timeout=0)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        # What cannot be written would look as if it were locked.
        file.open("a").close()
        held.acquire()
    except filelock.Timeout:
        raise InputError(
            f"another process writes into {os.fspath(place)!r}: wait for it, or choose another "
            "place"
        ) from None
    except OSError as error:
        raise cannot_write(place, error) from None
    try:
        yield
    finally:
        held.release()

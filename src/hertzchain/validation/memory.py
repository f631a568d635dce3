"""Check that arrays fit in memory before they are allocated."""

from __future__ import annotations

from typing import Final

from ..errors import InputError

GIB: Final = 2**30
# Bytes that any machine has: the free memory is measured only for more, because this takes time.
ALWAYS_FREE: Final = 2**28


def check_memory(what: str, needed: float, advice: str, usable: float = 1.0) -> None:
    """Raise `InputError` if more than the usable part of the free memory is needed [bytes]."""
    if needed < ALWAYS_FREE:
        return
    import psutil

    free = psutil.virtual_memory().available
    if needed > usable * free:
        raise InputError(
            f"{what} need {needed / GIB:.1f} GiB of memory, but {free / GIB:.1f} GiB are free; "
            f"{advice}"
        )

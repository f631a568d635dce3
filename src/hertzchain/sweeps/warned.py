"""Warnings of methods: heard, not shown, also where several threads compute."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

# Warnings are a matter of the whole process: batches in threads share one recorder.
_lock = threading.Lock()
_users = 0
_quiet = warnings.catch_warnings()
_show = warnings.showwarning
_heard = threading.local()


@contextmanager
def recorded() -> Iterator[list[type[Warning]]]:
    """Categories of the warnings in a ``with`` block of this thread; none is shown.

    Yields
    ------
    list of type
        Filled as they come.

    Examples
    --------
    >>> from hertzchain.errors import ModelRangeWarning
    >>> with recorded() as heard:
    ...     warnings.warn("outside", ModelRangeWarning)
    >>> heard
    [<class 'hertzchain.errors.ModelRangeWarning'>]
    """
    global _quiet, _show, _users
    mine: list[type[Warning]] = []
    with _lock:
        if not _users:
            _quiet = warnings.catch_warnings()
            _quiet.__enter__()
            _show = warnings.showwarning
            warnings.simplefilter("always")
            warnings.showwarning = _hear
        _users += 1
    outer = getattr(_heard, "categories", None)
    _heard.categories = mine
    try:
        yield mine
    finally:
        _heard.categories = outer
        with _lock:
            _users -= 1
            if not _users:
                _quiet.__exit__(None, None, None)


def _hear(message: Any, category: type[Warning], *where: Any, **more: Any) -> None:
    categories = getattr(_heard, "categories", None)
    if categories is None:
        # Of a thread that computes no batch, such as the one that tells progress.
        _show(message, category, *where, **more)
    else:
        categories.append(category)

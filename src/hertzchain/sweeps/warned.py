"""Warnings of methods: heard, not shown, also where several threads compute."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

# Warnings are a matter of the whole process: batches in threads share one recorder.
_lock = threading.Lock()
_users: list[object] = []
_quiet = warnings.catch_warnings()
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
    global _quiet
    mine: list[type[Warning]] = []
    with _lock:
        if not _users:
            _quiet = warnings.catch_warnings()
            _quiet.__enter__()
            warnings.simplefilter("always")
            warnings.showwarning = _hear  # type: ignore[assignment]
        _users.append(mine)
    _heard.categories = mine
    try:
        yield mine
    finally:
        with _lock:
            _users.pop()
            if not _users:
                _quiet.__exit__(None, None, None)


def _hear(_: object, category: type[Warning], *__: object, **___: object) -> None:
    getattr(_heard, "categories", []).append(category)

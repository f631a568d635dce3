"""Record or ignore the warnings of one thread.

The filters of the module ``warnings`` belong to the whole process: while one thread ignores
warnings, those of all others are lost.  `errors.warn_user` therefore asks this module first.
"""

from __future__ import annotations

import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

_Listener = Callable[[Warning], bool]
# Each takes a warning, or leaves it to the one before.
_listeners: ContextVar[tuple[_Listener, ...]] = ContextVar("listeners", default=())


def is_taken(warning: Warning) -> bool:
    """Whether a ``with`` block around the caller has recorded or ignored the warning."""
    return any(listener(warning) for listener in reversed(_listeners.get()))


@contextmanager
def _listening(listener: _Listener) -> Iterator[None]:
    before = _listeners.get()
    _listeners.set((*before, listener))
    try:
        yield
    finally:
        # Not by a token: a generator may be closed by another thread than the one that began it.
        _listeners.set(before)


@contextmanager
def ignore_warnings(*categories: type[Warning]) -> Iterator[None]:
    """Ignore the warnings of this package in a ``with`` block; without categories, all of them."""
    with _listening(lambda warning: isinstance(warning, categories or Warning)):
        yield


class ObserveWarnings:
    """List the texts of warnings of a category in a ``with`` block, which are also shown.

    This is a class because theories that take 30 microseconds use it, and a generator takes four.
    """

    def __init__(self, category: type[Warning]) -> None:
        self.category, self.texts = category, list[str]()

    def __enter__(self) -> list[str]:
        self.before = _listeners.get()
        _listeners.set((*self.before, self._observe))
        return self.texts

    def __exit__(self, *_: object) -> None:
        _listeners.set(self.before)

    def _observe(self, warning: Warning) -> bool:
        if isinstance(warning, self.category):
            self.texts.append(str(warning))
        return False


@contextmanager
def record_warnings() -> Iterator[list[Warning]]:
    """Record the warnings in a ``with`` block, showing none."""
    recorded: list[Warning] = []

    def record(warning: Warning) -> bool:
        recorded.append(warning)
        return True

    with _listening(record), _foreign_warnings():
        yield recorded


# Warnings of other packages, and of theories that a user has registered, are issued by
# ``warnings.warn``.  One hook serves all threads.
_lock = threading.Lock()
_users = 0
_filters = warnings.catch_warnings()
_show = warnings.showwarning


@contextmanager
def _foreign_warnings() -> Iterator[None]:
    global _filters, _show, _users
    with _lock:
        if not _users:
            _filters = warnings.catch_warnings()
            _filters.__enter__()
            _show = warnings.showwarning
            warnings.simplefilter("always")
            warnings.showwarning = _hook
        _users += 1
    try:
        yield
    finally:
        with _lock:
            _users -= 1
            if not _users:
                _filters.__exit__(None, None, None)


def _hook(message: Any, category: type[Warning], *where: Any, **more: Any) -> None:
    # A thread without a recorder may show the progress, for example.
    if not is_taken(message):
        _show(message, category, *where, **more)

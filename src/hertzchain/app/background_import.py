"""Import of the library in the background, while the page is already served."""

from __future__ import annotations

import threading
from typing import Final

LOADED: Final = threading.Event()
_LOCK: Final = threading.Lock()


def load() -> None:
    """Import all that answers need; in one thread, because simultaneous imports can conflict."""
    with _LOCK:
        if not LOADED.is_set():
            from .. import warm_start  # noqa: F401
            from . import about, exports, results  # noqa: F401

            LOADED.set()

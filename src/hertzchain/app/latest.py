"""The newest request of each page: a newer one stops the older one."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from typing import Final

MAX_SESSIONS: Final = 64


class Latest:
    """Numbers of the newest requests by session and slot."""

    def __init__(self) -> None:
        self._newest: OrderedDict[tuple[str, str], int] = OrderedDict()
        self._lock = threading.Lock()

    def begin(self, session: str, slot: str, number: int) -> Callable[[], bool]:
        """Register a request; return a function that checks whether it is out of date."""
        key = session, slot
        with self._lock:
            self._newest[key] = max(number, self._newest.get(key, -1))
            self._newest.move_to_end(key)
            while len(self._newest) > MAX_SESSIONS:
                self._newest.popitem(last=False)
        return lambda: self._newest.get(key, number) > number

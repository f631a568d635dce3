"""Compile the functions that the first results need, in the background."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Final

from ..chain.chain import Chain
from ..warm_start import BEADS, FIRST, Stage

# Stages that must be complete before the message that follows another one, for default chains and
# for general chains.
NEEDED: Final = {"beads": (2, 4), "pulse": (3, 4)}
POLL: Final = 0.05


class WarmUp:
    """Progress of the compilation, which numba's cache reduces to seconds after the first time."""

    def __init__(self, stages: tuple[Stage, ...] = FIRST) -> None:
        self._stages = stages
        self._done = 0
        self._thread = threading.Thread(target=self._work, daemon=True)

    def start(self) -> None:
        """Start in a thread that does not keep the process alive."""
        self._thread.start()

    def _work(self) -> None:
        chain = Chain.tapered("backward-exponential", 0.05, beads=BEADS)
        for stage in self._stages:
            try:
                stage.run(chain)
            finally:
                self._done += 1

    def pending(self) -> list[str]:
        """Names of kernels that are not compiled yet, in order."""
        return [stage.name for stage in self._stages[self._done :]]

    def wait(self, part: str, *, general: bool, stop: Callable[[], bool]) -> None:
        """Wait for the kernels that the message after ``part`` needs, or until ``stop()`` is true.

        Otherwise threads of requests that are out of date would wait for the compiler.
        """
        needed = min(NEEDED.get(part, (0, 0))[general], len(self._stages))
        while self._done < needed and not stop():
            time.sleep(POLL)

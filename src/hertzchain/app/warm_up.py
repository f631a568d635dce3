"""Compile the functions that the first results need, in the background."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Collection
from typing import TYPE_CHECKING, Final

from . import background_import

if TYPE_CHECKING:
    from ..warm_start import Stage

# Stages that must be complete before the message that follows another one: for default chains, for
# other elastic chains, and for chains with losses.
NEEDED: Final = {"beads": (3, 1, 5), "pulse": (4, 1, 5)}
LOSSES: Final = {"loss", "mixed losses"}
POLL: Final = 0.05


class WarmUp:
    """Progress of the compilation, which numba's cache reduces to seconds after the first time.

    Without stages, those of `hertzchain.warm_start` are compiled.
    """

    def __init__(self, stages: tuple[Stage, ...] | None = None) -> None:
        self._stages = stages
        self._done = 0
        self._thread = threading.Thread(target=self._work, daemon=True)

    def start(self) -> None:
        """Start in a thread that does not keep the process alive."""
        self._thread.start()

    def _work(self) -> None:
        background_import.load()
        from ..chain.chain import Chain
        from ..warm_start import BEADS

        chain = Chain.tapered("backward-exponential", 0.05, beads=BEADS)
        try:
            for stage in self._known():
                stage.run(chain)
                self._done += 1
        finally:
            # If a stage fails, a request reports the error instead of waiting.
            self._done = len(self._known())

    def pending(self) -> list[str]:
        """Names of kernels that are not compiled yet, in order."""
        if self._stages is None and not background_import.LOADED.is_set():
            return ["the library"]
        return [stage.name for stage in self._known()[self._done :]]

    def _known(self) -> tuple[Stage, ...]:
        if self._stages is None:
            from ..warm_start import INTERACTIVE

            self._stages = INTERACTIVE
        return self._stages

    def wait(self, part: str, features: Collection[str], stop: Callable[[], bool]) -> None:
        """Wait for the kernels that the message after ``part`` needs, or until ``stop()`` is true.

        Otherwise threads of requests that are out of date would wait for the compiler.
        """
        kind = 2 if LOSSES & {*features} else 1 if {*features} - {"SI units"} else 0
        needed = NEEDED[part][kind] if part in NEEDED else 0
        while self._done < needed and self.pending() and not stop():
            time.sleep(POLL)

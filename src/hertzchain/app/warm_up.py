"""Compile the functions that the first results need, in the background."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Final

from ..chain.chain import Chain
from ..chain.laws.dashpot import Dashpot
from ..chain.walls import Wall
from ..propagation.propagate import propagate
from ..simulation.simulate import simulate
from ..theory.local_rate import local_rate

Stage = tuple[str, Callable[[Chain], object]]

STAGES: Final[tuple[Stage, ...]] = (
    ("the simulation of the pulse", propagate),
    ("the local-rate law", local_rate),
    ("the simulation of all beads", lambda chain: simulate(chain, rtol=1e-6)),
    ("walls and losses", lambda chain: simulate(
        chain.replace(right_wall=Wall(), loss=Dashpot(0.1)), rtol=1e-6)),
    ("heterogeneous chains", lambda chain: propagate(
        Chain.from_radii([*chain.radii, 2.0 * chain.radii[0], *chain.radii]))),
)  # fmt: skip


# Stages that must be complete before the message that follows another one, for default chains and
# for general chains.
NEEDED: Final = {"beads": (2, 4), "pulse": (3, 4)}
POLL: Final = 0.05


class WarmUp:
    """Progress of the compilation, which numba's cache reduces to seconds after the first time."""

    def __init__(self, stages: tuple[Stage, ...] = STAGES) -> None:
        self._stages = stages
        self._done = 0
        self._thread = threading.Thread(target=self._work, daemon=True)

    def start(self) -> None:
        """Start in a thread that does not keep the process alive."""
        self._thread.start()

    def _work(self) -> None:
        chain = Chain.tapered("backward-exponential", 0.05, beads=12)
        for _, compile_stage in self._stages:
            try:
                compile_stage(chain)
            finally:
                self._done += 1

    def pending(self) -> list[str]:
        """Names of kernels that are not compiled yet, in order."""
        return [name for name, _ in self._stages[self._done :]]

    def wait(self, part: str, *, general: bool, stop: Callable[[], bool]) -> None:
        """Wait for the kernels that the message after ``part`` needs, or until ``stop()`` is true.

        Otherwise threads of requests that are out of date would wait for the compiler.
        """
        needed = min(NEEDED.get(part, (0, 0))[general], len(self._stages))
        while self._done < needed and not stop():
            time.sleep(POLL)

"""Compile the functions that the first results need, in the background."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
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


class WarmUp:
    """Progress of the compilation, which numba's cache reduces to seconds after the first time."""

    def __init__(self, stages: tuple[Stage, ...] = STAGES) -> None:
        self._left = list(stages)
        self._thread = threading.Thread(target=self._work, daemon=True)

    def start(self) -> None:
        """Begin in a thread that does not keep the process alive."""
        self._thread.start()

    def _work(self) -> None:
        chain = Chain.tapered("backward-exponential", 0.05, beads=12)
        while self._left:
            self._left[0][1](chain)
            del self._left[0]

    def pending(self) -> Iterator[str]:
        """Names of kernels that are not compiled yet, in order."""
        yield from (name for name, _ in self._left.copy())

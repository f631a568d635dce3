"""Repeated impacts on a chain whose contacts keep their dents."""

from __future__ import annotations

import math
from typing import Any

from ..chain.chain import Chain
from ..errors import InputError, SimulationError
from ..recorded_warnings import ignore_warnings
from .run import Run
from .simulate import simulate
from .yielding import MAX_BEADS


def struck_repeatedly(run: Run, hits: int, **options: Any) -> list[Run]:
    """The run and its repetitions, each with the dents of the previous ones.

    Options are those of `simulate`.
    """
    runs = [run]
    while len(runs) < hits:
        runs.append(simulate(run.chain, start=runs[-1].state.struck_again(), **options))
    return runs


def leaves_dents(chain: Chain) -> bool:
    """Whether the law of any contact leaves dents."""
    contacts = zip(chain.contact_losses, chain.contact_stiffness, strict=True)
    return any(law.leaves_dents and stiffness > 0.0 for law, stiffness in contacts)


def peak_of_second_hit(chain: Chain, until: float | None = None) -> float:
    """Peak on the right wall if the chain is struck again with its dents.

    NaN if the first hit leaves no dents, the chain cannot be struck again, it is too long for two
    further simulations, or the peak is not complete.
    """
    if chain.right_wall is None or chain.beads > MAX_BEADS or not leaves_dents(chain):
        return math.nan
    options: dict[str, Any] = {"times": 0, "check": False, "until": until}
    with ignore_warnings():  # Those of the chain itself are shown.
        try:
            first = simulate(chain, **options)
            if not first.dents.any():
                return math.nan
            wall = struck_repeatedly(first, 2, **options)[-1]._wall_force("right")
        except (InputError, SimulationError):
            return math.nan
    return wall.peak if wall.complete else math.nan

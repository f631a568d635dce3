"""Repeated impacts on a chain whose contacts keep their dents."""

from __future__ import annotations

import math
from typing import Any

from ..chain.chain import Chain
from ..errors import InputError, SimulationError
from ..recorded_warnings import ignore_warnings
from .body_force import body_force
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


def second_hit(run: Run) -> float:
    """Peak on the right wall, or largest force on a cap without a wall, of a second equal impact.

    NaN if the run leaves no dents, the chain cannot be struck again, it is too long for a further
    simulation, or the peak is not complete.
    """
    chain = run.chain
    if chain.beads > MAX_BEADS or not leaves_dents(chain) or not run.dents.any():
        return math.nan
    until = run.end_time if run.status == "time reached" else None
    with ignore_warnings():  # Those of the run itself are shown.
        try:
            again = struck_repeatedly(run, 2, times=0, check=False, until=until)[-1]
        except (InputError, SimulationError):
            return math.nan
    return peak_at_right_end(again)


def peak_at_right_end(run: Run) -> float:
    """Complete peak on the right wall, or largest force on a cap without a wall; otherwise NaN."""
    if run.chain.right_wall is None:
        body = body_force(run) if run.chain._free_cap else None
        return body.force if body is not None and body.complete else math.nan
    wall = run._wall_force("right")
    return wall.peak if wall.complete else math.nan


def peak_of_second_hit(chain: Chain, until: float | None = None) -> float:
    """Peak on the right wall, or on a cap without a wall, if a chain with dents is struck again.

    If the first hit leaves no dents, it is that of this hit.  NaN if no law leaves dents, the chain
    cannot be struck again, it is too long for two further simulations, or the peak is not complete.
    """
    at_end = chain.right_wall is not None or chain._free_cap
    if not at_end or chain.beads > MAX_BEADS or not leaves_dents(chain):
        return math.nan
    with ignore_warnings():  # Those of the chain itself are shown.
        try:
            first = simulate(chain, times=0, check=False, until=until)
        except (InputError, SimulationError):
            return math.nan
    return second_hit(first) if first.dents.any() else peak_at_right_end(first)

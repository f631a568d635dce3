"""Motion of the initial chain and of the design, as curves to compare."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import IncompleteWarning, InputWarning, ModelRangeWarning
from ..simulation.simulate import simulate

if TYPE_CHECKING:
    from .result import DesignResult

# Saved times of the forces.
TIMES: Final = 2000
RTOL: Final = 1e-8


class Curve(NamedTuple):
    """Force on the wall over time, or without a wall the velocity of the leading pulse by bead."""

    x: Array
    y: Array


def initial_and_final(result: DesignResult) -> tuple[Curve, Curve]:
    """Simulate the initial chain and the design."""
    with warnings.catch_warnings():
        # The result has the limits of the models among its notes.
        for each in (InputWarning, ModelRangeWarning, IncompleteWarning):
            warnings.simplefilter("ignore", each)
        initial, final = (_curve(result, chain) for chain in (result.problem.chain, result.chain))
    return initial, final


def _curve(result: DesignResult, chain: Chain) -> Curve:
    if chain.right_wall is None:
        pulse = simulate(chain, times=0, rtol=RTOL).pulse()
        return Curve(np.arange(1.0, chain.beads + 1), pulse.velocity)
    end = simulate(chain, times=0, rtol=RTOL, until=result.problem.until).end_time
    run = simulate(chain, times=TIMES, rtol=RTOL, until=end)
    return Curve(run.times, run.wall_force().force)

"""Motion of the initial chain and of the design, as curves to compare."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from ..collision import Array
from ..errors import IncompleteWarning, InputWarning, ModelRangeWarning
from ..pulse.quantities import QUANTITIES
from ..simulation.simulate import simulate

if TYPE_CHECKING:
    from .result import DesignResult

# Saved times of the forces.
TIMES: Final = 2000
RTOL: Final = 1e-8
# Force, relative to its peak, that counts as none at the end of a curve.
QUIET: Final = 0.01


class Curve(NamedTuple):
    """Force on the wall over time, or without a wall a quantity of the leading pulse by bead."""

    x: Array
    y: Array
    peak: float


def initial_and_final(result: DesignResult, most: float) -> tuple[Curve, Curve]:
    """Simulate the initial chain and the design, for the same time.

    Each chain has its own time if these differ by more than the factor ``most``.
    """
    with warnings.catch_warnings():
        # The result has the limits of the models among its notes.
        for each in (InputWarning, ModelRangeWarning, IncompleteWarning):
            warnings.simplefilter("ignore", each)
        if result.chain.right_wall is not None:
            initial, final = _forces(result, most)
        else:
            initial, final = _pulses(result)
    return initial, final


def plotted_quantity(result: DesignResult) -> str:
    """Quantity of the leading pulse that the objective refers to; the velocity if there is none."""
    single = result.problem.objective.single
    name = "velocity" if single is None else single.quantity
    return name if name in QUANTITIES else "velocity"


def _pulses(result: DesignResult) -> list[Curve]:
    name = plotted_quantity(result)
    pulses = [simulate(chain, times=0, rtol=RTOL).pulse()
              for chain in (result.problem.chain, result.chain)]  # fmt: skip
    found = []
    for each in pulses:
        values = each.column(name)
        assert values is not None
        found.append(Curve(1.0 + np.arange(len(values)), values, float(np.nanmax(values))))
    return found


def _forces(result: DesignResult, most: float) -> list[Curve]:
    chains, until = (result.problem.chain, result.chain), result.problem.until
    ends = [simulate(chain, times=0, rtol=RTOL, until=until).end_time for chain in chains]
    together = max(ends) <= most * min(ends)
    if together:
        ends = [max(ends)] * 2
    walls = [simulate(chain, times=TIMES, rtol=RTOL, until=end).wall_force()
             for chain, end in zip(chains, ends, strict=True)]  # fmt: skip
    curves = [Curve(each.times, each.force, each.largest_so_far) for each in walls]
    return _until_quiet(curves) if together else [_until_quiet([each])[0] for each in curves]


def _until_quiet(curves: Sequence[Curve]) -> list[Curve]:
    """Cut curves with the same times where all forces are small, before a further impact begins."""
    quiet = np.all([each.y < QUIET * each.y.max() for each in curves], axis=0)
    quiet[: max(int(each.y.argmax()) for each in curves)] = False
    end = int(np.flatnonzero(quiet)[-1]) + 1 if quiet.any() else None
    return [each._replace(x=each.x[:end], y=each.y[:end]) for each in curves]

"""Motion of a design and of the best chain without a search, as curves to compare."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from ..chain.chain import Chain
from ..chain.hertz_ratios import NO_PREDICTION
from ..collision import Array
from ..errors import IncompleteWarning, InputWarning, ModelRangeWarning
from ..pulse.quantities import QUANTITIES
from ..recorded_warnings import ignore_warnings
from ..simulation.body_force import body_curve
from ..simulation.simulate import simulate
from ..simulation.yielding import dented_chain, largest_overlap_ratio, may_dent
from .comparison import shown_chains
from .measures import BODY, SENSORS

if TYPE_CHECKING:
    from ..simulation.run import Run
    from .result import DesignResult

# Saved times of the forces.
TIMES: Final = 2000
RTOL: Final = 1e-8
# Force, relative to its peak, that counts as none at the end of a curve.
QUIET: Final = 0.01
# Force, relative to its peak, that matters: late contacts with less do not lengthen a figure.
SMALL: Final = 0.05
# Part of the time in which forces act at least, and the time after them that is kept otherwise.
FILLED, MARGIN = 0.5, 0.1


class Curve(NamedTuple):
    """Force on the wall or cap over time, or else a quantity of the leading pulse by bead.

    ``name`` is that of `shown_chains`; ``yields`` states whether the contacts yield, ``outside``
    whether overlaps are then outside the range of the law.
    """

    name: str
    yields: bool
    x: Array
    y: Array
    peak: float
    outside: bool = False


class _Motion(NamedTuple):
    """A chain to simulate."""

    name: str
    yields: bool
    chain: Chain


def compared_curves(result: DesignResult, most: float) -> list[Curve]:
    """Simulate the design and the chain to compare it with, for the same time.

    Each chain has its own time if these differ by more than the factor ``most``.  If contacts
    exceed the pressure at first yield, a second curve of this chain is that of contacts that yield.
    """
    motions = []
    with ignore_warnings(InputWarning, ModelRangeWarning, IncompleteWarning):
        # The result has the limits of the models among its notes.
        for name, found in shown_chains(result).items():
            motions.append(_Motion(name, False, found.chain))
            limits = found.hertz_range
            denting = limits is not None and may_dent(limits)
            if denting and (dented := dented_chain(found.chain)) is not None:
                motions.append(_Motion(name, True, dented))
        if not shows_forces(result):
            return _pulses(result, motions)
        return _forces(motions, result.problem.until, most)


def shows_forces(result: DesignResult) -> bool:
    """Whether curves are those of the force on a wall, or on a cap that is the objective."""
    chain, single = result.chain, result.problem.objective.single
    if chain.right_wall is not None or single is None:
        return chain.right_wall is not None
    of_sensor = single.key in SENSORS and single.index(chain.beads) + 1 == chain.beads
    return single.key in BODY or (of_sensor and chain._free_cap)


def plotted_quantity(result: DesignResult) -> str:
    """Quantity of the leading pulse that the objective refers to; the velocity if there is none."""
    single = result.problem.objective.single
    name = "velocity" if single is None else single.quantity
    return name if name in QUANTITIES else "velocity"


def _pulses(result: DesignResult, motions: Sequence[_Motion]) -> list[Curve]:
    quantity, found = plotted_quantity(result), []
    for name, with_yield, chain in motions:
        run = simulate(chain, times=0, rtol=RTOL)
        values = run.pulse().column(quantity)
        assert values is not None
        beads, peak = 1.0 + np.arange(len(values)), float(np.nanmax(values))
        found.append(Curve(name, with_yield, beads, values, peak, with_yield and _outside(run)))
    return found


def _forces(motions: Sequence[_Motion], until: float | None, most: float) -> list[Curve]:
    ends = dict[str, float]()
    for name, _, chain in motions:
        end = simulate(chain, times=0, rtol=RTOL, until=until).end_time
        ends[name] = max(end, ends.get(name, 0.0))
    together = max(ends.values()) <= most * min(ends.values())
    if together:
        ends = dict.fromkeys(ends, max(ends.values()))
    curves = []
    for name, with_yield, chain in motions:
        run = simulate(chain, times=TIMES, rtol=RTOL, until=ends[name])
        if chain.right_wall is None:
            curves.append(_on_body(run, name, with_yield))
            continue
        wall, outside = run.wall_force(), with_yield and _outside(run)
        curves.append(Curve(name, with_yield, wall.times, wall.force, wall.largest_so_far, outside))
    if together:
        return _until_quiet(curves)
    return [cut for name in ends for cut in _until_quiet([c for c in curves if c.name == name])]


def _on_body(run: Run, name: str, with_yield: bool) -> Curve:
    """Force on the last body, without the static force."""
    times, force = body_curve(run)
    return Curve(name, with_yield, times, force, float(force.max()), with_yield and _outside(run))


def _outside(run: Run) -> bool:
    """Whether overlaps of contacts that yield are outside the range of their law."""
    return largest_overlap_ratio(run.chain, run.largest_overlaps) > NO_PREDICTION


def _until_quiet(curves: Sequence[Curve]) -> list[Curve]:
    """Cut curves with the same times where all forces are small, before a further pulse arrives.

    If forces above 5% of the peak act in less than half of the time that is left, most of the rest
    is cut, too.
    """
    quiet = np.all([each.y < QUIET * each.y.max() for each in curves], axis=0)
    quiet[: max(int(each.y.argmax()) for each in curves)] = False
    end = int(np.flatnonzero(quiet)[-1]) + 1 if quiet.any() else len(quiet)
    loud = np.any([each.y >= SMALL * each.y.max() for each in curves], axis=0)[:end]
    last = int(np.flatnonzero(loud)[-1]) if loud.any() else end
    if last < FILLED * end:
        end = int((1.0 + MARGIN) * last) + 1
    return [each._replace(x=each.x[:end], y=each.y[:end]) for each in curves]

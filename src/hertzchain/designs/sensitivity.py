"""Sensitivity of a result to each bead, by simulations of changed chains."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from types import MappingProxyType
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..chain.random_radii import check_gaps_can_open
from ..collision import Array
from ..derivatives.differences import FIELDS, Differences, changed, needs_differences
from ..derivatives.gradient import gradient
from ..derivatives.kinks import PART, mislead
from ..derivatives.names import OF_BODY
from ..derivatives.relative import per_unit, unit_of_parameter
from ..derivatives.result import Gradient
from ..errors import InputError
from ..simulation.simulate import simulate
from ..validation.objects import Progress
from .exact_gradients import PEAK
from .measured import measured
from .measures import ENDS, LARGEST_IN_SENSOR, SENSORS, Measure
from .problem import Design

STEP, RTOL = 1e-4, 1e-9
# Measures with simulated changes.
MEASURES: Final = (PEAK, *map(Measure, OF_BODY))
# By which a gap grows, and in words: derivatives by gaps hold only far below the overlaps.
GAP_STEP: Final = MappingProxyType({"SI": (1e-6, "1 um"), "scaled": (0.01, "0.01")})


def sensitivity(problem: Design, chain: Chain) -> Array:
    """Central differences of the objective with respect to the logarithms of the radii."""
    larger, smaller = _changes_of_objective(problem, chain, (np.exp(STEP), np.exp(-STEP)))
    return np.asarray((larger - smaller) / (2.0 * STEP))


def changes(problem: Design, chain: Chain, part: float) -> tuple[Array, Array]:
    """Relative changes of the objective if the radius of one bead grows or shrinks by a part.

    They are simulated.  At a design, several maxima of a force are often equal, and every change of
    a radius increases one of them.
    """
    larger, smaller = _changes_of_objective(problem, chain, (1.0 + part, 1.0 - part))
    return np.expm1(larger), np.expm1(smaller)


def changes_of_peak(
    chain: Chain,
    found: Gradient,
    by: str,
    until: float | None = None,
    progress: Progress | None = None,
) -> tuple[Array, Array] | None:
    """Simulated relative changes of a peak if one value grows or shrinks by 1%.

    The peak is that on the right wall or on the last body of a free end, or the acceleration there.

    `None` for other quantities, for parameters such as Young's modulus, and if no changed
    chain has a complete peak.
    """
    measure = next((each for each in MEASURES if each.key == found.quantity), None)
    if measure is None or by not in FIELDS:
        return None

    def peaks(chains: list[Chain]) -> Array:
        return measured(chains, [measure], until=until, rtol=RTOL, progress=progress).values[:, 0]

    larger, smaller = np.expm1(_changes_of_logarithm(peaks, chain, by, (1.0 + PART, 1.0 - PART)))
    return None if np.isnan([larger, smaller]).all() else (larger, smaller)


def end_of_run(chain: Chain, measure: Measure, until: float | None) -> float | None:
    """Stop time for a force, by default the end of the run, as for `distribution`.

    Forces that cannot be exceeded need none: derivatives follow from the steps up to them.
    """
    later = measure.key in (*OF_BODY, LARGEST_IN_SENSOR)
    # Static forces end neither an impact nor the waves.
    static = chain.gravity != 0.0 or chain.precompression != 0.0
    if until is not None or not (later or (static and measure.key in (*ENDS, *SENSORS))):
        return until
    return simulate(chain, times=0, rtol=RTOL).end_time


def gradient_by_gaps(
    chain: Chain, name: str, until: float | None = None, progress: Progress | None = None
) -> Gradient:
    """Value of a quantity and its derivatives by gaps, which are NaN if the loss has no exact ones.

    Differences would depend on their step: the derivatives of closed gaps are one-sided.
    """
    check_gaps_can_open(chain)
    if not needs_differences(chain):
        return gradient(chain, name, to="gaps", until=until, progress=progress)
    found = gradient(chain, name, to="velocities", until=until, progress=progress)
    unknown = np.full(chain.beads - 1, math.nan)
    unknown.setflags(write=False)
    return replace(
        found, gradient={"gaps": unknown}, parameters={"gaps": chain.gaps}, kinks=(),
        units={"gaps": per_unit(found.unit, unit_of_parameter(chain, "gaps"))}, method="none",
        _accuracy=Differences(math.nan, {}, {}, ()),
    )  # fmt: skip


def changes_by_gaps(
    chain: Chain,
    measure: Measure,
    until: float | None = None,
    progress: Progress | None = None,
) -> tuple[Array]:
    """Simulated relative changes of a quantity if one gap grows by `GAP_STEP`."""
    step = GAP_STEP[chain.units][0] * np.eye(chain.beads - 1)
    chains = [chain, *(chain.replace(gaps=chain.gaps + row) for row in step)]
    found = measured(chains, [measure], until=until, rtol=RTOL, progress=progress).values[:, 0]
    return (found[1:] / found[0] - 1.0,)


def derivatives_mislead(found: Gradient, by: str, larger: Array, smaller: Array) -> bool:
    """Whether derivatives predict other changes by 1%, as at a kink, where two maxima are equal."""
    return by in found.kinks or mislead(PART * found.relative(by), larger, smaller)


def _changes_of_objective(problem: Design, chain: Chain, factors: tuple[float, float]) -> Array:
    """Changes of the logarithm of the objective, shape (2, N), if one radius has each factor."""
    if "masses" in chain.given:
        raise InputError("the sensitivity to radii needs masses that follow from the radii")
    objective = problem.objective

    def scores(chains: list[Chain]) -> Array:
        found = measured(chains, objective.measures, rtol=RTOL, until=problem.until)
        return np.abs(objective.score(found.values))

    return _changes_of_logarithm(scores, chain, "radii", factors)


def _changes_of_logarithm(
    values: Callable[[list[Chain]], Array], chain: Chain, field: str, factors: tuple[float, float]
) -> Array:
    """Changes of the logarithm of a value, shape (2, N), if one entry of a field has each factor.

    They are 0 for zeros.
    """
    own = getattr(chain, field)
    places = np.flatnonzero(own)
    chains = [chain]
    for factor in factors:
        chains += [changed(chain, field, int(k), factor) for k in places]
    logarithms = np.log(values(chains))
    found = np.zeros((2, len(own)))
    found[:, places] = (logarithms[1:] - logarithms[0]).reshape(2, -1)
    return found

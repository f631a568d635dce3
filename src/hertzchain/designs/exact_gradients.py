"""Derivatives of the measures of a design by exact gradients of the simulation."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..chain.hertz_ratios import springs_of
from ..chain.laws.dashpot import Dashpot
from ..chain.laws.velocity_power import VelocityPower
from ..collision import Array
from ..derivatives.equation import has_gradient
from ..derivatives.gradient import gradients, quantity_values
from ..derivatives.names import OF_BODY
from ..derivatives.result import Gradient
from ..errors import IncompleteWarning, InputError, ModelRangeWarning, SimulationError
from ..recorded_warnings import ignore_warnings
from ..simulation.simulate import simulate
from ..threads import Threads
from .bounds import impact_varies
from .default_limits import OVERLAP
from .measures import IMPULSE, LARGEST, LARGEST_IN_SENSOR, PULSE, SENSORS, SHARES, Measure
from .overlap_slopes import overlap_ratio_and_slopes
from .problem import Design
from .size_space import SizeSpace

# Tolerances of elastic and damped runs.  Derivatives have errors of up to 2e-5, and 1e-4 in the
# worst of 60 damped chains (`Dashpot`: 7e-4), of the largest one, similar to those of differences.
RTOL, DAMPED_RTOL = 1e-9, 1e-10
# That of samples of a scatter, whose derivatives are averaged.
SAMPLE_RTOL: Final = 1e-7
# Cost of a gradient in simulations: `benchmarks/gradients.py` measures 1.3 to 2.4 times a plain run
# of the same tolerance for forces on a wall behind 20 to 300 beads.  For quantities of the leading
# pulse, whose window moves along the chain, it measures 0.1.  Trials of an evolution strategy, in
# batches and at a larger tolerance, are faster: a gradient of 20 beads takes the time of about 20.
COST: Final = 2
NAMES: Final = {
    "wall_force.peak": "wall_force.peak",
    IMPULSE: IMPULSE,
    "wall_force.duration": "wall_force.duration",
    **{name: name for name in OF_BODY},
}
PEAK: Final = Measure("wall_force.peak")
# Several gradients, one for each maximum of the force on the wall.
MAXIMA: Final = "wall_force.maxima"
NOT_COVERED: Final = (InputError, SimulationError)


def name_of(measure: Measure, beads: int) -> str | None:
    """Name of a measure for `hertzchain.gradient`; `None` if it has no exact gradient."""
    if measure.over is not None:
        return None
    if measure.key in (*PULSE, *SHARES):
        return f"pulse.{SHARES.get(measure.key, measure.key)}@{measure.index(beads) + 1}"
    if measure.key in LARGEST:
        return f"bead.{measure.key}@{measure.index(beads) + 1}"
    if measure.key in SENSORS:
        return f"{measure.key}@{measure.index(beads) + 1}"
    return NAMES.get(measure.key)


def covered(problem: Design) -> bool:
    """Whether all measures that need a simulation have exact gradients."""
    if problem.model != "simulation" or not isinstance(problem.space, SizeSpace):
        return False
    chain = problem.chain
    if chain.gravity or chain.precompression or not has_gradient(chain):
        return False
    # Their forces can be largest at a jump, where they have no derivative.
    jumps = any(isinstance(law, Dashpot | VelocityPower) for law in chain.contact_losses)
    if jumps and any(m.has_kinks for m in problem.measures):
        return False
    shares_vary = any(m.key in SHARES for m in problem.measures) and impact_varies(problem)
    needed = [m for m in problem.measures if not m.of_chain]
    limits = overlap_limits_of(problem)
    needed = [m for m in needed if m not in limits]
    known = [name_of(m, chain.beads) is not None for m in needed]
    return bool(needed) and all(known) and not shares_vary


def overlap_limits_of(problem: Design) -> dict[Measure, float]:
    """The limit of the overlap / radius of an elastic chain, if this is not an objective."""
    if not problem.chain.lossless or springs_of(problem.chain)[:-1].any():
        return {}
    return {each.measure: each.limit for each in problem.requirements
            if each.measure.key == OVERLAP and each.sign > 0
            and each.measure not in problem.reported}  # fmt: skip


def value_in_whole_run(measure: Measure, chain: Chain, until: float | None, rtol: float) -> float:
    """Value of a measure of the whole run; NaN if it is incomplete or the run fails."""
    name = str(name_of(measure, chain.beads))
    try:
        ((value, status),) = quantity_values(chain, [name], until=until, rtol=rtol)
    except NOT_COVERED:
        return float("nan")
    return value if status == "complete" else float("nan")


def _slopes_by_field(
    problem: Design, chain: Chain, elastic_rtol: float
) -> tuple[Array, dict[str, Array]]:
    """Values, and derivatives with respect to each field; NaN for measures that do not exist.

    The rows are those of the measures and, if the force on the wall is one of them, of all maxima
    of that force.
    """
    assert isinstance(problem.space, SizeSpace)
    fields, measures = problem.space.fields, problem.measures
    limits = overlap_limits_of(problem)
    names = {i: name_of(m, chain.beads) for i, m in enumerate(measures)
             if not m.of_chain and m not in limits}  # fmt: skip
    asked = [str(name) for name in names.values()]
    if PEAK in measures:
        asked.append(MAXIMA)
    rtol = elastic_rtol if chain.lossless else DAMPED_RTOL
    found = _gradients(chain, asked, fields, rtol, problem.until)
    maxima = found[len(names) :]
    count = len(measures) + len(maxima)
    values = np.full(count, np.nan)
    slopes = {field: np.zeros((count, len(getattr(chain, field)))) for field in fields}
    rows = [*names, *range(len(measures), count)]
    for row, each in zip(rows, found, strict=True):
        unit = 1.0
        if row < len(measures):
            unit = float(np.max(measures[row]._units_of_share([chain])))
        # A given end of the run determines the largest force on a body, as in `simulate_many`.
        of_body = each.quantity in OF_BODY and math.isfinite(each.value)
        complete = each.status == "complete" or of_body
        values[row] = each.value / unit if complete else np.nan
        for field in fields:
            slopes[field][row] = each[field] / unit
    for row, measure in enumerate(measures):
        if measure in limits:
            values[row], by_field = overlap_ratio_and_slopes(
                chain, fields, limits[measure], rtol, problem.until
            )
            for field in fields:
                slopes[field][row] = by_field[field]
        if measure.of_chain:
            values[row] = measure.from_chain(chain, np.nan)
            for field in fields:
                slopes[field][row] = measure.slope_of_chain(chain, field)
    return values, slopes


def _gradients(
    chain: Chain, names: list[str], fields: tuple[str, ...], rtol: float, until: float | None
) -> list[Gradient]:
    """Gradients by name, then those of all maxima.

    Largest forces in sensors and on bodies are those of whole runs.
    """
    whole = [name for name in names if name.startswith((LARGEST_IN_SENSOR, "body_force"))]
    if until is not None or not whole:
        return gradients(chain, names, to=fields, rtol=rtol, until=until)
    others = [name for name in names if name not in whole]
    found = gradients(chain, others, to=fields, rtol=rtol) if others else []
    end = simulate(chain, times=0, rtol=RTOL).end_time
    of_run = gradients(chain, whole, to=fields, rtol=rtol, until=end)
    plain = [name for name in others if name != MAXIMA]
    by_name = dict(zip(plain, found, strict=False)) | dict(zip(whole, of_run, strict=True))
    return [by_name[name] for name in names if name != MAXIMA] + found[len(plain) :]


def values_and_slopes(problem: Design, point: Array) -> tuple[Array, Array, Array]:
    """Values and derivatives with respect to the variables, and linear models of the objective.

    The models are rows of 0, a value and derivatives of all maxima of the force on the wall, if the
    objective is its peak.
    """
    space, count = problem.space, len(problem.measures)
    assert isinstance(space, SizeSpace)
    chain = space.chain_of(point)
    with ignore_warnings(IncompleteWarning, ModelRangeWarning):
        values, slopes = _slopes_by_field(problem, chain, RTOL)
    pulled = space.pull(point, slopes)
    models = np.column_stack([np.zeros(len(values)), values, pulled])[count:]
    return values[:count], pulled[:count], models if _has_maxima(problem) else models[:0]


def _has_maxima(problem: Design) -> bool:
    """Whether the objective is the largest of several maxima."""
    return problem.objective.single == PEAK and problem.objective.weights[0] > 0.0


def scattered_slopes(
    problem: Design, point: Array, draws: Array, sampled: Array, signs: Array,
    threads: int | None = None,
) -> tuple[Array, Array, int]:  # fmt: skip
    """Derivatives of the means or CVaR of all measures, linear models, and number of gradients.

    ``sampled`` has the values of all samples; only those that count need a gradient.  If the
    objective is a CVaR of one measure, the models are rows of the number of a sample, its value,
    and derivatives: of all maxima of its force on the wall, if this is minimised; of a sample
    without gradient they are 0.
    """
    space, scatter = problem.space, problem.scatter
    assert isinstance(space, SizeSpace)
    chain = space.chain_of(point)
    chains = scatter._chains(chain, draws)
    counted = [scatter._worst(column, sign) for column, sign in zip(sampled.T, signs, strict=True)]
    wanted = sorted({int(i) for group in counted for i in group})

    def slopes_of(i: int) -> tuple[Array, Array]:
        values, slopes = _slopes_by_field(problem, chains[i], SAMPLE_RTOL)
        if "radii" in slopes:
            # A relative deviation multiplies the radius, a grade adds to it.
            factor = chains[i].radii / chain.radii if scatter.grade is None else 1.0
            slopes["radii"] = slopes["radii"] * factor
        return values, space.pull(point, slopes)

    with ignore_warnings(IncompleteWarning, ModelRangeWarning), Threads(threads) as executor:
        by_sample = dict(zip(wanted, executor.map(slopes_of, wanted), strict=True))
    rows = [
        np.mean([by_sample[int(i)][1][row] for i in group], axis=0)
        for row, group in enumerate(counted)
    ]
    return np.array(rows), _models(problem, sampled, by_sample), len(wanted)


def _models(problem: Design, sampled: Array, by_sample: Mapping[int, tuple[Array, Array]]) -> Array:
    """Rows of sample, value and derivatives of the measure that is the objective."""
    measure, scatter = problem.objective.single, problem.scatter
    assert isinstance(problem.space, SizeSpace)
    if measure is None or not scatter.tail or measure.of_chain:
        return np.zeros((0, 2 + problem.space.size))
    column, found = problem.measures.index(measure), []
    for i, value in enumerate(sampled[:, column]):
        if i not in by_sample:
            found.append([i, value, *np.zeros(problem.space.size)])
            continue
        values, slopes = by_sample[i]
        rows = range(len(problem.measures), len(values)) if _has_maxima(problem) else [column]
        found += [[i, values[row], *slopes[row]] for row in rows]
    return np.array(found)

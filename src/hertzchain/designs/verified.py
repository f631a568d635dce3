"""Verification of a design: simulated again with a tight tolerance and beyond the last contact."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Final, NamedTuple

import numpy as np

from ..chain.chain import Chain
from ..chain.hertz_range import HertzRange, hertz_range
from ..chain.hertz_ratios import NO_PREDICTION, OUTSIDE_LAW
from ..chain.materials import FULLY_PLASTIC
from ..chain.stiff_walls import stiff_wall_notes
from ..collision import Array
from ..pulse.quantity_names import COLUMNS
from ..recorded_warnings import ignore_warnings
from ..representation import listed
from ..representation import measure as shown
from ..simulation.hits import leaves_dents, peak_of_second_hit
from ..simulation.not_yielded import NOT_YIELDED
from ..simulation.run_table import RunTable
from ..simulation.simulate import simulate
from ..simulation.simulate_many import tabulate_runs
from ..simulation.wall_force import sensitive_in_words
from ..simulation.yielding import (
    contacts_without_strength,
    dented_chain,
    dents_in_words,
    largest_overlap_ratio,
    yields,
)
from ..validation.objects import Progress
from .exact_gradients import value_in_whole_run
from .measured import measured
from .measures import (
    BODY,
    FIRST_MAXIMUM,
    LARGEST_IN_SENSOR,
    LARGEST_ON_WALL,
    OF_CHAIN,
    Measure,
    in_words,
    sensors_of,
)
from .new_samples import sampled_values, summary_of_samples
from .problem import Design
from .requirements import TOLERANCE, violation
from .yielding import NOT_YIELDING, change_with_yield

RTOL: Final = 1e-11
# The run is repeated for this multiple of its duration, to find a later and higher peak, or to
# complete a peak.
LONGER: Final = 2.0
# Relative difference from which a later peak is higher.
SAME: Final = 1e-6
# Measures at the first maximum of a velocity; saved times; relative difference that is reported.
PER_VELOCITY: Final = ("velocity", "momentum", "energy", "energy_share", "momentum_share")
TIMES, LATER, MAX_CHECKED = 2000, 0.01, 10
NOT_A_PEAK: Final = (
    f"{LARGEST_ON_WALL} is the largest force on the wall up to the end of the run; it is not a "
    "complete peak, so a larger force may follow"
)
LATER_ON_BODY: Final = (
    "the run ends before the force on the last body is complete, so a larger force may follow; "
    "give a later until, or none"
)
WITH_YIELD: Final = "with contacts that yield"
AT_FULLY_PLASTIC: Final = f"at {FULLY_PLASTIC:g} Y"


class FullyPlastic(NamedTuple):
    """Values of measures at the largest possible yield pressure.

    ``overlap_ratio`` is the largest overlap / radius; beyond 0.1, values are outside the range of
    the law.  ``second_peak`` is that of `Verified`.
    """

    values: dict[str, float]
    overlap_ratio: float
    second_peak: float = math.nan

    @property
    def outside_range(self) -> bool:
        """Whether the values are outside the range of the law."""
        return self.overlap_ratio > NO_PREDICTION


@dataclass(frozen=True, eq=False)
class Verified:
    """Numbers of a design from a new simulation.

    Attributes
    ----------
    chain : Chain
        The chain.
    values : dict
        Values of all measures, by name.
    rtol : float
        Relative tolerance of the simulation.
    notes : tuple of str
        Limits of Hertz's law that are exceeded, and incomplete or later peaks.
    scattered : dict
        With a scatter, the summary of 400 new samples, by measure.  Those of runners-up are
        simulated only if samples of better chains violate a limit; otherwise it is empty.
    hertz_range : HertzRange or None
        Limits of Hertz's law in the whole run, of a chain with materials.
    yielding : dict
        Values of the measures with `ElasticPlastic` contacts, if elastic contacts exceed the
        pressure at first yield and the yield strengths of the materials are known.
    yielding_overlap_ratio : float
        Largest overlap / radius of the run with these contacts; NaN without one.  Beyond 0.1,
        ``yielding`` is outside the range of the law.
    dents : str
        Contacts that yield in this run, or in that of a chain whose law leaves dents, and the
        deepest dent, in words.
    second_peak : float
        Peak on the right wall, or on a cap without a wall, if a chain is struck again with its
        dents (`State.struck_again`); that of the first hit without dents, and NaN if no law leaves
        dents.
    fully_plastic : FullyPlastic or None
        The same numbers, `values`, `overlap_ratio` and `second_peak`, at the largest possible
        yield pressure (2.8 times the yield strength), of the design and the chains to compare
        with, if contacts yield at an assumed pressure (1.6 times).
    stiff_walls : tuple of str
        Walls of a given stiffness that are too stiff to replace the Hertz contact of a ball; they
        are also in the notes (`hertzchain.Run.notes`).
    """

    chain: Chain
    values: dict[str, float]
    rtol: float
    notes: tuple[str, ...]
    scattered: dict[str, float]
    hertz_range: HertzRange | None = None
    yielding: dict[str, float] = field(default_factory=dict)
    yielding_overlap_ratio: float = math.nan
    dents: str = ""
    second_peak: float = math.nan
    fully_plastic: FullyPlastic | None = None
    stiff_walls: tuple[str, ...] = ()

    @property
    def outside_range(self) -> bool:
        """Whether a contact left the range of Hertz's law at any time of the run."""
        return self.hertz_range is not None and bool(self.hertz_range.violations)

    @property
    def not_a_prediction(self) -> bool:
        """Whether an overlap is beyond 0.1 of the effective radius, also if contacts yield."""
        elastic = 0.0 if self.hertz_range is None else self.hertz_range.overlap_ratio
        largest = float(np.nan_to_num(elastic).max())
        return largest > NO_PREDICTION or self.yielding_outside_range

    @property
    def yielding_outside_range(self) -> bool:
        """Whether a run with contacts that yield is outside the range of their law."""
        return self.yielding_overlap_ratio > NO_PREDICTION

    @property
    def yields(self) -> bool:
        """Whether elastic contacts of this chain would yield, as a run of such contacts shows."""
        return not math.isnan(self.yielding_overlap_ratio)

    @property
    def _dented(self) -> bool:
        """Whether the run has left dents, with which a second hit is known."""
        left = bool(self.dents) and not self.dents.startswith(NOT_YIELDED)
        return left and not math.isnan(self.second_peak)

    @property
    def yielding_words(self) -> str:
        """``with contacts that yield``, and whether this is outside the range of their law."""
        return f"{WITH_YIELD}, {OUTSIDE_LAW}" if self.yielding_outside_range else WITH_YIELD


class _Yield(NamedTuple):
    """Attributes of `Verified` on yield; the default ones are those of elastic contacts."""

    values: dict[str, float]
    overlap_ratio: float = math.nan
    dents: str = ""
    second_peak: float = math.nan


_ELASTIC: Final = _Yield({})


def verify_chain(
    problem: Design, chain: Chain, price: float, seed: int | None,
    progress: Progress | None = None,
) -> Verified:  # fmt: skip
    """Simulate a chain again; with a scatter and a seed, also new samples."""
    measures, notes = problem.measures, list[str]()
    names = sorted({name for each in measures for name in each.columns})
    names += ["end_time", "largest_overlap"]
    walled = chain.right_wall is not None
    names += ["wall_largest_so_far", "wall_peak_force"] if walled else []
    keep = list(dict.fromkeys(names))
    sensors = sensors_of(measures, [chain])
    table = tabulate_runs(
        [chain], keep=keep, sensors=sensors, rtol=RTOL, until=problem.until, progress=progress
    )
    notes += table.reasons.values()
    values = {
        str(m): m.from_chain(chain, price) if m.of_chain else _value(problem, chain, m, table)
        for m in measures
    }
    if not table.reasons and walled and problem.until is None:
        end, peak = float(table["end_time"][0]), float(table["wall_peak_force"][0])
        notes += _later_peak(chain, peak, end, progress)
    if any(m.key.startswith("wall_force") for m in measures):
        if table.sensitive[0]:
            notes.append(sensitive_in_words("hc.simulate(result.chain)", " on the wall"))
        if any(m.key == LARGEST_ON_WALL for m in measures) and np.isnan(
            table["wall_peak_force"][0]
        ):
            notes.append(NOT_A_PEAK)
    if any(m.key in BODY for m in measures) and not table.reasons and not table.complete[0]:
        notes.append(LATER_ON_BODY)
    notes += _later_motion(problem, chain, values)
    notes += _later_force(problem, chain, values, float(table["end_time"][0]))
    limits, stiff = None, tuple[str, ...]()
    if chain.materials is not None and chain.units == "SI" and not table.reasons:
        overlaps = table._overlaps[0, : chain.beads + 1]
        change = change_with_yield(problem)
        limits = replace(hertz_range(chain, overlaps), _change=change and f"{change} and ")
        stiff = stiff_wall_notes(chain, overlaps)
        remarks = [limits._remark] if limits._remark else []
        notes += [*limits.violations, *_missing_limits(problem, limits), *remarks,
                  *contacts_without_strength(chain, overlaps), *stiff]  # fmt: skip
    yielding = _with_yielding_contacts(problem, chain, values) if yields(limits) else _ELASTIC
    if leaves_dents(chain) and not table.reasons:
        dents = dents_in_words(chain, table._overlaps[0, : chain.beads + 1])
        again = peak_of_second_hit(chain, problem.until)
        yielding = _ELASTIC._replace(dents=dents, second_peak=again)
    scattered = dict[str, float]()
    if problem.scatter is not None and seed is not None:
        sampled = sampled_values(problem, chain, seed, progress=progress)
        scattered = summary_of_samples(problem, sampled)
    return Verified(chain, values, RTOL, tuple(notes), scattered, limits, *yielding,
                    stiff_walls=stiff)  # fmt: skip


def _missing_limits(problem: Design, found: HertzRange) -> list[str]:
    """A note on constraints that the problem does not have, and that exclude such chains."""
    limited = {each.measure.key for each in problem.requirements}
    at = found._most_squeezed
    ratios = {
        "yield_ratio": (found.largest_yield_ratio, 1.0),
        "overlap_ratio": (found.overlap_ratio[at], found.overlap_limit[at]),
    }
    missing = [f"{key} <= {limit:g}" for key, (ratio, limit) in ratios.items()
               if ratio > limit and key not in limited]  # fmt: skip
    if not missing:
        return []
    several = len(missing) > 1
    return [f"the constraint{'s' * several} {listed(missing)} exclude{'s' * (not several)} such "
            "chains"]  # fmt: skip


def _value(problem: Design, chain: Chain, measure: Measure, table: RunTable) -> float:
    if measure.of_whole_run:
        return value_in_whole_run(measure, chain, problem.until, RTOL)
    value = float(measure.from_table(table)[0])
    if np.isnan(value) and problem.until is None and not table.reasons:
        # A peak that is not complete at the end of the longest run may be proven later.
        until = LONGER * float(table["end_time"][0])
        return float(measured([chain], [measure], until=until, rtol=RTOL).values[0, 0])
    return value


class _RunWithYield(NamedTuple):
    """Known values of the measures, and overlaps, of a run with a law of yield."""

    values: dict[str, float]
    overlap_ratio: float
    overlaps: Array


def _with_yielding_contacts(problem: Design, chain: Chain, values: dict[str, float]) -> _Yield:
    """Values with `ElasticPlastic` contacts, overlap and dents; none if they do not apply."""
    if any(m.key in NOT_YIELDING or m.of_whole_run for m in problem.objective.measures):
        return _ELASTIC
    dented = dented_chain(chain)
    found = None if dented is None else run_with_yield(problem, dented, values)
    if dented is None or found is None:
        return _ELASTIC
    return _Yield(found.values, found.overlap_ratio, dents_in_words(dented, found.overlaps))


def run_with_yield(
    problem: Design, dented: Chain, values: dict[str, float]
) -> _RunWithYield | None:
    """Values of a chain with a law of yield; those of the chain itself are in ``values``."""
    measures = tuple(m for m in problem.measures if m.columns and m.key not in NOT_YIELDING)
    names = sorted({name for each in measures for name in each.columns})
    if not names:
        return None
    sensors = sensors_of(measures, [dented])
    table = tabulate_runs([dented], keep=[*names, "end_time"], sensors=sensors, until=problem.until)
    if table.reasons:
        return None
    if problem.until is None and any(np.isnan(m.from_table(table)[0]) for m in measures):
        until = LONGER * float(table["end_time"][0])
        table = tabulate_runs([dented], keep=names, sensors=sensors, until=until)
    of_chain = {name: value for name, value in values.items() if name in OF_CHAIN}
    found = {str(m): float(m.from_table(table)[0]) for m in measures}
    # Incomplete peaks have no value.
    known = of_chain | {name: value for name, value in found.items() if np.isfinite(value)}
    overlaps = table._overlaps[0, : dented.beads + 1]
    return _RunWithYield(known, largest_overlap_ratio(dented, overlaps), overlaps)


def _later_motion(problem: Design, chain: Chain, values: dict[str, float]) -> list[str]:
    """Notes on beads with a larger maximum of their velocity after the first one."""
    beads = {
        m.index(chain.beads): values[str(m)] for m in problem.measures
        if m.key in PER_VELOCITY and m.over is None and np.isfinite(values[str(m)])
    }  # fmt: skip
    if not beads or len(beads) > MAX_CHECKED:
        return []
    run = simulate(chain, times=TIMES, until=problem.until)
    first = run.pulse().velocity
    found = []
    for place in beads:
        largest, peak = float(run.velocities[:, place].max()), float(first[place])
        if largest > (1.0 + LATER) * peak:
            later, earlier = (_speed(chain, each) for each in (largest, peak))
            found.append(
                f"bead {place + 1} moves faster later: its velocity has a first maximum of "
                f"{earlier}, to which velocity, momentum and energy refer, and reaches {later} in "
                f"the run, {largest / peak:.3g} times as much"
            )
    return found


def _later_force(
    problem: Design, chain: Chain, values: dict[str, float], end: float
) -> list[str]:  # fmt: skip
    """Notes on sensors whose force is larger after its first maximum, or after the run."""
    sensors = [m for m in problem.measures if m.key in (FIRST_MAXIMUM, LARGEST_IN_SENSOR)
               and np.isfinite(values[str(m)])]  # fmt: skip
    if not sensors or len(sensors) > MAX_CHECKED:
        return []
    run = simulate(chain, times=TIMES, until=problem.until)
    found = []
    for measure in sensors:
        value, bead = values[str(measure)], measure.index(chain.beads) + 1
        if measure.key == FIRST_MAXIMUM:
            largest = run.sensor_force(bead).largest_so_far
            what, when = f"{measure} is the first maximum of the force", "in the run"
            advice = f" ({LARGEST_IN_SENSOR}@{bead})"
        elif problem.until is None:
            largest = _largest_in_longer_run(chain, bead, end)
            what, when = f"{measure} is the largest force in the run", "in a run twice as long"
            advice = "; give until"
        else:
            continue
        if largest > (1.0 + LATER) * value:
            now, later = (in_words(each, measure.unit, chain.units) for each in (value, largest))
            found.append(f"{what}, {now}; the force reaches {later} {when}, "
                         f"{largest / value:.3g} times as much{advice}")  # fmt: skip
    return found


def _largest_in_longer_run(chain: Chain, bead: int, end: float) -> float:
    column = COLUMNS[LARGEST_IN_SENSOR]
    longer = tabulate_runs([chain], keep=[column], sensors=[bead], until=LONGER * end, rtol=RTOL)
    return float(longer[column][0, 0])


def _speed(chain: Chain, value: float) -> str:
    """A velocity with its unit."""
    return shown(value, "m/s" if chain.units == "SI" else "", chain.units)


def _later_peak(
    chain: Chain, peak: float, end: float, progress: Progress | None
) -> list[str]:  # fmt: skip
    """A note if the force on the wall is larger after the end of the run."""
    longer = tabulate_runs(
        [chain], keep=["wall_largest_so_far"], until=LONGER * end, rtol=RTOL, progress=progress
    )
    later = float(longer["wall_largest_so_far"][0]) if not longer.reasons else np.nan
    if np.isfinite(peak) and not later > (1.0 + SAME) * peak:
        return []
    force = in_words(later, "N", chain.units)
    return [f"the largest force on the wall is {force} in a run of twice the duration"]


def met(problem: Design, values: dict[str, float]) -> bool:
    """Whether verified values meet all constraints, apart from rounding."""
    row: Array = np.array([[values[str(each.measure)] for each in problem.requirements]])
    return not problem.requirements or bool(violation(problem.requirements, row)[0] == 0.0)


def excess_with_scatter(problem: Design, found: Verified) -> dict[str, float]:
    """Limits that the statistic of a scatter violates in new samples, with the relative amounts.

    They are those of measures that need a simulation, since new samples have no others.  The amount
    is infinite if a sample has no value, or there are no samples.
    """
    if problem.scatter is None:
        return {}
    statistic, exceeded = problem.scatter.statistic, dict[str, float]()
    for each in problem.requirements:
        if each.measure.of_chain:
            continue
        value = found.scattered.get(f"{statistic} of {each.measure}", np.nan)
        amount = np.inf if np.isnan(value) else float(each.excess(value))
        if amount > TOLERANCE:
            exceeded[f"{statistic} of {each}"] = amount
    return exceeded


def violated(problem: Design, values: dict[str, float]) -> list[str]:
    """Names of the measures whose constraints verified values violate."""
    names = (str(each.measure) for each in problem.requirements
             if each.excess(values[str(each.measure)]) > TOLERANCE)  # fmt: skip
    return list(dict.fromkeys(names))


def quietly(
    problem: Design, chain: Chain, price: float, seed: int | None,
    progress: Progress | None = None,
) -> Verified:  # fmt: skip
    """Verification without warnings, which are notes of the result."""
    with ignore_warnings():
        return verify_chain(problem, chain, price, seed, progress)

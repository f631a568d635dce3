"""Compute one batch of a sweep: a specification and a number in, arrays out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import __version__
from ..chain.chain import Chain
from ..chain.hertz_range import ALL_YIELD, UNKNOWN_YIELD
from ..chain.hertz_ratios import yield_reasons
from ..chain.stiff_walls import stiff_wall_reasons
from ..collision import HERTZ_EXPONENT, Array
from ..errors import IncompleteWarning, InputError, ModelRangeWarning, SimulationError, warn_user
from ..propagation.propagate import propagate_many
from ..pulse.notes import notes_in_words
from ..pulse.pulse import Pulse
from ..pulse.quantities import BODY_QUANTITIES, QUANTITIES, SENSOR_QUANTITIES, WALL_QUANTITIES
from ..recorded_warnings import ignore_warnings, record_warnings
from ..simulation.ends_of_runs import NO_DURATION, ON_WALL, body_of_run
from ..simulation.ensemble_columns import largest_yield_ratio
from ..simulation.ensemble_input import is_covered
from ..simulation.run import Run
from ..simulation.sensor_force import MANY_TIMES
from ..simulation.simulate import DEFAULT_RTOL, simulate
from ..simulation.simulate_many import tabulate_runs
from ..store.sweep_store import DONE, FAILED
from .kept import PER_PLACE, PER_RUN
from .methods import OPTIONS_OF, pulse_by
from .placed import placed
from .plan import Index, Plan, plan_of

# Quantities of walls and sensors that `simulate_many` gives and that do not depend on the lengths
# of the steps in which a run ends, as the integral over a whole run does.
SIMULATED_TOGETHER = {
    "wall_peak_force", "wall_peak_time", "wall_largest_so_far", "wall_first_contact_impulse",
    *(name for name in SENSOR_QUANTITIES if name != "sensor_impulse"),
}  # fmt: skip
# Quantities that are known when the impact has ended, which may be later than the peak is complete.
IMPULSES = {"wall_impulse_of_impact", "wall_duration"}

Stop = Callable[[], bool]


class Stopped(Exception):
    """Raised in a batch that has to stop; its results are discarded."""


@dataclass(frozen=True, eq=False)
class Result:
    """Results of a batch.

    Attributes
    ----------
    batch : int
        Number of the batch.
    version : str
        Version of hertzchain that computed it.
    columns : mapping of str to ndarray
        Kept quantities, shape (points, methods, beads) or (points, methods).
    status : ndarray of int, shape (points, methods)
        `DONE` or `FAILED`.
    reason : list of list of str
        Why a method failed at a point, or why values are missing; otherwise empty.
    outside_range : ndarray of int, shape (points, methods)
        1 where the method warned that it is used outside its range.
    incomplete : ndarray of int, shape (points, methods)
        1 where the largest force on the wall is incomplete, or where its impulse is kept and the
        impact has not ended.
    sensitive : ndarray of int, shape (points, methods)
        1 where the largest force on the wall may be sensitive to small changes.
    beads : ndarray of int, shape (points,)
        Number of beads; 0 if the chain cannot be made.
    """

    batch: int
    version: str
    columns: Mapping[str, Array]
    status: np.ndarray[Any, np.dtype[np.int8]]
    reason: list[list[str]]
    outside_range: np.ndarray[Any, np.dtype[np.int8]]
    incomplete: np.ndarray[Any, np.dtype[np.int8]]
    sensitive: np.ndarray[Any, np.dtype[np.int8]]
    beads: np.ndarray[Any, np.dtype[np.int64]]


def run_batch(text: str, batch: int, stop: Stop | None = None) -> Result:
    """Compute one batch of a specification given as JSON text."""
    return run_planned(plan_of(text), batch, stop or (lambda: False))


def run_planned(plan: Plan, batch: int, stop: Stop) -> Result:
    """Compute one batch of a plan, which threads may share."""
    work = _Batch(plan, batch, stop)
    for place, method in enumerate(work.plan.specification.methods):
        if method == "propagate" and not work.varied_options:
            work.propagate_together(place)
        elif method == "simulate" and work.may_simulate_together:
            work.simulate_together(place)
        else:
            work.one_by_one(place, method)
    work.compute_errors()
    return work.result(batch)


class _Batch:
    """The points of a batch and their results so far."""

    def __init__(self, plan: Plan, batch: int, stop: Stop) -> None:
        self.plan, self.stop = plan, stop
        spec = plan.specification
        self.indices: list[Index] = list(plan.indices(batch))
        self.chains: dict[int, Chain] = {}
        shape = (len(self.indices), len(spec.methods))
        self.status = np.full(shape, DONE, np.int8)
        self.outside_range, self.incomplete, self.sensitive = np.zeros((3, *shape), np.int8)
        self.reason = [[""] * shape[1] for _ in self.indices]
        self.beads = np.zeros(shape[0], np.int64)
        self.varied_options = any(axis.path[0] == "method" for axis in spec.axes)
        # Values of all beads, since the largest error is taken over all of them.
        wide = [name for name in dict.fromkeys((*spec.keep, *spec.errors)) if name in PER_PLACE]
        self.whole: dict[str, Array] = {
            name: np.full((*shape, PER_PLACE[name].count(plan.longest)), np.nan) for name in wide
        }
        found = {name: placed(name) for name in spec.keep}
        self.placed = {name: each for name, each in found.items() if each is not None}
        self.single = {
            name: np.full(shape, np.nan) for name in plan.variables
            if name in PER_RUN or name in self.placed or name.startswith("worst_error_of_")
        }  # fmt: skip
        self.relative: dict[str, Array] = {}

    def propagate_together(self, place: int) -> None:
        """Propagate all chains without features in one call of `propagate_many`."""
        subjects: list[Chain | Array] = []
        rows = []
        for row in range(len(self.indices)):
            self._check_stop()
            try:
                subject = self._subject(row)
            except InputError as error:
                self._fail(row, place, error)
                continue
            if subject is None:
                self._one(row, place, "propagate")
                continue
            self.beads[row] = len(subject) if isinstance(subject, np.ndarray) else subject.beads
            subjects.append(subject)
            rows.append(row)
        if not subjects:
            return
        options = self._options("propagate", self.indices[0])
        with ignore_warnings(IncompleteWarning):
            table = propagate_many(subjects, threads=1, progress=self._check_stop, **options)
        for name, values in self._of_pulse.items():
            found = table.column(name)
            if found is not None:
                values[rows, place, : found.shape[1]] = found
        for number, reason in table.reasons.items():
            self._fail(rows[number], place, reason)

    @property
    def may_simulate_together(self) -> bool:
        """Whether `simulate_many` gives all that is kept, as `simulate` does."""
        walls = {name for name in self.single if name in WALL_QUANTITIES}
        kept = walls | {each.column for each in self.placed.values()}
        return not self.varied_options and kept <= SIMULATED_TOGETHER

    def simulate_together(self, place: int) -> None:
        """Simulate all chains that the kernel of `simulate_many` covers in one call."""
        options = self._options("simulate", self.indices[0])
        groups: dict[tuple[int, ...], list[int]] = {}
        for row in range(len(self.indices)):
            self._check_stop()
            try:
                chain = self.chain(row)
                if is_covered(chain, options.get("until")):
                    beads = tuple(
                        next(iter(each.numbers(chain)), 0) for each in self.placed.values()
                    )
                    groups.setdefault(beads, []).append(row)
                    continue
            except InputError as error:
                self._fail(row, place, error)
                continue
            self._one(row, place, "simulate")
        for beads, rows in groups.items():
            self._simulate_group(place, rows, beads, options)

    def _simulate_group(
        self, place: int, rows: list[int], sensors: tuple[int, ...], options: dict[str, Any]
    ) -> None:
        """Simulate chains whose sensors have the same numbers; 0 is that of a missing one."""
        walls = [name for name in self.single if name in WALL_QUANTITIES]
        keep = [name for name in self.whole if not PER_PLACE[name].estimate]
        keep += [name for name in self.single if name in PER_RUN]
        there = {name: (each.column, bead)
                 for (name, each), bead in zip(self.placed.items(), sensors, strict=True)
                 if bead}  # fmt: skip
        columns = dict.fromkeys([*keep, *(column for column, _ in there.values())])
        if not columns:
            for row in rows:
                self._one(row, place, "simulate")
            return
        chains = [self.chain(row) for row in rows]
        table = tabulate_runs(
            chains, keep=list(columns), sensors=sorted({bead for _, bead in there.values()}),
            threads=1, progress=self._check_stop, **{"rtol": DEFAULT_RTOL, **options},
        )  # fmt: skip
        for i, row in enumerate(rows):
            beads = self.beads[row] = chains[i].beads
            found = {name: values[i] for name, values in table.columns.items()}
            needed = [found[name][: PER_PLACE[name].count(beads)] for name in keep
                      if name in self.whole]  # fmt: skip
            found |= {name: found[column][table.sensors.index(bead)]
                      for name, (column, bead) in there.items()}  # fmt: skip
            needed += [found[name] for name in there]
            if i in table.reasons or any(np.isnan(each).any() for each in needed):
                # `simulate` has the reasons why values are absent.
                self._one(row, place, "simulate")
                continue
            for name in (*keep, *there):
                if name in self.whole:
                    self.whole[name][row, place, : len(found[name])] = found[name]
                else:
                    self.single[name][row, place] = found[name]
            missing = self._missing_places(chains[i])
            reasons = [
                *missing, *self._unknown_yield(chains[i], row, place), *table._stiff_walls(i)
            ]  # fmt: skip
            if table.outside_range[i]:
                reasons += yield_reasons(chains[i], table._overlaps[i, : beads + 1])
            self.reason[row][place] = "; ".join(reasons)
            self.outside_range[row, place] = table.outside_range[i]
            ends = bool(walls) or self._bodies(chains[i])
            self.incomplete[row, place] = ends and not table.complete[i]
            self.sensitive[row, place] = table.sensitive[i]

    def _bodies(self, chain: Chain) -> bool:
        """Whether the force on the last body of a free end is kept."""
        kept = any(name in BODY_QUANTITIES for name in self.single)
        return kept and chain.right_wall is None

    def _subject(self, row: int) -> Chain | Array | None:
        """Radii or chain of a point for `propagate_many`; `None` if the chain has features."""
        if self.plan.specification.methods == ("propagate",):
            # No other method needs the chain, so only the radii are computed.
            radii = self.plan.radii(self.indices[row])
            if radii is not None:
                return radii
        chain = self.chain(row)
        if chain.features:
            return None
        # Rows of radii are divided by their first.
        plain = chain.exponents == HERTZ_EXPONENT and chain.radii[0] == 1.0
        return chain.radii if plain else chain

    def one_by_one(self, place: int, method: str) -> None:
        """Apply a method to one chain after the other."""
        for row in range(len(self.indices)):
            self._one(row, place, method)

    def _one(self, row: int, place: int, method: str) -> None:
        self._check_stop()
        try:
            chain = self.chain(row)
            self.beads[row] = chain.beads
            with record_warnings() as warned:
                self._keep(row, place, method, chain)
            for flag, category in (
                (self.outside_range, ModelRangeWarning), (self.incomplete, IncompleteWarning),
            ):  # fmt: skip
                flag[row, place] = any(isinstance(each, category) for each in warned)
        except (InputError, SimulationError) as error:
            self._fail(row, place, error)

    def _keep(self, row: int, place: int, method: str, chain: Chain) -> None:
        options = self._options(method, self.indices[row])
        if method == "simulate":
            times = MANY_TIMES if self.placed else 0
            run = simulate(chain, times=times, progress=self._check_stop, **options)
            self._keep_wall(row, place, run)
            self._keep_body(row, place, run)
            self._keep_largest(row, place, run)
            if self._of_pulse:
                self._keep_pulse(row, place, run.pulse())
                if run.beads_passed < chain.beads - chain.strikers:
                    self.status[row, place] = FAILED
            self._keep_placed(row, place, run)
            notes = [
                self.reason[row][place], *stiff_wall_reasons(chain, run._furthest_overlaps),
                *yield_reasons(chain, run.largest_overlaps),
            ]  # fmt: skip
            self.reason[row][place] = "; ".join(filter(None, notes))
        else:
            self._keep_pulse(row, place, pulse_by(method, chain, **options))

    def _keep_pulse(self, row: int, place: int, pulse: Pulse) -> None:
        for name, values in self._of_pulse.items():
            found = pulse.column(name)
            if found is not None:
                values[row, place, : len(found)] = found
        self.reason[row][place] = "; ".join(notes_in_words(pulse.notes, self.whole))

    def _keep_wall(self, row: int, place: int, run: Run) -> None:
        wanted = [name for name in self.single if name in WALL_QUANTITIES]
        if wanted:
            wall = run.wall_force("right")
            if wall.complete and wall.complete_since is None and IMPULSES.intersection(wanted):
                warn_user(wall.reason, IncompleteWarning)
            self.sensitive[row, place] = wall.sensitive
            for name in wanted:
                value = getattr(wall, WALL_QUANTITIES[name].attribute)
                self.single[name][row, place] = np.nan if value is None else value

    def _keep_body(self, row: int, place: int, run: Run) -> None:
        wanted = [name for name in self.single if name in BODY_QUANTITIES]
        if not wanted:
            return
        if run.chain.right_wall is not None:
            raise InputError(ON_WALL)
        found = body_of_run(run)
        for name in wanted:
            self.single[name][row, place] = found[name]
        if np.isnan(found["body_peak_force"]):
            self.reason[row][place] = "the force on the last body has no maximum in the run"
        elif "body_duration" in wanted and np.isnan(found["body_duration"]):
            self.reason[row][place] = NO_DURATION

    def _keep_placed(self, row: int, place: int, run: Run) -> None:
        """Keep quantities at beads and between contacts, or why there are none."""
        reasons = [
            self.reason[row][place], *self._missing_places(run.chain),
            *self._unknown_yield(run.chain, row, place),
        ]  # fmt: skip
        for name, each in self.placed.items():
            if each.numbers(run.chain):
                self.single[name][row, place], notes = each.evaluate(run)
                reasons += notes
        self.reason[row][place] = "; ".join(dict.fromkeys(filter(None, reasons)))

    def _missing_places(self, chain: Chain) -> list[str]:
        """Why a chain has no values at some beads or contacts."""
        return [f"{each.absent} among {chain.beads}" for each in self.placed.values()
                if not each.numbers(chain)]  # fmt: skip

    def _unknown_yield(self, chain: Chain, row: int, place: int) -> list[str]:
        """Why a point has no ratio of pressure and yield, if it should have one."""
        missing = "yield_ratio" in self.single and np.isnan(self.single["yield_ratio"][row, place])
        if not missing:
            return []
        # Walls and pads that are springs do not yield.
        may_yield = [law.yields for law in chain.contact_losses[1:-1]]
        return [f"yield_ratio: {ALL_YIELD if all(may_yield) else UNKNOWN_YIELD}"]

    def _keep_largest(self, row: int, place: int, run: Run) -> None:
        """Keep the largest values of the whole run."""
        for name, found in (("largest_overlap", run.largest_overlaps), ("dent", run.dents)):
            if name in self.whole:
                self.whole[name][row, place, : len(found) - 2] = found[1:-1]
        if "yield_ratio" in self.single:
            ratio = largest_yield_ratio(run.chain, run.largest_overlaps)
            self.single["yield_ratio"][row, place] = ratio

    @property
    def _of_pulse(self) -> dict[str, Array]:
        """Values of all beads that are properties of the leading pulse."""
        return {name: values for name, values in self.whole.items() if name in QUANTITIES}

    def compute_errors(self) -> None:
        """Compute errors of all methods relative to the reference, and the largest per point."""
        spec = self.plan.specification
        for name in spec.errors:
            values = self.whole[name]
            reference = values[:, [spec.methods.index(spec.reference)]]
            with np.errstate(divide="ignore", invalid="ignore"):
                relative = np.where(values == reference, 0.0, (values - reference) / reference)
            # Bead 1 starts with the velocity of the impact in every method.
            first = 0 if QUANTITIES[name].per == "contact" else 1
            away = np.abs(relative[:, :, first:])
            known = ~np.isnan(away)
            worst = np.where(known, away, 0.0).max(axis=2, initial=0.0)
            self.single[f"worst_error_of_{name}"][:] = np.where(known.any(axis=2), worst, np.nan)
            self.relative[f"relative_error_of_{name}"] = relative

    def result(self, batch: int) -> Result:
        """Select what is kept."""
        plan = self.plan
        columns = {}
        for name in plan.variables:
            if name in self.single:
                columns[name] = self.single[name]
                continue
            whole = self.whole[name] if name in self.whole else self.relative[name]
            columns[name] = self._at(whole, name.removeprefix("relative_error_of_"))
        return Result(
            batch, __version__, columns, self.status, self.reason, self.outside_range,
            self.incomplete, self.sensitive, self.beads,
        )  # fmt: skip

    def _at(self, whole: Array, quantity: str) -> Array:
        """Select the beads that are kept; contact k is kept with bead k."""
        at = self.plan.specification.at
        if at == "every":
            return whole
        if at == "last":
            last = np.maximum(self.beads - 1 - (PER_PLACE[quantity].per == "contact"), 0)
            return np.take_along_axis(whole, last[:, None, None], axis=2)[:, :, 0]
        places = np.array(at) - 1
        inside = places < whole.shape[2]
        kept = whole[:, :, np.minimum(places, whole.shape[2] - 1)]
        return np.where(inside, kept, np.nan)

    def chain(self, row: int) -> Chain:
        """Make the chain of a point, once."""
        if row not in self.chains:
            chain = self.plan.chain(self.indices[row])
            if chain.beads > self.plan.longest:
                raise InputError(f"{chain.beads} beads where {self.plan.longest} were expected")
            if chain.units != self.plan.units:
                raise InputError(
                    f"the chain is in {chain.units} units, and others in {self.plan.units} units"
                )
            self.chains[row] = chain
        return self.chains[row]

    def _options(self, method: str, index: Index) -> dict[str, Any]:
        given = self.plan.document(index)["method"]
        return {name: given[name] for name in OPTIONS_OF.get(method, ()) if name in given}

    def _fail(self, row: int, place: int, error: Exception | str) -> None:
        self.status[row, place] = FAILED
        self.reason[row][place] = str(error)

    def _check_stop(self, *_: int) -> None:
        if self.stop():
            raise Stopped

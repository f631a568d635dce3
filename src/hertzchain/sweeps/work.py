"""One batch of a sweep, wherever it is computed: a specification and a number in, arrays out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hertzchain import __version__
from hertzchain.chain.chain import Chain
from hertzchain.contacts import HERTZ_EXPONENT, Array
from hertzchain.errors import IncompleteWarning, InputError, ModelRangeWarning, SimulationError
from hertzchain.propagation.propagate import propagate_many
from hertzchain.pulse.notes import notes_in_words
from hertzchain.pulse.pulse import Pulse
from hertzchain.pulse.quantities import PER_CONTACT, QUANTITIES
from hertzchain.simulation.run import Run
from hertzchain.simulation.simulate import simulate
from hertzchain.store.sweep_store import DONE, FAILED
from hertzchain.sweeps.methods import OPTIONS, pulse_by
from hertzchain.sweeps.plan import Index, Plan, plan_of
from hertzchain.sweeps.specification import WALL_QUANTITIES
from hertzchain.sweeps.warned import recorded

Stop = Callable[[], bool]


class Stopped(Exception):
    """A batch that was told to stop; nothing of it is kept."""


@dataclass(frozen=True, eq=False)
class Result:
    """All that a batch gave.

    Attributes
    ----------
    batch : int
        Its number.
    version : str
        Version of the package that computed it.
    columns : mapping of str to ndarray
        What is kept, shape (points of the batch, methods, beads) or without the last.
    status : ndarray of int, shape (points, methods)
        `DONE` or `FAILED`.
    reason : list of list of str
        Why a method failed at a point, or values are missing; empty if neither.
    outside_range : ndarray of int, shape (points, methods)
        1 where a method itself said that it is outside its range.
    incomplete : ndarray of int, shape (points, methods)
        1 where the largest force on the wall is not complete.
    beads : ndarray of int, shape (points,)
        Number of beads; 0 if there is no such chain.
    """

    batch: int
    version: str
    columns: Mapping[str, Array]
    status: np.ndarray[Any, np.dtype[np.int8]]
    reason: list[list[str]]
    outside_range: np.ndarray[Any, np.dtype[np.int8]]
    incomplete: np.ndarray[Any, np.dtype[np.int8]]
    beads: np.ndarray[Any, np.dtype[np.int64]]


def run_batch(text: str, batch: int, stop: Stop | None = None) -> Result:
    """Compute one batch.

    Parameters
    ----------
    text : str
        JSON of the specification.
    batch : int
        Number of the batch, from 0.
    stop : callable, optional
        Says whether to give up; looked at all the time.

    Returns
    -------
    Result

    Raises
    ------
    Stopped
        If it was told to.

    Examples
    --------
    >>> from hertzchain.sweeps.reading import read_specification
    >>> axes = {"beads": [20, 40]}
    >>> text = read_specification({"chain": {"taper": "uniform"}, "axes": axes}).as_json()
    >>> run_batch(text, 0).columns["velocity"].shape
    (2, 1, 40)
    """
    return run_planned(plan_of(text), batch, stop or (lambda: False))


def run_planned(plan: Plan, batch: int, stop: Stop) -> Result:
    """Compute one batch of a plan, which threads of one process share.

    Parameters
    ----------
    plan : Plan
        What is swept.
    batch : int
        Number of the batch, from 0.
    stop : callable
        Whether to stop; called many times a second.

    Returns
    -------
    Result

    Raises
    ------
    Stopped
        If it was told to.

    Examples
    --------
    See `run_batch`.
    """
    work = _Batch(plan, batch, stop)
    for place, method in enumerate(work.plan.specification.methods):
        if method == "propagate" and not work.varied_options:
            work.follow_together(place)
        else:
            work.one_by_one(place, method)
    work.measure_errors()
    return work.result(batch)


class _Batch:
    """The points of a batch and what is known of them so far."""

    def __init__(self, plan: Plan, batch: int, stop: Stop) -> None:
        self.plan, self.stop = plan, stop
        spec = plan.specification
        self.indices: list[Index] = list(plan.indices(batch))
        self.chains: dict[int, Chain] = {}
        shape = (len(self.indices), len(spec.methods))
        self.status = np.full(shape, DONE, np.int8)
        self.outside_range, self.incomplete = np.zeros((2, *shape), np.int8)
        self.reason = [[""] * shape[1] for _ in self.indices]
        self.beads = np.zeros(shape[0], np.int64)
        self.varied_options = any(axis.path[0] == "method" for axis in spec.axes)
        # Of every bead, since errors are the worst of all.
        wide = [name for name in dict.fromkeys((*spec.keep, *spec.errors)) if name in QUANTITIES]
        self.whole: dict[str, Array] = {
            name: np.full((*shape, plan.longest - (name in PER_CONTACT)), np.nan) for name in wide
        }
        self.single = {
            name: np.full(shape, np.nan) for name in plan.variables
            if name in WALL_QUANTITIES or name.startswith("worst_error_of_")
        }  # fmt: skip
        self.relative: dict[str, Array] = {}

    def follow_together(self, place: int) -> None:
        """All plain chains of the batch at once, as `propagate_many` does it best."""
        subjects: list[Chain | Array] = []
        rows = []
        for row in range(len(self.indices)):
            self._watch()
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
        table = propagate_many(subjects, threads=1, progress=self._watch, **options)
        for name, values in self.whole.items():
            found = table.column(name)  # type: ignore[arg-type]
            if found is not None:
                values[rows, place, : found.shape[1]] = found
        for number, reason in table.reasons.items():
            self._fail(rows[number], place, reason)

    def _subject(self, row: int) -> Chain | Array | None:
        """What `propagate_many` takes for a point: radii alone where they will do; or nothing."""
        if self.plan.specification.methods == ("propagate",):
            # Nothing else looks at the chain, so that it need not be made.
            radii = self.plan.radii(self.indices[row])
            if radii is not None:
                return radii
        chain = self.chain(row)
        if chain.features:
            return None
        return chain.radii if chain.exponent == HERTZ_EXPONENT else chain

    def one_by_one(self, place: int, method: str) -> None:
        """One chain after the other."""
        for row in range(len(self.indices)):
            self._one(row, place, method)

    def _one(self, row: int, place: int, method: str) -> None:
        self._watch()
        try:
            chain = self.chain(row)
            self.beads[row] = chain.beads
            with recorded() as warned:
                self._keep(row, place, method, chain)
            for flag, category in (
                (self.outside_range, ModelRangeWarning), (self.incomplete, IncompleteWarning),
            ):  # fmt: skip
                flag[row, place] = any(issubclass(each, category) for each in warned)
        except (InputError, SimulationError) as error:
            self._fail(row, place, error)

    def _keep(self, row: int, place: int, method: str, chain: Chain) -> None:
        options = self._options(method, self.indices[row])
        if method == "simulate":
            run = simulate(chain, times=0, progress=self._watch, **options)
            self._keep_wall(row, place, run)
            if self.whole:
                self._keep_pulse(row, place, run.pulse())
                if run.beads_passed < chain.beads:
                    self.status[row, place] = FAILED
        else:
            self._keep_pulse(row, place, pulse_by(method, chain, **options))

    def _keep_pulse(self, row: int, place: int, pulse: Pulse) -> None:
        for name, values in self.whole.items():
            found = pulse.column(name)  # type: ignore[arg-type]
            if found is not None:
                values[row, place, : len(found)] = found
        self.reason[row][place] = "; ".join(notes_in_words(pulse.notes, self.whole))

    def _keep_wall(self, row: int, place: int, run: Run) -> None:
        wanted = [name for name in self.single if name in WALL_QUANTITIES]
        if wanted:
            wall = run.wall_force("right")
            for name in wanted:
                value = getattr(wall, WALL_QUANTITIES[name][0])
                self.single[name][row, place] = np.nan if value is None else value

    def measure_errors(self) -> None:
        """Relative errors of all methods against the reference, and the worst of each point."""
        spec = self.plan.specification
        for name in spec.errors:
            values = self.whole[name]
            reference = values[:, [spec.methods.index(spec.reference)]]
            with np.errstate(divide="ignore", invalid="ignore"):
                relative = np.where(values == reference, 0.0, (values - reference) / reference)
            # Bead 1 is the striker, and knows nothing yet.
            first = 0 if name in PER_CONTACT else 1
            away = np.abs(relative[:, :, first:])
            known = ~np.isnan(away)
            worst = np.where(known, away, 0.0).max(axis=2, initial=0.0)
            self.single[f"worst_error_of_{name}"][:] = np.where(known.any(axis=2), worst, np.nan)
            self.relative[f"relative_error_of_{name}"] = relative

    def result(self, batch: int) -> Result:
        """What is kept of all that."""
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
            self.incomplete, self.beads,
        )  # fmt: skip

    def _at(self, whole: Array, quantity: str) -> Array:
        """Values of the beads that are kept; of a contact, those of the bead before it."""
        at = self.plan.specification.at
        if at == "every":
            return whole
        if at == "last":
            last = np.maximum(self.beads - 1 - (quantity in PER_CONTACT), 0)
            return np.take_along_axis(whole, last[:, None, None], axis=2)[:, :, 0]
        places = np.array(at) - 1
        inside = places < whole.shape[2]
        kept = whole[:, :, np.minimum(places, whole.shape[2] - 1)]
        return np.where(inside, kept, np.nan)

    def chain(self, row: int) -> Chain:
        """The chain of a point, made once."""
        if row not in self.chains:
            chain = self.plan.chain(self.indices[row])
            if chain.beads > self.plan.longest:
                raise InputError(f"{chain.beads} beads where {self.plan.longest} were expected")
            if chain.units != self.plan.units:
                raise InputError(f"the chain is {chain.units}, and others are {self.plan.units}")
            self.chains[row] = chain
        return self.chains[row]

    def _options(self, method: str, index: Index) -> dict[str, Any]:
        given = self.plan.document(index)["method"]
        return {name: given[name] for name in OPTIONS.get(method, ()) if name in given}

    def _fail(self, row: int, place: int, error: Exception | str) -> None:
        self.status[row, place] = FAILED
        self.reason[row][place] = str(error)

    def _watch(self, *_: int) -> None:
        if self.stop():
            raise Stopped

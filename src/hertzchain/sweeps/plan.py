"""The points of a sweep, their chains and batches, and checks before anything is computed."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, Final

import numpy as np

from ..chain.chain import Chain
from ..chain.input_checks import checked_beads
from ..chain.tapers import check_taper, taper_named, tapered_radii
from ..collision import Array
from ..errors import InputError, SimulationError, raise_all
from ..pulse.quantities import BODY_QUANTITIES, QUANTITIES, WALL_QUANTITIES
from ..recorded_warnings import record_warnings
from ..simulation.ends_of_runs import ON_WALL
from ..store.chain_files import BEAD_METHODS, chain_from
from ..validation.numbers import has_unit
from .axes import Axis
from .change_value import document_to_change, path_in_document, with_value
from .kept import absent_places
from .methods import SIMULATIONS, pulse_by
from .specification import (
    TAKEN,
    Specification,
    specification_from_json,
)

Index = tuple[int, ...]

# Largest number of points per batch; fewer if whole trajectories are computed, which takes longer.
MAX_POINTS: Final = 2048
MAX_TRAJECTORIES: Final = 32
# Number of batches below which batches are made smaller, so that all workers are busy, down to
# this number of points.
MIN_BATCHES: Final = 32
MIN_POINTS: Final = 8
# Largest number of bytes of one quantity in a batch, and of all arrays while it is computed.
MAX_BYTES: Final = 16 * 2**20
MAX_BYTES_IN_MEMORY: Final = 2**27
# Numbers per bead in memory while a batch is computed, in addition to the kept ones (measured).
NUMBERS_PER_BEAD: Final = 20
# Number of values of one axis that are tried before anything is computed.
MAX_TRIALS: Final = 200
# Keys of [chain] of a scaled taper without further features: its radii need no `Chain`.
TAPER_KEYS: Final = frozenset({"taper", "rate", "beads"})


@dataclass(frozen=True)
class Trial:
    """Outcome of making the chain of a point: its properties, or why it cannot be made."""

    reason: str = ""
    units: str = "scaled"
    has_wall: bool = False
    has_materials: bool = False


@dataclass(frozen=True, eq=False)
class Plan:
    """Points of a sweep, in the order of a dataset with one dimension per axis, in batches.

    Attributes
    ----------
    specification : Specification
        The specification of the sweep.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.sweeps.plan import Plan
    >>> from hertzchain.sweeps.specification import read_specification
    >>> axes = {"rate": [0.02, 0.04], "beads": [10, 20, 30]}
    >>> chain = {"taper": "forward-exponential"}
    >>> plan = Plan(read_specification({"chain": chain, "axes": axes}))
    >>> plan.dimensions, plan.shape, plan.points, plan.longest
    (('rate', 'beads'), (2, 3), 6, 30)
    >>> plan.chain((1, 2))
    Chain(forward-exponential, q = 0.04, 30 beads)
    """

    specification: Specification

    @property
    def zipped(self) -> bool:
        """Whether all axes vary together along one dimension."""
        return self.specification.combine == "zip"

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Name of each axis in a dataset."""
        short = [axis.name for axis in self.specification.axes]
        reserved = {*TAKEN, *self.variables}
        return tuple(
            "_".join(path_in_document(axis)) if short.count(name) > 1 or name in reserved else name
            for axis, name in zip(self.specification.axes, short, strict=True)
        )

    @property
    def variables(self) -> tuple[str, ...]:
        """Names of the quantities and errors that are kept."""
        spec = self.specification
        errors = [
            f"{kind}_error_of_{name}" for name in spec.errors for kind in ("relative", "worst")
        ]
        return (*spec.keep, *errors)

    @property
    def dimensions(self) -> tuple[str, ...]:
        """Names of the dimensions of the points."""
        return ("point",) if self.zipped else self.names

    @cached_property
    def shape(self) -> Index:
        """Number of values along each dimension."""
        lengths = tuple(len(axis) for axis in self.specification.axes)
        return lengths[:1] if self.zipped else lengths

    @property
    def points(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    def document(self, index: Index) -> dict[str, Any]:
        """Tables ``chain``, ``materials`` and ``method`` of a point."""
        found = document_to_change(self.specification)
        for axis, value in self._values(index):
            found = with_value(found, path_in_document(axis), value)
        return found

    def _values(self, index: Index) -> Iterator[tuple[Axis, Any]]:
        """The axes with their values at a point."""
        axes = self.specification.axes
        for axis, place in zip(axes, index * len(axes) if self.zipped else index, strict=True):
            yield axis, axis.values[place]

    def unknown_places(self, index: Index) -> dict[int, str]:
        """Axes without a place in the document of a point, and why."""
        found, reasons = document_to_change(self.specification), {}
        for i, (axis, value) in enumerate(self._values(index)):
            try:
                found = with_value(found, path_in_document(axis), value)
            except InputError as error:
                reasons[i] = str(error)
        return reasons

    def chain(self, index: Index) -> Chain:
        """Make the chain of a point."""
        document = self.document(index)
        return chain_from({"chain": document["chain"], "materials": document["materials"]})

    def trial(self, index: Index) -> Trial:
        """Try to make the chain of a point; the outcome is kept."""
        if index not in self._trials:
            try:
                chain = self.chain(index)
                walled, kinds = chain.right_wall is not None, chain.materials is not None
                self._trials[index] = Trial("", chain.units, walled, kinds)
            except InputError as error:
                self._trials[index] = Trial(str(error))
        return self._trials[index]

    @cached_property
    def _trials(self) -> dict[Index, Trial]:
        return {}

    def radii(self, index: Index) -> Array | None:
        """Radii of a point without features other than its taper; `None` of any other point."""
        if self._taper is None:
            return None
        places = index * len(self.specification.axes) if self.zipped else index
        taper, rate, count = (values[places[place]] for place, values in self._taper)
        if taper == "uniform":
            return None
        if taper_named(taper).is_uniform({"rate": rate}):
            return None
        beads = checked_beads(count, least=2)
        return tapered_radii(taper, check_taper(taper, rate, beads), beads)

    @cached_property
    def _taper(self) -> list[tuple[int, list[Any]]] | None:
        """Axis and values of taper, rate and beads, if the chains have no other keys."""
        spec = self.specification
        axes = {axis.path[0]: (place, axis.values) for place, axis in enumerate(spec.axes)}
        if spec.chain.keys() | axes.keys() != TAPER_KEYS:
            return None
        # A key that does not vary has the same value for all indices of the first axis.
        fixed = {key: (0, [value] * len(spec.axes[0])) for key, value in spec.chain.items()}
        return [(fixed | axes)[key] for key in ("taper", "rate", "beads")]

    @property
    def ragged(self) -> bool:
        """Whether chains may differ in length although there is no axis for it."""
        return "beads" not in self.names and (self.zipped or bool(self._changing))

    @property
    def may_be_outside_range(self) -> bool:
        """Whether a method may warn that it is used outside its range."""
        scaled = self.units == "scaled"
        return not (scaled and set(self.specification.methods) <= {*SIMULATIONS})

    @property
    def keeps_wall(self) -> bool:
        """Whether quantities of the wall are kept, which may be incomplete."""
        return any(name in WALL_QUANTITIES for name in self.specification.keep)

    @cached_property
    def _changing(self) -> list[int]:
        """Axes along which the number of beads changes."""
        axes = enumerate(self.specification.axes)
        return [place for place, axis in axes if self._changes_length(place, axis)]

    @cached_property
    def longest(self) -> int:
        """Number of beads of the longest chain."""
        if self._lengths is not None:
            return max(self._lengths)
        if self.zipped:
            return max(map(self._beads, np.ndindex(self.shape)), default=0)
        ranges = [range(n) if i in self._changing else (0,) for i, n in enumerate(self.shape)]
        return max(map(self._beads, itertools.product(*ranges)), default=0)

    @cached_property
    def _lengths(self) -> list[int] | None:
        """Lengths of all chains, if they are the values of an axis."""
        axes = {axis.path: axis for axis in self.specification.axes}
        keys = {path[0] for path in axes} | self.specification.chain.keys()
        values = axes[("beads",)].values if ("beads",) in axes else []
        whole = bool(values) and all(isinstance(value, int) for value in values)
        return values if whole and keys.isdisjoint(BEAD_METHODS) else None

    def _changes_length(self, place: int, axis: Axis) -> bool:
        first = (0,) * len(self.shape)
        tried = {self._beads((*first[:place], i, *first[place + 1 :])) for i in spread(len(axis))}
        # Where no chain can be made, a value of another axis may give a chain of any length.
        return len(tried) > 1 or 0 in tried

    def _beads(self, index: Index) -> int:
        """Number of beads of a point; 0 if its chain cannot be made."""
        try:
            table = self.document(index)["chain"]
            if isinstance(table.get("beads"), int) and not table.keys() & BEAD_METHODS:
                return int(table["beads"])
            return self.chain(index).beads
        except InputError:
            return 0

    @cached_property
    def block(self) -> Index:
        """Number of points of a batch along each dimension: a chunk of the stored arrays."""
        spec = self.specification
        most = MAX_TRAJECTORIES if "simulate" in spec.methods else MAX_POINTS
        kept = self.longest if spec.at == "every" else 1
        most = min(most, max(1, MAX_BYTES // (8 * max(1, kept) * len(spec.methods))))
        most = min(most, max(1, MAX_BYTES_IN_MEMORY // max(1, self._bytes_per_point)))
        left = spec.batch or min(most, max(MIN_POINTS, math.ceil(self.points / MIN_BATCHES)))
        block = [1] * len(self.shape)
        for place in range(len(self.shape) - 1, -1, -1):
            size = self.shape[place]
            block[place] = math.ceil(size / math.ceil(size / left))
            left //= block[place]
            if block[place] < size or left < 2:
                break
        return tuple(block)

    @property
    def _bytes_per_point(self) -> int:
        """Bytes in memory for each point of a batch while it is computed."""
        spec = self.specification
        quantities = len(dict.fromkeys((*spec.keep, *spec.errors))) + len(spec.errors)
        return 8 * self.longest * (len(spec.methods) * quantities + NUMBERS_PER_BEAD)

    @property
    def bytes_in_memory(self) -> int:
        """Approximate number of bytes in memory while a batch is computed."""
        return math.prod(self.block) * self._bytes_per_point

    @cached_property
    def grid(self) -> Index:
        """Number of batches along each dimension."""
        return tuple(math.ceil(n / b) for n, b in zip(self.shape, self.block, strict=True))

    @property
    def batches(self) -> int:
        """Number of batches."""
        return math.prod(self.grid)

    def region(self, batch: int) -> tuple[slice, ...]:
        """Slices of the points of a batch along each dimension."""
        corner = np.unravel_index(batch, self.grid)
        return tuple(
            slice(int(c) * b, min((int(c) + 1) * b, n))
            for c, b, n in zip(corner, self.block, self.shape, strict=True)
        )

    def indices(self, batch: int) -> Iterator[Index]:
        """Indices of the points of a batch, in order."""
        return itertools.product(*(range(part.start, part.stop) for part in self.region(batch)))

    @cached_property
    def units(self) -> str:
        """Units of the chains: ``"scaled"`` or ``"SI"``."""
        found = (self.trial(index) for index in self.tried())
        return next((each.units for each in found if not each.reason), "scaled")

    def tried(self) -> Iterator[Index]:
        """Yield up to 200 points for trials, including the first and the last."""
        for flat in spread(self.points):
            yield tuple(int(i) for i in np.unravel_index(flat, self.shape))


@lru_cache(maxsize=4)
def plan_of(text: str) -> Plan:
    """Plan of a specification given as JSON text, cached for the next batch."""
    return Plan(specification_from_json(text))


def spread(count: int) -> list[int]:
    """At most `MAX_TRIALS` of the numbers below count, including the first and the last."""
    if count <= MAX_TRIALS:
        return list(range(count))
    return [int(i) for i in np.linspace(0, count - 1, MAX_TRIALS).round()]


def check_plan(plan: Plan, heading: str = "") -> None:
    """Raise `InputError` if a method or a value of an axis cannot give any result."""
    with record_warnings():
        problems = (
            _bad_values(plan) or _bad_units(plan) or _bad_requests(plan) or _never_predicted(plan)
        )
    raise_all(problems, heading)


def _bad_requests(plan: Plan) -> list[str]:
    """Find methods and quantities that the chains do not support."""
    spec, problems = plan.specification, []
    if isinstance(spec.at, tuple) and spec.at[-1] > plan.longest:
        problems.append(f"sweep.at: there is no bead {spec.at[-1]} in {plan.longest} beads")
    trials = [plan.trial(index) for index in plan.tried()]
    if any(name in WALL_QUANTITIES for name in spec.keep) and not any(t.has_wall for t in trials):
        problems.append("sweep.keep: the chains have no right wall: add right_wall to [chain]")
    if any(name in BODY_QUANTITIES for name in spec.keep) and all(t.has_wall for t in trials):
        problems.append(f"sweep.keep: {ON_WALL}")
    problems += absent_places(spec.keep, tried_chains(plan))
    if "yield_ratio" in spec.keep and not any(each.has_materials for each in trials):
        problems.append("sweep.keep: yield_ratio needs chains with materials: add materials to "
                        "[chain]")  # fmt: skip
    for place, method in enumerate(spec.methods, start=1):
        if method != "simulate" and (reason := _method_error(plan, method)):
            problems.append(f"sweep.methods[{place}]: {reason}")
    return problems


def _bad_values(plan: Plan) -> list[str]:
    """Find values of an axis with which no chain can be made at either end of the others."""
    axes = plan.specification.axes
    ends = (0,) * len(plan.shape), tuple(n - 1 for n in plan.shape)
    # A value that has no place would be reported for each axis.
    first, last = map(plan.unknown_places, ends)
    problems = [f"axes.{axes[i].long_name}: {why}" for i, why in first.items() if i in last]
    if problems:
        return problems
    if plan.zipped:
        reasons = [plan.trial(index).reason for index in plan.tried()]
        return [f"axes: {reasons[0]}"] if all(reasons) else []
    always = []
    for place, axis in enumerate(axes):
        bad = {}
        for i in spread(len(axis)):
            places = ((*end[:place], i, *end[place + 1 :]) for end in ends)
            reasons = [plan.trial(index).reason for index in places]
            if all(reasons):
                bad[i] = reasons[0]
        if len(bad) == len(spread(len(axis))) > 1:
            always.append(f"axes.{axis.long_name}: with every value, {next(iter(bad.values()))}")
        else:
            problems += [f"axes.{axis.long_name}[{i + 1}]: {why}" for i, why in bad.items()]
    # If no value of several axes works, the cause may be one of them, or [chain].
    if len(always) > 1:
        always = [f"axes: with every combination of values, {always[0].split(', ', 1)[1]}"]
    return list(dict.fromkeys(problems + always))


def _bad_units(plan: Plan) -> list[str]:
    """Find values with units in scaled sweeps, and chains in different units."""
    spec = plan.specification
    with_unit = [f"axes.{axis.long_name}" for axis in spec.axes if axis.has_units]
    with_unit += [f"method.{name}" for name, value in spec.options.items() if has_unit(value)]
    if with_unit and plan.units == "scaled":
        problem = "has a unit, but the chains are in scaled variables: give plain numbers"
        return [f"{name}: {problem}" for name in with_unit]
    for found in map(plan.trial, plan.tried()):
        if not found.reason and found.units != plan.units:
            return ["axes: some chains are in SI units, others scaled: use two sweeps"]
    return []


def _method_error(plan: Plan, method: str) -> str:
    """Why a method supports neither the first nor the last chain; empty if it does."""
    reason = ""
    for chain in tried_chains(plan):
        try:
            pulse_by(method, chain)
        except InputError as error:
            reason = reason or str(error)
        except SimulationError:
            return ""
        else:
            return ""
    return reason


def tried_chains(plan: Plan) -> list[Chain]:
    """The first and the last chain that can be made, of those that are tried."""
    tried = [*plan.tried()]
    ends = (
        next((i for i in order if not plan.trial(i).reason), None) for order in (tried, tried[::-1])
    )
    return [plan.chain(index) for index in dict.fromkeys(ends) if index is not None]


def _never_predicted(plan: Plan) -> list[str]:
    """Find kept quantities that none of the methods gives."""
    spec = plan.specification
    wanted = {name for name in (*spec.keep, *spec.errors) if name in QUANTITIES}
    if set(spec.methods) & {*SIMULATIONS}:
        wanted = {name for name in wanted if QUANTITIES[name].estimate}
    if not wanted:
        return []
    predicted = {name for method in spec.methods for name in _columns(plan, method)}
    return [
        f"sweep.keep: no method gives {name}: {', '.join(spec.methods)}"
        for name in sorted(wanted - predicted)
    ]


def _columns(plan: Plan, method: str) -> Iterable[str]:
    """Quantities that a theory gives; all of them if it supports none of the chains."""
    if method in SIMULATIONS:
        return ()
    for chain in tried_chains(plan):
        with suppress(InputError, SimulationError):
            return pulse_by(method, chain).columns()
    return QUANTITIES

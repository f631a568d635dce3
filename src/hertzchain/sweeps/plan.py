"""The points of a sweep: their order, their chains, and the batches they are computed in."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, Final

import numpy as np

from hertzchain.chain.chain import Chain
from hertzchain.chain.sizes import checked_beads
from hertzchain.chain.tapers import check_taper, tapered_radii
from hertzchain.contacts import Array
from hertzchain.errors import InputError
from hertzchain.store.chain_files import METHODS, chain_from
from hertzchain.sweeps.axes import Axis
from hertzchain.sweeps.methods import INTEGRATIONS
from hertzchain.sweeps.reading import specification_from_json
from hertzchain.sweeps.specification import TAKEN, WALL_QUANTITIES, Specification

Index = tuple[int, ...]

# Points of a batch: at most so many (of whole trajectories, which take longer, fewer), and so
# few that there are batches for all workers.
MOST, MOST_TRAJECTORIES, LEAST, BATCHES = 2048, 32, 8, 32
# Bytes of one quantity in a batch, and of all that is in memory while it is computed.
MOST_BYTES: Final = 16 * 2**20
MOST_HELD: Final = 2**27
# Numbers per bead in memory while a batch is computed, next to what is kept (measured).
HELD_PER_BEAD: Final = 20
# Values of one axis that are tried before anything is computed.
TRIED: Final = 200
# Keys of [chain] of a plain scaled taper, whose radii are quickly had.
TAPER_KEYS: Final = frozenset({"taper", "rate", "beads"})


@dataclass(frozen=True)
class Trial:
    """What became of making the chain of a point.

    Attributes
    ----------
    reason : str
        Why there is no such chain; empty if there is.
    units : str
        Units of the chain.
    walled : bool
        Whether it has a right wall.
    """

    reason: str = ""
    units: str = "scaled"
    walled: bool = False


@dataclass(frozen=True, eq=False)
class Plan:
    """Points, in the order of a dataset with a dimension for each axis, and their batches.

    Attributes
    ----------
    specification : Specification
        What is swept.

    Examples
    --------
    >>> from hertzchain.sweeps.reading import read_specification
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
        """Whether all axes run together along one dimension."""
        return self.specification.combine == "zip"

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Name of each axis in a dataset."""
        short = [axis.name for axis in self.specification.axes]
        reserved = {*TAKEN, *self.variables}
        return tuple(
            _full_name(axis) if short.count(name) > 1 or name in reserved else name
            for axis, name in zip(self.specification.axes, short, strict=True)
        )

    @property
    def variables(self) -> tuple[str, ...]:
        """Names of what is kept."""
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
        """Number of values along each of them."""
        lengths = tuple(len(axis) for axis in self.specification.axes)
        return lengths[:1] if self.zipped else lengths

    @property
    def points(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    def document(self, index: Index) -> dict[str, Any]:
        """Tables ``chain``, ``materials`` and ``method`` of a point.

        Parameters
        ----------
        index : tuple of int
            Its place along each dimension, from 0.

        Returns
        -------
        dict

        Examples
        --------
        >>> from hertzchain.sweeps.reading import read_specification
        >>> axes = {"rate": [0.02, 0.04], "beads": [10, 20, 30]}
        >>> plan = Plan(read_specification({"chain": {"taper": "forward-linear"}, "axes": axes}))
        >>> plan.document((0, 1))["chain"]
        {'taper': 'forward-linear', 'rate': 0.02, 'beads': 20}
        """
        spec = self.specification
        found: dict[str, Any] = {
            "chain": spec.chain, "materials": spec.materials, "method": spec.options
        }  # fmt: skip
        places = index * len(spec.axes) if self.zipped else index
        for axis, place in zip(spec.axes, places, strict=True):
            path = axis.path if axis.path[0] == "method" else ("chain", *axis.path)
            found = with_value(found, path, axis.values[place])
        return found

    def chain(self, index: Index) -> Chain:
        """The chain of a point.

        Parameters
        ----------
        index : tuple of int
            Its place along each dimension, from 0.

        Returns
        -------
        Chain

        Raises
        ------
        InputError
            If there is no such chain.

        Examples
        --------
        >>> from hertzchain.sweeps.reading import read_specification
        >>> axes = {"rate": [0.02, 0.04], "beads": [10, 20, 30]}
        >>> plan = Plan(read_specification({"chain": {"taper": "forward-linear"}, "axes": axes}))
        >>> plan.chain((0, 1))
        Chain(forward-linear, S = 0.02, 20 beads)
        """
        document = self.document(index)
        return chain_from({"chain": document["chain"], "materials": document["materials"]})

    def trial(self, index: Index) -> Trial:
        """Make the chain of a point, once.

        Parameters
        ----------
        index : tuple of int
            Its place along each dimension, from 0.

        Returns
        -------
        Trial

        Examples
        --------
        >>> from hertzchain.sweeps.reading import read_specification
        >>> axes = {"rate": [0.02, 4.0]}
        >>> chain = {"taper": "forward-linear", "beads": 9}
        >>> Plan(read_specification({"chain": chain, "axes": axes})).trial((1,)).reason[:40]
        'a forward-linear taper with S = 4 runs o'
        """
        if index not in self._trials:
            try:
                chain = self.chain(index)
                self._trials[index] = Trial("", chain.units, chain.right_wall is not None)
            except InputError as error:
                self._trials[index] = Trial(str(error))
        return self._trials[index]

    @cached_property
    def _trials(self) -> dict[Index, Trial]:
        return {}

    def radii(self, index: Index) -> Array | None:
        """Radii of a point that is a plain taper; `None` of any other.

        Parameters
        ----------
        index : tuple of int
            Its place along each dimension, from 0.

        Returns
        -------
        ndarray or None

        Raises
        ------
        InputError
            If there is no such taper.

        Examples
        --------
        >>> from hertzchain.sweeps.reading import read_specification
        >>> axes = {"rate": [0.02, 0.04], "beads": [10, 20, 30]}
        >>> plan = Plan(read_specification({"chain": {"taper": "forward-linear"}, "axes": axes}))
        >>> plan.radii((1, 0))[:3]
        array([1.  , 0.96, 0.92])
        """
        if self._taper is None:
            return None
        places = index * len(self.specification.axes) if self.zipped else index
        taper, rate, count = (values[places[place]] for place, values in self._taper)
        if taper == "uniform":
            return None
        beads = checked_beads(count)
        return tapered_radii(taper, check_taper(taper, rate, beads), beads)

    @cached_property
    def _taper(self) -> list[tuple[int, list[Any]]] | None:
        """Axis and values of taper, rate and beads, if nothing else is said of the chains."""
        spec = self.specification
        axes = {axis.path[0]: (place, axis.values) for place, axis in enumerate(spec.axes)}
        if spec.chain.keys() | axes.keys() != TAPER_KEYS:
            return None
        # What does not vary has its one value at the place of any axis.
        fixed = {key: (0, [value] * len(spec.axes[0])) for key, value in spec.chain.items()}
        return [(fixed | axes)[key] for key in ("taper", "rate", "beads")]

    @property
    def ragged(self) -> bool:
        """Whether chains may differ in length, otherwise than by an axis that says so."""
        return "beads" not in self.names and (self.zipped or bool(self._changing))

    @property
    def judged(self) -> bool:
        """Whether a method may say that it is outside its range."""
        scaled = self.units == "scaled"
        return not (scaled and set(self.specification.methods) <= {*INTEGRATIONS})

    @property
    def walled(self) -> bool:
        """Whether something of a wall is kept, which may be incomplete."""
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
        """All lengths, if an axis gives them and nothing else changes them."""
        axes = {axis.path: axis for axis in self.specification.axes}
        keys = {path[0] for path in axes} | self.specification.chain.keys()
        values = axes[("beads",)].values if ("beads",) in axes else []
        whole = bool(values) and all(isinstance(value, int) for value in values)
        return values if whole and keys.isdisjoint(METHODS) else None

    def _changes_length(self, place: int, axis: Axis) -> bool:
        first = (0,) * len(self.shape)
        tried = {self._beads((*first[:place], i, *first[place + 1 :])) for i in spread(len(axis))}
        # Where there is no chain, another value of another axis may make one of any length.
        return len(tried) > 1 or 0 in tried

    def _beads(self, index: Index) -> int:
        """Number of beads of a point, 0 if there is no such chain."""
        try:
            table = self.document(index)["chain"]
            if isinstance(table.get("beads"), int) and not table.keys() & METHODS:
                return int(table["beads"])
            return self.chain(index).beads
        except InputError:
            return 0

    @cached_property
    def block(self) -> Index:
        """Points of a batch along each dimension: a chunk of the arrays in the store."""
        spec = self.specification
        most = MOST_TRAJECTORIES if "simulate" in spec.methods else MOST
        kept = self.longest if spec.at == "every" else 1
        most = min(most, max(1, MOST_BYTES // (8 * max(1, kept) * len(spec.methods))))
        most = min(most, max(1, MOST_HELD // max(1, self._held_per_point)))
        left = spec.batch or min(most, max(LEAST, math.ceil(self.points / BATCHES)))
        block = [1] * len(self.shape)
        for place in range(len(self.shape) - 1, -1, -1):
            size = self.shape[place]
            block[place] = math.ceil(size / math.ceil(size / left))
            left //= block[place]
            if block[place] < size or left < 2:
                break
        return tuple(block)

    @property
    def _held_per_point(self) -> int:
        """Bytes in memory for each point of a batch while it is computed."""
        spec = self.specification
        quantities = len(dict.fromkeys((*spec.keep, *spec.errors))) + len(spec.errors)
        return 8 * self.longest * (len(spec.methods) * quantities + HELD_PER_BEAD)

    @property
    def bytes_held(self) -> int:
        """Bytes in memory while a batch is computed, about."""
        return math.prod(self.block) * self._held_per_point

    @cached_property
    def grid(self) -> Index:
        """Number of batches along each dimension."""
        return tuple(math.ceil(n / b) for n, b in zip(self.shape, self.block, strict=True))

    @property
    def batches(self) -> int:
        """Number of batches."""
        return math.prod(self.grid)

    def region(self, batch: int) -> tuple[slice, ...]:
        """Where the points of a batch are.

        Parameters
        ----------
        batch : int
            Number of the batch, from 0.

        Returns
        -------
        tuple of slice

        Examples
        --------
        >>> from hertzchain.sweeps.reading import read_specification
        >>> axes = {"rate": [0.02, 0.04], "beads": [10, 20, 30]}
        >>> plan = Plan(read_specification({"chain": {"taper": "forward-linear"}, "axes": axes}))
        >>> plan.region(0)
        (slice(0, 2, None), slice(0, 3, None))
        """
        corner = np.unravel_index(batch, self.grid)
        return tuple(
            slice(int(c) * b, min((int(c) + 1) * b, n))
            for c, b, n in zip(corner, self.block, self.shape, strict=True)
        )

    def indices(self, batch: int) -> Iterator[Index]:
        """The points of a batch, in order.

        Parameters
        ----------
        batch : int
            Number of the batch, from 0.

        Yields
        ------
        tuple of int

        Examples
        --------
        >>> from hertzchain.sweeps.reading import read_specification
        >>> axes = {"rate": [0.02, 0.04], "beads": [10, 20, 30]}
        >>> plan = Plan(read_specification({"chain": {"taper": "forward-linear"}, "axes": axes}))
        >>> [*plan.indices(0)][:4]
        [(0, 0), (0, 1), (0, 2), (1, 0)]
        """
        return itertools.product(*(range(part.start, part.stop) for part in self.region(batch)))

    @cached_property
    def units(self) -> str:
        """Units of the chains: ``"scaled"`` or ``"SI"``."""
        found = (self.trial(index) for index in self.tried())
        return next((each.units for each in found if not each.reason), "scaled")

    def tried(self) -> Iterator[Index]:
        """A few of the points, the first and the last among them.

        Yields
        ------
        tuple of int

        Examples
        --------
        >>> from hertzchain.sweeps.reading import read_specification
        >>> axes = {"rate": [0.02, 0.04], "beads": [10, 20, 30]}
        >>> plan = Plan(read_specification({"chain": {"taper": "forward-linear"}, "axes": axes}))
        >>> len([*plan.tried()])
        6
        """
        for flat in spread(self.points):
            yield tuple(int(i) for i in np.unravel_index(flat, self.shape))


def _full_name(axis: Axis) -> str:
    return "_".join(axis.path if axis.path[0] == "method" else ("chain", *axis.path))


@lru_cache(maxsize=4)
def plan_of(text: str) -> Plan:
    """The plan of a specification, kept for the next batch.

    Parameters
    ----------
    text : str
        JSON of a specification.

    Returns
    -------
    Plan

    Examples
    --------
    >>> from hertzchain.sweeps.reading import read_specification
    >>> axes = {"beads": [20, 40]}
    >>> plan_of(read_specification({"chain": {"taper": "uniform"}, "axes": axes}).as_json()).points
    2
    """
    return Plan(specification_from_json(text))


def with_value(document: Any, path: tuple[str, ...], value: Any) -> Any:
    """A document with one value changed; the rest is shared.

    Parameters
    ----------
    document : mapping, list or None
        Nested tables and lists.
    path : tuple of str
        Keys, and places in lists from 1.
    value : object
        The new value.

    Returns
    -------
    dict or list

    Raises
    ------
    InputError
        If the path leads into what is neither table nor list, or past the end of a list.

    Examples
    --------
    >>> with_value({"radii": [1.0, 1.0], "loss": {"law": "dashpot"}}, ("radii", "2"), 0.5)
    {'radii': [1.0, 0.5], 'loss': {'law': 'dashpot'}}
    """
    key, rest = path[0], path[1:]
    if isinstance(document, list):
        if not (key.isdigit() and 1 <= int(key) <= len(document)):
            raise InputError(f"there is no place {key} among {len(document)} values")
        changed = list(document)
        old = changed[int(key) - 1]
        changed[int(key) - 1] = with_value(old, rest, value) if rest else value
        return changed
    if document is not None and not isinstance(document, Mapping):
        raise InputError(f"cannot set {'.'.join(path)} of {document!r}: it is not a table")
    table = dict(document or {})
    table[key] = with_value(table.get(key), rest, value) if rest else value
    return table


def spread(count: int) -> list[int]:
    """At most `TRIED` of so many places, with the first and the last.

    Parameters
    ----------
    count : int
        Number of places.

    Returns
    -------
    list of int

    Examples
    --------
    >>> spread(3), len(spread(10**6))
    ([0, 1, 2], 200)
    """
    if count <= TRIED:
        return list(range(count))
    return [int(i) for i in np.linspace(0, count - 1, TRIED).round()]

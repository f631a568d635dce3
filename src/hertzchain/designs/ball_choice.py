"""Discrete variables of a design: balls of a catalogue, and the order of given beads."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from math import factorial, prod
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..chain.chain import Chain
from ..chain.materials import Material, material
from ..chain.places import places_from
from ..errors import InputError
from ..representation import short
from ..validation.numbers import real_numbers
from ..validation.objects import check_bool, check_list
from . import stock
from .balls import Ball, load_balls

Choice = NDArray[np.int64]
# Relative difference of two diameters that are regarded as the same.
SAME: Final = 1e-3


@dataclass(frozen=True, repr=False)
class BallChoice:
    """Balls of a catalogue for some places; see `hertzchain.vary.balls`."""

    catalogue: Any
    materials: Any
    diameters: Any
    beads: Any
    optional: bool

    def __post_init__(self) -> None:
        check_bool("optional", self.optional)
        if self.materials is not None:
            given = [self.materials] if isinstance(self.materials, str | Material) else (
                check_list("materials", self.materials, "names")
            )  # fmt: skip
            object.__setattr__(self, "materials", tuple(map(material, given)))
        if self.diameters is not None:
            values = real_numbers("diameter", list(self.diameters), "ball", unit="m")
            object.__setattr__(self, "diameters", tuple(np.atleast_1d(values).tolist()))

    @property
    def balls(self) -> tuple[Ball, ...]:
        """The balls to choose from."""
        found, name = load_balls(self.catalogue), repr(str(self.catalogue))
        if self.materials is not None:
            for kind in self.materials:
                if all(each.material != kind for each in found):
                    known = ", ".join(dict.fromkeys(each.material.name for each in found))
                    raise InputError(
                        f"the catalogue {name} has no balls of {kind.name}; it has {known}"
                    )
            found = tuple(each for each in found if each.material in self.materials)
        if self.diameters is not None:
            _check_sizes(found, self.diameters, name, self.materials)
            chosen = tuple(each for each in found if _among(each.diameter, self.diameters))
            _check_materials(found, chosen, self.diameters, name, self.materials)
            found = chosen
        return found

    def __repr__(self) -> str:
        kinds = len(self.balls)
        empty = ", places may be empty" if self.optional else ""
        return short("BallChoice", f"{kinds} kinds of balls for {self.beads!r}{empty}")

    def space(self, chain: Chain) -> BallSpace:
        """The choices for a chain."""
        _check(chain)
        if chain.units != "SI" or chain.materials is None:
            raise InputError(
                "balls of a catalogue have materials: build the chain with Chain.from_materials"
            )
        places, balls = places_from(self.beads, chain.beads, "bead"), self.balls
        if len(balls) + self.optional < 2:
            raise InputError("there is one kind of balls, which leaves nothing to vary")
        space = BallSpace(chain, places, balls, self.optional, None)
        if space.limits is not None and not self.optional and sum(space.limits) < space.size:
            raise InputError(
                f"the catalogue {str(self.catalogue)!r} has {sum(space.limits)} balls in stock for "
                f"{space.size} places; let fewer beads vary, or permit empty places (optional)"
            )
        return space


@dataclass(frozen=True, repr=False)
class OrderChoice:
    """The order of some beads; see `hertzchain.vary.order`."""

    beads: Any

    def __repr__(self) -> str:
        return short("OrderChoice", f"order of the beads {self.beads!r}")

    def space(self, chain: Chain) -> BallSpace:
        """The orders for a chain."""
        _check(chain)
        places = places_from(self.beads, chain.beads, "bead")
        kinds = chain.materials or (None,) * chain.beads
        items = [(float(chain.radii[k]), kinds[k]) for k in places]
        distinct = list(dict.fromkeys(items))
        if len(distinct) < 2:
            raise InputError("all beads that can be exchanged are equal, which leaves no order")
        if chain.units == "scaled" and chain.strikers in places:
            raise InputError(
                f"bead {chain.strikers + 1} has radius 1, the unit of a scaled chain, and cannot "
                f"be exchanged: use beads='{chain.strikers + 2}:'"
            )
        start = np.array([distinct.index(each) for each in items])
        balls = tuple(Ball(2.0 * radius, kind) for radius, kind in distinct)
        return BallSpace(chain, places, balls, False, start)


def _check(chain: Chain) -> None:
    own = sorted({"masses", "stiffness"} & set(chain.given))
    if chain.gaps[chain.strikers :].any():
        own.append("gaps")
    if own:
        raise InputError(
            f"the {' and '.join(own)} of this chain are given bead by bead, and its beads "
            "cannot be exchanged: omit them"
        )


def _check_sizes(
    balls: tuple[Ball, ...], wanted: tuple[float, ...], name: str, materials: Any
) -> None:
    """Raise `InputError` if a catalogue does not have all diameters."""
    found = sorted({each.diameter for each in balls})
    missing = [each for each in wanted if not _among(each, tuple(found))]
    if not missing:
        return
    nearest = [found[int(np.argmin(np.abs(np.array(found) - size)))] for size in missing]
    of = f" of {' or '.join(kind.name for kind in materials)}" if materials else ""
    verb = "is" if len(missing) == 1 else "are"
    raise InputError(
        f"{', '.join(f'{1e3 * each:g} mm' for each in missing)} {verb} not among the balls{of} in "
        f"the catalogue {name}; the nearest {verb} "
        f"{', '.join(f'{1e3 * each:g} mm' for each in dict.fromkeys(nearest))}"
    )


def _check_materials(
    balls: tuple[Ball, ...], chosen: tuple[Ball, ...], wanted: tuple[float, ...], name: str,
    materials: Any,
) -> None:  # fmt: skip
    """Raise `InputError` if no ball of a requested material has one of the diameters."""
    for kind in materials or ():
        if any(each.material == kind for each in chosen):
            continue
        sizes = np.array([each.diameter for each in balls if each.material == kind])
        nearest = dict.fromkeys(float(sizes[np.argmin(np.abs(sizes - each))]) for each in wanted)
        raise InputError(
            f"no ball of {kind.name} in the catalogue {name} has one of these diameters; the "
            f"nearest are {', '.join(f'{1e3 * each:g} mm' for each in nearest)}: add some of them, "
            f"or omit {kind.name}"
        )


def _among(diameter: float, wanted: tuple[float, ...]) -> bool:
    return any(abs(diameter - each) <= SAME * each for each in wanted)


@dataclass(frozen=True, eq=False)
class BallSpace:
    """Choices of a ball for each place; ``start`` fixes the balls, whose order varies."""

    chain: Chain
    places: NDArray[np.int64]
    balls: tuple[Ball, ...]
    optional: bool
    start: Choice | None

    @property
    def size(self) -> int:
        """Number of places."""
        return len(self.places)

    @property
    def kinds(self) -> int:
        """Number of choices of each place; the last one is an empty place if it is allowed."""
        return len(self.balls) + self.optional

    @property
    def order(self) -> bool:
        """Whether the order of fixed balls varies."""
        return self.start is not None

    @cached_property
    def limits(self) -> list[int] | None:
        """Numbers of the balls in stock, at most that of the places; None if any are."""
        if all(ball.count is None for ball in self.balls):
            return None
        return [self.size if b.count is None else min(b.count, self.size) for b in self.balls]

    @property
    def least(self) -> int:
        """Smallest number of balls: a chain has at least two beads."""
        return max(0, 2 - (self.chain.beads - self.size)) if self.optional else self.size

    def long_enough(self, choice: Choice) -> bool:
        """Whether a choice has enough balls for a chain."""
        return not self.optional or int((choice < len(self.balls)).sum()) >= self.least

    @cached_property
    def count(self) -> int:
        """Number of all choices, of which each has its empty places at the end."""
        if self.start is not None:
            return factorial(self.size) // prod(map(factorial, np.bincount(self.start).tolist()))
        lengths = range(self.least, self.size + 1)
        if self.limits is not None:
            return stock.count_rows(self.limits, lengths)
        return sum(len(self.balls) ** length for length in lengths)

    def rows(self) -> Iterator[Choice]:
        """All choices of balls, in lexicographic order."""
        limits = self.limits or [self.size] * len(self.balls)
        return filter(self.long_enough, stock.all_rows(limits, self.size, optional=self.optional))

    def in_stock(self, choice: Choice) -> bool:
        """Whether no more balls are needed than there are."""
        return self.limits is None or stock.within(self.limits, choice)

    def from_stock(self, choice: Choice, rng: np.random.Generator) -> Choice:
        """The choice, with random balls of the stock in place of those that are missing."""
        if self.in_stock(choice):
            return choice
        assert self.limits is not None
        return stock.repaired(self.limits, choice, rng, optional=self.optional)

    def chain_of(self, choice: Choice) -> Chain:
        """The chain with these balls; empty places are omitted."""
        base = self.chain
        radii, kinds = base.radii.copy(), list(base.materials or ())
        keep = np.ones(base.beads, bool)
        for place, item in zip(self.places, choice, strict=True):
            if item == len(self.balls):
                keep[place] = False
                continue
            radii[place] = self.balls[item].radius
            if kinds:
                kinds[place] = self.balls[item].material
        changes: dict[str, Any] = {"radii": radii[keep]}
        if kinds:
            changes["materials"] = tuple(m for m, kept in zip(kinds, keep, strict=True) if kept)
        if "velocities" in base.given:
            changes["velocities"] = base.velocities[keep]
        if "gaps" in base.given:
            # Only strikers have gaps, which are the first.
            changes["gaps"] = base.gaps[: keep.sum() - 1]
        return base.replace(**changes)

    def price(self, choice: Choice) -> float:
        """Price of the balls that vary."""
        return float(sum(self.balls[i].price for i in choice if i < len(self.balls)))

    def parts(self, choice: Choice) -> list[tuple[int, str]]:
        """Parts list: number and name of each kind of ball."""
        used = [int(i) for i in choice if i < len(self.balls)]
        return [(used.count(i), str(self.balls[i])) for i in sorted(set(used))]

    def neat(self, choice: Choice) -> Choice:
        """The choice with all empty places at the end, so that equal chains are one choice."""
        if not self.optional:
            return choice
        empty = choice == len(self.balls)
        return np.concatenate([choice[~empty], choice[empty]])

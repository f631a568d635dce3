"""The space of choices of balls for the places of a chain, or of orders of its beads."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from math import factorial, prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..chain.chain import Chain
from . import stock
from .balls import Ball

Choice = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class BallSpace:
    """Choices of a ball for each place.

    ``given`` fixes the balls, whose order varies; ``start`` is a row with which the search begins.
    """

    chain: Chain
    places: NDArray[np.int64]
    balls: tuple[Ball, ...]
    optional: bool
    given: Choice | None = None
    start: Choice | None = None

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
        return self.given is not None

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
        if self.given is not None:
            return factorial(self.size) // prod(map(factorial, np.bincount(self.given).tolist()))
        lengths = range(self.least, self.size + 1)
        if self.limits is not None:
            return stock.count_rows(self.limits, lengths)
        return sum(len(self.balls) ** length for length in lengths)

    @property
    def first(self) -> Choice:
        """The given order, the row with which the search begins, or any row."""
        given = self.start if self.given is None else self.given
        return next(self.rows()) if given is None else given

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

    def parts(self, choice: Choice) -> dict[int, int]:
        """Parts list: number of balls of each kind, by its place in the catalogue."""
        used = sorted(int(i) for i in choice if i < len(self.balls))
        return {i: used.count(i) for i in used}

    def neat(self, choice: Choice) -> Choice:
        """The choice with all empty places at the end, so that equal chains are one choice."""
        if not self.optional:
            return choice
        empty = choice == len(self.balls)
        return np.concatenate([choice[~empty], choice[empty]])

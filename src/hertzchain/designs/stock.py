"""Rows of balls of which only limited numbers are in stock."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import comb

import numpy as np
from numpy.typing import NDArray

Row = NDArray[np.int64]


def count_rows(limits: Sequence[int], lengths: Sequence[int]) -> int:
    """Number of rows of these lengths, in which ball i occurs at most ``limits[i]`` times."""
    longest = max(lengths)
    ways = [1] + [0] * longest
    for limit in limits:
        # The balls of a kind take j of the n places of a longer row.
        ways = [
            sum(comb(n, j) * ways[n - j] for j in range(min(limit, n) + 1))
            for n in range(longest + 1)
        ]
    return sum(ways[length] for length in lengths)


def all_rows(limits: Sequence[int], size: int, *, optional: bool) -> Iterator[Row]:
    """All rows of balls in lexicographic order; empty places, if allowed, are at the end.

    An empty place is the number ``len(limits)``.
    """
    left, row = list(limits), [len(limits)] * size

    def fill(place: int) -> Iterator[Row]:
        if place == size:
            yield np.array(row)
            return
        for ball in range(len(limits)):
            if left[ball] > 0:
                left[ball] -= 1
                row[place] = ball
                yield from fill(place + 1)
                left[ball] += 1
        row[place] = len(limits)
        if optional:
            yield np.array(row)

    return fill(0)


def excess(limits: Sequence[int], row: Row) -> Row:
    """Number of balls of each kind above those in stock."""
    return np.maximum(np.bincount(row, minlength=len(limits))[: len(limits)] - limits, 0)


def within(limits: Sequence[int], row: Row) -> bool:
    """Whether a row needs no more balls than are in stock."""
    return not excess(limits, row).any()


def repaired(limits: Sequence[int], row: Row, rng: np.random.Generator, *, optional: bool) -> Row:
    """Replace balls that are not in stock, at random places, by random ones that are."""
    over, row = excess(limits, row), row.copy()
    left = np.append(limits, len(row) if optional else 0)
    left -= np.bincount(row, minlength=len(left))
    for ball in np.flatnonzero(over):
        for place in rng.permutation(np.flatnonzero(row == ball))[: over[ball]]:
            row[place] = rng.choice(np.flatnonzero(left > 0))
            left[row[place]] -= 1
    return row

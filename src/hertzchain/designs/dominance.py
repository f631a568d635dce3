"""Dominance among pairs of costs: rows that no other row beats, and how isolated they are."""

from __future__ import annotations

import numpy as np

from ..collision import Array

# Relative differences that are rounding errors of sums, and those of trial simulations.
ROUNDED, TRIAL_ERROR = 1e-9, 1e-5


def undominated(costs: Array) -> list[int]:
    """Rows of two costs that no other row beats, in the order of the first cost."""
    if not len(costs):
        return []
    size = np.abs(costs[:, 1]).max() or 1.0
    rounded = np.round(costs[:, 1] / (ROUNDED * size))
    found: list[int] = []
    lowest = np.inf
    for i in np.lexsort((costs[:, 0], rounded)):
        if not found or costs[i, 0] < lowest - TRIAL_ERROR * abs(lowest):
            found.append(int(i))
            lowest = costs[i, 0]
    return found[::-1]


def crowding(costs: Array) -> Array:
    """Relative distances between the neighbours of each point of a front; infinite at its ends."""
    found = np.full(len(costs), np.inf)
    if len(costs) > 2:
        spans = np.ptp(costs, axis=0)
        steps = np.abs(costs[2:] - costs[:-2]) / np.where(spans > 0.0, spans, 1.0)
        found[1:-1] = steps.sum(axis=1)
    return found


def best_spread(costs: Array, count: int) -> list[int]:
    """Rows of the first front, then of the next ones; in each, isolated points first."""
    left, found = np.arange(len(costs)), list[int]()
    while len(left) and len(found) < count:
        front = left[undominated(costs[left])]
        order = np.argsort(-crowding(costs[front]), kind="stable")
        found += front[order].tolist()
        left = np.setdiff1d(left, front)
    return found[:count]

"""Scan of one variable: a grid, and refinement of every local optimum."""

from __future__ import annotations

from typing import Final

import numpy as np

from .trials import Outcome, Trials

POINTS: Final = 129
# A refinement ends when its interval is this small.
WIDTH: Final = 5e-6
SECTIONS: Final = 8
# Tolerance of the runs of a refinement: an error of the value moves a flat optimum by its root.
FINE_RTOL: Final = 1e-8


def scan(trials: Trials, end: float) -> list[Outcome]:
    """All local optima between the limits, best first; the limits themselves may be among them."""
    count = min(POINTS, max(2, trials.room))
    grid = np.linspace(0.0, 1.0, count)
    found = trials.evaluate([np.array([x]) for x in grid])
    ranks = [each.rank for each in found]
    optima = []
    for i in range(len(found)):
        behind = ranks[i - 1] if i > 0 else (np.inf,) * 3
        ahead = ranks[i + 1] if i < len(found) - 1 else (np.inf,) * 3
        if ranks[i] < behind and ranks[i] <= ahead and np.isfinite(ranks[i][1]):
            optima.append(_refined(trials, found[i], 1.0 / (count - 1), end))
    return sorted(optima, key=lambda each: each.rank)


def _refined(trials: Trials, best: Outcome, width: float, end: float) -> Outcome:
    """Divide the interval around a point again and again, with several trials at a time."""
    best = next(iter(trials.evaluate([best.x], rtol=FINE_RTOL)), best)
    while width > WIDTH and trials.used < end:
        centre = float(best.x[0])
        points = np.linspace(max(0.0, centre - width), min(1.0, centre + width), 2 * SECTIONS + 1)
        new = trials.evaluate([np.array([x]) for x in points], rtol=FINE_RTOL)
        best = min([best, *new], key=lambda each: each.rank)
        width /= SECTIONS
    return best

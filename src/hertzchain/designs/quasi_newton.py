"""Descent with gradients for smooth objectives: SLSQP of SciPy within boxes."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from ..collision import Array
from .bundle_descent import Model, model_at
from .search_budget import Spent
from .trials import Outcome, Trials

# Largest change of a variable in one search; a longer step can leave the range and not return.
BOX: Final = 0.25
ROUNDS, ITERATIONS = 12, 60
PRECISION: Final = 1e-15


def quasi_newton(trials: Trials, start: Array, end: float) -> Outcome:
    """Descend from a point until nothing is gained or a part of the budget is used."""
    from scipy.optimize import minimize

    known: dict[bytes, Model] = {}

    def at(point: Array) -> Model:
        point = np.clip(point, 0.0, 1.0)
        if point.tobytes() not in known:
            if known and trials.used >= end:
                raise Spent
            known[point.tobytes()] = model_at(trials, point)
        return known[point.tobytes()]

    best = at(start)
    if not np.isfinite(best.outcome.score) or not np.isfinite(best.slope).all():
        return best.outcome
    scale = abs(best.outcome.score) or 1.0

    def objective(point: Array) -> tuple[float, Array]:
        found = at(point)
        if not np.isfinite(found.outcome.score):
            return 1e6, np.zeros(len(point))
        return found.outcome.score / scale, found.slope / scale

    constraints: list[dict[str, Any]] = []
    if len(best.excess):
        constraints = [{"type": "ineq", "fun": lambda x: -at(x).excess,
                        "jac": lambda x: -at(x).excess_slope}]  # fmt: skip
    try:
        for _ in range(ROUNDS):
            point = best.point
            limits = [*zip(np.maximum(point - BOX, 0.0), np.minimum(point + BOX, 1.0), strict=True)]
            minimize(objective, point, jac=True, method="SLSQP", bounds=limits,
                     constraints=constraints,
                     options={"maxiter": ITERATIONS, "ftol": PRECISION})  # fmt: skip
            better = min(known.values(), key=lambda each: each.outcome.rank)
            moved = float(np.abs(better.point - point).max())
            best = better
            if moved < 0.9 * BOX:
                break
    except Spent:
        pass
    return min(known.values(), key=lambda each: each.outcome.rank).outcome

"""Descent with gradients: a sequence of linear programs within a growing and shrinking box.

The derivatives of peak forces and CVaR jump: both are maxima over many peaks and samples.  Each
step minimises the largest of the linear models at recent points (a bundle).  The descent thus
follows the edges between peaks; constraints are linear models, too.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from ..collision import Array
from .search_budget import Spent
from .trials import Outcome, Trials

FIRST_BOX, MIN_BOX, MAX_BOX = 0.05, 1e-6, 0.3
# A step is accepted if it achieves this fraction of the gain of the linear models.
MIN_SHARE: Final = 0.05
KEPT: Final = 12
# A descent ends when this many points together improve the score by less than this fraction.
STALLED, MIN_GAIN = 20, 2e-3
# Weight of violated constraints, in units of the score, while they cannot be met.
PENALTY: Final = 20.0


@dataclass(frozen=True, eq=False)
class Model:
    """Linear model of score and constraints at a point.

    ``pieces`` are rows of a sample, a score and its derivatives.  The score is the mean, over the
    ``counted`` worst samples, of the largest of the pieces of each.
    """

    outcome: Outcome
    slope: Array
    excess: Array
    excess_slope: Array
    pieces: Array
    counted: int

    @property
    def point(self) -> Array:
        """The point."""
        return np.asarray(self.outcome.x)


def model_at(trials: Trials, point: Array) -> Model:
    """The linear model at a point."""
    outcome, slopes, models = trials.slopes(point)
    problem = trials.problem
    slope = problem.objective.slope(outcome.values[trials.terms]) @ slopes[trials.terms]
    excess = [float(r.excess(outcome.values[i])) for r, i in
              zip(problem.requirements, trials.limits, strict=True)]  # fmt: skip
    steep = [r.sign * slopes[i] / (abs(r.limit) or 1.0) for r, i in
             zip(problem.requirements, trials.limits, strict=True)]  # fmt: skip
    weight = float(problem.objective.weights[0])
    pieces, counted = np.array([[0.0, outcome.score, *slope]]), 1
    if len(models):
        pieces = models * np.r_[1.0, np.full(models.shape[1] - 1, weight)]
        counted = problem.scatter._counted(len(trials.draws)) if trials.draws is not None else 1
    return Model(outcome, slope, np.array(excess),
                 np.array(steep).reshape(len(excess), len(point)), pieces, counted)  # fmt: skip


def descend(trials: Trials, start: Array, end: float, *, box: float = FIRST_BOX) -> Outcome:
    """Descend from a point until the box is very small or a part of the budget is used.

    The result is the best trial; the last one may slightly violate the constraints.
    """
    current = model_at(trials, np.clip(start, 0.0, 1.0))
    bundle, scores, best = [current], [current.outcome.rank], current.outcome
    while trials.used < end and box > MIN_BOX and np.isfinite(current.outcome.score):
        if _stalled(scores):
            break
        step, expected = _step(current, bundle, box)
        if not expected > 1e-9 * _merit_scale(current):
            box *= 0.25
            continue
        try:
            trial = model_at(trials, np.clip(current.point + step, 0.0, 1.0))
        except Spent:
            break
        if not np.isfinite(trial.slope).all() or not np.isfinite(trial.outcome.score):
            box *= 0.25
            continue
        gain = _merit(current, current) - _merit(trial, current)
        bundle = [*bundle[-KEPT + 1 :], trial]
        best = min(best, trial.outcome, key=lambda each: each.rank)
        scores.append(best.rank)
        if gain >= MIN_SHARE * expected:
            current = trial
            box = min(MAX_BOX, box * (2.0 if gain > 0.5 * expected else 1.0))
        else:
            box *= 0.5
    return best


def _stalled(scores: list[tuple[float, float, float]]) -> bool:
    """Whether the best of the latest points gains very little."""
    if len(scores) <= STALLED:
        return False
    (violated, before, _), (_, now, _) = scores[-1 - STALLED], scores[-1]
    return violated == 0.0 and before - now <= MIN_GAIN * abs(now)


def _merit_scale(model: Model) -> float:
    return abs(model.outcome.score) or 1.0


def _merit(model: Model, reference: Model) -> float:
    """Score with a penalty for violated constraints."""
    weight = PENALTY * _merit_scale(reference)
    return model.outcome.score + weight * float(np.maximum(model.excess, 0.0).sum())


def _step(current: Model, bundle: list[Model], box: float) -> tuple[Array, float]:
    """Step that minimises the model of the score, and its expected gain."""
    from scipy.optimize import linprog

    n, limits = len(current.point), len(current.excess)
    scale = _merit_scale(current)
    samples = int(current.pieces[:, 0].max()) + 1
    several = samples if samples > 1 else 0
    # Unknowns: the step, a score t relative to the present one, the excess of each sample over t
    # (their mean over the counted samples, plus t, is the CVaR), and the slack of constraints.
    cost = np.r_[np.zeros(n), 1.0, np.full(several, 1.0 / current.counted),
                 np.full(limits, PENALTY)]  # fmt: skip
    rows, right = _rows_of_pieces(current, bundle, box, samples)
    rows = np.pad(rows, ((0, 0), (0, limits)))
    own = np.hstack([current.excess_slope, np.zeros((limits, 1 + several)), -np.eye(limits)])
    low = np.maximum(-box, -current.point)
    high = np.minimum(box, 1.0 - current.point)
    bounds = [*zip(low, high, strict=True), (None, None), *[(0.0, None)] * (several + limits)]
    found = linprog(cost, np.vstack([rows, own]), np.r_[right, -current.excess], bounds=bounds,
                    method="highs")  # fmt: skip
    if found.x is None:
        return np.zeros(n), 0.0
    before = PENALTY * float(np.maximum(current.excess, 0.0).sum())
    return found.x[:n], scale * (before - float(found.fun))


def _rows_of_pieces(
    current: Model, bundle: list[Model], box: float, samples: int
) -> tuple[Array, Array]:
    """Inequalities by which t, plus the excess of a sample, is at least each of its pieces."""
    scale, score = _merit_scale(current), current.outcome.score
    present = np.full(samples, -np.inf)
    np.maximum.at(present, current.pieces[:, 0].astype(int), current.pieces[:, 1])
    rows, right = [], []
    # After many points that were not better, the present one is no longer in the bundle.
    for each in (current, *(other for other in bundle if other is not current)):
        shift = current.point - each.point
        if np.abs(shift).max(initial=0.0) > 4.0 * box:
            continue
        # Samples without derivatives are regarded as constant only at the present point.
        pieces = each.pieces if each is current else each.pieces[each.pieces[:, 2:].any(axis=1)]
        sample, slopes = pieces[:, 0].astype(int), pieces[:, 2:]
        # A model of a function that is not convex must not cut off the present point.
        there = np.minimum(pieces[:, 1] + slopes @ shift, present[sample])
        excess = -np.eye(samples)[sample] if samples > 1 else np.zeros((len(sample), 0))
        rows.append(np.hstack([slopes / scale, np.full((len(sample), 1), -1.0), excess]))
        right.append((score - there) / scale)
    return np.vstack(rows), np.concatenate(right)

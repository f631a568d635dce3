"""Covariance matrix adaptation, an evolution strategy for continuous variables.

N. Hansen, "The CMA Evolution Strategy: A Tutorial", arXiv:1604.00772, with the rank-based order of
`Outcome.rank`, without gradients or penalties.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from ..collision import Array
from .requirements import TOLERANCE
from .trials import Outcome, Trials

SIGMA: Final = 0.3
# A run ends when the best score of this many generations has changed by less than this fraction,
# or its step is smaller than this.
STALLED, MIN_GAIN, MIN_STEP = 20, 1e-5, 1e-6


class Strategy:
    """Mean, step and covariance of the distribution of trials."""

    def __init__(self, start: Array, population: int) -> None:
        n = self.n = len(start)
        self.mean, self.sigma = start.copy(), SIGMA
        self.population, half = population, population // 2
        weights = math.log(half + 0.5) - np.log(np.arange(1, half + 1))
        self.weights = weights / weights.sum()
        mu = self.mu = float(1.0 / (self.weights**2).sum())
        self.cs = (mu + 2.0) / (n + mu + 5.0)
        self.ds = 1.0 + 2.0 * max(0.0, math.sqrt((mu - 1.0) / (n + 1.0)) - 1.0) + self.cs
        self.cc = (4.0 + mu / n) / (n + 4.0 + 2.0 * mu / n)
        self.c1 = 2.0 / ((n + 1.3) ** 2 + mu)
        self.cmu = min(1.0 - self.c1, 2.0 * (mu - 2.0 + 1.0 / mu) / ((n + 2.0) ** 2 + mu))
        self.norm = math.sqrt(n) * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n))
        self.path_s, self.path_c = np.zeros(n), np.zeros(n)
        self.covariance, self.axes, self.lengths = np.eye(n), np.eye(n), np.ones(n)
        self.generation = 0

    def ask(self, rng: np.random.Generator) -> tuple[Array, Array]:
        """New steps, and their points, reflected at the limits 0 and 1."""
        normal = rng.standard_normal((self.population, self.n))
        steps = normal * self.lengths @ self.axes.T
        return steps, reflected(self.mean + self.sigma * steps)

    def tell(self, steps: Array, order: Array) -> None:
        """Update with the steps, best first."""
        self.generation += 1
        chosen = steps[order[: len(self.weights)]]
        mean_step = self.weights @ chosen
        self.mean = reflected(self.mean + self.sigma * mean_step)
        white = self.axes @ ((self.axes.T @ mean_step) / self.lengths)
        self.path_s *= 1.0 - self.cs
        self.path_s += math.sqrt(self.cs * (2.0 - self.cs) * self.mu) * white
        length = float(np.linalg.norm(self.path_s))
        faded = math.sqrt(1.0 - (1.0 - self.cs) ** (2 * self.generation))
        rising = length / faded < (1.4 + 2.0 / (self.n + 1.0)) * self.norm
        self.path_c *= 1.0 - self.cc
        if rising:
            self.path_c += math.sqrt(self.cc * (2.0 - self.cc) * self.mu) * mean_step
        kept = 1.0 - self.c1 - self.cmu + (0.0 if rising else self.c1 * self.cc * (2.0 - self.cc))
        self.covariance *= kept
        self.covariance += self.c1 * np.outer(self.path_c, self.path_c)
        self.covariance += self.cmu * (chosen.T * self.weights) @ chosen
        self.sigma *= math.exp((self.cs / self.ds) * (length / self.norm - 1.0))
        self.sigma = min(self.sigma, 1.0)
        squares, self.axes = np.linalg.eigh(0.5 * (self.covariance + self.covariance.T))
        self.lengths = np.sqrt(np.maximum(squares, 1e-20))


def reflected(points: Array) -> Array:
    """Points between 0 and 1, reflected at the limits."""
    folded = np.mod(points, 2.0)
    return np.where(folded > 1.0, 2.0 - folded, folded)


def evolve(
    trials: Trials, start: Array, end: float, rng: np.random.Generator, *, population: int
) -> Outcome | None:  # fmt: skip
    """One run from a start, until it stalls or a part of the budget is used; its best trial."""
    strategy, best = Strategy(start, population), None
    bests: list[float] = []
    while trials.used < end:
        steps, points = strategy.ask(rng)
        found = trials.evaluate(list(points))
        if len(found) < population:
            return min(
                [*found, *([best] if best else [])], key=lambda each: each.rank, default=None
            )
        order = np.array(sorted(range(population), key=lambda i: found[i].rank))
        strategy.tell(steps, order)
        top = found[order[0]]
        best = top if best is None or top.rank < best.rank else best
        bests.append(best.score)
        if strategy.sigma * strategy.lengths.max() < MIN_STEP:
            break
        # A violation may still fall; a run in which all values are unknown has stalled.
        if len(bests) > STALLED + 10 * len(start) // population and not best.violation > TOLERANCE:
            gain = bests[-1 - STALLED] - bests[-1]
            if not gain > MIN_GAIN * abs(bests[-1]):
                break
    return best

"""New samples of a scatter, with which a design and the chains to compare with are verified."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError
from ..validation.objects import Progress
from .measured import measured
from .measures import Measure
from .problem import Design
from .scatter import worst

# Number of new samples, and what is added to the seed of the search.
FRESH: Final = 400
OTHER_SEED: Final = 1_000_003


def sampled_measures(problem: Design) -> list[Measure]:
    """Measures of the motion, which have values in samples."""
    return [m for m in problem.measures if not m.of_chain]


def sampled_values(
    problem: Design, chain: Chain, seed: int, threads: int | None = None,
    progress: Progress | None = None,
) -> Array:  # fmt: skip
    """Values of the measures of the motion in new samples, shape (S, M); none without samples.

    Chains of equal length have the same random numbers.
    """
    scatter, measures = problem.scatter, sampled_measures(problem)
    try:
        chains = scatter._chains(chain, scatter._draws(seed + OTHER_SEED, chain.beads, FRESH))
    except InputError:
        return np.zeros((0, len(measures)))
    return measured(
        chains, measures, until=problem.until, threads=threads, progress=progress
    ).values


def summary_of_samples(problem: Design, sampled: Array) -> dict[str, float]:
    """Mean, CVaR and worst of all measures of the motion."""
    scatter, found = problem.scatter, dict[str, float]()
    if not len(sampled):
        return found
    for measure, values in zip(sampled_measures(problem), sampled.T, strict=True):
        sign = problem.bad_sides[measure]
        for name, tail in (("mean", 0.0), ("CVaR90", 0.1), (scatter.statistic, scatter.tail)):
            found[f"{name} of {measure}"] = float(values[worst(values, sign, tail)].mean())
        found[f"worst of {measure}"] = sign * float((sign * values).max())
    return found

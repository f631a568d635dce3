"""Simulated values of measures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..simulation.simulate_many import DEFAULT_RTOL, simulate_many
from ..validation.numbers import worker_count
from .exact_gradients import value_in_whole_run
from .measures import Measure


def measured(
    chains: Sequence[Chain],
    measures: Sequence[Measure],
    *,
    until: float | None = None,
    rtol: float = DEFAULT_RTOL,
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Array, list[str]]:
    """Values of measures, shape (C, M), and reasons of failed runs; values of prices are NaN."""
    values, reasons = np.full((len(chains), len(measures)), np.nan), list[str]()
    names = sorted({name for each in measures for name in each.columns})
    if names and chains:
        table = simulate_many(
            chains, keep=names, until=until, rtol=rtol, threads=threads, progress=progress
        )
        reasons += table.reasons.values()
    for j, each in enumerate(measures):
        if each.of_chain:
            values[:, j] = [each.from_chain(chain, np.nan) for chain in chains]
        elif each.columns and chains:
            values[:, j] = each.from_table(table)
        elif chains:
            values[:, j] = _in_whole_runs(each, chains, until, rtol, threads)
    return values, reasons


def _in_whole_runs(
    measure: Measure, chains: Sequence[Chain], until: float | None, rtol: float,
    threads: int | None,
) -> list[float]:  # fmt: skip
    """Values of a measure that `simulate_many` does not give."""

    def value(chain: Chain) -> float:
        return value_in_whole_run(measure, chain, until, rtol)

    with ThreadPoolExecutor(worker_count("threads", threads)) as executor:
        return list(executor.map(value, chains))

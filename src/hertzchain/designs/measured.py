"""Simulated values of measures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..simulation.ensemble_columns import Request
from ..simulation.run_table import RunTable
from ..simulation.simulate_many import DEFAULT_RTOL, simulate_ensemble
from ..threads import Threads
from ..validation.numbers import worker_count
from ..validation.objects import Progress
from .exact_gradients import value_in_whole_run
from .measures import Measure, sensors_of


class Measured(NamedTuple):
    """Values (C, M), NaN for prices; reasons of failed runs; the table if one was simulated."""

    values: Array
    reasons: list[str]
    table: RunTable | None


def measured(
    chains: Sequence[Chain],
    measures: Sequence[Measure],
    *,
    until: float | None = None,
    rtol: float = DEFAULT_RTOL,
    threads: int | None = None,
    progress: Progress | None = None,
    check_range: bool = False,
) -> Measured:
    """Simulate chains and collect measures; the range of Hertz's law is checked on request."""
    sensors = sensors_of(measures, chains)
    if sensors and len({chain.beads for chain in chains}) > 1:
        return _by_length(chains, measures, until, rtol, threads)
    values, reasons = np.full((len(chains), len(measures)), np.nan), list[str]()
    table: RunTable | None = None
    names = sorted({name for each in measures for name in each.columns})
    if names and chains:
        request = Request(tuple(names), sensors, until, rtol, None, check_range)
        table = simulate_ensemble(chains, request, threads, progress)
        reasons += table.reasons.values()
    for j, each in enumerate(measures):
        if each.of_chain:
            values[:, j] = [each.from_chain(chain, np.nan) for chain in chains]
        elif each.columns and table is not None:
            values[:, j] = each.from_table(table)
        elif chains:
            values[:, j] = _in_whole_runs(each, chains, until, rtol, threads)
    return Measured(values, reasons, table)


def _by_length(
    chains: Sequence[Chain], measures: Sequence[Measure], until: float | None, rtol: float,
    threads: int | None,
) -> Measured:  # fmt: skip
    """Values of chains of several lengths, whose last beads with sensors are not the same."""
    values, reasons = np.full((len(chains), len(measures)), np.nan), list[str]()
    for beads in sorted({chain.beads for chain in chains}):
        rows = [i for i, chain in enumerate(chains) if chain.beads == beads]
        some = [chains[i] for i in rows]
        found = measured(some, measures, until=until, rtol=rtol, threads=threads)
        values[rows] = found.values
        reasons += found.reasons
    return Measured(values, reasons, None)


def _in_whole_runs(
    measure: Measure, chains: Sequence[Chain], until: float | None, rtol: float,
    threads: int | None,
) -> list[float]:  # fmt: skip
    """Values of a measure that `simulate_many` does not give."""

    def value(chain: Chain) -> float:
        return value_in_whole_run(measure, chain, until, rtol)

    with Threads(worker_count("threads", threads)) as executor:
        return list(executor.map(value, chains))

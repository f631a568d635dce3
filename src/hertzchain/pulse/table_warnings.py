"""Warnings about tables of many chains: one for those that failed, one for Hertz's limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..chain.hertz_range import hertz_range
from ..chain.hertz_ratios import exceeds_limits
from ..chain.hertz_warnings import violations_of
from ..errors import IncompleteWarning, ModelRangeWarning, warn_user
from .pulse_table import PulseTable


def warn_failed(chains: int, reasons: Mapping[int, str]) -> None:
    """Warn once if some chains of a table have no values."""
    if reasons:
        first = min(reasons)
        warn_user(
            f"{len(reasons)} of {chains} chains failed and have no values; in the first of them, "
            f"chain {first}, {reasons[first]}",
            IncompleteWarning,
        )


def warn_exceeded(method: str, chains: int, rows: Sequence[int], violation: str) -> None:
    """Warn once about rows that exceed limits of Hertz's law, with a violation of the first."""
    warn_user(
        f"{method}: {len(rows)} of {chains} chains exceed the limits of Hertz's law; in the first "
        f"of them, chain {rows[0]}, {violation}",
        ModelRangeWarning,
    )


def warn_outside_hertz_once(table: PulseTable) -> None:
    """Warn once if chains in SI units have exceeded the limits of Hertz's law."""
    exceeded = []
    for row, chain in enumerate(table.chains):
        if chain is None or chain.units != "SI" or chain.materials is None:
            continue
        if row not in table.reasons:
            overlaps = table.peak_overlap[row, : chain.beads - 1]
            if exceeds_limits(chain, np.pad(overlaps, 1)):
                exceeded.append(row)
    if exceeded:
        chain = table.chains[exceeded[0]]
        assert chain is not None
        overlaps = table.peak_overlap[exceeded[0], : chain.beads - 1]
        found = violations_of("propagation", hertz_range(chain, overlaps))
        warn_exceeded("propagation", len(table), exceeded, found[0])

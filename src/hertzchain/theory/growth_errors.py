"""Errors of the local-rate law that accumulate along a chain.

The constants of the error estimate were determined on chains of about 100 beads.  In longer ones
two errors accumulate that these do not contain: that of the growth per bead, which is tabulated as
a function of the rate, and that of the response to further changes of rates near 0, where the
first order of the law is smoothed.  If the tables are interpolated between exponents, the error of
the growth depends so much on the exponent that it is added from the first contact on.
"""

from __future__ import annotations

import csv
import functools
from importlib import resources
from pathlib import Path
from typing import Final

import numpy as np

from ..collision import Array
from .exponents import shrink_of
from .universal_functions import UniversalFunctions

# Exponents with tables that are not interpolated.
OWN_TABLES: Final = (1.5, 2.0)
# Ends of the intervals of rates; the last number ends the rates at which long chains are possible.
EDGES: Final = (
    -0.165, -0.1575, -0.15, -0.1425, -0.135, -0.1275, -0.12, -0.1125, -0.105, -0.0975, -0.09,
    -0.0825, -0.075, -0.0675, -0.06, -0.0525, -0.045, -0.0375, -0.03, -0.0225, -0.015, -0.0075,
    -0.002, 0.002, 0.0075, 0.015, 0.0225, 0.03, 0.045, 0.06, 0.09, 0.12, 0.15, 0.1828, 0.2155,
    0.2483, 0.281, 0.3466, 0.4121, 0.5103,
)  # fmt: skip
# Number of contacts whose errors the constants of the estimate contain, without interpolation.
COVERED: Final = 100
# Error of the response to a change of the rate, relative to the constant of the error near the rate
# 0 and for at most this constant, which is larger where it contains errors of the interpolation
# between exponents; size of rates beyond which the first order is not smoothed.
OF_CHANGE, MAX_CONSTANT, SMOOTHED = 250.0, 4.24e-5, 0.015
# Index of this constant.
SLOW: Final = 1
# Of interpolated tables: exponent up to which beads at the free end and all beads may lose their
# first maximum, as fractions of the lowest rate below which the last two and all others may, and
# the fraction within which the error becomes unknown.  The interpolation is between exponents with
# and without this maximum.
LOST_TWO_UP_TO, LOST_ALL_UP_TO, LOST_TWO, LOST_ALL, RAMP = 1.65, 1.85, 0.81, 0.9, 0.01
# Contacts before the last two whose rates affect these beads, and an error that is unknown.
BEFORE_END, UNKNOWN = 3, 2.0


def covered(exponent: float) -> int:
    """Number of contacts whose errors of the growth the constants of the estimate contain."""
    return COVERED if exponent in OWN_TABLES else 0


def add_accumulated(errors: Array, slow: Array, functions: UniversalFunctions) -> None:
    """Add the accumulated errors to the estimated relative errors behind each contact."""
    if len(errors) > covered(functions.exponent):
        errors += (1.0 + errors) * np.expm1(accumulated_errors(slow, functions))


def add_lost_maxima(errors: Array, slow: Array, exponent: float) -> None:
    """Make errors unknown, behind contacts of all slow rates, where first maxima may be lost."""
    if exponent in OWN_TABLES or exponent > LOST_ALL_UP_TO:
        return
    lowest = edges_of(exponent)[0]
    behind = np.minimum.accumulate(slow)[: len(errors)]
    errors += UNKNOWN * _doubt(behind / lowest, LOST_ALL)
    at_end = slice(len(slow) - 2, None)
    if exponent <= LOST_TWO_UP_TO:
        errors[at_end] += UNKNOWN * _doubt(slow[-2 - BEFORE_END :].min() / lowest, LOST_TWO)


def _doubt(fraction: Array | float, start: float) -> Array:
    """Doubt about maxima that may be lost beyond a fraction of the lowest rate: 0 to 1."""
    return np.clip((np.asarray(fraction) - start) / RAMP, 0.0, 1.0) ** 2


def accumulated_errors(slow: Array, functions: UniversalFunctions) -> Array:
    """Errors of ln v that accumulate behind each contact, from slow rates."""
    errors, first = np.zeros(len(slow)), covered(functions.exponent)
    errors[first:] = np.cumsum(errors_per_bead(slow[first:], functions.exponent))
    near = np.clip(slow[COVERED - 1 :], -SMOOTHED, SMOOTHED)
    size = OF_CHANGE * min(functions.error[SLOW], MAX_CONSTANT)
    errors[COVERED:] += size * np.abs(near[1:] - near[:1])
    return errors


def errors_per_bead(rates: Array, exponent: float) -> Array:
    """Errors of the growth per bead; those beyond the table are those at its ends."""
    edges = edges_of(exponent)
    interval = np.clip(np.searchsorted(edges, rates, "right") - 1, 0, len(edges) - 2)
    return _errors_of(exponent)[interval]


def edges_of(exponent: float) -> Array:
    """Ends of the intervals of an exponent: negative rates are those of its tables."""
    edges = np.array(EDGES)
    if exponent in OWN_TABLES:
        return edges
    return np.where(edges < 0.0, shrink_of(exponent) * edges, edges)


@functools.lru_cache(maxsize=32)
def _errors_of(exponent: float) -> Array:
    """Errors in each interval: between two tabulated exponents, the larger ones."""
    exponents, errors = _table()
    if exponent in OWN_TABLES:
        return np.asarray(errors[np.argmin(np.abs(exponents - exponent))])
    interpolated = ~np.isin(exponents, OWN_TABLES)
    exponents, errors = exponents[interpolated], errors[interpolated]
    above = int(np.clip(np.searchsorted(exponents, exponent), 1, len(exponents) - 1))
    return np.asarray(np.maximum(errors[above - 1], errors[above]))


@functools.cache
def _table() -> tuple[Array, Array]:
    """Exponents, and the errors in each interval."""
    with table_file().open(encoding="utf-8", newline="") as lines:
        _, *rows = csv.reader(line for line in lines if not line.startswith("#"))
    values = np.array(rows, dtype=float)
    return values[:, 0], values[:, 1:]


def table_file() -> Path:
    """File of the table."""
    return Path(str(resources.files("hertzchain.theory"))) / "growth_errors.csv"

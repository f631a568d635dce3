r"""Universal functions of the local-rate law, read from their tables.

The *rate* of contact k is :math:`s_k = \ln(R_{k+1}/R_k)`.  The *state* :math:`z_k` of the pulse at
this contact consists of three dimensionless numbers of order one:

.. math::

    \rho_k = \ln\frac{v_{k+1}}{v_k}, \qquad
    \varphi_k = \ln\frac{F_k}{r_k^{1/(p+1)} (m_k v_k^2)^{p/(p+1)}}, \qquad
    \tau_k = \ln\frac{T_k}{(m_k/r_k)^{1/(p+1)}\, v_k^{-(p-1)/(p+1)}}

These are the logarithms of the velocity ratio, and of the peak force and residence time made
dimensionless with the mass and velocity of bead k and the stiffness of contact k.  Contacts
are divided into *stages*: those after the impact, and those within the chain.  For each stage,
`tools/training` determines the state on an exponential chain as a function of its rate, and the
response to differences between rates.  Further tables contain the response to fast changes of the
rate, and the effect of the free end on the last contacts.
"""

from __future__ import annotations

import csv
import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import resources
from itertools import combinations_with_replacement
from pathlib import Path
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array, velocity_transfer
from ..errors import InputError
from ..kernels.law_tables import FastTables, SlowTables
from ..pulse.pulse import Pulse
from . import exponents
from .packed_tables import STEPS, unpack

STATE: Final = ("growth", "force", "time")
# Number of contacts that depend on the impact.
START: Final = 4
STAGES: Final = ("start 1", "start 2", "start 3", "start 4", "within")
WITHIN: Final = START
# Stage whose anchor is subtracted from the previous state; the first stage has no previous one.
REFERENCES: Final = (0, 0, 1, 2, WITHIN)
# Inputs of the response: the deviation of the previous state from that of an exponential chain,
# and the differences between the rates of five neighbouring contacts.
INPUTS: Final = (
    *(f"{name} before" for name in STATE),
    "s[k-1]-s[k-2]",
    "s[k]-s[k-1]",
    "s[k+1]-s[k]",
    "s[k+2]-s[k+1]",
)
# The response is of second order: it contains all inputs and all products of two inputs.
PAIRS: Final = tuple(combinations_with_replacement(range(len(INPUTS)), 2))
TERMS: Final = INPUTS + tuple(f"({INPUTS[i]})({INPUTS[j]})" for i, j in PAIRS)
# Tables of fast changes, as functions of the rate.
FAST_VALUES: Final = (
    "single", "early", "end", "end_slopes", "short", "second", "last", "alternating"
)  # fmt: skip
# Arguments of the tables of fast changes.
FAST_ARGUMENTS: Final = ("places", "knots", "last_knots", "bases", "steady")
NOTHING: Final = np.zeros(0)
MIN_BEADS: Final = 9


@dataclass(frozen=True, eq=False)
class UniversalFunctions:
    r"""Functions of the rate s as piecewise cubic polynomials with continuous second derivatives.

    Attributes
    ----------
    exponent : float
        Exponent p of the contact force.
    nodes : ndarray, shape (n + 1,)
        Ends of the intervals of the `anchors`.
    anchors : ndarray, shape (stages, n, 12)
        State of each stage on an exponential chain.  The entries are the coefficients of the
        powers 3, 2, 1, 0 of the distance from the left end of the interval, each for the three
        components of the state.
    knots : ndarray, shape (K + 1,)
        Ends of the intervals of the `response`.
    response : ndarray, shape (stages, K, 4, 108)
        Polynomials, as for the anchors, of the coefficients of the `TERMS`, followed by 0, for
        each of the three components.
    fast : FastTables
        Responses to fast changes and to the free end.
    error : ndarray, shape (16,)
        Constants of the error estimate; see `hertzchain.theory.local_rate.Solution`.
    """

    exponent: float
    nodes: Array
    anchors: Array
    knots: Array
    response: Array
    fast: FastTables
    error: Array

    @property
    def slow(self) -> SlowTables:
        """Tables of the recursion along the slow rates."""
        return SlowTables(self.nodes, self.anchors, self.knots, self.response)

    @functools.cached_property
    def arrays(self) -> tuple[Array | float, ...]:
        """All tables, as an argument of kernels."""
        return *self.slow, *self.fast

    @property
    def range(self) -> tuple[float, float]:
        """Smallest and largest rate of the tables."""
        return float(self.nodes[0]), float(self.nodes[-1])

    def on_exponential_chains(self, rate: float, stage: int) -> Array:
        """State of a stage on exponential chains of a rate inside the tables."""
        piece = min(int(np.searchsorted(self.nodes, rate, "right")), len(self.nodes) - 1) - 1
        powers = (rate - self.nodes[piece]) ** np.arange(3.0, -1.0, -1.0)
        return np.asarray(powers @ self.anchors[stage, piece].reshape(4, len(STATE)))


def state(pulse: Pulse) -> Array:
    r"""State :math:`(\rho_k, \varphi_k, \tau_k)` of every contact of a pulse."""
    assert pulse.peak_force is not None
    assert pulse.residence is not None
    scales = log_scales(pulse.chain, np.log(pulse.velocity))
    growth = np.diff(np.log(pulse.velocity))
    # Residence times are negative if beads peak out of order; the law does not describe this.
    force, time = np.log(pulse.peak_force), np.log(np.abs(pulse.residence))
    return np.stack([growth, force - scales[0], time - scales[1]], axis=-1)


def log_scales(chain: Chain, log_velocity: Array) -> tuple[Array, Array]:
    r"""Logarithms of the units of force and time formed from mass, velocity and stiffness."""
    of = powers(chain.exponents)
    scaled = np.log(chain.masses[:-1]), log_velocity[:-1], np.log(chain.stiffness)
    force, time = (of[name][:3] @ scaled for name in ("peak_force", "residence"))
    return force, time


@functools.cache
def powers(exponent: float) -> dict[str, Array]:
    r"""Exponents of the power products that give each quantity.

    .. math:: \ln Q_k = a\ln m_k + b\ln v_k + c\ln r_k + d\,\varphi_k + e\,\tau_k
    """
    p = exponent
    listed = {
        "velocity": (0.0, 1.0, 0.0, 0.0, 0.0),
        "momentum": (1.0, 1.0, 0.0, 0.0, 0.0),
        "energy": (1.0, 2.0, 0.0, 0.0, 0.0),
        "peak_force": (p / (p + 1.0), 2.0 * p / (p + 1.0), 1.0 / (p + 1.0), 1.0, 0.0),
        "peak_overlap": (1.0 / (p + 1.0), 2.0 / (p + 1.0), -1.0 / (p + 1.0), 1.0 / p, 0.0),
        "residence": (1.0 / (p + 1.0), -(p - 1.0) / (p + 1.0), -1.0 / (p + 1.0), 0.0, 1.0),
    }
    return {name: np.array(numbers) for name, numbers in listed.items()}


def bca_growth(rate: Array) -> Array:
    r"""Growth of the velocity per bead in the BCA, :math:`\ln[2/(1 + e^{3s})]`, Eq. (5)."""
    return np.log(velocity_transfer(1.0, np.exp(3.0 * np.asarray(rate))))


def cubic_pieces(knots: Array, coefficients: Array) -> Array:
    """Convert a cubic spline to polynomials on its intervals."""
    from scipy.interpolate import BSpline

    spline = BSpline(padded_knots(knots), coefficients, 3)
    # Taylor coefficients at the left end of each interval.
    powers = [spline(knots[:-1], nu=power) / math.factorial(power) for power in (3, 2, 1, 0)]
    return np.stack(powers, axis=1)


def padded_knots(knots: Array) -> Array:
    """Knots with the outer ones repeated four times, as required by cubic B-splines."""
    return np.concatenate([[knots[0]] * 3, knots, [knots[-1]] * 3])


def table_folder(exponent: float) -> Path:
    """Folder of the tables for an exponent, which need not exist."""
    return Path(str(resources.files("hertzchain.theory"))) / "universal_tables" / f"p{exponent:g}"


def assemble(
    exponent: float,
    nodes: Array,
    values: Array,
    knots: Array,
    coefficients: Array,
    fast: dict[str, Array],
    error: Array,
) -> UniversalFunctions:
    """Build universal functions from the numbers in their tables."""
    from scipy.interpolate import CubicSpline

    # Tables contain the growth beyond that of the BCA.
    values = values.copy()
    values[..., 0] += bca_growth(nodes)[:, None]
    spline = CubicSpline(nodes, values)
    pieces = cubic_pieces(knots, np.moveaxis(coefficients, 2, 0))
    # From (powers, intervals, stages, states).
    anchors = np.einsum("pist->sipt", spline.c).reshape(len(STAGES), len(nodes) - 1, -1)
    # The kernels are compiled once, for contiguous arrays.
    nodes, anchors = np.ascontiguousarray(nodes), np.ascontiguousarray(anchors)
    slow = nodes, anchors, knots, _side_by_side(pieces)
    return UniversalFunctions(exponent, *slow, fast_tables(exponent, slow, **fast), error)


def fast_tables(
    exponent: float, slow: tuple[Array, Array, Array, Array], places: Array, single: Array,
    end: Array, end_slopes: Array, knots: Array, second: Array,
    last_knots: Array = NOTHING, last: Array = NOTHING, short: Array = NOTHING,
    early: Array | None = None,
    bases: Array = NOTHING, alternating: Array = NOTHING, steady: Array | None = None,
) -> FastTables:  # fmt: skip
    """Build the tables of fast changes, and of the first order that the recursion misses.

    Values at the places are ``single`` (n + 1, 18, 48), ``early`` (n + 1, 12, 3), the states of
    the first contacts on exponential chains, ``end`` (n + 1, 5, 51), and ``end_slopes``,
    the derivatives of those of exponential chains, (n + 1, 5, 3), and ``short`` (n + 1, 33, 24),
    what the impact leaves at the last contacts of short chains.  ``second`` (K + 3, 1890) and
    ``last`` (L + 3, 552) are coefficients of B-splines, ``alternating`` (B + 1, 18, 36) values at
    the bases.  Without ``early``, the tables belong to a recursion whose first order is not
    completed.  Without ``last``, the last contacts have no separate functions.
    """
    from scipy.interpolate import Akima1DInterpolator, CubicHermiteSpline, CubicSpline

    from .end_response import end_tables
    from .linear_response import missing_response, pieces_of

    # Near the free end of steep forward tapers, functions of the rate have kinks: there,
    # interpolation must be local.
    pieces = CubicSpline(places, single).c
    at_end = slice(len(single[0]) - len(end[0]), None)
    pieces[:, :, at_end] = Akima1DInterpolator(places, single[:, at_end]).c
    of_end = Akima1DInterpolator(places, end).c
    # The first number of each component is the state on an exponential chain.
    each = slice(None, None, end.shape[2] // len(STATE))
    of_end[..., each] = CubicHermiteSpline(places, end[..., each], end_slopes).c
    by_state = single.reshape(*single.shape[:2], len(STATE), -1)
    missing = np.zeros((len(places), single.shape[1] - end.shape[1], len(STATE), end.shape[2] // 3))
    if early is not None:
        missing = missing_response(slow, places, by_state, early)
    rest = pieces_of(places, missing)
    # The effect of the free end is a difference from the response within.
    rest = np.concatenate([rest, rest[-1] + np.transpose(of_end, (2, 1, 0, 3))])
    return FastTables(
        places=places,
        first=_first_order(np.transpose(pieces, (2, 1, 0, 3)), rest),
        knots=knots,
        second=_by_stage(cubic_pieces(knots, second)),
        last_knots=last_knots,
        last=_by_contact(last_knots, last),
        **end_tables(slow, places, single, end, end_slopes, early, short if len(last) else NOTHING),
        steady=exponents.steady_gain(exponent) if steady is None else float(steady),
        bases=bases,
        alternating=_alternating(bases, alternating),
    )


def _first_order(single: Array, rest: Array) -> Array:
    """Responses to fast changes and slow steps side by side, and missing states."""
    from ..kernels.fast_changes import COLUMNS

    by_state = [each.reshape(*each.shape[:3], len(STATE), -1) for each in (single, rest)]
    taps = by_state[0].shape[-1]
    found = np.zeros((*by_state[0].shape[:-1], COLUMNS))
    found[..., :taps], found[..., taps : 2 * taps] = by_state[0], by_state[1][..., 1:]
    found[..., 2 * taps] = by_state[1][..., 0]
    return found.reshape(*single.shape[:3], -1)


def _by_stage(pieces: Array) -> Array:
    """Products of fast changes of each stage, (stages, intervals, 4, 108).

    A table of the products of two fast changes only is that of all stages.
    """
    from ..kernels.fast_changes import COLUMNS, PAIRS, STAGES

    intervals, powers = pieces.shape[:2]
    stages = 1 if pieces.shape[-1] == len(STATE) * PAIRS else STAGES
    by_state = pieces.reshape(intervals, powers, stages, len(STATE), -1)
    padded = np.zeros((intervals, powers, STAGES, len(STATE), COLUMNS))
    padded[..., : by_state.shape[-1]] = by_state
    by_stage = padded.reshape(intervals, powers, STAGES, -1)
    return np.ascontiguousarray(np.moveaxis(by_stage, 2, 0))


def _by_contact(knots: Array, coefficients: Array) -> Array:
    """Coefficients of each of the last contacts, (contacts, intervals, 4, 138)."""
    from ..kernels.last_contacts import LAST as CONTACTS

    if not len(coefficients):
        return np.zeros((0, 0, 4, 0))
    pieces = cubic_pieces(knots, coefficients)
    by_contact = pieces.reshape(*pieces.shape[:2], CONTACTS, -1)
    return np.ascontiguousarray(np.moveaxis(by_contact, 2, 0))


def _alternating(bases: Array, values: Array) -> Array:
    """Cubic polynomials, (stages, intervals, 4, 36), of the effect of alternating rates."""
    from scipy.interpolate import CubicSpline

    if not len(bases):
        return np.zeros((0, 0, 4, 0))
    return np.ascontiguousarray(
        np.transpose(CubicSpline(bases, values, bc_type="clamped").c, (2, 1, 0, 3))
    )


def _side_by_side(pieces: Array) -> Array:
    """Coefficients of the terms of each component, from (intervals, powers, stages, terms, states).

    A zero follows those of each component, to make their number a multiple of four.
    """
    intervals, powers, stages, terms, states = pieces.shape
    found = np.zeros((stages, intervals, powers, states, terms + 1))
    found[..., :terms] = np.transpose(pieces, (2, 0, 1, 4, 3))
    return found.reshape(stages, intervals, powers, -1)


# A sweep may have many exponents.
@functools.lru_cache(maxsize=32)
def universal_functions(exponent: float) -> UniversalFunctions:
    """Universal functions of an exponent, from the tables of the package."""
    folder = table_folder(exponent)
    if folder.is_dir():
        return read_tables(folder, exponent)
    if not exponents.LOWEST <= exponent <= exponents.HIGHEST:
        raise InputError(
            f"the local-rate law has no tables for the exponent {exponent:g}, only for those from "
            f"{exponents.LOWEST:g} to {exponents.HIGHEST:g}; use propagate"
        )
    return functions_of(exponent, exponents.interpolated_tables(folder.parent, exponent))


def functions_of(exponent: float, of: dict[str, Array]) -> UniversalFunctions:
    """Universal functions from interpolated tables."""
    names = "places", "single", "early", "end", "end_slopes", "second"
    fast = {name: of[name] for name in names}
    fast |= {"knots": of["fast_knots"]}
    return assemble(
        exponent, of["nodes"], of["values"], of["knots"], of["response"], fast, of["error"]
    )


def read_tables(folder: Path, exponent: float) -> UniversalFunctions:
    """Read universal functions from a folder of tables."""
    nodes, columns = _numbers(folder / "exponential.csv")
    values = columns.reshape(len(nodes), len(STAGES), len(STATE))
    knots, coefficients = read_response(folder / "response.csv")
    with np.load(folder / "fast.npz") as stored:
        of = {name: unpack(stored[name], STEPS[name], 0) for name in FAST_VALUES}
        arguments = {name: stored[name] for name in FAST_ARGUMENTS}
    first, others = _numbers(folder / "error.csv")
    error = np.concatenate([first, others[0]])
    return assemble(exponent, nodes, values, knots, coefficients, of | arguments, error)


def _rows(file: Path) -> Iterator[list[str]]:
    """Rows of a table without its comments."""
    with file.open(encoding="utf-8", newline="") as lines:
        yield from csv.reader(line for line in lines if not line.startswith("#"))


def _numbers(file: Path) -> tuple[Array, Array]:
    """First column and other columns of a table with one header line."""
    _, *rows = _rows(file)
    values = np.array(rows, dtype=float)
    return values[:, 0], values[:, 1:]


def read_response(file: Path) -> tuple[Array, Array]:
    """Knots and coefficients, shape (stages, terms, splines, states); zero if not listed."""
    names, knots, *rows = _rows(file)
    coefficients = np.zeros((len(STAGES), len(TERMS), len(names) - 3, len(STATE)))
    for stage, state, term, *values in rows:
        at = STAGES.index(stage), TERMS.index(term), slice(None), STATE.index(state)
        coefficients[at] = [float(value) for value in values]
    return np.array([float(knot) for knot in knots[3:] if knot]), coefficients

r"""The universal functions of the local-rate law: what they are, read from their tables.

The *rate* of contact k is :math:`s_k = \ln(R_{k+1}/R_k)`.  What a pulse does at that contact
is three numbers of order one that do not depend on units, the *state* :math:`z_k`:

.. math::

    \rho_k = \ln\frac{v_{k+1}}{v_k}, \qquad
    \varphi_k = \ln\frac{F_k}{r_k^{1/(p+1)} (m_k v_k^2)^{p/(p+1)}}, \qquad
    \tau_k = \ln\frac{T_k}{(m_k/r_k)^{1/(p+1)}\, v_k^{-(p-1)/(p+1)}}

growth of velocity, peak force and residence time, the last two in the units that mass,
stiffness and velocity of bead k make up.  `hertzchain.training` finds, for each *stage* (the
contacts after the strike, those within, those before the free end), the state on an
exponential chain as a function of its one rate, and the response to differences.
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

from hertzchain.chain.chain import Chain
from hertzchain.contacts import Array, velocity_transfer
from hertzchain.errors import InputError
from hertzchain.pulse.pulse import Pulse

STATE: Final = ("growth", "force", "time")
# Contacts 1..4 feel how the pulse was made, the last three that the chain ends.
START: Final = 4
END: Final = 3
STAGES: Final = ("start 1", "start 2", "start 3", "start 4", "within", "end 3", "end 2", "end 1")
WITHIN: Final = START
# The stage from whose anchor the state before is measured; the first has none before it.
REFERENCES: Final = (0, 0, 1, 2, WITHIN, WITHIN, 5, 6)
# What a state responds to: how far the state before was from an exponential chain's, and
# the differences between the rates of five neighbouring contacts.
INPUTS: Final = (
    *(f"{name} before" for name in STATE),
    "s[k-1]-s[k-2]",
    "s[k]-s[k-1]",
    "s[k+1]-s[k]",
    "s[k+2]-s[k+1]",
)
# The response is of second degree: each input, and each product of two.
PAIRS: Final = tuple(combinations_with_replacement(range(len(INPUTS)), 2))
TERMS: Final = INPUTS + tuple(f"({INPUTS[i]})({INPUTS[j]})" for i, j in PAIRS)
FEWEST_BEADS: Final = START + END + 2


@dataclass(frozen=True, eq=False)
class UniversalFunctions:
    r"""Functions of the rate s as piecewise cubic polynomials, continuous to the second derivative.

    Attributes
    ----------
    exponent : float
        Exponent p of the contact force.
    nodes : ndarray, shape (n + 1,)
        Ends of the intervals of the `anchors`.
    anchors : ndarray, shape (stages, n, 12)
        The state of each stage on an exponential chain, growth as excess over that of the BCA:
        coefficients of the powers 3, 2, 1, 0 of the distance from the interval's left end, each
        for the three components of the state.
    knots : ndarray, shape (K + 1,)
        Ends of the intervals of the `response`.
    response : ndarray, shape (stages, K, 4, 192)
        The same for the symmetric matrices :math:`A(s)` of the response :math:`y^T A y`,
        y a one and the `INPUTS`: for each power the rows of all three components side by side,
        shape (8, 3, 8).
    error : ndarray, shape (4,)
        Constants of the estimated error, see `hertzchain.theory.local_rate.Solution`.
    """

    exponent: float
    nodes: Array
    anchors: Array
    knots: Array
    response: Array
    error: Array

    @property
    def tables(self) -> tuple[Array, Array, Array, Array]:
        """Nodes, anchors, knots and response, as the kernel takes them."""
        return self.nodes, self.anchors, self.knots, self.response

    @property
    def range(self) -> tuple[float, float]:
        """Smallest and largest rate that the functions were found for."""
        return float(self.nodes[0]), float(self.nodes[-1])


def state(pulse: Pulse) -> Array:
    r"""State :math:`(\rho_k, \varphi_k, \tau_k)` of every contact of a pulse.

    Parameters
    ----------
    pulse : Pulse
        Of an integration.

    Returns
    -------
    ndarray, shape (N - 1, 3)

    Examples
    --------
    >>> import hertzchain as hc
    >>> state(hc.propagate(hc.Chain.uniform(30)))[20].round(4)
    array([-0.    ,  0.0129,  0.0971])
    """
    assert pulse.peak_force is not None
    assert pulse.residence is not None
    scales = log_scales(pulse.chain, np.log(pulse.velocity))
    growth = np.diff(np.log(pulse.velocity))
    # A residence is negative where beads peak out of order, which the law does not cover.
    force, time = np.log(pulse.peak_force), np.log(np.abs(pulse.residence))
    return np.stack([growth, force - scales[0], time - scales[1]], axis=-1)


def log_scales(chain: Chain, log_velocity: Array) -> tuple[Array, Array]:
    r"""Logarithms of the units of force and of time that a moving bead and its contact make up.

    Parameters
    ----------
    chain : Chain
        The chain.
    log_velocity : ndarray, shape (N,)
        :math:`\ln v_k`.

    Returns
    -------
    tuple of ndarray
        Of force and of time [scaled], both of shape (N - 1,).

    Examples
    --------
    >>> import hertzchain as hc
    >>> force, time = log_scales(hc.Chain.uniform(3), np.log([1.0, 1.0, 1.0]))
    >>> force.tolist(), time.tolist()
    ([0.0, 0.0], [0.0, 0.0])
    """
    of = powers(chain.exponent)
    scaled = np.log(chain.masses[:-1]), log_velocity[:-1], np.log(chain.stiffness)
    force, time = (of[name][:3] @ scaled for name in ("peak_force", "residence"))
    return force, time


@functools.cache
def powers(exponent: float) -> dict[str, Array]:
    r"""What the quantities are products of powers of.

    .. math:: \ln Q_k = a\ln m_k + b\ln v_k + c\ln r_k + d\,\varphi_k + e\,\tau_k

    Parameters
    ----------
    exponent : float
        Exponent p of the contact force.

    Returns
    -------
    dict
        Of :math:`(a, b, c, d, e)` by name; the energy without its one half.

    Examples
    --------
    >>> powers(1.5)["residence"]
    array([ 0.4, -0.2, -0.4,  0. ,  1. ])
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
    r"""Growth of velocity per bead by the BCA, :math:`\ln[2/(1 + e^{3s})]`, Eq. (5).

    Parameters
    ----------
    rate : ndarray
        Rate s of a contact.

    Returns
    -------
    ndarray

    Examples
    --------
    >>> float(bca_growth(np.array(0.0)))
    0.0
    """
    return np.log(velocity_transfer(1.0, np.exp(3.0 * np.asarray(rate))))


def cubic_pieces(knots: Array, coefficients: Array) -> Array:
    """A cubic spline as polynomials on its intervals.

    Parameters
    ----------
    knots : ndarray, shape (K + 1,)
        Ends of the intervals; the spline's knots are these, the outer ones fourfold.
    coefficients : ndarray, shape (K + 3, ...)
        Coefficients of its B-splines.

    Returns
    -------
    ndarray, shape (K, 4, ...)
        Coefficients of the powers 3, 2, 1, 0 of the distance from the interval's left end.

    Examples
    --------
    The B-splines sum up to one:

    >>> cubic_pieces(np.array([0.0, 1.0, 2.0]), np.ones(5))[:, 3]
    array([1., 1.])
    """
    from scipy.interpolate import BSpline

    spline = BSpline(padded_knots(knots), coefficients, 3)
    # By Taylor: the derivatives at the left end of each interval.
    powers = [spline(knots[:-1], nu=power) / math.factorial(power) for power in (3, 2, 1, 0)]
    return np.stack(powers, axis=1)


def padded_knots(knots: Array) -> Array:
    """The knots with the outer ones fourfold, as B-splines of third degree want them.

    Parameters
    ----------
    knots : ndarray, shape (K + 1,)
        Ends of the intervals.

    Returns
    -------
    ndarray, shape (K + 7,)

    Examples
    --------
    >>> padded_knots(np.array([0.0, 1.0]))
    array([0., 0., 0., 0., 1., 1., 1., 1.])
    """
    return np.concatenate([[knots[0]] * 3, knots, [knots[-1]] * 3])


def tables(exponent: float) -> Path:
    """The folder of the tables for an exponent; it need not exist.

    Parameters
    ----------
    exponent : float
        Exponent p of the contact force.

    Returns
    -------
    pathlib.Path

    Examples
    --------
    >>> tables(1.5).name
    'p1.5'
    """
    return Path(str(resources.files("hertzchain.theory"))) / "universal_tables" / f"p{exponent:g}"


def assembled(
    exponent: float, nodes: Array, values: Array, knots: Array, coefficients: Array, error: Array
) -> UniversalFunctions:
    """Universal functions as polynomials, from what their tables list.

    Parameters
    ----------
    exponent : float
        Exponent p of the contact force.
    nodes, values : ndarray, shapes (n + 1,) and (n + 1, stages, 3)
        Rates, and the states on exponential chains of these rates.
    knots, coefficients : ndarray, shapes (K + 1,) and (stages, terms, K + 3, 3)
        Knots, and the coefficients of the responses' B-splines.
    error : ndarray, shape (4,)
        Constants of the estimated error.

    Returns
    -------
    UniversalFunctions

    Examples
    --------
    Used by `read_tables` and by `hertzchain.training`.
    """
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(nodes, values)
    pieces = cubic_pieces(knots, np.moveaxis(coefficients, 2, 0))
    # From (powers, intervals, stages, states).
    anchors = np.einsum("pist->sipt", spline.c).reshape(len(STAGES), len(nodes) - 1, -1)
    return UniversalFunctions(
        exponent=exponent,
        nodes=nodes,
        anchors=np.ascontiguousarray(anchors),
        knots=knots,
        response=_matrices(pieces),
        error=error,
    )


def _matrices(pieces: Array) -> Array:
    """Symmetric matrices of the responses, from (intervals, powers, stages, terms, states).

    A product of two inputs stands in both places of the matrix, half in each; so does an
    input, which is its product with one.
    """
    intervals, powers, stages, _, states = pieces.shape
    side = 1 + len(INPUTS)
    found = np.zeros((stages, intervals, powers, side, states, side))
    ends = [(0, 1 + i) for i in range(len(INPUTS))] + [(1 + i, 1 + j) for i, j in PAIRS]
    for term, (i, j) in enumerate(ends):
        half = 0.5 * np.einsum("ipst->sipt", pieces[:, :, :, term])
        found[:, :, :, i, :, j] += half
        found[:, :, :, j, :, i] += half
    return found.reshape(stages, intervals, powers, -1)


@functools.cache
def universal_functions(exponent: float) -> UniversalFunctions:
    """The universal functions of an exponent, from the tables in the package.

    Parameters
    ----------
    exponent : float
        Exponent p of the contact force; there are tables for 1.5 and 2.

    Returns
    -------
    UniversalFunctions

    Raises
    ------
    InputError
        If there are none for it.

    Examples
    --------
    >>> universal_functions(1.5).range
    (-0.165, 1.1)
    """
    folder = tables(exponent)
    if not folder.is_dir():
        known = sorted(entry.name[1:] for entry in tables(1.5).parent.iterdir())
        raise InputError(
            f"the local-rate law has no tables for the exponent {exponent:g}, only for "
            f"{' and '.join(known)}; use propagate"
        )
    return read_tables(folder, exponent)


def read_tables(folder: Path, exponent: float) -> UniversalFunctions:
    """The universal functions from a folder of tables.

    Parameters
    ----------
    folder : Path
        Folder of ``exponential.csv``, ``response.csv`` and ``error.csv``.
    exponent : float
        The exponent that they belong to.

    Returns
    -------
    UniversalFunctions

    Examples
    --------
    >>> read_tables(tables(1.5), 1.5).knots.size
    13
    """
    nodes, columns = _numbers(folder / "exponential.csv")
    values = columns.reshape(len(nodes), len(STAGES), len(STATE))
    knots, coefficients = _response(folder / "response.csv")
    first, others = _numbers(folder / "error.csv")
    error = np.concatenate([first, others[0]])
    return assembled(exponent, nodes, values, knots, coefficients, error)


def _rows(file: Path) -> Iterator[list[str]]:
    """Rows of a table without its comments."""
    with file.open(encoding="utf-8", newline="") as lines:
        yield from csv.reader(line for line in lines if not line.startswith("#"))


def _numbers(file: Path) -> tuple[Array, Array]:
    """First column and the others of a table with one line of names."""
    _, *rows = _rows(file)
    values = np.array(rows, dtype=float)
    return values[:, 0], values[:, 1:]


def _response(file: Path) -> tuple[Array, Array]:
    """Knots and coefficients, shape (stages, terms, splines, states), zero where not listed."""
    names, knots, *rows = _rows(file)
    coefficients = np.zeros((len(STAGES), len(TERMS), len(names) - 3, len(STATE)))
    for stage, state, term, *values in rows:
        at = STAGES.index(stage), TERMS.index(term), slice(None), STATE.index(state)
        coefficients[at] = [float(value) for value in values]
    return np.array([float(knot) for knot in knots[3:] if knot]), coefficients

"""Tables of the local-rate law, as kernels use them."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]


class SlowTables(NamedTuple):
    """The recursion along the slow rates, as piecewise cubic polynomials.

    The attributes are those of `hertzchain.theory.universal_functions.UniversalFunctions`.
    """

    nodes: Array
    anchors: Array
    knots: Array
    response: Array


class FastTables(NamedTuple):
    """Responses to fast changes and to the free end, as piecewise cubic polynomials.

    See `hertzchain.kernels.fast_changes`.

    Attributes
    ----------
    places : ndarray, shape (n + 1,)
        Ends of the intervals of ``first``.
    first : ndarray, shape (18, n, 4, 108)
        First order of each stage (twelve after the impact, within, five before the free end):
        coefficients of the powers 3 to 0, each for the three components.  Of each component, these
        are the responses G to fast changes and H to steps of the slow rates, at sixteen offsets,
        the state on an exponential chain, less that of the recursion, as is H, and three zeros.
    knots : ndarray, shape (K + 1,)
        Ends of the intervals of ``second``.
    second : ndarray, shape (18, K, 4, 108)
        Coefficients A of the products of two fast changes, and K of those of a fast change and the
        change of the slow rate, and a zero, for each stage and component.
    last_knots : ndarray, shape (L + 1,)
        Ends of the intervals of ``last``.
    last : ndarray, shape (4, L, 4, 138)
        Coefficients B and C of the last four contacts, see `hertzchain.kernels.last_contacts`.
    end_places : ndarray, shape (P + 1,)
        Ends of the intervals of the following tables; empty if there are none.
    end_response : ndarray, shape (4, P, 4, 54)
        First order of the last four contacts: of each component, the responses G to sixteen rates
        and to all earlier ones, and the state on an exponential chain.
    impact : ndarray, shape (12, P, 4, 54)
        The same of the first contacts, less those within.
    short : ndarray, shape (33, 4, P, 4, 6)
        What the impact leaves at the last four contacts of chains of 8 to 40 contacts: of each
        component, the state on exponential chains, and the response to a linear change of the rate.
    steady : float
        Constant c of the factor of the products of two fast changes.
    bases : ndarray, shape (B + 1,)
        Ends of the intervals of ``alternating``; empty if there is no such table.
    alternating : ndarray, shape (18, B, 4, 36)
        Coefficients of powers of the amplitude of alternating rates, for each stage and component,
        see `hertzchain.kernels.alternation`.
    """

    places: Array
    first: Array
    knots: Array
    second: Array
    last_knots: Array
    last: Array
    end_places: Array
    end_response: Array
    impact: Array
    short: Array
    steady: float
    bases: Array
    alternating: Array

"""First order of the states of the last four contacts, as functions of a mean rate.

See `hertzchain.kernels.last_contacts`.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from ..collision import Array
from ..kernels.fast_changes import EARLY, STATES, TAPS, WITHIN
from ..kernels.last_contacts import LAST, TERMS

# These functions are smooth at rate 0, unlike those within the chain: between the places that are
# nearer to it, rounded values of the tables would determine their slopes.
NEAREST: Final = 0.006
SlowTables = tuple[Array, Array, Array, Array]


def end_tables(
    slow: SlowTables, places: Array, single: Array, end: Array, end_slopes: Array,
    early: Array | None, short: Array,
) -> dict[str, Array]:  # fmt: skip
    """Tables of the last contacts, from those of the responses to single changes.

    The arguments are those of `hertzchain.theory.universal_functions.fast_tables`.  Without
    those of ``short`` chains, tables are empty.
    """
    from scipy.interpolate import Akima1DInterpolator, CubicHermiteSpline, PPoly

    if early is None or not len(short):
        return {
            "end_places": np.zeros(0),
            "end_response": np.zeros((0, 0, 4, STATES * TERMS)),
            "impact": np.zeros((0, 0, 4, STATES * TERMS)),
            "short": np.zeros((0, 0, 0, 4, 2 * STATES)),
        }
    nodes, anchors, _, _ = slow
    within = PPoly(np.moveaxis(anchors[-1].reshape(-1, 4, STATES), 1, 0), nodes)
    kept = (places == 0.0) | (np.abs(places) > NEAREST)
    at, contacts = places[kept], slice(end.shape[1] - LAST, None)
    # The first number of each component is the effect of the end on an exponential chain.
    of_end = end[kept].reshape(len(at), -1, STATES, end.shape[2] // STATES)[:, contacts, :, 0]
    states = within(at)[:, None] + of_end
    slopes = within(at, 1)[:, None] + end_slopes[kept][:, contacts]
    taps = single[kept].reshape(len(at), -1, STATES, TAPS)
    # All responses add up to the slope of the state.
    earlier = slopes - taps[:, -LAST:].sum(axis=-1)
    responses = np.concatenate([taps[:, -LAST:], earlier[..., None]], axis=-1)
    # Near the free end of steep forward tapers, functions have kinks: interpolation is local.
    pieces = Akima1DInterpolator(at, responses).c
    pieces = np.concatenate([pieces, CubicHermiteSpline(at, states, slopes).c[..., None]], axis=-1)
    after_impact = np.zeros((len(at), EARLY, STATES, TERMS))
    after_impact[..., :TAPS] = taps[:, :EARLY] - taps[:, WITHIN, None]
    after_impact[..., -1] = early[kept] - within(at)[:, None]
    # From (places, lengths, contacts, states, 2).
    of_length = short[kept].reshape(len(at), -1, LAST, 2 * STATES)
    return {
        "end_places": at,
        "end_response": _by_contact(pieces),
        "impact": _by_contact(Akima1DInterpolator(at, after_impact).c),
        # From (powers, intervals, lengths, contacts, states).
        "short": np.ascontiguousarray(
            np.transpose(Akima1DInterpolator(at, of_length).c, (2, 3, 1, 0, 4))
        ),
    }


def _by_contact(pieces: Array) -> Array:
    """Polynomials (contacts, intervals, powers, n), from (powers, intervals, contacts, ...)."""
    flat = pieces.reshape(*pieces.shape[:3], -1)
    return np.ascontiguousarray(np.transpose(flat, (2, 1, 0, 3)))

"""First order of the response to slow rates: the simulated one less that of the recursion.

The response of the recursion is fitted to finite changes of the rate; that to a small change of
one rate is known from the simulation.  Near a constant rate, this module differentiates the
recursion, and tabulates what is missing in its states and in their response to differences of the
rate.  With these additions, the law is exact in first order.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline, make_lsq_spline

from ..collision import Array
from ..kernels import local_rate as kernel
from ..kernels.fast_changes import AHEAD, BACKWARD, BEHIND, EARLY, STATES, TAPS

# Number of rates of the chains, and contact within, so far from the struck bead that it is not
# seen.
CONTACTS: Final = BEHIND + AHEAD + 8
MIDDLE: Final = CONTACTS - AHEAD - 1
# Fraction of the rates of the tables that is near 0.
NEAR_ZERO: Final = 0.3
SlowTables = tuple[Array, Array, Array, Array]


def missing_response(tables: SlowTables, places: Array, single: Array, early: Array) -> Array:
    """Values at all places, shape (places, stages up to within, 3, 1 + offsets).

    The first number of each component is the missing state; the others are the missing responses
    to a step, which raises the rates of the contact at the offset and of all ahead.  ``single``
    contains the responses to single rates, (places, stages, 3, offsets), and ``early`` the
    simulated states of the first contacts on exponential chains, (places, 12, 3).
    """
    found = np.zeros((len(places), EARLY + 1, STATES, 1 + TAPS))
    steps = _sums_from(single[:, : EARLY + 1])
    for place, rate in enumerate(places):
        states, slopes = _recursion(tables, float(rate))
        found[place, :EARLY, :, 0] = early[place] - states
        found[place, ..., 1:] = steps[place] - slopes
    # Steps at the first contact are changes of the rate of the chain.
    for stage in range(min(BEHIND, EARLY)):
        found[:, stage, :, 1 : 1 + BEHIND - stage + 1] = 0.0
    return found


def _sums_from(values: Array) -> Array:
    """Sums of each value and those after it."""
    return np.asarray(np.cumsum(values[..., ::-1], axis=-1)[..., ::-1])


def _recursion(tables: SlowTables, rate: float) -> tuple[Array, Array]:
    """States of the recursion on an exponential chain, and their responses to steps."""
    nodes, anchors, knots, response = tables
    rates, work, unused = np.full(CONTACTS, rate), np.empty(kernel.WORK), np.empty((CONTACTS, 4))
    states, deviations = np.empty((CONTACTS, STATES)), np.empty((CONTACTS, STATES))
    slopes, found = np.empty((CONTACTS, STATES, 2)), np.zeros((EARLY + 1, STATES, TAPS))
    chain = nodes, anchors, knots, response, work, states, deviations, slopes, unused
    kernel.forward(rates, CONTACTS, *chain)
    for stage in range(EARLY + 1):
        contact = stage
        if stage == EARLY:
            contact, deviations = MIDDLE, np.zeros_like(deviations)
        for i in range(STATES):
            seeds, to_rates = np.zeros((contact + 1, STATES)), np.zeros(BEHIND + CONTACTS)
            seeds[contact, i] = 1.0
            kernel.backward(
                rates, knots, response, deviations, slopes, seeds, work, to_rates[BEHIND:]
            )
            found[stage, i] = _sums_from(to_rates)[contact : contact + TAPS]
    return states[:EARLY], found


def pieces_of(places: Array, values: Array) -> Array:
    """Cubic polynomials, (stages, intervals, 4, 3 (1 + offsets)), from values at the places.

    Near rate 0, responses have terms of the order |s|^(3/2).  The second order of the recursion
    cannot follow their slopes, which would remain as an error that accumulates: there, responses
    to steps are smoothed.
    """
    flat = values.reshape(*values.shape[:2], -1)
    exact = CubicSpline(places, flat).c
    # All others are interpolated, with the second and the last but one left out of the knots.
    far = places[(places < NEAR_ZERO * places[0]) | (places > NEAR_ZERO * BACKWARD)]
    knots = np.concatenate(
        [np.repeat(far[0], 4), np.union1d(far[2:-2], 0.0), np.repeat(far[-1], 4)]
    )
    smooth = make_lsq_spline(places, flat, knots)
    of_steps = np.arange(flat.shape[-1]) % (1 + TAPS) > 0
    for power in range(4):
        taylor = smooth(places[:-1], nu=3 - power) / math.factorial(3 - power)
        exact[power][..., of_steps] = taylor[..., of_steps]
    return np.asarray(np.transpose(exact, (2, 1, 0, 3)))

"""Derivatives of the states of a chain with respect to all rates, simulated and by the law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from hertzchain.collision import Array
from hertzchain.kernels import local_rate_pulse as kernel
from hertzchain.kernels.error_terms import PARTS
from hertzchain.kernels.fast_changes import STATES
from hertzchain.theory.universal_functions import UniversalFunctions

from .training_chains import states_of

# Changes of a rate in central differences of the simulation, and of the law.
SIMULATED_STEP: Final = 2e-4
LAW_STEP: Final = 1e-5
# All simulations of a chain have the same tolerance, as they are subtracted.
RTOL: Final = 1e-10


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """States of a chain, and their derivatives.

    Attributes
    ----------
    rates : ndarray, shape (M,)
        Rates of the contacts.
    states : ndarray, shape (M, 3)
        States of the contacts.
    slopes : ndarray, shape (M, 3, M)
        Derivatives of the states with respect to the rates, or to the last ones.
    """

    rates: Array
    states: Array
    slopes: Array

    def less(self, other: Sensitivity) -> Sensitivity:
        """Differences of the states and derivatives."""
        return Sensitivity(self.rates, self.states - other.states, self.slopes - other.slopes)


def simulate_slopes(
    rates: Sequence[Array], exponent: float, last: int = 0, rtol: float = RTOL
) -> list[Sensitivity]:
    """Simulated states and derivatives of the chains for which all simulations succeed.

    The derivatives are those with respect to all rates, or to so many ``last`` ones.
    """
    found = []
    for row in rates:
        steps = SIMULATED_STEP * np.eye(len(row))[-last:]
        moved = [row, *(row + steps), *(row - steps)]
        states = [each for each in states_of(moved, exponent, (rtol,)) if each is not None]
        if len(states) == len(moved):
            up, down = np.array(states[1:]).reshape(2, len(steps), len(row), STATES)
            slopes = np.moveaxis(up - down, 0, -1) / (2.0 * SIMULATED_STEP)
            found.append(Sensitivity(row, states[0], slopes))
    return found


def law_slopes(functions: UniversalFunctions, rates: Array) -> Sensitivity:
    """States and derivatives by the law."""
    steps = LAW_STEP * np.eye(len(rates))
    up = np.array([law_states(functions, rates + step) for step in steps])
    down = np.array([law_states(functions, rates - step) for step in steps])
    slopes = np.moveaxis(up - down, 0, -1) / (2.0 * LAW_STEP)
    return Sensitivity(rates, law_states(functions, rates), slopes)


def law_states(functions: UniversalFunctions, rates: Array) -> Array:
    """States by the law, (contacts, 3)."""
    contacts = len(rates)
    slow, fast = kernel.divide(rates, contacts)
    states, parts = np.empty((contacts, STATES)), np.empty((contacts, PARTS))
    deviations, slopes = np.empty((contacts, STATES)), np.empty((contacts, STATES, 2))
    kernel.evaluate(rates, slow, fast, functions.arrays, states, deviations, slopes, parts)
    return states


def of_radii(slopes: Array) -> Array:
    """Derivatives with respect to the logarithms of the radii, from those by the rates."""
    padded = np.pad(slopes, [(0, 0)] * (slopes.ndim - 1) + [(1, 1)])
    return np.asarray(padded[..., :-1] - padded[..., 1:])

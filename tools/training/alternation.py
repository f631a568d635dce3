"""Determine what the law lacks on chains whose rates alternate about a constant one."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hertzchain.chain.chain import Chain
from hertzchain.collision import Array
from hertzchain.kernels.alternation import COUNT, LOWEST, LOWEST_RATE, POWERS, TOP
from hertzchain.kernels.fast_changes import EARLY, END, STAGES, STATES
from hertzchain.theory.local_rate import solve
from hertzchain.theory.universal_functions import UniversalFunctions

from .training_chains import states_of

# Mean rates; at the outer ones, the effect vanishes, and it fades towards the largest.
BASES: Final = np.array([
    -0.14, -0.12, -0.1, -0.08, -0.06, -0.045, -0.03, -0.02, -0.01, 0.0,
    0.01, 0.02, 0.03, 0.045, 0.06, 0.08, 0.1, 0.13, 0.165, 0.2,
])  # fmt: skip
FADING: Final = 0.165
AMPLITUDES: Final = np.array([0.005, 0.01, 0.015, *np.arange(2, 13) / 100])
# The effect of the largest amplitude with rates above the lowest one is used for larger amplitudes,
# with less weight.
EXTENDED: Final = 0.2
# Amplitude below which all errors have the same weight.
SMALL: Final = 0.01
ROUNDING: Final = 1e-9
# Beyond this contact, the state alternates between two values.
CONTACTS: Final = 99
SETTLED: Final = 60


def alternating_rates(base: float, amplitude: float) -> Array:
    """Rates of a chain that alternate about a base."""
    return base + amplitude * (-1.0) ** np.arange(CONTACTS)


def possible(base: float) -> NDArray[np.bool_]:
    """Amplitudes with which no rate is below the lowest one."""
    return base - AMPLITUDES >= LOWEST_RATE - ROUNDING


def effects(functions: UniversalFunctions, base: float) -> Array:
    """States less those of the law, shape (amplitudes, signs, stages, 3)."""
    amplitudes = AMPLITUDES[possible(base)]
    rates = [alternating_rates(base, sign * a) for a in amplitudes for sign in (1.0, -1.0)]
    rows = []
    for row, true in zip(rates, states_of(rates, functions.exponent), strict=True):
        assert true is not None
        radii = np.exp(np.concatenate([[0.0], np.cumsum(row)]))
        chain = Chain.from_radii(radii, exponent=functions.exponent)
        rows.append(true - solve(chain, functions).states)
    missing = np.array(rows).reshape(len(amplitudes), 2, CONTACTS, STATES)
    contacts = [*range(EARLY), SETTLED, *range(CONTACTS - END, CONTACTS)]
    found = np.empty((len(AMPLITUDES), 2, STAGES, STATES))
    for stage, contact in enumerate(contacts):
        # At odd contacts, the sign is that of the other chain.
        signs = [0, 1] if contact % 2 == 0 else [1, 0]
        found[: len(amplitudes), :, stage] = missing[:, signs, contact]
    found[len(amplitudes) :] = found[len(amplitudes) - 1]
    return found


def coefficients(functions: UniversalFunctions) -> Array:
    """Coefficients of powers of the amplitude at all bases, shape (bases, 18, 3 COUNT)."""
    powers = (AMPLITUDES[:, None] / TOP) ** (LOWEST + np.arange(POWERS))
    # Rows of both signs.
    matrix = np.concatenate([np.hstack([powers, powers]), np.hstack([powers, -powers])])
    found = np.zeros((len(BASES), STAGES, STATES * COUNT))
    for place, base in enumerate(BASES[1:-1], 1):
        if base >= FADING:
            found[place] = 0.5 * found[place - 1]
            continue
        missing = effects(functions, float(base))
        weight = 1.0 / (AMPLITUDES**2 + SMALL**2)
        weight = np.tile(np.where(possible(base), weight, EXTENDED * weight), 2)
        right = np.moveaxis(missing, 1, 0).reshape(2 * len(AMPLITUDES), -1)
        solution = np.linalg.lstsq(matrix * weight[:, None], right * weight[:, None])[0]
        # From (powers, stages, components).
        by_stage = solution.reshape(COUNT, STAGES, STATES)
        found[place] = np.transpose(by_stage, (1, 2, 0)).reshape(STAGES, -1)
    return found

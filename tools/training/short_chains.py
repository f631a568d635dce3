"""Effect of the impact at the last contacts of short chains, from simulations.

Simulated are exponential chains of each length, and chains whose rates change linearly along the
whole chain.  The states that the law already has are subtracted.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from hertzchain.collision import Array
from hertzchain.kernels import last_contacts as kernel
from hertzchain.kernels.fast_changes import STATES
from hertzchain.theory.exponents import scaled
from hertzchain.theory.universal_functions import UniversalFunctions

from .last_fit import last_states
from .responses import PLACES, STRONG
from .training_chains import FINE_RTOLS, states_of

# Numbers of contacts of chains at whose end the impact is not forgotten.
SHORT_CONTACTS: Final = range(kernel.SHORTEST, 41)
# Table of chains that are all long.
NONE: Final = np.zeros((len(PLACES), 0, 2 * kernel.LAST * STATES))
# Rise of the rates of the ramps.
RISE: Final = 1e-3
# Below this rate, states of Hertz chains jump, and the response to a ramp is that at this rate.
LOWEST_SLOPE: Final = -0.1275


def missing(functions: UniversalFunctions, s: float, contacts: int, rtol: float) -> Array | None:
    """Missing states of an exponential chain, and their response to a ramp, (4, 3, 2)."""
    ramp = np.linspace(-0.5, 0.5, contacts)
    rows = [s + rise * RISE * ramp for rise in (0.0, 1.0, -1.0, 2.0, -2.0)]
    found = [
        None if states is None else states[-kernel.LAST :] - last_states(functions.fast, row)
        for states, row in zip(states_of(rows, functions.exponent, (rtol,)), rows, strict=True)
    ]
    if any(each is None for each in found):
        return None
    z = np.array(found)
    slope = (8.0 * (z[1] - z[2]) - (z[3] - z[4])) / (12.0 * RISE)
    return np.stack([z[0], slope], axis=-1)


def left_by_impact(functions: UniversalFunctions, shrink: float = 1.0) -> Array:
    """Table of short chains, (places, lengths, 24), for functions without one."""
    places = scaled(PLACES, shrink)
    found = np.zeros((len(places), len(SHORT_CONTACTS), kernel.LAST, STATES, 2))
    for i, s in enumerate(places):
        for length, contacts in enumerate(SHORT_CONTACTS):
            for rtol in FINE_RTOLS[-1:] if s > STRONG else FINE_RTOLS:
                each = missing(functions, s, contacts, rtol)
                if each is not None:
                    found[i, length] = each
                    break
    jumping = places < scaled(LOWEST_SLOPE, shrink)
    found[jumping, ..., 1] = found[np.argmin(jumping), ..., 1]
    return found.reshape(len(places), len(SHORT_CONTACTS), -1)

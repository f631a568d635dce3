"""Responses to a change of one rate, and to the free end, from simulations of exponential chains.

A *step at m* raises the rates of contact m and of all contacts ahead: it is a change of the
difference between the rates of contacts m and m - 1.  At each place of the tables, exponential
chains are simulated with one small step of either sign; central differences of fourth order give
the response of each state.  A change of one rate is a step minus the next one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from hertzchain.collision import Array
from hertzchain.kernels.fast_changes import AHEAD, BEHIND, EARLY, END, STAGES, STATES, TAPS, WITHIN
from hertzchain.theory.exponents import scaled

from .training_chains import FINE_RTOLS, HIGHEST, NEAR_ZERO, states_of

# Below the lowest place, responses vary abruptly with the rate.  Those of Hertz contacts jump
# between -0.1325 and -0.132, where the last bead but one loses its first maximum.
PLACES: Final = np.unique(
    np.round(
        [
            *np.arange(-0.15, 0.1501, 0.0075), *np.negative(NEAR_ZERO), *NEAR_ZERO,
            -0.133, -0.1314,
            *np.arange(0.17, 0.3, 0.02), *np.arange(0.3, 0.6, 0.05), *np.arange(0.6, 0.95, 0.1),
            1.0, HIGHEST,
        ],
        5,
    )
)  # fmt: skip
# Backward tapers above this rate amplify rounding errors and require larger tolerance and steps.
STRONG: Final = 0.31
STEP: Final = 2e-4
STEP_STRONG: Final = 2e-3
# The chains are so long that effects of impact and end do not overlap; steps within the chain are
# made at the contact in the middle.
CONTACTS, MIDDLE = 92, 44
CONTACTS_STRONG, MIDDLE_STRONG = 72, 30


def respond(s: float, contacts: int, steps: Sequence[int], exponent: float) -> tuple[Array, Array]:
    """States on an exponential chain, and responses to steps (steps, contacts, 3)."""
    strong = s > STRONG
    size = STEP_STRONG if strong else STEP
    up = (np.arange(contacts) >= np.array(steps)[:, None]).astype(float)
    rows = np.concatenate([np.zeros((1, contacts)), up, -up, 2.0 * up, -2.0 * up])
    # All with the same tolerance, as they are subtracted.
    for rtol in FINE_RTOLS[-1:] if strong else FINE_RTOLS:
        found = states_of(list(s + size * rows), exponent, (rtol,))
        z = np.array([states for states in found if states is not None])
        if len(z) == len(rows):
            break
    one = z[1:].reshape(4, len(steps), contacts, STATES)
    return z[0], (8.0 * (one[0] - one[1]) - (one[2] - one[3])) / (12.0 * size)


def measure(exponent: float, shrink: float = 1.0) -> dict[str, Array]:
    """Values of the tables of fast changes at all places."""
    count, places = len(PLACES), scaled(PLACES, shrink)
    single = np.zeros((count, STAGES, STATES, TAPS))
    end, slopes = np.zeros((count, END, STATES, 1 + TAPS)), np.zeros((count, END, STATES))
    impact = np.zeros((count, EARLY, STATES))
    for place, s in enumerate(places):
        contacts, middle = (CONTACTS_STRONG, MIDDLE_STRONG) if s > STRONG else (CONTACTS, MIDDLE)
        early, last = range(EARLY + AHEAD + 1), contacts - END - BEHIND - 1
        steps = [*early, middle, *range(last, contacts)]
        states, response = respond(s, contacts, steps, exponent)
        of = {step: response[i] for i, step in enumerate(steps)}
        impact[place] = states[:EARLY]
        # Response to the step at an offset from a contact.
        within = np.array([of[middle][middle - o] for o in range(-BEHIND - 1, AHEAD + 1)])
        for k in range(EARLY):
            for m in range(max(0, k - BEHIND), k + AHEAD + 1):
                single[place, k, :, m - k + BEHIND] = of[m][k] - of[m + 1][k]
        of[contacts] = np.zeros((contacts, STATES))
        single[place, WITHIN] = _differences(within[1:]).T
        settled = middle + (contacts - middle) // 2
        for i in range(END):
            k = contacts - END + i
            ahead = min(AHEAD, contacts - 1 - k)
            ending = np.array([of[k + o][k] for o in range(-BEHIND, ahead + 1)])
            single[place, WITHIN + 1 + i, :, : len(ending)] = _differences(ending).T
            # Response to a change of all rates.
            slope = of[0][k] - of[0][settled]
            change = ending - within[1 : 1 + len(ending)]
            change[: BEHIND + 1] -= slope
            end[place, i, :, 0] = states[k] - states[settled]
            end[place, i, :, 1 : 1 + len(change)] = change.T
            slopes[place, i] = slope
    return {
        "places": places,
        "single": single.reshape(count, STAGES, -1),
        "early": impact,
        "end": end.reshape(count, END, -1),
        "end_slopes": slopes,
    }


def _differences(steps: Array) -> Array:
    """Responses to changes of one rate from those to steps, which are 0 further ahead."""
    return steps - np.concatenate([steps[1:], np.zeros((1, STATES))])

r"""Find the beads at which losses have turned a pulse into the front of a shock-like tail.

At the crossing of contact k, the beads ahead of the crest have the momentum :math:`A_k`, and those
of the leading pulse behind it :math:`B_k`.  In the solitary wave of equal beads,
:math:`B_k/A_k = 1`; in a taper without losses, the ratio depends on the rate, because beads keep a
part of their momentum where the next one is lighter: 1.3 for q = 0.02, 2.1 for q = 0.05.  Losses
increase it, in the same proportion in all tapers.  A pulse is the front of a tail where the ratio
is more than twice that of the same chain without losses.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..chain.modifications import with_one_loss
from ..collision import Array
from ..errors import InputError, SimulationError
from ..recorded_warnings import ignore_warnings
from .simulate import simulate

# Ratio, relative to that without losses, above which a pulse is the front of a tail.
TAIL: Final = 2.0
# Smaller ratios are found without losses only if masses grow by more than 10% per bead.
LEAST: Final = 0.6
# Tolerance of the simulation without losses.
RTOL: Final = 1e-9
# Features with which the pulse of equal beads is a solitary wave.
SOLITARY_FEATURES: Final = {"SI units", "masses", "stiffness", "left wall", "right wall", "loss"}


def tailed(chain: Chain, crossings: Array) -> Array:
    """Contacts at which the pulse is the front of a tail, shape (N - 1,)."""
    found = np.zeros(chain.beads - 1, bool)
    if chain.lossless:
        return found
    ratios = _ratios(crossings)
    equal = (
        np.ptp(chain.masses) == 0.0 == np.ptp(chain.stiffness)
        and {*chain.features} <= SOLITARY_FEATURES
    )
    lowest = LEAST if (np.diff(chain.masses) > 0.0).any() else 1.0
    if not (ratios > TAIL * (1.0 if equal else lowest)).any():
        return found
    usual = np.ones(len(ratios)) if equal else _without_losses(chain, crossings)
    found = ratios > TAIL * usual
    # Near the end of the chain, beads that would carry a part of the pulse are missing.
    found[-2:] = found[-3:-2].any()
    return found


def _ratios(crossings: Array) -> Array:
    """Momentum behind the crest over that ahead of it; 0 where it is not known."""
    from ..kernels import state_layout

    ahead = crossings[state_layout.HANDED_OVER]
    behind = crossings[state_layout.LEADING_MOMENTUM] - ahead
    return np.divide(behind, ahead, out=np.zeros(len(ahead)), where=ahead > 0.0)


def _without_losses(chain: Chain, crossings: Array) -> Array:
    """Ratios of the same chain without losses; 1 where its pulse does not arrive."""
    from ..kernels import state_layout

    last = float(crossings[state_layout.CROSSING_TIME].max())
    with ignore_warnings():
        try:
            run = simulate(with_one_loss(chain, None), until=last, times=0, rtol=RTOL, check=False)
        except (InputError, SimulationError):
            return np.ones(chain.beads - 1)
    found = _ratios(run._crossings)
    return np.where(found > 0.0, found, 1.0)

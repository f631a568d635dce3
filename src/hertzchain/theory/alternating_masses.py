"""Find chains whose masses alternate, to which theories of single collisions do not apply."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from ..chain.chain import Chain
from ..collision import Array
from ..errors import ModelRangeWarning, warn_user

# Largest loss of velocity by alternating masses, as a factor.  In smooth chains, the velocities of
# the BCA are too large by a factor of about 1.5: with this loss, they are too small by 40%.
MAX_LOSS: Final = 2.5
# Contacts on each side within which masses alternate, and changes of ln m that are neglected.
WINDOW, SMALL = 2, 1e-6


def losses(masses: Array) -> Array:
    r"""Factor by which alternating masses reduce the velocity of each bead in the BCA, shape (N,).

    A collision transfers the part :math:`1/\cosh^2(d_k/2)` of the energy, with
    :math:`d_k = \ln(m_{k+1}/m_k)`.  A pulse spreads over several beads and responds to the mean of
    these changes.  The factor is that of the changes over that of their mean over neighbouring
    contacts with weights 1/4, 1/2, 1/4, which has no alternating part.  Contacts count where
    masses both grow and fall within two contacts, so that steep tapers and steps do not.
    """
    changes = np.diff(np.log(masses))
    if len(changes) < 2:
        return np.ones(len(masses))
    padded = np.pad(changes, 1, mode="reflect")
    mean = 0.25 * (padded[:-2] + padded[2:]) + 0.5 * changes
    lost = (_log_cosh(0.5 * changes) - _log_cosh(0.5 * mean)) * alternates(masses)
    return np.exp(np.concatenate(([0.0], np.cumsum(lost))))


def alternates(masses: Array) -> NDArray[np.bool_]:
    """Whether masses both grow and fall within two contacts of each contact, shape (N - 1,)."""
    changes = np.diff(np.log(masses))
    near = sliding_window_view(np.pad(changes, WINDOW), 2 * WINDOW + 1)
    return np.asarray((near.min(axis=1) < -SMALL) & (near.max(axis=1) > SMALL))


def _log_cosh(x: Array) -> Array:
    return np.asarray(np.logaddexp(x, -x) - np.log(2.0))


def warn_if_alternating(chain: Chain, theory: str) -> None:
    """Warn that a theory of single collisions does not apply to a chain of alternating masses."""
    with np.errstate(over="ignore"):
        found = losses(chain.masses)
    outside = found > MAX_LOSS
    if outside.any():
        last = f"{found[-1]:.3g}" if found[-1] < 1e6 else "more than a million"
        warn_user(
            f"{theory} underestimates velocities in this chain ({chain.description}): it treats "
            "each contact as a separate collision, in which masses that grow and fall from bead to "
            f"bead cost a factor of {last} (more than {MAX_LOSS:g} from bead "
            f"{int(np.argmax(outside)) + 1} on), while a pulse across several beads loses much "
            "less; use propagate or simulate",
            ModelRangeWarning,
        )

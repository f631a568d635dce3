"""Which beads of a chain are small ones between large ones."""

from __future__ import annotations

import warnings
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hertzchain.chain.chain import Chain
from hertzchain.contacts import Array
from hertzchain.errors import ModelRangeWarning

# A bead is small if the large ones on both sides exceed it by more than this.
SMALL: Final = 0.8


def small_beads(radii: Array) -> NDArray[np.bool_]:
    """Find the beads that decorate a chain: small ones between large ones.

    A run of beads counts as small if the bead before it and the bead after it are larger
    than all of it, by a factor of more than 1/0.8.  A taper, however strong, has none.

    Parameters
    ----------
    radii : ndarray, shape (N,)
        Radii of the beads.

    Returns
    -------
    ndarray of bool, shape (N,)

    Examples
    --------
    >>> small_beads(np.array([1.0, 0.3, 0.9, 0.25, 0.25, 0.8]))
    array([False,  True, False,  True,  True, False])
    >>> bool(small_beads(0.7 ** np.arange(9)).any())
    False
    """
    small: NDArray[Any] = np.zeros(len(radii), dtype=bool)
    falls = np.flatnonzero(radii[1:] < SMALL * radii[:-1])
    rises = radii[1:] * SMALL > radii[:-1]
    end = 0
    for large in falls:
        if large < end or not rises[large + 1 :].any():
            continue
        found = _run_end(radii, int(large) + 1)
        if found is not None:
            end = found
            small[large + 1 : end] = True
    return small


def _run_end(radii: Array, first: int) -> int | None:
    """First bead that towers over all from the given one on; looks farther step by step."""
    ahead = 8
    while True:
        part = radii[first : first + ahead]
        towering = np.flatnonzero(part[1:] * SMALL > np.maximum.accumulate(part[:-1]))
        if len(towering):
            return first + 1 + int(towering[0])
        if first + ahead >= len(radii):
            return None
        ahead *= 4


def warn_if_decorated(chain: Chain, theory: str) -> None:
    """Warn that a theory of single collisions does not hold for a decorated chain.

    Parameters
    ----------
    chain : Chain
        The chain it was asked about.
    theory : str
        Name of the theory.

    Examples
    --------
    >>> import hertzchain as hc
    >>> warn_if_decorated(hc.Chain.tapered("forward-linear", 0.01, beads=50), "BCA")
    """
    small = small_beads(chain.radii)
    if small.any():
        warnings.warn(
            f"{theory} has one collision at a time, but bead {int(np.argmax(small)) + 1} is a "
            "small one between large ones and is hit many times: use effective_chain, or "
            f"a chain whose radii do not fall below {SMALL:g} of those on both sides",
            ModelRangeWarning,
            stacklevel=3,
        )

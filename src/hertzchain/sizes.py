"""Sizes of beads as people give them: how many, which radii, which exponent."""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hertzchain.contacts import Array
from hertzchain.errors import InputError, real_number

# What an integration holds per bead: sixteen stages and the state, 8 bytes a number.
BYTES_PER_BEAD: Final = 400
# Beyond it a contact is a hard wall, which steps in time cannot follow.
LARGEST_EXPONENT: Final = 50.0


def checked_beads(beads: int) -> int:
    """A number of beads: whole, at least two, and not more than fit in memory.

    Parameters
    ----------
    beads : int
        Number of beads.

    Returns
    -------
    int

    Raises
    ------
    InputError
        If it is none of these.

    Examples
    --------
    >>> checked_beads(20)
    20
    """
    try:
        count = operator.index(beads)
    except TypeError:
        raise InputError(f"beads must be a whole number of at least 2, got {beads!r}") from None
    if isinstance(beads, bool) or count < 2:
        raise InputError(f"beads must be a whole number of at least 2, got {beads!r}")
    # Nobody's memory is full at a hundred thousand beads; asking it takes time.
    if count > 100_000:
        import psutil

        free = psutil.virtual_memory().available
        if count * BYTES_PER_BEAD > free:
            raise InputError(
                f"{count} beads do not fit in memory: at {BYTES_PER_BEAD} bytes a bead the "
                f"{free / 2**30:.1f} GiB free hold {free // BYTES_PER_BEAD} beads; use fewer"
            )
    return count


def checked_exponent(exponent: float) -> float:
    """An exponent of the contact force, above 1 and at most 50.

    Parameters
    ----------
    exponent : float
        Exponent p.

    Returns
    -------
    float

    Raises
    ------
    InputError
        If it is out of this range.

    Examples
    --------
    >>> checked_exponent(2)
    2.0
    """
    value = real_number("exponent of the contact force", exponent)
    if not 1.0 < value <= LARGEST_EXPONENT:
        raise InputError(
            f"exponent of the contact force must be above 1 and at most {LARGEST_EXPONENT:g}, "
            f"got {value:g}; Hertz contacts have 1.5"
        )
    return value


def positive_radii(radii: ArrayLike) -> Array:
    """A copy of radii that are numbers, positive and finite, and at least two.

    Parameters
    ----------
    radii : array_like, shape (N,)
        Radii in any one unit.

    Returns
    -------
    ndarray, shape (N,)

    Raises
    ------
    InputError
        If they are not; the bead is named.

    Examples
    --------
    >>> positive_radii([5, 4])
    array([5., 4.])
    """
    try:
        given = np.asarray(radii)
    except ValueError:
        raise InputError(f"radii must be a list of positive numbers, got {radii!r}") from None
    if given.dtype.kind not in "iuf":
        raise InputError(_first_unreadable(radii))
    if given.ndim != 1 or len(given) < 2:
        raise InputError(f"radii must be a list of at least two numbers, got {radii!r}")
    checked_beads(len(given))
    values: NDArray[np.float64] = given.astype(float)
    good = (values > 0.0) & (values < math.inf)
    if not good.all():
        k = int(np.argmin(good))
        raise InputError(
            f"radius of bead {k + 1} is {values[k]:g}: radii must be positive and finite"
        )
    return values


def scaled_radii(radii: ArrayLike) -> Array:
    """A copy of radii, in units of the first bead's, whose cubes can be represented.

    Parameters
    ----------
    radii : array_like, shape (N,)
        Radii [scaled].

    Returns
    -------
    ndarray, shape (N,)

    Raises
    ------
    InputError
        If they are not positive numbers, or a mass would underflow or overflow.

    Examples
    --------
    >>> scaled_radii([1, 0.5])
    array([1. , 0.5])
    """
    values = np.array(radii, dtype=float)
    with np.errstate(over="ignore", under="ignore"):
        masses = values**3
    good = (masses >= np.finfo(float).tiny) & (masses < math.inf)
    if values.ndim == 1 and not good.all():
        k = int(np.argmin(good))
        if not values[k] < 0.0:
            raise InputError(
                f"bead {k + 1} has {values[k]:g} times the radius of the first: its mass cannot "
                "be represented beyond 1e-102..1e102; use fewer beads or a weaker taper"
            )
    return positive_radii(values)


def _first_unreadable(radii: object) -> str:
    if isinstance(radii, Sequence) and not isinstance(radii, str):
        for k, value in enumerate(radii, start=1):
            try:
                real_number("", value)
            except InputError:
                return f"radius of bead {k} is {value!r}: radii must be positive numbers"
    return f"radii must be a list of positive numbers, got {radii!r}"

"""Sizes of beads as people give them: how many, which radii, which exponent."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from hertzchain.checks import number, real_numbers, whole_number
from hertzchain.contacts import Array
from hertzchain.errors import InputError, shown

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
    count = whole_number("beads", beads, least=2)
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
    return number(
        "exponent of the contact force", exponent, above=1.0, most=LARGEST_EXPONENT,
        hint="Hertz contacts have 1.5",
    )  # fmt: skip


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
    values = real_numbers("radius", radii, "bead")
    if values.ndim != 1 or len(values) < 2:
        raise InputError(f"radii must be a list of at least two numbers, got {shown(radii)}")
    checked_beads(len(values))
    values = values.copy()
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
    values = real_numbers("radius", radii, "bead")
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

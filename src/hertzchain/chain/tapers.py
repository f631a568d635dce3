"""The four tapers of the paper: names, radii and the rates they may have."""

from __future__ import annotations

import math
from typing import Final, Literal, get_args

import numpy as np

from hertzchain.contacts import Array
from hertzchain.errors import InputError, real_number, unknown_name

Taper = Literal["backward-linear", "backward-exponential", "forward-linear", "forward-exponential"]
TAPERS: Final[tuple[Taper, ...]] = get_args(Taper)

# A radius below this is what rounding leaves of zero.
ROUNDING: Final = 1e-12


def rate_symbol(taper: str) -> Literal["S", "q"]:
    """The paper's letter for the tapering parameter: S if linear, q if exponential.

    Parameters
    ----------
    taper : str
        Name of a taper.

    Returns
    -------
    str

    Raises
    ------
    InputError
        If there is no such taper.

    Examples
    --------
    >>> rate_symbol("backward-linear")
    'S'
    """
    if not isinstance(taper, str) or taper not in TAPERS:
        uniform = isinstance(taper, str) and taper == "uniform"
        hint = "; equal beads are Chain.uniform" if uniform else ""
        raise InputError(str(unknown_name("taper", taper, TAPERS)) + hint)
    return "S" if taper.endswith("linear") else "q"


def check_taper(taper: str, rate: float, beads: int = 2) -> float:
    """The rate of a taper, if the taper exists and a chain of so many beads has that rate.

    Parameters
    ----------
    taper : str
        Name of the taper.
    rate : float
        Tapering parameter S or q.
    beads : int
        Number of beads.

    Returns
    -------
    float
        The rate.

    Raises
    ------
    InputError
        For an unknown taper, or a rate outside its range.

    Examples
    --------
    >>> check_taper("forward-linear", 0.01, 100)
    0.01
    """
    symbol = rate_symbol(taper)
    value = real_number(f"{symbol} of a {taper} taper", rate)
    if symbol == "q":
        if not 0.0 < value < 1.0:
            raise InputError(
                f"q of a {taper} taper must lie between 0 and 1, got {value:g}; "
                "try 0.05, or a uniform chain for equal beads"
            )
        return value
    if not 0.0 < value < math.inf:
        raise InputError(
            f"S of a {taper} taper must be positive and finite, got {value:g}; "
            "try 0.005, or a uniform chain for equal beads"
        )
    if taper == "forward-linear" and not _last_radius(value, beads) > ROUNDING:
        # 1/S is rounded: step down from it to the first chain that has a radius left.
        longest = math.ceil(1.0 + 1.0 / value)
        while longest >= 2 and not _last_radius(value, longest) > ROUNDING:
            longest -= 1
        advice = (
            f"use at most {longest} beads or a smaller S"
            if longest >= 2
            else "S must be below 1 for even two beads"
        )
        raise InputError(
            f"a forward-linear taper with S = {value:g} runs out of radius at bead "
            f"{longest + 1}, but {beads} beads were asked for: {advice}"
        )
    return value


def _last_radius(rate: float, beads: int) -> float:
    return 1.0 - rate * (beads - 1)


def tapered_radii(taper: str, rate: float, beads: int) -> Array:
    """Radii of a taper, the first of which is 1; rate and number of beads are not checked.

    Parameters
    ----------
    taper : str
        Name of the taper.
    rate : float
        Tapering parameter S or q.
    beads : int
        Number of beads.

    Returns
    -------
    ndarray, shape (beads,)

    Examples
    --------
    >>> tapered_radii("backward-linear", 0.5, 3)
    array([1. , 1.5, 2. ])
    """
    step = np.arange(beads, dtype=float)
    with np.errstate(over="ignore", under="ignore"):
        if taper == "backward-linear":
            return 1.0 + rate * step
        if taper == "forward-linear":
            return 1.0 - rate * step
        ratio = 1.0 - rate if taper == "backward-exponential" else 1.0 + rate
        return np.asarray(ratio**-step)

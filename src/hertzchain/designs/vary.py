"""Variables of a design: `hertzchain.vary`.

>>> import hertzchain as hc
>>> hc.vary.radii(0.5, 1.0, beads="2:")
Sizes(radii of '2:' from 0.5 to 1.0, by bead)
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from typing import Any

from ..chain.materials import MaterialLike
from ..units import quantity
from ..validation.keywords import checked_arguments
from .ball_choice import BallChoice, OrderChoice
from .sizes import Sizes

__all__ = ("balls", "diameters", "gaps", "masses", "order", "radii")

Beads = str | Sequence[int]


def __dir__() -> tuple[str, ...]:
    return __all__  # for completion


@checked_arguments("vary.radii")
def radii(
    low: Any, high: Any, *, beads: Beads = "2:", by: str = "bead", knots: int | None = None,
    symmetric: bool = False, monotone: str | None = None,
) -> Sizes:  # fmt: skip
    r"""Radii between two limits.

    .. math:: \ln R_k = \sum_j B_j(k)\, c_j

    with cubic B-splines :math:`B_j` (``by="spline"``), one coefficient per bead (``by="bead"``),
    or one for all (``by="common"``).

    Parameters
    ----------
    low, high : float or str
        Smallest and largest radius [scaled, or m].
    beads : str or sequence of int
        Beads that vary: ``"first:last"`` or ``"first:last:step"``, with both ends included, or a
        list.  A range without an end, such as ``"2:"``, does not include a cap.  Names do
        not count the strikers: ``"ball 1:"`` or ``"ball 2:ball 6"``.  All others are fixed.
    by : str
        ``"bead"``, ``"spline"`` or ``"common"``.  A spline continues the size of the bead behind
        the first that varies, which fixes its first coefficient, unless there is none, that bead is
        a striker, or the spline is symmetric or monotone.
    knots : int, optional
        Number of coefficients of a spline; by default a quarter of the beads, at least 4 and at
        most 24.
    symmetric : bool
        Whether the radii are the same from both ends.
    monotone : str, optional
        ``"increasing"`` or ``"decreasing"``.

    Raises
    ------
    InputError
        If limits exclude each other, or an option is unknown.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.vary.radii(0.3, 3.0, by="spline", knots=12)
    Sizes(radii of '2:' from 0.3 to 3.0, by spline with 12 knots)
    """
    return Sizes("radii", low, high, beads, by, knots, symmetric, monotone)


@checked_arguments("vary.diameters")
def diameters(
    low: Any, high: Any, *, beads: Beads = "2:", by: str = "bead", knots: int | None = None,
    symmetric: bool = False, monotone: str | None = None,
) -> Sizes:  # fmt: skip
    """Diameters between two limits; half of them are the limits of the radii.

    Parameters
    ----------
    low, high : float or str
        Smallest and largest diameter [scaled, or m].
    beads, by, knots, symmetric, monotone
        As for `radii`.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.vary.diameters("5 mm", "20 mm", by="spline")
    Sizes(radii of '2:' from 2.5 mm to 10 mm, by spline)
    """
    return radii(
        _half(low), _half(high), beads=beads, by=by, knots=knots, symmetric=symmetric,
        monotone=monotone,
    )  # fmt: skip


def _half(diameter: Any) -> Any:
    """Half of a number or of text with a unit; anything else is left to the check of radii."""
    if isinstance(diameter, int | float) and not isinstance(diameter, bool):
        return 0.5 * diameter
    parts = quantity(diameter) if isinstance(diameter, str) else None
    return diameter if parts is None else f"{0.5 * float(parts[0]):.12g} {parts[1]}"


@checked_arguments("vary.masses")
def masses(
    low: Any, high: Any, *, beads: Beads = "2:", by: str = "bead", knots: int | None = None,
    symmetric: bool = False, monotone: str | None = None,
) -> Sizes:  # fmt: skip
    """Masses between two limits, at fixed contacts.

    Parameters
    ----------
    low, high : float or str
        Smallest and largest mass [scaled, or kg].
    beads, by, knots, symmetric, monotone
        As for `radii`.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.vary.masses(0.05, 0.9, beads="2::2", by="common")
    Sizes(masses of '2::2' from 0.05 to 0.9, by common)
    """
    return Sizes("masses", low, high, beads, by, knots, symmetric, monotone)


@checked_arguments("vary.gaps")
def gaps(
    low: Any, high: Any, *, contacts: Beads = "1:", by: str = "bead", knots: int | None = None
) -> Sizes:
    """Gaps of contacts between two limits.

    Parameters
    ----------
    low, high : float or str
        Smallest and largest gap [scaled, or m].
    contacts, by, knots
        As for the beads of `radii`.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.vary.gaps(0.0, 0.1)
    Sizes(gaps of '1:' from 0.0 to 0.1, by bead)
    """
    return Sizes("gaps", low, high, contacts, by, knots, False, None)


@checked_arguments("vary.balls")
def balls(
    catalogue: str | os.PathLike[str] = "bearing-balls", *,
    materials: Iterable[MaterialLike] | None = None, diameters: Iterable[Any] | str | None = None,
    beads: Beads = "2:", optional: bool = False, start: Iterable[Any] | None = None,
) -> BallChoice:  # fmt: skip
    """Balls of a catalogue, one for each place.

    Parameters
    ----------
    catalogue : str or path-like
        ``"bearing-balls"``, the catalogue of hertzchain, or a CSV file with the columns
        ``diameter [mm]``, ``material`` and, optionally, ``grade``, ``name``, ``price`` and
        ``count``, the number of balls in stock; an empty cell is any number.
    materials : iterable, optional
        Materials to choose from; by default all.
    diameters : iterable or str, optional
        Diameters [m, or with a unit] to choose from; by default all.  A range such as
        ``"4 mm to 16 mm"`` has all sizes of the catalogue between its ends, both included.
    beads : str or sequence of int
        Places that vary, as in `radii`.
    optional : bool
        Whether places may be empty; the number of beads then varies.
    start : iterable, optional
        A row with which the search begins and with which the design is compared: the balls from
        the first place on, such as ``["8 mm", "2 x 5 mm"]``.  If there are several materials, each
        ball has one: ``"5 mm ptfe"``.  Fewer balls than places are a row with empty places.
        Balls from the line ``order`` of a summary that end in ``(arrives)`` do not vary and are
        left out.

    Raises
    ------
    InputError
        If the catalogue is missing or has unknown materials, no ball is left, too few balls
        are in stock, or a ball of ``start`` cannot be chosen.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.vary.balls(materials=["steel-304", "ptfe"], diameters=["4.762 mm"])
    BallChoice(2 kinds of balls for '2:')
    >>> hc.vary.balls(materials=["steel-52100"], diameters="4 mm to 5 mm")
    BallChoice(4 kinds of balls for '2:')
    """
    return BallChoice(catalogue, materials, diameters, beads, optional, start)


@checked_arguments("vary.order")
def order(*, beads: Beads = "2:") -> OrderChoice:
    """Order of the beads that the chain has.

    Parameters
    ----------
    beads : str or sequence of int
        Places whose beads are exchanged, as in `radii`.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.vary.order(beads="2:10")
    OrderChoice(order of the beads '2:10')
    """
    return OrderChoice(beads)

"""The chain of beads that is struck: its description, builders and checks.

Everything is in the scaled variables of the paper (Sec. 2): radii in units of
the first bead's radius, masses of the first bead's mass, velocities of the
strike's.  Bead ``k = 1..N`` counts from the struck end; contact ``k`` joins
beads ``k`` and ``k + 1``.  Arrays start at 0: ``chain.radii[0]`` is bead 1.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hertzchain.contacts import HERTZ_EXPONENT, Array, hertz_stiffness
from hertzchain.errors import InputError, real_number, unknown_name

Taper = Literal["backward-linear", "backward-exponential", "forward-linear", "forward-exponential"]
TAPERS: Final[tuple[Taper, ...]] = get_args(Taper)

# What an integration holds per bead: sixteen stages and the state, 8 bytes a number.
BYTES_PER_BEAD: Final = 400
# A radius below this is what rounding leaves of zero.
ROUNDING: Final = 1e-12
# Beyond it a contact is a hard wall, which steps in time cannot follow.
LARGEST_EXPONENT: Final = 50.0


@dataclass(frozen=True, eq=False)
class Chain:
    r"""A row of touching beads at rest; the first is struck with velocity one.

    Make one with a builder: `Chain.tapered`, `Chain.uniform` or
    `Chain.from_radii`.  The scaled equation of motion, Eq. (4) of the paper, is

    .. math::

        m_k \ddot x_k = r_{k-1}(x_{k-1}-x_k)_+^{p} - r_k (x_k-x_{k+1})_+^{p},
        \qquad v_1(0) = m_1 = R_1 = 1 .

    Attributes
    ----------
    radii : ndarray, shape (N,)
        Radii :math:`R_k` [scaled]; the first is 1.
    exponent : float
        Exponent p of the contact force, > 1; 3/2 for spheres (Hertz).
    taper : str or None
        Name of the taper, if the chain was built from one.
    rate : float or None
        Tapering parameter, S of a linear or q of an exponential taper.

    Examples
    --------
    >>> chain = Chain.tapered("backward-exponential", 0.05, beads=100)
    >>> chain
    Chain(backward-exponential, q = 0.05, 100 beads)
    >>> chain.radii[:3].round(4)
    array([1.    , 1.0526, 1.108 ])
    """

    radii: Array
    exponent: float = HERTZ_EXPONENT
    taper: Taper | None = None
    rate: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "exponent", _checked_exponent(self.exponent))
        object.__setattr__(self, "radii", _checked_radii(self.radii))
        if self.radii[0] != 1.0:
            raise InputError(
                f"the first of a chain's radii must be 1, got {self.radii[0]:g}; "
                "Chain.from_radii takes radii in any unit"
            )
        if (self.taper is None) != (self.rate is None):
            raise InputError("a chain has a taper and a rate or neither; use Chain.tapered")
        if self.taper is not None and self.rate is not None:
            check_taper(self.taper, self.rate, self.beads)
            if not np.array_equal(self.radii, _tapered_radii(self.taper, self.rate, self.beads)):
                raise InputError(
                    f"these radii are not those of a {self.taper} taper; use Chain.tapered"
                )

    @classmethod
    def tapered(
        cls, taper: str, rate: float, *, beads: int, exponent: float = HERTZ_EXPONENT
    ) -> Chain:
        r"""A chain whose radii grow (backward) or shrink (forward) along it.

        ====================  ============================  =====================
        taper                 radius of bead k              in the paper
        ====================  ============================  =====================
        backward-linear       :math:`1 + S(k-1)`            Eq. (6)
        backward-exponential  :math:`(1-q)^{-(k-1)}`        Eq. (7)
        forward-linear        :math:`1 - S(k-1)`            Eq. (19), N < 1 + 1/S
        forward-exponential   :math:`(1+q)^{-(k-1)}`        Eq. (21)
        ====================  ============================  =====================

        Parameters
        ----------
        taper : str
            One of the four names above.
        rate : float
            Tapering parameter: S > 0 of a linear, 0 < q < 1 of an exponential taper.
        beads : int
            Number of beads N, at least 2.
        exponent : float
            Exponent p of the contact force, > 1.

        Returns
        -------
        Chain

        Raises
        ------
        InputError
            For an unknown taper, a rate or number of beads out of range, or radii
            that overflow.

        Examples
        --------
        >>> Chain.tapered("forward-linear", 0.25, beads=4).radii
        array([1.  , 0.75, 0.5 , 0.25])
        """
        count = _checked_beads(beads)
        checked = check_taper(taper, rate, count)
        return cls(_tapered_radii(taper, checked, count), exponent, taper, checked)  # type: ignore[arg-type]

    @classmethod
    def uniform(cls, beads: int, *, exponent: float = HERTZ_EXPONENT) -> Chain:
        """A chain of equal beads, on which a strike becomes a solitary wave.

        Parameters
        ----------
        beads : int
            Number of beads N, at least 2.
        exponent : float
            Exponent p of the contact force, > 1.

        Returns
        -------
        Chain

        Raises
        ------
        InputError
            If there are fewer than two beads or more than fit in memory.

        Examples
        --------
        >>> Chain.uniform(20)
        Chain(uniform, 20 beads)
        """
        return cls(np.ones(_checked_beads(beads)), exponent)

    @classmethod
    def from_radii(cls, radii: ArrayLike, *, exponent: float = HERTZ_EXPONENT) -> Chain:
        """A chain of spheres of one material with any positive radii.

        Parameters
        ----------
        radii : array_like, shape (N,)
            Radii of the beads, struck bead first, in any one unit: the chain
            keeps them in units of the first.
        exponent : float
            Exponent p of the contact force, > 1.

        Returns
        -------
        Chain

        Raises
        ------
        InputError
            If a radius is not a positive finite number, or fewer than two are given.

        Examples
        --------
        >>> Chain.from_radii([5.0, 2.5, 5.0]).masses
        array([1.   , 0.125, 1.   ])
        """
        given = _positive_radii(radii)
        with np.errstate(over="ignore", under="ignore"):
            return cls(given / given[0], exponent)

    @property
    def beads(self) -> int:
        """Number of beads N."""
        return len(self.radii)

    @property
    def masses(self) -> Array:
        """Masses m_k = R_k^3 [scaled], Eq. (3) of the paper, shape (N,)."""
        return self.radii**3

    @property
    def stiffness(self) -> Array:
        """Contact stiffness r_k [scaled], below Eq. (4) of the paper, shape (N - 1,)."""
        return hertz_stiffness(self.radii[:-1], self.radii[1:])

    @property
    def description(self) -> str:
        """The chain in a few words, as it heads tables and figures."""
        kind = "free radii"
        if self.taper is not None:
            kind = f"{self.taper}, {rate_symbol(self.taper)} = {self.rate:g}"
        elif np.all(self.radii == 1.0):
            kind = "uniform"
        law = "" if self.exponent == HERTZ_EXPONENT else f", p = {self.exponent:g}"
        return f"{kind}, {self.beads} beads{law}"

    def __repr__(self) -> str:
        return f"Chain({self.description})"


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
    if taper not in TAPERS:
        hint = "; equal beads are Chain.uniform" if taper == "uniform" else ""
        raise InputError(str(unknown_name("taper", taper, TAPERS)) + hint)
    return "S" if taper.endswith("linear") else "q"


def _tapered_radii(taper: str, rate: float, beads: int) -> Array:
    step = np.arange(beads, dtype=float)
    with np.errstate(over="ignore", under="ignore"):
        if taper == "backward-linear":
            return 1.0 + rate * step
        if taper == "forward-linear":
            return 1.0 - rate * step
        ratio = 1.0 - rate if taper == "backward-exponential" else 1.0 + rate
        return np.asarray(ratio**-step)


def _checked_beads(beads: int) -> int:
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


def _checked_exponent(exponent: float) -> float:
    value = real_number("exponent of the contact force", exponent)
    if not 1.0 < value <= LARGEST_EXPONENT:
        raise InputError(
            f"exponent of the contact force must be above 1 and at most {LARGEST_EXPONENT:g}, "
            f"got {value:g}; Hertz contacts have 1.5"
        )
    return value


def _positive_radii(radii: ArrayLike) -> Array:
    """A copy of radii that are numbers, positive and finite, and at least two."""
    try:
        given = np.asarray(radii)
    except ValueError:
        raise InputError(f"radii must be a list of positive numbers, got {radii!r}") from None
    if given.dtype.kind not in "iuf":
        raise InputError(_first_unreadable(radii))
    if given.ndim != 1 or len(given) < 2:
        raise InputError(f"radii must be a list of at least two numbers, got {radii!r}")
    _checked_beads(len(given))
    values: NDArray[np.float64] = given.astype(float)
    good = (values > 0.0) & (values < math.inf)
    if not good.all():
        k = int(np.argmin(good))
        raise InputError(
            f"radius of bead {k + 1} is {values[k]:g}: radii must be positive and finite"
        )
    return values


def _checked_radii(radii: ArrayLike) -> Array:
    """Read-only copy of scaled radii whose masses can be represented."""
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
    values = _positive_radii(values)
    values.setflags(write=False)
    return values


def _first_unreadable(radii: object) -> str:
    if isinstance(radii, Sequence) and not isinstance(radii, str):
        for k, value in enumerate(radii, start=1):
            try:
                real_number("", value)
            except InputError:
                return f"radius of bead {k} is {value!r}: radii must be positive numbers"
    return f"radii must be a list of positive numbers, got {radii!r}"

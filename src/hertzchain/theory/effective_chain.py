r"""Reduce a decorated chain to its large beads, with effective contacts and masses.

A light bead between two heavy ones follows their motion immediately, with the same force F
on both of its contacts.  The contacts between neighbouring large beads then act as springs
in series, and the masses of the small beads are added to the large ones: U. Harbola,
A. Rosas, A. H. Romero, M. Esposito and K. Lindenberg, Phys. Rev. E 80, 051302 (2009),
arXiv:0909.2627, for one small bead.  The generalisation to any number of small beads of any
sizes is derived here.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..chain.chain import Chain
from ..chain.feature_support import require_supported
from ..collision import (
    HERTZ_EXPONENT,
    Array,
    collision_cascade,
    collision_overlap,
    compression_time,
    reduced_mass,
)  # fmt: skip
from ..errors import InputError, ModelRangeWarning, short_repr, warn_user
from ..frozen import Frozen
from ..pulse.notes import WARNING
from ..pulse.pulse import EFFECTIVE_CHAIN, Pulse
from ..representation import measure, short
from ..validation.keywords import checked_arguments, checked_methods
from ..validation.numbers import real_numbers, whole_number
from ..validation.objects import check_list
from .decoration import SMALL, small_beads, warn_if_steep
from .solitary_wave import solitary_wave

# Largest mass of the small beads between two large ones, over that of the lighter large bead,
# for which the spacing is accurate to about 0.2%: one small bead of half the radius.  For larger
# exponents p, it is (3/2p)^3 of this: a stiffer law makes a shorter pulse.
MAX_LOAD: Final = 0.125
# Notes of pulses of the whole chain, and a warning about their velocities and forces.
NOT_OF_SMALL: Final = "not predicted for small beads"
OF_LARGE: Final = "a large bead is reached when it becomes faster than the large one behind it"
NOT_OF_PAIRS: Final = "not predicted between large and small beads"
ONLY_TIMES: Final = (
    "only the times of an effective chain are predictions: in exponential tapers with q up to "
    "0.05, those from large bead to large bead differ by up to 7% from the simulation, but "
    "velocities are too large by 39% to 67%"
)


@checked_methods
@dataclass(frozen=True, eq=False)
class EffectiveChain(Frozen):
    r"""Large beads of a decorated chain, with effective contacts between them.

    It is returned by `effective_chain`.  The force between neighbours is
    :math:`k_{\mathrm{eff}} (x_j - x_{j+1})_+^p`.

    Attributes
    ----------
    masses : ndarray, shape (n,)
        Masses of the large beads, including shares of the small ones [scaled, or kg].
    stiffness : ndarray, shape (n - 1,)
        Effective stiffness between neighbours [scaled, or N/m^p].
    exponent : float
        Exponent p of the contact force.
    large_beads : ndarray of int, shape (n,)
        Bead numbers in the decorated chain, counted from 1.
    velocity : float
        Velocity with which bead 1 is struck [scaled, or m/s].
    units : str
        ``"scaled"`` or ``"SI"``.
    decorated : Chain or None
        The chain with small beads, with which `effective_chain` was called.

    Examples
    --------
    >>> import hertzchain as hc
    >>> effective = hc.effective_chain(hc.Chain.uniform(41).decorated(0.3))
    >>> effective
    EffectiveChain(41 large beads of 81, p = 1.5)
    >>> round(float(effective.masses[20]), 3)
    1.027
    """

    masses: Array
    stiffness: Array
    exponent: float
    large_beads: NDArray[np.int64]
    velocity: float = 1.0
    units: str = "scaled"
    decorated: Chain | None = None

    _instead_of_chain: ClassVar[str] = (
        "its methods bca() and spacing(velocity) give velocities, forces and times; give other "
        "methods the chain with small beads from which it was made"
    )

    def __post_init__(self) -> None:
        for values in (self.masses, self.stiffness, self.large_beads):
            values.setflags(write=False)

    def bca(self) -> EffectivePulse:
        r"""Binary collision approximation of the large beads.

        It is evaluated as in `hertzchain.bca`, with effective masses and stiffness, in the
        units of the chain.  Only its times are predictions: in exponential tapers with q up to
        0.05, those from large bead to large bead differ by up to 7% from simulations, but the
        velocities of large beads are too large by 39% to 67%, because in the BCA only two large
        beads touch at a time.

        Examples
        --------
        Equal large beads transfer their velocity completely, except at the ends of the chain,
        which have only half the share of the small beads:

        >>> import hertzchain as hc
        >>> effective = hc.effective_chain(hc.Chain.uniform(41).decorated(0.3))
        >>> effective.bca().velocity[[0, 1, 20]].round(5)
        array([1.     , 0.99338, 0.99338])
        """
        m, k, p = self.masses, self.stiffness, self.exponent
        velocity = self.velocity * collision_cascade(m)
        reduced, speed = reduced_mass(m[:-1], m[1:]), velocity[:-1]
        return EffectivePulse(
            bead=self.large_beads,
            velocity=velocity,
            arrival=np.concatenate(([0.0], np.cumsum(compression_time(reduced, k, speed, p)))),
            peak_force=k * collision_overlap(reduced, k, speed, p) ** p,
            units=self.units,
            chain=self.decorated,
        )

    def spacing(self, velocity: ArrayLike) -> Array:
        r"""Travel time of the pulse from each large bead to the next.

        .. math::

            T_j = \frac1C \left(\frac{\bar m}{k_{\mathrm{eff}}}\right)^{\frac1{p+1}}
                  \bar v^{\,-\frac{p-1}{p+1}}

        This is the time of the exact solitary wave, with the constant C of `solitary_wave`,
        the arithmetic mean of the masses and the geometric mean of the velocities of beads j
        and j + 1.  A taper of the large beads changes the pulse and therefore its speed: in
        simulations with a ratio of the small beads of 0.3 to 0.5, the times are too large by
        0.9%, 1.9%, 3.0% and 5.0 to 5.5% for a ``"forward-exponential"`` taper with q = 0.01,
        0.02, 0.03 and 0.05, and too small by 0.7 to 0.8%, 1.4 to 1.7%, 2.2 to 2.4% and 3.5 to
        3.8% for a ``"backward-exponential"`` one.

        Parameters
        ----------
        velocity : array_like
            Peak velocities of the large beads, shape (n,), or one for all [scaled, or m/s].

        Returns
        -------
        ndarray, shape (n - 1,)
            Times [scaled, or s].

        Raises
        ------
        InputError
            If a velocity is not positive, or the number of velocities is wrong.

        Warns
        -----
        ModelRangeWarning
            If the error that follows from the change of the sizes is larger than 2%.

        Examples
        --------
        Between the velocity maxima of beads 51 and 101 of 119, the mean time in the simulation
        is 2.12796:

        >>> import hertzchain as hc
        >>> effective = hc.effective_chain(hc.Chain.uniform(60).decorated(0.3))
        >>> round(float(effective.spacing(0.68012)[30]), 3)
        2.128
        """
        v = real_numbers("velocity", velocity, "large bead")
        if v.shape not in ((), self.masses.shape) or not np.all((v > 0.0) & np.isfinite(v)):
            raise InputError(
                f"velocity must be one positive number or one for each of the {len(self.masses)} "
                f"large beads, got {short_repr(velocity)}"
            )
        warn_if_steep(self.masses)
        v = np.broadcast_to(v, self.masses.shape)
        s, p = 1.0 / (self.exponent + 1.0), self.exponent
        mass = 0.5 * (self.masses[:-1] + self.masses[1:])
        mean = np.sqrt(v[:-1]) * np.sqrt(v[1:])
        constant = solitary_wave(p).speed_constant
        return np.asarray((mass / self.stiffness) ** s * mean ** (-(p - 1.0) * s) / constant)

    def _repr_html_(self) -> str:
        from ..notebook.theories import effective_chain_html

        return effective_chain_html(self)

    def __repr__(self) -> str:
        total = int(self.large_beads[-1])
        return f"EffectiveChain({len(self.masses)} large beads of {total}, p = {self.exponent:g})"


@checked_methods
@dataclass(frozen=True, eq=False)
class EffectivePulse(Frozen):
    """Leading pulse on the large beads of a decorated chain, from `EffectiveChain.bca`.

    Only its times are predictions (see there).  Comparisons and plots accept it like a `Pulse`;
    `pulse` returns that of the whole chain.

    Attributes
    ----------
    bead : ndarray of int, shape (n,)
        Bead numbers in the decorated chain, counted from 1.
    velocity : ndarray, shape (n,)
        Peak velocities [scaled, or m/s].
    arrival : ndarray, shape (n,)
        Times at which a large bead becomes faster than the large bead behind [scaled, or s].
    peak_force : ndarray, shape (n - 1,)
        Largest force between neighbours, the same on all contacts between them [scaled, or N].
    units : str
        ``"scaled"`` or ``"SI"``.
    chain : Chain or None
        The chain with small beads.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(41).decorated(0.3)
    >>> theory = hc.effective_chain(chain).bca().pulse()
    >>> comparison = theory.compare(hc.propagate(chain))
    >>> late = {"first_bead": 20}
    >>> print(f"{comparison.worst('arrival', **late):.1%}, "
    ...       f"{comparison.worst('velocity', **late):.0%}")
    2.4%, 46%
    """

    bead: NDArray[np.int64]
    velocity: Array
    arrival: Array
    peak_force: Array
    units: str = "scaled"
    chain: Chain | None = None

    def __post_init__(self) -> None:
        for values in (self.bead, self.velocity, self.arrival, self.peak_force):
            values.setflags(write=False)

    def pulse(self) -> Pulse:
        """The pulse of the chain with small beads, whose velocities and times are NaN.

        Returns
        -------
        Pulse
            By the method ``"effective chain"``, in the units of the chain.

        Raises
        ------
        InputError
            If the effective chain was not made by `effective_chain`.

        Examples
        --------
        >>> import hertzchain as hc
        >>> found = hc.effective_chain(hc.Chain.uniform(3).decorated(0.3)).bca().pulse()
        >>> found.velocity.round(3)
        array([1.   ,   nan, 0.993,   nan, 1.   ])
        """
        if self.chain is None:
            raise InputError(
                "this effective chain has no chain with small beads; use effective_chain(chain)"
            )
        velocity, arrival = np.full((2, self.chain.beads), np.nan)
        velocity[self.bead - 1], arrival[self.bead - 1] = self.velocity, self.arrival
        force = np.repeat(self.peak_force, np.diff(self.bead))
        overlap = (force / self.chain.stiffness) ** (1.0 / self.chain.exponents)
        notes = {
            "velocity": NOT_OF_SMALL, "arrival": f"{NOT_OF_SMALL}; {OF_LARGE}",
            "residence": NOT_OF_PAIRS, WARNING: ONLY_TIMES,
        }  # fmt: skip
        return Pulse(
            self.chain, EFFECTIVE_CHAIN, velocity, arrival=arrival, peak_overlap=overlap,
            notes=notes,
        )  # fmt: skip

    # Comparisons and plots call it.
    _as_pulse = pulse

    def __repr__(self) -> str:
        last, arrival, force = (
            measure(value, unit, self.units)
            for value, unit in (
                (self.velocity[-1], "m/s"), (self.arrival[-1], "s"), (self.peak_force.max(), "N")
            )
        )  # fmt: skip
        facts = f"v_{self.bead[-1]} = {last}", f"arrival {arrival}", f"largest force {force}"
        return short("EffectivePulse", f"{len(self.bead)} large beads", *facts)


@checked_arguments("effective_chain")
def effective_chain(chain: Chain, large: Sequence[int] | None = None) -> EffectiveChain:
    r"""Replace the small beads of a decorated chain by effective contacts and masses.

    All contacts between two neighbouring large beads a and b, with stiffness k_i, carry the
    same force, and their overlaps add up:

    .. math::

        k_{\mathrm{eff}} = \Bigl(\sum_i k_i^{-1/p}\Bigr)^{-p}, \qquad
        x_j = (1-\lambda_j)\,x_a + \lambda_j\,x_b, \qquad
        \lambda_j = \frac{\sum_{i \le j} k_i^{-1/p}}{\sum_i k_i^{-1/p}} .

    The small bead j adds :math:`(1-\lambda_j)\,m_j` to the mass of bead a and
    :math:`\lambda_j m_j` to that of bead b, which conserves momentum.  Between equal large
    beads, `EffectiveChain.spacing` agrees with the simulation to 0.2% for one small bead of up
    to half the radius, and to 0.25% for several small beads that have one eighth of the mass in
    total; for exponents p from 3/2 to 3, to 0.4% up to :math:`(3/2p)^3/8` of the mass. The
    energy that remains in the small beads is neglected, and so is the decay of the pulse at
    resonant size ratios.

    Parameters
    ----------
    chain : Chain
        A chain, scaled or in SI units, with one or more small beads between some or all of its
        large ones, such as `Chain.decorated` returns; both may be tapered.  The first and the
        last bead are always treated as large.
    large : sequence of int, optional
        Numbers of the large beads, counted from 1.  By default they are found from the radii:
        small beads are runs of beads smaller than both neighbours by a factor of more than
        1/0.8.

    Raises
    ------
    InputError
        If no small beads are found, a small bead is not smaller than its large neighbours,
        or ``large`` is not an ascending list of bead numbers from 1 to N.

    Warns
    -----
    ModelRangeWarning
        If the small beads between two large ones have more than one eighth of the mass of
        the lighter large bead or, for an exponent p above 3/2, more than :math:`(3/2p)^3/8` of it.

    Examples
    --------
    Two equal contacts in series have :math:`2^{-3/2}` times the stiffness of one:

    >>> import hertzchain as hc
    >>> decorated = hc.Chain.uniform(2).decorated(0.25)
    >>> float(hc.effective_chain(decorated).stiffness[0] / decorated.stiffness[0]).__round__(6)
    0.353553
    """
    require_supported(
        chain,
        "effective_chain",
        supported=("SI units", "masses", "stiffness"),
        alternative="use simulate",
    )
    index = _detected(chain) if large is None else _checked_large(chain, large)
    _check_small(chain, index)
    masses, springs = chain.masses, chain.stiffness ** (-1.0 / chain.exponents)
    effective, softness = masses[index].copy(), np.empty(len(index) - 1)
    for j, (a, b) in enumerate(itertools.pairwise(index)):
        softness[j] = springs[a:b].sum()
        share = np.cumsum(springs[a : b - 1]) / softness[j]
        between = masses[a + 1 : b]
        effective[j] += np.sum((1.0 - share) * between)
        effective[j + 1] += np.sum(share * between)
    return EffectiveChain(
        effective, softness**-chain.exponents, chain.exponents, index + 1,
        float(chain.velocities[0]), chain.units, chain,
    )  # fmt: skip


def _detected(chain: Chain) -> NDArray[Any]:
    small = small_beads(chain.radii)
    if not small.any():
        raise InputError(
            f"effective_chain requires small beads between large ones, but {chain.description} has "
            f"no radii below {SMALL:g} of both neighbours; use bca, or give large"
        )
    return np.flatnonzero(~small)


def _checked_large(chain: Chain, large: Sequence[int]) -> NDArray[Any]:
    given = check_list("large", large, "bead numbers")
    index = np.array([whole_number("large bead", k, least=1, most=chain.beads) for k in given])
    ends = len(index) >= 2 and index[0] == 1 and index[-1] == chain.beads
    if not ends or np.any(np.diff(index) <= 0):
        raise InputError(
            f"large must be ascending bead numbers that include 1 and {chain.beads} (the first and "
            f"the last bead have only one neighbour), got {short_repr(large)}"
        )
    return index - 1


def _check_small(chain: Chain, index: NDArray[Any]) -> None:
    """Reject beads that are not small, and warn about beads that are not light enough."""
    between = np.diff(index) - 1
    small = np.delete(np.arange(chain.beads), index)
    left, right = chain.radii[index[:-1]], chain.radii[index[1:]]
    ratio = chain.radii[small] / np.repeat(np.minimum(left, right), between)
    if len(small) and ratio.max() >= 1.0:
        bead = small[np.argmax(ratio)] + 1
        raise InputError(
            f"bead {bead} is between large beads but has {ratio.max():.3g} times the radius of one "
            "of them; include it in large"
        )
    cell = np.repeat(np.arange(len(between)), between)
    masses = chain.masses
    lighter = np.minimum(masses[index[:-1]], masses[index[1:]])
    load = np.bincount(cell, weights=masses[small], minlength=len(between)) / lighter
    worst = int(np.argmax(load))
    share = min(1.0, HERTZ_EXPONENT / chain.exponents)
    limit, accuracy = MAX_LOAD * share**3, "0.2%" if share == 1.0 else "0.4%"
    if load[worst] > limit * (1.0 + 1e-9):
        warn_user(
            f"the small beads between beads {index[worst] + 1} and {index[worst + 1] + 1} have "
            f"{load[worst]:.3g} times the mass of the lighter of the two; the effective chain is "
            f"accurate to {accuracy} only up to {limit:.3g} (one small bead of {0.5 * share:.3g} "
            "times the radius), because heavier beads do not follow their neighbours immediately",
            ModelRangeWarning,
        )

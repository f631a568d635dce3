r"""Decorated chains: small beads between large ones, done away with.

A light bead between two heavy ones follows them at once, with one force F on both of
its contacts.  The contacts between neighbouring large beads are then springs in series,
and the small beads' masses belong to the large ones: U. Harbola, A. Rosas, A. H. Romero,
M. Esposito and K. Lindenberg, Phys. Rev. E 80, 051302 (2009), arXiv:0909.2627, for one
bead; derived here for any number of any sizes.
"""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hertzchain.arguments import listed
from hertzchain.chain.chain import Chain
from hertzchain.chain.coverage import require
from hertzchain.checks import real_numbers, whole_number
from hertzchain.contacts import (
    Array,
    collision_cascade,
    collision_overlap,
    compression_time,
    reduced_mass,
)
from hertzchain.errors import InputError, ModelRangeWarning, shown
from hertzchain.frozen import Frozen
from hertzchain.theory.decoration import SMALL, small_beads
from hertzchain.theory.solitary_wave import solitary_wave

# Largest mass of the small beads between two large ones, over that of the smaller of these,
# up to which the spacing is right to about 0.2 per cent: one small bead of half the radius.
LARGEST_LOAD: Final = 0.125


@dataclass(frozen=True, eq=False)
class EffectiveChain(Frozen):
    r"""The large beads of a decorated chain, with the effective contacts between them.

    Made by `effective_chain`.  The force between neighbours is
    :math:`k_{\mathrm{eff}} (x_j - x_{j+1})_+^p`.

    Attributes
    ----------
    masses : ndarray, shape (n,)
        Masses of the large beads, shares of the small ones included [scaled].
    stiffness : ndarray, shape (n - 1,)
        Effective stiffness between neighbours [scaled].
    exponent : float
        Exponent p of the contact force.
    large_beads : ndarray of int, shape (n,)
        Their bead numbers in the decorated chain, counted from 1.

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

    def __post_init__(self) -> None:
        for values in (self.masses, self.stiffness, self.large_beads):
            values.setflags(write=False)

    def bca(self) -> EffectivePulse:
        r"""Binary collision approximation of the large beads.

        As `hertzchain.bca`, with effective masses and stiffness: the first bead has
        velocity one.

        Returns
        -------
        EffectivePulse

        Examples
        --------
        Equal large beads hand on their velocity, but for the ends of the chain, which
        have half the share of the small beads:

        >>> import hertzchain as hc
        >>> effective = hc.effective_chain(hc.Chain.uniform(41).decorated(0.3))
        >>> effective.bca().velocity[[0, 1, 20]].round(5)
        array([1.     , 0.99338, 0.99338])
        """
        m, k, p = self.masses, self.stiffness, self.exponent
        velocity = collision_cascade(m)
        reduced, speed = reduced_mass(m[:-1], m[1:]), velocity[:-1]
        return EffectivePulse(
            bead=self.large_beads,
            velocity=velocity,
            arrival=np.concatenate(([0.0], np.cumsum(compression_time(reduced, k, speed, p)))),
            peak_force=k * collision_overlap(reduced, k, speed, p) ** p,
        )

    def spacing(self, velocity: ArrayLike) -> Array:
        r"""Time of the pulse from each large bead to the next, at the exact wave's speed.

        .. math::

            T_j = \frac1C \left(\frac{\bar m}{k_{\mathrm{eff}}}\right)^{\frac1{p+1}}
                  \bar v^{\,-\frac{p-1}{p+1}}

        with the constant C of `solitary_wave`, and the means of the masses (arithmetic)
        and velocities (geometric) of beads j and j + 1.  A taper of the large beads changes
        the pulse and with it the speed: by 2 per cent if radii change by 2 per cent a bead.

        Parameters
        ----------
        velocity : array_like
            Peak velocities of the large beads, shape (n,), or one for all [scaled].

        Returns
        -------
        ndarray, shape (n - 1,)
            Times [scaled].

        Raises
        ------
        InputError
            If a velocity is not positive, or their number is not that of the beads.

        Examples
        --------
        Between velocity maxima of beads 51 and 101 of 119, the integration has 2.12796:

        >>> import hertzchain as hc
        >>> effective = hc.effective_chain(hc.Chain.uniform(60).decorated(0.3))
        >>> round(float(effective.spacing(0.68012)[30]), 3)
        2.128
        """
        v = real_numbers("velocity", velocity, "large bead")
        if v.shape not in ((), self.masses.shape) or not np.all((v > 0.0) & np.isfinite(v)):
            raise InputError(
                f"velocity must be one positive number or one for each of the {len(self.masses)} "
                f"large beads, got {shown(velocity)}"
            )
        v = np.broadcast_to(v, self.masses.shape)
        s, p = 1.0 / (self.exponent + 1.0), self.exponent
        mass = 0.5 * (self.masses[:-1] + self.masses[1:])
        mean = np.sqrt(v[:-1]) * np.sqrt(v[1:])
        constant = solitary_wave(p).speed_constant
        return np.asarray((mass / self.stiffness) ** s * mean ** (-(p - 1.0) * s) / constant)

    def __repr__(self) -> str:
        total = int(self.large_beads[-1])
        return f"EffectiveChain({len(self.masses)} large beads of {total}, p = {self.exponent:g})"


@dataclass(frozen=True, eq=False)
class EffectivePulse:
    """The leading pulse on the large beads of a decorated chain, by `EffectiveChain.bca`.

    Attributes
    ----------
    bead : ndarray of int, shape (n,)
        Bead numbers in the decorated chain, counted from 1.
    velocity : ndarray, shape (n,)
        Peak velocities [scaled].
    arrival : ndarray, shape (n,)
        Times at which a large bead becomes faster than the large one behind [scaled].
    peak_force : ndarray, shape (n - 1,)
        Largest force between neighbours, on all contacts between them [scaled].
    """

    bead: NDArray[np.int64]
    velocity: Array
    arrival: Array
    peak_force: Array


def effective_chain(chain: Chain, large: Sequence[int] | None = None) -> EffectiveChain:
    r"""Replace the small beads of a decorated chain by what they do to the large ones.

    Between two neighbouring large beads a and b, contacts of stiffness k_i bear one force,
    so that their overlaps add as

    .. math::

        k_{\mathrm{eff}} = \Bigl(\sum_i k_i^{-1/p}\Bigr)^{-p}, \qquad
        x_j = (1-\lambda_j)\,x_a + \lambda_j\,x_b, \qquad
        \lambda_j = \frac{\sum_{i \le j} k_i^{-1/p}}{\sum_i k_i^{-1/p}} .

    The small bead j gives :math:`(1-\lambda_j)\,m_j` to bead a and :math:`\lambda_j m_j` to
    b, which keeps the momentum.  Between equal large beads `EffectiveChain.spacing` is within
    0.2 per cent of the integration for one small bead of up to half the radius, and within
    0.25 per cent for several of together one eighth of the mass.  What the small beads keep
    of the energy, and so the decay of the pulse at ratios that resonate, is left out.

    Parameters
    ----------
    chain : Chain
        A chain with one or more small beads between some or all of its large ones, as
        `Chain.decorated` makes them; both may be tapered.  Its first and last bead count as
        large, whatever their size.
    large : sequence of int, optional
        Bead numbers of the large beads, counted from 1; found from the radii by default:
        small beads are runs that both neighbours exceed by more than a factor of 1/0.8.

    Returns
    -------
    EffectiveChain

    Raises
    ------
    InputError
        If no small beads are found, a small one is not smaller than its large neighbours,
        or the numbers given are not rising bead numbers from 1 to N.

    Warns
    -----
    ModelRangeWarning
        If the small beads between two large ones have more than one eighth of the mass of
        the smaller of these.

    Examples
    --------
    Two equal contacts in series are :math:`2^{-3/2}` as stiff as one:

    >>> import hertzchain as hc
    >>> decorated = hc.Chain.uniform(2).decorated(0.25)
    >>> float(effective_chain(decorated).stiffness[0] / decorated.stiffness[0]).__round__(6)
    0.353553
    """
    require(chain, "effective_chain", covers=("masses", "stiffness"), instead="use simulate")
    index = _detected(chain) if large is None else _checked_large(chain, large)
    _check_small(chain, index)
    masses, springs = chain.masses, chain.stiffness ** (-1.0 / chain.exponent)
    effective, softness = masses[index].copy(), np.empty(len(index) - 1)
    for j, (a, b) in enumerate(itertools.pairwise(index)):
        softness[j] = springs[a:b].sum()
        share = np.cumsum(springs[a : b - 1]) / softness[j]
        between = masses[a + 1 : b]
        effective[j] += np.sum((1.0 - share) * between)
        effective[j + 1] += np.sum(share * between)
    return EffectiveChain(effective, softness**-chain.exponent, chain.exponent, index + 1)


def _detected(chain: Chain) -> NDArray[Any]:
    small = small_beads(chain.radii)
    if not small.any():
        raise InputError(
            f"effective_chain needs small beads between large ones; {chain.description} has none "
            f"below {SMALL:g} of both neighbours: use bca, or name the large beads"
        )
    return np.flatnonzero(~small)


def _checked_large(chain: Chain, large: Sequence[int]) -> NDArray[Any]:
    given = listed("large", large, "bead numbers")
    index = np.array([whole_number("large bead", k, least=1, most=chain.beads) for k in given])
    ends = len(index) >= 2 and index[0] == 1 and index[-1] == chain.beads
    if not ends or np.any(np.diff(index) <= 0):
        raise InputError(
            f"large must be rising bead numbers from 1 to {chain.beads}, both included (the first "
            f"and the last bead have no neighbour on one side), got {shown(large)}"
        )
    return index - 1


def _check_small(chain: Chain, index: NDArray[Any]) -> None:
    """Refuse small beads that are not small, and warn of those that are not light enough."""
    between = np.diff(index) - 1
    small = np.delete(np.arange(chain.beads), index)
    left, right = chain.radii[index[:-1]], chain.radii[index[1:]]
    ratio = chain.radii[small] / np.repeat(np.minimum(left, right), between)
    if len(small) and ratio.max() >= 1.0:
        bead = small[np.argmax(ratio)] + 1
        raise InputError(
            f"bead {bead} lies between large beads but has {ratio.max():.3g} "
            "of the radius of one of them: count it among the large ones"
        )
    cell = np.repeat(np.arange(len(between)), between)
    load = np.bincount(cell, weights=ratio**3, minlength=len(between))
    worst = int(np.argmax(load))
    if load[worst] > LARGEST_LOAD * (1.0 + 1e-9):
        warnings.warn(
            f"the small beads between beads {index[worst] + 1} and {index[worst + 1] + 1} have "
            f"{load[worst]:.3g} of the mass of a large one: the effective chain is right to 0.2 "
            f"per cent up to {LARGEST_LOAD:g} only (one small bead of half the radius), since "
            "heavier beads do not follow their neighbours at once",
            ModelRangeWarning,
            stacklevel=3,
        )

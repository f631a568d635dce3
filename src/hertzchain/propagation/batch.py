"""Concatenated chains and their pulse data, in the array layout of the kernels.

The beads of all chains are stored one after the other, with five results per bead.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..chain.chain import Chain
from ..collision import HERTZ_EXPONENT, Array, hertz_stiffness

Indices = NDArray[np.int64]

# Rows of the result.
VELOCITY, PEAK_TIME, ARRIVAL, PEAK_OVERLAP, RESIDENCE, COLUMNS = range(6)
# Velocity, peak time and arrival of the struck bead.
STRUCK = np.array([[1.0], [0.0], [0.0]])
STRIKER_COLUMNS = len(STRUCK)


@dataclass(frozen=True, eq=False)
class Batch:
    """Concatenated chains, each in units in which its first bead moves with velocity 1.

    Attributes
    ----------
    masses, stiffness, exponents : ndarray, shape (M,)
        Masses of all beads, stiffness and exponents of the contacts ahead of them; the entry of
        the last bead of each chain has stiffness 0 and the exponent of the previous contact.
    first, beads : ndarray, shape (C,)
        Index of the first bead and number of beads of each chain.
    units : ndarray, shape (C, 3), or None
        Units of velocity, time and length of each chain; all are 1 if there are none.
    """

    masses: Array
    stiffness: Array
    exponents: Array
    first: Indices
    beads: Indices
    units: Array | None = None

    @classmethod
    def of(cls, chains: Sequence[Chain]) -> Batch:
        """Concatenate chains."""
        beads = np.array([chain.beads for chain in chains])
        units = [_units(chain) for chain in chains]
        parts = [_in_units(chain, *own) for chain, own in zip(chains, units, strict=True)]
        masses, stiffness, exponents = (np.concatenate(each) for each in zip(*parts, strict=True))
        scales = np.array([(speed, length / speed, length) for length, _, speed in units])
        return cls(
            masses, stiffness, exponents, np.cumsum(beads) - beads, beads,
            None if np.all(scales == 1.0) else scales,
        )  # fmt: skip

    @classmethod
    def of_radii(cls, radii: Array, beads: Indices) -> Batch:
        """Chains of scaled radii, one after the other."""
        first = np.cumsum(beads) - beads
        stiffness = np.zeros(len(radii))
        stiffness[:-1] = hertz_stiffness(radii[:-1], radii[1:])
        stiffness[first + beads - 1] = 0.0
        return cls(radii**3, stiffness, np.full(len(radii), HERTZ_EXPONENT), first, beads)

    @cached_property
    def chain_exponents(self) -> Array:
        """Exponent of each chain; NaN if its contacts differ."""
        least = np.minimum.reduceat(self.exponents, self.first)
        same = least == np.maximum.reduceat(self.exponents, self.first)
        return np.where(same, least, np.nan)

    def chain(self, index: int) -> Chain:
        """One of the chains, as a scaled `Chain` with its masses and stiffness but radii of 1."""
        start = self.first[index]
        end = start + self.beads[index]
        p = self.exponents[start : end - 1]
        return Chain(
            np.ones(end - start),
            p if np.isnan(self.chain_exponents[index]) else float(p[0]),
            masses=self.masses[start:end],
            stiffness=self.stiffness[start : end - 1],
        )

    @cached_property
    def given(self) -> Array:
        """Inverse masses, contact stiffness and exponents of all beads, for the kernels."""
        return np.array([1.0 / self.masses, self.stiffness, self.exponents])

    def beads_of(self, chains: Indices) -> NDArray[np.bool_]:
        """Mask of the beads that belong to given chains."""
        chosen: NDArray[np.bool_] = np.isin(np.arange(len(self.beads)), chains)
        return np.repeat(chosen, self.beads)


@dataclass(frozen=True, eq=False)
class PulseData:
    """Pulse data of the beads of a `Batch`.

    Attributes
    ----------
    columns : ndarray, shape (5, M)
        First velocity maxima, their times, arrival times, largest overlaps and residence
        times.  The last overlap and the last residence time of each chain are NaN.
    reasons : dict
        Reasons why chains failed, by index; their columns are NaN.
    """

    columns: Array
    reasons: dict[int, str]


def difference(found: Array, other: Array, first: Indices) -> Array:
    """Largest relative difference between two results, for each chain."""
    # The struck bead's times are 0, and entries of contacts after the last bead are NaN.
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.nan_to_num(np.abs(found / other - 1.0), nan=0.0, posinf=np.inf)
    return np.maximum.reduceat(relative.max(axis=0), first)


def _units(chain: Chain) -> tuple[float, float, float]:
    """Units of length, mass and velocity in which a chain is integrated.

    For a scaled chain, only the unit of velocity is changed: its values are not rounded.
    """
    speed = float(chain.velocities[0])
    if chain.scaled:
        return 1.0, 1.0, speed
    p = chain.exponents
    power = (p if isinstance(p, float) else float(p[0])) + 1.0
    mass = float(chain.masses[0])
    return (mass * speed * speed / float(chain.stiffness[0])) ** (1.0 / power), mass, speed


def _in_units(chain: Chain, length: float, mass: float, speed: float) -> tuple[Array, Array, Array]:
    """Masses, stiffness and exponents of a chain, the last two with an entry for the last bead."""
    exponents, stiffness = np.empty(chain.beads), np.zeros(chain.beads)
    exponents[:-1] = chain.exponents
    exponents[-1] = exponents[-2]
    stiffness[:-1] = chain.stiffness
    if mass == length == speed == 1.0:
        return chain.masses, stiffness, exponents
    with np.errstate(over="ignore", under="ignore"):
        stiffness *= length ** (exponents + 1.0) / (mass * speed * speed)
    return chain.masses / mass, stiffness, exponents

"""Concatenated chains and their pulse data, in the array layout of the kernels.

The beads of all chains are stored one after the other, with five results per bead.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..chain.chain import Chain
from ..collision import Array, hertz_stiffness

Indices = NDArray[np.int64]

# Entries of the array with which another thread stops the computation and reads its progress.
STOP, PASSED = 0, 1

# Rows of the result.
VELOCITY, PEAK_TIME, ARRIVAL, PEAK_OVERLAP, RESIDENCE, COLUMNS = range(6)
# Velocity, peak time and arrival of the struck bead.
STRUCK = np.array([[1.0], [0.0], [0.0]])
STRIKER_COLUMNS = len(STRUCK)


@dataclass(frozen=True, eq=False)
class Batch:
    """Concatenated chains.

    Attributes
    ----------
    radii : ndarray, shape (M,)
        Radii of all beads [scaled].
    first, beads : ndarray, shape (C,)
        Index of the first bead and number of beads of each chain.
    exponents : ndarray, shape (C,)
        Exponent of each chain's force law.
    """

    radii: Array
    first: Indices
    beads: Indices
    exponents: Array

    @classmethod
    def of(cls, chains: Iterable[Chain]) -> Batch:
        """Concatenate chains."""
        listed = list(chains)
        beads = np.array([chain.beads for chain in listed])
        return cls(
            radii=np.concatenate([chain.radii for chain in listed]),
            first=np.cumsum(beads) - beads,
            beads=beads,
            exponents=np.array([chain.exponents for chain in listed]),
        )

    def chain(self, index: int) -> Chain:
        """One of the chains, as a `Chain`."""
        start = self.first[index]
        return Chain(self.radii[start : start + self.beads[index]], float(self.exponents[index]))

    def given(self) -> Array:
        """Inverse masses and contact stiffness of all beads, in the layout of the kernels."""
        given = np.zeros((2, len(self.radii)))
        given[0] = self.radii**-3.0
        given[1, :-1] = hertz_stiffness(self.radii[:-1], self.radii[1:])
        given[1, self.first + self.beads - 1] = 0.0
        return given

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

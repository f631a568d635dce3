"""Chains put end to end, and what passes them: what the engines work on.

Arrays for the compiled kernels, without any engine: the beads of all chains in one row, and
five numbers for each that become known as the pulse passes.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hertzchain.chain.chain import Chain
from hertzchain.contacts import Array, hertz_stiffness

Indices = NDArray[np.int64]

# Entries of the array by which another thread stops the work, and sees how far it is.
STOP, PASSED = 0, 1

# Rows of the result.
VELOCITY, PEAK_TIME, ARRIVAL, PEAK_OVERLAP, RESIDENCE, COLUMNS = range(6)
# Velocity, peak time and arrival of the struck bead, the first columns.
STRUCK = np.array([[1.0], [0.0], [0.0]])
STRIKER_KNOWS = len(STRUCK)


@dataclass(frozen=True, eq=False)
class Batch:
    """Chains put end to end: the beads of all of them in one row.

    Attributes
    ----------
    radii : ndarray, shape (M,)
        Radii of all beads [scaled].
    first, beads : ndarray, shape (C,)
        Where each chain begins in that row, and how many beads it has.
    exponents : ndarray, shape (C,)
        Exponent of each chain's force law.
    """

    radii: Array
    first: Indices
    beads: Indices
    exponents: Array

    @classmethod
    def of(cls, chains: Iterable[Chain]) -> Batch:
        """Put chains end to end.

        Parameters
        ----------
        chains : iterable of Chain
            At least one chain.

        Returns
        -------
        Batch

        Examples
        --------
        >>> Batch.of([Chain.uniform(2), Chain.uniform(3)]).first
        array([0, 2])
        """
        listed = list(chains)
        beads = np.array([chain.beads for chain in listed])
        return cls(
            radii=np.concatenate([chain.radii for chain in listed]),
            first=np.cumsum(beads) - beads,
            beads=beads,
            exponents=np.array([chain.exponent for chain in listed]),
        )

    def chain(self, index: int) -> Chain:
        """One of the chains.

        Parameters
        ----------
        index : int
            Its number, from 0.

        Returns
        -------
        Chain

        Examples
        --------
        >>> Batch.of([Chain.uniform(2), Chain.uniform(3)]).chain(1).beads
        3
        """
        start = self.first[index]
        return Chain(self.radii[start : start + self.beads[index]], float(self.exponents[index]))

    def given(self) -> Array:
        """Inverse masses and contact stiffness of all beads, as the kernels take them.

        Returns
        -------
        ndarray, shape (2, M)
            The contact after the last bead of a chain has stiffness 0.

        Examples
        --------
        >>> Batch.of([Chain.uniform(2), Chain.uniform(3)]).given()[1]
        array([1., 0., 1., 1., 0.])
        """
        given = np.zeros((2, len(self.radii)))
        given[0] = self.radii**-3.0
        given[1, :-1] = hertz_stiffness(self.radii[:-1], self.radii[1:])
        given[1, self.first + self.beads - 1] = 0.0
        return given

    def beads_of(self, chains: Indices) -> NDArray[np.bool_]:
        """Which of all beads belong to some of the chains.

        Parameters
        ----------
        chains : ndarray of int
            Numbers of the chains, from 0.

        Returns
        -------
        ndarray of bool, shape (M,)

        Examples
        --------
        >>> Batch.of([Chain.uniform(2), Chain.uniform(3)]).beads_of(np.array([1]))
        array([False, False,  True,  True,  True])
        """
        chosen: NDArray[np.bool_] = np.isin(np.arange(len(self.beads)), chains)
        return np.repeat(chosen, self.beads)


@dataclass(frozen=True, eq=False)
class Passage:
    """What passed the beads of a `Batch`.

    Attributes
    ----------
    columns : ndarray, shape (5, M)
        First velocity maxima, their times, arrival times, largest overlaps and residence
        times; the last entry of the overlaps and residences of each chain is NaN.
    reasons : dict
        Why a chain could not be followed, by its number; its columns are NaN.
    """

    columns: Array
    reasons: dict[int, str]


def difference(found: Array, other: Array, first: Indices) -> Array:
    """Largest relative difference of two results, of each chain.

    Parameters
    ----------
    found, other : ndarray, shape (any, M)
        Columns, or some of them.
    first : ndarray, shape (C,)
        Where each chain begins.

    Returns
    -------
    ndarray, shape (C,)

    Examples
    --------
    >>> difference(np.array([[1.0, 2.0, 3.0]]), np.array([[1.0, 2.0, 4.0]]), np.array([0, 2]))
    array([0.  , 0.25])
    """
    # The striker's times are 0, and no number stands for a contact after the last bead.
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.nan_to_num(np.abs(found / other - 1.0), nan=0.0, posinf=np.inf)
    return np.maximum.reduceat(relative.max(axis=0), first)

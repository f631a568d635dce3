"""Bands of a periodic host with a few other beads, and its localised modes; base of `Spectrum`."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..collision import Array
from ..errors import InputError, unavailable_without
from .band_structure import BandStructure
from .bands import SAME, plane_waves, slow_wave_speed
from .linear_contacts import LinearContacts

# Largest cell of a host, and the largest part of its beads that others replace.
MAX_CELL: Final = 4
MAX_OTHERS: Final = 0.2
# Distance from a band, relative to the highest band edge, at which a mode is outside of it.
OUTSIDE: Final = 1e-9


class HostBands(BandStructure):
    """Properties of a spectrum that belong to localised modes."""

    modes: Array | NDArray[np.complex128]

    @property
    def frequencies(self) -> Array:
        """Frequencies of the modes."""
        raise NotImplementedError

    @property
    def _energies(self) -> Array:
        """Energy of each bead in each mode, up to a factor of the mode, shape (N, M)."""
        return np.asarray(self.contacts.masses[:, np.newaxis] * np.abs(self.modes) ** 2)

    @property
    def _undamped(self) -> Array:
        """Frequencies of the shapes of the modes without dampers, by Rayleigh's quotient."""
        if not self.contacts.dampers.any():
            return self.frequencies
        stretched = np.diff(np.pad(self.modes, ((1, 1), (0, 0))), axis=0)
        stored = self.contacts.springs @ np.abs(stretched) ** 2
        return np.asarray(np.sqrt(stored / self._energies.sum(axis=0)) / (2.0 * math.pi))

    @property
    def participation(self) -> Array:
        r"""Number of beads that take part in each mode, shape (M,).

        .. math:: \left(\sum_k e_k\right)^2 \Big/ \sum_k e_k^2, \qquad e_k = m_k |x_k|^2

        Two thirds of all beads for standing waves of equal beads, close to 1 if one bead moves.

        Examples
        --------
        >>> import hertzchain as hc
        >>> held = hc.Chain.uniform(30).replace(precompression=1.0, held_by="force")
        >>> hc.spectrum(held).participation[[0, 10]].round(6)
        array([30., 20.])
        """
        energy = self._energies
        return np.asarray(energy.sum(axis=0) ** 2 / (energy**2).sum(axis=0))

    @property
    @unavailable_without
    def host_edges(self) -> Array:
        """Edges of the bands of the periodic host of a chain with a few odd beads, shape (C, 2).

        The host is the infinite chain with the masses and springs that most of the cells have; for
        a periodic chain, these are the `band_edges`.

        Raises
        ------
        InputError
            If more than a fifth of the beads differ from any cell of up to four beads, or more than
            a fifth of the contacts other than those of such beads, as under gravity.

        Examples
        --------
        >>> import hertzchain as hc
        >>> held = hc.Chain.uniform(40).replace(precompression=1.0, held_by="force")
        >>> hc.spectrum(held.with_defects({20: 0.5})).host_edges.round(6)
        array([[0.      , 0.389848]])
        """
        host, cell = _host(self.contacts, self.chain.description)
        return np.sort(plane_waves(host, cell, np.array([0.0, math.pi])), axis=0).T.copy()

    @property
    @unavailable_without
    def host_sound_speed(self) -> float:
        """Speed of long waves in the periodic host of a chain with a few other beads.

        In the units of `sound_speed`, which it is for a periodic chain.  Long waves in the parts of
        the chain without other beads have this speed.

        Raises
        ------
        InputError
            If the chain has no host, as for `host_edges`.

        Examples
        --------
        A light bead in a row of steel balls:

        >>> import hertzchain as hc
        >>> balls = hc.Chain.from_materials(5e-3, "steel-52100", beads=40)
        >>> held = balls.replace(precompression=1.0, held_by="force")
        >>> odd = held.with_defects({20: 2.5e-3})
        >>> [round(hc.spectrum(each).host_sound_speed, 1) for each in (held, odd)]
        [374.5, 374.5]
        """
        host, cell = _host(self.contacts, self.chain.description)
        distances = [_usual(self.chain.centre_distances[i::cell]) for i in range(cell)]
        return slow_wave_speed(host, np.array(distances))

    @property
    def localised(self) -> NDArray[np.intp]:
        """Numbers, from 1, of the modes whose frequencies are outside all bands of the host.

        Mode j has the frequency ``frequencies[j - 1]`` and the shape ``modes[:, j - 1]``.  The
        amplitude of a localised mode decays exponentially with the distance from an odd bead or
        an end.  Empty if the chain has no host (`host_edges`).  With loss, the frequency that is
        compared with the bands is that of the same shape without dampers, because the bands neglect
        losses, which reduce all frequencies.

        Examples
        --------
        A bead of half the radius in a row of 40:

        >>> import hertzchain as hc
        >>> held = hc.Chain.uniform(40).replace(precompression=1.0, held_by="force")
        >>> found = hc.spectrum(held.with_defects({20: 0.5}))
        >>> found.localised, found.participation[found.localised - 1].round(2)
        (array([40]), array([1.15]))
        """
        try:
            low, high = self.host_edges.T
        except InputError:
            return np.zeros(0, dtype=np.intp)
        room, f = OUTSIDE * high[-1], self._undamped[:, np.newaxis]
        return np.flatnonzero(~((f >= low - room) & (f <= high + room)).any(axis=1)) + 1


def _host(contacts: LinearContacts, description: str) -> tuple[LinearContacts, int]:
    """Masses and springs of the cell that most beads and contacts have, and its size."""
    masses, springs = contacts.masses, contacts.springs[1:-1]
    beads = len(masses)
    for cell in range(1, min(MAX_CELL, beads // 2) + 1):
        usual = [np.array([_usual(values[i::cell]) for i in range(cell)])
                 for values in (masses, springs) if len(values) >= cell]  # fmt: skip
        if len(usual) < 2:
            break
        others = [
            np.abs(values / np.resize(each, len(values)) - 1.0) > SAME
            for values, each in zip((masses, springs), usual, strict=True)
        ]
        # Each other bead may have other springs on both sides.
        room = max(2 * others[0].sum(), MAX_OTHERS * len(springs))
        if others[0].sum() <= MAX_OTHERS * beads and others[1].sum() <= room:
            return LinearContacts(usual[0], np.append(0.0, usual[1]), np.zeros(cell + 1)), cell
    raise InputError(
        f"most beads of this chain ({description}) do not repeat a cell of up to {MAX_CELL} beads, "
        "so that it has no host; use frequencies and participation"
    )


def _usual(values: Array) -> float:
    """The most frequent value, except for rounding."""
    ordered = np.sort(values)
    counts = np.searchsorted(ordered, ordered * (1.0 + SAME), "right") - np.arange(len(ordered))
    return float(ordered[np.argmax(counts)])

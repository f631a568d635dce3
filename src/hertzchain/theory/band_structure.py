"""Bands and gaps of an infinite chain with the cell of a finite one; base of `Spectrum`."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from ..chain.chain import Chain
from ..collision import Array
from ..errors import unavailable_without
from ..frozen import Frozen
from ..validation.keywords import checked_methods
from ..validation.numbers import bounded_numbers
from .bands import plane_waves, repeating_cell, slopes_of_bands, slow_wave_speed
from .linear_contacts import LinearContacts

# Gaps narrower than this fraction of the highest frequency are bands that touch.
TOUCHING: Final = 1e-6


@checked_methods
class BandStructure(Frozen):
    """Properties of a spectrum that belong to an infinite chain."""

    chain: Chain
    contacts: LinearContacts

    @property
    @unavailable_without
    def sound_speed(self) -> float:
        r"""Speed of long waves in an infinite chain with the same cell [R_1 per unit time, or m/s].

        .. math:: c_0 = L \left(\sum_k m_k \sum_k \frac1{K_k}\right)^{-1/2}

        with the length L, the masses and the springs of a cell; :math:`2R\sqrt{K/m}` for equal
        beads.  Shorter waves are slower: the front of a weak pulse has this speed, its crests lag.

        Raises
        ------
        InputError
            If masses or springs do not repeat, as for `bands`.  If a few beads differ from the
            others, `Spectrum.host_sound_speed` is the speed between them.

        Examples
        --------
        Steel balls of 10 mm diameter under 1 N, and under 64 N:

        >>> import hertzchain as hc
        >>> balls = hc.Chain.from_materials(5e-3, "steel-52100", beads=20)
        >>> held = [balls.replace(precompression=f, held_by="force") for f in (1.0, 64.0)]
        >>> [round(hc.spectrum(each).sound_speed, 1) for each in held]
        [374.5, 749.1]
        """
        cell = repeating_cell(self.contacts, None, self.chain.description)
        return slow_wave_speed(self.contacts, self.chain.centre_distances[:cell])

    def bands(self, phase: ArrayLike, *, cell: int | None = None) -> Array:
        r"""Frequencies of plane waves in an infinite chain with the same cell.

        From one cell to the next, a wave of phase q changes by the factor :math:`e^{iq}`.  Losses
        are neglected.

        Parameters
        ----------
        phase : array_like
            Phase q from cell to cell [radians].
        cell : int, optional
            Number of beads per cell.  The default is the smallest cell that repeats.

        Returns
        -------
        ndarray, shape (..., cell)
            Frequencies of all bands in ascending order [cycles per unit time, or Hz].

        Raises
        ------
        InputError
            If masses or springs do not repeat (for example under gravity), or the chain is
            shorter than two cells.

        Examples
        --------
        >>> import hertzchain as hc
        >>> import numpy as np
        >>> held = hc.Chain.uniform(9).replace(precompression=1.0, held_by="force")
        >>> hc.spectrum(held).bands(np.pi).round(6)  # sqrt(6)/2 pi
        array([0.389848])
        """
        size = repeating_cell(self.contacts, cell, self.chain.description)
        return plane_waves(self.contacts, size, bounded_numbers("phase", phase))

    def group_velocity(self, phase: ArrayLike, *, cell: int | None = None) -> Array:
        r"""Group velocities of plane waves in an infinite chain with the same cell.

        .. math:: v_g = L\,\frac{d\omega}{dq}

        with the length L of a cell and the phase q from cell to cell.  A burst of several periods
        travels with this velocity; that of long waves is `sound_speed`.

        Parameters
        ----------
        phase : array_like
            Phase q from cell to cell [radians], as for `bands`.
        cell : int, optional
            As for `bands`.

        Returns
        -------
        ndarray, shape (..., cell)
            Group velocities in all bands, in the order of `bands` [R_1 per unit time, or m/s].  A
            negative one is that of a wave whose energy travels against its phase.  At phase 0, the
            first is `sound_speed`.

        Raises
        ------
        InputError
            As for `bands`.

        Examples
        --------
        Equal beads have :math:`v_g = c_0 \cos(q/2)`:

        >>> import hertzchain as hc
        >>> import numpy as np
        >>> held = hc.Chain.uniform(9).replace(precompression=1.0, held_by="force")
        >>> spectrum = hc.spectrum(held)
        >>> velocity = spectrum.group_velocity([0.0, np.pi / 3, np.pi])[:, 0]
        >>> (velocity / spectrum.sound_speed).round(6) + 0.0
        array([1.      , 0.866025, 0.      ])
        """
        size = repeating_cell(self.contacts, cell, self.chain.description)
        phases = bounded_numbers("phase", phase)
        length = float(self.chain.centre_distances[:size].sum())
        found = length * slopes_of_bands(self.contacts, size, phases)
        # Two waves in opposite directions meet at this phase.
        found[np.mod(phases, 2.0 * math.pi) == 0.0, 0] = self.sound_speed
        return found + 0.0

    def band_edges(self, *, cell: int | None = None) -> Array:
        """Edges of the frequency bands of an infinite chain with the same cell.

        Parameters
        ----------
        cell : int, optional
            As for `bands`.

        Returns
        -------
        ndarray, shape (cell, 2)
            Lower and upper edge of each band [cycles per unit time, or Hz].  Waves do not
            propagate at frequencies between the bands or above the last one.

        Raises
        ------
        InputError
            As for `bands`.

        Examples
        --------
        Alternating aluminium and steel balls under 1 N have two bands, given here in kHz:

        >>> import hertzchain as hc
        >>> pair = hc.Chain.periodic([9.5e-3] * 2, cells=20,
        ...                          materials=["aluminium", "steel-316"])
        >>> held = pair.replace(precompression=1.0, held_by="force")
        >>> (hc.spectrum(held).band_edges() / 1e3).round(2)
        array([[0.  , 2.82],
               [4.85, 5.61]])
        """
        return np.sort(self.bands([0.0, math.pi], cell=cell), axis=0).T.copy()

    def gaps(self, *, cell: int | None = None) -> Array:
        """Frequency ranges in which no waves propagate in an infinite chain with the same cell.

        Parameters
        ----------
        cell : int, optional
            As for `bands`.

        Returns
        -------
        ndarray, shape (G, 2)
            Lower and upper end of each gap between two bands, and last from the cut-off, the edge
            of the highest band, to infinity [cycles per unit time, or Hz].  Bands that touch have
            no gap.  There is none below the first band, which begins at 0.

        Raises
        ------
        InputError
            As for `bands`.

        Examples
        --------
        Alternating aluminium and steel balls under 1 N, in kHz:

        >>> import hertzchain as hc
        >>> pair = hc.Chain.periodic([9.5e-3] * 2, cells=20,
        ...                          materials=["aluminium", "steel-316"])
        >>> held = pair.replace(precompression=1.0, held_by="force")
        >>> (hc.spectrum(held).gaps() / 1e3).round(2)
        array([[2.82, 4.85],
               [5.61,  inf]])
        """
        edges = self.band_edges(cell=cell)
        found = np.column_stack((edges[:, 1], np.append(edges[1:, 0], math.inf)))
        return found[found[:, 1] - found[:, 0] > TOUCHING * edges[-1, 1]]

r"""Spectrum of a chain about its static equilibrium: frequencies, decay, transfer functions.

Displacements x from equilibrium that are much smaller than the static overlaps obey

.. math:: M \ddot x + C \dot x + K x = f(t) ,

with the springs and dampers of `hertzchain.theory.linear_contacts`.  The solutions are sums of
:math:`\mathrm{Re}\,[X_j e^{\lambda_j t}]`, where
:math:`(\lambda_j^2 M + \lambda_j C + K) X_j = 0`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..chain.chain import Chain
from ..chain.drives import Driven
from ..chain.feature_support import require_chain
from ..chain.hertz_warnings import warn_outside_static
from ..collision import Array
from ..errors import InputError
from ..representation import measure, short
from ..validation.keywords import checked_arguments, checked_methods
from ..validation.numbers import bounded_numbers, contact_number, whole_number
from .eigenmodes import eigenmodes
from .linear_contacts import LinearContacts, linear_contacts
from .mode_tables import ModeTables
from .response import Complex, Response, WallName, driven_place

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Number of frequencies of a transfer function, and the last one relative to the highest mode, which
# is none of these frequencies.
FREQUENCIES, ROOM = 2001, 1.25


@checked_methods
@dataclass(frozen=True, eq=False)
class Spectrum(ModeTables):
    r"""Small oscillations of a chain, as returned by `spectrum`.

    Frequencies are in cycles per unit time, like those of drives (Hz for a chain in SI units).
    There is one mode per bead.  Numbers of the modes of odd beads or ends, outside the bands, are
    `localised`; `participation` is the number of beads in each mode.  If a mode is overdamped,
    there are two instead, with frequency 0 and different decay rates.

    If the chain repeats a cell of beads, `band_edges` and `gaps` are those of an infinite chain,
    `bands` and `group_velocity` describe its plane waves, and `sound_speed` is that of long waves.
    If only a few beads differ from others that repeat, `host_edges` and `host_sound_speed` are
    those of the others.  `to_dataframe` has one row per mode, `to_xarray` also the shapes.

    Attributes
    ----------
    chain : Chain
        The chain.
    eigenvalues : ndarray of complex, shape (M,)
        Eigenvalues :math:`\lambda_j = -\delta_j + 2\pi i f_j` with :math:`f_j \ge 0`, sorted by
        frequency, then by decay rate [1/time, or 1/s].  For a chain without walls, the first is
        0: it belongs to the translation of the whole chain.
    modes : ndarray, shape (N, M)
        Displacements of the beads; ``modes[:, j]`` belongs to eigenvalue j, normalised so that
        :math:`\sum_k m_k |x_k|^2 = 1` and the displacement of the bead with
        the most energy is real and positive.  The modes of a chain without loss are real;
        otherwise they are complex, because beads need not move in phase.
    contacts : LinearContacts
        Masses, springs and dampers.

    Examples
    --------
    Steel balls of 10 mm diameter, compressed by 10 N between walls:

    >>> import hertzchain as hc
    >>> wall = hc.Wall()
    >>> chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=20)
    >>> held = chain.replace(precompression=10.0, left_wall=wall, right_wall=wall)
    >>> hc.spectrum(held)  # doctest: +ELLIPSIS
    Spectrum(20 modes, 1333.83 .. 17453.3 Hz, sound speed 549.8 m/s: 20 steel-52100 beads, ...)
    """

    chain: Chain
    eigenvalues: Complex
    modes: Array | Complex
    contacts: LinearContacts

    @property
    def frequencies(self) -> Array:
        """Frequencies in ascending order, shape (M,) [cycles per unit time, or Hz]."""
        return self.eigenvalues.imag / (2.0 * math.pi)

    @property
    def decay_rates(self) -> Array:
        r"""Rates of the decay :math:`e^{-\delta_j t}`, shape (M,) [1/time, or 1/s]."""
        # This gives 0.0 instead of -0.0 for a chain without loss.
        return 0.0 - self.eigenvalues.real

    @property
    def damping_ratios(self) -> Array:
        r"""Ratios :math:`\delta_j/|\lambda_j|`, shape (M,): 0 without loss, 1 if overdamped.

        The quality factor is :math:`1/(2\,\delta_j/|\lambda_j|)`.
        """
        size = np.abs(self.eigenvalues)
        return np.divide(self.decay_rates, size, out=np.zeros(len(size)), where=size > 0.0)

    def transfer(
        self,
        frequencies: ArrayLike,
        bead: int,
        *,
        drive: Driven = "force",
        at: int | WallName = 1,
    ) -> Complex:
        r"""Displacement of a bead under a steady drive.

        Under a drive :math:`\mathrm{Re}\,[a\,e^{2\pi i f t}]`, the displacement of the bead after
        the initial transient is :math:`\mathrm{Re}\,[H(f)\,a\,e^{2\pi i f t}]`.  The transfer
        function of its velocity is :math:`2\pi i f H`.

        Parameters
        ----------
        frequencies : array_like
            Frequencies f >= 0 of the drive [cycles per unit time, or Hz]; in SI units, also
            text such as ``"1 kHz"``.
        bead : int
            Number k of the responding bead, from 1.
        drive : str
            ``"force"`` on a bead, positive towards bead N, or ``"displacement"`` of a bead or
            wall.
        at : int or str
            Driven bead or wall: a bead number, ``"left wall"`` or ``"right wall"``.

        Returns
        -------
        ndarray of complex
            Transfer function H, in the shape of ``frequencies`` [scaled, or m/N for a force; no
            unit for a displacement].  At a resonance without loss, it is infinite under a force,
            and above 1e15 under a displacement.

        Raises
        ------
        InputError
            If the bead or wall does not exist, a wall is driven by a force, a frequency is
            negative, or a constant force acts on a chain that is not held in place.

        Examples
        --------
        Two beads between walls, with spring constants of 3/2, resonate at
        :math:`\omega^2 = 3/2` and 9/2.  At :math:`\omega^2 = 3` the driven bead does not move:

        >>> import hertzchain as hc
        >>> import numpy as np
        >>> wall = hc.Wall(stiffness=1.0)
        >>> held = hc.Chain.uniform(2).replace(precompression=1, left_wall=wall, right_wall=wall)
        >>> found = hc.spectrum(held)
        >>> [float(found.transfer(np.sqrt(3) / (2 * np.pi), k).real.round(6)) for k in (1, 2)]
        [0.0, -0.666667]
        """
        response = Response(self.contacts, self._angular(frequencies))
        k = whole_number("bead", bead, least=1, most=self.chain.beads)
        return response.displacement(k, drive, driven_place(response, drive, at))

    def transfer_force(
        self,
        frequencies: ArrayLike,
        contact: int,
        *,
        drive: Driven = "force",
        at: int | WallName = 1,
    ) -> Complex:
        """Change of a contact force under a steady drive.

        Parameters
        ----------
        frequencies : array_like
            Frequencies f >= 0 of the drive [cycles per unit time, or Hz]; in SI units, also
            text such as ``"1 kHz"``.
        contact : int
            Number of the responding contact: contact k joins beads k and k + 1, contacts 0 and
            N are those with the walls.  A sensor in bead k shows the mean of contacts k - 1
            and k.
        drive, at
            As for `transfer`.

        Returns
        -------
        ndarray of complex
            Amplitude of the force over that of the drive, in the shape of ``frequencies``
            [no unit for a force; scaled, or N/m for a displacement].

        Raises
        ------
        InputError
            As for `transfer`, or if the contact is at a free end.

        Examples
        --------
        A slowly varying force on bead 1 is transmitted to the wall unchanged; far above the
        cut-off frequency, no force is transmitted:

        >>> import hertzchain as hc
        >>> import numpy as np
        >>> held = hc.Chain.uniform(9).replace(
        ...     precompression=1.0, held_by="force", right_wall=hc.Wall())
        >>> np.abs(hc.spectrum(held).transfer_force([0.0, 2.0], 9)).round(6)
        array([1., 0.])
        """
        response = Response(self.contacts, self._angular(frequencies))
        c = contact_number(contact, self.chain.beads)
        if self.contacts.springs[c] == 0.0:
            raise InputError(
                f"contact {c} carries no force, because no wall touches the chain at this end; "
                f"give a contact from 1 to {self.chain.beads - 1}, or a wall"
            )
        return response.force(c, drive, driven_place(response, drive, at))

    def _angular(self, frequencies: ArrayLike) -> Array:
        """Angular frequencies."""
        unit = self.chain._unit("Hz")
        return 2.0 * math.pi * bounded_numbers("frequency", frequencies, unit=unit, least=0.0)

    @property
    def _usual_frequencies(self) -> Array:
        """Frequencies of a transfer function, to a quarter above the highest mode."""
        # 0 is not included, because a constant force may accelerate the chain.
        return np.linspace(0.0, ROOM * self.frequencies.max(), FREQUENCIES + 1)[1:]

    def plot(
        self, kind: str | None = None, *, cell: int | None = None, ax: Axes | None = None
    ) -> Axes:
        """Plot the band structure of a periodic chain, or the frequencies of the modes.

        Parameters
        ----------
        kind : str, optional
            ``"bands"`` shows the frequencies of plane waves over the phase q from cell to cell,
            with the band gaps shaded and the modes of the chain as ticks at the right axis.
            ``"modes"`` shows the frequency of each mode, also in a chain that does not repeat;
            frequencies outside the bands of its host (`host_edges`) are shaded.
            The default is ``"bands"`` if the chain repeats, otherwise ``"modes"``.
        cell : int, optional
            Number of beads per cell, as for `bands`.
        ax : matplotlib.axes.Axes, optional
            Axes to draw into; by default those of a new figure.

        Returns
        -------
        matplotlib.axes.Axes
            The axes; the frequencies are in kHz for a chain in SI units.

        Raises
        ------
        InputError
            For another kind, or as for `bands`.

        Examples
        --------
        >>> import hertzchain as hc
        >>> pair = hc.Chain.periodic([9.5e-3] * 2, cells=20, materials=["brass", "glass"])
        >>> crystal = hc.spectrum(pair.replace(precompression=1.0, held_by="force"))
        >>> crystal.plot().get_ylabel()
        'frequency [kHz]'
        """
        from ..plotting.spectra import plot_spectrum

        return plot_spectrum(self, kind, cell=cell, ax=ax)

    def plot_modes(
        self, modes: int | Sequence[int] | None = None, *, ax: Axes | None = None
    ) -> Axes:
        r"""Plot the shapes of modes: displacements over the bead number.

        The largest displacement of each mode is 1, and the bead with the most energy moves to
        positive x.  With loss, beads need not move in phase; the displacements are those when this
        bead is at its maximum, :math:`\mathrm{Re}\,X_k / \max|X|`.  Legends state the frequencies
        and which modes are `localised`; the title states the bands of the host (`host_edges`).

        Parameters
        ----------
        modes : int or sequence of int, optional
            Numbers of modes from 1, as in `plot` and `localised`; mode j belongs to
            ``modes[:, j - 1]`` and ``frequencies[j - 1]``.  The default is the first five
            localised modes, or the first three modes if none is localised.
        ax : matplotlib.axes.Axes, optional
            Axes to draw into; by default those of a new figure.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Raises
        ------
        InputError
            If a mode does not exist, or the list is empty.

        Examples
        --------
        The mode of a light bead in a row of 40:

        >>> import hertzchain as hc
        >>> held = hc.Chain.uniform(40).replace(precompression=1.0, held_by="force")
        >>> axes = hc.spectrum(held.with_defects({20: 0.5})).plot_modes()
        >>> [text.get_text() for text in axes.get_legend().get_texts()]
        ['localised mode 40, $f$ = 0.7529, around bead 20']
        """
        from ..plotting.mode_shapes import plot_modes

        return plot_modes(self, modes, ax=ax)

    def plot_transfer(
        self,
        contact: int,
        *,
        drive: Driven = "force",
        at: int | WallName = 1,
        frequencies: ArrayLike | None = None,
        ax: Axes | None = None,
    ) -> Axes:
        """Plot the amplitude of a contact force under a steady drive over its frequency.

        Frequencies without plane waves are shaded if the chain repeats.  Without loss, all
        resonances leave the frame.  If axes have several of these curves, the legend names the
        properties in which the chains, contacts or drives differ, the title has the common ones,
        and frequencies at which none of the chains transmits waves are shaded.

        Parameters
        ----------
        contact, drive, at
            As for `transfer_force`.
        frequencies : array_like, optional
            Increasing frequencies of the drive [cycles per unit time, or Hz]; in SI units, also
            text such as ``"1 kHz"``.  The default is from 0 to a quarter above the highest mode.
        ax : matplotlib.axes.Axes, optional
            Axes to draw into; by default those of a new figure.

        Returns
        -------
        matplotlib.axes.Axes
            The axes, with a logarithmic amplitude.

        Raises
        ------
        InputError
            As for `transfer_force`, or for fewer than two frequencies.

        Examples
        --------
        >>> import hertzchain as hc
        >>> held = hc.Chain.uniform(9).replace(
        ...     precompression=1.0, held_by="force", right_wall=hc.Wall())
        >>> hc.spectrum(held).plot_transfer(9).get_yscale()
        'log'
        """
        from ..plotting.spectra import plot_transfer

        return plot_transfer(self, contact, drive=drive, at=at, frequencies=frequencies, ax=ax)

    def _bead_of_mode(self, mode: int) -> int:
        """Number of the bead that has most of the energy of a mode with this number."""
        return int(self._energies[:, mode - 1].argmax()) + 1

    def __repr__(self) -> str:
        f, unit = self.frequencies, " Hz" if self.chain.units == "SI" else ""
        about = f"{len(f)} modes, {f[0]:g} .. {f[-1]:g}{unit}"
        with suppress(InputError):
            about += f", sound speed {measure(self.sound_speed, 'm/s', self.chain.units)}"
            gaps = [f"{low:g} .. {high:g}" for low, high in self.gaps()[:-1]]
            about += f", gap{'s' * (len(gaps) > 1)} {' and '.join(gaps)}{unit}" if gaps else ""
        if len(local := self.localised):
            modes = " and ".join(
                f"{self.frequencies[j - 1]:g}{unit} around bead {self._bead_of_mode(j)}"
                for j in local[:3]
            )
            about += f", localised at {modes}" if len(local) <= 3 else (
                f", {len(local)} localised modes")  # fmt: skip
            about += " (plot_modes)"
        return short("Spectrum", about, self.chain.description)

    def _repr_html_(self) -> str:
        from ..notebook.spectra import spectrum_html

        return spectrum_html(self)


@checked_arguments("spectrum")
def spectrum(chain: Chain) -> Spectrum:
    r"""Frequencies, decay rates and modes of a chain about its static equilibrium.

    Walls, gravity, precompression, given masses and stiffness, losses and SI units are taken into
    account; velocities and drive are ignored.  An end held by a constant force
    (``held_by="force"``) moves freely.

    Parameters
    ----------
    chain : Chain
        A chain whose contacts carry a static force, from precompression or gravity.

    Returns
    -------
    Spectrum
        Eigenvalues, accurate to about 1e-14 of the largest one, and modes.

    Raises
    ------
    InputError
        If a contact carries no static force, or its loss law cannot be linearised:
        `UnloadingRatio`, `WaltonBraun`, `ElasticPlastic` beyond yield, and `VelocityPower` with
        alpha < 1.

    Warns
    -----
    ModelRangeWarning
        If the loss is a `VelocityPower` with alpha > 1, which does not damp small motions, or
        the static forces exceed a limit of Hertz's law (`hertz_range`).

    Examples
    --------
    Two beads between walls, with spring constants K = 1.5 and a material time A = 0.1, have
    modes with :math:`\omega^2 = K` and :math:`3K`, and :math:`\delta = A\omega^2/2`:

    >>> import hertzchain as hc
    >>> wall = hc.Wall(stiffness=1.0)
    >>> held = hc.Chain.uniform(2).replace(
    ...     precompression=1.0, left_wall=wall, right_wall=wall, loss=hc.Viscoelastic(0.1))
    >>> hc.spectrum(held).decay_rates.round(12)
    array([0.075, 0.225])
    """
    require_chain("spectrum", chain)
    contacts = linear_contacts(chain)
    warn_outside_static(chain, linear=True)
    eigenvalues, modes = eigenmodes(contacts)
    for array in (eigenvalues, modes, contacts.springs, contacts.dampers):
        array.setflags(write=False)
    return Spectrum(chain, eigenvalues, modes, contacts)

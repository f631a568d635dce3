"""Steady motion of a row of masses, springs and dampers under a drive of one frequency."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hertzchain.chain.drives import Driven
from hertzchain.contacts import Array
from hertzchain.frozen import Frozen
from hertzchain.theory.linear_contacts import LinearContacts

Complex = NDArray[np.complexfloating[Any, Any]]


class Response(Frozen):
    r"""Steady motion of a chain at some frequencies.

    ``ahead[c]`` is the force by which contact c and all ahead of it resist a unit displacement
    of bead c, ``behind[c]`` that by which it and all behind it resist one of bead c + 1:
    springs in series with what they lead to.  Unlike the inverse of
    :math:`K + i\omega C - \omega^2 M`, this keeps its digits for slow drives.
    """

    def __init__(self, contacts: LinearContacts, omega: Array) -> None:
        self.omega = omega
        springs, dampers = contacts.springs[:, None], contacts.dampers[:, None]
        flat = omega.reshape(-1)
        self.links: Complex = springs + 1j * flat * dampers
        self.inertia: Array = -(flat**2) * contacts.masses[:, None]
        self.beads = len(contacts.masses)
        self.ahead, self.behind = self.links.copy(), self.links.copy()
        for c in range(self.beads - 1, -1, -1):
            self.ahead[c] = _in_series(self.links[c], self.inertia[c] + self.ahead[c + 1])
        for c in range(1, self.beads + 1):
            self.behind[c] = _in_series(self.links[c], self.inertia[c - 1] + self.behind[c - 1])

    def displacement(self, bead: int, drive: Driven, source: int) -> Complex:
        r"""Complex amplitude of a bead's motion, for a drive of amplitude one.

        Parameters
        ----------
        bead : int
            Bead 1..N; walls are 0 and N + 1.
        drive : str
            ``"force"`` or ``"displacement"``.
        source : int
            The bead or wall that is driven.

        Returns
        -------
        ndarray of complex
            Of the shape of the frequencies.

        Examples
        --------
        A mass of 1 on a spring of 2, driven at :math:`\omega = 1`, moves by 1/(2 - 1):

        >>> one = LinearContacts(np.ones(1), np.array([2.0, 0.0]), np.zeros(2))
        >>> complex(Response(one, np.array(1.0)).displacement(1, "force", 1))
        (1+0j)
        """
        moved = self._at_source(drive, source)
        for c in range(source, bead):
            moved = moved * _share(self.links[c], self.inertia[c] + self.ahead[c + 1])
        for c in range(source - 1, bead - 1, -1):
            moved = moved * _share(self.links[c], self.inertia[c - 1] + self.behind[c - 1])
        return moved.reshape(self.omega.shape)

    def force(self, contact: int, drive: Driven, source: int) -> Complex:
        """Complex amplitude of the force in a contact, positive if it is pressed more.

        Parameters
        ----------
        contact : int
            Contact 0..N.
        drive, source
            As for `displacement`.

        Returns
        -------
        ndarray of complex
            Of the shape of the frequencies.

        Examples
        --------
        >>> one = LinearContacts(np.ones(1), np.array([2.0, 0.0]), np.zeros(2))
        >>> complex(Response(one, np.array(1.0)).force(0, "force", 1)).real
        -2.0
        """
        if contact >= source:
            moved = self.displacement(contact, drive, source)
            return moved * self.ahead[contact].reshape(self.omega.shape)
        moved = self.displacement(contact + 1, drive, source)
        return -moved * self.behind[contact].reshape(self.omega.shape)

    def _at_source(self, drive: Driven, source: int) -> Complex:
        if drive == "displacement":
            return np.ones(self.links.shape[1], complex)
        resistance = self.inertia[source - 1] + self.ahead[source] + self.behind[source - 1]
        found = np.full(resistance.shape, complex(math.inf))
        return np.divide(1.0, resistance, out=found, where=resistance != 0.0)


def _in_series(link: Complex, rest: Complex) -> Complex:
    """Resistance of a contact and what it leads to; 0 at a free end."""
    if not link.any():
        return link
    return rest * _share(link, rest)


def _share(link: Complex, rest: Complex) -> Complex:
    """What part of its one end's displacement a contact hands on to the other."""
    total = link + rest
    # At a resonance of the rest, which without loss can be met exactly.
    return link / np.where(total == 0.0, np.finfo(float).eps * link, total)

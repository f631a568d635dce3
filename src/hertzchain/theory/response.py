"""Steady motion of a line of masses, springs and dampers under a harmonic drive."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..chain.drives import Driven
from ..collision import Array
from ..errors import InputError
from ..frozen import Frozen
from .linear_contacts import LinearContacts

Complex = NDArray[np.complexfloating[Any, Any]]

# Squares of larger frequencies cannot be represented.
MAX_FREQUENCY = 1e100


class Response(Frozen):
    r"""Steady motion of a chain at given frequencies.

    ``ahead[c]`` is the dynamic stiffness of contact c and everything ahead of it, as seen by bead
    c; ``behind[c]`` is that of contact c and everything behind it, as seen by bead c + 1.  Both
    are springs in series with the rest of the chain.  Unlike the inverse of
    :math:`K + i\omega C - \omega^2 M`, they remain accurate at low frequencies.
    """

    def __init__(self, contacts: LinearContacts, omega: Array) -> None:
        self.omega = omega
        springs, dampers = contacts.springs[:, None], contacts.dampers[:, None]
        flat = omega.reshape(-1)
        if np.abs(flat).max(initial=0.0) > MAX_FREQUENCY:
            raise InputError(
                f"angular frequencies must be at most {MAX_FREQUENCY:g}, got {np.abs(flat).max():g}"
            )
        self.links: Complex = springs + 1j * flat * dampers
        self.inertia: Array = -(flat**2) * contacts.masses[:, None]
        self.beads = len(contacts.masses)
        self.ahead, self.behind = self.links.copy(), self.links.copy()
        for c in range(self.beads - 1, -1, -1):
            self.ahead[c] = _in_series(self.links[c], self.inertia[c] + self.ahead[c + 1])
        for c in range(1, self.beads + 1):
            self.behind[c] = _in_series(self.links[c], self.inertia[c - 1] + self.behind[c - 1])

    def displacement(self, bead: int, drive: Driven, source: int) -> Complex:
        r"""Complex amplitude of a bead's displacement, for a drive of amplitude one."""
        moved = self._at_source(drive, source)
        for c in range(source, bead):
            share = _share(self.links[c], self.inertia[c] + self.ahead[c + 1])
            moved = _times(moved, share)
        for c in range(source - 1, bead - 1, -1):
            share = _share(self.links[c], self.inertia[c - 1] + self.behind[c - 1])
            moved = _times(moved, share)
        return moved.reshape(self.omega.shape)

    def force(self, contact: int, drive: Driven, source: int) -> Complex:
        """Complex amplitude of a contact force, positive in compression."""
        if contact >= source:
            moved = self.displacement(contact, drive, source)
            return _times(moved, self.ahead[contact].reshape(self.omega.shape))
        moved = self.displacement(contact + 1, drive, source)
        return -_times(moved, self.behind[contact].reshape(self.omega.shape))

    def _at_source(self, drive: Driven, source: int) -> Complex:
        if drive == "displacement":
            return np.ones(self.links.shape[1], complex)
        resistance = self.inertia[source - 1] + self.ahead[source] + self.behind[source - 1]
        found = np.full(resistance.shape, complex(math.inf))
        return np.divide(1.0, resistance, out=found, where=resistance != 0.0)


def _times(moved: Complex, factor: Complex) -> Complex:
    """The product; at a resonance without loss, where the motion is infinite, it stays so."""
    return np.multiply(moved, factor, out=moved.copy(), where=np.isfinite(moved))


def _in_series(link: Complex, rest: Complex) -> Complex:
    """Dynamic stiffness of a contact in series with the rest of the chain; 0 at a free end."""
    if not link.any():
        return link
    return rest * _share(link, rest)


def _share(link: Complex, rest: Complex) -> Complex:
    """Displacement at the far end of a contact over that at its near end."""
    total = link + rest
    # Without loss, the sum can vanish exactly at a resonance.
    return link / np.where(total == 0.0, np.finfo(float).eps * link, total)

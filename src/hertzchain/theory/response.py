"""Steady motion of a line of masses, springs and dampers under a harmonic drive."""

from __future__ import annotations

import math
from typing import Any, Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ..chain.drives import DRIVEN, Driven
from ..collision import Array
from ..errors import InputError
from ..frozen import Frozen
from ..validation.numbers import whole_number
from ..validation.objects import check_choice
from .linear_contacts import LinearContacts

Complex = NDArray[np.complexfloating[Any, Any]]
WallName = Literal["left wall", "right wall"]
WALLS: Final[tuple[WallName, ...]] = get_args(WallName)

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
        self.walls = contacts.springs[[0, -1]] != 0.0
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


def driven_place(response: Response, drive: Driven, at: int | WallName) -> int:
    """Check the place of a drive: 0 is the left wall, N + 1 the right wall."""
    check_choice("drive", drive, DRIVEN)
    if isinstance(at, str):
        side = WALLS.index(check_choice("driven end", at, WALLS))
        if not response.walls[side]:
            raise InputError(
                f"the {at} cannot be driven, because no wall touches the chain at this end"
            )
        if drive == "force":
            raise InputError(
                f"a force on the {at} does not move it; drive a bead, or use drive='displacement'"
            )
        return (response.beads + 1) * side
    place = whole_number("driven bead", at, least=1, most=response.beads)
    if drive == "force" and not response.walls.any() and (response.omega == 0.0).any():
        raise InputError(
            "a constant force (frequency 0) accelerates a chain without walls indefinitely; "
            "give frequencies above 0, or a wall"
        )
    return place

"""Energy and momentum between two contacts, and the part that still moves towards one of them."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from ..collision import Array
from .budget import overlaps_of, stored_energy
from .reflection import Reflection
from .trajectory import Trajectory
from .wave_events import largest_force_of, static_forces_of

# Forces of open contacts, relative to the largest force of the run: rounding errors.
ROUNDING: Final = 1e-9
NAMES: Final = ("reflected", "transmitted")


class Incomplete(NamedTuple):
    """A coefficient of energy whose waves have not all passed the contact."""

    name: str
    contact: int
    counted: float
    coming: float
    # Energy between the contacts that moves in the other direction.
    away: float


def energy_between(run: Trajectory, first: int, second: int, times: Array) -> Array:
    """Energy between two contacts, beyond the work of the static forces, at the saved times."""
    return _energies(run, first, second, times).sum(axis=1)


def incomplete(found: Reflection) -> Incomplete | None:
    """The coefficient that would be larger by a relevant part if the run were longer."""
    contacts, coming = (found.before, found.after), found.energy_on_its_way
    counted = (found.reflected_energy, found.transmitted_energy)
    parts = zip(NAMES, contacts, counted, coming, reversed(coming), strict=True)
    for name, contact, energy, more, away in parts:
        if found._energy_coming(name):
            return Incomplete(name, contact, energy, more, away)
    return None


def separated_energy(run: Trajectory, found: Reflection) -> float:
    """Energy of the beads between the contacts that have separated, over the incident energy."""
    energies = _energies(run, found.before, found.after, np.array([found.until]))[0]
    return float(energies[_separated(run, found)].sum()) / found.incident.energy


def _separated(run: Trajectory, found: Reflection) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Which beads between the contacts fly away from a free end, and meet no others again.

    From the end, all contacts are open and no two beads approach each other; beads that follow
    can only accelerate them away from the row.
    """
    chain, saved = run.chain, _saved(run, np.array([found.until]))[0]
    apart = np.zeros(chain.beads, bool)
    low, high = sorted((found.before, found.after))
    if chain.gravity or np.any(static_forces_of(run)):
        return apart[low:high]
    velocities, forces = run.velocities[saved], np.abs(run.forces[saved, 1:-1])
    closed = forces > ROUNDING * largest_force_of(run)
    for end, sign in ((chain.left_wall or chain.drive, -1), (chain.right_wall, 1)):
        if end is None:
            outward = (sign * velocities)[::-sign]
            flying = ~closed[::-sign] & (np.diff(outward) <= 0.0) & (outward[:-1] >= 0.0)
            apart[::-sign][: chain.beads - 1] |= np.logical_and.accumulate(flying)
    return apart[low:high]


def energy_on_its_way(run: Trajectory, found: Reflection) -> tuple[float, float]:
    """Energy that moves towards ``before`` and ``after`` at the end, over the incident energy.

    Without precompression, the beads of a wave move in its direction.
    """
    energies = _energies(run, found.before, found.after, np.array([found.until]))[0]
    energies *= ~_separated(run, found) / found.incident.energy
    if found.after in (0, run.chain.beads):
        return float(energies.sum()), 0.0
    low, high = sorted((found.before, found.after))
    saved = _saved(run, np.array([found.until]))[0]
    onward = run.velocities[saved, low:high] * found.incident.direction > 0.0
    return float(energies[~onward].sum()), float(energies[onward].sum())


def momentum_on_its_way(run: Trajectory, found: Reflection) -> tuple[float, float]:
    """Momentum that moves towards ``before`` and ``after`` at the end, over the incident one."""
    low, high = sorted((found.before, found.after))
    saved = _saved(run, np.array([found.until]))[0]
    momenta = (run.chain.masses * run.velocities[saved])[low:high] * ~_separated(run, found)
    onward = momenta * found.incident.direction > 0.0
    back, on = (float(np.abs(momenta[part]).sum()) for part in (~onward, onward))
    back, on = back / found.incident.impulse, on / found.incident.impulse
    # A wall or a free end reflects all of it.
    return (back + on, 0.0) if found.after in (0, run.chain.beads) else (back, on)


def _saved(run: Trajectory, times: Array) -> Array:
    return np.minimum(np.searchsorted(run.times, times), len(run.times) - 1)


def _energies(run: Trajectory, first: int, second: int, times: Array) -> Array:
    """Energy of each bead between two contacts, with its share of that stored in contacts."""
    chain, saved = run.chain, _saved(run, times)
    low, high = sorted((first, second))
    overlaps = overlaps_of(chain, run.times[saved], run.positions[saved])
    stored = stored_energy(chain, overlaps, run.forces[saved])
    stored -= static_forces_of(run) * overlaps
    # The two sides of a contact share its energy, and a wall keeps none.
    shared = 0.5 * stored
    shared[:, [0, -1]] *= 2.0
    stored_in_beads = shared[:, :-1] + shared[:, 1:]
    kinetic = 0.5 * chain.masses * run.velocities[saved] ** 2
    return np.asarray((kinetic + stored_in_beads)[:, low:high])

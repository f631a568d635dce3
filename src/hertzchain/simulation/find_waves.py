r"""Find the waves of a run: maxima of the force that pass one contact after another.

Events of neighbouring contacts and of one direction are assigned to each other so that the sum of

.. math:: \left(\frac{\Delta t}{h} - 1\right)^2 + \ln^2\frac{J_{k\pm1}}{J_k}

is smallest, where :math:`h = 0.668\,J/F` is the time in which a solitary wave of this duration
passes from contact to contact; pairs for which this cost is 4 or more are not linked.  The time
from one contact to the next may therefore be negative: in many dimers, the force of a pulse has its
maximum at the second contact of a cell before that at the first.  Here J is
twice the smaller part of the impulse, before or after the maximum, because near a heavy striker an
impulse includes all waves that have not separated yet.  A wave ends where it meets another wave or
a wall, and a new wave begins beyond.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from ..collision import Array
from ..errors import InputError, InputWarning, warn_user
from ..validation.numbers import FRACTION, number, whole_number
from .energy_flux import energy_to_and_fro
from .trajectory import Trajectory
from .wave_events import (
    ContactCurves,
    WaveEvent,
    check_saved_times,
    events_of,
    largest_force_of,
    static_forces_of,
)
from .wave_samples import MIN_SAMPLES, advised_times, are_few
from .waves import DIRECTIONS, Wave, Waves

# Time from contact to contact in durations, in the solitary wave of p = 3/2.
HOP: Final = 0.668
# Limit of the cost of linking two events.
MAX_COST: Final = 4.0
# Saved times per duration below which the crest at the next contact may be missed, and largest
# force there over that at the last contact of a track from which the wave has passed.
LOST: Final = 0.5 * MIN_SAMPLES
PASSED: Final = 0.5
# Part of the largest energy through a contact from which the energy through another one counts.
MUCH: Final = 0.1


def find_waves(self: Trajectory, *, threshold: float = 0.01, min_contacts: int = 3) -> Waves:
    """Find the travelling waves in both directions: pulses, trains and reflections.

    A wave is a maximum of the force that passes one contact after another;
    `hertzchain.simulation.find_waves` describes how waves are found.

    Parameters
    ----------
    threshold : float
        Smallest force of a wave, relative to the largest force of the run.
    min_contacts : int
        Smallest number of contacts that a wave passes.

    Returns
    -------
    Waves
        A sequence of `Wave`, ordered by the time at the first contact.

    Raises
    ------
    InputError
        If fewer than 8 times were saved during the passage of the strongest wave.

    Warns
    -----
    InputWarning
        If some weaker waves are not resolved; they are marked.  If a track may end early, because
        fewer than 4 times were saved while the wave passed its last contact.  If most of the energy
        that passes more than 5 neighbouring contacts, or all contacts of a shorter chain, is in no
        listed wave (`Waves.unlisted_energy`).  A wave that has not passed ``min_contacts`` contacts
        by the end of the run is not listed.

    Examples
    --------
    A striker of four times the mass generates a train of waves, each with about 40% of the force
    of the previous one:

    >>> import hertzchain as hc
    >>> import numpy as np
    >>> chain = hc.Chain.uniform(80).replace(masses=np.append(4.0, np.ones(79)))
    >>> train = hc.simulate(chain, until=110.0, times=2200).waves().passing(60)
    >>> [round(wave.amplitude, 3) for wave in train][:4]
    [1.277, 0.495, 0.207, 0.089]
    """
    threshold = number("threshold", threshold, unit=FRACTION, above=0.0, below=1.0)
    least = whole_number("min_contacts", min_contacts, least=2)
    check_saved_times(self)
    floor = threshold * largest_force_of(self)
    curves = [ContactCurves(self, k) for k in range(self.chain.beads + 1)]
    units = self.chain.units
    events = [events_of(here, k, floor, units) for k, here in enumerate(curves)]
    every = [event for here in events for event in here]
    tracks = [
        track for sign in DIRECTIONS for track in _tracks(events, sign) if len(track) >= least
    ]
    found = [Wave(self.chain, track[0].direction, tuple(track)) for track in tracks]
    found.sort(key=lambda wave: wave.events[0].time)
    _check_resolved(self, found)
    _warn_lost(self, found)
    waves = Waves(self.chain, tuple(found), tuple(every), _unlisted(curves[1:-1], found))
    if waves._unlisted:
        few = f"; with few saved times, waves may be missing: {advised_times(self)}"
        warn_user(waves._unlisted + few * are_few(self), InputWarning)
    return waves


def _unlisted(curves: list[ContactCurves], waves: list[Wave]) -> Array:
    """Part of the energy that passed each inner contact, to either side, that no wave has."""
    flux = np.array([sum(energy_to_and_fro(here)) for here in curves])
    listed = np.zeros(len(curves))
    for wave in waves:
        listed[wave.contacts - 1] += wave.energies
    # Where little energy passes, its parts are of no interest and may be rounding errors.
    much = flux > MUCH * flux.max(initial=0.0)
    return np.where(much, 1.0 - np.clip(listed / np.where(much, flux, 1.0), 0.0, 1.0), 0.0)


def _tracks(events: list[list[WaveEvent]], sign: int) -> Iterator[list[WaveEvent]]:
    """Events of one direction, linked from contact to contact."""
    moving = [[event for event in here if event.direction == sign] for here in events][::sign]
    open_tracks: dict[int, list[WaveEvent]] = {}
    for here, there in zip(moving, [*moving[1:], []], strict=True):
        for i, event in enumerate(here):
            open_tracks.setdefault(i, [event])
        following = {}
        for i, j in _links(here, there):
            track = open_tracks.pop(i)
            track.append(there[j])
            following[j] = track
        yield from open_tracks.values()
        open_tracks = following


def _links(here: list[WaveEvent], there: list[WaveEvent]) -> Iterator[tuple[int, int]]:
    """Assign events of the next contact to events of this one."""
    from scipy.optimize import linear_sum_assignment

    if not (here and there):
        return
    time, duration, impulse = (each[:, np.newaxis] for each in _columns(here))
    next_time, next_duration, next_impulse = _columns(there)
    # Impulses of opposite signs, of which one is rounding, and durations that few saved times do
    # not resolve give NaN or infinity and are not linked.
    with np.errstate(invalid="ignore", divide="ignore"):
        wait = (next_time - time) / (0.5 * HOP * (duration + next_duration))
        cost = (wait - 1.0) ** 2 + np.log(next_impulse / impulse) ** 2
    cost[~(cost < MAX_COST)] = 1e9
    for i, j in zip(*linear_sum_assignment(cost), strict=True):
        if cost[i, j] < MAX_COST:
            yield int(i), int(j)


def _columns(events: list[WaveEvent]) -> tuple[Array, Array, Array]:
    """Times, durations and impulses of the crests of events."""
    impulse = np.array([event.impulse_of_crest for event in events])
    amplitude = np.array([event.amplitude for event in events])
    return np.array([event.time for event in events]), impulse / amplitude, impulse


def _may_be_lost(run: Trajectory, wave: Wave) -> bool:
    """Whether few saved times end a track inside the chain, before the end of the run."""
    last = wave.events[-1]
    following = last.contact + wave.direction
    inside = 0 < following < run.chain.beads
    if not inside or last.samples >= LOST:
        return False
    # Largest overlaps do not depend on the saved times.
    overlap = max(0.0, float(run.largest_overlaps[following]))
    force = (
        run.chain.contact_stiffness[following] * overlap ** run.chain.contact_exponents[following]
    )
    return bool(force - static_forces_of(run)[following] > PASSED * last.amplitude)


def _check_resolved(run: Trajectory, waves: list[Wave]) -> None:
    """Raise an error if the strongest wave is not resolved; warn about weaker ones."""
    missed = [wave for wave in waves if not wave.resolved]
    if not missed:
        return
    worst, advice = min(wave.samples for wave in missed), advised_times(run)
    strongest = max(waves, key=lambda wave: wave.energy)
    samples = float(np.median([event.samples for event in strongest.events]))
    if samples < MIN_SAMPLES:
        raise InputError(
            f"too few saved times to find waves: only {samples:.3g} are within the "
            f"passage of the strongest wave through a contact, but at least {MIN_SAMPLES:g} are "
            f"required; {advice}"
        )
    warn_user(
        f"{len(missed)} of {len(waves)} waves have fewer than {MIN_SAMPLES:g} saved times while "
        f"they pass a contact (least: {worst:.3g}) and are marked as unresolved; {advice}",
        InputWarning,
    )


def _warn_lost(run: Trajectory, waves: list[Wave]) -> None:
    """Warn about tracks that may end early."""
    lost = [wave for wave in waves if _may_be_lost(run, wave)]
    if not lost:
        return
    end = max(lost, key=lambda wave: wave.energy).events[-1]
    several = f"the tracks of {len(lost)} waves may end early, that of the strongest"
    tracks = several if len(lost) > 1 else "the track of a wave may end early"
    warn_user(
        f"{tracks} at contact {end.contact}, which it passes within {end.samples:.2g} saved times; "
        f"{advised_times(run)}",
        InputWarning,
    )

"""Find the waves that an incident wave causes at a wall, an interface or a defect."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..errors import IncompleteWarning, InputWarning, SimulationError, warn_user
from ..representation import measure
from ..validation.numbers import number
from .contact_pairs import separate_contacts
from .energy_on_its_way import (
    Incomplete,
    energy_between,
    energy_on_its_way,
    incomplete,
    momentum_on_its_way,
    separated_energy,
)
from .reflection import LEAST, Reflection, least_distance
from .trajectory import Trajectory
from .wave_events import (
    ContactCurves,
    WaveEvent,
    check_saved_times,
    events_at,
    largest_force_of,
    require_resolved,
    static_forces_of,
)

# Events above this fraction of the largest force at their contact are counted; below this fraction
# of the largest force of the run, forces are those of rounding errors.
THRESHOLD, ROUNDING = 1e-3, 1e-9
# Waves below this fraction of the incident energy need not be resolved, counting does not end when
# they enter from outside, and rarefactions with less energy than this are neglected.
WEAK: Final = 0.01
# Fraction of the incident energy that may be missing, still be between the contacts, or enter from
# outside before the incident wave has left; fraction of the momentum that may be missing.
MISSING: Final = 0.05
# Neighbouring contacts with which the reflected energy is compared, and how many of those beyond
# `before` are enough; differences, relative to it and to the incident energy, from which it depends
# on the contact, the latter also from which a coefficient depends on the end of the count.
NEARBY, ENOUGH = 6, 3
SAME, SMALL = 0.1, 0.005


def reflection_of(
    self: Trajectory,
    before: int,
    after: int | str,
    *,
    since: float = 0.0,
    until: float | None = None,
) -> Reflection:
    """Evaluate reflection and transmission of a wave between two contacts.

    Parameters
    ----------
    before, after : int
        Contacts on both sides of an interface or defect, in the direction of the wave, each at
        least the width of a pulse (5 contacts) from it.  For a wall or the end of a precompressed
        chain, ``after`` is N or 0; for a wall, also ``"wall"``, ``"right wall"`` or
        ``"left wall"``.  At the end of a row without precompression or wall, beads separate and
        fly away, so that no wave is reflected.
    since : float
        Time from which to search for the incident wave [scaled, or s].
    until : float, optional
        Time up to which events are counted [scaled, or s].  Counting ends earlier if another
        wave enters from outside, except for weak ones before the incident wave has left.

    Returns
    -------
    Reflection
        Coefficients of energy, momentum and force, and the waves themselves.

    Raises
    ------
    InputError
        If there are no such contacts, they are less than 3 apart or ``after`` is next to a wall,
        or fewer than 8 times were saved during the passage of one of the waves.
    SimulationError
        If no wave towards ``after`` passes the contact ``before``, or another wave enters
        before it has passed.  Also if rarefactions, which are not counted, carry more than 1% of
        the incident energy through one of the contacts, as in precompressed chains.

    Warns
    -----
    InputWarning
        If a coefficient of energy depends on ``until`` (`Reflection.late_energy`), as in dimers,
        in which weak waves follow the incident one.
        If the contacts are less than 10 apart, or less than 5 from a wall or free end: in rows of
        equal beads with a step or an odd bead, R and T then differ by up to 0.02.
        If more than 5% of the incident energy is missing from the balance, because of other
        waves; if ``missing_momentum`` exceeds 5%.
        If beads that have separated and fly away from a free end have more than 5% of the
        incident energy (``separated_energy``), which a longer run cannot count.
        If the reflected energy at ``before`` differs from the median of the 6 contacts in front
        of it and from that of the 6 contacts beyond it, which happens where weak waves meet the
        reflected one, as in dimers.
    IncompleteWarning
        If more than 5% of the incident energy is still between the contacts.
        If the waves that are still on their way to one of the contacts have more than 5% of the
        energy counted there, and more than 0.05% of the incident energy beyond
        ``entered_energy``: the run, or ``until``, ends before weak waves have passed.  If another
        wave ends the count instead, this is an `InputWarning`.

    See Also
    --------
    EnergyFlux.balance : Balance of all waves, where a single one cannot be separated, as in most
        dimers and in precompressed or strongly disordered chains.

    Notes
    -----
    Forces and powers are quintic splines through the saved times.  With 8 of them during each
    wave, which are required, energies and momenta differ by less than 1e-8 from those with more.

    Examples
    --------
    The last 60 beads have twice the radius of the first:

    >>> import hertzchain as hc
    >>> import numpy as np
    >>> chain = hc.Chain.from_radii(np.where(np.arange(120) < 60, 1.0, 2.0))
    >>> found = hc.simulate(chain, until=140.0, times=1500).reflection(50, 75)
    >>> f"R = {found.reflected_energy:.3f}, T = {found.transmitted_energy:.3f}"
    'R = 0.523, T = 0.476'
    """
    first, second = separate_contacts(self.chain, before, after)
    unit = self.chain._unit("s")
    begin = number("since", since, unit=unit)
    stop = np.inf if until is None else number("until", until, unit=unit, above=begin)
    check_saved_times(self)
    sign = 1 if second > first else -1
    near = [event for event in _events_at(self, first) if event.time >= begin]
    incident = next((event for event in near if event.direction == sign), None)
    if incident is None or incident.time > stop:
        back = any(event.direction != sign for event in near)
        other = f"waves from contact {second} do: exchange before and after"
        raise SimulationError(
            f"no wave towards contact {second} passes contact {first} in the given time interval; "
            f"{other if back else 'give a larger until'}; {self.message}"
        )
    far = [event for event in _events_at(self, second) if event.time > incident.time]
    stop = min(stop, float(self.times[-1]))
    found = _between(self, (first, second), incident, near, far, stop)
    _check_rarefactions(self, found)
    _check_count(self, found)
    found = dataclasses.replace(
        found,
        energy_on_its_way=energy_on_its_way(self, found),
        momentum_on_its_way=momentum_on_its_way(self, found),
        separated_energy=separated_energy(self, found),
    )
    nearby = _neighbours(self, found, far, stop) if self.chain.lossless else []
    if nearby:
        found = dataclasses.replace(found, nearby_energy=(min(nearby), max(nearby)))
    near_object = found._overlap
    depends = _dependence(found, nearby)
    other = _other_waves(found)
    late = "" if other else _on_the_way(found, known=bool(near_object or depends))
    if late:
        warn_user(late, InputWarning if found.disturbed else IncompleteWarning)
    momentum = "" if other or late else _missing_in_waves(found)
    growing = "" if other or late else _growing(found)
    apart = "" if other or late else _stays(found)
    for reason in filter(None, (depends, other, growing, momentum, apart, near_object)):
        warn_user(reason, InputWarning)
    return found


def _between(
    self: Trajectory,
    contacts: tuple[int, int],
    incident: WaveEvent,
    near: list[WaveEvent],
    far: list[WaveEvent],
    stop: float,
) -> Reflection:
    """Count the waves that an incident wave causes, among those at both contacts."""
    (first, second), sign = contacts, incident.direction
    near = [event for event in near if event.time > incident.time]
    entering = [e for e in near if e.direction == sign] + [e for e in far if e.direction == -sign]

    def still_there(time: float) -> float:
        gained = energy_between(self, first, second, np.array([incident.begin, time]))
        return float(gained[1] - gained[0]) / incident.energy

    last, entered = _end_of_count(
        entering, incident, stop, lambda time: still_there(time) <= MISSING
    )
    reflected = tuple(e for e in near if e.direction == -sign and e.time <= last)
    transmitted = tuple(e for e in far if e.direction == sign and e.time <= last)
    return Reflection(
        chain=self.chain, before=first, after=second, incident=incident, reflected=reflected,
        transmitted=transmitted, until=last, disturbed=last < stop,
        kept_energy=sign * _inflow(self, first, second, incident.begin, last) / incident.energy,
        stored_energy=still_there(last), entered_energy=entered,
        missing_momentum=max(
            (_missing_momentum(self, each, incident, last) for each in ([incident, *near], far)),
            key=abs,
        ),
    )  # fmt: skip


def _neighbours(
    run: Trajectory, found: Reflection, far: list[WaveEvent], stop: float
) -> list[float]:
    """Reflected energy at the contacts in front of ``before``, or at those beyond if they agree."""
    front = _nearby(run, found, far, stop, -found.incident.direction)
    if not _differs(found, front):
        return front
    # The place where waves meet the reflected one may be just in front of a good contact.
    beyond = _nearby(run, found, far, stop, found.incident.direction)
    return front if len(beyond) < ENOUGH or _differs(found, beyond) else beyond


def _nearby(
    run: Trajectory, found: Reflection, far: list[WaveEvent], stop: float, side: int
) -> list[float]:
    """Reflected energy at the contacts on one side of ``before``, up to the reflecting object."""
    incident, sign, nearby = found.incident, found.incident.direction, []
    for contact in (found.before + side * shift for shift in range(1, NEARBY + 1)):
        too_near = side == sign and abs(found.after - contact) < least_distance(
            run.chain, found.after
        )
        if too_near or not 0 < contact < run.chain.beads:
            break
        near = _events_at(run, contact)
        same = [
            event for event in near
            if event.direction == sign
            and abs(event.time - incident.time) < NEARBY * incident.duration
            and abs(event.energy - incident.energy) < SAME * incident.energy
        ]  # fmt: skip
        if same:
            here = _between(run, (contact, found.after), same[-1], near, far, stop)
            nearby.append(here.reflected_energy)
    return nearby


def _events_at(run: Trajectory, contact: int) -> list[WaveEvent]:
    """Waves at a contact that are strong enough there; most of the run's force may be elsewhere."""
    own = float(np.max(ContactCurves(run, contact).force, initial=0.0))
    return events_at(run, contact, max(THRESHOLD * own, ROUNDING * largest_force_of(run)))


def _missing_momentum(
    run: Trajectory, events: list[WaveEvent], incident: WaveEvent, last: float
) -> float:
    """Part of the impulse at the contact of events that none of them has."""
    if not events or events[0].contact in (0, run.chain.beads):
        return 0.0
    whole = ContactCurves(run, events[0].contact).force_curve.antiderivative()
    found = sum(event.impulse for event in events if event.time <= last)
    # The last event may end after the count.
    end = max([last, *(event.end for event in events if event.time <= last)])
    return (float(whole(end) - whole(incident.begin)) - found) / incident.impulse


def _end_of_count(
    entering: list[WaveEvent],
    incident: WaveEvent,
    stop: float,
    has_left: Callable[[float], bool],
) -> tuple[float, float]:
    """Time at which counting ends because another wave enters, energy of earlier ones."""
    entered = strong = 0.0
    for event in sorted(entering, key=lambda each: each.begin):
        share = event.energy / incident.energy
        if event.begin >= stop:
            break
        if share > WEAK:
            late = event.begin > incident.end and not has_left(event.begin)
            if not late or strong + share > MISSING:
                return event.begin, entered
            strong += share
        entered += share
    return stop, entered


def _inflow(run: Trajectory, first: int, second: int, begin: float, end: float) -> float:
    """Net energy that flowed in between two contacts, between two times."""
    flows = (ContactCurves(run, k).power_curve.antiderivative() for k in (first, second))
    here, there = (float(whole(end) - whole(begin)) for whole in flows)
    return here - there


def _time(chain: Chain, time: float) -> str:
    return f"t = {measure(time, 's', chain.units, 6)}"


def _check_rarefactions(run: Trajectory, found: Reflection) -> None:
    """Raise an error if waves below the static force, which are not counted, have much energy."""
    shares = {}
    for contact in (found.before, found.after):
        curves = ContactCurves(run, contact)
        during = (curves.times >= found.incident.begin) & (curves.times <= found.until)
        # Without a static force, a negative force is that of a loss that pulls.
        below = during & (curves.force < 0.0) & (static_forces_of(run)[contact] > 0.0)
        energy = np.trapezoid(np.where(below, np.abs(curves.power), 0.0), curves.times)
        shares[contact] = float(energy) / found.incident.energy
    contact, share = max(shares.items(), key=lambda each: each[1])
    if share > WEAK:
        raise SimulationError(
            f"no coefficients: rarefactions, which reflection does not count, carry {share:.2g} "
            f"times the energy of the first wave through contact {contact}; use "
            f"run.energy_flux().balance({found.before}, {found.after}): returned_energy is the "
            f"reflected fraction if the reflected wave arrives at contact {found.before} after the "
            "incident one has passed, and the run ends before waves return from the ends"
        )


def _check_count(run: Trajectory, found: Reflection) -> None:
    """Raise an error if the incident wave has not passed, or waves are not resolved."""
    incident = found.incident
    if found.until <= incident.end:
        until, end = (_time(run.chain, each) for each in (found.until, incident.end))
        enters = "another wave enters"
        if not run.chain.lossless:
            enters = "another wave, or the tail that losses leave behind this one, enters"
        if not found.disturbed and found.until == float(run.times[-1]):
            raise SimulationError(
                f"no coefficients: the incident wave still passes contact {found.before} at the "
                f"end of the run, {until}; simulate for longer"
            )
        reason = f"; {enters} at {until}" if found.disturbed else ""
        raise SimulationError(
            f"no coefficients: the incident wave passes contact {found.before} until {end}"
            f"{reason}; choose other contacts, since or until, or use the balance of all waves, "
            f"run.energy_flux().balance({found.before}, {found.after})"
        )
    contacts = (found.before, found.after)
    require_resolved(run, incident, "the incident wave", contacts)
    for event in (*found.reflected, *found.transmitted):
        if event.energy >= WEAK * incident.energy:
            name = "a reflected" if event in found.reflected else "a transmitted"
            require_resolved(run, event, f"{name} wave", contacts)


def _later(found: Reflection) -> str:
    """How the waves that are still between the contacts can be counted."""
    if found.disturbed:
        return "another wave enters then; choose contacts nearer to the object between them"
    return "simulate for longer"


def _differs(found: Reflection, nearby: list[float]) -> bool:
    """Whether the reflected energy is not the median of that at neighbouring contacts."""
    usual = float(np.median(nearby)) if nearby else found.reflected_energy
    return abs(found.reflected_energy - usual) > max(SAME * usual, SMALL)


def _away(part: Incomplete) -> str:
    """Energy that moves away from the contact and may still be reflected, if it is relevant."""
    if part.away < LEAST:
        return ""
    return f", and {part.away:.4f} moves away from it, of which a part may still be reflected"


def _dependence(found: Reflection, nearby: list[float]) -> str:
    """Why the coefficient is not that of neighbouring contacts, or ''."""
    if not _differs(found, nearby):
        return ""
    usual = float(np.median(nearby))
    low, high = found.nearby_energy
    apart = sorted((found.before, found.before - found.incident.direction * NEARBY))
    return (
        f"the reflected energy depends on the contact: {found.reflected_energy:.4f} at contact "
        f"{found.before}, but {low:.4f} to {high:.4f} at neighbours (median {usual:.4f}, "
        f"contacts {apart[0]} to {apart[1]}), because other waves meet the reflected one "
        "there; choose a contact whose neighbours agree, or take the range as the uncertainty"
    )


def _other_waves(found: Reflection) -> str:
    """Why the coefficients are not those of one wave, or ''."""
    if abs(found.unexplained_energy) <= MISSING:
        return ""
    return (
        f"other waves contribute: {found.unexplained_energy:.0%} of the incident energy is "
        "missing from the balance, so the coefficients are not those of one wave; choose "
        "other contacts, since or until"
    )


def _growing(found: Reflection) -> str:
    """Which coefficient depends on the end of the count, or ''."""
    parts = zip(("reflected", "transmitted"), found.late_energy, strict=True)
    name, late = max(parts, key=lambda each: each[1])
    # Otherwise the waves of a train have passed one after another, and the coefficient is final.
    if not min(late, found.entered_energy) > SMALL:
        return ""
    whole = getattr(found, f"{name}_energy")
    return (
        f"the {name} energy depends on the end of the count: it rose from {whole - late:.4f} to "
        f"{whole:.4f} in the last third of the time until {_time(found.chain, found.until)}, "
        f"and weak waves with {found.entered_energy:.4f} of the incident energy followed the "
        "incident one; state until, or use the balance of all waves, "
        f"run.energy_flux().balance({found.before}, {found.after})"
    )


def _on_the_way(found: Reflection, *, known: bool) -> str:
    """Which energy has not passed a contact yet, or ''.

    If another wave ends the count, weak waves are not mentioned where a larger error is known.
    """
    moving = found.stored_energy - found.separated_energy
    if moving > MISSING:
        return (
            f"{moving:.0%} of the incident energy is still between the contacts at "
            f"{_time(found.chain, found.until)}; {_later(found)}"
        )
    if not (known and found.disturbed) and (part := incomplete(found)):
        return (
            f"the {part.name} energy, {part.counted:.4f}, is not complete: waves with "
            f"{part.coming:.4f} of the incident energy are still on their way to contact "
            f"{part.contact} at {_time(found.chain, found.until)}"
            f"{_away(part)}; {_later(found)}"
        )
    return ""


def _stays(found: Reflection) -> str:
    """Which energy does not return, because its beads have separated, or ''."""
    if found.separated_energy <= MISSING:
        return ""
    return (
        f"{found.separated_energy:.0%} of the incident energy is that of beads that have separated "
        "and fly away from the free end: it does not return to the contacts, however long the run "
        "is; to hold the beads, add a wall with chain.replace(right_wall=hc.Wall()), or left_wall"
    )


def _missing_in_waves(found: Reflection) -> str:
    """Which momentum belongs to no wave, or ''."""
    if abs(found.missing_momentum) <= MISSING:
        return ""
    return (
        f"{found.missing_momentum:.0%} of the incident momentum passes one of the contacts, "
        "but belongs to no wave, so the coefficients of momentum are not complete; choose "
        "other contacts, or integrate run.forces"
    )

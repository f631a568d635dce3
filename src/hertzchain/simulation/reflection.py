"""Reflection and transmission of a wave by a wall, an interface or a defect."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from hertzchain.chain.chain import Chain
from hertzchain.checks import number, whole_number
from hertzchain.errors import InputError, InputWarning, SimulationError
from hertzchain.simulation.wave_events import (
    ContactCurves,
    WaveEvent,
    check_saved_times,
    events_at,
    largest_force_of,
    require_resolved,
)

if TYPE_CHECKING:
    from hertzchain.simulation.run import Run

# Events from this part of the largest force on are counted.
THRESHOLD: Final = 0.01
# Waves of less than this part of the incident energy need not be resolved, nor do they end the
# count when they enter from outside.
WEAK: Final = 0.01
# Part of the incident energy that may be missing from the balance, or still between the contacts.
MISSING: Final = 0.05


@dataclass(frozen=True, eq=False)
class Reflection:
    r"""What became of a wave between two contacts.

    With impulses J and works W of the wave events at the contacts ``before`` and ``after``,

    .. math:: R = \frac{\sum |W_\text{reflected}|}{W_\text{incident}}, \qquad
              T = \frac{\sum |W_\text{transmitted}|}{W_\text{incident}},

    and likewise with J for momentum.

    Attributes
    ----------
    chain : Chain
        The chain.
    before, after : int
        The contacts between which the object is.
    incident : WaveEvent
        The first wave at ``before`` that runs towards ``after``.
    reflected : tuple of WaveEvent
        What passed ``before`` in the other direction later, until ``until``.
    transmitted : tuple of WaveEvent
        What passed ``after`` in the direction of the incident wave, until ``until``.
    until : float
        Time up to which events count [scaled, or s]: the time asked for, the end of the run, or
        the time at which another wave entered from outside.
    disturbed : bool
        Whether another wave entered from outside, and ended the count, before the time asked for
        or the end of the run.
    kept_energy : float
        Net energy that flowed in between the two contacts from the beginning of the incident
        wave until ``until``, in parts of the incident energy: it is still there, or lost there.

    Examples
    --------
    A wave that comes to beads of twice the radius:

    >>> import hertzchain as hc
    >>> import numpy as np
    >>> radii = np.where(np.arange(120) < 60, 1.0, 2.0)
    >>> run = hc.simulate(hc.Chain.from_radii(radii), until=140.0, times=1500)
    >>> found = run.reflection(50, 75)
    >>> round(found.reflected_energy, 3), round(found.transmitted_energy, 3)
    (0.523, 0.476)
    """

    chain: Chain
    before: int
    after: int
    incident: WaveEvent
    reflected: tuple[WaveEvent, ...]
    transmitted: tuple[WaveEvent, ...]
    until: float
    disturbed: bool
    kept_energy: float

    @property
    def reflected_energy(self) -> float:
        """Coefficient R of energy."""
        return sum(event.energy for event in self.reflected) / self.incident.energy

    @property
    def transmitted_energy(self) -> float:
        """Coefficient T of energy; 0 where ``after`` is a wall or a free end."""
        return sum(event.energy for event in self.transmitted) / self.incident.energy

    @property
    def reflected_momentum(self) -> float:
        """Momentum carried back, in parts of the incident momentum, positive."""
        return sum(event.impulse for event in self.reflected) / self.incident.impulse

    @property
    def transmitted_momentum(self) -> float:
        """Momentum carried on, in parts of the incident momentum."""
        return sum(event.impulse for event in self.transmitted) / self.incident.impulse

    @property
    def reflected_force(self) -> float:
        """Largest force of the reflected waves, in parts of the incident wave's."""
        return max((e.amplitude for e in self.reflected), default=0.0) / self.incident.amplitude

    @property
    def transmitted_force(self) -> float:
        """Largest force of the transmitted waves, in parts of the incident wave's."""
        return max((e.amplitude for e in self.transmitted), default=0.0) / self.incident.amplitude

    @property
    def unexplained_energy(self) -> float:
        """What 1 - R - T - ``kept_energy`` leaves.

        It is far from 0 where other waves were between the contacts, or passed one of them
        together with a counted wave; then the coefficients are not those of one wave.
        """
        return 1.0 - self.reflected_energy - self.transmitted_energy - self.kept_energy

    def __repr__(self) -> str:
        ended = "another wave entered" if self.disturbed else "nothing else entered"
        return (
            f"Reflection(between contacts {self.before} and {self.after}, until t = "
            f"{self.until:.4g}, {ended}:\n"
            f"  reflected    energy {self.reflected_energy:.4f}, momentum "
            f"{self.reflected_momentum:.4f}, waves {len(self.reflected)}\n"
            f"  transmitted  energy {self.transmitted_energy:.4f}, momentum "
            f"{self.transmitted_momentum:.4f}, waves {len(self.transmitted)}\n"
            f"  energy still between them or lost there {self.kept_energy:.4f})"
        )


def reflection_of(
    run: Run, before: int, after: int, since: float = 0.0, until: float | None = None
) -> Reflection:
    """What became of a wave between two contacts; see `hertzchain.Run.reflection`.

    Parameters
    ----------
    run : Run
        A run with saved times.
    before, after : int
        Contacts before and after the object, in the direction of the wave.
    since, until : float
        Times between which to look.

    Returns
    -------
    Reflection

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(40).replace(right_wall=hc.Wall.rigid())
    >>> found = reflection_of(hc.simulate(chain, until=80.0, times=1000), 30, 40)
    >>> round(found.reflected_energy, 3)
    1.0
    """
    beads = run.chain.beads
    first = whole_number("before", before, least=1, most=beads - 1)
    second = whole_number("after", after, least=0, most=beads)
    if first == second:
        raise InputError(f"before and after must be two contacts, got {first} twice")
    begin = number("since", since)
    stop = np.inf if until is None else number("until", until, above=begin)
    check_saved_times(run)
    floor = THRESHOLD * largest_force_of(run)
    sign = 1 if second > first else -1
    near = [event for event in events_at(run, first, floor) if event.time >= begin]
    incident = next((event for event in near if event.direction == sign), None)
    if incident is None or incident.time > stop:
        raise SimulationError(
            f"no wave towards contact {second} passes contact {first} in the time looked at; "
            f"{run.message}"
        )
    near = [event for event in near if event.time > incident.time]
    far = [event for event in events_at(run, second, floor) if event.time > incident.time]

    stop = min(stop, float(run.times[-1]))
    entering = [e for e in near if e.direction == sign] + [e for e in far if e.direction == -sign]
    last = min(stop, _first_entry(entering, incident))
    reflected = tuple(e for e in near if e.direction == -sign and e.time <= last)
    transmitted = tuple(e for e in far if e.direction == sign and e.time <= last)
    found = Reflection(
        chain=run.chain, before=first, after=second, incident=incident, reflected=reflected,
        transmitted=transmitted, until=last, disturbed=last < stop,
        kept_energy=sign * _inflow(run, first, second, incident.begin, last) / incident.energy,
    )  # fmt: skip
    _check_count(run, found)
    _warn_of_balance(found)
    return found


def _first_entry(entering: list[WaveEvent], incident: WaveEvent) -> float:
    """When the first other wave of some strength enters from outside; infinite if none does."""
    strong = (event.begin for event in entering if event.energy > WEAK * incident.energy)
    return min(strong, default=np.inf)


def _inflow(run: Run, first: int, second: int, begin: float, end: float) -> float:
    """Energy that flowed to the right at one contact and not at the other, between two times."""
    flows = (ContactCurves(run, k).power_curve.antiderivative() for k in (first, second))
    here, there = (float(whole(end) - whole(begin)) for whole in flows)
    return here - there


def _check_count(run: Run, found: Reflection) -> None:
    """Refuse a count that ends before the incident wave has passed, and waves not resolved."""
    incident = found.incident
    if found.until <= incident.end:
        reason = f"; another wave enters at t = {found.until:g}" if found.disturbed else ""
        raise SimulationError(
            f"no coefficients: the incident wave passes contact {found.before} until t = "
            f"{incident.end:g}{reason}; choose other contacts, since or until, or use "
            "run.energy_flux()"
        )
    require_resolved(run, incident, "the incident wave")
    for event in (*found.reflected, *found.transmitted):
        if event.energy >= WEAK * incident.energy:
            name = "a reflected" if event in found.reflected else "a transmitted"
            require_resolved(run, event, f"{name} wave")


def _warn_of_balance(found: Reflection) -> None:
    """Warn where the coefficients are not, or not yet, those of one wave."""
    if abs(found.unexplained_energy) > MISSING:
        reason = (
            f"other waves take part: {found.unexplained_energy:.0%} of the incident energy is "
            "missing from the balance, and the coefficients are not those of one wave; choose "
            "other contacts, since or until"
        )
    elif found.kept_energy > MISSING and found.chain.loss is None:
        advice = "choose another since or until" if found.disturbed else "simulate for longer"
        reason = (
            f"{found.kept_energy:.0%} of the incident energy is still between the contacts at t = "
            f"{found.until:g}; {advice}"
        )
    else:
        return
    warnings.warn(reason, InputWarning, stacklevel=4)

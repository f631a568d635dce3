"""Values of quantities in a recorded run, and how they depend on its states."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..collision import Array
from ..kernels.limits import MIN_ROUGH_PUSH
from ..representation import measure
from ..simulation.wall_bound import LEFT, RIGHT
from .backward_pass import Dependence, Place, Slopes, place_of_event
from .gauges import (
    LOWEST,
    Missing,
    check_smooth,
    contact_forces,
    contacts_of,
    fastest,
    first_maximum,
    impulse,
    largest,
    locate,
    maxima,
    stage_forces,
)
from .names import Name
from .record import Record
from .targets import Ending, is_moving


@dataclass(eq=False)
class Reader:
    """Reads quantities from a recorded run."""

    record: Record
    ending: Ending
    until: float | None

    def read(self, name: Name) -> list[tuple[Name, Dependence, str]]:
        """The quantity, or several for all maxima, with a note if it may be incomplete."""
        if name.group == "pulse":
            return [(name, self._pulse(name), "")]
        if name.group == "sensor":
            return [(name, self._sensor(name), "")]
        if name.group in ("wall_force", "left_wall_force"):
            return self._wall(name)
        if name.group == "body_force":
            note = "" if self.ending.body_is_complete(self.record) else "the peak is not complete"
            return [(name, each, note) for each in self._body(name)]
        if name.group == "bead":
            return [(name, *self._fastest(name, (name.bead or 1) - 1))]
        return [(name, self._final(name), "")]

    @property
    def _equation(self) -> Any:
        return self.record.equation

    @property
    def _end(self) -> str:
        """Time of the end of the run."""
        return f"t = {measure(self.record.time, 's', self._equation.chain.units, 6)}"

    def _zero(self) -> Slopes:
        return Slopes.zero(self._equation.beads)

    def _target(self, kind: int, first: int, second: int | None = None) -> int:
        return self.ending.targets.number(kind, first, second)

    def _event(self, kind: int, first: int, what: str) -> Place:
        """State at the first event of a kind."""
        place = place_of_event(self.record, self._target(kind, first))
        if place is None:
            raise Missing(f"{what} before the end of the run at {self._end}")
        return place

    def _pulse(self, name: Name) -> Dependence:
        from ..kernels.adjoint_layout import CLOSING

        bead = name.bead or 0
        if name.item in ("velocity", "momentum", "energy", "peak_time"):
            return self._velocity(name, bead - 1)
        if name.item == "arrival":
            return self._crossing(bead - 1) if bead > 1 else Dependence(0.0, [], self._zero())
        if name.item == "residence":
            after = self._crossing(bead)
            if bead == 1:
                return after
            before = self._crossing(bead - 1)
            return _combined(after.value - before.value, (after, 1.0), (before, -1.0))
        place = self._event(CLOSING, bead, f"contact {bead} has no largest overlap")
        overlap = float(self._equation.overlaps_at(place.positions)[bead])
        direct = self._zero()
        if name.item == "peak_overlap":
            direct.overlaps[bead] = 1.0
            place.by_position[bead - 1], place.by_position[bead] = 1.0, -1.0
            return Dependence(overlap, [place], direct)
        value = self._add_force(place, direct, bead, 1.0)
        return Dependence(value, [place], direct)

    def _velocity(self, name: Name, i: int) -> Dependence:
        from ..kernels.adjoint_layout import VELOCITY

        equation, direct = self._equation, self._zero()
        mass = float(equation.masses[i])
        if is_moving(equation, i + 1):
            place = self._event(VELOCITY, i, f"the velocity of bead {i + 1} has no maximum")
            check_smooth(equation, place, (i, i + 1), in_velocity=True)
            speed, places = float(place.velocities[i]), [place]
            if name.item == "peak_time":
                return self._time_of_rest(place, i)
        else:
            speed, places = float(equation.velocities[i]), []
            if name.item == "peak_time":
                return Dependence(0.0, [], direct)
        value, by_velocity, direct.masses[i] = _of_velocity(name.item, mass, speed)
        (places[0].by_velocity if places else direct.velocities)[i] = by_velocity
        return Dependence(value, places, direct)

    def _fastest(self, name: Name, i: int) -> tuple[Dependence, str]:
        """Largest forward velocity of bead i in the whole run, and quantities at this time."""
        from ..kernels.adjoint_layout import MAXIMUM

        equation, direct = self._equation, self._zero()
        place = fastest(self.record, self._target(MAXIMUM, i), i)
        speed = float(equation.velocities[i])
        end = float(self.record.velocities[i])
        top = -math.inf if place is None else float(place.velocities[i])
        if place is not None and top >= max(speed, end):
            check_smooth(equation, place, (i, i + 1), in_velocity=True)
        elif end > speed:
            place, top = self._last_place(), end
        else:
            place, top = None, speed
        if not top > 0.0:
            raise Missing(f"bead {i + 1} does not move forward")
        mass = float(equation.masses[i])
        value, by_velocity, direct.masses[i] = _of_velocity(name.quantity, mass, top)
        (direct.velocities if place is None else place.by_velocity)[i] = by_velocity
        rising = place is not None and top == end and float(place.accelerations[i]) > 0.0
        note = "the velocity still rises at the end of the run" if rising else ""
        return Dependence(value, [] if place is None else [place], direct), note

    def _time_of_rest(self, place: Place, i: int) -> Dependence:
        """Time at which the acceleration of bead i vanishes."""
        equation, direct = self._equation, self._zero()
        m, rates = float(equation.masses[i]), self._slopes(place)
        closing = -np.diff(np.pad(place.velocities, 1))
        jerk = (rates[i] * closing[i] - rates[i + 1] * closing[i + 1]) / m
        if jerk == 0.0:
            raise Missing(
                f"the time of the velocity maximum of bead {i + 1} has no gradient, because the "
                "bead leaves both neighbours at that time"
            )
        net = float(place.accelerations[i]) - float(equation.body[i])
        for c, sign in ((i, 1.0), (i + 1, -1.0)):
            self._add_force(place, direct, c, -sign / (m * jerk))
        direct.masses[i] += net / (m * jerk)
        direct.body[i] -= 1.0 / jerk
        return Dependence(place.time, [place], direct)

    def _slopes(self, place: Place) -> Array:
        """Derivatives of the forces by the overlaps."""
        overlaps = np.maximum(self._equation.overlaps_at(place.positions), 0.0)
        p, k = self._equation.exponents, self._equation.stiffness
        return np.asarray(p * k * overlaps ** (p - 1.0))

    def _crossing(self, contact: int) -> Dependence:
        """Time at which a contact has its first largest overlap."""
        from ..kernels.adjoint_layout import CLOSING

        place = self._event(CLOSING, contact, f"the pulse does not reach bead {contact + 1}")
        bend = float(place.accelerations[contact - 1] - place.accelerations[contact])
        place.by_velocity[contact - 1], place.by_velocity[contact] = -1.0 / bend, 1.0 / bend
        return Dependence(place.time, [place], self._zero())

    def _add_force(self, place: Place, direct: Slopes, c: int, weight: float) -> float:
        """Add the dependence on the force of a contact; return the force times the weight."""
        equation = self._equation
        overlap = max(0.0, float(equation.overlaps_at(place.positions)[c]))
        p, k = float(equation.exponents[c]), float(equation.stiffness[c])
        slope = weight * p * k * overlap ** (p - 1.0)
        if c > 0:
            place.by_position[c - 1] += slope
        if c < equation.beads:
            place.by_position[c] -= slope
        direct.overlaps[c] += slope
        direct.stiffness[c] += weight * overlap**p
        return weight * k * overlap**p

    def _gauge(self, place: Place, contacts: tuple[int, ...]) -> Dependence:
        """Mean force of contacts at a state."""
        direct, weight = self._zero(), 1.0 / len(contacts)
        value = 0.0
        pushing = contact_forces(self._equation, place.positions, place.velocities)
        check_smooth(self._equation, place, contacts)
        for c in contacts:
            if pushing[c] != 0.0:
                value += self._add_force(place, direct, c, weight)
                value += self._add_damping(place, direct, c, weight)
        return Dependence(value, [place], direct)

    def _add_damping(self, place: Place, direct: Slopes, c: int, weight: float) -> float:
        """Add the dependence on the damping force of a contact; return it times the weight."""
        equation = self._equation
        if equation.hertz is not None:
            return 0.0
        overlap = float(equation.overlaps_at(place.positions)[c])
        closing = float(-np.diff(np.pad(place.velocities, 1))[c])
        q, g = float(equation.overlap_powers[c]), float(equation.damping[c])
        power = weight * overlap**q
        by_overlap = q * g * power / overlap * closing
        for i, sign in ((c - 1, 1.0), (c, -1.0)):
            if 0 <= i < equation.beads:
                place.by_position[i] += sign * by_overlap
                place.by_velocity[i] += sign * g * power
        direct.overlaps[c] += by_overlap
        direct.damping[c] += power * closing
        return g * power * closing

    def _gauge_time(self, place: Place, contacts: tuple[int, ...]) -> Dependence:
        """Time at which the mean force of contacts has a maximum."""
        equation, direct = self._equation, self._zero()
        closing = -np.diff(np.pad(place.velocities, 1))
        speeding = -np.diff(np.pad(place.accelerations, 1))
        overlaps, slopes = equation.overlaps_at(place.positions), self._slopes(place)
        p = equation.exponents
        closed = [c for c in contacts if overlaps[c] > 0.0]
        bends = {c: (p[c] - 1.0) * slopes[c] / overlaps[c] for c in closed}
        rate = sum(slopes[c] * speeding[c] + bends[c] * closing[c] ** 2 for c in closed)
        for c in closed:
            by_overlap = -bends[c] * closing[c] / rate
            by_closing = -slopes[c] / rate
            direct.overlaps[c] += by_overlap
            direct.stiffness[c] += by_closing * closing[c] / equation.stiffness[c]
            for i, sign in ((c - 1, 1.0), (c, -1.0)):
                if 0 <= i < equation.beads:
                    place.by_position[i] += sign * by_overlap
                    place.by_velocity[i] += sign * by_closing
        return Dependence(place.time, [place], direct)

    def _impulse(self, contacts: tuple[int, ...], steps: int) -> Dependence:
        """Impulse of the mean force of contacts in the first steps."""
        gauge = np.zeros(self._equation.beads + 1)
        gauge[list(contacts)] = 1.0 / len(contacts)
        value = float(impulse(self.record, contacts)[:steps].sum())
        return Dependence(value, [], self._zero(), gauge, steps)

    def _sensor(self, name: Name) -> Dependence:
        from ..kernels.adjoint_layout import GAUGE

        contacts = contacts_of(name.bead or 0)
        if name.item == "impulse":
            return self._impulse(contacts, self.record.steps)
        target = self._target(GAUGE, *contacts)
        if name.item.startswith("first"):
            step = first_maximum(self.record, name.bead or 0)
            place = None if step is None else locate(self.record, target, step)
        else:
            place = largest(self.record, target)
        if place is None:
            raise Missing(
                f"the force in bead {name.bead} has no maximum before the end of the run at "
                f"{self._end}"
            )
        read = self._gauge_time if name.item.endswith("time") else self._gauge
        return read(place, contacts)

    def _body(self, name: Name) -> list[Dependence]:
        """Force of the last contact of a free end, or the acceleration of its last body."""
        from ..kernels.adjoint_layout import GAUGE

        equation = self._equation
        contact = equation.beads - 1
        target = self._target(GAUGE, contact)
        if name.item == "maxima":
            return self._maxima(target, (contact,))
        place = largest(self.record, target)
        if place is None:
            raise Missing(
                f"the force on the last body has no maximum before the end of the run at "
                f"{self._end}"
            )
        force = self._gauge(place, (contact,))
        if name.item == "peak":
            return [force]
        mass = float(equation.masses[-1])
        found = _combined(force.value / mass, (force, 1.0 / mass))
        found.direct.masses[-1] -= force.value / mass**2
        return [found]

    def _wall(self, name: Name) -> list[tuple[Name, Dependence, str]]:
        from ..kernels.adjoint_layout import GAUGE

        side = RIGHT if name.group == "wall_force" else LEFT
        contact = self._equation.beads if side == RIGHT else 0
        target, contacts = self._target(GAUGE, contact), (contact,)
        complete = self.ending.complete(self.record, side, self.until)
        note = "" if complete else "the peak is not complete"
        ended = "" if side in self.ending.since else "the impact on the wall has not ended"
        if name.item == "impulse":
            return [(name, self._impulse(contacts, self.record.steps), "")]
        if name.item == "first_contact_impulse":
            return [(name, self._impulse(contacts, self._first_contact(contacts)), "")]
        if name.item == "maxima":
            return [(name, each, note) for each in self._maxima(target, contacts)]
        if name.item == "impulse_of_impact":
            return [(name, self._impulse(contacts, self._impact(side)), note or ended)]
        place = largest(self.record, target)
        if place is None:
            raise Missing(
                f"the force on the wall has no maximum before the end of the run at {self._end}"
            )
        if name.item == "peak_time":
            return [(name, self._gauge_time(place, contacts), note)]
        peak = self._gauge(place, contacts)
        if name.item == "peak":
            return [(name, peak, note)]
        total = self._impulse(contacts, self._impact(side))
        duration = total.value / peak.value
        found = _combined(
            duration, (total, 1.0 / peak.value), (peak, -duration / peak.value)
        )  # fmt: skip
        return [(name, found, note or ended)]

    def _maxima(self, target: int, contacts: tuple[int, ...]) -> list[Dependence]:
        """All maxima of at least half the largest one, the largest one first."""
        candidates = maxima(self.record, target)
        top = max((force for _, force in candidates), default=0.0)
        places = [
            locate(self.record, target, n) for n, force in candidates if force >= LOWEST * top
        ]
        found = [self._gauge(place, contacts) for place in places if place is not None]
        if not found:
            raise Missing("the force has no maximum before the end of the run")
        return sorted(found, key=lambda each: -each.value)

    def _impact(self, side: int) -> int:
        """Number of steps until the peak on a wall is complete and the wall is free."""
        since = self.ending.since.get(side, self.record.time)
        lengths = np.concatenate([block.lengths for block in self.record.blocks])
        first = int(np.count_nonzero(np.cumsum(lengths) - lengths < since))
        # The force is then a thousandth of the peak; a cut before its end would be in the gradient.
        contact = self._equation.beads if side == RIGHT else 0
        free = np.flatnonzero(stage_forces(self.record, (contact,))[first:, 0] == 0.0)
        return first + int(free[0]) if len(free) else first

    def _first_contact(self, contacts: tuple[int, ...]) -> int:
        """Number of steps until the end of the first contact with a wall."""
        equation = self._equation
        total = np.cumsum(impulse(self.record, contacts))
        least = MIN_ROUGH_PUSH * float(np.abs(equation.masses * equation.velocities).sum())
        forces = stage_forces(self.record, contacts)
        ended = np.flatnonzero((total[:-1] > least) & (forces[1:, 0] == 0.0))
        if not len(ended):
            raise Missing(f"the first contact with the wall has not ended at {self._end}")
        return int(ended[0]) + 1

    def _last_place(self) -> Place:
        """State at the end of the run."""
        from ..kernels.adjoint_layout import KEPT_SWITCHES

        record, beads = self.record, self._equation.beads
        block, n = record.block_of(record.steps - 1)
        low, high = (int(each) for each in block.windows[n])
        kept = block.kept[n].copy()
        if self._equation.hertz is None:
            # Contacts that are released at the end change no velocity.
            kept[KEPT_SWITCHES] = 0.0
        forces = contact_forces(self._equation, record.positions, record.velocities)
        accelerations = -np.diff(forces) / self._equation.masses + self._equation.body
        return Place(
            record.steps - 1, float(block.lengths[n]), low, high, kept, record.time,
            record.positions, record.velocities, accelerations, np.zeros(beads), np.zeros(beads),
        )  # fmt: skip

    def _final(self, name: Name) -> Dependence:
        """A quantity of the state at the end of the run."""
        record, equation = self.record, self._equation
        direct, beads, place = self._zero(), equation.beads, self._last_place()
        i = (name.bead or 1) - 1
        if name.group == "final":
            moved = name.item == "position"
            (place.by_position if moved else place.by_velocity)[i] = 1.0
            return Dependence(float((record.positions if moved else record.velocities)[i]),
                              [place], direct)  # fmt: skip
        value, v = 0.0, record.velocities
        if name.item in ("kinetic", "forward", "backward"):
            chosen = {"kinetic": np.full(beads, True), "forward": v > 0.0}
            own = chosen.get(name.item, v <= 0.0)
            value = float((0.5 * equation.masses * v**2)[own].sum())
            place.by_velocity[own] = (equation.masses * v)[own]
            direct.masses[own] = 0.5 * v[own] ** 2
            return Dependence(value, [place], direct)
        overlaps = np.maximum(equation.overlaps_at(record.positions), 0.0)
        forces, p = equation.forces(overlaps), equation.exponents
        walls = name.item == "walls"
        for c in (0, beads) if walls else range(1, beads):
            value += forces[c] * overlaps[c] / (p[c] + 1.0)
            direct.overlaps[c] += forces[c]
            direct.stiffness[c] += overlaps[c] ** (p[c] + 1.0) / (p[c] + 1.0)
            for k, sign in ((c - 1, 1.0), (c, -1.0)):
                if 0 <= k < beads:
                    place.by_position[k] += sign * forces[c]
        return Dependence(float(value), [place], direct)


def _of_velocity(quantity: str, mass: float, speed: float) -> tuple[float, float, float]:
    """A quantity of a bead, and its derivatives by velocity and mass."""
    return {
        "velocity": (speed, 1.0, 0.0),
        "momentum": (mass * speed, mass, speed),
        "energy": (0.5 * mass * speed**2, mass * speed, 0.5 * speed**2),
    }[quantity]


def _combined(value: float, *terms: tuple[Dependence, float]) -> Dependence:
    """A weighted sum of dependences, of which at most one has an impulse."""
    direct = Slopes.zero(len(terms[0][0].direct.masses))
    places, gauge, last = [], np.zeros(0), 0
    for term, weight in terms:
        for name, values in vars(direct).items():
            values += weight * getattr(term.direct, name)
        for place in term.places:
            place.by_position *= weight
            place.by_velocity *= weight
            places.append(place)
        if len(term.gauge):
            gauge, last = weight * term.gauge, term.last
    return Dependence(value if math.isfinite(value) else math.nan, places, direct, gauge, last)

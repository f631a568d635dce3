"""An independent integration of any chain by SciPy, restarted whenever a contact force switches.

It is written from the equations of the documentation and of the papers cited there.  Only the
description of a chain is used (radii, materials, given values, walls, law, drive); masses, Hertz
stiffness, static equilibrium, contact laws and drives are computed here.  All numbers are made
dimensionless with rough units of the motion, so that the same tolerances suit chains in metres.

Within a piece of the integration, each contact remains open, loading, unloading or stuck.  Its
*margin* is positive as long as this state is correct; the first zero of a margin on the dense
output of SciPy ends the piece.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import DOP853, Radau
from scipy.optimize import brentq
from scipy_laws import (
    LOADING,
    NOISE,
    OPEN,
    STUCK,
    UNLOADING,
    Mixed,
    Plastic,
    described_exponents,
    described_laws,
    law_of,
    laws_of,
)

MAX_SWITCHES = 20_000


class Units(NamedTuple):
    """Rough units of the motion in a chain; those of a scaled chain are one."""

    length: float = 1.0
    time: float = 1.0
    mass: float = 1.0

    @property
    def velocity(self):
        return self.length / self.time

    @property
    def force(self):
        return self.mass * self.length / self.time**2

    def stiffness(self, exponent):
        return self.force / self.length**exponent


class Motion(NamedTuple):
    """At each time: beads' displacements since time 0 and velocities, forces of contacts 0..N.

    Also the integrals up to each time: impulses of the left and the right wall, work of the drive.
    """

    displacements: np.ndarray
    velocities: np.ndarray
    forces: np.ndarray
    impulses: np.ndarray
    work: np.ndarray


def masses_of(chain):
    if "masses" in chain.given:
        return np.array(chain.masses)
    if chain.materials is None:
        masses = chain.radii**3
    else:
        masses = np.array([
            m.density * 4.0 * math.pi * r**3 / 3.0
            for m, r in zip(chain.materials, chain.radii, strict=True)
        ])  # fmt: skip
    for k, striker in enumerate(chain.striker_properties):
        if striker.mass is not None:
            masses[k] = striker.mass
    return masses


def hertz(one, other, radius, other_radius):
    """4/3 E* sqrt(R*), Johnson's Eqs. (4.20) to (4.22); a material is (E, nu)."""
    softness = sum((1.0 - nu**2) / young for young, nu in (one, other))
    return 4.0 / 3.0 / softness / math.sqrt(1.0 / radius + 1.0 / other_radius)


def elastic_constants(chain):
    """(E, nu) of each bead.  Scaled, two equal beads of radius 1 have stiffness 1."""
    if chain.materials is None:
        return [(1.5 * math.sqrt(2.0), 0.0)] * len(chain.radii)
    return [(each.young, each.poisson) for each in chain.materials]


def stiffness_of(chain):
    """Stiffness of contacts 0..N; 0 at a free end."""
    beads = len(chain.radii)
    k = np.zeros(beads + 1)
    solid = elastic_constants(chain)
    if "stiffness" in chain.given:
        k[1:-1] = chain.stiffness
    else:
        radii, given = chain.radii.copy(), chain.striker_properties
        radii[[i for i, striker in enumerate(given) if striker.flat]] = math.inf
        for c in range(1, beads):
            own = given[c - 1].stiffness if c <= len(given) else None
            k[c] = own or hertz(solid[c - 1], solid[c], radii[c - 1], radii[c])
    for end, wall in ((0, chain.left_wall), (-1, chain.right_wall)):
        if wall is None:
            continue
        own = solid[end]
        of_wall = own if wall.material is None else (wall.material.young, wall.material.poisson)
        k[end] = wall.stiffness or hertz(own, of_wall, chain.radii[end], math.inf)
    return k


def yield_overlap(chain, c, law):
    """Overlap at which the largest pressure of contact c is the yield pressure."""
    if law.yield_overlap is not None:
        return law.yield_overlap
    beads = len(chain.radii)
    walls = [wall and wall.material for wall in (chain.left_wall, chain.right_wall)]
    kinds = [walls[0] or chain.materials[0], *chain.materials, walls[1] or chain.materials[-1]]
    radii = [math.inf, *chain.radii, math.inf]
    softness = sum((1.0 - m.poisson**2) / m.young for m in kinds[c : c + 2])
    radius = 1.0 / (1.0 / radii[c] + 1.0 / radii[c + 1])
    known = [m.yield_strength for m in kinds[c : c + 2] if m.yield_strength]
    pressure = law.yield_pressure or (law.factor or 1.6) * min(known)
    # A free end has no contact.
    present = 0 < c < beads or (chain.left_wall, chain.right_wall)[c > 0] is not None
    return radius * (0.5 * math.pi * pressure * softness) ** 2 if present else 1.0


def plastic_overlap(force, k, first):
    """Overlap of an elastic-plastic contact: the force rises linearly, as steeply as at yield."""
    excess = force - k * first**1.5
    return first + excess / (1.5 * k * math.sqrt(first)) if excess > 0.0 else (force / k) ** (2 / 3)


def static_forces(chain, masses):
    """Forces of contacts 0..N at rest; zero if nothing supports the beads."""
    beads, strikers = len(masses), chain.strikers
    forces = np.zeros(beads + 1)
    weight = masses * chain.gravity
    down = chain.right_wall if chain.gravity > 0.0 else chain.left_wall
    stands = (
        chain.gravity != 0.0
        and down is not None
        and down.gap == 0.0
        and not (strikers > 0 and chain.gravity < 0.0)
        and not np.any(chain.gaps[strikers:] > 0.0)
    )
    if chain.precompression == 0.0 and not stands:
        return forces
    # Bead k is at rest: F_k = F_{k-1} + weight_k; the smallest of them is the precompression.
    for k in range(strikers, beads):
        forces[k + 1] = forces[k] + weight[k]
    forces[strikers:] += chain.precompression - min(forces[strikers:])
    return forces


def drive_between(chain, start, end):
    """Value, rate and acceleration of the drive, as one smooth function from start to end."""
    drive, middle = chain.drive, 0.5 * (start + end)
    if drive is None:
        return lambda _t: (0.0, 0.0, 0.0)
    kind, a = type(drive).__name__, getattr(drive, "amplitude", 0.0)
    if kind == "StepDrive":
        if middle >= drive.rise:
            return lambda _t: (a, 0.0, 0.0)
        rise = drive.rise

        def smooth_step(t):
            u = t / rise
            return (a * u * u * (3 - 2 * u), 6 * a * u * (1 - u) / rise, a * (6 - 12 * u) / rise**2)

        return smooth_step
    if kind == "TableDrive":
        values = np.interp([start, end], drive.times, drive.values)
        slope = (values[1] - values[0]) / (end - start)
        return lambda t: (values[0] + slope * (t - start), slope, 0.0)
    if not 0.0 < middle < drive.cycles / drive.frequency:
        return lambda _t: (0.0, 0.0, 0.0)
    w = 2.0 * math.pi * drive.frequency
    slow = 0.0 if drive.window == "none" else w / drive.cycles

    def burst(t):
        s, ds, dds = math.sin(w * t), w * math.cos(w * t), -w * w * math.sin(w * t)
        if slow == 0.0:
            return a * s, a * ds, a * dds
        g = 0.5 * (1.0 - math.cos(slow * t))
        dg, ddg = 0.5 * slow * math.sin(slow * t), 0.5 * slow * slow * math.cos(slow * t)
        return a * g * s, a * (dg * s + g * ds), a * (ddg * s + 2.0 * dg * ds + g * dds)

    return burst


def kinks_of(drive):
    if drive is None:
        return []
    kind = type(drive).__name__
    if kind == "TableDrive":
        return list(drive.times)
    return [drive.rise if kind == "StepDrive" else drive.cycles / drive.frequency]


class Contacts:
    """A chain as dimensionless numbers, and the states of its contacts."""

    def __init__(self, chain, units):
        p = described_exponents(chain)
        masses, k = masses_of(chain), stiffness_of(chain)
        forces = static_forces(chain, masses)
        self.free = k == 0.0
        # A chain after strikers is supported by a force on its first bead, not by their contact.
        held = (
            (forces > 0.0)
            & ~self.free
            & (np.arange(len(k)) >= chain.strikers + bool(chain.strikers))
        )
        overlaps = np.where(held, (forces / np.where(self.free, 1.0, k)) ** (1.0 / p), 0.0)
        for c, law in enumerate(described_laws(chain)):
            if held[c] and type(law).__name__ == "ElasticPlastic":
                overlaps[c] = plastic_overlap(forces[c], k[c], yield_overlap(chain, c, law))
        walls = [getattr(wall, "gap", 0.0) for wall in (chain.left_wall, chain.right_wall)]
        gaps = np.concatenate((walls[:1], chain.gaps, walls[1:]))
        self.at_rest = (overlaps - gaps) / units.length
        outside = masses * chain.gravity
        if chain.precompression > 0.0:
            outside[chain.strikers] += forces[chain.strikers] if self.free[0] else 0.0
            outside[-1] -= forces[-1] if self.free[-1] else 0.0
        self.outside = outside / units.force
        self.m, self.k = masses / units.mass, k / units.stiffness(p)
        self.law = self._laws(chain, p, units)
        self.moves_wall = chain.drive is not None and chain.drive.of == "displacement"
        self.drive, self.drive_unit = None, (units.length if self.moves_wall else units.force)
        self.time_unit = units.time
        self.mode = np.full(len(k), OPEN)
        self.largest = np.zeros(len(k))

    def _laws(self, chain, p, units):
        """One law for all contacts, which is faster, unless they differ."""
        laws = described_laws(chain)
        uniform = all(law == laws[0] for law in laws) and np.all(p == p[0])
        if uniform and type(laws[0]).__name__ != "ElasticPlastic":
            inverse = 1.0 / np.concatenate(([math.inf], self.m, [math.inf]))
            return law_of(laws[0], self.k, 1.0 / (inverse[:-1] + inverse[1:]), p[0], units)

        def first_yield(c, law):
            return yield_overlap(chain, c, law) / units.length

        return laws_of(chain, self.k, self.m, p, units, first_yield)

    def driven(self, t):
        value, rate, second = self.drive(t * self.time_unit)
        T = self.time_unit
        return np.array([value, rate * T, second * T * T]) / self.drive_unit

    def kinematics(self, t, y):
        """Overlaps and their rates."""
        n = len(self.m)
        wall = self.driven(t) if self.moves_wall else np.zeros(3)
        x = np.concatenate((wall[:1], y[:n], [0.0]))
        v = np.concatenate((wall[1:2], y[n : 2 * n], [0.0]))
        return self.at_rest - np.diff(x), -np.diff(v)

    def accelerations(self, t, forces):
        a = (forces[:-1] - forces[1:] + self.outside) / self.m
        if not self.moves_wall:
            a[0] += self.driven(t)[0] / self.m[0]
        return a

    def closing_accelerations(self, t, forces):
        wall = self.driven(t)[2] if self.moves_wall else 0.0
        return -np.diff(np.concatenate(([wall], self.accelerations(t, forces), [0.0])))

    def responses(self, which):
        """Minus the change of d'' of these contacts by a unit force in each: a mass matrix."""
        inverse = np.concatenate(([0.0], 1.0 / self.m, [0.0]))
        matrix = np.diag(inverse[:-1] + inverse[1:])
        matrix -= np.diag(inverse[1:-1], 1) + np.diag(inverse[1:-1], -1)
        return matrix[np.ix_(which, which)]

    def forces(self, t, d, closing):
        forces = self.law.forces(self.mode, self.largest, d, closing)
        forces = np.where(self.free, 0.0, forces)
        stuck = np.flatnonzero(self.mode == STUCK)
        if len(stuck):
            known = self.closing_accelerations(t, forces)[stuck]
            forces[stuck] = np.linalg.solve(self.responses(stuck), known)
        return forces

    def margins(self, t, y):
        d, closing = self.kinematics(t, y)
        forces = self.forces(t, d, closing)
        margins = self.law.margins(self.mode, self.largest, d, closing, forces)
        return np.where(self.free, 1.0, margins)

    def rates(self, t, y):
        n = len(self.m)
        forces = self.forces(t, *self.kinematics(t, y))
        drive = self.driven(t)
        power = forces[0] * drive[1] if self.moves_wall else drive[0] * y[n]
        passed = [forces[0], forces[-1], power]
        return np.concatenate((y[n : 2 * n], self.accelerations(t, forces), passed))

    def start(self, t, y):
        """Beads that touch are in contact, unless they separate."""
        d, closing = self.kinematics(t, y)
        self.largest = np.maximum(d, 0.0)
        touching = (d > 0.0) | ((d == 0.0) & (closing >= 0.0))
        self.mode = np.where(touching & ~self.free, LOADING, OPEN)

    def switch(self, c, t, y):
        d, closing = self.kinematics(t, y)
        forces = self.forces(t, d, closing)
        law, i = self.law.at(c) if isinstance(self.law, Mixed) else (self.law, c)
        mode = law.following(self.mode[c], self.largest[c], d[c], closing[c], forces[c], i)
        if mode is None:
            self.decide(c, t, d, forces)
            self.hold(t, y)
            return
        if isinstance(law, Plastic) and self.mode[c] == LOADING:
            self.largest[c] = max(self.largest[c], d[c])
        self.mode[c] = mode

    def decide(self, c, t, d, forces):
        """Loading, unloading or stuck, for a contact with d' = 0 and all that are stuck.

        Each force is between its bounds, at the upper one if d'' > 0 and at the lower one if
        d'' < 0: a linear complementarity problem, solved by Murty's pivoting, first index first.
        """
        which = np.flatnonzero((self.mode == STUCK) | (np.arange(len(d)) == c))
        turn = int(np.argmax(which == c))
        least, most = (bound[which] for bound in self.law.bounds(d))
        upper = forces[c] > 0.5 * (least[turn] + most[turn])
        forces, then = forces.copy(), np.full(len(which), STUCK)
        for _ in range(1000):
            forces[which] = np.where(then == LOADING, most, np.where(then == STUCK, 0.0, least))
            free = which[then == STUCK]
            known = self.closing_accelerations(t, forces)[free]
            forces[free] = np.linalg.solve(self.responses(free), known)
            found, speeding = forces[which], self.closing_accelerations(t, forces)[which]
            rounding = NOISE * (1.0 + np.abs(forces).max())
            right = np.choose(then, [
                np.nan, speeding > -rounding, speeding < rounding,
                (found < most + rounding) & (found > least - rounding),
            ])  # fmt: skip
            if right.all():
                break
            i = int(np.argmin(right))
            beyond = LOADING if found[i] > most[i] else UNLOADING
            then[i] = beyond if then[i] == STUCK else STUCK
        # The contact that switches leaves its mode, even if no force acts on it yet.
        if self.mode[c] == STUCK:
            then[turn] = LOADING if upper else UNLOADING
        elif then[turn] == self.mode[c]:
            then[turn] = STUCK
        self.mode[which] = then

    def hold(self, t, y):
        """Set the relative speed of stuck contacts, a rounding error, to zero."""
        _, closing = self.kinematics(t, y)
        stuck, n = np.flatnonzero(self.mode == STUCK), len(self.m)
        impulses = np.zeros(n + 1)
        impulses[stuck] = np.linalg.solve(self.responses(stuck), closing[stuck])
        y[n : 2 * n] += (impulses[:-1] - impulses[1:]) / self.m


def trajectory(chain, times, units=None, rtol=1e-12):
    """Integrate a chain up to the last of some increasing times; returns a `Motion` at them."""
    units = units or Units()
    contacts, n = Contacts(chain, units), len(chain.radii)
    at = np.asarray(times, float) / units.time
    y = np.concatenate((np.zeros(n), chain.velocities / units.velocity, np.zeros(3)))
    saved = np.zeros((len(at), len(y) + n + 1))
    kinks = [kink / units.time for kink in kinks_of(chain.drive)]
    ends = sorted({kink for kink in kinks if 0.0 < kink < at[-1]} | {float(at[-1])})
    t, first = 0.0, True
    for end in ends:
        contacts.drive = drive_between(chain, t * units.time, end * units.time)
        if first:
            contacts.start(t, y)
            first = False
        t, y = _advance(contacts, t, y, end, rtol, at, saved)
    return Motion(
        saved[:, :n] * units.length,
        saved[:, n : 2 * n] * units.velocity,
        saved[:, 2 * n + 3 :] * units.force,
        saved[:, 2 * n : 2 * n + 2] * (units.force * units.time),
        saved[:, 2 * n + 2] * (units.force * units.length),
    )


def wall_peak(chain, end, count=20_001):
    """Largest force on the right wall until ``end``, by a parabola through three saved times."""
    forces = trajectory(chain, np.linspace(0.0, end, count)).forces[:, -1]
    k = int(np.argmax(forces[1:-1])) + 1
    before, here, after = forces[k - 1 : k + 2]
    return here + (after - before) ** 2 / (8.0 * (2.0 * here - before - after))


def _advance(contacts, t, y, end, rtol, at, saved):
    """Integrate piece by piece to ``end``, where the drive has a kink or the run stops."""
    for _ in range(MAX_SWITCHES):
        margins = contacts.margins(t, y)
        worst = int(np.argmin(margins))
        if margins[worst] < -NOISE:
            contacts.switch(worst, t, y)
            continue
        t, y, switching = _piece(contacts, t, y, end, rtol, at, saved)
        if switching is None:
            return t, y
        contacts.switch(switching, t, y)
    raise RuntimeError(f"the reference switches without end at t = {t:g}")


def _piece(contacts, t, y, end, rtol, at, saved):
    """Integrate until a contact must switch; returns where, and which one (None at the end)."""
    stiff = getattr(contacts.law, "stiff", False)
    # With smaller tolerances, an implicit method of order 5 takes too long.
    stepper, rtol = (Radau, max(rtol, 1e-8)) if stiff else (DOP853, rtol)
    solver = stepper(contacts.rates, t, y, end, rtol=rtol, atol=0.1 * rtol, max_step=0.3)
    while solver.status == "running":
        message = solver.step()
        if solver.status == "failed":
            raise RuntimeError(f"the reference stops at t = {solver.t:g}: {message}")
        dense = solver.dense_output()
        when, which = _first_violation(contacts, dense, solver.t_old, solver.t)
        for i in np.flatnonzero((at >= solver.t_old) & (at <= when)):
            state = dense(at[i])
            saved[i] = np.concatenate(
                (state, contacts.forces(at[i], *contacts.kinematics(at[i], state)))
            )
        if which is not None:
            return when, dense(when), which
    return solver.t, solver.y, None


def _first_violation(contacts, dense, begin, end):
    """First zero of a margin within a step, and its contact; (end, None) without one."""
    earliest, which, low = end, None, begin
    for theta in (0.25, 0.5, 0.75, 1.0):
        t = begin + theta * (end - begin) if theta < 1.0 else end
        margins = contacts.margins(t, dense(t))
        for c in np.flatnonzero(margins < -NOISE):

            def margin(s, c=c):
                return contacts.margins(s, dense(s))[c] + NOISE

            when = low if margin(low) <= 0.0 else brentq(margin, low, t, xtol=1e-15, rtol=1e-14)
            if which is None or when < earliest:
                earliest, which = when, int(c)
        if which is not None:
            break
        low = t
    return earliest, which

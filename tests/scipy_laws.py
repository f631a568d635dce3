"""The laws of loss, each with its modes, written from their equations; used by `scipy_chain`.

All numbers are dimensionless.  A contact is open, loading, unloading or stuck; its margin is
positive as long as that is right.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

OPEN, LOADING, UNLOADING, STUCK = range(4)
# A margin must be violated by more than rounding [units of the motion].
NOISE = 1e-13
# A relative speed this small may be one at which a contact turns: its sign says nothing.
AT_REST = 1e-9


class Damped:
    """k d^p and a viscous part; with ``attractive`` the overlap ends a contact, else the force."""

    def __init__(self, k, p, viscous, attractive, stiff=False):
        self.k, self.p, self.viscous, self.attractive = k, p, viscous, attractive
        self.stiff = stiff

    def formula(self, d, closing):
        d = np.maximum(d, 0.0)
        return self.k * d**self.p + self.viscous(d, closing)

    def forces(self, mode, _largest, d, closing):
        return np.where(mode == OPEN, 0.0, self.formula(d, closing))

    def margins(self, mode, _largest, d, closing, _forces):
        acts = d if self.attractive else np.minimum(d, self.formula(d, closing))
        return np.where(mode == OPEN, -acts, acts)

    def following(self, mode, _largest, _d, _closing, _force):
        return LOADING if mode == OPEN else OPEN


class Weaker:
    """k d^p while the beads approach, a part of it while they part, anything between if neither."""

    def __init__(self, k, p, kept):
        self.k, self.p, self.kept = k, p, kept

    def forces(self, mode, _largest, d, _closing):
        part = np.array([0.0, 1.0, self.kept, 0.0])[mode]
        return part * self.k * np.maximum(d, 0.0) ** self.p

    def bounds(self, d):
        most = self.k * np.maximum(d, 0.0) ** self.p
        return self.kept * most, most

    def margins(self, mode, _largest, d, closing, forces):
        least, most = self.bounds(d)
        # Only a wall whose speed jumps takes a stuck contact out of its rest.
        stuck = np.minimum(np.minimum(most - forces, forces - least), AT_REST - np.abs(closing))
        return np.choose(mode, [-d, np.minimum(d, closing), np.minimum(d, -closing), stuck])

    def following(self, mode, _largest, d, closing, _force):
        if mode == OPEN:
            return LOADING
        if d <= NOISE:
            return OPEN
        if abs(closing) > AT_REST:
            return LOADING if closing > 0.0 else UNLOADING
        return None  # depends on the forces of all others


class Plastic:
    """k d^p at first; below the largest overlap so far a steeper curve that ends at a dent."""

    def __init__(self, k, p, ratio):
        self.k, self.p, self.ratio = k, p, ratio

    def forces(self, mode, largest, d, _closing):
        first = self.k * np.maximum(d, 0.0) ** self.p
        dent = (1.0 - self.ratio) * largest
        width = np.where(largest > 0.0, largest - dent, 1.0)
        again = self.k * largest**self.p * (np.maximum(d - dent, 0.0) / width) ** self.p
        return np.choose(mode, [0.0 * first, first, again, first])

    def margins(self, mode, largest, d, closing, _forces):
        dent = (1.0 - self.ratio) * largest
        of = [dent - d, np.minimum(d, closing), np.minimum(largest - d, d - dent), d]
        return np.choose(mode, of)

    def following(self, mode, largest, d, _closing, _force):
        if mode == LOADING:
            return UNLOADING if d > NOISE else OPEN
        if mode == OPEN:
            return UNLOADING if largest > NOISE else LOADING
        return LOADING if d > (1.0 - 0.5 * self.ratio) * largest else OPEN


def damping_ratio(e, attractive):
    """Of the oscillator q' = u, u' = -q - 2 zeta u that returns with speed e if it came with 1.

    In q ~ d^((p+1)/2), and some measure of time, a collision is this oscillator with u = d' for any
    p.  It ends with q or, if it may not pull, already with its force.
    """
    if attractive:
        return brentq(lambda z: math.exp(-math.pi * z / math.sqrt(1.0 - z * z)) - e, 0.0, 0.9999)

    def excess(zeta):
        system = np.array([[0.0, 1.0], [-1.0, -2.0 * zeta]])

        def moved(t):
            return expm(system * t) @ [0.0, 1.0]

        end = brentq(lambda t: system[1] @ moved(t), 1e-9, 3.15)
        return -moved(end)[1] - e

    return brentq(excess, 0.0, 30.0, xtol=1e-15)


def law_of(chain, k, masses, p, units):
    """The chain's law with dimensionless constants."""
    law, kind = chain.loss, type(chain.loss).__name__
    if kind == "UnloadingRatio" and law.ratio > 0.0:
        return Weaker(k, p, 1.0 - law.ratio)
    if kind == "WaltonBraun":
        return Plastic(k, p, law.ratio)
    viscous = {
        "Restitution": _hertz_damping,
        "Viscoelastic": _kuwabara_kono,
        "VelocityPower": _velocity_power,
        "Dashpot": _velocity_power,
    }.get(kind)
    if viscous is None:
        return Damped(k, p, lambda _d, closing: 0.0 * closing, True)
    # With |d'|^alpha, alpha < 1, beads in contact hardly move against each other at last.
    stiff = getattr(law, "alpha", 1.0) < 1.0
    return Damped(k, p, viscous(law, k, masses, p, units), law.attractive, stiff)


def _hertz_damping(law, k, masses, p, _units):
    inverse = 1.0 / np.concatenate(([math.inf], masses, [math.inf]))
    reduced = 1.0 / (inverse[:-1] + inverse[1:])
    zeta = damping_ratio(law.coefficient, law.attractive)
    factor = math.sqrt(2.0 * (p + 1.0)) * zeta * np.sqrt(reduced * k)
    return lambda d, closing: factor * d ** (0.5 * (p - 1.0)) * closing


def _kuwabara_kono(law, k, _masses, p, units):
    factor = p * (law.time / units.time) * k
    return lambda d, closing: factor * d ** (p - 1.0) * closing


def _velocity_power(law, k, _masses, _p, units):
    alpha = getattr(law, "alpha", 1.0)
    factor = np.where(k > 0.0, law.gamma / (units.force / units.velocity**alpha), 0.0)
    if alpha == 1.0:
        return lambda _d, closing: factor * closing
    return lambda _d, closing: factor * np.sign(closing) * np.abs(closing) ** alpha

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

    def following(self, mode, _largest, _d, _closing, _force, _c=0):
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

    def following(self, mode, _largest, d, closing, _force, _c=0):
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

    def dent(self, largest):
        return (1.0 - self.ratio) * largest

    def first(self, d):
        return self.k * np.maximum(d, 0.0) ** self.p

    def again(self, d, largest):
        dent = self.dent(largest)
        width = np.where(largest > 0.0, largest - dent, 1.0)
        return self.k * largest**self.p * (np.maximum(d - dent, 0.0) / width) ** self.p

    def forces(self, mode, largest, d, _closing):
        first = self.first(d)
        return np.choose(mode, [0.0 * first, first, self.again(d, largest), first])

    def margins(self, mode, largest, d, closing, _forces):
        dent = self.dent(largest)
        of = [dent - d, np.minimum(d, closing), np.minimum(largest - d, d - dent), d]
        return np.choose(mode, of)

    def following(self, mode, largest, d, _closing, _force, c=0):
        if mode == LOADING:
            return UNLOADING if d > NOISE else OPEN
        if mode == OPEN:
            return UNLOADING if largest > NOISE else LOADING
        dent = np.broadcast_to(self.dent(largest), np.shape(self.k))[c]
        return LOADING if d > 0.5 * (dent + largest) else OPEN


class Yielding(Plastic):
    """Thornton's elastic-plastic spheres, by the formulas of his paper for spheres of radius 1."""

    def __init__(self, k, first_yield):
        self.k, self.p, self.modulus = k, 1.5, 0.75 * k
        with np.errstate(divide="ignore", invalid="ignore"):
            self.pressure = 2.0 * self.modulus * np.sqrt(first_yield) / math.pi
        self.at = first_yield
        self.force = 4.0 / 3.0 * self.modulus * first_yield**1.5

    def first(self, d):
        elastic = 4.0 / 3.0 * self.modulus * np.maximum(d, 0.0) ** 1.5
        return np.where(d > self.at, self.force + math.pi * self.pressure * (d - self.at), elastic)

    def radius(self, largest):
        """Of the flattened contact; 1 before it yields."""
        peak = self.first(largest)
        with np.errstate(divide="ignore", invalid="ignore"):
            area = (2.0 * peak + self.force) / (2.0 * math.pi * self.pressure)
            flattened = 4.0 * self.modulus / (3.0 * peak) * area**1.5
        return np.where(largest > self.at, flattened, 1.0)

    def dent(self, largest):
        steeper = 4.0 / 3.0 * self.modulus * np.sqrt(self.radius(largest))
        with np.errstate(divide="ignore", invalid="ignore"):
            width = (self.first(largest) / steeper) ** (2.0 / 3.0)
        return np.where(largest > self.at, largest - width, 0.0)

    def again(self, d, largest):
        steeper = 4.0 / 3.0 * self.modulus * np.sqrt(self.radius(largest))
        return steeper * np.maximum(d - self.dent(largest), 0.0) ** 1.5


class Mixed:
    """Contacts of different laws; each of ``parts`` has the indices of its contacts."""

    def __init__(self, parts):
        self.parts = parts
        self.stiff = any(getattr(law, "stiff", False) for _, law in parts)

    def at(self, c):
        """The law of contact c, and which of its contacts this is."""
        return next((law, int(np.argmax(i == c))) for i, law in self.parts if c in i)

    def forces(self, mode, largest, d, closing):
        found = np.zeros(len(d))
        for i, law in self.parts:
            found[i] = law.forces(mode[i], largest[i], d[i], closing[i])
        return found

    def margins(self, mode, largest, d, closing, forces):
        found = np.zeros(len(d))
        for i, law in self.parts:
            found[i] = law.margins(mode[i], largest[i], d[i], closing[i], forces[i])
        return found

    def bounds(self, d):
        least, most = np.zeros((2, len(d)))
        for i, law in self.parts:
            if isinstance(law, Weaker):
                least[i], most[i] = law.bounds(d[i])
        return least, most


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


def laws_of(chain, k, masses, p, units, first_yield):
    """The laws of contacts 0..N with dimensionless constants.

    ``first_yield`` gives the overlap at which contact c yields under a law.
    """
    inverse = 1.0 / np.concatenate(([math.inf], masses, [math.inf]))
    reduced = 1.0 / (inverse[:-1] + inverse[1:])
    named = described_laws(chain)
    parts = []
    for c, law in enumerate(named):
        i = np.array([c])
        if type(law).__name__ == "ElasticPlastic":
            own = Yielding(k[i], np.array([first_yield(c, law)]))
        else:
            own = law_of(law, k[i], reduced[i], p[c], units)
        parts.append((i, own))
    return Mixed(parts)


def described_laws(chain):
    """The law of each contact 0..N, as the chain and its walls describe it."""
    inner = _each(chain, chain.loss)
    laws = [inner[0], *inner, inner[-1]]
    for end, wall, bead in ((0, chain.left_wall, 0), (-1, chain.right_wall, -1)):
        if wall is not None and wall.loss is not None:
            laws[end] = wall.loss
        elif wall is not None and hasattr(chain.loss, "values"):
            laws[end] = _of_pair(chain.loss, chain.materials[bead], wall.material)
    return laws


def described_exponents(chain):
    """The exponent of each contact 0..N."""
    inner = _each(chain, chain.exponent)
    powers = [inner[0], *inner, inner[-1]]
    for end, wall, bead in ((0, chain.left_wall, 0), (-1, chain.right_wall, -1)):
        if wall is not None and wall.exponent is not None:
            powers[end] = wall.exponent
        elif wall is not None and hasattr(chain.exponent, "values"):
            powers[end] = _of_pair(chain.exponent, chain.materials[bead], wall.material)
    return np.array(powers)


def _each(chain, given):
    """A value for each contact of two beads."""
    beads = len(chain.radii)
    if hasattr(given, "values"):
        return [_of_pair(given, *chain.materials[k : k + 2]) for k in range(beads - 1)]
    return list(given) if isinstance(given, tuple | np.ndarray) else [given] * (beads - 1)


def _of_pair(pairs, one, other):
    other = one if other is None else other
    return next(v for pair, v in pairs.values.items() if pair == {one, other})


def law_of(law, k, reduced, p, units):
    """A law with dimensionless constants, for contacts of one exponent."""
    kind = type(law).__name__
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
    return Damped(k, p, viscous(law, k, reduced, p, units), law.attractive, stiff)


def _hertz_damping(law, k, reduced, p, _units):
    zeta = damping_ratio(law.coefficient, law.attractive)
    factor = math.sqrt(2.0 * (p + 1.0)) * zeta * np.sqrt(reduced * k)
    return lambda d, closing: factor * d ** (0.5 * (p - 1.0)) * closing


def _kuwabara_kono(law, k, _reduced, p, units):
    factor = p * (law.time / units.time) * k
    return lambda d, closing: factor * d ** (p - 1.0) * closing


def _velocity_power(law, k, _reduced, _p, units):
    alpha = getattr(law, "alpha", 1.0)
    factor = np.where(k > 0.0, law.gamma / (units.force / units.velocity**alpha), 0.0)
    if alpha == 1.0:
        return lambda _d, closing: factor * closing
    return lambda _d, closing: factor * np.sign(closing) * np.abs(closing) ** alpha

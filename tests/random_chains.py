"""Random chains with all features, reproducible by a seed.

`random_case(seed)` chooses beads, materials or given masses and stiffness, exponent, velocities,
gaps, walls, gravity, precompression, strikers, drive and loss law, so that all kinds of chain that
`hertzchain.simulate` accepts occur.  A failing test names the seeds; ``random_case(seed).chain``
reproduces the chain.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy_chain import Units

import hertzchain as hc

LAWS = ("Restitution", "Viscoelastic", "UnloadingRatio", "VelocityPower", "Dashpot", "WaltonBraun")
FEATURES = {
    "SI", "gaps", "walls", "gravity", "precompression", "strikers", "drive", "loss",
}  # fmt: skip
DAMPING = ("Restitution", "Viscoelastic", "Dashpot", "Elastic")
MIXED = (*LAWS, "ElasticPlastic", "Elastic")
# Duration of a run, in units of a collision of the first beads.
DURATION = 20.0


class Case(NamedTuple):
    """A chain, the duration of its run, and rough units of its motion."""

    seed: int
    chain: hc.Chain
    units: Units
    options: dict

    @property
    def until(self):
        return DURATION * self.units.time

    def __repr__(self):
        chain = self.chain
        options = "".join(f", {name}={value}" for name, value in self.options.items())
        parts = (chain.loss, chain.drive, chain.left_wall, chain.right_wall)
        return f"random_case({self.seed}{options}): {chain}, " + ", ".join(map(repr, parts))


def random_case(seed, **options):
    """A random chain of up to nine beads.

    Options are ``only`` and ``without``, names of ``FEATURES`` that it must or must not have, and
    ``laws``, the laws from which one is chosen.
    """
    return _random_case(seed, options, **options)


def _random_case(seed, options, only=(), without=(), laws=LAWS):
    rng = np.random.default_rng(seed)
    draw = _Draw(rng, only, without)
    chain, units = _beads(draw, int(rng.integers(2, 9)))
    changes = _start(draw, chain, units) | _ends(draw, chain, units)
    if draw.has("gravity", 0.4):
        changes["gravity"] = draw.near(0.08) * draw.sign() * units.length / units.time**2
    chain = chain.replace(**changes)
    chain = _held(draw, chain, units)
    chain = _struck(draw, chain, units)
    drive = random_drive(rng, units, walled=chain.left_wall is not None)
    if draw.has("drive", 0.3):
        chain = chain.replace(drive=drive)
    law = random_law(rng, units, laws)
    if draw.has("loss", 0.8):
        chain = chain.replace(loss=law)
    return Case(seed, chain, units, options)


class _Draw:
    """Random choices of the features of a chain."""

    def __init__(self, rng, only, without):
        assert {*only, *without} <= FEATURES
        self.rng, self.only, self.without = rng, only, without

    def has(self, feature, chance):
        # The number is drawn in any case, so that excluding a feature does not change the others.
        drawn = bool(self.rng.random() < chance)
        return (drawn or feature in self.only) and feature not in self.without

    def near(self, value, factor=3.0):
        return value * factor ** self.rng.uniform(-1.0, 1.0)

    def sign(self):
        return float(self.rng.choice([-1.0, 1.0]))


def _beads(draw, beads):
    """Beads and their contacts; only the first bead moves."""
    rng = draw.rng
    radii = rng.uniform(0.6, 1.7, beads)
    if draw.has("SI", 0.4):
        radii *= draw.near(5e-3)
        materials = [_material(rng, name) for name in "ABC"]
        kinds = [materials[i] for i in rng.integers(0, 3, beads)]
        velocity = draw.near(0.3)
        chain = hc.Chain.from_materials(radii, kinds, velocity=velocity)
        mass, stiffness = float(chain.masses[0]), float(chain.stiffness.mean())
        length = (mass * velocity**2 / stiffness) ** 0.4
        return chain, Units(length, length / velocity, mass)
    exponent = float(rng.choice([1.5, 1.5, 1.5, 1.2, 1.35, 1.75, 2.0, 2.5, 3.0]))
    fields = {}
    if rng.random() < 0.4:
        fields["masses"] = rng.uniform(0.4, 3.0, beads)
    if rng.random() < 0.4:
        fields["stiffness"] = rng.uniform(0.4, 3.0, beads - 1)
    return hc.Chain.from_radii(radii, exponent=exponent).replace(**fields), Units()


def _material(rng, name):
    young = 10.0 ** rng.uniform(9.5, 11.5)
    return hc.Material(name, rng.uniform(1e3, 9e3), young, rng.uniform(0.1, 0.45))


def _start(draw, chain, units):
    """Velocities and gaps."""
    rng, changes = draw.rng, {}
    if rng.random() < 0.3:
        changes["velocities"] = rng.uniform(-0.6, 1.0, chain.beads) * units.velocity
    if draw.has("gaps", 0.35):
        gaps = rng.uniform(0.0, 0.4, chain.beads - 1) * (rng.random(chain.beads - 1) < 0.7)
        changes["gaps"] = gaps * units.length
    return changes


def _ends(draw, chain, units):
    """Walls."""
    rng, changes = draw.rng, {}
    for side, chance in (("left_wall", 0.45), ("right_wall", 0.65)):
        gap = rng.uniform(0.0, 0.5) * units.length if rng.random() < 0.3 else 0.0
        stiffness = rng.uniform(0.5, 4.0) * units.stiffness(chain.exponent)
        kinds = [hc.Wall(stiffness=stiffness, gap=gap)]
        if chain.exponent == 1.5 and "stiffness" not in chain.given:
            kinds += [hc.Wall(gap=gap), hc.Wall.rigid(gap=gap)]
            if chain.materials is not None:
                kinds.append(hc.Wall.of(_material(rng, f"of the {side}"), gap=gap))
        wall = kinds[int(rng.integers(len(kinds)))]
        if draw.has("walls", chance):
            changes[side] = wall
    return changes


def _held(draw, chain, units):
    """Precompression; features that it excludes are removed."""
    force = draw.near(0.2) * units.force
    if not draw.has("precompression", 0.3):
        return chain
    both = chain.left_wall is not None and chain.right_wall is not None
    touching = {
        side: wall and hc.Wall(wall.stiffness, wall.material)
        for side, wall in (("left_wall", chain.left_wall), ("right_wall", chain.right_wall))
    }
    return chain.replace(
        precompression=force, held_by="walls" if both else "force", gaps=None, **touching
    )


def _struck(draw, chain, units):
    """Strikers in front of a chain."""
    rng = draw.rng
    given = {"velocity": draw.near(1.0, 2.0) * units.velocity, "count": int(rng.integers(1, 4))}
    if rng.random() < 0.5:
        given["mass"] = draw.near(2.0) * units.mass
        if rng.random() < 0.5:
            given["radius"] = float(chain.radii[0] * rng.uniform(0.5, 2.0))
    if chain.exponent != 1.5 or "stiffness" in chain.given:
        given["stiffness"] = draw.near(1.0) * units.stiffness(chain.exponent)
    if rng.random() < 0.4:
        given["gap"] = rng.uniform(0.0, 0.5) * units.length
    if not draw.has("strikers", 0.25) or chain.beads + given["count"] > 9:
        return chain
    if chain.precompression > 0.0 and chain.left_wall is not None:
        chain = chain.replace(left_wall=None, held_by="force")
    return at_rest(chain).struck_by(**given)


def at_rest(chain):
    """The chain without an impact on bead 1; other beads that move keep their velocities."""
    return chain if "velocities" in chain.features else chain.replace(velocities=None)


def mixed_case(seed, **options):
    """A random chain whose contacts and walls have different laws and exponents."""
    case = random_case(seed, without=("loss", "strikers"), **options)
    chain, units, rng = case.chain, case.units, np.random.default_rng([seed, 1])
    scaled = chain.units == "scaled"
    # Laws |d'|^alpha with alpha < 1 need implicit steps, which support only damping.
    names = MIXED if rng.random() < 0.8 else (*DAMPING, "VelocityPower")

    def draw():
        p = float(rng.choice([1.5, 1.5, 1.2, 1.75, 2.0, 3.0])) if scaled else 1.5
        law = random_law(rng, units, names)
        if isinstance(law, hc.ElasticPlastic):
            p = 1.5
        if names is MIXED and getattr(law, "alpha", 1.0) < 1.0:
            law = hc.Elastic()
        return law, p

    drawn = [draw() for _ in range(chain.beads - 1)]
    changes = {"loss": [law for law, _ in drawn], "exponent": [p for _, p in drawn]}
    for side, end in (("left_wall", 0), ("right_wall", -1)):
        wall = getattr(chain, side)
        if wall is not None:
            law, p = draw()
            changes[side] = hc.Wall(chain.wall_stiffness[end], gap=wall.gap, exponent=p, loss=law)
    return case._replace(chain=chain.replace(**changes))


def random_law(rng, units, laws=LAWS):
    """One of the laws of loss."""
    name, pulls = str(rng.choice(laws)), bool(rng.random() < 0.5)
    strength = 10.0 ** rng.uniform(-2.0, -0.3)
    if name == "Restitution":
        return hc.Restitution(float(rng.uniform(0.2, 0.99)), pulls)
    if name == "Viscoelastic":
        return hc.Viscoelastic(strength * units.time, pulls)
    if name == "UnloadingRatio":
        return hc.UnloadingRatio(float(rng.uniform(0.02, 0.9)))
    if name == "WaltonBraun":
        return hc.WaltonBraun(float(rng.uniform(0.2, 0.99)))
    if name == "Elastic":
        return hc.Elastic()
    if name == "ElasticPlastic":
        return hc.ElasticPlastic(yield_overlap=float(rng.uniform(0.02, 0.8)) * units.length)
    if name == "Dashpot":
        return hc.Dashpot(strength * units.force / units.velocity, pulls)
    alpha = float(rng.choice([0.75, 0.9, 1.0, 1.25, 1.5, 1.81, 2.0, 3.0]))
    return hc.VelocityPower(strength * units.force / units.velocity**alpha, alpha, pulls)


def random_drive(rng, units, *, walled):
    """A force on bead 1 or, with a left wall, a displacement of the wall."""
    of = "displacement" if walled and rng.random() < 0.5 else "force"
    size = rng.uniform(-1.0, 1.0) * (units.length if of == "displacement" else 0.6 * units.force)
    kind = rng.integers(4)
    if kind == 0:
        return hc.StepDrive(size, rng.uniform(0.3, 4.0) * units.time, of)
    if kind == 1 and of == "force":
        return hc.StepDrive(0.5 * size)
    if kind == 2:
        times = np.cumsum(rng.uniform(0.3, 3.0, 5)) - rng.uniform(0.0, 1.0)
        return hc.TableDrive(times * units.time, size * rng.uniform(-1.0, 1.0, 5), of)
    cycles = float(rng.choice([0.5, 1.0, 2.0, 3.5]))
    window = str(rng.choice(["hann", "none"]))
    return hc.SineBurst(size, rng.uniform(0.08, 0.5) / units.time, cycles, of, window)


def may_wedge(chain):
    """Whether all contacts between two walls may be stuck, with an undetermined common force."""
    walls = (chain.left_wall, chain.right_wall)
    laws = {type(law) for law in chain.contact_losses}
    return laws == {hc.UnloadingRatio} and None not in walls


def force_difference(run, forces, units):
    """Largest difference between contact forces, if they are determined."""
    apart = run.forces - forces
    if may_wedge(run.chain):
        # Only differences along the chain are determined.
        apart = np.diff(apart, axis=1)
    return np.abs(apart).max() / units.force


class Tally:
    """Results of a check on many chains."""

    def __init__(self, name):
        self.name, self.tried, self.worst, self.failures = name, 0, 0.0, []

    def try_all(self, seeds, deviation, most, **options):
        """Call ``deviation(case)`` on each random chain; fails with all seeds above ``most``."""
        for seed in seeds:
            case = random_case(seed, **options)
            self.tried += 1
            try:
                found = float(deviation(case))
            except (AssertionError, RuntimeError, ValueError, Warning) as error:
                self.failures.append(f"{case!r}: {type(error).__name__}: {error}")
                continue
            self.worst = max(self.worst, found)
            if not found <= most:
                self.failures.append(f"{case!r}: deviates by {found:.3g}, more than {most:g}")
        assert not self.failures, f"{self}:\n" + "\n".join(self.failures)

    def __str__(self):
        return (
            f"{self.name}: {self.tried} chains tried, {len(self.failures)} failed, "
            f"largest deviation {self.worst:.1e}"
        )

"""Quantities with exact or published values, each with its source, and how we find them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, partial
from typing import Final

import numpy as np

from hertzchain.chain.chain import Chain
from hertzchain.chain.losses import Loss, Restitution, UnloadingRatio, Viscoelastic, WaltonBraun
from hertzchain.chain.materials import Material
from hertzchain.chain.walls import Wall
from hertzchain.contacts import Array
from hertzchain.simulation.run import Run
from hertzchain.simulation.simulate import simulate
from hertzchain.theory.dispersion import band_edges, dispersion_uniform, linear_stiffness
from hertzchain.theory.effective_chain import effective_chain
from hertzchain.theory.long_wave import precompressed_speed
from hertzchain.theory.solitary_wave import solitary_wave

INTEGRATIONS: Final = "two integrations"
HARD_NUMBERS: Final = "closed form"
JAYAPRAKASH: Final = "Jayaprakash et al., PRE 83, 036606 (2011)"


@dataclass(frozen=True)
class Case:
    """One quantity with a known value.

    Attributes
    ----------
    group, name : str
        What it is.
    expected : float
        The known value.
    tolerance : float
        How far from it a result may be: half of the last known digit, or the error that
        the source states for itself.
    source : str
        Where the value is from.
    compute : callable
        Our value.
    """

    group: str
    name: str
    expected: float
    tolerance: float
    source: str
    compute: Callable[[], float]


def cases() -> list[Case]:
    """All cases, group by group.

    Returns
    -------
    list of Case

    Examples
    --------
    >>> len(cases()) > 20
    True
    """
    return [
        *_uniform(), *_strikers(), *_ends(), *_dimers(), *_compressed(), *_collisions(),
        *_real_beads(),
    ]  # fmt: skip


@cache
def shared_runs(name: str, *options: float) -> Run:
    """Runs that several cases look at."""
    if name == "uniform":
        return simulate(Chain.uniform(200, exponent=options[0]), times=0)
    if name == "walls":
        wall = Wall(stiffness=options[0])
        return simulate(Chain.uniform(60).replace(right_wall=wall), times=0)
    chain = {
        "mono": lambda: Chain.uniform(20),
        "forward-exponential": lambda: Chain.tapered("forward-exponential", 0.05, beads=20),
        "forward-linear": lambda: Chain.tapered("forward-linear", 0.04, beads=20),
        "backward-exponential": lambda: Chain.tapered("backward-exponential", 0.05, beads=20),
    }[name]()
    return simulate(chain.replace(right_wall=Wall()), until=1000.0, times=0)


def _uniform() -> Iterator[Case]:
    """A uniform chain, struck by one of its own beads."""
    velocities = {1.25: 0.57733689, 1.5: 0.68163155, 1.75: 0.74714607, 2.0: 0.79433275,
                  2.5: 0.85911287, 3.0: 0.90128004, 4.0: 0.95024781}  # fmt: skip
    speeds = {1.25: 0.9466818312, 1.5: 0.9074700784, 2.0: 0.8552519319, 3.0: 0.8047601163}
    for p, velocity in velocities.items():
        yield Case(
            "uniform chain", f"velocity of the leading pulse, p = {p:g}", velocity, 6e-9,
            INTEGRATIONS, partial(_uniform_velocity, p),
        )  # fmt: skip
    for p, constant in speeds.items():
        yield Case(
            "uniform chain", f"speed V (m/k)^(1/(p+1)) v^(-(p-1)/(p+1)), p = {p:g}", constant,
            5e-10, "fixed point of the travelling wave", partial(_speed_constant, p),
        )  # fmt: skip
    yield Case(
        "uniform chain", "velocity of the last bead, which flies off", 0.98567886, 6e-9,
        INTEGRATIONS, lambda: shared_runs("uniform", 1.5).pulse().velocity[-1],
    )  # fmt: skip
    yield Case(
        "uniform chain", "velocity of the striker afterwards", -0.07108502, 6e-9, INTEGRATIONS,
        lambda: shared_runs("uniform", 1.5).state.velocities[0],
    )  # fmt: skip
    yield Case(
        "uniform chain", "momentum of the leading pulse", 1.138305088728, 5e-9, INTEGRATIONS,
        lambda: _leading("momentum"),
    )  # fmt: skip


def _uniform_velocity(p: float) -> float:
    return float(shared_runs("uniform", p).pulse().velocity[150])


def _speed_constant(p: float) -> float:
    pulse = shared_runs("uniform", p).pulse()
    assert pulse.peak_time is not None
    speed = 20.0 / (pulse.peak_time[160] - pulse.peak_time[140])
    return float(speed * pulse.velocity[150] ** (-(p - 1.0) / (p + 1.0)))


def _leading(of: str) -> float:
    run = simulate(Chain.uniform(100), until=80.0, times=[80.0])
    return float(getattr(run.budget(), of)["leading pulse"][0])


def _strikers() -> Iterator[Case]:
    """A uniform chain, struck by a lighter or heavier bead."""
    velocities = {0.1: 0.12348280, 0.25: 0.27030873, 0.5: 0.44968037, 2.0: 0.94809654,
                  4.0: 1.21314076, 8.0: 1.44133545, 16.0: 1.62033946}  # fmt: skip
    for mass, velocity in velocities.items():
        yield Case(
            "strikers", f"velocity of the pulse at bead 61, striker of mass {mass:g}", velocity,
            6e-9, INTEGRATIONS, partial(_struck_by_mass, mass),
        )  # fmt: skip


def _struck_by_mass(mass: float) -> float:
    masses = np.ones(100)
    masses[0] = mass
    chain = Chain.uniform(100).replace(masses=masses)
    return float(simulate(chain, times=0).pulse().velocity[60])


def _ends() -> Iterator[Case]:
    """What a wall at the end of a chain feels."""
    kinds = {
        "as stiff as a contact": (1.0, 1.75040),
        "flat, of the beads' material": (math.sqrt(2.0), 1.94390),
        "flat and rigid": (2.0 * math.sqrt(2.0), 2.23838),
    }
    for kind, (stiffness, ratio) in kinds.items():
        yield Case(
            "walls", f"wall force over the pulse's, wall {kind}", ratio, 6e-6, INTEGRATIONS,
            partial(_wall_ratio, stiffness),
        )  # fmt: skip
    # As printed, so that the last digit known can be seen. In forward tapers light beads knock
    # against each other and the wall until the fourth digit depends on rounding: SciPy's DOP853
    # gives 3.14941 and 3.47847 at rtol 1e-11, 3.14936 and 3.47687 at 1e-13.
    table = {
        "mono": ("1.24323", "2.34539", "2.36546"),
        "forward-exponential": ("0.88930", "1.77524", "3.15"),
        "forward-linear": ("0.56417", "1.26397", "3.48"),
        "backward-exponential": ("1.41652", "8.90193", "8.90193"),
    }
    for name, values in table.items():
        what = "uniform" if name == "mono" else name
        for quantity, text in zip(
            ("peak", "first_contact_impulse", "impulse"), values, strict=True
        ):
            digit = 10.0 ** -len(text.partition(".")[2])
            yield Case(
                "walls", f"{quantity.replace('_', ' ')} on the wall, {what}, 20 beads",
                float(text), 0.6 * digit, INTEGRATIONS,
                partial(_on_wall, name, quantity),
            )  # fmt: skip


def _wall_ratio(stiffness: float) -> float:
    """Largest force on a wall over that in the pulse that hits it."""
    return shared_runs("walls", stiffness).wall_force().peak / 0.6395542321


def _on_wall(name: str, quantity: str) -> float:
    return float(getattr(shared_runs(name).wall_force(), quantity))


def _dimers() -> Iterator[Case]:
    """Heavy and light beads in turn: where solitary waves pass, and where they do not."""
    for ratio in (1.0, 0.342845, 0.154752, 0.090127, 0.061503):
        yield Case(
            "dimers", f"velocity kept from bead 61 to 181, mass ratio {ratio:g}", 1.0, 1e-8,
            f"anti-resonance: {JAYAPRAKASH}", partial(_kept, ratio, 61, 181),
        )  # fmt: skip
    for ratio, kept, tolerance in ((0.574, 0.574, 6e-4), (0.2397, 0.946, 6e-4),
                                   (0.1224, 0.9935, 6e-5)):  # fmt: skip
        yield Case(
            "dimers", f"velocity kept from bead 21 to 61, mass ratio {ratio:g}", kept, tolerance,
            INTEGRATIONS, partial(_kept, ratio, 21, 61),
        )  # fmt: skip
    yield Case(
        "dimers", "time per cell over the effective chain's, decorated 0.3", 1.0, 2.5e-4,
        "springs in series", _decorated,
    )  # fmt: skip


def _kept(ratio: float, first: int, last: int) -> float:
    run = simulate(Chain.dimer(ratio, beads=last + 40), times=0)
    velocity = run.pulse().velocity
    return float(velocity[last - 1] / velocity[first - 1])


def _decorated() -> float:
    decorated = Chain.uniform(60).decorated(0.3)
    pulse = simulate(decorated, times=0).pulse()
    effective = effective_chain(decorated)
    large = np.arange(40, 80, 2)
    assert pulse.peak_time is not None
    measured = float(np.diff(pulse.peak_time[large]).mean())
    middle = 20
    wave = solitary_wave()
    speed = wave.speed(
        velocity=float(pulse.velocity[large].mean()), mass=float(effective.masses[middle]),
        stiffness=float(effective.stiffness[middle]),
    )  # fmt: skip
    return measured * float(speed)


def _compressed() -> Iterator[Case]:
    """Chains under a static force: linear waves, and pulses on them."""
    yield Case(
        "compressed chains", "frequency of a mode, q = 3 pi/21",
        float(dispersion_uniform(3 * math.pi / 21, spring=1.5)), 1e-9, "2 sqrt(K/m) sin(q/2)",
        lambda: _mode_frequency(np.ones(20), np.sin(3 * math.pi * np.arange(1, 21) / 21), 1.0),
    )  # fmt: skip
    edges = band_edges(mass=1.0, other_mass=0.4, spring=1.5)[1:]
    in_turn = np.array([1.0, 0.0, -1.0, 0.0] * 5 + [1.0])
    heavy, light = np.resize([1.0, 0.4], 21), np.resize([0.4, 1.0], 21)
    both = np.resize([1.0, -2.5], 21)
    ends = np.where(np.isin(np.arange(21), (0, 20)), 0.5, 1.0) * heavy
    names = ("heavy beads alone", "light beads alone", "heavy against light")
    shapes = ((heavy, in_turn, 1.0), (light, in_turn, 1.0), (ends, both, 0.0))
    for name, edge, shape in zip(names, edges, shapes, strict=True):
        yield Case(
            "compressed chains", f"band edge of a diatomic chain, {name}", float(edge), 1e-9,
            HARD_NUMBERS, partial(_mode_frequency, *shape),
        )  # fmt: skip
    for strike in (0.05, 1.0, 5.0):
        yield Case(
            "compressed chains", f"speed of a pulse over Nesterenko's, struck with {strike:g}", 1.0,
            8e-3, "long-wave theory, Nesterenko 2001",
            partial(_on_compression, strike),
        )  # fmt: skip
    yield Case(
        "compressed chains", "under gravity, speed of sound ~ depth to the power", 1.0 / 6.0, 4e-3,
        "Hong, Ji, Kim, PRL 82, 3058 (1999)", lambda: _under_gravity()[0],
    )  # fmt: skip
    yield Case(
        "compressed chains", "under gravity, velocity of a weak pulse ~ depth to the power", -0.25,
        2e-2, "Hong, Ji, Kim, PRL 82, 3058 (1999)", lambda: _under_gravity()[1],
    )  # fmt: skip


def _mode_frequency(masses: Array, shape: Array, walls: float) -> float:
    """Angular frequency of a linear mode, from the phase after several periods."""
    beads, weak = len(masses), 1e-5
    ends = {"held_by": "force"} if walls == 0.0 else {
        "left_wall": Wall(stiffness=walls), "right_wall": Wall(stiffness=walls)}  # fmt: skip
    chain = Chain.uniform(beads).replace(
        masses=masses, precompression=1.0, velocities=weak * shape, **ends
    )
    # A multiple of the first guess's period, so that the phase is small.
    stiffness = float(linear_stiffness(1.0, 1.0))
    springs = stiffness * (np.diff(shape, append=0.0) - np.diff(shape, prepend=0.0))
    if walls == 0.0:
        springs[[0, -1]] += stiffness * shape[[0, -1]]
    guess = math.sqrt(float(-(shape @ springs) / (shape @ (masses * shape))))
    until = 10.0 * 2.0 * math.pi / guess
    run = simulate(chain, until=until, times=[0.0, until])
    moved = (run.positions[1] - run.positions[0]) @ (masses * shape)
    moving = run.velocities[1] @ (masses * shape)
    return float((20.0 * math.pi + math.atan2(guess * moved, moving)) / until)


def _on_compression(strike: float) -> float:
    velocities = np.zeros(160)
    velocities[0] = strike
    chain = Chain.uniform(160).replace(precompression=0.1, held_by="force", velocities=velocities)
    pulse = simulate(chain, times=0).pulse()
    assert pulse.peak_time is not None
    assert pulse.peak_force is not None
    speed = 20.0 / (pulse.peak_time[120] - pulse.peak_time[100])
    ratio = float(pulse.peak_force[110]) / 0.1
    sound = math.sqrt(float(linear_stiffness(1.0, 0.1)))
    return float(speed / (sound * float(precompressed_speed(ratio))))


@cache
def _under_gravity() -> tuple[float, float]:
    velocities = np.zeros(400)
    velocities[0] = 1e-5
    chain = Chain.uniform(400).replace(gravity=1.0, right_wall=Wall(), velocities=velocities)
    run = simulate(chain, until=400.0, times=0)
    deep = slice(100, 300)
    depth = np.log(np.arange(1, 401)[deep])
    times, peaks = run._peaks[:, deep]
    speed = np.log(1.0 / np.gradient(times))
    return float(np.polyfit(depth, speed, 1)[0]), float(np.polyfit(depth, np.log(peaks), 1)[0])


def _collisions() -> Iterator[Case]:
    """Two beads that collide."""
    yield Case(
        "restitution", "duration of a collision, in overlap over speed", 2.943275184, 1e-9,
        "Hertz", _duration,
    )  # fmt: skip
    for e in (0.3, 0.5, 0.7, 0.9):
        for speed in (0.1, 10.0):
            yield Case(
                "restitution", f"Hertz damping, e = {e:g}, at speed {speed:g}", e, 1e-8,
                "Tsuji et al., Powder Technol. 71, 239 (1992)",
                partial(_restitution, Restitution(e), speed),
            )  # fmt: skip
    yield Case(
        "restitution", "viscoelastic, B = 0.015, against its series", _viscoelastic_series(0.015),
        4 * 0.015**3, "Brilliantov et al., PRE 53, 5382 (1996)",
        lambda: _restitution(Viscoelastic(0.01 * 0.5**0.4, attractive=True), 1.0),
    )  # fmt: skip
    yield Case(
        "restitution", "unloading ratio w = 0.19", 0.9, 1e-8, "e = sqrt(1 - w)",
        lambda: _restitution(UnloadingRatio(0.19), 1.0),
    )  # fmt: skip
    yield Case(
        "restitution", "Walton-Braun K1/K2 = 0.49", 0.7, 1e-8, "e = sqrt(K1/K2)",
        lambda: _restitution(WaltonBraun(0.49), 1.0),
    )  # fmt: skip


def _duration() -> float:
    pulse = simulate(Chain.uniform(2), times=0).pulse()
    assert pulse.arrival is not None
    assert pulse.peak_overlap is not None
    return float(2.0 * pulse.arrival[1] / pulse.peak_overlap[0])


def _restitution(law: Loss, speed: float) -> float:
    chain = Chain.uniform(2).replace(loss=law, velocities=[speed, 0.0])
    left, right = simulate(chain, until=50.0 * speed**-0.2, times=0).state.velocities
    return float((right - left) / speed)


def _viscoelastic_series(b: float) -> float:
    """1 - C1 B + (3/5) (C1 B)^2, with C1 from the same source."""
    gamma = math.gamma
    c1 = math.sqrt(math.pi) * gamma(0.6) / (2.0**0.2 * 5.0**0.4 * gamma(2.1))
    return 1.0 - c1 * b + 0.6 * (c1 * b) ** 2


def _real_beads() -> Iterator[Case]:
    """Steel beads of 10 mm diameter (E = 203 GPa, nu = 0.3, 7780 kg/m^3), struck with 1 m/s."""
    names = {
        "speed of the pulse [m/s]": (674.659, 6e-4, lambda t, _: 0.2 / (t[70] - t[50])),
        "largest force [N]": (209.121, 6e-4, lambda _, pulse: pulse.peak_force[60]),
        "largest overlap [um]": (9.2479, 6e-5, lambda _, pulse: 1e6 * pulse.peak_overlap[60]),
    }
    for name, (value, tolerance, read) in names.items():
        yield Case(
            "steel beads", name, value, tolerance, "SI units of the constants above",
            partial(_steel, read),
        )  # fmt: skip


def _steel(read: Callable[..., float]) -> float:
    # No yield strength: the numbers are of elastic beads, at a speed at which real ones dent.
    steel = Material("steel", density=7780.0, young=203e9, poisson=0.3)
    chain = Chain.from_materials(5e-3, steel, beads=100)
    pulse = simulate(chain, times=0).pulse()
    return float(read(pulse.peak_time, pulse))

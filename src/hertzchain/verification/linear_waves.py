"""Chains under a static force: linear waves, bands, decay, and pulses."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

import numpy as np

from ..chain.chain import Chain
from ..chain.laws.viscoelastic import Viscoelastic
from ..chain.materials import Material
from ..chain.walls import Wall
from ..collision import Array
from ..simulation.simulate import simulate
from ..theory.dispersion import band_edges, dispersion_uniform, linear_stiffness
from ..theory.long_wave import precompressed_speed
from ..theory.spectrum import spectrum
from .case import Case, shared

HONG = "Hong, Ji, Kim, PRL 82, 3058 (1999)"
BOECHLER = "Boechler et al., PRL 104, 244302 (2010)"


def cases() -> list[Case]:
    """Cases of this topic."""
    return [*_modes(), *_pulses(), *_spectra()]


def _modes() -> Iterator[Case]:
    """Simulated small oscillations."""
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
    names = ("only heavy beads move", "only light beads move", "both move in antiphase")
    shapes = ((heavy, in_turn, 1.0), (light, in_turn, 1.0), (ends, both, 0.0))
    for name, edge, shape in zip(names, edges, shapes, strict=True):
        yield Case(
            "compressed chains", f"diatomic band edge, {name}", float(edge), 1e-9, "closed form",
            partial(_mode_frequency, *shape),
        )  # fmt: skip
    omega = float(dispersion_uniform(3 * math.pi / 21, spring=1.5))
    yield Case(
        "compressed chains", "decay of a mode, Viscoelastic(0.05)", 0.5 * 0.05 * omega**2, 1e-9,
        "A omega^2/2", partial(_mode_decay, 0.05, omega),
    )  # fmt: skip


def _pulses() -> Iterator[Case]:
    """Pulses in precompressed chains and under gravity."""
    for strike in (0.05, 1.0, 5.0):
        yield Case(
            "compressed chains", f"speed over long-wave theory, impact at {strike:g}", 1.0, 8e-3,
            "Coste et al., PRE 56, 6104 (1997); known to be up to 0.8% too low",
            partial(_on_compression, strike),
        )  # fmt: skip
    yield Case(
        "compressed chains", "speed of sound ~ depth^x under gravity", 1.0 / 6.0, 4e-3,
        f"{HONG}; for large depth", lambda: _under_gravity()[0],
    )  # fmt: skip
    yield Case(
        "compressed chains", "velocity of a weak pulse ~ depth^x", -0.25, 2e-2,
        f"{HONG}; for large depth", lambda: _under_gravity()[1],
    )  # fmt: skip


def _spectra() -> Iterator[Case]:
    """Spectra from `hertzchain.spectrum`."""
    aluminium, steel = _aluminium_and_steel()
    yield Case(
        "spectra", "Hertz coefficient, Al on steel [N/um^1.5]", 5.46, 6e-3,
        f"{BOECHLER}; 5.466 truncated",
        lambda: Chain.from_materials([9.53e-3] * 2, [aluminium, steel]).stiffness[0] * 1e-9,
        "recalled",
    )  # fmt: skip
    names = ("upper acoustic", "lower optical", "upper optical")
    for row, name, edge in zip(((0, 1), (1, 0), (1, 1)), names, (5.125, 8.82, 10.20), strict=True):
        yield Case(
            "spectra", f"{name} band edge at 20.4 N [kHz]", edge, 1e-3 * edge,
            f"{BOECHLER}; masses from densities, to 0.1%", partial(_crystal_edge, *row),
            "recalled",
        )  # fmt: skip
    for ratio in (0.2, 0.4):
        yield Case(
            "spectra", f"light bead of mass {ratio:g}: omega^2/(4K/m)",
            1.0 / (ratio * (2.0 - ratio)), 1e-12, "Montroll, Potts, Phys. Rev. 100, 525 (1955)",
            partial(_defect, ratio),
        )  # fmt: skip


def _mode_frequency(masses: Array, shape: Array, walls: float) -> float:
    """Angular frequency of a linear mode, from the phase after several periods."""
    beads, weak = len(masses), 1e-5
    ends = {"held_by": "force"} if walls == 0.0 else {
        "left_wall": Wall(stiffness=walls), "right_wall": Wall(stiffness=walls)}  # fmt: skip
    chain = Chain.uniform(beads).replace(
        masses=masses, precompression=1.0, velocities=weak * shape, **ends
    )
    # After ten periods of the first guess, the remaining phase is small.
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


def _mode_decay(time: float, omega: float) -> float:
    """Decay rate from the velocity after ten periods of the damped oscillator."""
    shape = np.sin(3 * math.pi * np.arange(1, 21) / 21)
    wall = Wall(stiffness=1.0)
    chain = Chain.uniform(20).replace(
        precompression=1.0, left_wall=wall, right_wall=wall, loss=Viscoelastic(time),
        velocities=1e-6 * shape,
    )  # fmt: skip
    until = 20.0 * math.pi / math.sqrt(omega**2 - (0.5 * time * omega**2) ** 2)
    run = simulate(chain, until=until, times=[0.0, until])
    before, after = run.velocities @ shape
    return -math.log(after / before) / until


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


@shared
def _under_gravity() -> tuple[float, float]:
    velocities = np.zeros(400)
    velocities[0] = 1e-5
    chain = Chain.uniform(400).replace(gravity=1.0, right_wall=Wall(), velocities=velocities)
    pulse = simulate(chain, until=400.0, times=0).pulse()
    assert pulse.peak_time is not None
    deep = slice(100, 300)
    depth = np.log(np.arange(1, 401)[deep])
    speed = np.log(1.0 / np.gradient(pulse.peak_time[deep]))
    velocity = np.log(pulse.velocity[deep])
    return float(np.polyfit(depth, speed, 1)[0]), float(np.polyfit(depth, velocity, 1)[0])


def _aluminium_and_steel() -> tuple[Material, Material]:
    return (
        Material("6061-T6", density=2700.0, young=73.5e9, poisson=0.33),
        Material("316", density=8000.0, young=193e9, poisson=0.3),
    )


@shared
def _crystal() -> Array:
    """Band edges [kHz] of 80 beads with the measured stiffness."""
    pair = _aluminium_and_steel()
    beads = Chain.periodic([9.53e-3] * 2, cells=40, materials=pair, velocity=0.0)
    chain = beads.replace(stiffness=7.04e9, precompression=20.4, held_by="force")
    return spectrum(chain).band_edges() / 1e3


def _crystal_edge(band: int, edge: int) -> float:
    return float(_crystal()[band, edge])


def _defect(ratio: float) -> float:
    """Squared frequency of the highest mode of 61 beads with a light bead in the middle."""
    masses = np.ones(61)
    masses[30] = ratio
    wall = Wall(stiffness=1.0)
    chain = Chain.uniform(61).replace(
        masses=masses, precompression=1.0, left_wall=wall, right_wall=wall
    )
    return float((2.0 * math.pi * spectrum(chain).frequencies[-1]) ** 2 / 6.0)

"""Walls: the force of a pulse, and collisions of single beads and columns."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

import numpy as np

from ..chain.chain import Chain
from ..chain.materials import RIGID, Material
from ..chain.walls import Wall
from ..simulation.run import Run
from ..simulation.simulate import simulate
from .case import PULSE_FORCE, TWO_INTEGRATIONS, Case, shared

JOHNSON = "Johnson, Contact Mechanics (1985), Eq. 11.22"
STEEL = Material("steel", density=7810.0, young=210e9, poisson=0.3)
BRASS = Material("brass", density=8500.0, young=100e9, poisson=0.35)


def cases() -> list[Case]:
    """Cases of this topic."""
    return [*_walls(), *_single_beads()]


def _walls() -> Iterator[Case]:
    """Pulses that are reflected by a wall."""
    kinds = {
        "like a contact": (1.0, 1.75040),
        "own material": (math.sqrt(2.0), 1.94390),
        "rigid": (2.0 * math.sqrt(2.0), 2.23838),
    }
    for kind, (stiffness, ratio) in kinds.items():
        yield Case(
            "walls", f"force over the pulse's, {kind}", ratio, 6e-6, TWO_INTEGRATIONS,
            partial(_wall_ratio, stiffness), "computed",
        )  # fmt: skip
    # These are strings, which show the last known digit. In forward tapers light beads bounce
    # between each other and the wall, until the fourth digit depends on rounding: SciPy's DOP853
    # gives 3.14941 and 3.47847 at rtol 1e-11, but 3.14936 and 3.47687 at 1e-13.
    table = {
        "uniform": ("1.24323", "2.34539", "2.36546"),
        "forward-exponential": ("0.88930", "1.77524", "3.15"),
        "forward-linear": ("0.56417", "1.26397", "3.48"),
        "backward-exponential": ("1.41652", "8.90193", "8.90193"),
    }
    for name, values in table.items():
        names = ("peak", "first_contact_impulse", "impulse")
        for quantity, text in zip(names, values, strict=True):
            digit = 10.0 ** -len(text.partition(".")[2])
            yield Case(
                "walls, 20 beads", f"{quantity.replace('_', ' ')}, {name}", float(text),
                0.6 * digit, TWO_INTEGRATIONS, partial(_on_wall, name, quantity), "computed",
            )  # fmt: skip


def _single_beads() -> Iterator[Case]:
    """Beads and columns that hit a wall."""
    # F = k^(2/5) (5 m v^2/4)^(3/5), with k = 4/3 E* sqrt(R) and 1/E* the sum for both bodies.
    mass, compliance = 4.0 / 3.0 * math.pi * 7810.0 * 6e-3**3, 0.91 / 210e9
    for wall, other in ((RIGID, 0.0), (STEEL, compliance), (BRASS, (1.0 - 0.35**2) / 100e9)):
        k = 4.0 / 3.0 * math.sqrt(6e-3) / (compliance + other)
        force = k**0.4 * (1.25 * mass * 0.2**2) ** 0.6
        yield Case(
            "beads on a wall", f"steel ball on {wall.name}, peak force [N]", force, 1e-9 * force,
            JOHNSON, partial(_peak, wall),
        )  # fmt: skip
    yield Case(
        "beads on a wall", "duration over (m^2/(R E*^2 v))^(1/5)", 2.87, 5e-3,
        "Johnson, Eq. 11.24; 2.8683, rounded", _duration, "recalled",
    )  # fmt: skip
    for bead, name in enumerate(("light", "heavy")):
        yield Case(
            "beads on a wall", f"superball m on 3 m, {name} one afterwards", -2.0 + 2.0 * bead,
            1e-9, "textbook: two-body collisions", partial(_superball, bead),
        )  # fmt: skip
    yield Case(
        "beads on a wall", "peak of 40 falling beads over that of 2", 1.0, 1e-6,
        "Falcon et al., EPJ B 5, 111 (1998)", lambda: _column(40) / _column(2), "recalled",
    )  # fmt: skip


@shared
def _on(stiffness: float) -> Run:
    chain = Chain.uniform(60).replace(right_wall=Wall(stiffness=stiffness))
    return simulate(chain, times=0)


def _wall_ratio(stiffness: float) -> float:
    """Largest force on a wall over that of the incident pulse."""
    return _on(stiffness).wall_force().peak / PULSE_FORCE


@shared
def _walled(name: str) -> Run:
    chain = {
        "uniform": lambda: Chain.uniform(20),
        "forward-exponential": lambda: Chain.tapered("forward-exponential", 0.05, beads=20),
        "forward-linear": lambda: Chain.tapered("forward-linear", 0.04, beads=20),
        "backward-exponential": lambda: Chain.tapered("backward-exponential", 0.05, beads=20),
    }[name]()
    return simulate(chain.replace(right_wall=Wall()), until=1000.0, times=0)


def _on_wall(name: str, quantity: str) -> float:
    return float(getattr(_walled(name).wall_force(), quantity))


@shared
def _ball(wall: Material) -> Run:
    """A 12 mm steel ball at 0.2 m/s separates from another one and hits a wall."""
    pair = Chain.from_materials(6e-3, STEEL, beads=2)
    chain = pair.replace(velocities=[0.0, 0.2], right_wall=Wall(material=wall))
    return simulate(chain, until=1e-4, times=2)


def _peak(wall: Material) -> float:
    return _ball(wall).wall_force().peak


def _duration() -> float:
    """Twice the time to the peak force, for a rigid wall."""
    run = _ball(RIGID)
    mass, modulus = float(run.chain.masses[1]), 210e9 / 0.91
    unit = (mass**2 / (6e-3 * modulus**2 * 0.2)) ** 0.2
    return 2.0 * run.wall_force().peak_time / unit


def _superball(bead: int) -> float:
    return float(_dropped().state.velocities[bead])


@shared
def _dropped() -> Run:
    chain = Chain.from_radii([1.0, math.cbrt(3.0)]).replace(
        masses=[1.0, 3.0], velocities=[1.0, 1.0], gaps=[50.0], right_wall=Wall(gap=1.0)
    )
    return simulate(chain, until=400.0, times=0)


def _column(beads: int) -> float:
    chain = Chain.uniform(beads).replace(velocities=np.ones(beads), right_wall=Wall(gap=1.0))
    return simulate(chain, until=150.0, times=0).wall_force().peak

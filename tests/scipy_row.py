"""Traces of a row of 16 steel balls in front of a wall, integrated by SciPy from scratch.

Masses, Hertz stiffness and forces are computed here; hertzchain is used only to describe the chain
that is fitted to the traces.
"""

import functools
import math

import numpy as np
from scipy.integrate import solve_ivp

import hertzchain as hc

RADIUS, DENSITY, YOUNG, POISSON = 5e-3, 7780.0, 203e9, 0.3
WALL_YOUNG = 193e9
BALLS, VELOCITY, LOSS_TIME, FACTOR = 15, 0.25, 0.6e-6, 0.97
SPACING, BEFORE = 0.7e-6, 86
# Sensors: in balls, and on the wall.
SENSORS = {"ball 5": 5, "ball 10": 10, "wall": None}
FREE = ["stiffness", "loss.time", "struck_by.velocity", "time_offset"]
TRUTH = {"stiffness": FACTOR, "loss.time": LOSS_TIME, "struck_by.velocity": VELOCITY,
         "time_offset": BEFORE * SPACING}  # fmt: skip


def chain(**fields):
    """The chain with nominal values, which differ from the true ones."""
    row = hc.Chain.from_materials(RADIUS, "steel-52100", beads=BALLS).struck_by(velocity=0.26)
    return row.replace(
        **{"right_wall": hc.Wall.of("steel-304"), "loss": hc.Viscoelastic(0.4e-6)} | fields
    )


@functools.cache
def forces(
    spacing=SPACING, gap=0.0, behind=8, exponent=1.5, static=0.0, velocity=VELOCITY, heavier=1.0,
    wall_young=WALL_YOUNG, gravity=0.0, cell=0.0,
):  # fmt: skip
    """Forces of the sensors after the impact, by name; a load cell is a linear spring."""
    count = BALLS + 1
    masses = np.full(count, DENSITY * 4.0 / 3.0 * math.pi * RADIUS**3)
    masses[[ball for ball in SENSORS.values() if ball is not None]] *= heavier
    softness = (1.0 - POISSON**2) / YOUNG
    inner = 4.0 / 3.0 / (2.0 * softness) * math.sqrt(RADIUS / 2.0)
    wall = 4.0 / 3.0 / (softness + (1.0 - POISSON**2) / wall_young) * math.sqrt(RADIUS)
    # Of the same force at an overlap of 2 um.
    k = FACTOR * np.array([inner] * (count - 1) + [wall]) * 2e-6 ** (1.5 - exponent)
    powers, loss_times = np.full(count, exponent), np.full(count, LOSS_TIME)
    if cell:
        k[-1], powers[-1], loss_times[-1] = cell, 1.0, 0.0
    gaps = np.zeros(count)
    gaps[behind] = gap
    # The striker does not rest on the balls.
    weights = gravity * np.concatenate(([0.0], np.cumsum(masses[1:])))
    at_rest = ((static + weights) / k) ** (1.0 / powers) - gaps

    def forces_of(x, v):
        overlap = (
            x - np.concatenate((x[1:], 0.0 * x[:1])) + at_rest.reshape(-1, *[1] * (x.ndim - 1))
        )
        rate = v - np.concatenate((v[1:], 0.0 * v[:1]))
        closed = np.maximum(overlap, 0.0)
        stiffness, p, loss = (each.reshape(-1, *[1] * (x.ndim - 1))
                              for each in (k, powers, loss_times))  # fmt: skip
        slope = p * closed ** (p - 1.0) * (closed > 0.0)
        return stiffness * (closed**p + loss * slope * rate)

    def derivatives(_, y):
        force = forces_of(y[:count], y[count:])
        push = np.concatenate(([static], force[:-1])) - force
        return np.concatenate((y[count:], push / masses + gravity))

    times = np.arange(0.0, 7e-4, spacing)
    start = np.concatenate((np.zeros(count), [velocity], np.zeros(count - 1)))
    solved = solve_ivp(
        derivatives, (0.0, times[-1]), start, "DOP853", times, rtol=1e-9, atol=1e-14, max_step=2e-6
    )
    found = forces_of(solved.y[:count], solved.y[count:])
    # A force in ball n is the mean of its two sides; the striker is in front of ball 1.
    return {
        name: found[-1] if ball is None else 0.5 * (found[ball - 1] + found[ball])
        for name, ball in SENSORS.items()
    }


def recorded(seed=0, noise=0.1, before=BEFORE, signals=None, **options):
    """Times and columns of a CSV file: forces with samples before the impact, and white noise."""
    rng = np.random.default_rng(seed)
    signals = forces(**options) if signals is None else signals
    columns = {}
    for name, force in signals.items():
        seen = np.concatenate((np.full(before, force[0]), force))
        columns[f"{name} [N]"] = seen + noise * rng.standard_normal(len(seen))
    times = options.get("spacing", SPACING) * np.arange(len(seen))
    return times, columns


def traces(seed=0, *, known_noise=None, change=None, **options):
    """Traces, after a change of the columns."""
    times, columns = recorded(seed, **options)
    columns = columns if change is None else change(columns)
    return hc.Traces.from_arrays(times, columns, noise=known_noise)

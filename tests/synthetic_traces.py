"""Synthetic traces of 20 steel balls in front of a wall, for tests and benchmarks of fits."""

import numpy as np
from scipy.interpolate import make_interp_spline

import hertzchain as hc

BALLS = (6, 11, 16)
STEP = 200 / 2**14


def bench(loss=None, velocity=0.3, factor=1.0, gap=0.0, behind=8, beads=20, **fields):
    """Steel balls with the modulus changed by a factor, and a gap behind one of them."""
    steel = hc.material("steel-52100")
    own = hc.Material("steel", steel.density, factor * steel.young, steel.poisson)
    chain = hc.Chain.from_materials(5e-3, own, beads=beads).struck_by(velocity=velocity)
    gaps = np.zeros(chain.beads - 1)
    gaps[behind] = gap
    return chain.replace(right_wall=hc.Wall(), loss=loss, gaps=gaps, **fields)


def signals(chain, duration, offset, balls=BALLS, spacing=1e-6):
    """Times, and true forces in the balls and on the wall."""
    times = np.arange(0.0, duration, spacing)
    grid = np.arange(0.0, duration + 60e-6, 0.05e-6)
    run = hc.simulate(chain, times=grid, rtol=1e-11)
    columns = [run.sensor(k + chain.strikers) for k in balls] + [run.forces[:, -1]]
    spline = make_interp_spline(grid, np.column_stack(columns), k=3)
    # Before the impact, the forces at rest.
    seen = spline(np.maximum(times - offset, 0.0))
    return times, seen


def recorded(times, seen, rng, *, gains=1.0, noise=0.1, balls=BALLS, step=STEP, phase=0.0):
    """Traces with noise and the steps of a digitiser, by default with 14 bits.

    Zero is at the phase within a step, from -0.5 to 0.5.
    """
    noisy = gains * seen + rng.normal(0.0, noise, seen.shape)
    values = step * (np.round(noisy / step + phase) - phase)
    names = [*(f"ball {k} [N]" for k in balls), "wall [N]"]
    return hc.Traces.from_arrays(times, dict(zip(names, values.T, strict=True)))


def measured(chain, rng, *, offset=4.2e-6, duration=500e-6, balls=BALLS, **options):
    """Traces of a chain."""
    return recorded(*signals(chain, duration, offset, balls), rng, balls=balls, **options)

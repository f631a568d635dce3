"""Write the synthetic traces that ship with hertzchain: two impacts on a row of steel balls.

They are computed with SciPy's integrator from the equations of motion and of the sensors, without
hertzchain, and are used in the documentation and the tests of `hertzchain.fit`.

    python tools/example_traces.py src/hertzchain/fitting/example
"""

import sys
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

# True values.  The chain file has nominal ones: the catalogue's steel, and 0.1 and 0.3 m/s.
BALLS, RADIUS, DENSITY, POISSON = 20, 5e-3, 7780.0, 0.3
YOUNG = 0.96 * 203e9
RELAXATION = 0.62e-6
SHOTS = {"slow": (0.1013, 63.7e-6, 760), "fast": (0.2968, 71.3e-6, 640)}
# Sensors: ball, gain (V/N for the second, which has no calibration), noise and step.
SENSORS = (
    (6, 1.021, 0.1, 200 / 2**14),
    (11, 0.0483, 0.004, 10 / 2**14),
    (16, 0.984, 0.1, 200 / 2**14),
)
WALL = (1.012, 0.1, 200 / 2**14)
LAG, DISCHARGE, CROSSTALK = 1.4e-6, 6e-3, 0.004
SEED = 20


def rates(_, y, mass, stiffness):
    """Equations of motion, and of lag and discharge of each sensor."""
    beads = BALLS + 1
    x, v = y[:beads], y[beads : 2 * beads]
    overlap = np.append(x[:-1] - x[1:], x[-1])
    closing = np.append(v[:-1] - v[1:], v[-1])
    d = np.maximum(overlap, 0.0)
    force = np.maximum(stiffness * np.sqrt(d) * (d + 1.5 * RELAXATION * closing), 0.0)
    around = np.concatenate(([0.0], force))
    # Ball k is bead k + 1 behind the striker.
    signals = [0.5 * (around[k] + around[k + 1]) for k, *_ in SENSORS] + [force[-1]]
    lagging = y[2 * beads :: 2]
    slope = (np.array(signals) - lagging) / LAG
    out = np.empty_like(y)
    out[:beads] = v
    out[beads : 2 * beads] = (around[:-1] - force) / mass
    out[2 * beads :: 2] = slope
    out[2 * beads + 1 :: 2] = slope - y[2 * beads + 1 :: 2] / DISCHARGE
    return out


def shot(velocity, offset, samples, rng):
    """Times and columns of one shot as the recorder stores them."""
    mass = 4.0 / 3.0 * np.pi * DENSITY * RADIUS**3
    modulus = YOUNG / (1.0 - POISSON**2) / 2.0
    stiffness = np.full(BALLS + 1, 4.0 / 3.0 * modulus * np.sqrt(RADIUS / 2.0))
    stiffness[-1] = 4.0 / 3.0 * modulus * np.sqrt(RADIUS)
    start = np.zeros(2 * (BALLS + 1) + 2 * (len(SENSORS) + 1))
    start[BALLS + 1] = velocity
    times = 1e-6 * np.arange(samples)
    moments = times - offset
    after = moments > 0.0
    found = solve_ivp(
        rates, (0.0, moments[-1]), start, "DOP853", moments[after], args=(mass, stiffness),
        rtol=1e-10, atol=1e-16, max_step=1e-6,
    )  # fmt: skip
    seen = np.zeros((samples, len(SENSORS) + 1))
    seen[after] = found.y[2 * (BALLS + 1) + 1 :: 2].T
    constants = [each[1:] for each in SENSORS] + [WALL]
    for i, (gain, _, _) in enumerate(constants):
        seen[:, i] *= gain
    # Crosstalk of neighbouring channels that are recorded in the same unit: the last two.
    mixed = seen.copy()
    mixed[:, 2] += CROSSTALK * seen[:, 3]
    mixed[:, 3] += CROSSTALK * seen[:, 2]
    for i, (_, noise, step) in enumerate(constants):
        # Adding 0 turns -0 into 0.
        mixed[:, i] = step * np.round((mixed[:, i] + rng.normal(0.0, noise, samples)) / step) + 0.0
    return times, mixed


def main():
    """Write both files into the folder named on the command line."""
    folder = Path(sys.argv[1])
    rng = np.random.default_rng(SEED)
    for name, (velocity, offset, samples) in SHOTS.items():
        times, columns = shot(velocity, offset, samples, rng)
        lines = [
            "# Synthetic data, made by tools/example_traces.py; see docs/how-to/fit.md",
            "time [us],ball 6 [N],ball 11 [mV],ball 16 [N],wall [N]",
        ]
        for time, row in zip(times, columns, strict=True):
            a, b, c, d = row
            lines.append(f"{1e6 * time:.0f},{a:.6g},{1e3 * b:.6g},{c:.6g},{d:.6g}")
        (folder / f"{name}.csv").write_text("\n".join(lines) + "\n", "utf-8")


if __name__ == "__main__":
    main()

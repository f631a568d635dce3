"""Compute the table of `explanation/predictability.md`.

Each chain is integrated with tolerances of 1e-13 and 1e-14, and by its shadow run.  The error is
the largest difference between two velocities, relative to the largest velocity.
"""

import numpy as np

import hertzchain as hc

# Stiffness of the contact of a bead of radius 1 with a flat wall of the same material.
WALL = hc.Wall(stiffness=np.sqrt(2.0))
BOX = {"left_wall": WALL, "right_wall": WALL}


def chains() -> list[tuple[str, hc.Chain, float]]:
    """Names, chains and end times of the runs."""
    scattered = np.random.default_rng(1).uniform(0.9, 1.1, 100)
    column = hc.Chain.uniform(30).replace(gravity=0.01, right_wall=WALL)
    taper = hc.Chain.tapered("forward-exponential", 0.03, beads=60)
    pressed = hc.Chain.uniform(60).replace(precompression=0.3, **BOX)
    dimer = hc.Chain.dimer(0.5, beads=60)
    return [
        ("equal beads, 100, two walls", hc.Chain.uniform(100).replace(**BOX), 500.0),
        ("radii 0.9 to 1.1, 100, two walls", hc.Chain.from_radii(scattered).replace(**BOX), 500.0),
        ("dimer of mass ratio 0.5, 60, two walls", dimer.replace(**BOX), 300.0),
        ("forward-exponential, q = 0.03, 60, one wall", taper.replace(right_wall=WALL), 280.0),
        ("equal beads, 60, free ends", hc.Chain.uniform(60), 500.0),
        ("column under gravity, 30, one wall", column, 500.0),
        ("equal beads, 60, two walls, Restitution(0.95)",
         hc.Chain.uniform(60).replace(loss=hc.Restitution(0.95), **BOX), 500.0),
        ("equal beads, 60, two walls, precompressed", pressed, 500.0),
    ]  # fmt: skip


def first_time(run: hc.Run, other: hc.Run, within: float = 0.01) -> tuple[float, float]:
    """Time at which two runs differ by a fraction of the largest velocity, and largest error."""
    error = np.abs(run.velocities - other.velocities).max(axis=1) / np.abs(run.velocities).max()
    beyond = np.flatnonzero(error > within)
    return (run.times[beyond[0]] if len(beyond) else np.inf), float(error.max())


def format_time(time: float, error: float) -> str:
    """Format a time, or the largest error if there is no such time."""
    return f"{time:.0f}" if np.isfinite(time) else f"never ({error:.1g})"


def main() -> None:
    """Print the table."""
    print("| chain, run until | energy drift | 1e-13 and 1e-14 differ by 1% at | `horizon()` | "
          "of a run at 1e-12 |\n|---|---|---|---|---|")  # fmt: skip
    for name, chain, until in chains():
        times = np.linspace(0.0, until, 501)[1:]
        run, tight, loose = (
            hc.simulate(chain, times=times, rtol=rtol) for rtol in (1e-13, 1e-14, 1e-12)
        )
        cells = [format_time(*first_time(run, tight))]
        for other in (run, loose):
            horizon = other.horizon()
            cells.append(format_time(horizon.time, horizon.error[-1]))
        print(f"| {name}, {until:g} | {run.energy_drift:.0e} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()

"""Compute results of the most used methods on some chains, and compare two versions bit by bit.

Save the results before a change that must not alter any of them, and compare afterwards:

    python tools/reference_results.py save before.npz
    python tools/reference_results.py compare before.npz

``compare`` prints the largest relative difference of each result that differs, and exits with code
3 if there is one.
The numbers depend on the processor and on the versions of NumPy and numba, so files are compared
on one machine and never committed.
"""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

import hertzchain as hc

TAPERS = {
    "backward-exponential": 0.05,
    "backward-linear": 0.9,
    "forward-exponential": 0.03,
    "forward-linear": 0.009,
}
LOSSES = {
    "restitution": hc.Restitution(0.9),
    "restitution without attraction": hc.Restitution(0.9, attractive=False),
    "viscoelastic": hc.Viscoelastic(0.1),
    "unloading ratio": hc.UnloadingRatio(0.1),
    "velocity power": hc.VelocityPower(0.1, 1.6),
    "dashpot": hc.Dashpot(0.1),
    "Walton-Braun": hc.WaltonBraun(0.9),
}
Results = dict[str, np.ndarray]


def scaled_chains() -> Iterator[tuple[str, hc.Chain]]:
    """Chains without walls, losses or drives."""
    for taper, rate in TAPERS.items():
        yield f"{taper} {rate}", hc.Chain.tapered(taper, rate, beads=100)
    yield "uniform", hc.Chain.uniform(100)
    yield "uniform, p = 2", hc.Chain.uniform(60, exponent=2.0)
    yield (
        "backward exponential, p = 1.8",
        hc.Chain.tapered("backward-exponential", 0.03, beads=40, exponent=1.8),
    )
    random = np.random.default_rng(7)
    yield "random radii", hc.Chain.from_radii(random.uniform(0.5, 2.0, 40))
    yield "alternating radii", hc.Chain.periodic([1.0, 0.6], cells=20)


def general_chains() -> Iterator[tuple[str, hc.Chain, float]]:
    """Chains for `simulate`, and the time at which the run ends."""
    walled = hc.Chain.uniform(20).replace(right_wall=hc.Wall())
    yield "wall", walled, 60.0
    yield (
        "two walls and gaps",
        walled.replace(left_wall=hc.Wall.rigid(gap=0.1), gaps=[0.05] * 19),
        60.0,
    )
    yield "gravity", hc.Chain.uniform(12).replace(gravity=0.05, right_wall=hc.Wall()), 40.0
    yield "precompression", hc.Chain.uniform(20).replace(precompression=0.1, held_by="force"), 30.0
    yield "strikers", hc.Chain.uniform(20).struck_by(count=3), 40.0
    for name, loss in LOSSES.items():
        yield name, walled.replace(loss=loss), 50.0
    at_rest = hc.Chain.uniform(15).replace(
        velocities=np.zeros(15), precompression=0.1, held_by="force"
    )
    pushed = at_rest.replace(drive=hc.SineBurst(0.05, frequency=0.1, cycles=3))
    yield "sine burst", pushed, 60.0
    steel = hc.Chain.from_materials(
        [9.5e-3] * 16, ["steel-316", "ptfe"] * 8, velocity=0.4, right_wall=hc.Wall.of("brass")
    )
    yield "steel and PTFE", steel, 2e-3


def pulses() -> Iterator[tuple[str, hc.Pulse]]:
    """Leading pulses by all methods."""
    for name, chain in scaled_chains():
        yield f"propagate: {name}", hc.propagate(chain)
        yield f"bca: {name}", hc.bca(chain)
        yield f"hard_sphere: {name}", hc.hard_sphere(chain)
        if chain.exponent in (1.5, 2.0):
            yield f"local_rate: {name}", hc.local_rate(chain)
        if chain.taper is not None and chain.exponent == 1.5:
            yield f"modified_bca: {name}", hc.modified_bca(chain)
    table = hc.propagate_many(
        [chain.radii for _, chain in scaled_chains() if chain.exponent == 1.5]
    )
    for row, pulse in enumerate(table):
        yield f"propagate_many: {row}", pulse
    for name, chain in scaled_chains():
        if chain.beads == 40:
            yield f"simulate: {name}", hc.simulate(chain, times=50).pulse()


def results() -> Results:
    """All results by name."""
    found: Results = {}
    for name, pulse in pulses():
        for quantity, values in pulse.columns().items():
            found[f"{name}: {quantity}"] = values
    for name, chain, until in general_chains():
        run = hc.simulate(chain, until=until, times=101)
        found |= {f"{name}: positions": run.positions, f"{name}: velocities": run.velocities}
        found |= {f"{name}: forces": run.forces, f"{name}: steps": np.array([run.steps])}
        for kind, values in run.budget().energy.items():
            found[f"{name}: energy: {kind}"] = values
    chain = hc.Chain.tapered("backward-exponential", 0.05, beads=60)
    found["gradient"] = hc.local_rate_gradient(chain, "velocity", bead=50)[1]
    wave = hc.solitary_wave(1.5)
    found["solitary wave"] = wave.velocity(np.linspace(-3.0, 3.0, 25))
    sweep = hc.sweep(
        {
            "chain": {"taper": "forward-exponential"},
            "axes": {"rate": [0.02, 0.05], "beads": [20, 30]},
            "sweep": {
                "methods": ["propagate", "local-rate", "simulate"],
                "keep": ["momentum", "arrival"],
            },
        }
    )
    found |= {f"sweep: {name}": sweep[name].values for name in ("momentum", "arrival")}
    return found


def compare(before: Results, now: Results, show: Callable[[str], None] = print) -> int:
    """Print all differences and return their number."""
    different = 0
    for name in sorted(before.keys() | now.keys()):
        if name not in before or name not in now:
            show(f"{name}: only {'before' if name in before else 'now'}")
        elif before[name].shape != now[name].shape:
            show(f"{name}: shape {before[name].shape} before, {now[name].shape} now")
        elif not np.array_equal(before[name], now[name], equal_nan=True):
            size = np.nanmax(np.abs(before[name]))
            error = np.nanmax(np.abs(now[name] - before[name])) / (size or 1.0)
            show(f"{name}: differs by {error:.1e} of its largest value")
        else:
            continue
        different += 1
    show(f"{len(now)} results, {different} differ")
    return different


def main() -> None:
    """Save the results, or compare them with saved ones."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("action", choices=("save", "compare"))
    parser.add_argument("file", type=Path)
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    now = results()
    if arguments.action == "save":
        np.savez_compressed(arguments.file, **now)
        print(f"{len(now)} results saved to {arguments.file}")
    else:
        with np.load(arguments.file) as before:
            sys.exit(3 if compare(dict(before), now) else 0)


if __name__ == "__main__":
    main()

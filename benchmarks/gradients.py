"""Measure the accuracy of gradients, and their time in units of the run that they differentiate.

    python benchmarks/gradients.py

Errors are those of the largest component, against a gradient at rtol = 1e-14.  Times are the
shortest of several, measured in this thread.
"""

import time
import warnings

import numpy as np

import hertzchain as hc
from hertzchain.sensitivity import gradient as module

TO = ("radii", "masses", "stiffness", "gaps", "velocities")
REPETITIONS = 10


def cases():
    """Chains and quantities by name."""
    rough = np.random.default_rng(3).uniform(0.5, 1.0, 20)
    rough[0] = 1.0
    walled = {"right_wall": hc.Wall()}
    forward = hc.Chain.tapered("forward-exponential", 0.03, beads=20).replace(**walled)
    damped = forward.replace(loss=hc.Viscoelastic(0.02))
    return {
        "20 beads, forward, wall": (forward, "wall_force.peak"),
        "20 beads, rough, wall": (hc.Chain.from_radii(rough).replace(**walled), "wall_force.peak"),
        "60 equal beads, wall": (hc.Chain.uniform(60).replace(**walled), "wall_force.peak"),
        "20 beads, viscoelastic": (damped, "wall_force.peak"),
        "100 beads, forward": (
            hc.Chain.tapered("forward-exponential", 0.01, beads=100), "pulse.velocity@90",
        ),
        "100 beads, backward": (
            hc.Chain.tapered("backward-exponential", 0.03, beads=100), "pulse.velocity@90",
        ),
    }  # fmt: skip


def accuracy():
    """Print errors and estimates for several tolerances."""
    print(f"{'chain':<26}{'rtol':>8}{'steps':>8}{'value':>10}{'gradient':>10}{'estimate':>10}")
    for name, (chain, quantity) in cases().items():
        exact = hc.gradient(chain, quantity, to=TO, rtol=1e-14)
        for rtol in (1e-7, 1e-9, 1e-10, 1e-12):
            found = hc.gradient(chain, quantity, to=TO, rtol=rtol)
            error = max(np.abs(found[to] - exact[to]).max() / np.abs(exact[to]).max() for to in TO)
            value = abs(found.value / exact.value - 1.0)
            print(f"{name:<26}{rtol:>8.0e}{found.steps:>8}{value:>10.1e}{error:>10.1e}"
                  f"{found.error:>10.1e}", flush=True)  # fmt: skip


def times():
    """Print times of runs and of their gradients."""
    spent = {}

    def timed(function, name):
        def run(*args):
            began = time.thread_time()
            result = function(*args)
            spent.setdefault(name, []).append(time.thread_time() - began)
            return result

        return run

    module.run, module.sweep = timed(module.run, "run"), timed(module.sweep, "sweep")
    print(f"\n{'beads':>6}{'steps':>8}{'run, ms':>10}{'sweep, ms':>11}{'all, ms':>10}{'ratio':>8}")
    chains = [
        hc.Chain.tapered("forward-exponential", 0.3 / n, beads=n).replace(right_wall=hc.Wall())
        for n in (20, 50, 100, 300)
    ]
    jobs = [(chain, "wall_force.peak") for chain in chains]
    jobs += [case for name, case in cases().items() if name.startswith("100")]
    for chain, quantity in jobs:
        spent.clear()
        totals = []
        for _ in range(REPETITIONS):
            began = time.thread_time()
            found = hc.gradient(chain, quantity, to=TO)
            totals.append(time.thread_time() - began)
        run, sweep, total = (1e3 * min(each) for each in (spent["run"], spent["sweep"], totals))
        print(f"{chain.beads:>6}{found.steps:>8}{run:>10.2f}{sweep:>11.2f}{total:>10.2f}"
              f"{total / run:>8.2f}")  # fmt: skip


if __name__ == "__main__":
    warnings.simplefilter("ignore", hc.IncompleteWarning)
    accuracy()
    times()

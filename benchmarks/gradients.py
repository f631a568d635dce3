"""Measure the accuracy of gradients, and their time in units of the run that they differentiate.

    python benchmarks/gradients.py

Errors are those of the largest component, against a gradient at rtol = 1e-14.  Times are the
shortest of several, measured in this thread.
"""

import time
import warnings

import numpy as np

import hertzchain as hc
from hertzchain.derivatives import gradient as module

TO = ("radii", "masses", "stiffness", "gaps", "velocities")
REPETITIONS = 7
PLAIN_RTOL = 1e-10


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


def timed(spent, function, name):
    """The function, which adds its time to ``spent``."""

    def run(*args):
        began = time.thread_time()
        result = function(*args)
        spent[name] += time.thread_time() - began
        return result

    return run


def times():
    """Print times of runs, of their gradients, and of the same run without a record.

    The ratio is that of all to the run that is recorded; the cost is that of all to a plain run of
    the same tolerance, with which designs count gradients (`exact_gradients.COST`).
    """
    spent = {"run": 0.0, "sweep": 0.0}
    # A pulse that the window cannot follow is integrated again with all beads.
    for name, kind in (("follow_pulse", "run"), ("run", "run"), ("sweep", "sweep")):
        setattr(module, name, timed(spent, getattr(module, name), kind))
    print(f"\n{'beads':>6}{'steps':>8}{'run, ms':>10}{'sweep, ms':>11}{'all, ms':>10}{'ratio':>8}"
          f"{'plain, ms':>11}{'cost':>8}")  # fmt: skip
    chains = [
        hc.Chain.tapered("forward-exponential", 0.3 / n, beads=n).replace(right_wall=hc.Wall())
        for n in (20, 50, 100, 300)
    ]
    jobs = [(chain, "wall_force.peak") for chain in chains]
    jobs += [case for name, case in cases().items() if not name.startswith("20 beads, forward")]
    for chain, quantity in jobs:
        rows = [one_time(spent, chain, quantity) for _ in range(REPETITIONS)]
        run, sweep, total, plain = (1e3 * min(each) for each in zip(*rows, strict=True))
        steps = hc.gradient(chain, quantity, to=TO).steps
        print(f"{chain.beads:>6}{steps:>8}{run:>10.2f}{sweep:>11.2f}{total:>10.2f}"
              f"{total / run:>8.2f}{plain:>11.2f}{total / plain:>8.2f}", flush=True)  # fmt: skip


def one_time(spent, chain, quantity):
    """Times of the run, of the sweep, of the whole gradient, and of a run without a record."""
    spent.update(run=0.0, sweep=0.0)
    began = time.thread_time()
    hc.gradient(chain, quantity, to=TO)
    total = time.thread_time() - began
    keep = "wall_peak_force" if quantity.startswith("wall") else "velocity"
    began = time.process_time()
    hc.simulate_many([chain], keep=keep, rtol=PLAIN_RTOL, threads=1)
    return spent["run"], spent["sweep"], total, time.process_time() - began


if __name__ == "__main__":
    warnings.simplefilter("ignore", hc.IncompleteWarning)
    accuracy()
    times()

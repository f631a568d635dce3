"""The local-rate law with loss against `simulate`: ``python benchmarks/loss_law.py [CHAINS]``.

For each law of loss and range of its strength, random smooth tapers that were not used for the
tables.  Prints the number of chains, of errors raised and of warnings; the largest velocity error
of each other chain, from bead 10 on (median, 90% and largest, in %); the largest errors of velocity
(from bead 10 on), arrival time and force of chains without a warning; beads whose error is below
the estimate; and the median ratio of estimate to error.  The strength of
`Viscoelastic` is the largest one along the chain.  Some ten minutes.  The first lines are the
times of the law and of `simulate` for one taper; with 0 CHAINS, nothing else is computed.
"""

import sys
import time
import warnings

import numpy as np
from scipy.interpolate import CubicSpline

import hertzchain as hc


def viscoelastic(strength, chain):
    """The relaxation time for which A (k/m)^(2/5) v^(1/5) of the lossless pulse reaches a value."""
    velocity = hc.propagate(chain, rtol=1e-9).velocity[:-1]
    unit = (chain.stiffness / chain.masses[:-1]) ** 0.4 * velocity**0.2
    return hc.Viscoelastic(strength / unit.max())


RANGES = {
    "Restitution 1 to 0.97": (lambda x, _: hc.Restitution(1 - x), 0.003, 0.03),
    "Restitution 0.97 to 0.94": (lambda x, _: hc.Restitution(1 - x), 0.03, 0.06),
    "Restitution 0.94 to 0.9": (lambda x, _: hc.Restitution(1 - x), 0.06, 0.1),
    "without pull, 1 to 0.9": (lambda x, _: hc.Restitution(1 - x, attractive=False), 0.003, 0.1),
    "UnloadingRatio to 0.03": (lambda x, _: hc.UnloadingRatio(x), 0.003, 0.03),
    "UnloadingRatio to 0.06": (lambda x, _: hc.UnloadingRatio(x), 0.03, 0.06),
    "UnloadingRatio to 0.1": (lambda x, _: hc.UnloadingRatio(x), 0.06, 0.1),
    "Viscoelastic to 0.01": (viscoelastic, 0.0005, 0.01),
    "Viscoelastic to 0.03": (viscoelastic, 0.01, 0.03),
    "Viscoelastic to 0.06": (viscoelastic, 0.03, 0.06),
}


def random_radii(random, beads):
    """Radii of a smooth taper: a spline of the rate or of ln R, a hump or a step, or a power."""
    k = np.arange(beads)
    while True:
        kind = random.integers(5)
        if kind == 0:
            knots = np.linspace(0, beads, random.integers(3, 8))
            level = np.exp(random.uniform(np.log(0.004), np.log(0.07)))
            rates = CubicSpline(knots, level * random.normal(size=len(knots)))(k)
            log_radii = np.cumsum(rates)
        elif kind == 1:
            width = np.exp(random.uniform(np.log(8), np.log(40)))
            bend = (k - random.uniform(0, beads)) / width
            hump = np.exp(-(bend**2)) if random.random() < 0.5 else np.tanh(bend)
            log_radii = random.uniform(-0.6, 0.6) * hump + random.uniform(-0.02, 0.03) * k
        elif kind == 2:
            log_radii = random.uniform(-1, 1.5) * np.log1p(k / random.uniform(15, 200))
        elif kind == 3:
            log_radii = random.uniform(-0.06, 0.08) * k
        else:
            period = random.uniform(30, 150)
            depth = random.uniform(0.002, 0.05) * period / 6.28
            log_radii = depth * np.sin(6.28 * (k / period + random.random()))
        rates = np.diff(log_radii)
        if rates.min() > -0.08 and rates.max() < 0.1 and np.abs(np.diff(rates)).max() < 0.008:
            return np.exp(log_radii - log_radii[0])


def evaluated(chain):
    """Errors, estimate and whether there was a warning; or `None` if the law does not apply."""
    with warnings.catch_warnings(record=True) as raised:
        warnings.simplefilter("always")
        try:
            law = hc.local_rate(chain)
        except hc.InputError:
            return None
    compared = law.compare(hc.simulate(chain, times=0, rtol=1e-9, check=False).pulse())
    errors = [np.abs(compared.errors(name)) for name in ("velocity", "arrival", "peak_force")]
    return *errors, law.velocity_error, bool(raised)


def row(name, count, seed):
    """One line of the table."""
    make, low, high = RANGES[name]
    random = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        radii = random_radii(random, int(random.choice([30, 60, 100, 100, 100])))
        chain = hc.Chain.from_radii(radii)
        found.append(evaluated(chain.replace(loss=make(random.uniform(low, high), chain))))
    kept = [each for each in found if each is not None]
    velocity = 100 * np.array([each[0][9:].max() for each in kept])
    quiet = np.array([not each[4] for each in kept])
    others = [100 * max(each[i].max() for each in kept if not each[4]) for i in (1, 2)]
    error, estimate = (np.concatenate([each[i][1:] for each in kept]) for i in (0, 3))
    ratio = np.median(estimate / np.maximum(error, 1e-9))
    print(
        f"{name:25} {count:4} {count - len(kept):4} {np.sum(~quiet):4}   "
        f"{np.median(velocity):6.3f} {np.quantile(velocity, 0.9):6.3f} {velocity.max():6.2f}   "
        f"{velocity[quiet].max():6.3f} {others[0]:6.3f} {others[1]:6.3f}   "
        f"{100 * np.mean(error <= estimate):6.2f} {ratio:5.1f}",
        flush=True,
    )


def cpu_time(call, repeats):
    """Shortest processor time of a call [ms], after one that compiles."""
    times = []
    for _ in range(repeats + 1):
        began = time.process_time()
        call()
        times.append(1e3 * (time.process_time() - began))
    return min(times[1:])


def print_times():
    """Times of the law and of the simulation for a backward-linear taper of 100 beads."""
    taper = hc.Chain.tapered("backward-linear", 0.05, beads=100)
    for loss in (None, hc.Restitution(0.95), hc.UnloadingRatio(0.05), hc.Viscoelastic(0.01)):
        chain = taper.replace(loss=loss)
        law = cpu_time(lambda chain=chain: hc.local_rate(chain), 100)
        run = cpu_time(lambda chain=chain: hc.simulate(chain, times=0), 10)
        print(f"{loss!r:48} local_rate {law:6.3f} ms   simulate {run:6.2f} ms   {run / law:5.0f}")


if __name__ == "__main__":
    chains = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    print_times()
    if not chains:
        sys.exit()
    print(f"{'':27}n  raised warned  median   90%    max | unwarned: v, arrival, force | covered")
    for place, name in enumerate(RANGES):
        row(name, chains, 1000 + place)

"""The disorder law against ensembles: ``python benchmarks/disorder.py [CHAINS]``.

Prints, at bead 100 of 110, the mean effect of the scatter on ln v and its standard deviation, each
over the law's, with the standard errors of the ensemble; and the same for arrival time and force.
"""

import sys

import numpy as np

import hertzchain as hc

BEADS, BEAD = 110, 100
TAPERS = {
    "uniform": np.zeros(BEADS - 1),
    "exponential -0.02": np.full(BEADS - 1, -0.02),
    "exponential -0.004": np.full(BEADS - 1, -0.004),
    "exponential 0.007": np.full(BEADS - 1, 0.007),
    "exponential 0.04": np.full(BEADS - 1, 0.04),
    "backward-linear 0.05": np.diff(np.log(1 + 0.05 * np.arange(BEADS))),
    "sine 0.02": 0.02 * np.sin(2 * np.pi * np.arange(BEADS - 1) / 60),
}


def columns(radii, velocity, arrival, overlap):
    """Logarithms of velocity, arrival time and force on the next bead, at one bead."""
    stiffness = hc.collision.hertz_stiffness(radii[..., BEAD - 1], radii[..., BEAD])
    force = np.log(stiffness) + 1.5 * np.log(overlap[..., BEAD - 1])
    return np.stack([np.log(velocity[..., BEAD - 1]), np.log(arrival[..., BEAD - 1]), force])


def ensemble(radii, scatter, chains, seed, moduli=False):
    """Logarithms over an ensemble of pairs with opposite deviations, in units of R_1 = 1."""
    x = scatter * np.random.default_rng(seed).standard_normal((chains // 2, BEADS))
    x = np.concatenate((x, -x))
    if moduli:
        chain, soft = hc.Chain.from_radii(radii), np.exp(-x)
        factors = 2.0 / (soft[:, :-1] + soft[:, 1:])
        rows = [chain.replace(stiffness=chain.stiffness * factor) for factor in factors]
        table = hc.propagate_many(rows, rtol=1e-7, threads=1)
        found = columns(table.radii, table.velocity, table.arrival, table.peak_overlap)
        return found + 1.0 * np.log(factors[:, BEAD - 1]) * np.array([0, 0, 1])[:, np.newaxis]
    rows = radii * np.exp(x)
    table = hc.propagate_many(rows, rtol=1e-7, threads=1)
    found = columns(table.radii, table.velocity, table.arrival, table.peak_overlap)
    return found + x[:, 0] * np.array([0.0, 1.0, 2.0])[:, np.newaxis]


def compare(name, scatter, chains, seed=7, moduli=False):
    """Ratios of mean effect and spread, ensemble over law, for each quantity."""
    radii = np.exp(np.concatenate(([0.0], np.cumsum(TAPERS[name]))))
    chain = hc.Chain.from_radii(radii)
    clean = hc.propagate(chain)
    law = hc.disorder(chain, **{"modulus_scatter" if moduli else "scatter": scatter})
    nominal = hc.local_rate(chain)
    found = ensemble(radii, scatter, chains, seed, moduli)
    exact = columns(radii, clean.velocity, clean.arrival, clean.peak_overlap)
    effect = found - exact[:, np.newaxis]
    mean, pairs = effect.mean(axis=1), effect.reshape(3, 2, -1).mean(axis=1)
    error = pairs.std(axis=1) / np.sqrt(pairs.shape[1])
    expected = columns(radii, law.velocity, law.arrival, law.peak_overlap) - columns(
        radii, nominal.velocity, nominal.arrival, nominal.peak_overlap
    )
    spread = [law.velocity_spread, law.arrival_spread, law.peak_force_spread]
    spread = np.array([each[BEAD - 1] for each in spread])
    return mean / expected, error / np.abs(expected), found.std(axis=1) / spread


if __name__ == "__main__":
    chains = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    print(f"{chains} chains; ensemble/law of mean effect (standard error) and of spread")
    for kind, scatters in (("radii", (0.001, 0.003, 0.01)), ("moduli", (0.01,))):
        for name in TAPERS:
            for scatter in scatters:
                ratios = compare(name, scatter, chains, moduli=kind == "moduli")
                shown = "; ".join(
                    f"{of}: mean {m:.3f} ({e:.3f}), spread {d:.3f}"
                    for of, m, e, d in zip(("v", "t", "F"), *ratios, strict=True)
                )
                print(f"{kind} {scatter:5.1%} {name:21} {shown}", flush=True)

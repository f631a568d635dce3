"""The disorder law against ensembles: ``python benchmarks/disorder.py [CHAINS]``.

Prints, at several beads of chains of 110, the errors of the law's geometric means and of its
standard deviations.  The chains are pairs with opposite deviations, which are uncorrelated from
bead to bead in the sample, too; the standard errors of the means and spreads are then small.
"""

import sys

import numpy as np

import hertzchain as hc

BEADS, SHOWN = 110, (2, 5, 10, 30, 50, 100, 110)
TAPERS = {
    "equal": np.zeros(BEADS - 1),
    "forward 0.03": np.full(BEADS - 1, -0.03),
    "backward 0.05": np.full(BEADS - 1, 0.05),
    "backward-linear 0.05": np.diff(np.log(1 + 0.05 * np.arange(BEADS))),
    "sine 0.02": 0.02 * np.sin(2 * np.pi * np.arange(BEADS - 1) / 60),
}
SCATTERS = (0.003, 0.01, 0.03)
SPREADS = {
    "velocity": "velocity_spread", "arrival": "arrival_spread", "peak_force": "peak_force_spread",
}  # fmt: skip


def deviations(scatter, chains, seed=7):
    """Pairs with opposite deviations of ln R or ln E, uncorrelated from bead to bead."""
    drawn = np.random.default_rng(seed).standard_normal((chains // 2, BEADS))
    x = scatter * np.sqrt(len(drawn)) * np.linalg.qr(drawn)[0]
    return np.concatenate((x, -x))


def ensemble(radii, x, moduli=False):
    """Logarithms of the columns over an ensemble, in the units of the nominal chain."""
    first = np.zeros(len(x)) if moduli else x[:, 0]
    size, rows = x * (not moduli), radii * np.exp(x)
    if moduli:
        chain, soft = hc.Chain.from_radii(radii), np.exp(-x)
        factors = 2.0 / (soft[:, :-1] + soft[:, 1:])
        rows = [chain.replace(stiffness=chain.stiffness * factor) for factor in factors]
    table = hc.propagate_many(rows, rtol=1e-7, threads=1)
    unit = first[:, np.newaxis]
    velocity = np.log(table.velocity)
    mass = np.log(hc.Chain.from_radii(radii).masses) + 3.0 * size
    with np.errstate(divide="ignore"):
        arrival = np.log(table.arrival)
    return {
        "velocity": velocity,
        "momentum": velocity + mass,
        "energy": 2.0 * velocity + mass + np.log(0.5),
        "arrival": arrival + unit,
        "residence": np.log(table.residence) + unit,
        "peak_force": np.log(table.stiffness) + 1.5 * np.log(table.peak_overlap) + 2.0 * unit,
        "peak_overlap": np.log(table.peak_overlap) + unit,
    }


def compare(name, scatter, chains, moduli=False):
    """By quantity and bead: error of the mean, its standard error, and spread of chains and law."""
    radii = np.exp(np.concatenate(([0.0], np.cumsum(TAPERS[name]))))
    law = hc.disorder(
        hc.Chain.from_radii(radii), **{"modulus_scatter" if moduli else "scatter": scatter}
    )
    predicted, result = law.columns(), {}
    for quantity, found in ensemble(radii, deviations(scatter, chains), moduli).items():
        for bead in SHOWN:
            if bead > found.shape[1]:
                continue
            values = found[:, bead - 1]
            pairs = values.reshape(2, -1).mean(axis=0)
            spread = predicted.get(SPREADS.get(quantity, ""))
            result[quantity, bead] = (
                np.log(predicted[quantity][bead - 1]) - values.mean(),
                pairs.std() / np.sqrt(len(pairs)),
                values.std(),
                np.nan if spread is None else spread[bead - 1],
            )
    return result


def show(kind, name, scatter, result):
    """Print one line per quantity: errors of the mean, and of the spread, by bead."""
    print(f"\n{scatter:.1%} scatter of {kind}, {name}; beads {', '.join(map(str, SHOWN))}")
    for quantity in dict.fromkeys(quantity for quantity, _ in result):
        rows = np.array([row for key, row in result.items() if key[0] == quantity])
        error, uncertain, found, law = rows.T
        means = " ".join(f"{100 * each:+8.4f}" for each in error)
        print(f"{quantity:12} mean off by [%]  {means}  (+-{100 * uncertain.max():.4f})")
        print(f"{'':12} spread [%]       " + " ".join(f"{100 * each:8.4f}" for each in found))
        if np.isfinite(law).all():
            print(f"{'':12} law/ensemble     " + " ".join(f"{each:8.3f}" for each in law / found))


def summarize(results):
    """Print the largest errors of means and the range of those of spreads, by quantity."""
    by_scatter = {}
    for (kind, _, scatter), result in results.items():
        by_scatter.setdefault((kind, scatter), []).append(result)
    print("\n| quantity | " + " | ".join(f"{s:.1%} ({kind})" for kind, s in by_scatter) + " |")
    print("|---" * (1 + len(by_scatter)) + "|")
    for quantity in dict.fromkeys(quantity for quantity, _ in next(iter(results.values()))):
        cells = []
        for each in by_scatter.values():
            rows = [row for result in each for key, row in result.items() if key[0] == quantity]
            error, uncertain, found, law = np.array(rows).T
            worst = np.argmax(np.abs(error))
            part = 100.0 * (law / found - 1.0)
            spread = f"; {part.min():+.2f} to {part.max():+.2f}%" if np.isfinite(part).all() else ""
            cells.append(f"{100 * abs(error[worst]):.4f}% (+-{100 * uncertain[worst]:.4f}){spread}")
        print(f"| {quantity} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    chains = int(sys.argv[1]) if len(sys.argv) > 1 else 4000
    print(f"{chains} chains each; the signs are those of law minus ensemble")
    results = {}
    for kind, scatters in (("radii", SCATTERS), ("moduli", (0.01, 0.1))):
        for name in TAPERS:
            for scatter in scatters:
                found = compare(name, scatter, chains, kind == "moduli")
                results[kind, name, scatter] = found
                show(kind, name, scatter, found)
                sys.stdout.flush()
    summarize(results)

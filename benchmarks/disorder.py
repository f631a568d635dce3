"""The disorder law against ensembles: ``python benchmarks/disorder.py [CHAINS] [TAPER ...]``.

Prints, at several beads of chains of 110, the errors of the law's geometric means and of its
standard deviations.  The chains are pairs with opposite deviations, which are uncorrelated from
bead to bead in the sample, too; the standard errors of the means and spreads are then small.

``python benchmarks/disorder.py estimate [CHAINS]`` compares the estimated errors of the mean
velocity at all beads with the deviations, in tapers of many kinds with rates from -0.1 to 0.1.
"""

import sys
import warnings

import numpy as np

import hertzchain as hc

BEADS, SHOWN = 110, (2, 5, 10, 30, 50, 100, 110)
TAPERS = {
    "equal": np.zeros(BEADS - 1),
    "forward 0.03": np.full(BEADS - 1, -0.03),
    "backward 0.05": np.full(BEADS - 1, 0.05),
    "backward-linear 0.05": np.diff(np.log(1 + 0.05 * np.arange(BEADS))),
    "backward-linear 0.1": np.diff(np.log(1 + 0.1 * np.arange(BEADS))),
    "sine 0.02": 0.02 * np.sin(2 * np.pi * np.arange(BEADS - 1) / 60),
}
SCATTERS = (0.003, 0.01, 0.03)
MODULUS_SCATTERS = (0.01, 0.1)
SPREADS = {
    "velocity": "velocity_spread", "arrival": "arrival_spread", "peak_force": "peak_force_spread",
}  # fmt: skip


def tapers_of_the_range():
    """Rates of tapers of many kinds, by name."""
    contacts = np.arange(BEADS - 1)
    found = {f"exponential {s:g}": np.full(BEADS - 1, s)
             for s in (-0.1, -0.04, -0.007, 0.0, 0.0015, 0.007, 0.015, 0.04, 0.1)}  # fmt: skip
    for slope in (0.02, 0.05, 0.1):
        found[f"backward-linear {slope:g}"] = np.diff(np.log(1 + slope * np.arange(BEADS)))
    for end in (-0.1, -0.02, 0.02, 0.1):
        found[f"rates from {-end:g} to {end:g}"] = np.linspace(-end, end, BEADS - 1)
    for size, period in (
        (0.005, 60), (0.01, 60), (0.02, 60), (0.05, 60), (0.1, 60), (0.02, 30), (0.05, 30),
        (0.1, 120),
    ):  # fmt: skip
        found[f"sine {size:g}, period {period}"] = size * np.sin(2 * np.pi * contacts / period)
    return found


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


def velocity_deviations(rates, scatter, chains, moduli):
    """Law minus ensemble of the mean ln v of all beads, its standard error, and the estimate."""
    chain = hc.Chain.from_radii(np.exp(np.concatenate(([0.0], np.cumsum(rates)))))
    law = hc.disorder(chain, **{"modulus_scatter" if moduli else "scatter": scatter})
    found = ensemble(chain.radii, deviations(scatter, chains), moduli)["velocity"]
    pairs = found.reshape(2, -1, BEADS).mean(axis=0)
    error = np.log(law.velocity) - found.mean(axis=0)
    return error, pairs.std(axis=0) / np.sqrt(len(pairs)), law.velocity_error


def estimates(chains):
    """Print the largest deviations of the mean velocity, and those relative to the estimate."""
    warnings.simplefilter("ignore", hc.ModelRangeWarning)
    print(f"{chains} chains each; deviations of the mean velocity of all beads, law minus ensemble")
    for kind, scatters in (("radii", SCATTERS), ("moduli", MODULUS_SCATTERS)):
        for name, rates in tapers_of_the_range().items():
            for scatter in scatters:
                error, uncertain, estimate = velocity_deviations(
                    rates, scatter, chains, kind == "moduli"
                )
                k = int(np.argmax(np.abs(error)))
                # The deviation may be larger by two standard errors.
                part = np.abs(error[1:]) / (estimate[1:] + 2.0 * uncertain[1:])
                print(f"{scatter:.1%} scatter of {kind}, {name:24} largest {100 * error[k]:+.4f}% "
                      f"(+-{100 * uncertain[k]:.4f}) at bead {k + 1}, estimate "
                      f"{100 * estimate[k]:.4f}%; at most {part.max():.2f} of the estimate and "
                      "two standard errors", flush=True)  # fmt: skip


if __name__ == "__main__":
    if sys.argv[1:2] == ["estimate"]:
        estimates(int(sys.argv[2]) if len(sys.argv) > 2 else 1500)
        raise SystemExit
    chains = int(sys.argv[1]) if len(sys.argv) > 1 else 4000
    print(f"{chains} chains each; the signs are those of law minus ensemble")
    results = {}
    for kind, scatters in (("radii", SCATTERS), ("moduli", MODULUS_SCATTERS)):
        for name in sys.argv[2:] or TAPERS:
            for scatter in scatters:
                found = compare(name, scatter, chains, kind == "moduli")
                results[kind, name, scatter] = found
                show(kind, name, scatter, found)
                sys.stdout.flush()
    summarize(results)

"""Tables of the disorder law, from ensembles: ``python tools/disorder_tables.py FOLDER [PAIRS]``.

Each ensemble has PAIRS pairs of exponential chains with opposite deviations, normally distributed;
all ensembles have the same deviations, in units of the scatter.  600 pairs take three minutes of
one core.
"""

import sys
from pathlib import Path

import numpy as np

import hertzchain as hc
from hertzchain.theory.disorder_table import END, MEANS, RATES, SCATTERS, SPREADS, START

BEADS = 84
# Scatter of moduli, of which the mean is of second order, and step of first derivatives.
MODULUS_SCATTER, STEP = 0.01, 1e-4
RTOL = 1e-7


def radii_table(rows, rtol=RTOL):
    """Logarithms of velocity, peak force and residence time, in units of R_1 = 1."""
    table = hc.propagate_many(rows, rtol=rtol, threads=1)
    size = np.log(rows[:, :1])
    return logarithms(table, 2.0 * size, size)


def modulus_table(radii, deviations, rtol=RTOL):
    """The same for deviations of the moduli."""
    chain, soft = hc.Chain.from_radii(radii), np.exp(-deviations)
    factors = 2.0 / (soft[:, :-1] + soft[:, 1:])
    chains = [chain.replace(stiffness=chain.stiffness * factor) for factor in factors]
    return logarithms(hc.propagate_many(chains, rtol=rtol, threads=1), 0.0, 0.0)


def logarithms(table, force_unit, time_unit):
    """Logarithms of the columns of a table, with units added."""
    force = np.log(table.stiffness) + 1.5 * np.log(table.peak_overlap) + force_unit
    return np.log(table.velocity), force, np.log(table.residence) + time_unit


def mean_row(columns, clean, scatter):
    """Mean loss of ln v per contact, and offsets of force and time, over the squared scatter."""
    velocity, force, time = (
        (found.mean(axis=0) - base[0]) / scatter**2
        for found, base in zip(columns, clean, strict=True)
    )
    within = slice(START, BEADS - 1 - END)
    parts = -np.diff(velocity), force - 1.2 * velocity[:-1], time + 0.2 * velocity[:-1]
    return [
        value
        for part in parts
        for value in (*part[:START], part[within].mean(), *part[BEADS - 1 - END :])
    ]


def spread_row(response, clean):
    """Variances over the squared scatter: those of early beads, from start and local beads."""
    velocity, force, time = (np.square(each) for each in response)
    near, within = slice(0, START), 60
    row = []
    for values, last in ((velocity, BEADS), (force, BEADS - 1)):
        row += [*values[:, 1 : START + 1].sum(axis=0), values[near, within].sum()]
        row += [values[START:, k].sum() for k in (within, *range(last - END, last))]
    # Effect of one bead on all residence times around it, in units of its own.
    own = np.exp(clean[2][0])
    delay = (response[2][40, 30:60] * own[30:60]).sum() / own[40]
    return [*row, delay**2, time[START:, within].sum()]


def main(folder, pairs):
    """Write both tables."""
    rng = np.random.default_rng(20260)
    lots = rng.standard_normal((pairs, BEADS))
    lots /= np.sqrt(np.mean(lots**2, axis=0))
    lots = np.concatenate((lots, -lots))
    means, spreads = [], []
    for rate in RATES:
        radii = np.exp(rate * np.arange(BEADS))
        clean = radii_table(radii[np.newaxis], 1e-10)
        for scatter in SCATTERS:
            found = radii_table(radii * np.exp(scatter * lots))
            means.append([rate, scatter, *mean_row(found, clean, scatter)])
        single = STEP * np.eye(BEADS)
        soft = modulus_table(radii, MODULUS_SCATTER * lots)
        means.append([rate, 0.0, *mean_row(soft, clean, MODULUS_SCATTER)])
        steps = single, -single
        changed = [radii_table(radii * np.exp(step), 1e-10) for step in steps]
        softened = [modulus_table(radii, step, 1e-10) for step in steps]
        for up, down in (changed, softened):
            response = [(a - b) / (2.0 * STEP) for a, b in zip(up, down, strict=True)]
            spreads.append([rate, *spread_row(response, clean)])
        print(rate, flush=True)
    write(folder / "means.csv", MEANS, means)
    write(folder / "spreads.csv", SPREADS, spreads)


def write(path, names, rows):
    """Write a table as CSV."""
    lines = [",".join(names), *(",".join(f"{value:.6g}" for value in row) for row in rows)]
    source = f"# Written by tools/disorder_tables.py, hertzchain {hc.__version__}."
    path.write_text("\n".join([source, *lines]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 600)

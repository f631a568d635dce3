"""Tables of the disorder law, from ensembles: ``python tools/disorder_tables.py FOLDER [PAIRS]``.

Each ensemble has PAIRS pairs of exponential chains with opposite deviations, normally distributed;
all ensembles have the same deviations, in units of the scatter.  600 pairs take three minutes of
one core.  With 0 pairs, only the tables of first derivatives are written.
"""

import sys
from pathlib import Path

import numpy as np

import hertzchain as hc
from hertzchain.theory.disorder_table import (
    DELAYED,
    DELAYS,
    END,
    MEANS,
    OFFSETS,
    RATES,
    SCATTERS,
    SPREADS,
    START,
)

BEADS = 84
# Scatter of moduli, of which the mean is of second order, and step of first derivatives.
MODULUS_SCATTER, STEP = 0.01, 1e-4
RTOL = 1e-7


def radius_table(radii, deviations, rtol=RTOL):
    """Logarithms of velocity, peak force and residence time, in the units of the nominal chain."""
    table = hc.propagate_many(radii * np.exp(deviations), rtol=rtol, threads=1)
    size = deviations[:, :1]
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


def spread_row(response):
    """Variances over the squared scatter: those of early beads, from start and local beads."""
    velocity, force = (np.square(each) for each in response[:2])
    near, within = slice(0, START), 60
    row = []
    for values, first, last in ((velocity, 1, BEADS), (force, 0, BEADS - 1)):
        row += [*values[:, first : START + first].sum(axis=0), values[near, within].sum()]
        row += [values[START:, k].sum() for k in (within, *range(last - END, last))]
    return row


def delay_row(response):
    """Derivatives of ln T with respect to the deviations of beads around the contact, by stage."""
    padded = np.pad(response, ((-OFFSETS[0], OFFSETS[-1]), (0, 0)))
    contacts = (*range(DELAYED), 40, BEADS - 2)
    rows = [padded[k : k + len(OFFSETS), k] for k in contacts]
    # Beads near the impact change all later residence times.
    return [*np.concatenate(rows), *response[: len(OFFSETS), 60]]


def main(folder, pairs):
    """Write the tables."""
    means, spreads, delays = [], [], []
    step = STEP * np.eye(BEADS)
    for rate in RATES:
        radii = np.exp(rate * np.arange(BEADS))
        if pairs:
            means += mean_rows(rate, radii, pairs)
        for table in (radius_table, modulus_table):
            up, down = table(radii, step, 1e-10), table(radii, -step, 1e-10)
            response = [(a - b) / (2.0 * STEP) for a, b in zip(up, down, strict=True)]
            spreads.append([rate, *spread_row(response)])
            delays.append([rate, *delay_row(response[2])])
        print(rate, flush=True)
    if pairs:
        write(folder / "means.csv", MEANS, means)
    write(folder / "spreads.csv", SPREADS, spreads)
    write(folder / "delays.csv", DELAYS, delays)


def mean_rows(rate, radii, pairs):
    """Rows of means at one rate: one for each scatter of radii, and one for moduli."""
    lots = np.random.default_rng(20260).standard_normal((pairs, BEADS))
    lots /= np.sqrt(np.mean(lots**2, axis=0))
    lots = np.concatenate((lots, -lots))
    clean = radius_table(radii, np.zeros((1, BEADS)), 1e-10)
    found = []
    for scatter in SCATTERS:
        table = radius_table(radii, scatter * lots)
        found.append([rate, scatter, *mean_row(table, clean, scatter)])
    soft = modulus_table(radii, MODULUS_SCATTER * lots)
    return [*found, [rate, 0.0, *mean_row(soft, clean, MODULUS_SCATTER)]]


def write(path, names, rows):
    """Write a table as CSV."""
    lines = [",".join(names), *(",".join(f"{value:.6g}" for value in row) for row in rows)]
    source = f"# Written by tools/disorder_tables.py, hertzchain {hc.__version__}."
    path.write_text("\n".join([source, *lines]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 600)

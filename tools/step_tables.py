"""Table of the effects of steps and odd beads: ``python tools/step_tables.py FILE``.

Each entry compares the simulated pulse of a chain with a step of the radius, between two
exponential parts, with that of the chain without the step, beads after the step being measured in
their own units.  About one minute.
"""

import sys

import numpy as np

import hertzchain as hc
from hertzchain.theory.step_table import AFTER, BEFORE, LOG_RATIOS, RATES

FIRST, BEADS = 36, 110


def columns(log_radii, unit):
    """Logarithms of velocity and overlap, and residence times, in the units of the beads."""
    table = hc.propagate_many(np.exp(log_radii), rtol=1e-9, threads=1)
    contacts = slice(FIRST - BEFORE, FIRST + AFTER)
    velocity = np.log(table.velocity[:, 1:])
    overlap, time = np.log(table.peak_overlap) - unit, table.residence * np.exp(-unit)
    return np.stack([each[:, contacts] for each in (velocity, overlap, time)], axis=1)


def smooth(before, after):
    """Logarithms of the radii of two exponential parts, with the mean rate between them."""
    rates = np.full(BEADS - 1, after)
    rates[: FIRST - 1] = before
    rates[FIRST - 1] = 0.5 * (before + after)
    return np.concatenate(([0.0], np.cumsum(rates)))


def effect(before, after, ratios, shape):
    """Effect of all steps, or odd beads, between two rates."""
    clean = smooth(before, after)
    unit = np.array(ratios)[:, np.newaxis] * shape
    found = columns(clean + unit, unit[:, :-1])
    base = columns(clean[np.newaxis], 0.0)
    # Beads may be passed out of order, with negative residence times.
    return np.concatenate((found[:, :2] - base[:, :2], found[:, 2:] / base[:, 2:]), axis=1)


def main(path):
    """Write the table."""
    bead = np.arange(BEADS)
    step, odd = 1.0 * (bead >= FIRST), 1.0 * (bead == FIRST)
    tables = {
        name: np.float32([[effect(a, b, LOG_RATIOS, shape) for b in RATES] for a in RATES])
        for name, shape in (("step", step), ("odd", odd))
    }
    np.savez_compressed(path, **tables)


if __name__ == "__main__":
    main(sys.argv[1])

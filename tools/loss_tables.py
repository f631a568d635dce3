"""Tables of the local-rate law with loss: ``python tools/loss_tables.py FILE``.

For each law, exponential chains determine the effect of the loss after the impact, within the
chain and at its end; the response to changes of the rate is fitted to random smooth tapers, and the
estimate of the error to others.  All random numbers have fixed seeds.
"""

import dataclasses
import sys
import time

import numpy as np
from loss_anchors import anchors
from loss_chains import random_samples
from training.error_fit import quantile_fit

from hertzchain.theory.loss_table import (
    INPUTS,
    LossTable,
    inputs,
    rate_polynomials,
    strength_polynomials,
)
from hertzchain.theory.lossy_law import OVERTAKEN, effect_along, error_parts
from hertzchain.theory.tabulated_losses import LAWS

# Degrees + 1 of the response, in the rate and in the strength.
RESPONSE = (5, 3)
# Numbers of random chains by their beads: for the response, and for the estimate of the error.
TRAINING = {20: 200, 40: 250, 100: 900, 150: 100}
OTHERS = {20: 120, 40: 120, 100: 360, 150: 100}
# Chains that are fitted at once, to save memory.
TOGETHER = 100
# Errors that concern few chains, and are not fitted: per contact where the tail overtakes the
# pulse, at the largest strength, and by rates outside the tables, per strength.
TAIL, OUTSIDE = 0.006, 3.0
# Fast changes with a strong loss are rare among these chains: the terms of changes are enlarged.
SAFETY = np.array([1.0, 1.3, 1.3, 1.3])
COVERED = 0.975
# The law that has the response of the one before.
WITHOUT_PULL = "restitution without pull"


class Group:
    """Chains of one length: inputs of the response, what they have to explain, and weights."""

    def __init__(self, table, samples):
        rates, x, effects = (
            np.array([getattr(each, name) for each in samples])
            for name in ("rates", "strength", "changes")
        )
        self.rest = effects - table.effect(table.series(rates), x)
        polynomials = np.einsum(
            "nka,nkb,nk->nkab",
            rate_polynomials(rates, RESPONSE[0]),
            strength_polynomials(x, table.largest, RESPONSE[1]),
            x,
        )
        design = np.einsum("nfk,nkab->nkfab", inputs(rates), polynomials)
        self.design = design.reshape(*rates.shape, -1)
        self.weights = np.ones(len(samples))

    def errors(self, growth):
        """Largest errors of the velocities of each chain."""
        return np.abs(np.cumsum(self.rest[:, 0] - self.design @ growth, axis=1)).max(axis=1)


def response(table, samples):
    """Fit the response to the velocities along random tapers, and to their contacts."""
    groups = [
        Group(table, chains[first : first + TOGETHER])
        for chains in samples
        for first in range(0, len(chains), TOGETHER)
    ]
    for _ in range(5):
        growth = weighted(groups, 0, accumulate=True)
        for group in groups:
            error = group.errors(growth)
            # Chains whose pulse is overtaken by its tail do not count.
            group.weights = np.where(error < 0.1, 1e-3 / (1e-3 + error), 0.0)
    others = [weighted(groups, c, accumulate=False) for c in (1, 2)]
    found = np.array([growth, *others]).reshape(3, INPUTS, *RESPONSE)
    return found, np.concatenate([group.errors(growth) for group in groups])


def weighted(groups, component, *, accumulate):
    """Least squares of contacts and, if requested, of sums along the chain."""
    size = groups[0].design.shape[-1]
    matrix, right = np.zeros((size, size)), np.zeros(size)
    for group in groups:
        for sums, factor in ((False, 3.0), (True, 1.0))[: 1 + accumulate]:
            both = group.design, group.rest[:, component]
            rows, to = (np.cumsum(each, axis=1) if sums else each for each in both)
            scale = factor * group.weights
            flat = (rows * scale[:, np.newaxis, np.newaxis]).reshape(-1, size)
            matrix += flat.T @ flat
            right += flat.T @ (to * scale[:, np.newaxis]).ravel()
    ridge = 1e-9 * np.trace(matrix) / size * np.eye(size)
    return np.linalg.solve(matrix + ridge, right)


def parts_and_errors(name, table, samples):
    """Parts of the estimate and errors of the law, before the tail overtakes."""
    parts, errors = [], []
    for each in samples:
        log_velocity = each.log_velocity
        x, effect = effect_along(table, LAWS[name], each.coefficients, each.rates, log_velocity)
        decay = np.cumsum(effect[0])
        after = log_velocity + np.concatenate(([0.0], decay))
        part, relative = error_parts(each.rates, x, table.largest, after)
        before = np.cumprod(relative < OVERTAKEN).astype(bool)
        parts.append(part[:, before].T)
        errors.append(np.abs(np.expm1(decay - np.cumsum(each.changes[0])))[before])
    return np.concatenate(parts), np.concatenate(errors)


def estimate(name, table, samples):
    """Constants of the estimated error, from chains that were not used for the response."""
    part, error = parts_and_errors(name, table, samples)
    constants = np.append(SAFETY * quantile_fit(part[:, :-2], error, COVERED), (TAIL, OUTSIDE))
    estimated = part @ constants
    covered, ratio = np.mean(error <= estimated), np.median(estimated / error)
    print(
        f"covered {covered:.2%}, median ratio of estimate to error {ratio:.1f}, largest of error "
        f"to estimate {np.max(error / estimated):.1f};",
        constants.round(5),
        flush=True,
    )
    return constants


def trained(name, start, end):
    """Response and error constants of a law."""
    blank = np.zeros((3, INPUTS, *RESPONSE))
    table = LossTable(LAWS[name].largest, start, end, blank, np.zeros(0))
    found, error = response(table, draw(name, 14, TRAINING))
    print(name, "response, largest errors of chains: 50, 90, 95, 100%",
          np.quantile(error, (0.5, 0.9, 0.95, 1.0)).round(5), flush=True)  # fmt: skip
    table = dataclasses.replace(table, response=found)
    others = [each for chains in draw(name, 15, OTHERS) for each in chains]
    return {"response": found, "error": estimate(name, table, others)}


def draw(name, seed, numbers):
    """Random samples, as one list for each length."""
    random = np.random.default_rng(seed)
    return [random_samples(name, random, count, beads) for beads, count in numbers.items()]


def main(path):
    """Write the tables."""
    stored = {}
    for name, law in LAWS.items():
        start, end = anchors(name)
        if name != WITHOUT_PULL:
            # For these losses, it hardly matters whether contacts may pull.
            fitted = trained(name, start, end)
        parts = {"anchors": start, "end": end, **fitted}
        stored |= {f"{name}/{key}": value.astype(np.float32) for key, value in parts.items()}
        stored[f"{name}/largest"] = np.array(law.largest)
        np.savez_compressed(path, **stored)
        print(f"{name}: {time.process_time():.0f} s in total", flush=True)


if __name__ == "__main__":
    main(sys.argv[1])

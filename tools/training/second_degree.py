"""Fit the response to products of two fast changes, and of a fast and the slow change.

Two kinds of equations determine it: the states of random chains, and the derivatives of the states
of other random chains with respect to all rates.  States alone do not: a response that reaches too
far explains them as well, but has wrong derivatives.  Derivatives alone do not, either: in chains
whose rates change quickly all along, small errors of all contacts add up.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.interpolate import BSpline

from hertzchain.collision import Array
from hertzchain.kernels import local_rate_pulse as kernel
from hertzchain.kernels.fast_changes import (
    AHEAD,
    BEHIND,
    EARLY,
    END,
    FACTORS,
    FIRST,
    LARGE,
    LAST,
    NEAR,
    PAIRS,
    PRODUCTS,
    RISING,
    STAGES,
    STATES,
    TAPS,
    TINY,
)
from hertzchain.theory.universal_functions import START, UniversalFunctions, padded_knots

from .sensitivities import Sensitivity, law_slopes, law_states, of_radii

# Beyond the last knot, the response is zero.
KNOTS: Final = np.array(
    [-0.15, -0.1, -0.07, -0.045, -0.025, -0.01, 0.0, 0.01, 0.025, 0.05, 0.1, 0.2]
)
# Those of single stages are differences from that within, which is determined by more chains.
RIDGE, RIDGE_OF_STAGE = 1e-4, 1e-3
# Weight of the differences between coefficients of neighbouring B-splines.
SMOOTH: Final = 2e-3
# Mean square of fast changes below which errors are negligible.
FLOOR: Final = 1e-5
# The sum of the growth over contacts is fitted, too, at every eighth contact, with this weight.
SUMMED: Final = 8
WEIGHT_OF_SUMS: Final = 0.35
# Weights of the derivatives with respect to the radii, and of their sums over contacts, which are
# those of the velocity, relative to one that decreases with the size of fast changes; and weight
# of the states of these chains.
OF_SLOPES, OF_SUMS, OF_STATES, SIZE = 1.0, 0.5, 20.0, 0.004
SUMMED_SLOPES: Final = 3
# Step of the derivatives of slow and fast rates.
STEP: Final = 1e-6
# First contacts with products of their own.
FIRST_CONTACTS: Final = 10
# Contacts that are neither affected by the impact nor by the free end.
INSIDE: Final = slice(EARLY + 2, -END - 1)
# Larger errors of a contact are not those of a second degree, nor are those of its derivatives.
LARGEST, LARGEST_SLOPE = 0.3, 1.0
Equations = tuple[Array, Array]


@dataclass(frozen=True, eq=False)
class Chains:
    """Rates and simulated states of chains, and the weight of their equations."""

    rates: Sequence[Array]
    states: Sequence[Array]
    weight: float = 1.0


def surroundings(fast: Array) -> Array:
    """Fast changes around each contact, (M, offsets, ...), from those of the chain."""
    padded = np.pad(fast, [(BEHIND, AHEAD), *[(0, 0)] * (fast.ndim - 1)])
    return np.stack([padded[i : i + len(fast)] for i in range(TAPS)], axis=1)


def rises(slow: Array) -> Array:
    """Mean change of the slow rate near each contact."""
    k = np.arange(len(slow))
    begin, end = np.maximum(k - RISING, 0), np.minimum(k + AHEAD, len(slow) - 1)
    return np.asarray((slow[end] - slow[begin]) / (end - begin).reshape(-1, *[1] * (slow.ndim - 1)))


def splines_of(slow: Array, knots: Array) -> tuple[Array, Array]:
    """Values of B-splines at the slow rates and their derivatives, (M, splines)."""
    flat, padded = np.clip(slow, knots[0], knots[-1]), padded_knots(knots)
    basis = BSpline(padded, np.eye(len(knots) + 2), 3)
    slopes = basis(flat, nu=1) * ((knots[0] < slow) & (slow < knots[-1]))[:, None]
    return basis(flat)[:, :-1], slopes[:, :-1]


def gains(slow: Array, size: Array, steady: float) -> tuple[Array, Array, Array]:
    """Factor of the products of two fast changes, and its derivatives, see the kernel."""
    sum_of, limit = 4.0 * slow**2 + size + TINY, 1.0 + size / LARGE
    value = sum_of**0.25 * limit**-1.25
    by_size = value * (0.25 / sum_of - 1.25 / (LARGE * limit)) - steady / (LARGE * limit**2)
    return value + steady / limit, value * 2.0 * slow / sum_of, by_size


def terms(slow: Array, fast: Array, knots: Array, steady: float) -> tuple[Array, Array]:
    """Products with their gain, (M, 35), and values of B-splines."""
    around = surroundings(fast)
    gain = gains(slow, (around[:, FIRST:LAST] ** 2).mean(axis=1), steady)[0]
    i, j = np.triu_indices(FACTORS)
    near = around[:, NEAR:]
    pairs = gain[:, None] * near[:, i] * near[:, j]
    return np.hstack([pairs, rises(slow)[:, None] * near]), splines_of(slow, knots)[0]


def slopes_of_terms(rates: Array, knots: Array, steady: float) -> Equations:
    """Products times B-splines, (M, unknowns), and their derivatives, (M, unknowns, M)."""
    slow, fast = divided(rates)
    moved = [divided(rates + step) + divided(rates - step) for step in STEP * np.eye(len(rates))]
    by_slow = np.array([(a - c) / (2.0 * STEP) for a, _, c, _ in moved]).T
    by_fast = np.array([(b - d) / (2.0 * STEP) for _, b, _, d in moved]).T
    around, to_around = surroundings(fast), surroundings(by_fast)
    size = (around[:, FIRST:LAST] ** 2).mean(axis=1)
    to_size = 2.0 * (around[:, FIRST:LAST, None] * to_around[:, FIRST:LAST]).mean(axis=1)
    gain, by_rate, by_size = gains(slow, size, steady)
    to_gain = by_rate[:, None] * by_slow + by_size[:, None] * to_size
    i, j = np.triu_indices(FACTORS)
    near, to_near = around[:, NEAR:], to_around[:, NEAR:]
    to_pairs = near[:, i, None] * to_near[:, j] + near[:, j, None] * to_near[:, i]
    to_pairs = gain[:, None, None] * to_pairs
    to_pairs += (near[:, i] * near[:, j])[..., None] * to_gain[:, None]
    to_rises = rises(slow)[:, None, None] * to_near + near[..., None] * rises(by_slow)[:, None]
    values, splines = terms(slow, fast, knots, steady)
    _, bends = splines_of(slow, knots)
    slopes = np.concatenate([to_pairs, to_rises], axis=1)[:, :, None] * splines[:, None, :, None]
    slopes += (values[:, :, None] * bends[:, None])[..., None] * by_slow[:, None, None]
    spread = values[:, :, None] * splines[:, None]
    return spread.reshape(len(rates), -1), slopes.reshape(len(rates), -1, len(rates))


def divided(rates: Array) -> tuple[Array, Array]:
    """Slow and fast parts of the rates."""
    slow, fast = kernel.divide(rates, len(rates))
    return slow, fast[BEHIND : BEHIND + len(rates)]


def value_equations(functions: UniversalFunctions, chains: Chains, count: int) -> Equations:
    """Normal equations of the states of random chains, for so many products."""
    knots, steady = functions.fast.knots, functions.fast.steady
    unknowns = count * (len(knots) + 1)
    matrix, right = np.zeros((unknowns, unknowns)), np.zeros((unknowns, STATES))
    used = slice(START, -END)
    for row, true in zip(chains.rates, chains.states, strict=True):
        rest = true - law_states(functions, row)
        if np.abs(rest).max() > LARGEST:
            continue
        slow, fast = divided(row)
        products, splines = terms(slow, fast, knots, steady)
        products = products[used, :count]
        equations = (products[:, :, None] * splines[used, None, :]).reshape(-1, unknowns)
        weight = 1.0 / (FLOOR + np.mean(fast**2))
        for part, value, factor in (
            (equations, rest[used], weight),
            (
                np.cumsum(equations, axis=0)[SUMMED - 1 :: SUMMED],
                np.cumsum(rest[used], axis=0)[SUMMED - 1 :: SUMMED],
                WEIGHT_OF_SUMS * weight,
            ),
        ):
            matrix += factor**2 * part.T @ part
            right += factor**2 * part.T @ value
    return chains.weight * matrix, chains.weight * right


def slope_weight(fast: Array) -> float:
    """Weight of the equations of a chain, larger if its fast changes are small."""
    return float(1.0 / (SIZE * (SIZE + np.sqrt(np.mean(fast**2)))))


def slope_equations(functions: UniversalFunctions, chains: Sequence[Sensitivity]) -> Equations:
    """Normal equations of the derivatives within the chains."""
    knots, steady = functions.fast.knots, functions.fast.steady
    unknowns = PRODUCTS * (len(knots) + 1)
    matrix, right = np.zeros((unknowns, unknowns)), np.zeros((unknowns, STATES))
    every = slice(SUMMED_SLOPES - 1, None, SUMMED_SLOPES)
    for chain in chains:
        rest = chain.less(law_slopes(functions, chain.rates))
        if not sound(rest, INSIDE):
            continue
        weight = slope_weight(divided(chain.rates)[1])
        values, slopes = slopes_of_terms(chain.rates, knots, steady)
        part, value = of_radii(slopes)[INSIDE], of_radii(rest.slopes)[INSIDE]
        for left, wanted, factor in (
            (part, value, OF_SLOPES),
            (np.cumsum(part, axis=0)[every], np.cumsum(value, axis=0)[every], OF_SUMS),
            (values[INSIDE, :, None], rest.states[INSIDE, :, None], OF_STATES),
        ):
            flat = np.moveaxis(left, 1, 0).reshape(unknowns, -1) * (factor * weight)
            matrix += flat @ flat.T
            right += flat @ np.moveaxis(wanted, 1, 0).reshape(STATES, -1).T * (factor * weight)
    return matrix, right


def sound(rest: Sensitivity, part: slice) -> bool:
    """Whether the law describes a chain so well that the rest is of second degree."""
    small = np.abs(rest.states[part]).max() < LARGEST
    return bool(small and np.abs(rest.slopes[part]).max() < LARGEST_SLOPE)


def solve_normal(matrix: Array, right: Array, ridge: float) -> Array:
    """Solution of normal equations with a ridge relative to their diagonal.

    Coefficients of neighbouring B-splines are similar: where there are few chains, at the ends of
    the tables, a function is nearly constant.
    """
    scale = np.sqrt(np.diag(matrix))
    scale += 1e-3 * scale.max()
    normal = matrix / scale[:, None] / scale + ridge * np.eye(len(scale))
    splines = len(KNOTS) + 1
    largest = scale.reshape(-1, splines).max(axis=1)
    step = np.diff(np.eye(splines), axis=0)
    for first, size in zip(range(0, len(scale), splines), largest, strict=True):
        part = slice(first, first + splines)
        relative = step * (size / scale[part])
        normal[part, part] += SMOOTH * relative.T @ relative
    return np.asarray(np.linalg.solve(normal, right / scale[:, None]) / scale[:, None])


def fit(
    functions: UniversalFunctions, values: Sequence[Chains], sloped: Sequence[Sensitivity] = ()
) -> Array:
    """Coefficients of B-splines for functions that have none yet.

    From states alone, those of products of two fast changes, (splines, 84), which are used for all
    stages; with derivatives, those of the slow change, too, for each stage, (splines, 1890).
    """
    count = PRODUCTS if sloped else PAIRS
    equations = [value_equations(functions, chains, count) for chains in values]
    if sloped:
        equations.append(slope_equations(functions, sloped))
    matrix, right = (sum(each[i] for each in equations) for i in (0, 1))
    within = _arranged(solve_normal(matrix, right, RIDGE))
    return np.tile(within, (1, STAGES)) if sloped else within


def _arranged(found: Array) -> Array:
    """Coefficients (splines, 3 products) with those beyond the last knot, from the unknowns."""
    splines = len(KNOTS) + 1
    # From (products, splines, states).
    shaped = np.moveaxis(found.reshape(-1, splines, STATES), (1, 2, 0), (0, 1, 2))
    return np.concatenate([shaped.reshape(splines, -1), np.zeros((1, found.size // splines))])


def fit_stages(
    functions: UniversalFunctions,
    second: Array,
    chains: Sequence[Sensitivity],
    starting: Chains | None = None,
) -> Array:
    """Add to the coefficients ``second`` what the first contacts and the fifth last one lack.

    The states of the first contacts of chains that are ``starting`` with quick changes count, too.
    """
    knots, steady = functions.fast.knots, functions.fast.steady
    unknowns = PRODUCTS * (len(knots) + 1)
    # The last four contacts have functions of their own.
    contacts, stages = [*range(FIRST_CONTACTS), -END], [*range(FIRST_CONTACTS), STAGES - END]
    matrix = np.zeros((len(contacts), unknowns, unknowns))
    right = np.zeros((len(contacts), unknowns, STATES))
    for chain in chains:
        rest = chain.less(law_slopes(functions, chain.rates))
        weight = slope_weight(divided(chain.rates)[1])
        values, slopes = slopes_of_terms(chain.rates, knots, steady)
        for at, k in enumerate(contacts):
            part = slice(k, k + 1)
            if not sound(rest, part):
                continue
            for left, wanted, factor in (
                (of_radii(slopes[k]), of_radii(rest.slopes[k]), OF_SLOPES),
                (values[k, :, None], rest.states[k, :, None], OF_STATES),
            ):
                matrix[at] += (factor * weight) ** 2 * left @ left.T
                right[at] += (factor * weight) ** 2 * left @ wanted.T
    if starting is not None:
        add_starting(functions, starting, matrix, right)
    found = second.reshape(len(second), STAGES, -1).copy()
    for at, stage in enumerate(stages):
        found[:, stage] += _arranged(solve_normal(matrix[at], right[at], RIDGE_OF_STAGE))
    return found.reshape(second.shape)


def add_starting(
    functions: UniversalFunctions, chains: Chains, matrix: Array, right: Array
) -> None:
    """Add the normal equations of the states of the first contacts."""
    knots, steady = functions.fast.knots, functions.fast.steady
    for rates, states in zip(chains.rates, chains.states, strict=True):
        rest = states - law_states(functions, rates)
        slow, fast = divided(rates)
        values, splines = terms(slow, fast, knots, steady)
        factor = chains.weight * (OF_STATES * slope_weight(fast)) ** 2
        for k in range(FIRST_CONTACTS):
            if np.abs(rest[k]).max() > LARGEST:
                continue
            equation = (values[k][:, None] * splines[k]).ravel()
            matrix[k] += factor * equation[:, None] * equation
            right[k] += factor * equation[:, None] * rest[k]

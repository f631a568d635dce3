"""Tables of the local-rate law with loss, which `tools/loss_tables.py` writes."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.polynomial.chebyshev import chebvander

from ..collision import Array
from .table_files import stored_arrays

# Rates of the tables.
RATES: Final = (-0.1, 0.12)
# Contacts that depend on the impact and on the free end.
START, END = 40, 2
# Factors by which the memory of a change of the rate decays per contact.
MEMORIES: Final = (0.0, 0.4, 0.6, 0.8)
# Inputs of the response: memories, rates ahead, products of memories, and memories that matter
# less with the distance from the impact, by a factor per contact.
AHEAD, PRODUCTS, NEAR_IMPACT, FADING = 2, ((2, 2), (0, 2), (3, 3)), (0, 2), 0.75
INPUTS: Final = len(MEMORIES) + AHEAD + len(PRODUCTS) + len(NEAR_IMPACT)


@dataclass(frozen=True, eq=False)
class LossTable:
    r"""Effect of a law of loss, as Chebyshev series in the rate s and the strength x of the loss.

    The three components are the changes of the growth of ln v, and of the logarithms of overlap
    and residence time in units formed from mass, velocity and stiffness, divided by x.

    Attributes
    ----------
    largest : float
        Largest strength x.
    anchors : ndarray, shape (40, 3, a, b)
        Effect at each contact of an exponential chain; the last one holds for all others.
    end : ndarray, shape (2, 3, a, b)
        Effect of the free end on the last contacts.
    response : ndarray, shape (3, inputs, c, d)
        Response to the inputs of `inputs`.
    error : ndarray, shape (parts,)
        Constants of the error estimate.
    """

    largest: float
    anchors: Array
    end: Array
    response: Array
    error: Array

    def series(self, rates: Array) -> Array:
        """Chebyshev series in the strength of the three components at all contacts.

        Rates have the shape (..., contacts), the result the shape (..., 3, contacts, b).
        """
        contacts = rates.shape[-1]
        table = self.anchors[np.minimum(np.arange(contacts), START - 1)]
        table[contacts - END :] += self.end
        of_rate = rate_polynomials(rates, table.shape[2])
        found = np.einsum("kcab,...ka->...ckb", table, of_rate)
        size, degree = self.response.shape[2:]
        found[..., :degree] += np.einsum(
            "cfab,...fk,...ka->...ckb",
            self.response,
            inputs(rates),
            of_rate[..., :size],
            optimize=True,
        )
        return found

    def effect(self, series: Array, strength: Array) -> Array:
        """Changes of the three components by a loss with strengths of shape (..., contacts)."""
        limited = np.minimum(strength, self.largest)
        of_strength = strength_polynomials(limited, self.largest, series.shape[-1])
        found = np.einsum("...ckb,...kb->...ck", series, of_strength)
        return np.asarray(found * strength[..., np.newaxis, :])


def inputs(rates: Array) -> Array:
    """Inputs of the response: sums of changes of the rate, and their products."""
    contacts = rates.shape[-1]
    changes = np.diff(rates, axis=-1)
    memories = np.zeros((len(MEMORIES), *rates.shape))
    factors = np.reshape(MEMORIES, (-1, *[1] * (rates.ndim - 1)))
    for k in range(1, contacts):
        memories[..., k] = factors * memories[..., k - 1] + changes[..., k - 1]
    ahead = np.zeros((AHEAD, *rates.shape))
    for i in range(AHEAD):
        ahead[i, ..., : contacts - 1 - i] = changes[..., i:]
    products = [memories[one] * memories[other] for one, other in PRODUCTS]
    near = FADING ** np.arange(contacts)
    start = [memories[i] * near for i in NEAR_IMPACT]
    return np.stack([*memories, *ahead, *products, *start], axis=-2)


def rate_polynomials(rates: Array, count: int) -> Array:
    """Chebyshev polynomials of the rate, which is limited to the range of the tables."""
    low, high = RATES
    place = (2.0 * np.clip(rates, low, high) - low - high) / (high - low)
    return np.asarray(chebvander(place, count - 1))


def strength_polynomials(strength: Array, largest: float, count: int) -> Array:
    """Chebyshev polynomials of the strength of the loss, from zero to the largest one."""
    return np.asarray(chebvander(2.0 * strength / largest - 1.0, count - 1))


@functools.cache
def loss_tables() -> dict[str, LossTable]:
    """Tables by the name of the law; see `hertzchain.theory.lossy_law.LAWS`."""
    parts: dict[str, dict[str, Array]] = {}
    for key, values in stored_arrays("loss_table.npz").items():
        law, name = key.split("/")
        parts.setdefault(law, {})[name] = values
    return {
        law: LossTable(largest=float(part.pop("largest")), **part) for law, part in parts.items()
    }

"""Tables in a form that compresses well, to a given accuracy.

Numbers are rounded to multiples of a step.  Those of a table are smooth functions of the rate, so
that the second differences of these multiples are small.  Their signs are folded into the lowest
bit, and their bytes are stored one after the other: most of the higher ones are zero.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..collision import Array

# Degree of the differences.
DEGREE: Final = 2
# Steps of all tables.  Changes of the rate are below 0.1 and mostly below 0.01: the effect
# on the growth is below 1e-7.
STEPS: Final = {
    "values": 1e-9, "early": 1e-8, "single": 2e-6, "end": 2e-6, "end_slopes": 1e-5, "short": 2e-6,
    "second": 1e-3, "last": 1e-3, "linear": 1e-5, "products": 1e-3, "alternating": 1e-6,
}  # fmt: skip
Bytes = NDArray[np.unsignedinteger[Any]]


def pack(values: Array, step: float, axis: int) -> Bytes:
    """Bytes of the multiples of the step, (bytes, ...), with the differenced axis last."""
    found = np.moveaxis(np.rint(values / step).astype(np.int64), axis, -1)
    for _ in range(DEGREE):
        found = np.diff(found, axis=-1, prepend=0)
    folded = np.ascontiguousarray((found << 1) ^ (found >> 63)).astype("<u8")
    planes = np.moveaxis(folded[..., None].view(np.uint8), -1, 0)
    used = np.flatnonzero(planes.reshape(len(planes), -1).any(axis=1))
    return np.ascontiguousarray(planes[: 1 + used.max(initial=0)])


def unpack(planes: Bytes, step: float, axis: int) -> Array:
    """Numbers that were packed."""
    padded = np.zeros((*planes.shape[1:], 8), np.uint8)
    padded[..., : len(planes)] = np.moveaxis(planes, 0, -1)
    folded = padded.view("<u8")[..., 0]
    found = (folded >> 1).astype(np.int64) ^ -(folded & 1).astype(np.int64)
    for _ in range(DEGREE):
        found = np.cumsum(found, axis=-1)
    return np.moveaxis(found * step, -1, axis)

r"""Forces of elastic contacts, for several chains side by side.

.. math:: F_c = k_c \, d_c^{\,p_c} , \qquad d_c = x_c - x_{c+1} + d_c(0)

Exponents may differ between contacts.  Overlaps below `LEAST` give no force: the foot of a pulse
decays doubly exponentially, and the processor is slow with such small numbers.
"""

from __future__ import annotations

import math

import numpy as np

from .compilation import CONTRACTED, internal
from .elastic_layout import (
    AT_REST,
    BODY,
    EXPONENT,
    FORCE,
    INVERSE_MASS,
    LANES,
    NEAR,
    STIFFNESS,
    WORK,
    V,
    X,
)
from .powers import BIAS, MANTISSA, ONE, ROOT_2, SHIFT, exp2, log2

compiled = internal(**CONTRACTED)
inlined = internal(forceinline=True, **CONTRACTED)

LEAST = 1e-40


@compiled
def raise_overlaps(w, count):
    """Replace overlaps in the row of forces by forces, by the series of `powers`."""
    bits = w.view(np.int64)
    for i in range(count):
        b = bits[FORCE + i]
        bits[WORK + i] = (b & MANTISSA) | ONE
        bits[NEAR + i] = (b >> SHIFT) - BIAS
    for i in range(count):
        p, e, m = w[EXPONENT + i], float(bits[NEAR + i]), w[WORK + i]
        upper = np.float64(np.float32(p))
        large = m > ROOT_2
        m, e = 0.5 * m if large else m, e + 1.0 if large else e
        log = log2(m)
        n = np.floor(upper * e + p * log + 0.5)
        w[WORK + i] = exp2((upper * e - n) + ((p - upper) * e + p * log))
        n = BIAS if n > BIAS else n
        bits[NEAR + i] = (int(-BIAS if n < -BIAS else n) + BIAS) << SHIFT
    for i in range(count):
        push = w[STIFFNESS + i] * (w[WORK + i] * w[NEAR + i])
        w[FORCE + i] = push if w[FORCE + i] > LEAST else 0.0


@compiled
def general_forces(w, beads, at):
    """`press` for any exponents."""
    size = (beads + 1) * LANES
    for i in range(size):
        w[FORCE + i] = w[AT_REST + i] + (w[at + i] - w[at + LANES + i])
    raise_overlaps(w, size)


@inlined
def press_hertz(w, i, at):
    """Compute the force of a Hertz contact at the positions in row ``at``."""
    d = w[AT_REST + i] + (w[at + i] - w[at + LANES + i])
    d = d if d > LEAST else 0.0
    w[FORCE + i] = w[STIFFNESS + i] * (d * math.sqrt(d))


@inlined
def press(w, beads, at, hertz):
    """Compute contact forces at the positions in row ``at``."""
    if not hertz:
        general_forces(w, beads, at)
        return
    for i in range((beads + 1) * LANES):
        press_hertz(w, i, at)


@inlined
def acceleration(w, i):
    """Acceleration of a bead by the forces of its contacts."""
    return (w[FORCE + i] - w[FORCE + LANES + i]) * w[INVERSE_MASS + i] + w[BODY + i]


@compiled
def force_of(w, at, overlap):
    """Force of the contact at an entry of the rows, at an overlap."""
    if not overlap > LEAST:
        return 0.0
    if w[EXPONENT + at] == 1.5:
        return w[STIFFNESS + at] * (overlap * math.sqrt(overlap))
    return w[STIFFNESS + at] * overlap ** w[EXPONENT + at]


@compiled
def force_rate(w, at, x, v):
    """Rate of a contact's force, at the positions and velocities in rows x and v."""
    overlap = w[AT_REST + at] + (w[x + at] - w[x + LANES + at])
    if not overlap > LEAST:
        return 0.0
    closing = w[v + at] - w[v + LANES + at]
    return w[EXPONENT + at] * force_of(w, at, overlap) / overlap * closing


@compiled
def overlap_of(w, at):
    """Present overlap of a contact; negative if it is open."""
    return w[AT_REST + at] + (w[X + at] - w[X + LANES + at])


@compiled
def closing_of(w, at):
    """Present closing speed of a contact."""
    return w[V + at] - w[V + LANES + at]

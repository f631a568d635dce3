r"""Discrete adjoint of RKN8(6) steps of an elastic chain.

A step from (x, v) has the stages :math:`f_s = f(x + c_s h v + h^2 \sum_j a_{sj} f_j)`.  With the
derivatives :math:`\lambda_x, \lambda_v` of a quantity with respect to the state at its end,

.. math::

    w_s = h^2 b_s \lambda_x + h b'_s \lambda_v + h^2 \sum_{j>s} a_{js} \xi_j, \qquad
    \xi_s = J_s^T w_s, \qquad
    \lambda_x \mathrel{+}= \sum_s \xi_s, \qquad
    \lambda_v \mathrel{+}= h \lambda_x + h \sum_s c_s \xi_s ,

where J is the Jacobian of f with respect to the positions.  The step contributes
:math:`\sum_s w_s \cdot \partial f_s/\partial p` to the derivative with respect to a parameter p.
"""

from __future__ import annotations

from .adjoint_damped import reverse_damped
from .adjoint_layout import (
    AT_RELEASE,
    BY_BODY,
    BY_MASS,
    BY_OVERLAP,
    BY_STIFFNESS,
    EXPONENT,
    FACTOR,
    INVERSE_MASS,
    LV,
    LX,
    ROW,
    STIFFNESS,
    TRANSFER,
    XI0,
    U,
)
from .adjoint_release import reverse_release
from .adjoint_step import compiled, entry_point, inlined
from .adjoint_window import WINDOW
from .powers import power
from .rkn8 import A1, A2, A3, A4, A5, A6, A7, B_POSITION, B_VELOCITY, C1, C2, C3, C4, C5, C6, C7

ROWS_OF_A = ((), A1, A2, A3, A4, A5, A6, A7)
# Weights of stage s in the positions of all later stages.
(W0, W1, W2, W3, W4, W5, W6) = (
    tuple(float(ROWS_OF_A[later][s]) for later in range(s + 1, 8)) for s in range(7)
)
P0, P1, P2, P3, P4, P5, P6 = B_POSITION
D0, D1, D2, D3, D4, D5, D6, D7 = B_VELOCITY


@inlined
def derive(w, low, high, hertz, stage, kept, gauge, weight):
    """Compute the derivatives with respect to the positions at a stage from row U.

    Contributions are added to the derivatives with respect to parameters.
    """
    w[U + low] = w[U + high + 1] = 0.0
    if hertz:
        for c in range(low, high + 1):
            root, k = kept[c - low], w[STIFFNESS + c]
            share = w[U + c + 1] - w[U + c] + weight * gauge[c]
            slope = 1.5 * k * root
            raised = root * root * root
            transfer = share * slope
            w[TRANSFER + c] = transfer
            w[FACTOR + c] = k * raised
            w[BY_OVERLAP + c] += transfer
            w[BY_STIFFNESS + c] += share * raised
    else:
        for c in range(low, high + 1):
            d, k, p = kept[c - low], w[STIFFNESS + c], w[EXPONENT + c]
            share = w[U + c + 1] - w[U + c] + weight * gauge[c]
            raised = power(d, p)
            slope = p * k * raised / (d if d > 0.0 else 1.0)
            transfer = share * slope
            w[TRANSFER + c] = transfer
            w[FACTOR + c] = k * raised
            w[BY_OVERLAP + c] += transfer
            w[BY_STIFFNESS + c] += share * raised
    for i in range(low, high):
        w[stage + i] = w[TRANSFER + i + 1] - w[TRANSFER + i]
        w[BY_MASS + i] -= w[U + 1 + i] * (w[FACTOR + i] - w[FACTOR + i + 1])
        w[BY_BODY + i] += w[U + 1 + i]


@inlined
def gather(w, low, high, h, position, velocity, later, weights):
    """Compute row U of a stage: derivatives with respect to accelerations, divided by masses."""
    square = h * h
    for i in range(low, high):
        push, stage = position * w[LX + i], later + i
        for weight in weights:
            push += weight * w[stage]
            stage += ROW
        w[U + 1 + i] = (square * push + h * velocity * w[LV + i]) * w[INVERSE_MASS + i]


@inlined
def reverse_stages(w, low, high, h, hertz, kept, gauge, on):
    """`reverse_step` without damping."""
    last = XI0 + 7 * ROW
    size = on * h
    gather(w, low, high, h, 0.0, D7, last, (0.0,))
    derive(w, low, high, hertz, last, kept[7], gauge, size * D7)
    gather(w, low, high, h, P6, D6, last, W6)
    derive(w, low, high, hertz, last - ROW, kept[6], gauge, size * D6)
    gather(w, low, high, h, P5, D5, last - ROW, W5)
    derive(w, low, high, hertz, last - 2 * ROW, kept[5], gauge, size * D5)
    gather(w, low, high, h, P4, D4, last - 2 * ROW, W4)
    derive(w, low, high, hertz, last - 3 * ROW, kept[4], gauge, size * D4)
    gather(w, low, high, h, P3, D3, last - 3 * ROW, W3)
    derive(w, low, high, hertz, last - 4 * ROW, kept[3], gauge, size * D3)
    gather(w, low, high, h, P2, D2, last - 4 * ROW, W2)
    derive(w, low, high, hertz, last - 5 * ROW, kept[2], gauge, size * D2)
    gather(w, low, high, h, P1, D1, last - 5 * ROW, W1)
    derive(w, low, high, hertz, last - 6 * ROW, kept[1], gauge, 0.0)
    gather(w, low, high, h, P0, D0, last - 6 * ROW, W0)
    derive(w, low, high, hertz, XI0, kept[0], gauge, size * D0)
    for i in range(low, high):
        x0, x1, x2, x3 = (w[XI0 + i], w[XI0 + ROW + i], w[XI0 + 2 * ROW + i],
                          w[XI0 + 3 * ROW + i])  # fmt: skip
        x4, x5, x6, x7 = (w[XI0 + 4 * ROW + i], w[XI0 + 5 * ROW + i], w[XI0 + 6 * ROW + i],
                          w[XI0 + 7 * ROW + i])  # fmt: skip
        delayed = C1 * x1 + C2 * x2 + C3 * x3 + C4 * x4 + C5 * x5 + C6 * x6 + C7 * x7
        w[LV + i] += h * (w[LX + i] + delayed)
        w[LX + i] += x0 + x1 + x2 + x3 + x4 + x5 + x6 + x7


@compiled
def reverse_elastic(w, low, high, h, hertz, kept, gauge, on):
    """`reverse_step` without damping."""
    reverse_stages(w[low:], 0, high - low, h, hertz, kept, gauge[low:], on)


@compiled
def reverse_in_window(w, h, hertz, kept, gauge):
    """`reverse_step` of all beads of a window, with which the rows begin."""
    reverse_stages(w, 0, WINDOW, h, hertz, kept, gauge, 0.0)


@entry_point
def reverse_step(w, low, high, h, hertz, kept, gauge, on):
    """Derivatives with respect to the state at the start of a step from those at its end.

    ``gauge`` has the weight of each contact in an impulse that is part of the quantity; ``on`` is 1
    if the impulse includes this step and 0 otherwise.
    """
    if hertz is None:
        reverse_damped(w, low, high, h, kept, gauge, on)
    else:
        reverse_elastic(w, low, high, h, hertz, kept, gauge, on)


@entry_point
def reverse(w, start, stop, lengths, windows, hertz, kept, gauge, on):
    """Apply `reverse_step` to steps ``start - 1`` down to ``stop`` of a block."""
    for n in range(start - 1, stop - 1, -1):
        reverse_step(w, windows[n, 0], windows[n, 1], lengths[n], hertz, kept[n], gauge, on)


@entry_point
def reverse_window(w, start, stop, lengths, windows, hertz, kept, releases, gauge):
    """`reverse` for steps in a window that moves, and for the contacts that are released."""
    last = len(releases) - 1
    while last >= 0 and releases[last, AT_RELEASE] >= start:
        last -= 1
    for n in range(start - 1, stop - 1, -1):
        while last >= 0 and releases[last, AT_RELEASE] == n:
            reverse_release(w, releases[last])
            last -= 1
        reverse_in_window(w[windows[n, 0] :], lengths[n], hertz, kept[n], gauge)

r"""The interpolant of order 7 within a step.

With the fraction :math:`\theta` of the step and seven coefficients per component, it is

.. math:: y + \theta(c_0 + (1-\theta)(c_1 + \theta(c_2 + (1-\theta)(c_3 + \theta(c_4
          + (1-\theta)(c_5 + \theta c_6))))))

(`hertzchain.kernels.dop853`).  The coefficients of all components are computed together;
the search for a maximum is then cheap.
"""

from __future__ import annotations

from .compilation import compiled
from .dop853 import STEP_STAGES, D

COEFFICIENTS = 7
# Fraction of a step over which the change of a slope is estimated.
SHORT = 1e-3


@compiled
def find_coefficients(h, y, y_new, stages, dense):
    """Coefficients of all components, (COEFFICIENTS, len(y)), of a step with all its stages."""
    first, last = stages[0], stages[STEP_STAGES]
    for i in range(len(y)):
        dense[0, i] = y_new[i] - y[i]
    for i in range(len(y)):
        dense[1, i] = h * first[i] - dense[0, i]
    for i in range(len(y)):
        dense[2, i] = 2.0 * dense[0, i] - h * (last[i] + first[i])
    for row in range(3, COEFFICIENTS):
        weights, out = D[row - 3], dense[row]
        # The interpolant does not use stages 1 to 4.
        w0, w1, w2, w3 = h * weights[0], h * weights[5], h * weights[6], h * weights[7]
        s1, s2, s3 = stages[5], stages[6], stages[7]
        for i in range(len(y)):
            out[i] = w0 * first[i] + w1 * s1[i] + w2 * s2[i] + w3 * s3[i]
        for j in (8, 12):
            w0, w1, w2, w3 = weights[j], weights[j + 1], weights[j + 2], weights[j + 3]
            add_four(out, h * w0, h * w1, h * w2, h * w3, stages, j)


@compiled
def add_four(out, a, b, c, d, stages, j):
    """Add a multiple of each of four stages, from stage j on."""
    p, q, r, s = stages[j], stages[j + 1], stages[j + 2], stages[j + 3]
    for i in range(len(out)):
        out[i] = out[i] + a * p[i] + b * q[i] + c * r[i] + d * s[i]


@compiled
def value(i, theta, y, dense):
    """Component i of the state at the fraction theta of the step."""
    rest = 1.0 - theta
    high = dense[3, i] + theta * (dense[4, i] + rest * (dense[5, i] + theta * dense[6, i]))
    return y[i] + theta * (dense[0, i] + rest * (dense[1, i] + theta * (dense[2, i] + rest * high)))


@compiled
def slope(i, theta, h, dense):
    """Rate of change of component i at the fraction theta of the step."""
    result, rate = 0.0, 0.0
    for row in range(COEFFICIENTS - 1, -1, -1):
        result += dense[row, i]
        if row % 2 == 0:
            result, rate = result * theta, rate * theta + result
        else:
            result, rate = result * (1.0 - theta), rate * (1.0 - theta) - result
    return rate / h


@compiled
def attainable_slope(i, h, dense):
    """Upper bound of the rate of change of component i within the step, if it falls at the end.

    A concave curve lies below the tangents at its ends.  A rate that rises at the end has its
    maximum there or in a later step.
    """
    first, last = slope(i, 0.0, h, dense), slope(i, 1.0, h, dense)
    fall = (last - slope(i, 1.0 - SHORT, h, dense)) / SHORT
    if fall >= 0.0:
        return last
    rise = (slope(i, SHORT, h, dense) - first) / SHORT
    theta = (last - fall - first) / (rise - fall)
    if rise <= 0.0 or not 0.0 < theta < 1.0:
        return last - fall
    return first + rise * theta


@compiled
def state_within(theta, y, dense, out):
    """All components at the fraction theta of the step."""
    for i in range(len(out)):
        out[i] = value(i, theta, y, dense)

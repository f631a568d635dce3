r"""Interpolant of degree 7 within a step, common to all methods.

With the fraction :math:`\theta` of the step and seven coefficients per component, it is

.. math:: y + \theta(c_0 + (1-\theta)(c_1 + \theta(c_2 + (1-\theta)(c_3 + \theta(c_4
          + (1-\theta)(c_5 + \theta c_6))))))

as for DOP853 (`hertzchain.kernels.dop853`).  The coefficients of all components are computed
together, so that the search for a maximum takes little time.
"""

from __future__ import annotations

from .compilation import compiled

COEFFICIENTS = 7
# Fraction of a step over which the change of a slope is estimated.
SHORT = 1e-3


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
def attainable(first, rise, last, fall):
    """Upper bound of a concave curve within a step, from the values and slopes at its ends.

    A concave curve lies below the tangents at its ends.  A curve that rises at the end has its
    maximum there or in a later step.
    """
    if fall >= 0.0:
        return last
    theta = (last - fall - first) / (rise - fall)
    if rise <= 0.0 or not 0.0 < theta < 1.0:
        return last - fall
    return first + rise * theta


@compiled
def attainable_slope(i, h, dense):
    """Upper bound of the rate of change of component i within the step, if it falls at the end."""
    first, last = slope(i, 0.0, h, dense), slope(i, 1.0, h, dense)
    fall = (last - slope(i, 1.0 - SHORT, h, dense)) / SHORT
    rise = (slope(i, SHORT, h, dense) - first) / SHORT
    return attainable(first, rise, last, fall)


@compiled
def state_within(theta, y, dense, out):
    """All components at the fraction theta of the step."""
    for i in range(len(out)):
        out[i] = value(i, theta, y, dense)

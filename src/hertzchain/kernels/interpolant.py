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
def polynomial(theta, start, c0, c1, c2, c3, c4, c5, c6):
    """The interpolant of one component, which has the value ``start`` at the step's start."""
    rest = 1.0 - theta
    high = c3 + theta * (c4 + rest * (c5 + theta * c6))
    return start + theta * (c0 + rest * (c1 + theta * (c2 + rest * high)))


@compiled
def value(i, theta, y, dense):
    """Component i of the state at the fraction theta of the step."""
    return polynomial(
        theta, y[i], dense[0, i], dense[1, i], dense[2, i], dense[3, i], dense[4, i], dense[5, i],
        dense[6, i],
    )  # fmt: skip


@compiled
def difference(i, j, y, dense):
    """Arguments of `polynomial`, after the first, for the difference of two components."""
    return (
        y[i] - y[j], dense[0, i] - dense[0, j], dense[1, i] - dense[1, j],
        dense[2, i] - dense[2, j], dense[3, i] - dense[3, j], dense[4, i] - dense[4, j],
        dense[5, i] - dense[5, j], dense[6, i] - dense[6, j],
    )  # fmt: skip


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

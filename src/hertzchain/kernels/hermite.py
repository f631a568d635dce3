"""Hermite interpolation within a step, by a polynomial of degree 7.

Position, velocity, acceleration and jerk at both ends determine its eight coefficients.  Nystrom
methods (`hertzchain.kernels.rkn8`) have no interpolant; with this one, maxima within a step are as
accurate as the step.
"""

from __future__ import annotations

from .compilation import CONTRACTED, internal

compiled = internal(**CONTRACTED)


@compiled
def hermite(h, x0, v0, a0, j0, x1, v1, a1, j1):
    """Coefficients of the polynomial in s = t/h through both ends of a step."""
    c1, c2, c3 = h * v0, 0.5 * h * h * a0, h * h * h * j0 / 6.0
    x = x1 - (x0 + c1 + c2 + c3)
    v = h * v1 - (c1 + 2.0 * c2 + 3.0 * c3)
    a = h * h * a1 - (2.0 * c2 + 6.0 * c3)
    j = h * h * h * j1 - 6.0 * c3
    c4 = 35.0 * x - 15.0 * v + 2.5 * a - j / 6.0
    c5 = -84.0 * x + 39.0 * v - 7.0 * a + 0.5 * j
    c6 = 70.0 * x - 34.0 * v + 6.5 * a - 0.5 * j
    c7 = -20.0 * x + 10.0 * v - 2.0 * a + j / 6.0
    return x0, c1, c2, c3, c4, c5, c6, c7


@compiled
def value(c, s):
    """Value of the polynomial at s."""
    c0, c1, c2, c3, c4, c5, c6, c7 = c
    return c0 + s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * (c5 + s * (c6 + s * c7))))))


@compiled
def slope(c, s):
    """First derivative with respect to s."""
    _, c1, c2, c3, c4, c5, c6, c7 = c
    high = 4.0 * c4 + s * (5.0 * c5 + s * (6.0 * c6 + s * (7.0 * c7)))
    return c1 + s * (2.0 * c2 + s * (3.0 * c3 + s * high))


@compiled
def curvature(c, s):
    """Second derivative with respect to s."""
    _, _, c2, c3, c4, c5, c6, c7 = c
    high = 12.0 * c4 + s * (20.0 * c5 + s * (30.0 * c6 + s * (42.0 * c7)))
    return 2.0 * c2 + s * (6.0 * c3 + s * high)


@compiled
def third(c, s):
    """Third derivative with respect to s."""
    _, _, _, c3, c4, c5, c6, c7 = c
    return 6.0 * c3 + s * (24.0 * c4 + s * (60.0 * c5 + s * (120.0 * c6 + s * (210.0 * c7))))

r"""Tables of the implicit method Radau IIA with five stages, of order 9.

The nodes :math:`c_i` are the zeros of :math:`\frac{d^4}{dc^4} c^4 (c - 1)^5`, the weights

.. math:: a_{ij} = \int_0^{c_i} \ell_j(c)\, dc ,

where :math:`\ell_j` is the polynomial of degree 4 that is 1 at node j and 0 at the other nodes:
E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, section IV.5.  The last node is
the end of the step.  All tables are computed from the nodes in rational arithmetic, so that they
are correctly rounded.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np

from .interpolant import COEFFICIENTS

NODES = (0.05710419611451768, 0.2768430136381238, 0.5835904323689168, 0.8602401356562195, 1.0)
IMPLICIT_STAGES = len(NODES)

Polynomial = list[Fraction]


def _times(one: Polynomial, other: Polynomial) -> Polynomial:
    """Product of two polynomials, with coefficients of rising powers."""
    product = [Fraction(0)] * (len(one) + len(other) - 1)
    for i, a in enumerate(one):
        for j, b in enumerate(other):
            product[i + j] += a * b
    return product


def _integral(polynomial: Polynomial) -> Polynomial:
    """Integral from 0."""
    return [Fraction(0), *(c / (i + 1) for i, c in enumerate(polynomial))]


def _at(polynomial: Polynomial, x: Fraction) -> Fraction:
    return sum((c * x**i for i, c in enumerate(polynomial)), Fraction(0))


def _lagrange() -> list[Polynomial]:
    """For each node, the polynomial that is 1 there and 0 at the other nodes."""
    nodes = [Fraction(c) for c in NODES]
    basis = []
    for i, here in enumerate(nodes):
        product = [Fraction(1)]
        for j, other in enumerate(nodes):
            if j != i:
                product = _times(product, [-other / (here - other), 1 / (here - other)])
        basis.append(product)
    return basis


def _dense(polynomial: Polynomial) -> Polynomial:
    """Coefficients in the basis t, t(1-t), t^2(1-t), ... of `hertzchain.kernels.interpolant`."""
    rest, coefficients = list(polynomial), [Fraction(0)] * COEFFICIENTS
    basis = [[Fraction(0), Fraction(1)]]
    for row in range(1, COEFFICIENTS):
        factor = [Fraction(1), Fraction(-1)] if row % 2 else [Fraction(0), Fraction(1)]
        basis.append(_times(basis[-1], factor))
    for row in range(len(rest) - 2, -1, -1):
        coefficients[row] = rest[row + 1] / basis[row][row + 1]
        for power, c in enumerate(basis[row]):
            rest[power] -= coefficients[row] * c
    return coefficients


def _legendre(degree: int) -> list[Fraction]:
    """Weights of the values at the nodes in a Legendre coefficient of their interpolant."""
    shifted = [Fraction(1)], [Fraction(-1), Fraction(2)]
    polynomials = list(shifted)
    for n in range(1, degree):
        ahead = [Fraction(2 * n + 1, n + 1) * c for c in _times(shifted[1], polynomials[n])]
        for i, c in enumerate(polynomials[n - 1]):
            ahead[i] -= Fraction(n, n + 1) * c
        polynomials.append(ahead)
    part = Fraction(2 * degree + 1)
    return [part * _at(_integral(_times(e, polynomials[degree])), Fraction(1)) for e in _lagrange()]


def _floats(rows: list[Polynomial]) -> Any:
    return np.array([[float(c) for c in row] for row in rows])


_INTEGRALS = [_integral(e) for e in _lagrange()]
# Weights (stage, stage), their matrix square, and the weights of implicit Euler, with one stage.
WEIGHTS = _floats([[_at(e, Fraction(c)) for e in _INTEGRALS] for c in NODES])
SQUARED = WEIGHTS @ WEIGHTS
ONE_STAGE = np.ones((1, 1))
# Matrix (COEFFICIENTS, stage) from the rates at the nodes to coefficients of the interpolant.
TO_DENSE = np.ascontiguousarray(_floats([_dense(e) for e in _INTEGRALS]).T)
# Lagrange polynomials of the nodes, by powers of the fraction of the step (power, stage).
BETWEEN = np.ascontiguousarray(_floats(_lagrange()).T)
# The last two Legendre coefficients of the rates, as changes of the velocity within the step.
LAST, BEFORE_LAST = _floats([[c / (2 * (2 * n + 1)) for c in _legendre(n)] for n in (4, 3)])

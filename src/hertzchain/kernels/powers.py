r"""Vectorised powers of the elements of an array.

With :math:`x = 2^e m`, where e and m follow from the bits of x,

.. math:: x^a = 2^n\, 2^{a e + a \log_2 m - n}, \qquad
          \log_2 m = \frac{2}{\ln 2}\,\mathrm{artanh}\,\frac{m - 1}{m + 1} ,

where n is the integer closest to the exponent; both functions are evaluated by their series.  The
relative error is a few :math:`10^{-16}`, and the loops are free of branches, so that the compiler
can vectorise them.

`power` is the same function of one number, to be called in such loops.  It takes half the time, and
its relative error of 1e-14 is smaller than the integration errors.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from .compilation import CONTRACTED, compiled, internal

# A float64 is 2^(exponent - BIAS) (1 + mantissa), where the exponent begins at bit SHIFT.
SHIFT, BIAS = 52, 1023
MANTISSA, ONE = (1 << SHIFT) - 1, BIAS << SHIFT
# Smaller numbers are subnormal; their powers are set to 0.
SMALLEST = 1e-300
ROOT_2 = math.sqrt(2.0)
# Series of log2 m in odd powers of (m - 1)/(m + 1), and of 2^r in powers of r.
LOGARITHM = tuple(2.0 / ((2 * i + 1) * math.log(2.0)) for i in range(12))
EXPONENTIAL = tuple(math.log(2.0) ** i / math.factorial(i) for i in range(14))
# Adding the first number to a smaller one rounds it to an integer; the second one has the bits of
# 2^52, whose mantissa is 0.
ROUNDING, INTEGER = 1.5 * 2.0**52, 0x4330000000000000
# Smallest and largest exponent of a power of two with full precision.
MIN_EXPONENT, MAX_EXPONENT = -1021.0, 1023.0
# Bits of the root of 1/2; mantissas are reduced to the interval from there to the root of 2.
ROOT_BITS = 0x3FE6A09E667F3BCD


def _fitted(function: Any, degree: int, low: float, high: float) -> tuple[float, ...]:
    """Coefficients of the polynomial through a function's values at the Chebyshev points."""
    fit = np.polynomial.Chebyshev.interpolate(function, degree, [low, high])
    return tuple(fit.convert(kind=np.polynomial.Polynomial).coef.tolist())


def _log2_over_f(square: Any) -> Any:
    """(log2 m)/f as a function of the square of f = (m - 1)/(m + 1)."""
    return sum(square**i / (2 * i + 1) for i in range(20)) * 2.0 / math.log(2.0)


# Relative errors of 6e-15 and 4e-16.
SHORT_LOGARITHM = _fitted(_log2_over_f, 6, 0.0, ((ROOT_2 - 1.0) / (ROOT_2 + 1.0)) ** 2)
SHORT_EXPONENTIAL = _fitted(np.exp2, 10, -0.5, 0.5)

inlined = internal(forceinline=True, **CONTRACTED)


@intrinsic
def _bits_of(_context, _number):
    """Bits of a float64 as an integer; unlike a view, this allows vector instructions."""

    def generate(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], ir.IntType(64))

    return types.int64(types.float64), generate


@intrinsic
def _number_of(_context, _bits):
    """The float64 with these bits."""

    def generate(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], ir.DoubleType())

    return types.float64(types.int64), generate


# Callers omit the first argument, which type checkers would require.
bits_of: Any = _bits_of
number_of: Any = _number_of


@inlined
def power(base, exponent):
    """base^exponent to 1e-14, at most 9e307; 0 unless the base is larger than 1e-300."""
    positive = base > SMALLEST
    bits = bits_of(base if positive else 1.0)
    # Mantissa between the roots of 1/2 and 2, and the remaining exponent as a float.
    whole = (bits - ROOT_BITS) >> SHIFT
    m = number_of(bits - (whole << SHIFT))
    e = number_of((whole + BIAS) | INTEGER) - number_of(INTEGER | BIAS)
    f = (m - 1.0) / (m + 1.0)
    q = f * f
    a0, a1, a2, a3, a4, a5, a6 = SHORT_LOGARITHM
    log = f * (a0 + q * (a1 + q * (a2 + q * (a3 + q * (a4 + q * (a5 + q * a6))))))
    total = exponent * (e + log)
    total = total if total > MIN_EXPONENT else MIN_EXPONENT
    total = total if total < MAX_EXPONENT else MAX_EXPONENT
    shifted = total + ROUNDING
    r = total - (shifted - ROUNDING)
    b0, b1, b2, b3, b4, b5, b6, b7, b8, b9, b10 = SHORT_EXPONENTIAL
    high = b5 + r * (b6 + r * (b7 + r * (b8 + r * (b9 + r * b10))))
    root = b0 + r * (b1 + r * (b2 + r * (b3 + r * (b4 + r * high))))
    found = number_of(bits_of(root) + (bits_of(shifted) << SHIFT))
    # NaN stays NaN.
    return found if positive else 0.0 * base


@compiled
def powers(base, exponent, out, scratch):
    """Write base^exponent (base >= 0, NaN if not finite; 0 <= exponent <= 16) into ``out``."""
    bits = base.view(np.int64)
    mantissa, whole = scratch[0, : len(base)], scratch[1, : len(base)]
    written, exponents = mantissa.view(np.int64), whole.view(np.int64)
    for i in range(len(base)):
        written[i] = (bits[i] & MANTISSA) | ONE
        exponents[i] = (bits[i] >> SHIFT) - BIAS
    # The product of the upper half of the exponent and an integer is exact.
    upper = np.float64(np.float32(exponent))
    lower = exponent - upper
    for i in range(len(base)):
        m, e = mantissa[i], float(exponents[i])
        large = m > ROOT_2
        m, e = 0.5 * m if large else m, e + 1.0 if large else e
        log = log2(m)
        n = np.floor(upper * e + exponent * log + 0.5)
        out[i] = exp2((upper * e - n) + (lower * e + exponent * log))
        n = BIAS if n > BIAS else n
        exponents[i] = (int(-BIAS if n < -BIAS else n) + BIAS) << SHIFT
    for i in range(len(base)):
        power = out[i] * whole[i] if base[i] > SMALLEST else 0.0
        out[i] = power + (base[i] - base[i])


@compiled
def log2(m):
    """Logarithm to the base 2 of a number between the roots of 1/2 and 2."""
    f = (m - 1.0) / (m + 1.0)
    q = f * f
    a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11 = LOGARITHM
    high = a6 + q * (a7 + q * (a8 + q * (a9 + q * (a10 + q * a11))))
    return f * (a0 + q * (a1 + q * (a2 + q * (a3 + q * (a4 + q * (a5 + q * high))))))


@compiled
def exp2(r):
    """2^r for abs(r) <= 1/2."""
    a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11, a12, a13 = EXPONENTIAL
    high = a7 + r * (a8 + r * (a9 + r * (a10 + r * (a11 + r * (a12 + r * a13)))))
    return a0 + r * (a1 + r * (a2 + r * (a3 + r * (a4 + r * (a5 + r * (a6 + r * high))))))

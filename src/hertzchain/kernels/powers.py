r"""Vectorised powers of the elements of an array.

With :math:`x = 2^e m`, where e and m follow from the bits of x,

.. math:: x^a = 2^n\, 2^{a e + a \log_2 m - n}, \qquad
          \log_2 m = \frac{2}{\ln 2}\,\mathrm{artanh}\,\frac{m - 1}{m + 1} ,

where n is the whole number next to the exponent; both functions are evaluated by their series.  The
relative error is a few :math:`10^{-16}`, and the loops have no branch, so that the compiler can
vectorise them.
"""

from __future__ import annotations

import math

import numpy as np

from .compilation import compiled

# A float64 is 2^(exponent - BIAS) (1 + mantissa), where the exponent begins at bit SHIFT.
SHIFT, BIAS = 52, 1023
MANTISSA, ONE = (1 << SHIFT) - 1, BIAS << SHIFT
# Smaller numbers are subnormal; their powers are set to 0.
SMALLEST = 1e-300
ROOT_2 = math.sqrt(2.0)
# Series of log2 m in odd powers of (m - 1)/(m + 1), and of 2^r in powers of r.
LOGARITHM = tuple(2.0 / ((2 * i + 1) * math.log(2.0)) for i in range(12))
EXPONENTIAL = tuple(math.log(2.0) ** i / math.factorial(i) for i in range(14))


@compiled
def powers(base, exponent, out, scratch):
    """Write base^exponent (base >= 0, NaN if not finite; 0 <= exponent <= 16) into ``out``."""
    bits = base.view(np.int64)
    mantissa, whole = scratch[0, : len(base)], scratch[1, : len(base)]
    written, exponents = mantissa.view(np.int64), whole.view(np.int64)
    for i in range(len(base)):
        written[i] = (bits[i] & MANTISSA) | ONE
        exponents[i] = (bits[i] >> SHIFT) - BIAS
    # The product of the upper half of the exponent and a whole number is exact.
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
    """Logarithm to the base 2 of a number near 1."""
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

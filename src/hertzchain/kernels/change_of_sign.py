"""Search for the place within a step at which a quantity changes its sign.

A bracket is a tuple of the fractions of the step at its ends, the values there, the first positive
and the second not, and the end at which it was last narrowed.
"""

from __future__ import annotations

from .compilation import compiled

# Secants in a part of a step before bisection, and the least part of a step by which a search
# continues.
SECANTS, BISECTIONS, CLOSE = 16, 48, 2.0**-50


@compiled
def place_within(bracket, tried):
    """Next fraction of a step at which to look for the change of sign in a bracket."""
    low, high, rising, falling, _ = bracket
    if tried >= SECANTS or not rising > 0.0 > falling:
        return 0.5 * (low + high)
    return min(max(low + (high - low) * rising / (rising - falling), low + CLOSE), high - CLOSE)


@compiled
def narrowed(bracket, middle, found):
    """The bracket with one end, and the value there, replaced by a place between the ends.

    By the Illinois rule, the value at an end that remains again is halved.
    """
    low, high, rising, falling, side = bracket
    if found > 0.0:
        return middle, high, found, 0.5 * falling if side > 0 else falling, 1
    return low, middle, 0.5 * rising if side < 0 else rising, found, -1


@compiled
def closing_within(c, beads, y, dense):
    """Polynomial of the relative velocity of beads c and c + 1 (0-based): start, coefficients."""
    i, j = beads + c, beads + c + 1
    return (
        y[i] - y[j], dense[0, i] - dense[0, j], dense[1, i] - dense[1, j],
        dense[2, i] - dense[2, j], dense[3, i] - dense[3, j], dense[4, i] - dense[4, j],
        dense[5, i] - dense[5, j], dense[6, i] - dense[6, j],
    )  # fmt: skip

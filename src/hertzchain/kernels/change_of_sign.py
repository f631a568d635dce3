"""Search for the place within a step at which a quantity changes its sign.

A bracket is a tuple of the fractions of the step at its ends, the values there, the first positive
and the second not, and the end at which it was last narrowed.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .compilation import OPTIONS, compiled, internal

# Parts of a step that are searched for the first change, because a light bead may reverse its
# direction twice in a step.
PARTS = 8
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


def first_change_of(quantity: Callable[..., float]) -> Callable[..., float]:
    """Search for the first change of sign of ``quantity(theta, *arguments)``.

    The search, called with ``(start, arguments)``, returns the fraction theta of the step at which
    the quantity, ``start`` at first, is first not positive; 2 if there is none.
    """

    # It is compiled into the functions that call it, which are cached.
    @internal(**(OPTIONS | {"cache": False}))
    def first_change(start: float, arguments: tuple[Any, ...]) -> float:
        low, rising = 0.0, start
        for part in range(1, PARTS + 1):
            high = part / PARTS
            falling = quantity(high, *arguments)
            if not falling <= 0.0:
                low, rising = high, falling
                continue
            bracket = low, high, rising, falling, 0
            for tried in range(SECANTS + BISECTIONS):
                if bracket[1] - bracket[0] <= 2.0 * CLOSE:
                    break
                middle = place_within(bracket, tried)
                bracket = narrowed(bracket, middle, quantity(middle, *arguments))
            return bracket[1]
        return 2.0

    return first_change

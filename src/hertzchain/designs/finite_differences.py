"""Derivatives of the measures of a design by central differences of simulations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from ..collision import Array

# Step relative to the range of a variable, and tolerance of the runs.
STEP: Final = 1e-4
STEP_RTOL: Final = 1e-9


def differences(
    values_at: Callable[[Sequence[Array]], Array], point: Array
) -> tuple[Array, Array, int]:
    """Values, shape (M,), their derivatives (M, n), and the number of points used.

    No point is outside the limits 0 and 1 of the variables.
    """
    size = len(point)
    steps = STEP * np.eye(size)
    ahead, behind = np.minimum(point + steps, 1.0), np.maximum(point - steps, 0.0)
    values = values_at([point, *ahead, *behind])
    width = (ahead - behind).diagonal()
    slopes = (values[1 : size + 1] - values[size + 1 :]).T / width
    return values[0], slopes, 2 * size + 1

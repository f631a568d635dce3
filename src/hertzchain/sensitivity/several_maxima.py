"""Changes of a peak that is the largest of several maxima, which may overtake each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..collision import Array
from .gradient import Gradient


def change_of_largest(maxima: Sequence[Gradient], name: str, part: float) -> Array:
    r"""Relative change of the largest maximum if a parameter of each bead grows by a part.

    With values :math:`Q_i`, of which :math:`Q_1` is the largest, and derivatives by the parameter
    :math:`x_k`, it is
    :math:`\max_i (Q_i + \epsilon x_k\,\partial Q_i/\partial x_k)/Q_1 - 1`.  If another maximum is
    nearly as large as the first one, this differs between :math:`\epsilon` and :math:`-\epsilon`.
    """
    changed = [each.value * (1.0 + part * each.relative(name)) for each in maxima]
    return np.asarray(np.max(changed, axis=0) / maxima[0].value - 1.0)

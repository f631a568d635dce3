"""Weights of the nodes of a table in cubic spline interpolation, which is linear in its values."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from ..collision import Array


def spline_weights(nodes: tuple[float, ...], at: float) -> Array:
    """Weight of each node in the value at a point."""
    return np.asarray(_splines(nodes)(at))


@functools.cache
def _splines(nodes: tuple[float, ...]) -> Any:
    from scipy.interpolate import CubicSpline

    return CubicSpline(nodes, np.eye(len(nodes)))

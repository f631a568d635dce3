"""Rows beside a Pareto front: the given chain, the given row, and the best one to compare."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.axes import Axes

from ..designs.comparison import GIVEN, shown_chains
from ..designs.reference_chains import GIVEN_ROW
from ..designs.verified import met
from .colours import grey

if TYPE_CHECKING:
    from ..designs.result import DesignResult
    from ..designs.verified import Verified

MARKS: Final = ("s", "D", "^")
# A row that would make the front smaller than this part of an axis is stated in the legend.
LEAST: Final = 0.2
# Objective of an axis, the factor to its unit, and this unit.
Scale = tuple[str, float, str]


def draw_compared_rows(result: DesignResult, across: Scale, up: Scale, axes: Axes) -> None:
    """Draw the rows beside the front, or state their values if they are far away from it."""
    low, high = np.array(axes.dataLim.get_points())
    for (name, found), mark in zip(_rows(result).items(), MARKS, strict=False):
        x, y = (factor * found.values[key] for key, factor, _ in (across, up))
        beyond = "" if met(result.problem, found.values) else ", outside the limits"
        span = np.maximum(high, (x, y)) - np.minimum(low, (x, y))
        distant = bool(((high > low) & (high - low < LEAST * span)).any())
        if distant:
            pairs = ((y, up[2]), (x, across[2]))
            values = ", ".join(f"{value:.4g} {unit}".rstrip() for value, unit in pairs)
            beyond += f": {values} (not shown)"
        axes.plot([] if distant else [x], [] if distant else [y], mark, color=grey(axes, 0.35),
                  markerfacecolor="none", label=f"{name}{beyond}")  # fmt: skip


def _rows(result: DesignResult) -> dict[str, Verified]:
    """Rows by name, without the design itself."""
    shown = shown_chains(result)
    rows = {} if GIVEN in shown else {GIVEN: result._initial}
    rows |= {name: found for name, found in result.references.items() if name == GIVEN_ROW}
    compared = [*shown.items()][:-1]
    return rows | dict(compared)

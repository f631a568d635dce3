"""Plot a run: forces on walls and bodies above the map of velocities."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import matplotlib.pyplot as plt
from matplotlib.axes import Axes

from ..simulation.run import Run
from .decades import is_pale
from .runs import plot_forces, plot_run
from .style import figure_style
from .widths import figure_size

# Heights of both panels.
HEIGHTS: Final = (2.0, 3.0)


def plot_run_and_forces(run: Run, places: Sequence[int | str]) -> Axes:
    """Plot forces over time and, below them, velocities as a map with the same times."""
    with figure_style():
        grid = plt.subplots(
            2, 1, sharex=True, height_ratios=HEIGHTS, figsize=figure_size(6.0, 5.2),
            layout="constrained",
        )[1]  # fmt: skip
        upper: Axes = plot_forces(run, places, ax=grid[0])
        lower = plot_run(run, relative=is_pale(run), ax=grid[1])
        lower.set_title("")
        lower.set_title("", loc="left")
        upper.set_xlabel("")
        upper.tick_params(labelbottom=False)
    return upper

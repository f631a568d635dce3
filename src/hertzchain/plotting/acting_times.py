"""Limits of a time axis: the times at which forces act."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from matplotlib.axes import Axes

from .force_lines import force_lines

# Part of the largest value of a curve from which a force is visible.
VISIBLE: Final = 0.01
# Part of the axis that forces must fill; a smaller one is enlarged, with this margin on both sides.
FILLED, MARGIN = 0.5, 0.1


def limit_to_forces(panels: Sequence[Axes]) -> None:
    """Show only the times at which forces act, if the axis is empty otherwise.

    Each impact of at least `VISIBLE` of the largest force of its curve remains visible.  Axes with
    other curves, such as measured ones, and those whose limits were given do not change.
    """
    lines = [line for axes in panels for line in force_lines(axes)]
    if len(lines) < sum(len(axes.lines) for axes in panels) or not lines:
        return
    if not all(axes.get_autoscalex_on() for axes in panels):
        return
    # The circle at the end of a force that may still rise remains in the axes.
    if any(line.analysed for line in lines):
        return
    begin, end = np.inf, -np.inf
    for line in lines:
        times, force = np.asarray(line.get_xdata()), np.abs(np.asarray(line.get_ydata()))
        acting = times[force > VISIBLE * force.max(initial=0.0)]
        begin, end = min(begin, acting.min(initial=np.inf)), max(end, acting.max(initial=-np.inf))
    low, high = panels[0].get_xlim()
    span = end - begin
    if not 0.0 < span < FILLED * (high - low):
        return
    # The axis begins at the impact on the chain, unless this would make the forces too narrow.
    left = low if begin - low < span else begin - MARGIN * span
    for axes in panels:
        # Further curves make the axis longer again.
        axes.set_xlim(left, min(end + MARGIN * span, high), auto=True)

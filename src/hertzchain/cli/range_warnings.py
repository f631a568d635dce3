"""Warnings on the limits of Hertz's law of many runs: one line for each limit."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from .shown_warnings import show_warning
from .wording import on_command_line

if TYPE_CHECKING:
    from ..chain.hertz_range import HertzRange
    from ..simulation.run import Run


def warn_of_limits(runs: Mapping[str, Run]) -> None:
    """Warn of each limit that runs exceed, with the number of these runs and the largest ratio."""
    from ..chain.hertz_range import hertz_range
    from ..chain.hertz_ratios import MAX_SPEED_RATIO, NO_PREDICTION

    ranges = {
        name: hertz_range(run.chain, run.largest_overlaps)
        for name, run in runs.items()
        if run.chain.materials is not None and run.chain.units == "SI"
    }
    _warn("pressure / yield", ranges, lambda each: each.largest_yield_ratio,
          lambda each: each.largest_yield_ratio > 1.0,
          "reduce the velocity or add --loss elastic-plastic")  # fmt: skip
    far = sum(_overlap(each) > NO_PREDICTION for each in ranges.values())
    beyond = f"beyond {NO_PREDICTION:g}, in {far}, forces are not a prediction; " * bool(far)
    _warn("overlap / radius", ranges, _overlap,
          lambda each: bool((each.overlap_ratio > each.overlap_limit).any()),
          f"{beyond}reduce the velocity")  # fmt: skip
    noted = {name: run for name, run in runs.items() if run.notes}
    if noted:
        name, run = next(iter(noted.items()))
        show_warning(f"{name}: {on_command_line(run.notes[0])}")
    _warn("impact speed / sound", ranges, lambda each: each.speed_ratio,
          lambda each: each.speed_ratio > MAX_SPEED_RATIO, "reduce the velocity")  # fmt: skip


def _overlap(limits: HertzRange) -> float:
    """Largest overlap / radius; NaN at linear springs is left out."""
    import numpy as np

    return float(np.nan_to_num(limits.overlap_ratio).max())


def _warn(
    ratio: str, ranges: Mapping[str, HertzRange], value: Callable[[HertzRange], float],
    exceeds: Callable[[HertzRange], bool], advice: str,
) -> None:  # fmt: skip
    """Warn of a ratio that is above its limit in any run."""
    above = {name: value(each) for name, each in ranges.items() if exceeds(each)}
    if above:
        worst = max(above, key=above.__getitem__)
        show_warning(
            f"{ratio} exceeds its limit in {len(above)} of {len(ranges)} runs, and is up to "
            f"{above[worst]:.2g} ({worst}); {advice}"
        )

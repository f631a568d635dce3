"""Notes on records with few samples during a pulse."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from ..collision import Array
from ..representation import counted, measure
from ..traces.signals import Shot
from .crossings import pulse_duration

# Samples during a pulse, at half of its peak, of which fewer are noted, and that are recommended.
FEW, ENOUGH = 3.0, 5.0
ABOUT: Final = "at half of its peak: peaks and arrival times are uncertain; sample every"


def sampling_notes(
    shot: Shot, models: Sequence[Array], grid: Array | None = None, number: int | None = None
) -> list[str]:
    """A note if the shortest simulated pulse of a shot has few samples.

    ``models`` are at the times of the ``grid``, by default those of the samples; ``number`` is that
    of one of several shots.
    """
    times = shot.times if grid is None else grid
    durations = []
    for model in models:
        known = np.isfinite(model)
        values = model[known] - model[known][0] if known.any() else np.zeros(1)
        durations.append(pulse_duration(times[known], values))
    step = float(np.median(np.diff(shot.times)))
    if not np.isfinite(durations).any():
        return []
    shortest = int(np.nanargmin(durations))
    duration = durations[shortest]
    if duration >= FEW * step:
        return []
    count, where = counted(max(round(duration / step), 1), "sample"), shot.signals[shortest].name
    return [
        f"the pulse at {where}{'' if number is None else f' of shot {number}'} has about {count} "
        f"{ABOUT} {measure(duration / ENOUGH, 's', digits=2)} or less"
    ]

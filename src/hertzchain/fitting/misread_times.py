"""Times in another unit or with another sampling interval, from durations and arrivals."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from ..collision import Array
from ..traces.amplitudes import ARRIVED, extreme, level_of
from ..traces.signals import Shot
from .arrival_notes import has_pulse
from .crossings import half_width, reached
from .misread_columns import Misread
from .model import Model
from .sensor_comparison import check_durations, saturated_samples
from .simulations import passing_time

# The ratios of pulse durations and of the times between sensors agree within the first factor, and
# differ from 1 by more than the second.
ALIKE, CLEAR = 1.25, 1.5
# Factors that a unit or a sampling interval is usually wrong by, and their tolerance.
USUAL: Final = (2.0, 2.5, 4.0, 5.0, 10.0, 100.0)
TOLERANCE: Final = 1.15


def time_factor(shot: Shot, columns: Sequence[Array], grid: Array) -> float | None:
    """Ratio of measured to simulated times; None if pulses and travel disagree, or if it is 1.

    Another stiffness has the same effect on times, but changes the forces inversely.
    """
    found, arrivals = [], []
    for signal, column in zip(shot.signals, columns, strict=True):
        ok = signal.valid | saturated_samples(signal)
        seen, own = (signal.values - level_of(signal))[ok], column - column[0]
        if not own.any() or not has_pulse(signal):
            return None
        found.append(half_width(shot.times[ok], seen) / max(half_width(grid, own), grid[1]))
        arrivals.append([
            reached(times, values, ARRIVED * extreme(values))
            for times, values in ((shot.times[ok], seen), (grid, own))
        ])  # fmt: skip
    if len(arrivals) < 2:
        return None
    seen, own = np.array(arrivals).T
    first, last = int(np.argmin(own)), int(np.argmax(own))
    if own[last] <= own[first]:
        return None
    travel = float((seen[last] - seen[first]) / (own[last] - own[first]))
    widths = float(np.median(found))
    if travel <= 0.0 or not 1.0 / ALIKE < widths / travel < ALIKE:
        return None
    if 1.0 / CLEAR < travel < CLEAR:
        return None
    near = [each**sign for each in USUAL for sign in (1, -1)]
    usual = min(near, key=lambda each: abs(np.log(travel / each)))
    return usual if 1.0 / TOLERANCE < travel / usual < TOLERANCE else float(f"{travel:.2g}")


def time_notes(shot: Shot, columns: Sequence[Array], grid: Array) -> list[str]:
    """A note if all times differ from those of the simulation by one factor."""
    factor = time_factor(shot, columns, grid)
    if factor is None:
        return []
    times = {2.0: "twice", 0.5: "half"}.get(factor, f"{factor:.3g} times")
    return [
        f"the measured pulses last {times} as long as the simulated ones, and they take "
        f"{times} as long from sensor to sensor: check the unit of the times, the "
        "sampling interval, and the materials of the chain"
    ]


def check_times(model: Model) -> None:
    """Raise `InputError` if measured and nominal pulses differ in duration by a power of 1000."""
    shot, columns, grid = nominal_pulses(model)
    pairs = zip(shot.signals, columns, strict=True)
    clear = [(signal, column) for signal, column in pairs if has_pulse(signal)]
    check_durations(
        replace(shot, signals=tuple(each for each, _ in clear)),
        [column for _, column in clear],
        grid,
    )


def misread_times(model: Model) -> Iterator[Misread]:
    """Traces with times that agree better with the nominal chain."""
    factor = time_factor(*nominal_pulses(model))
    if factor is not None:
        how = f"multiplied by {1.0 / factor:.3g}" if factor < 1.0 else f"divided by {factor:.3g}"
        correction = float(f"{1.0 / factor:.4g}")
        advice = (
            "check the unit of the times and the sampling interval; "
            f"traces.with_scaled_times({correction:g}) corrects them"
        )
        corrected = model.traces.with_scaled_times(correction)
        yield Misread(f"all times {how}", advice, corrected, whole=True)


def nominal_pulses(model: Model, index: int = 0) -> tuple[Shot, list[Array], Array]:
    """A shot, and the signals of its nominal chain, on a grid, until the pulse has passed it."""
    shot = model.traces.shots[index]
    chain = model.chain(index, {each.name: each.start for each in model.parameters})
    duration = passing_time(chain)
    if not np.isfinite(duration):
        duration = float(shot.times[-1] - shot.times[0])
    run = model.simulator.signals(chain, duration)
    columns = [model.simulator.column(run, signal) for signal in shot.signals]
    return shot, columns, run.spacing * np.arange(len(run.columns))

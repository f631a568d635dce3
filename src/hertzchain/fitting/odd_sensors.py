"""Notes on one sensor whose delay or amplitude differs from those of all others."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Final

import numpy as np

from ..collision import Array
from ..representation import measure
from ..traces.places import NAME
from ..traces.signals import Shot
from .arrival_notes import has_pulse
from .sensor_comparison import NOTED, SensorComparison
from .shown_values import shown_ratio

# Least number of sensors; a sensor is odd if it is further from all others, and from their trend
# along the chain, than this multiple of their range.
MIN_SENSORS: Final = 3
IN_RANGES: Final = 4.0
# Least difference of the logarithms of amplitudes; that of delays is this part of the travel time
# from the first sensor to the last, and this multiple of the error of the arrival.
MIN_AMPLITUDE, OF_TRAVEL, IN_ERRORS = 0.2, 0.05, 5.0
# A ball of the row may be missing if a delay differs from the time in which the pulse passes one
# ball by less than this part of it.
ONE_BALL: Final = 0.5

# A ball that is missing at the end of a row changes arrivals only on the wall.
BALLS: Final = ", the number of balls"


def odd_sensor_notes(
    sensors: Sequence[SensorComparison], shot: Shot, inside: Array, outside: Collection[str]
) -> list[str]:
    """Notes on a sensor that differs from the others, of those with a pulse in the record."""
    silent = {each.name for each in shot.signals if not has_pulse(each, inside)}
    known = [
        each for each in sensors
        if each.name not in silent.union(outside) and np.isfinite(each.delay)
    ]  # fmt: skip
    return [*_delayed(known), *_amplified(known)]


def _delayed(sensors: Sequence[SensorComparison]) -> list[str]:
    if len(sensors) < MIN_SENSORS:
        return []
    arrivals = np.array([each.simulated_arrival for each in sensors])
    found = _odd_one(arrivals, np.array([each.delay for each in sensors]))
    if found is None:
        return []
    odd, difference = sensors[found[0]], found[1]
    least = max(OF_TRAVEL * float(np.ptp(arrivals)), IN_ERRORS * float(odd.arrival_error))
    if not abs(difference) > least:
        return []
    return [
        f"the measured signal of {odd.name} is {measure(abs(difference), 's', digits=2)} "
        f"{'late' if difference < 0.0 else 'early'} compared with those of the other sensors: "
        f"check {_late_causes(sensors, odd, difference)}"
    ]


def _late_causes(
    sensors: Sequence[SensorComparison], odd: SensorComparison, difference: float
) -> str:
    """Causes of the delay of one sensor; those at an end of the row may be due to the row."""
    order = sorted(sensors, key=lambda each: each.simulated_arrival)
    early = difference > 0.0
    missing = _missing_ball(order, odd, difference)
    own = f"the delay of its channel and its place{_end(odd, BALLS)}{missing}"
    if early and odd is order[0]:
        between = f"between {odd.name} and {order[1].name}"
    elif not early and odd is order[-1] and "wall" not in odd.name:
        between = f"between {order[-2].name} and {odd.name}"
    elif not early and odd is order[-1]:
        between = f"between {order[-2].name} and the wall"
    else:
        return own
    return f"for a gap or an odd ball {between}, and check {own}"


def _missing_ball(
    order: Sequence[SensorComparison], odd: SensorComparison, difference: float
) -> str:
    """A further cause of a first sensor that is late, or a last one that is early, by one ball."""
    numbers = {each.name: found[2] for each in order if (found := NAME.fullmatch(each.name))}
    balls = [each for each in order if numbers.get(each.name)]
    if len(balls) < 2:
        return ""
    first, last = balls[0], balls[-1]
    count = int(numbers[last.name]) - int(numbers[first.name])
    travel = last.simulated_arrival - first.simulated_arrival
    if not count > 0 or not abs(abs(difference) * count / travel - 1.0) < ONE_BALL:
        return ""
    if odd is order[0] and difference < 0.0:
        before, behind = order[:2]
    elif odd is order[-1] and difference > 0.0 and odd in balls:
        before, behind = order[-2:]
    else:
        return ""
    second = f"{'the ' * ('wall' in behind.name)}{behind.name}"
    return f", or whether a ball is missing between {before.name} and {second}"


def _amplified(sensors: Sequence[SensorComparison]) -> list[str]:
    """A note on an amplitude; ratios that are noted for each sensor are omitted."""
    calibrated = [
        each for each in sensors
        if each.unit != "V" and not each.lower_bound and each.peak_ratio > 0.0
    ]  # fmt: skip
    if len(calibrated) < MIN_SENSORS:
        return []
    arrivals = np.array([each.simulated_arrival for each in calibrated])
    found = _odd_one(arrivals, np.log([each.peak_ratio for each in calibrated]))
    if found is None or abs(found[1]) < MIN_AMPLITUDE:
        return []
    odd = calibrated[found[0]]
    if not 1.0 / NOTED < odd.peak_ratio < NOTED:
        return []
    others = [each.peak_ratio for each in calibrated if each is not odd]
    return [
        f"the simulated peak of {odd.name} is {shown_ratio(odd.peak_ratio)} the measured one, "
        f"those of the other sensors are {min(others):.3g} to {max(others):.3g} times the measured "
        f"ones: check the gain of {odd.name}{_end(odd)}"
    ]


def _end(sensor: SensorComparison, more: str = "") -> str:
    """Further causes of differences of a sensor on a wall."""
    return f"{more}, and the wall of the chain" if "wall" in sensor.name else ""


def _odd_one(arrivals: Array, values: Array) -> tuple[int, float] | None:
    """Index of the only value far from the others, and its distance from them."""
    found = []
    for k in range(len(values)):
        others = np.delete(values, k)
        spread = float(np.ptp(others))
        nearest = float(others[np.argmin(np.abs(others - values[k]))])
        # A wrong loss or material changes delays and amplitudes in proportion to the time.
        trend = np.polynomial.Polynomial.fit(np.delete(arrivals, k), others, 1)
        distances = values[k] - nearest, float(values[k] - trend(arrivals[k]))
        if min(map(abs, distances)) > IN_RANGES * spread and distances[0] * distances[1] > 0.0:
            found.append((k, float(values[k] - np.median(others))))
    return found[0] if len(found) == 1 else None

"""Notes on one sensor that differs from the others."""

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.fitting.odd_sensors import odd_sensor_notes
from hertzchain.fitting.sensor_comparison import SensorComparison


def sensor(name, simulated, delay):
    """The comparison of a sensor whose signal is early by a delay."""
    return SensorComparison(
        name, "N", "force", 1.0, 1.0, simulated - delay, simulated, 1e-7, 0.1, 1.0
    )


def notes_on(sensors):
    """Notes on sensors whose pulses are in the record."""
    times = 1e-6 * np.arange(40)
    columns = {f"{each.name} [N]": np.pad([1.0, 2.0, 1.0], (20, 17)) for each in sensors}
    (shot,) = hc.Traces.from_arrays(times, columns, noise=0.01).shots
    return odd_sensor_notes(sensors, shot, np.full(40, True), [])


def test_a_late_wall_may_be_due_to_the_number_of_balls():
    sensors = [
        sensor("ball 4", 1e-4, 0.0), sensor("ball 9", 2e-4, 1e-7), sensor("wall", 3e-4, -4e-5),
    ]  # fmt: skip
    (note,) = notes_on(sensors)
    assert "the measured signal of wall is 40 us late" in note
    assert note.endswith(
        "check the delay of its channel and its place, the number of balls, and the wall of the "
        "chain"
    )


@pytest.mark.parametrize(("first", "last", "places"), [
    # The pulse passes one ball in 20 us.
    (-2.1e-5, 0.0, "ball 4 and ball 9"), (0.0, 2.1e-5, "ball 9 and ball 14"),
    (2.1e-5, 0.0, ""), (0.0, -2.1e-5, ""), (-4.5e-5, 0.0, ""),
])  # fmt: skip
def test_a_delay_of_the_time_in_which_the_pulse_passes_a_ball_may_be_a_missing_ball(
    first, last, places
):
    (note,) = notes_on([
        sensor("ball 4", 1e-4, first), sensor("ball 9", 2e-4, 1e-7), sensor("ball 14", 3e-4, last),
    ])  # fmt: skip
    assert ("missing" in note) == bool(places)
    assert note.endswith(f", or whether a ball is missing between {places}" if places else "place")

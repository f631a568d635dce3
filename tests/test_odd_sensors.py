"""Notes on one sensor that differs from the others."""

import numpy as np

import hertzchain as hc
from hertzchain.fitting.odd_sensors import odd_sensor_notes
from hertzchain.fitting.sensor_comparison import SensorComparison


def test_a_late_wall_may_be_due_to_the_number_of_balls():
    def sensor(name, simulated, delay):
        return SensorComparison(
            name, "N", "force", 1.0, 1.0, simulated - delay, simulated, 1e-7, 0.1, 1.0
        )

    sensors = [
        sensor("ball 4", 1e-4, 0.0), sensor("ball 9", 2e-4, 1e-7), sensor("wall", 3e-4, -4e-5),
    ]  # fmt: skip
    times = 1e-6 * np.arange(40)
    columns = {f"{each.name} [N]": np.pad([1.0, 2.0, 1.0], (20, 17)) for each in sensors}
    (shot,) = hc.Traces.from_arrays(times, columns, noise=0.01).shots
    (note,) = odd_sensor_notes(sensors, shot, np.full(40, True), [])
    assert "the measured signal of wall is 40 us late" in note
    assert note.endswith(
        "check the delay of its channel and its place, the number of balls, and the wall of the "
        "chain"
    )

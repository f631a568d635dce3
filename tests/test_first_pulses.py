"""Durations of first pulses, and notes on broad and double ones, in data from SciPy."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter, peak_widths
from scipy_row import SPACING, chain, forces, recorded

import hertzchain as hc
from hertzchain.fitting.crossings import duration_above

pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")
END = 6.5e-4


def compared(change, seed=0, noise=0.05, names=("ball 5", "wall")):
    """Comparison of changed forces with the chain whose stiffness is nearly that of the data."""
    signals = {name: change(forces()[name]) for name in names}
    data = hc.Traces.from_arrays(*recorded(seed, noise=noise, signals=signals))
    return hc.simulate(chain(), until=END, times=3000).compare(data)


def shapes(found):
    """Notes on the shape of pulses."""
    return [each for each in found.notes if "first pulse of" in each]


def filtered(force, time):
    """The signal of an amplifier with a relaxation time."""
    part = SPACING / time
    return lfilter([part], [1.0, part - 1.0], force)


def second(force, late, size):
    """A force and its later copy."""
    at = np.arange(len(force)) - late / SPACING
    return force + size * np.interp(at, np.arange(len(force)), force, left=0.0)


def test_durations_are_the_widths_at_half_of_the_peaks():
    found = compared(lambda force: force)
    for each in found.sensors:
        own = hc.simulate(chain(), times=SPACING * np.arange(1000)).sensor(each.name)
        for force, duration in (
            (forces()[each.name], each.measured_duration), (own, each.simulated_duration)
        ):  # fmt: skip
            width = SPACING * peak_widths(force, [int(np.argmax(force))])[0][0]
            assert duration == pytest.approx(width, rel=0.01)
    line = next(each for each in found.summary(width=None).splitlines() if "half of its" in each)
    first = found.sensors[0]
    shown = (1e6 * first.measured_duration, 1e6 * first.simulated_duration)
    assert "ball 5 {:.3g} and {:.3g} us; wall".format(*shown) in line
    table = found.to_dataframe()
    assert table.measured_duration["wall"] == found.sensors[1].measured_duration
    assert table.attrs["units"]["simulated_duration"] == "s"


@pytest.mark.parametrize("noise", [0.05, 1.0, 4.0])
def test_pulses_of_the_right_shape_are_not_noted(noise):
    for seed in range(5):
        assert not shapes(compared(lambda force: force, seed, noise))


@pytest.mark.parametrize("change", [
    lambda force: filtered(force, 60e-6), lambda force: gaussian_filter1d(force, 40),
])  # fmt: skip
def test_broader_pulses_are_noted(change):
    found = compared(change)
    (note,) = shapes(found)
    assert "the measured first pulse of ball 5 and wall lasts" in note
    ratios = sorted(each.measured_duration / each.simulated_duration for each in found.sensors)
    assert "lasts {:.2g} to {:.2g} times as long".format(*ratios) in note
    assert ratios[0] > 1.5


def test_a_second_crest_is_noted_with_its_time():
    (note,) = shapes(compared(lambda force: second(force, 55e-6, 0.7)))
    assert note.startswith("the measured first pulse of ball 5")
    assert "a second crest, 5" in note
    assert "check for a second impact" in note


def test_a_small_peak_within_the_noise_has_no_duration():
    found = compared(lambda force: force, noise=forces()["ball 5"].max() / 8.0)
    assert np.isnan(found.sensors[0].measured_duration)


def test_a_duration_ends_at_the_last_crossing_before_the_signal_falls_to_a_quarter():
    times = np.arange(11.0)
    values = np.array([0, 0, 4, 1.8, 4, 0.8, 0, 4, 4, 0, 0])
    # From 1.5 to between 4 (at 4.0) and 5 (at 0.8), the level being 2.
    assert duration_above(times, values, 2.0) == pytest.approx(4.0 + 2.0 / 3.2 - 1.5)
    assert np.isnan(duration_above(times, values, 5.0))
    assert np.isnan(duration_above(times[2:], values[2:], 2.0))
    assert np.isnan(duration_above(times[:5], values[:5], 2.0))

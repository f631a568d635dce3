"""The passages of waves through a sensor, compared with contacts and with SciPy's peaks."""

import math
import re

import numpy as np
import pytest
from scipy.signal import find_peaks, peak_widths

import hertzchain as hc


@pytest.fixture(scope="module")
def run():
    chain = hc.Chain.uniform(30).replace(right_wall=hc.Wall.rigid())
    return hc.simulate(chain, until=75.0, times=3000)


def test_passages_are_those_of_the_contacts_beside_the_sensor(run):
    passages = run.sensor_force(15).passages(threshold=0.1)
    assert [each.direction for each in passages] == [1, -1]
    contacts = [run.waves().at(k) for k in (14, 15)]
    for i, passage in enumerate(passages):
        before, after = (events[i] for events in contacts)
        # A solitary wave passes both contacts in turn and is highest in the sensor in between.
        assert passage.time == pytest.approx(0.5 * (before.time + after.time), abs=2e-3)
        assert passage.impulse == pytest.approx(0.5 * (before.impulse + after.impulse), rel=2e-3)
        assert passage.width > max(before.width, after.width)
        assert passage.resolved


def test_the_first_passage_is_the_first_maximum(run):
    sensor = run.sensor_force(15)
    first, *_ = sensor.passages()
    assert first.peak == pytest.approx(sensor.first_maximum, rel=1e-6)
    assert first.time == pytest.approx(sensor.first_maximum_time, abs=1e-4)


def test_peaks_and_widths_are_those_of_the_saved_force(run):
    sensor, fine = run.sensor_force(9), np.linspace(0.0, 75.0, 60_001)
    force = hc.simulate(run.chain, times=fine).sensor(9)
    places, _ = find_peaks(force, prominence=0.1)
    found = sensor.passages(threshold=0.1)
    assert [each.time for each in found] == pytest.approx(fine[places], abs=2e-3)
    assert [each.peak for each in found] == pytest.approx(force[places], rel=1e-5)
    widths = peak_widths(force, places, rel_height=0.5)[0] * fine[1]
    assert [each.width for each in found] == pytest.approx(widths, rel=2e-3)


def test_peaks_include_the_static_force_and_amplitudes_do_not():
    chain = hc.Chain.uniform(20).replace(
        precompression=0.1, right_wall=hc.Wall.rigid(), held_by="force"
    )
    sensor = hc.simulate(chain, until=12.0, times=1200).sensor_force(8)
    first = sensor.passages(threshold=0.3)[0]
    assert sensor.static_force == pytest.approx(0.1)
    assert first.peak - first.amplitude == pytest.approx(0.1)
    assert first.peak == pytest.approx(sensor.first_maximum, rel=1e-5)


def test_passages_with_units_and_too_few_saved_times():
    chain = hc.Chain.from_materials("5 mm", "steel-52100", beads=12).struck_by(velocity=0.02)
    run = hc.simulate(chain, until="400 us", times=2000)
    (passage,) = run.sensor_force("ball 6").passages(threshold=0.1)
    assert repr(passage).startswith("SensorPassage(bead 7, to the right: ")
    assert " us; width " in repr(passage)
    sparse = hc.simulate(chain, until="400 us", times=40).sensor_force("ball 6")
    with pytest.warns(hc.InputWarning, match="fewer than 8 saved times") as shown:
        (rough,) = sparse.passages(threshold=0.1)
    advised = int(re.search(r"times=(\d+) is enough", str(shown[0].message))[1])
    enough = hc.simulate(chain, until="400 us", times=advised).sensor_force("ball 6")
    (passage,) = enough.passages(threshold=0.1)
    assert 8.0 <= passage.samples <= 20.0
    assert "unresolved" in repr(rough)
    assert math.isclose(rough.peak, passage.peak, rel_tol=0.1)
    with pytest.warns(hc.IncompleteWarning):
        few = hc.simulate(chain, until="400 us", times=5).sensor_force("ball 6")
    with pytest.raises(hc.InputError, match=rf"the run has 5; times={advised} is enough"):
        few.passages()


def test_a_sensor_before_the_pulse_has_no_passages(run):
    with pytest.warns(hc.IncompleteWarning):
        early = hc.simulate(run.chain, until=2.0, times=400).sensor_force(29)
    assert early.passages() == () or max(each.amplitude for each in early.passages()) < 1e-9


def test_thresholds_are_checked(run):
    with pytest.raises(hc.InputError, match="threshold"):
        run.sensor_force(15).passages(threshold=2.0)

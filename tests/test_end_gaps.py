"""Gaps behind the last ball with a sensor, in data integrated by SciPy."""

import functools

import pytest
from scipy_row import FACTOR, FREE, LOSS_TIME, TRUTH, VELOCITY, chain, forces, recorded

import hertzchain as hc
from hertzchain.fitting import gap_causes
from hertzchain.fitting.end_gaps import end_gaps, values_before_waves_return
from hertzchain.fitting.fit import fit_experiment, fitted

CELL = 50e6
LAST = 15


def with_cell(*, known=False):
    """The row with a load cell; its velocity and loss may be those of the data."""
    row = chain(right_wall=hc.Wall(CELL, exponent=1, loss=hc.Elastic()))
    velocities = row.velocities * VELOCITY / row.velocities.max()
    return row.replace(loss=hc.Viscoelastic(LOSS_TIME), velocities=velocities) if known else row


@functools.cache
def undiagnosed(gap, sensors, behind=LAST, free=tuple(FREE)):
    """The fit of a row with a load cell, without the gap of the data."""
    signals = forces(gap=gap, behind=behind, cell=FACTOR * CELL)  # a fit scales all contacts
    data = hc.Traces.from_arrays(*recorded(signals={name: signals[name] for name in sensors}))
    known = "loss.time" not in free
    return fit_experiment(data, with_cell(known=known), lambda result, *_: result, free=free)


SENSORS = "ball 5", "ball 10", "wall"


@pytest.mark.long
def test_a_gap_in_front_of_a_load_cell_is_found_although_the_fit_without_it_is_far_away():
    result = undiagnosed(20e-6, SENSORS, free=("stiffness", "time_offset"))
    early = {str(name): value for name, value in values_before_waves_return(result).items()}
    assert result.chi2 > 100.0 * result.goodness.freedom
    assert early["stiffness"] == pytest.approx(TRUTH["stiffness"], rel=1e-2)
    assert early["time_offset"] == pytest.approx(TRUTH["time_offset"], abs=1e-6)
    found = end_gaps(result)
    assert len(found) == 3
    best = min(found.values(), key=lambda each: each.cost)
    assert str(best.name) == "right_wall.gap"
    assert best.size == pytest.approx(20e-6, rel=0.15)


@pytest.mark.long
@pytest.mark.parametrize(("size", "sensors", "behind", "name"), [
    (8e-6, SENSORS, LAST, "right_wall.gap"), (20e-6, SENSORS, LAST, "right_wall.gap"),
    (8e-6, SENSORS[:2], LAST, "right_wall.gap"), (8e-6, SENSORS, 12, "gap[12-13]"),
])  # fmt: skip
def test_a_gap_behind_the_last_sensor_is_fitted(size, sensors, behind, name):
    result = undiagnosed(size, sensors, behind)
    assert not result.describes
    found = [each.result for each in gap_causes.gap_causes(result, {}, fitted)]
    (best,) = (each for each in found if each.describes)
    assert abs(best.values[name] - size) < 4.0 * best.errors[name]


@pytest.mark.long
def test_a_scan_finds_a_gap_in_front_of_a_load_cell():
    scan = hc.scan_defects(undiagnosed(20e-6, SENSORS))
    assert scan.best == "right_wall.gap"
    assert scan.sizes[-1] == pytest.approx(20e-6, rel=0.15)


def test_the_signal_of_a_load_cell_alone_has_no_values_without_the_gap():
    signals = {"wall": forces(cell=FACTOR * CELL)["wall"]}
    data = hc.Traces.from_arrays(*recorded(signals=signals))
    result = fit_experiment(data, with_cell(), lambda result, *_: result, free=["stiffness"])
    assert end_gaps(result) == {}

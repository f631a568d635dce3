"""Gaps behind the last ball with a sensor, in data integrated by SciPy."""

import functools

import pytest
from scipy_row import FACTOR, FREE, TRUTH, chain, forces, recorded

import hertzchain as hc
from hertzchain.fitting import gap_causes
from hertzchain.fitting.end_gaps import end_gaps, values_before_waves_return
from hertzchain.fitting.fit import fit_experiment, fitted

CELL = 50e6
LAST = 15


def with_cell():
    return chain(right_wall=hc.Wall(CELL, exponent=1, loss=hc.Elastic()))


@functools.cache
def undiagnosed(gap, sensors, behind=LAST, free=tuple(FREE)):
    """The fit of a row with a load cell, without the gap of the data."""
    signals = forces(gap=gap, behind=behind, cell=FACTOR * CELL)  # a fit scales all contacts
    data = hc.Traces.from_arrays(*recorded(signals={name: signals[name] for name in sensors}))
    return fit_experiment(data, with_cell(), lambda result, *_: result, free=free)


SENSORS = "ball 5", "ball 10", "wall"


def test_a_gap_in_front_of_a_load_cell_is_found_although_the_fit_without_it_is_far_away():
    result = undiagnosed(20e-6, SENSORS, free=("stiffness", "time_offset"))
    early = {str(name): value for name, value in values_before_waves_return(result).items()}
    assert abs(result.values["stiffness"] / TRUTH["stiffness"] - 1.0) > 0.2
    # The fixed velocity and loss of this chain are not those of the data.
    assert early["stiffness"] == pytest.approx(TRUTH["stiffness"], rel=0.1)
    assert early["time_offset"] == pytest.approx(TRUTH["time_offset"], abs=5e-6)
    found = end_gaps(result)
    names = [str(name) for name in found]
    assert names == [*(f"gap[{k}-{k + 1}]" for k in range(10, LAST)), "right_wall.gap"]
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

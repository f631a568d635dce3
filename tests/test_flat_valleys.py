"""Gaps in front of the first sensor, which a fit may not distinguish from the time offset."""

import numpy as np
import pytest
from scipy_row import FREE, TRUTH, chain, traces

import hertzchain as hc

GAP = "gap[2-3]"
OFFSET = TRUTH["time_offset"]


@pytest.mark.parametrize("start", [20e-6, pytest.param(30e-6, marks=pytest.mark.long)])
def test_a_gap_that_only_delays_the_signals_is_not_determined(start):
    # The first sensor is in ball 5, and ball 2 has left ball 1 before it reaches ball 3.
    starts = {GAP: start, "time_offset": OFFSET - (start - 20e-6) / 0.25}
    result = hc.fit(traces(gap=20e-6, behind=2), chain(), free=[*FREE, GAP], start=starts)
    assert result.describes
    (weak,) = (each for each in result.weak if GAP in each.weights)
    assert set(weak.weights) == {GAP, "time_offset"}
    assert str(weak) in result.summary(width=None)
    assert not result.errors[GAP] < 10e-6
    # The others agree with the truth within their errors.
    for name in ("stiffness", "struck_by.velocity", "loss.time"):
        assert abs(result.values[name] - TRUTH[name]) < 3.5 * result.errors[name]


def test_the_error_of_a_smaller_gap_is_that_of_chi_squared():
    # With the gap fixed beside its optimum, chi-squared of all others rises by 25 at five errors.
    result = hc.fit(
        traces(gap=6e-6, behind=2), chain(), free=[*FREE, GAP],
        start={GAP: 6e-6, "time_offset": OFFSET},
    )  # fmt: skip
    error = result.errors[GAP]
    assert abs(result.values[GAP] - 6e-6) < 3.5 * error < 0.1e-6
    rises = []
    for sign in (1.0, -1.0):
        gaps = np.zeros(15)
        gaps[2] = result.values[GAP] + sign * 5.0 * error
        start = {"time_offset": result.values["time_offset"]}
        beside = hc.fit(traces(gap=6e-6, behind=2), chain(gaps=gaps), free=FREE, start=start)
        rises.append(beside.chi2 - result.chi2)
    assert np.mean(rises) == pytest.approx(25.0, rel=0.3)


def forecast(gap):
    values = {**TRUTH, GAP: gap}
    del values["time_offset"]
    plan = hc.forecast(
        chain(), ["ball 5", "ball 10", "wall"], noise="0.1 N", interval="0.7 us", until="640 us",
        free=[*FREE, GAP], start=values,
    )  # fmt: skip
    return dict(zip(plan.names, plan.sigmas, strict=True)), plan


def test_a_forecast_marks_a_gap_that_only_delays_the_signals():
    # The fits above show that the data of SciPy do not determine it, either.
    errors, plan = forecast(20e-6)
    (weak,) = (each for each in plan.weak if GAP in each.weights)
    assert set(weak.weights) == {GAP, "time_offset"}
    assert str(weak) in plan.summary(width=None)
    assert not errors[GAP] < 10e-6
    assert errors["stiffness"] < 0.02


def test_a_forecast_of_a_small_gap_has_the_error_of_the_fit_to_independent_data():
    errors, plan = forecast(6e-6)
    result = hc.fit(
        traces(gap=6e-6, behind=2), chain(), free=[*FREE, GAP],
        start={GAP: 6e-6, "time_offset": OFFSET},
    )  # fmt: skip
    assert errors[GAP] == pytest.approx(result.errors[GAP], rel=0.3)
    assert not any(GAP in each.weights for each in plan.weak)

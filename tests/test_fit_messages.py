"""Warnings and advice of fits to traces that SciPy computed."""

import re

import numpy as np
import pytest
from scipy_row import FREE, TRUTH, chain, recorded, traces

import hertzchain as hc
from hertzchain.fitting.noise import saturated


@pytest.fixture(scope="module")
def good():
    return hc.fit(traces(), chain(), free=FREE)


def test_traces_of_scipy_are_recovered(good):
    assert good.describes
    deviations = [(good.values[name] - true) / good.errors[name] for name, true in TRUTH.items()]
    assert np.abs(deviations).max() < 3.5


def test_a_fitted_wall_keeps_the_yield_strength_of_its_material(good):
    # Johnson, Eq. (4.24): the pressure is proportional to the root of the overlap, which is
    # proportional to (v^2/k)^(2/5).
    start = hc.hertz_range(chain()).yield_ratio[-1]
    change = (0.25 / 0.26) ** 0.4 * 0.97**-0.2
    assert hc.hertz_range(good.chain).yield_ratio[-1] == pytest.approx(change * start, rel=2e-3)
    # Annealed steel yields long before the balls do.
    assert start > 5.0
    assert good.chain.right_wall.material.name == "steel-304"
    assert "pressure / yield" in good.summary()
    with pytest.warns(hc.ModelRangeWarning, match="right wall"):
        hc.simulate(good.chain)


def test_a_wall_with_stiffness_and_material_is_kept_by_chain_files(good, tmp_path):
    (tmp_path / "fitted.toml").write_text(good.chain_toml())
    wall = hc.load_chain(tmp_path / "fitted.toml").right_wall
    assert wall.stiffness == good.chain.right_wall.stiffness
    assert wall.material.yield_strength == hc.material("steel-304").yield_strength
    assert repr(wall).startswith("Wall(steel-304, stiffness = ")


def clipped(columns, limit, step=0.0):
    """Columns of which that of the wall is rounded and clipped by a digitiser."""
    wall = columns["wall [N]"]
    rounded = step * np.round(wall / step) if step else wall
    return columns | {"wall [N]": np.minimum(rounded, limit)}


@pytest.mark.parametrize("step", [0.0, 0.0122, 0.05, 0.25])
@pytest.mark.parametrize("limit", [30, 38, 40, 43, 44, 45, 46, 47, 48, 49, 50, 51])
def test_every_clipped_crest_is_recognised(limit, step):
    # The largest force is 52.67 N.
    level = step * round(limit / step) if step else float(limit)
    for seed in range(10):
        times, columns = recorded(seed)
        wall = clipped(columns, level, step)["wall [N]"]
        signal = hc.Traces.from_arrays(times, {"wall [N]": wall}).shots[0].signals[0]
        assert not signal.valid[wall == level].any()
        # Nothing else but two neighbours is omitted, apart from dips of the noise.
        assert np.count_nonzero(~signal.valid) <= np.count_nonzero(wall == level) + 8


@pytest.mark.parametrize("noise", [0.05, 0.2])
@pytest.mark.parametrize("step", [0.05, 0.5, 1.0])
def test_rounded_crests_are_not_regarded_as_clipped(step, noise):
    found = 0
    for seed in range(40):
        _, columns = recorded(seed, noise=noise)
        for values in columns.values():
            found += bool(saturated(step * np.round(values / step)).any())
            found += bool(saturated(values).any())
    # Of 240 signals.
    assert found <= 2


def test_traces_are_rejected_if_most_of_a_pulse_is_clipped():
    times, columns = recorded()
    wall = columns["wall [N]"]
    # Later pulses of the wall are smaller.
    peak = int(np.argmax(wall))
    ends = np.flatnonzero(wall < 0.05 * 13.0)
    duration = ends[ends > peak][0] - ends[ends < peak][-1] - 1
    above = np.count_nonzero(wall > 13.0)
    with pytest.raises(hc.InputError, match="saturated at 13 N during most of its pulse") as caught:
        hc.Traces.from_arrays(times, clipped(columns, 13.0))
    counts = [int(each) for each in re.findall(r"\((\d+) of (\d+) samples\)", str(caught.value))[0]]
    assert counts == pytest.approx([above, duration], rel=0.15)
    assert above > 0.5 * duration


@pytest.mark.parametrize("limit", [30.0, 45.0])
def test_a_fit_without_clipped_samples_recovers_the_truth(limit):
    result = hc.fit(traces(change=lambda columns: clipped(columns, limit)), chain(), free=FREE)
    assert result.describes
    assert "samples of wall in shot 1 are saturated" in result.summary()
    deviations = [(result.values[name] - TRUTH[name]) / result.errors[name] for name in FREE]
    assert np.abs(deviations).max() < 3.5

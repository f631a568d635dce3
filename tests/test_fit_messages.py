"""Warnings and advice of fits to traces that SciPy computed."""

import numpy as np
import pytest
from scipy_row import FREE, TRUTH, chain, traces

import hertzchain as hc


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

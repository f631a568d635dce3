"""Crests of noisy records, which must not depend on a model."""

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.traces.crests import crest_of_record


@pytest.mark.parametrize(
    "sigma", [1e-3, *(pytest.param(each, marks=pytest.mark.long) for each in (0.02, 0.05))]
)
def test_the_error_of_a_noisy_crest_is_that_of_its_scatter(sigma):
    times, rng = np.linspace(-3.0, 3.0, 301), np.random.default_rng(1)
    pulse = 1.0 / np.cosh(times) ** 4
    found = [crest_of_record(times, pulse + sigma * rng.standard_normal(301), sigma)
             for _ in range(100)]  # fmt: skip
    deviations = np.array([each.height for each in found]) - 1.0
    errors = np.array([each.error for each in found])
    assert abs(deviations.mean()) < 0.1 * sigma
    assert np.sqrt(np.mean((deviations / errors) ** 2)) == pytest.approx(1.0, abs=0.25)
    # A polynomial in a window of known width, corrected by the true form, has 0.25 sigma.
    assert np.sqrt(np.mean(deviations**2)) < 0.4 * sigma


def test_the_crest_without_noise_is_that_between_samples():
    times = np.linspace(-3.0, 3.0, 201) + 0.01
    crest = crest_of_record(times, 1.0 / np.cosh(times) ** 4, 0.0)
    assert crest.height == pytest.approx(1.0, abs=1e-6)
    assert crest.error < 1e-4


def test_the_largest_of_few_samples_is_returned():
    crest = crest_of_record(np.arange(9.0), np.array([0, 0, 0, 0.2, 1.0, 0.1, 0, 0, 0]), 1e-3)
    assert crest.height == 1.0
    assert np.isnan(crest.error)


@pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
@pytest.mark.filterwarnings("ignore::hertzchain.errors.InputWarning")
@pytest.mark.parametrize("noise", [0.0, 6.0])
def test_the_measured_peak_of_narrow_crests_on_a_broad_signal_is_that_of_the_record(noise):
    balls = hc.Chain.from_materials("5 mm", "steel-52100", beads=12)
    row = balls.struck_by(mass="80 g", radius=np.inf, velocity="0.767 m/s")
    row = row.replace(right_wall=hc.Wall(stiffness="20 kN/mm", exponent=1))
    times = 1e-6 * np.arange(900)
    force = np.concatenate((np.zeros(100), hc.simulate(row, times=times).sensor("wall")))
    seen = force + noise * np.random.default_rng(2).standard_normal(1000)
    data = hc.Traces.from_arrays(1e-6 * np.arange(1000), {"wall [N]": seen}, noise=max(noise, 0.01))
    models = [
        row, row.replace(loss=hc.ElasticPlastic()), row.replace(loss=hc.ElasticPlastic(factor=2.8)),
        row.replace(loss=hc.Restitution(0.7)),
        row.replace(right_wall=hc.Wall(stiffness="1 kN/mm", exponent=1)),
    ]  # fmt: skip
    walls = [hc.simulate(each, until=1e-3, times=4000).compare(data).sensors[0] for each in models]
    for each in walls:
        assert each.measured_peak == pytest.approx(walls[0].measured_peak, rel=1e-9)
        assert each.measured_arrival == pytest.approx(walls[0].measured_arrival, abs=1e-9)
    true = hc.simulate(row, until=1e-3).wall_force().peak
    allowed = 3.0 * walls[0].peak_error + 1e-4 * true
    assert walls[0].measured_peak == pytest.approx(true, abs=allowed)
    assert allowed < 0.02 * true

"""Steps of a digitiser are found from the levels of samples, however these are printed."""

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.traces.noise import digitiser_step


def pulses(samples=1400):
    after = (np.arange(samples) - 200.0) / 60.0
    return sum(
        height * np.sin(np.pi * np.clip(after - begin, 0.0, 1.0)) ** 3
        for begin, height in ((0.0, 3.0), (8.0, 1.8))
    )


def rounded(step, noise=0.3, offset=0.0, odd=False, text="%.17g"):
    """Samples on a grid, the first of which may be off it, as they are printed."""
    exact = pulses() + noise * step * np.random.default_rng(0).standard_normal(1400)
    values = step * (np.round(exact / step) + offset)
    values[0] += 0.1 * step * odd
    return np.array([float(text % each) for each in values])


@pytest.mark.parametrize("odd", [False, True])
@pytest.mark.parametrize("offset", [0.0, 0.37])
@pytest.mark.parametrize("text", ["%.17g", "%.8g", "%.5g", "%.4g", "%.3f"])
@pytest.mark.parametrize("step", [0.5, 0.04, 0.03125, 0.0078125])
def test_step_is_the_spacing_of_levels(step, text, offset, odd):
    for noise in (0.0, 0.3, 1.5):
        found = digitiser_step(rounded(step, noise, offset, odd, text))
        assert found == pytest.approx(step, rel=0.02)


def test_smooth_samples_have_no_step():
    for seed in range(100):
        rng = np.random.default_rng(seed)
        after = np.arange(600) + rng.uniform(0.0, 1.0) - 400.0
        shape = np.sin(np.pi * np.clip(after / rng.uniform(3.0, 120.0), 0.0, 1.0))
        assert digitiser_step(shape ** rng.uniform(1.0, 4.0)) == 0.0


@pytest.mark.parametrize("odd", [False, True])
def test_few_other_levels_before_the_pulse_are_noise_and_not_accuracy(odd):
    step = 0.03125
    values = rounded(step, 0.0, odd=odd, text="%.5g")
    values[[40, 90, 130]] = step
    ((_, signal),) = hc.Traces.from_arrays(1e-6 * np.arange(1400), {"ball 4 [V]": values})
    assert signal.step == pytest.approx(step, rel=0.01)
    assert not signal.noiseless
    assert signal.coarse
    assert signal.sigma == pytest.approx(step / 12.0**0.5, rel=0.5)

"""Noise that is correlated or smaller than the steps of the digitiser; its statistics are known."""

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy_row import FREE, TRUTH, chain, recorded

import hertzchain as hc
from hertzchain.fitting.goodness import goodness_of
from hertzchain.fitting.noise import independent_samples, noise_of


def first_order(rng, rho, shape):
    """Noise of unit variance whose successive samples have the correlation rho."""
    white = rng.standard_normal((*shape[:-1], shape[-1] + 500))
    return lfilter([(1.0 - rho**2) ** 0.5], [1.0, -rho], white)[..., 500:]


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.8])
def test_independent_samples_of_first_order_noise_are_counted(rho):
    noise = first_order(np.random.default_rng(1), rho, (200, 400))
    counts = [independent_samples(each) for each in noise]
    # The variance of a mean of first-order noise is (1 + rho)/(1 - rho) times that of white noise.
    assert np.median(counts) == pytest.approx(400.0 * (1.0 - rho) / (1.0 + rho), rel=0.1)


@pytest.mark.parametrize("rho", [0.0, 0.7, 0.85])
def test_estimates_of_a_slow_noise_are_not_too_small(rho):
    noise = first_order(np.random.default_rng(2), rho, (400, 90))
    assert np.mean([noise_of(each) ** 2 for each in noise]) == pytest.approx(1.0, abs=0.12)


@pytest.mark.parametrize(("rho", "before"), [(0.84, 108), (0.954, 108), (0.954, 500)])
def test_slow_noise_is_described(rho, before):
    """Residuals are the noise itself, as if the model were true."""
    rng, times = np.random.default_rng(3), 0.7e-6 * np.arange(before + 1000)
    pulse = 1000.0 * (times >= 0.7e-6 * before)
    good = []
    for _ in range(100):
        noise = first_order(rng, rho, (3, len(times)))
        names = ("ball 5 [N]", "ball 10 [N]", "wall [N]")
        traces = hc.Traces.from_arrays(times, dict(zip(names, pulse + noise, strict=True)))
        residuals = np.concatenate(
            [own / signal.noise for own, (_, signal) in zip(noise, traces, strict=True)]
        )
        good.append(goodness_of(traces, residuals, np.ones(len(residuals), bool), 0))
    # The true model is not rejected.
    assert np.mean([each.describes or each.undecided for each in good]) >= 0.95
    # Of a noise with two or three independent samples before the pulse, less can be said.
    hardly_known = rho == 0.954 and before == 108
    assert np.mean([each.describes for each in good]) >= (0.5 if hardly_known else 0.9)
    assert (np.mean([each.undecided for each in good]) > 0.2) == hardly_known
    # The excess is in units of its standard deviation.
    assert 0.5 < np.std([each.excess for each in good]) < 1.8


@pytest.mark.parametrize("rho", [0.0, 0.5])
def test_slow_residuals_of_a_wrong_model_do_not_excuse_themselves(rho):
    """Of 2000 residuals, a slow misfit leaves few independent ones, but the noise is not slow."""
    rng, times = np.random.default_rng(4), 0.7e-6 * np.arange(1108)
    pulse = 1000.0 * (times >= 0.7e-6 * 108)
    # A variance of 2.5, and a chi-squared of 2.5 + 1 = 3.5 times the expectation.
    missed = 5.0**0.5 * np.sin(2.0 * np.pi * np.arange(1108) / 700.0)
    good = []
    for _ in range(50):
        noise = first_order(rng, rho, (2, len(times)))
        names = ("ball 5 [N]", "wall [N]")
        traces = hc.Traces.from_arrays(times, dict(zip(names, pulse + noise, strict=True)))
        residuals = np.concatenate(
            [(own + missed) / signal.noise for own, (_, signal) in zip(noise, traces, strict=True)]
        )
        good.append(goodness_of(traces, residuals, np.ones(len(residuals), bool), 0))
    assert max(each.effective_samples for each in good) < 40.0
    assert not any(each.describes for each in good)
    assert np.mean([each.undecided for each in good]) <= 0.02
    # 108 samples before the pulse and 1108 residuals determine the variance of each signal.
    slow = (1.0 + rho) / (1.0 - rho)
    known = (slow / 108 + slow / 1108) ** 0.5  # 2/2 each: two signals
    found = np.median([each.uncertainty for each in good])
    assert found == pytest.approx(known, rel=0.15)


def rounded(step, seed, noise=0.05):
    times, columns = recorded(seed, noise=noise)
    return hc.Traces.from_arrays(times, {k: step * np.round(v / step) for k, v in columns.items()})


@pytest.mark.parametrize("step", [0.5, 1.0])
def test_errors_account_for_coarse_steps(step):
    squares = []
    for seed in range(4):
        data = rounded(step, seed)
        result = hc.fit(data, chain(), free=FREE)
        text = result.summary()
        assert "multiply all errors" not in text
        assert "the residuals show" not in text
        assert f"are rounded to steps of {step:g} N" in text
        squares += [((result.values[k] - TRUTH[k]) / result.errors[k]) ** 2 for k in FREE]
    # Errors that are 2.8 times too small, as for random rounding errors, give 8.
    assert np.mean(squares) < 3.0


def test_coarse_steps_are_part_of_the_noise():
    for _, signal in rounded(1.0, 0):
        assert signal.coarse
        assert signal.sigma == pytest.approx(np.hypot(signal.noise, 1.0 / 12.0**0.5))
        assert signal.sigma >= 0.2886
    assert "noise 0.289 N" in repr(rounded(1.0, 0))
    # A fine digitiser changes nothing: its rounding is part of the measured noise.
    for _, signal in rounded(0.01, 0):
        assert not signal.coarse
        assert signal.sigma == signal.noise

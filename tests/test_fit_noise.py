"""Noise that is correlated or smaller than the steps of the digitiser; its statistics are known."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline
from scipy.signal import butter, lfilter
from scipy_row import BEFORE, FREE, SPACING, TRUTH, chain, forces, recorded
from synthetic_traces import bench, signals
from synthetic_traces import recorded as synthetic

import hertzchain as hc
from hertzchain.fitting.autocorrelation import correlation_length
from hertzchain.fitting.fit import fit_with
from hertzchain.fitting.goodness import goodness_of
from hertzchain.fitting.parameters import default_names
from hertzchain.fitting.settings import Settings
from hertzchain.traces.noise import (
    autocorrelation,
    correlation_of_rounding,
    independent_samples,
    noise_before_rounding,
    noise_of,
    onset,
    unbiased_first_lag,
)
from hertzchain.traces.quiet_parts import only_noise, quiet_counts


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


def ratio_of_errors(noise, samples_per_independent):
    """True error of a mean over the estimated one: the standard deviation of pulls."""
    lengths = np.array([correlation_length(each) for each in noise])
    return np.mean(samples_per_independent / lengths) ** 0.5


@pytest.mark.parametrize("rho", [0.5, 0.8])
@pytest.mark.parametrize("samples", [60, 150, 1000])
def test_correlations_of_short_records_are_not_too_small(samples, rho):
    noise = first_order(np.random.default_rng(5), rho, (400, samples))
    assert 0.9 < ratio_of_errors(noise, (1.0 + rho) / (1.0 - rho)) < 1.15


@pytest.mark.parametrize("rho", [0.3, 0.9])
def test_the_mean_does_not_bias_the_correlation_of_successive_samples(rho):
    noise = first_order(np.random.default_rng(2), rho, (4000, 50))
    # Without a correction, the bias is -(1 + 4 rho)/50, and its own error of second order.
    mean = np.mean([unbiased_first_lag(autocorrelation(each)[1], 50) for each in noise])
    assert mean == pytest.approx(rho, abs=0.3 * (1.0 + 4.0 * rho) / 50)


@pytest.mark.parametrize("cutoff", [0.2, 0.5])
def test_correlations_of_smooth_noise_are_found(cutoff):
    filtered = butter(2, cutoff)
    response = lfilter(*filtered, [1.0, *np.zeros(1000)])
    white = np.random.default_rng(6).standard_normal((200, 1000))
    noise = lfilter(*filtered, white)[:, 500:]
    length = response.sum() ** 2 / (response @ response)
    assert 0.9 < ratio_of_errors(noise, length) < 1.15
    # In short records, the bias of the coefficients is not amplified.
    found = np.median([correlation_length(each[:100]) for each in noise])
    assert 0.9 * length < found < 1.2 * length


@pytest.mark.long
def test_errors_of_fits_include_the_correlation_of_the_noise():
    """Pulls of the true values in 20 records of 100 samples have unit variance."""
    rng, spacing = np.random.default_rng(7), 4e-6
    truth = {"stiffness": 1.0, "struck_by.velocity": 0.3, "time_offset": 100e-6}
    times, seen = signals(bench(beads=10), 400e-6, 100e-6, balls=(3, 6), spacing=spacing)
    pulls = []
    for _ in range(20):
        noise = 0.1 * first_order(rng, 0.8, seen.T.shape).T
        names = ("ball 3 [N]", "ball 6 [N]", "wall [N]")
        traces = hc.Traces.from_arrays(times, dict(zip(names, (seen + noise).T, strict=True)))
        result = hc.fit(traces, bench(beads=10), free=list(truth), starts=1)
        pulls.append([(result.values[k] - truth[k]) / result.errors[k] for k in truth])
    # The standard deviation of 60 numbers, of which some are correlated.
    assert 0.7 < np.std(pulls) < 1.3


@pytest.mark.parametrize("rho", [0.0, 0.7, 0.85])
def test_estimates_of_a_slow_noise_are_not_too_small(rho):
    noise = first_order(np.random.default_rng(2), rho, (400, 90))
    assert np.mean([noise_of(each) ** 2 for each in noise]) == pytest.approx(1.0, abs=0.12)


@pytest.mark.parametrize(
    "filtered",
    [butter(2, 0.1), butter(2, 0.2), butter(4, 0.1), butter(4, 0.2), (np.ones(10), [1.0])],
)
def test_noise_behind_a_low_pass_is_estimated(filtered):
    """Its samples are not of first order; their independent number follows from the response."""
    response = lfilter(*filtered, [1.0, *np.zeros(1000)])
    covariances = np.correlate(response, response, "full")[1000:1100]
    variance = covariances[0]
    mean = (variance + 2.0 * covariances[1:] @ (1.0 - np.arange(1, 100) / 100.0)) / 100.0
    white = np.random.default_rng(11).standard_normal((400, 1100))
    noise = lfilter(*filtered, white)[:, 1000:] / variance**0.5
    assert np.mean([noise_of(each) ** 2 for each in noise]) ** 0.5 == pytest.approx(1.0, abs=0.05)
    counts = [independent_samples(each) for each in noise]
    assert np.median(counts) == pytest.approx(variance / mean, rel=0.3)


@pytest.mark.long
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
    # Of a noise with two or three independent samples before the pulse, less can be said.
    hardly_known = rho == 0.954 and before == 108
    # The true model is not rejected.
    accepted = np.mean([each.describes or each.undecided for each in good])
    assert accepted >= (0.9 if hardly_known else 0.95)
    assert np.mean([each.describes for each in good]) >= (0.5 if hardly_known else 0.9)
    assert (np.mean([each.undecided for each in good]) > 0.2) == hardly_known
    # The excess is in units of its standard deviation.
    assert 0.5 < np.std([each.excess for each in good]) < (2.5 if hardly_known else 1.8)


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


def test_the_mean_before_the_pulse_makes_the_noise_less_certain():
    times = 1e-6 * np.arange(200)
    noise = np.random.default_rng(5).standard_normal((400, 200))
    squares, errors = [], []
    for own in noise:
        traces = hc.Traces.from_arrays(times, {"wall [N]": own + 1000.0 * (times > 29.5e-6)})
        ((_, signal),) = traces
        good = goodness_of(traces, own / signal.noise, np.ones(200, bool), 0)
        squares.append(signal.noise**2)
        errors.append(good.noise_error)
    # The variance of n samples about their mean has n - 1 degrees of freedom.
    assert np.median(errors) == pytest.approx((2.0 / (signal.before - 1)) ** 0.5, rel=1e-6)
    assert np.std(squares) / np.mean(squares) == pytest.approx(np.median(errors), rel=0.15)


@pytest.mark.long
@pytest.mark.parametrize(
    ("rho", "samples", "before"), [(0.0, 60, 30), (0.8, 60, 30), (0.5, 200, 30), (0.5, 1000, 60)]
)
def test_few_samples_before_the_pulse_do_not_exclude_correlated_noise(rho, samples, before):
    """Residuals are the noise itself; 30 samples of correlated noise often look random."""
    rng, times = np.random.default_rng(12), 1e-6 * np.arange(samples)
    pulse = 1000.0 * (times >= 1e-6 * before)
    rejected = 0
    for noise in first_order(rng, rho, (300, samples)):
        traces = hc.Traces.from_arrays(times, {"wall [N]": pulse + noise})
        ((_, signal),) = traces
        good = goodness_of(traces, noise / signal.noise, np.ones(samples, bool), 0)
        rejected += not good.describes and not good.undecided
    assert rejected <= 0.05 * 300


@pytest.mark.long
@pytest.mark.parametrize(("samples", "before"), [(60, 26), (200, 40), (1000, 100)])
def test_a_wrong_stiffness_is_found_in_short_records(samples, before):
    true = bench(beads=5, behind=3)
    # Forces of the first passage: the first sensor begins after 32 us.
    spacing = 158e-6 / (samples - before)
    times, seen = signals(
        true, samples * spacing, before * spacing - 32e-6, balls=(3,), spacing=spacing
    )
    free, found = ["struck_by.velocity", "time_offset"], []
    for seed in range(20):
        noise = 0.01 * seen.max(axis=0) * np.random.default_rng(seed).standard_normal(seen.shape)
        columns = dict(zip(["ball 3 [N]", "wall [N]"], (seen + noise).T, strict=True))
        traces = hc.Traces.from_arrays(times, columns)
        found += [fit_with(traces, [bench(beads=5, behind=3, factor=1.05)], Settings(free), 1)]
    assert np.mean([not each.describes for each in found]) >= 0.9
    assert samples == 60 or not any(each.goodness.undecided for each in found)


def test_a_verdict_on_known_noise_does_not_ask_for_it():
    rng, times = np.random.default_rng(13), 1e-6 * np.arange(60)
    traces = hc.Traces.from_arrays(times, {"wall [N]": 100.0 * np.sin(1e5 * times)}, noise=1.0)
    residuals = 1.3 * rng.standard_normal(60)
    verdict = goodness_of(traces, residuals, np.ones(60, bool), 0).verdict
    assert "cannot be decided" in verdict
    assert "Record more samples. If the residuals" in verdict


@pytest.mark.parametrize("time", [2.0, 5.0])
def test_slow_noise_does_not_end_the_samples_before_the_pulse(time):
    """The pulse begins at a known sample; correlation times are in samples."""
    rng, begin = np.random.default_rng(10), 100
    after = np.arange(280) - begin
    pulse = np.where(after > 0, np.sin(np.pi * np.clip(after, 0, 40) / 40.0) ** 2, 0.0)
    noise = first_order(rng, np.exp(-1.0 / time), (100, len(pulse)))
    found = [onset(pulse + 0.02 * each) for each in noise]
    assert np.mean([abs(each - begin) <= 15 for each in found]) >= 0.95


@pytest.mark.parametrize("begin", [30, 100])
def test_a_small_first_pulse_is_not_slow_noise(begin):
    after = np.arange(400) - begin
    small = 0.05 * np.sin(np.pi * np.clip(after, 0, 30) / 30.0) ** 2
    large = np.sin(np.pi * np.clip(after - 100, 0, 30) / 30.0) ** 2
    for seed in range(20):
        noise = 1e-3 * np.random.default_rng(seed).standard_normal(400)
        assert begin < onset(small + large + noise) < begin + 15


def rounded(step, seed, noise=0.05):
    times, columns = recorded(seed, noise=noise)
    return hc.Traces.from_arrays(times, {k: step * np.round(v / step) for k, v in columns.items()})


@pytest.mark.long
@pytest.mark.parametrize("step", [0.5, 1.0])
def test_errors_account_for_coarse_steps(step):
    squares = []
    for seed in range(4):
        data = rounded(step, seed)
        result = hc.fit(data, chain(), free=FREE)
        text = result.summary(width=None)
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


@pytest.mark.long
@pytest.mark.parametrize(("part", "bias"), [(0.05, 0.15), (0.25, 0.05), (0.55, 0.03), (0.9, 0.03)])
def test_noise_smaller_than_a_step_is_separated_from_rounding(part, bias):
    rng = np.random.default_rng(6)
    found = [
        noise_before_rounding(np.round(rng.uniform(-0.5, 0.5) + part * each), 1.0)
        for each in rng.standard_normal((300, 400))
    ]
    # Errors of rounding are uniform if the mean may be anywhere within a step.
    variance = np.mean(np.square(found)) + 1.0 / 12.0
    assert variance == pytest.approx(part**2 + 1.0 / 12.0, rel=bias)


@pytest.mark.parametrize("part", [0.05, 0.15, 0.3])
def test_correlation_of_rounding_errors(part):
    rng = np.random.default_rng(7)
    true = rng.uniform(-0.5, 0.5, 200_000)
    one, two = (np.round(true + part * rng.standard_normal(len(true))) - true for _ in range(2))
    expected = np.corrcoef(one, two)[0, 1]
    assert correlation_of_rounding(part, 1.0) == pytest.approx(expected, abs=0.01)


@pytest.mark.parametrize("part", [0.15, 0.3, 0.5])
def test_noise_of_rounded_samples_is_not_the_beginning_of_a_pulse(part):
    times = 1e-6 * np.arange(600)
    for seed in range(30):
        rng = np.random.default_rng(seed)
        # 40 steps high; within half a step of zero until 240 us.
        steps = 40.0 * np.exp(-(((times - 300e-6) / 25e-6) ** 2))
        steps += part * rng.standard_normal(len(times)) + rng.uniform(-0.5, 0.5)
        assert onset(1.5 * np.round(steps)) > 240


@pytest.mark.parametrize("step", [0.0, 0.1, 0.2, 0.5])
def test_sensors_that_the_pulse_has_not_reached_do_not_shorten_the_quiet_part(step):
    """The pulse is at ball 6 from sample 162; the wall has only noise of 0.1 N."""
    times = np.arange(220.0)
    pulse = 30.0 * np.clip(np.cos((times - 200.0) / 25.0), 0.0, None) ** 4
    pulse *= np.abs(times - 200.0) < 39.0
    few = 0
    for seed in range(100):
        noise = np.random.default_rng(seed).normal(0.03, 0.1, (2, len(times)))
        columns = {"ball 6 [N]": pulse + noise[0], "wall [N]": noise[1]}
        if step:
            columns = {key: step * np.round(each / step) for key, each in columns.items()}
        counts, _ = quiet_counts([*columns.values()])
        few += min(counts) <= 100
    assert few <= 2


@pytest.mark.parametrize(("height", "width"), [(8.0, 3), (5.0, 10), (3.0, 30), (2.0, 100)])
def test_a_weak_pulse_is_not_only_noise(height, width):
    """The height is in standard deviations of the noise, the width in samples."""
    distance = np.arange(400.0) - 280.0
    pulse = height * np.cos(np.pi / 2.0 * np.clip(distance / width, -1.0, 1.0)) ** 3
    for seed in range(50):
        noise = np.random.default_rng(seed).standard_normal(len(pulse))
        assert not only_noise(pulse + noise)


def test_the_sensor_with_the_first_pulse_is_named():
    times = np.arange(200.0)
    early, late = (
        np.sin(np.pi * np.clip((times - begin) / 40.0, 0.0, 1.0)) ** 2 for begin in (12, 14)
    )
    noise = 0.01 * np.random.default_rng(1).standard_normal((2, len(times)))
    columns = {"ball 6 [N]": late + noise[0], "wall [N]": early + noise[1]}
    with pytest.raises(hc.InputError, match="ball 6 cannot .* begins in the signal of wall after"):
        hc.Traces.from_arrays(1e-6 * times, columns)


def test_samples_whose_squares_underflow_are_noise_free():
    times = np.arange(600.0)
    one, two = (
        20.0 * np.cos(np.pi / 2.0 * np.clip((times - peak) / 62.8, -1.0, 1.0)) ** 6
        for peak in (200.0, 350.0)
    )
    one[80:100] = two[80:100] = 1e-200  # as the tails of other integrations have
    data = hc.Traces.from_arrays(1e-6 * times, {"ball 6 [N]": one, "wall [N]": two})
    assert all(signal.noiseless for _, signal in data)
    given = hc.Traces.from_arrays(1e-6 * times, {"ball 6 [N]": one, "wall [N]": two}, noise=0.05)
    assert [signal.noise for _, signal in given] == [0.05, 0.05]
    assert independent_samples(np.append(np.zeros(20), 1e-200)) == 21.0


def drawn(seed, part, step=0.4):
    """Rounded traces with noise of a part of a step, the true gains, and a measured velocity."""
    rng = np.random.default_rng(seed)
    columns, gains, signals = {}, 1.0 + 0.03 * rng.standard_normal(3), forces()
    begin = TRUTH["time_offset"] - rng.uniform(0.0, SPACING)
    for (name, force), gain in zip(signals.items(), gains, strict=True):
        after = SPACING * np.arange(BEFORE + len(force)) - begin
        spline = make_interp_spline(SPACING * np.arange(len(force)), force, k=3)
        seen = np.where(after > 0.0, spline(np.clip(after, 0.0, SPACING * (len(force) - 1))), 0.0)
        phase, noise = rng.uniform(-0.5, 0.5), part * rng.standard_normal(len(seen))
        columns[f"{name} [N]"] = step * (np.round(gain * seen / step + noise + phase) - phase)
    data = hc.Traces.from_arrays(SPACING * np.arange(len(seen)), columns)
    truth = {**TRUTH, "time_offset": begin}
    truth |= {f"gain[{name}]": gain for name, gain in zip(signals, gains, strict=True)}
    sigma = 0.01 * TRUTH["struck_by.velocity"]
    gate = TRUTH["struck_by.velocity"] + sigma * rng.standard_normal()
    return data, truth, {"struck_by.velocity": (gate, sigma), "gain[*]": (1.0, 0.03)}


@pytest.mark.long
@pytest.mark.parametrize("part", [0.05, 0.25, 0.55])
def test_errors_and_chi_squared_of_8_bits_are_right_with_priors(part):
    scores, ratios = [], []
    for seed in range(12):
        data, truth, priors = drawn(1000 + seed, part)
        result = hc.fit(data, chain(), free=[*FREE, "gain[*]"], priors=priors)
        errors = result.errors
        # No error exceeds that of the prior.
        assert errors["struck_by.velocity"] < priors["struck_by.velocity"][1]
        assert max(errors[f"gain[{name}]"] for name in data.names) < 0.03
        scores.append([(result.values[name] - truth[name]) / errors[name] for name in truth])
        ratios.append(result.goodness.ratio)
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.15)
    # Most parameters are correlated, and the mean of 12 squares scatters by a third.
    assert np.sqrt(np.mean(np.square(scores))) == pytest.approx(1.0, abs=0.3)
    assert np.mean(np.abs(scores) < 1.0) == pytest.approx(0.683, abs=0.2)
    assert np.mean(np.abs(scores) < 2.0) > 0.85


@pytest.mark.long
def test_the_posterior_of_rounded_samples_has_the_prior():
    # Without a loss, no trial requires a simulation.
    row, rng = bench(), np.random.default_rng(9)
    times, seen = signals(row, 700e-6, 60e-6)
    data = synthetic(times, seen, rng, noise=0.04, step=0.4, phase=rng.uniform(-0.5, 0.5, 4))
    priors = {"struck_by.velocity": (0.3, 3e-4), "gain[*]": (1.0, 0.03)}
    free = ["stiffness", "struck_by.velocity", "time_offset", "gain[*]"]
    result = hc.fit(data, row, free=free, priors=priors)
    assert result.errors["struck_by.velocity"] == pytest.approx(3e-4, rel=0.05)
    sampled = result.sample(500, seed=1).errors
    for name, error in result.errors.items():
        assert sampled[name] == pytest.approx(error, rel=0.2)


def test_priors_keep_their_weight_with_slow_noise():
    times, columns = recorded(5, noise=0.0)
    slow = 0.3 * first_order(np.random.default_rng(8), 0.9, (3, len(times)))
    noisy = {name: seen + own for (name, seen), own in zip(columns.items(), slow, strict=True)}
    data = hc.Traces.from_arrays(times, noisy, noise=0.3)
    priors = {"struck_by.velocity": (TRUTH["struck_by.velocity"], 3e-5)}
    result = hc.fit(data, chain(), free=FREE, priors=priors)
    assert result.describes
    assert result.goodness.inflation > 5.0
    assert re.search(
        r"\(\d+ samples, correlated as \d+ independent ones\)", result.summary(width=None)
    )
    # The data alone determine the velocity less accurately than the prior.
    assert 2.4e-5 < result.errors["struck_by.velocity"] < 3e-5
    assert abs(result.prior_deviations["struck_by.velocity"]) < 1.0


def test_residuals_smaller_than_their_noise_are_noted():
    times, columns = recorded()
    data = hc.Traces.from_arrays(times, columns, noise=0.15)
    result = hc.fit(data, chain(), free=FREE)
    assert result.goodness.ratio == pytest.approx(1.0 / 1.5**2, rel=0.1)
    assert "The residuals are smaller than their noise: check it" in result.verdict
    assert "multiply all errors by 0.67" in result.verdict


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    """Forces without noise, as `hertzchain simulate --forces` writes them, and their chain."""
    nominal = bench(loss=hc.Viscoelastic(0.5e-6))
    run = hc.simulate(nominal, times=np.arange(0.0, 600e-6, 0.8e-6))
    file = tmp_path_factory.mktemp("simulated") / "forces.csv"
    run.save_forces(file, ["ball 6", "ball 16", "wall"])
    return file, nominal


def test_the_chain_that_made_noise_free_data_describes_them(simulated):
    result = hc.fit(*simulated)
    assert result.describes
    assert result.goodness.noiseless
    assert "the model describes the data to the accuracy of the simulation" in result.verdict
    assert result.values["stiffness"] == pytest.approx(1.0, abs=1e-6)
    assert max(result.chi2_per_sample.values()) < 0.3
    assert result.warnings[-1].endswith("if the data are measured, give noise")
    assert not any("cannot be excluded" in each for each in result.warnings)


@pytest.mark.long
@pytest.mark.parametrize("change", ["loss", "gap", "ball"])
def test_another_chain_does_not_describe_noise_free_data(change, simulated):
    file, nominal = simulated
    wrong = {
        "loss": nominal.replace(loss=hc.Restitution(0.93)),
        "gap": nominal.replace(gaps=np.where(np.arange(nominal.beads - 1) == 9, 2e-8, 0.0)),
        "ball": nominal.replace(radii=np.append(nominal.radii[:-1], 1.003 * nominal.radii[-1])),
    }[change]
    traces = hc.load_traces(file)
    names = default_names(traces, wrong)
    result = fit_with(traces, [wrong], Settings(names), 1)
    assert not result.describes
    assert result.goodness.ratio > 10.0


@pytest.mark.long
@pytest.mark.parametrize("digits", [3, 4, 6, 17])
def test_printed_digits_are_part_of_the_noise(digits, simulated, tmp_path):
    """Samples with a number of significant digits are not on one grid."""
    file, nominal = simulated
    rows = np.genfromtxt(file, delimiter=",", skip_header=1)
    printed = tmp_path / "printed.csv"
    head = file.read_text().splitlines()[0]
    np.savetxt(printed, rows, ["%.9g", *[f"%.{digits}g"] * 3], ",", header=head, comments="")
    result = hc.fit(printed, nominal)
    assert result.describes
    assert result.goodness.noiseless == (digits > 4)


@pytest.fixture(scope="module")
def true_forces():
    """Forces of a chain; the pulse arrives at ball 6 after 75 samples, at the wall after 364."""
    return signals(bench(hc.Viscoelastic(0.6e-6)), 560e-6, 0.0)


def noisy_traces(forces, part, rho, seed, crosstalk=0.0):
    """Traces with noise that is a part of each peak, and the noise."""
    times, seen = forces
    seen = (1.0 - crosstalk) * seen + crosstalk * seen.sum(axis=1, keepdims=True)
    sigma = part * forces[1].max(axis=0)
    noise = first_order(np.random.default_rng(seed), rho, seen.T.shape).T
    names = [f"{name} [N]" for name in ("ball 6", "ball 11", "ball 16", "wall")]
    columns = dict(zip(names, (seen + sigma * noise).T, strict=True))
    return hc.Traces.from_arrays(times, columns), sigma


def test_each_sensor_is_quiet_until_its_own_pulse(true_forces):
    traces, _ = noisy_traces(true_forces, 5e-3, 0.0, 1)
    seen = true_forces[1]
    begins = [int(np.argmax(each > 1e-3 * each.max())) for each in seen.T]
    counts = [signal.before for _, signal in traces]
    assert all(count <= begin for count, begin in zip(counts, begins, strict=True))
    # The foot that is omitted is shorter than two rises from 2% to half of the peak.
    assert all(count > begin - 40 for count, begin in zip(counts[1:], begins[1:], strict=True))


@pytest.mark.parametrize(("part", "rho"), [(2e-3, 0.0), (2e-2, 0.0), (1e-2, 0.6)])
def test_the_foot_of_a_pulse_is_not_noise(part, rho, true_forces):
    found = []
    for seed in range(60):
        traces, sigma = noisy_traces(true_forces, part, rho, seed)
        found.append([signal.sigma for _, signal in traces] / sigma)
    found = np.array(found)
    # The mean of 60 estimates has an error below 2%.
    np.testing.assert_allclose(np.mean(found**2, axis=0)[1:], 1.0, atol=0.06)
    # The wall has five times as many quiet samples as the first sensor.
    assert rho or found[:, -1].std() < 0.75 * found[:, 0].std()


def test_sensors_that_pick_up_other_pulses_are_quiet_before_the_first(true_forces):
    traces, _ = noisy_traces(true_forces, 5e-3, 0.0, 1, crosstalk=0.02)
    counts = [signal.before for _, signal in traces]
    assert len(set(counts)) == 1
    assert counts[0] < np.argmax(true_forces[1][:, 0] > 1e-3 * true_forces[1][:, 0].max())


def test_errors_of_simulated_data_without_noise_are_those_of_data_with_it():
    """The small and smooth residuals are not noise whose samples are correlated."""
    times, seen = signals(bench(beads=10), 400e-6, 100e-6, balls=(3, 6))
    names, found = ("ball 3 [N]", "ball 6 [N]", "wall [N]"), []
    for noise in (0.0, 0.1):
        values = seen + noise * np.random.default_rng(7).standard_normal(seen.shape)
        columns = dict(zip(names, values.T, strict=True))
        traces = hc.Traces.from_arrays(times, columns, noise=0.1)
        free = ["stiffness", "struck_by.velocity", "time_offset"]
        found.append(hc.fit(traces, bench(beads=10), free=free, starts=1))
    without, noisy = found
    assert without.sigmas == pytest.approx(noisy.sigmas, rel=0.02)
    (note,) = [note for note in without.warnings if "far smaller than the noise" in note]
    assert note.startswith("the residuals of ball 3, ball 6 and wall are")
    assert not any("far smaller than the noise" in note for note in noisy.warnings)
    assert "multiply" not in without.verdict


def test_a_scan_for_defects_counts_independent_samples():
    rng, rho = np.random.default_rng(4), 0.9
    chain = bench(beads=4, behind=2)
    times, seen = signals(chain, 600e-6, 150e-6, balls=(2,))
    noisy = seen + 0.5 * first_order(rng, rho, seen.T.shape).T
    data = hc.Traces.from_arrays(times, {"ball 2 [N]": noisy[:, 0], "wall [N]": noisy[:, 1]})
    result = hc.fit(data, chain, free=["time_offset"])
    scan = hc.scan_defects(result)
    # The variance of a mean of first-order noise is (1 + rho)/(1 - rho) times that of white noise.
    independent = noisy.size * (1.0 - rho) / (1.0 + rho)
    assert scan.freedom == pytest.approx(independent, rel=0.3)
    assert abs(scan.chi2 - scan.freedom) < 4.0 * (2.0 * scan.freedom) ** 0.5
    assert f"of {scan.freedom + 1.0:.0f} independent samples" in str(scan)
    half = replace(scan, improvements=np.full(len(scan.names), 0.5 * scan.chi2)).plot()
    assert half.lines[0].get_ydata() == pytest.approx(0.5 * scan.chi2)
    levels = {line.get_label(): line.get_ydata()[0] for line in half.lines[2:]}
    assert levels == pytest.approx({"no defect": scan.chi2, "noise alone": scan.freedom})

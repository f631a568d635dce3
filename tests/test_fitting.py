"""Fits of synthetic traces, of which the truth is known."""

import dataclasses
import functools
import json
import re
import subprocess
import sys
import warnings
from signal import SIGINT
from time import monotonic

import click
import matplotlib.pyplot as plt
import numpy as np
import pytest
from interruption import PROMPT
from scipy.integrate import solve_ivp
from synthetic_traces import bench, measured, recorded, signals

import hertzchain as hc
from hertzchain.cli.postponed_diagnosis import LOOKING
from hertzchain.fitting import least_squares
from hertzchain.fitting.autocorrelation import correlation_length
from hertzchain.fitting.chain_parameters import value_of, with_motion, with_sizes
from hertzchain.fitting.defect_fits import fit_of_defect
from hertzchain.fitting.effect_limits import _limit as largest_effect
from hertzchain.fitting.goodness import Goodness, goodness_of
from hertzchain.fitting.jumps import next_to_jumps
from hertzchain.fitting.loss_comparison import LossComparison, LossFit
from hertzchain.fitting.model import make_model
from hertzchain.fitting.names import Name, parse_name
from hertzchain.fitting.parameters import default_names, every_name, free_parameters
from hertzchain.fitting.posterior import MIN_WALKERS, moves_from, steps_needed
from hertzchain.fitting.problem import Problem
from hertzchain.fitting.sensors import Sensor, filtered
from hertzchain.fitting.simulations import Simulator
from hertzchain.fitting.starts import aligned
from hertzchain.fitting.symmetry import similarity_key, units_of
from hertzchain.recorded_warnings import ignore_warnings

# The truth of tools/example_traces.py.
TRUTH = {
    "stiffness": 0.96, "struck_by.velocity": 0.2968, "loss.time": 0.62e-6,
    "time_offset": 71.3e-6, "gain[ball 6]": 1.021, "gain[ball 11]": 0.0483,
    "gain[ball 16]": 0.984, "gain[wall]": 1.012, "lag": 1.4e-6, "highpass": 1 / 6e-3,
    "crosstalk": 0.004,
}  # fmt: skip
KNOWN = {"struck_by.velocity": (0.3, 0.003), "gain[*]": (1.0, 0.03)}
NINE = ["stiffness", "exponent", "struck_by.velocity", "loss.time", "time_offset", "gain[*]"]
LAW = hc.Viscoelastic(0.6e-6)
# A force that may pull ends with a jump, where differences are of no use.
SMOOTH = hc.Restitution(0.97, attractive=False)


@pytest.fixture(scope="module")
def example():
    return hc.fit(*hc.example_experiment())


@pytest.fixture(scope="module")
def traces():
    return measured(bench(LAW), np.random.default_rng(5))


def problem_of(chain, free, traces, priors=None):
    parameters = free_parameters(traces, [chain], free, priors or {}, {})
    places = [signal.place for _, signal in traces]
    return Problem(make_model(traces, [chain], parameters, Simulator(places)))


def test_data_of_another_integrator_are_recovered(example):
    assert example.converged
    assert example.describes
    deviations = [(example.values[name] - true) / example.errors[name]
                  for name, true in TRUTH.items()]  # fmt: skip
    assert np.abs(deviations).max() < 3.0
    assert np.mean(np.square(deviations)) < 2.5
    assert example.simulations <= 25


@pytest.mark.long
def test_chi_squared_scatters_as_stated_if_the_noise_is_estimated():
    """Gaussian residuals of four signals, whose noise is estimated from about 60 samples."""
    rng, times = np.random.default_rng(8), 1e-6 * np.arange(500.0)
    pulse = 100.0 * (times > 75e-6)
    found = []
    for _ in range(300):
        noise = rng.standard_normal((4, 500))
        names = ("ball 5 [N]", "ball 9 [N]", "ball 12 [N]", "wall [N]")
        traces = hc.Traces.from_arrays(times, dict(zip(names, pulse + noise, strict=True)))
        residuals = np.concatenate(
            [own / signal.noise for own, (_, signal) in zip(noise, traces, strict=True)]
        )
        found.append(goodness_of(traces, residuals, np.ones(2000, bool), 0))
    ratios = np.array([each.chi2 / each.freedom for each in found])
    known = 2.0 / 2000
    assert ratios.std() == pytest.approx((found[0].noise_error ** 2 + known) ** 0.5, rel=0.15)
    assert np.std([each.excess for each in found]) == pytest.approx(1.0, abs=0.15)
    # Most of these chi-squared would be unlikely if the noise were known.
    far = np.abs(ratios - 1.0) > 3.0 * known**0.5
    assert [each.noise_uncertain for each in found] == (far & [x.describes for x in found]).tolist()
    assert 0.15 < far.mean() < 0.85


def test_the_verdict_names_an_uncertain_noise(example):
    # (0.091^2 + 2/1977)^(1/2) = 0.096, from the noise and from the scatter of chi-squared.
    good = Goodness(2266.9, 1990, 1990.0, 1990.0, 0, 13, 0.096, 0.2, noise_error=0.091)
    verdict = dataclasses.replace(example, goodness=good).verdict
    assert "within the uncertainty of their noise" in verdict
    assert "1.147 +- 0.096 times the expectation" in verdict
    # (2266.9/1977)^(1/2), as for any fit whose residuals measure the noise.
    assert verdict.endswith("multiply all errors by 1.07")
    given = dataclasses.replace(good, noise_error=0.0, uncertainty=0.0318)
    assert given.excess == pytest.approx(4.6, abs=0.02)
    assert not given.describes
    assert not given.undecided
    assert not given.noise_uncertain


@pytest.mark.parametrize(
    ("uncertainty", "words"),
    [
        (0.11, ", far more than expected: the model does not describe the data"),
        (0.25, "7 standard deviations more than expected: the model does not describe the data"),
        (0.35, "cannot be decided, because chi2 is known only to +-35%"),
        (0.60, "cannot be decided, because chi2 is known only to +-60%"),
    ],
)
def test_a_large_chi_squared_never_counts_as_a_description(example, uncertainty, words):
    good = Goodness(5665.3, 2160, 2160.0, 16.0, 0, 4, uncertainty, 0.2, noise_error=0.1)
    assert not good.describes
    result = dataclasses.replace(example, goodness=good)
    assert words in result.verdict
    assert "2.63 +- " in result.verdict
    # The residuals of an undecided fit may be used with the factor (5665.3/2156)^(1/2).
    assert ("multiply all errors by 1.62" in result.verdict) == good.undecided
    assert ("have no meaning" in result.verdict) == (not good.undecided)


def test_a_very_large_chi_squared_has_no_error(example):
    good = Goodness(52_058_000.0, 2160, 2160.0, 2160.0, 0, 4, 0.17, 0.2, noise_error=0.1)
    result = dataclasses.replace(example, goodness=good)
    assert "independent samples), 24146 times the expectation, far more" in result.verdict
    statement = LossComparison((LossFit("dashpot", result),)).statement
    assert "none of the laws compared describes the data; dashpot comes closest" in statement


def test_laws_are_not_compared_if_the_noise_is_too_uncertain(example):
    good = Goodness(5665.3, 2160, 2160.0, 16.0, 0, 4, 0.6, 0.2, noise_error=0.6)
    laws = LossComparison((LossFit("viscoelastic", dataclasses.replace(example, goodness=good)),))
    assert "the noise is too uncertain to decide whether it describes" in laws.statement


@pytest.mark.long
def test_two_shots_share_their_material():
    result = hc.fit(*hc.example_experiment("fast", "slow"))
    assert result.describes
    slow = result.values["struck_by.velocity@2"] - 0.1013
    assert abs(slow) < 3.0 * result.errors["struck_by.velocity@2"]
    assert abs(result.values["loss.time"] - 0.62e-6) < 3.0 * result.errors["loss.time"]


def test_shots_that_are_sampled_at_other_intervals_have_their_own_signals():
    chain, pair = bench(LAW), []
    for interval in (2e-6, 1e-6):
        times = interval * np.arange(201)
        run = hc.simulate(chain, times=times, rtol=1e-11)
        pair.append((times, run.forces[:, -1]))
    one, two = (
        hc.Traces.from_arrays(times, {"wall [N]": force}, noise=0.1) for times, force in pair
    )
    parameters = free_parameters(one + two, [chain, chain], ["stiffness"], {}, {})
    places = [signal.place for _, signal in one]
    model = make_model(one + two, [chain, chain], parameters, Simulator(places))
    found = model.predict({parse_name("stiffness"): 1.0})
    for (signal,), (_, force) in zip(found, pair, strict=True):
        assert signal == pytest.approx(force, abs=1e-4 * pair[0][1].max())


def with_zero_error(traces, zero):
    """One shot whose signals have another zero."""
    (shot,) = traces.shots
    columns = {f"{each.name} [N]": each.values + zero for each in shot.signals}
    return hc.Traces.from_arrays(shot.times, columns)


@pytest.mark.parametrize("zero", [0.0, -20.0, 50.0])
def test_the_first_alignment_does_not_depend_on_the_zero_of_the_sensors(zero):
    data = measured(bench(LAW), np.random.default_rng(1), offset=71.3e-6)
    free = ["stiffness", "time_offset", "offset[*]"]
    model = problem_of(bench(LAW), free, with_zero_error(data, zero)).model
    start = aligned(model, {each.name: each.start for each in model.parameters})
    # Trial factors of time differ by 2.5%, and times of the grid by 0.25 us.
    assert start[parse_name("stiffness")] == pytest.approx(1.0, rel=0.07)
    assert start[parse_name("time_offset")] == pytest.approx(71.3e-6, abs=2e-6)


def test_the_time_offset_of_a_shot_replaces_the_common_one_in_the_first_alignment():
    shots = [
        measured(bench(LAW), np.random.default_rng(1), offset=offset) for offset in (80e-6, 30e-6)
    ]
    chains, traces = [bench(LAW)] * 2, shots[0] + shots[1]
    free, priors = ["time_offset", "time_offset@2"], {"time_offset": (80e-6, 1e-6)}
    parameters = free_parameters(traces, chains, free, priors, {})
    places = [signal.place for signal in traces.shots[0].signals]
    model = make_model(traces, chains, parameters, Simulator(places))
    start = aligned(model, {each.name: each.start for each in parameters})
    assert start[parse_name("time_offset@2")] == pytest.approx(30e-6, abs=1e-6)


def test_nine_parameters_take_few_simulations(traces):
    result = hc.fit(traces, bench(hc.Viscoelastic(0.3e-6)), free=NINE, priors=KNOWN)
    assert result.simulations <= 25
    truth = {"stiffness": 1.0, "exponent": 1.5, "loss.time": 0.6e-6, "time_offset": 4.2e-6}
    for name, true in truth.items():
        assert abs(result.values[name] - true) < 3.5 * result.errors[name], name


def test_speed_and_stiffness_and_gains_scale_together():
    one, other = bench(hc.Restitution(0.97)), bench(hc.Restitution(0.97), velocity=0.33)
    stiffness = {parse_name("stiffness"): 1.1**-0.5}
    other = with_sizes(other, stiffness, 1e-6)
    assert similarity_key(one, units_of(one)) == similarity_key(other, units_of(other))
    assert units_of(other).time == pytest.approx(units_of(one).time, rel=1e-12)
    # A relaxation time, gravity and a gap are scales of their own.
    heavy = [each.replace(gravity=9.81) for each in (one, other)]
    first, second = (similarity_key(each, units_of(each)) for each in heavy)
    assert first != second


def test_scaled_signals_are_those_of_a_simulation():
    places = [signal.place for _, signal in hc.example_experiment()[0]]
    simulator = Simulator(places)
    one = bench(hc.Viscoelastic(0.6e-6))
    simulator.signals(one, 500e-6)
    factor = units_of(bench(velocity=0.36, factor=1.3)).time / units_of(one).time
    other = bench(hc.Viscoelastic(0.6e-6 * factor), velocity=0.36, factor=1.3)
    found = simulator.signals(other, 300e-6)
    assert simulator.count == 1
    run = hc.simulate(other, times=found.spacing * np.arange(len(found.columns)), rtol=1e-11)
    reference = run.sensor(7)
    assert np.abs(found.columns[:, 0] - reference).max() < 1e-7 * reference.max()


@pytest.mark.parametrize(
    ("chain", "free"),
    [
        (bench(LAW, gravity=9.81), ["stiffness", "struck_by.velocity", "loss.time"]),
        (bench([SMOOTH] * 10 + [LAW] * 10),
         ["stiffness", "loss.time", "loss[3-4].coefficient", "stiffness[8-9]", "gap[8-9]"]),
        (bench(LAW, gap=1e-7), ["right_wall.stiffness", "mass[7]", "lag", "highpass"]),
        (bench(hc.UnloadingRatio(0.06)), ["stiffness", "exponent", "loss.ratio"]),
        (bench(hc.VelocityPower(25.0, 1.8)), ["exponent", "loss.gamma", "loss.alpha"]),
    ],
    ids=["gravity", "per contact", "wall and mass", "jumps in unloading", "jumps at the end"],
)  # fmt: skip
def test_derivatives_agree_with_long_differences(chain, free, traces):
    problem = problem_of(chain, free, traces)
    start = {each.name: each.start for each in problem.model.parameters}
    for name in start:
        if name.key in ("gap", "lag"):
            start[name] = 1e-6
        if name.key == "highpass":
            start[name] = 50.0
    variables = problem.model.variables(start)
    if problem.jumps:
        problem.skip_next_to_jumps(variables, more=False)
    columns = problem.jacobian(variables)
    for j in range(len(variables)):
        # Fourth order, with steps twenty times as long.
        step = 20.0 * problem.step(j)
        if problem.model.parameters[j].name.key == "gap" or problem.jumps:
            step = problem.step(j)
        ends = [problem.residuals(variables + k * step * np.eye(len(variables))[j])
                for k in (-2, -1, 1, 2)]  # fmt: skip
        expected = (ends[0] - 8.0 * ends[1] + 8.0 * ends[2] - ends[3]) / (12.0 * step)
        error = np.linalg.norm(columns[:, j] - expected) / np.linalg.norm(expected)
        assert error < 0.03, (free[j], error)


def test_parameters_of_single_contacts_change_only_them():
    chain = bench([hc.Restitution(0.97)] * 10 + [LAW] * 10)
    out = with_motion(chain, {parse_name("loss[3-4].coefficient"): 0.9})
    changed = [k for k in range(22) if out.contact_losses[k] != chain.contact_losses[k]]
    assert changed == [4]
    out = with_motion(chain, {parse_name("loss.time"): 1e-6})
    assert out.contact_losses[21] == hc.Viscoelastic(1e-6)
    assert out.contact_losses[1] == hc.Restitution(0.97)


def test_filters_solve_their_equations():
    spacing, lag, rate = 0.5e-6, 3e-6, 400.0
    times = spacing * np.arange(2000)

    def force(t):
        return np.exp(-(((t - 2e-4) / 2e-5) ** 2))

    def slopes(t, y):
        slope = (force(t) - y[0]) / lag
        return [slope, slope - rate * y[1]]

    exact = solve_ivp(slopes, (0.0, times[-1]), [0.0, 0.0], "LSODA", times, rtol=1e-10, atol=1e-13)
    found = filtered(force(times), spacing, Sensor(lag=lag, highpass=rate))
    # The signal is linear between the times of the grid: an error of h^2 F''/12.
    assert np.abs(found - exact.y[1]).max() < 2.0 * spacing**2 / 2e-5**2 / 6.0
    # A force at rest stays, however slow the high-pass.
    assert np.array_equal(
        filtered(np.full(9, 2.0), spacing, Sensor(highpass=rate)), np.full(9, 2.0)
    )


def test_nothing_calibrated_is_named(traces):
    result = hc.fit(traces, bench(LAW), free=["stiffness", "struck_by.velocity", "loss.time",
                                             "time_offset", "gain[*]"])  # fmt: skip
    assert len(result.weak) == 1
    weights = result.weak[0].weights
    assert result.weak[0].exact
    assert weights["struck_by.velocity"] / weights["stiffness"] == pytest.approx(-2.0, abs=0.01)
    assert weights["gain[wall]"] / weights["stiffness"] == pytest.approx(2.0, abs=0.01)
    assert "fix one of them, or give it a prior" in result.summary(width=None)
    assert np.isinf(result.errors["stiffness"])
    assert np.isfinite(result.errors["loss.time"])


def test_large_errors_are_named(traces):
    # Before the wall is reached, the traces do not depend on its stiffness.
    shot = traces.shots[0]
    early = shot.times < 250e-6
    first = hc.Traces.from_arrays(
        shot.times[early], {"ball 6 [N]": shot.signals[0].values[early]}, noise=0.1
    )
    result = hc.fit(first, bench(LAW), free=["time_offset", "loss.time", "right_wall.stiffness"])
    assert "right_wall.stiffness" in " ".join(result.warnings)


@pytest.mark.long
def test_lag_that_is_not_modelled_is_seen_or_warned_of(traces):
    data, chain = hc.example_experiment()
    free = ["stiffness", "struck_by.velocity", "loss.time", "time_offset", "exponent", "gain[*]",
            "highpass", "crosstalk"]  # fmt: skip
    known = {"struck_by.velocity": (0.3, 0.003)}
    without = hc.fit(data, hc.load_chain(chain), free=free, priors=known)
    lag = next(each for each in without.effects if each.name == "lag")
    assert abs(lag.value - 1.4e-6) < 4.0 * lag.error
    assert "lag" in without.summary(width=None)
    # Ideal sensors: none of the effects is seen, but a lag can be mistaken for another exponent.
    ideal = hc.fit(traces, bench(LAW), free=NINE, priors=KNOWN)
    assert not any(each.present for each in ideal.effects)
    assert "lag of the sensors" in ideal.summary(width=None)


@pytest.mark.long
def test_the_limit_of_a_lag_is_that_of_fits_with_this_lag(traces):
    free = ["stiffness", "exponent", "loss.time", "time_offset"]
    chain = bench(LAW)
    ideal = hc.fit(traces, chain, free=free)
    lag = next(each for each in ideal.effects if each.name == "lag")
    assert f"a lag of the sensors up to {1e6 * lag.limit:.2g} us" in ideal.summary(width=None)
    best, there = (
        hc.fit(traces, chain, free=[*free, "lag"], priors={"lag": prior}, start={"lag": lag.limit})
        for prior in ((0.0, 1.0), (lag.limit, 1e-5 * lag.limit))
    )
    assert there.chi2 - min(best.chi2, ideal.chi2) == pytest.approx(4.0, abs=0.7)
    moved = (there.values[lag.moved] - ideal.values[lag.moved]) / ideal.errors[lag.moved]
    # The limit is found with the derivatives without a lag.
    assert lag.shift == pytest.approx(abs(moved), rel=0.1)


@pytest.mark.parametrize("guess", [0.01, 1.0, 1.5, 50.0])
def test_the_limit_of_an_effect_is_two_standard_deviations_from_the_best_value(guess):
    # Without a best value other than 0, the fourth power is four at the square root of two.
    assert largest_effect(lambda size: 7.0 + size**4, guess) == pytest.approx(2**0.5, rel=0.02)
    assert np.isnan(largest_effect(lambda _size: 7.0, guess))


@pytest.mark.long
def test_a_lag_is_mentioned_only_if_it_matters(traces):
    free = ["stiffness", "loss.time", "time_offset"]
    four = hc.fit(traces, bench(LAW), free=free)
    assert "cannot be excluded" not in four.summary(width=None)
    effects = {each["name"]: each for each in four.as_dict()["effects"]}
    assert 0.0 < effects["lag"]["shift"] < 3.0
    with_lag = hc.fit(traces, bench(LAW), free=[*free, "lag"])
    assert all(with_lag.errors[name] < 2.0 * four.errors[name] for name in free[:2])
    # The lag of a single sensor delays its pulse as another stiffness does.
    shot = traces.shots[0]
    wall = hc.Traces.from_arrays(shot.times, {"wall [N]": shot.signals[-1].values})
    one = hc.fit(wall, bench(LAW), free=free)
    assert "lag of the sensors" in one.summary(width=None)


def test_loss_law_is_identified(traces):
    compared = hc.compare_losses(
        traces, bench(), laws=["restitution", "viscoelastic", "elastic"], free=NINE, priors=KNOWN
    )
    assert [each.law for each in compared.fits] == ["viscoelastic", "restitution", "elastic"]
    assert compared.statement.startswith("of the laws compared, viscoelastic describes")


@pytest.fixture(scope="module")
def cell():
    """A lossy row of ten balls in front of a linear, elastic load cell, and its traces."""
    row = bench(LAW, beads=10, behind=3)
    row = row.replace(right_wall=hc.Wall("50 kN/mm", exponent=1, loss=hc.Elastic()))
    return row, measured(row, np.random.default_rng(5), balls=(3, 6), duration=400e-6)


@pytest.mark.long
def test_comparisons_of_losses_keep_the_law_of_an_elastic_load_cell(cell):
    """The fit with the true law is that of `fit`; without the law of the wall, it is poor."""
    row, data = cell
    free = ["stiffness[3-4]", "loss.time", "time_offset"]
    compared = hc.compare_losses(data, row, laws=["restitution", "viscoelastic"], free=free)
    assert [each.law for each in compared.fits] == ["viscoelastic", "restitution"]
    assert compared.best.describes
    assert compared.best.chi2 == pytest.approx(hc.fit(data, row, free=free).chi2, rel=1e-6)
    assert compared.best.chain.right_wall.loss == hc.Elastic()
    lossy = row.replace(right_wall=hc.Wall("50 kN/mm", exponent=1))
    assert not hc.compare_losses(data, lossy, laws=["viscoelastic"], free=free).best.describes


@pytest.mark.long
def test_comparisons_of_losses_keep_the_free_parameters_of_a_wall_with_its_own_law(cell):
    row, data = cell
    row = row.replace(right_wall=hc.Wall("50 kN/mm", exponent=1, loss=hc.Restitution(0.99)))
    free = ["loss.time", "time_offset", "right_wall.loss.coefficient"]
    compared = hc.compare_losses(data, row, laws=["viscoelastic", "dashpot"], free=free)
    assert set(compared.fits[1].result.names) == {
        "loss.gamma", "time_offset", "right_wall.loss.coefficient"
    }  # fmt: skip
    assert compared.best.values["right_wall.loss.coefficient"] == pytest.approx(1.0, abs=0.01)


def laws_with(chain, **values):
    """Times of the laws between beads and of the right wall, with values of parameters."""
    names = {parse_name(name): value for name, value in values.items()}
    losses = with_motion(chain, names).contact_losses
    return [law.time for law in losses[1:-1]], losses[-1].time


def test_the_loss_of_the_balls_is_not_that_of_a_wall_with_its_own_law():
    usual = hc.Chain.uniform(4).replace(loss=hc.Viscoelastic(0.01), right_wall=hc.Wall())
    own = usual.replace(right_wall=hc.Wall(loss=hc.Viscoelastic(0.02)))
    free, wall = {"loss.time": 0.05}, {"right_wall.loss.time": 0.03}
    assert laws_with(usual, **free) == ([0.05] * 3, 0.05)
    assert laws_with(own, **free) == ([0.05] * 3, 0.02)
    for chain in (usual, own):
        # The order of the names has no effect.
        for values in (free | wall, wall | free):
            assert laws_with(chain, **values) == ([0.05] * 3, 0.03)
        assert laws_with(chain, **wall) == ([0.01] * 3, 0.03)
    assert laws_with(usual, **{"loss.time[2-3]": 0.07}, **free) == ([0.05, 0.07, 0.05], 0.05)
    last = {"loss.time[3-4]": 0.07}
    assert laws_with(usual, **last) == ([0.01, 0.01, 0.07], 0.01)
    # Walls of a chain with listed laws follow their neighbours in the result, too.
    listed = usual.replace(loss=[hc.Viscoelastic(0.01)] * 3)
    assert laws_with(listed, **free) == ([0.05] * 3, 0.05)
    assert with_motion(listed, {Name("loss.time"): 0.05}).right_wall.loss is None


def test_names_of_losses_are_those_of_balls_and_of_walls_with_their_own_law(cell):
    row, data = cell
    own = hc.Wall("50 kN/mm", exponent=1, loss=hc.Restitution(0.9))
    chain = row.replace(right_wall=own)
    names = [name for name in every_name(data, chain) if "loss." in name]
    assert names == ["loss.time", "right_wall.loss.coefficient"]
    assert [name for name in default_names(data, chain) if "loss." in name] == ["loss.time"]
    elastic = chain.replace(loss=None)
    assert not any("loss." in name for name in default_names(data, elastic))
    with pytest.raises(hc.InputError, match=r"right_wall\.loss\.coefficient"):
        hc.fit(data, elastic, free=["time_offset", "loss.coefficient"])


def test_a_fit_keeps_the_law_that_was_given_to_the_wall():
    wall = hc.Wall(loss=hc.Viscoelastic("3 us"))
    truth = bench(LAW, beads=8, behind=3).replace(right_wall=wall)
    data = measured(truth, np.random.default_rng(5), balls=(3, 6), duration=400e-6)
    start = truth.replace(loss=hc.Viscoelastic("1 us"))
    result = hc.fit(data, start, free=["loss.time", "time_offset"], starts=1)
    assert result.chain.right_wall.loss == wall.loss
    error = result.errors["loss.time"]
    assert result.values["loss.time"] == pytest.approx(LAW.time, abs=4.0 * error)
    assert result.describes


def test_the_factor_of_the_stiffness_does_not_include_the_spring_of_a_cell(cell):
    """The data are those of softer balls on the same cell; walls of materials follow the factor."""
    row, _ = cell
    soft = bench(LAW, factor=0.9, beads=10, behind=3).replace(right_wall=row.right_wall)
    data = measured(soft, np.random.default_rng(5), balls=(3, 6), duration=400e-6)
    result = hc.fit(data, row, free=["stiffness", "loss.time", "time_offset"])
    assert result.describes
    assert result.values["stiffness"] == pytest.approx(0.9, abs=4.0 * result.errors["stiffness"])
    assert result.chain.right_wall.stiffness == 50e6
    hertz = bench(LAW, beads=10, behind=3)
    walls = [
        with_sizes(chain, {Name("stiffness"): 0.9}, 1e-6).wall_stiffness[1]
        for chain in (hertz, hertz.replace(right_wall=hc.Wall(stiffness=hertz.wall_stiffness[1])))
    ]
    assert walls == pytest.approx([0.9 * hertz.wall_stiffness[1]] * 2)


@pytest.mark.long
def test_a_poor_fit_is_started_again_from_other_losses():
    """A start of twice the loss leads to another minimum, which one start does not leave."""
    cell = hc.Wall("50 kN/mm", exponent=1, loss=hc.Elastic())
    row = bench(hc.Viscoelastic("0.62 us")).replace(right_wall=cell).with_cap("5 g")
    data = measured(row, np.random.default_rng(5), balls=(6, 14), duration=800e-6)
    lossy = row.replace(loss=hc.Viscoelastic("1.24 us"))
    free = ["materials[steel].young", "loss.time", "time_offset"]
    result = hc.fit(data, lossy, free=free)
    assert result.describes
    error = result.errors["loss.time"]
    assert result.values["loss.time"] == pytest.approx(0.62e-6, abs=4.0 * error)
    assert result.notes[-1] == (
        "from loss.time = 1.24 us, the search ended at a larger chi2; this fit starts from "
        "loss.time = 0.62 us"
    )
    assert result.scan == "loss.time from 0.124 us to 6.2 us"
    once = hc.fit(data, lossy, free=free, starts=1)
    assert once.chi2 > 10.0 * result.chi2
    assert once.scan == ""


def test_noise_that_hides_the_law_is_reported():
    chain = bench(hc.Viscoelastic(0.2e-6), velocity=0.2)
    noisy = measured(chain, np.random.default_rng(2), noise=1.0)
    free = ["stiffness", "struck_by.velocity", "loss.time", "time_offset", "exponent"]
    compared = hc.compare_losses(
        noisy, chain, laws=["restitution", "viscoelastic"], free=free,
        priors={"struck_by.velocity": (0.2, 0.002)},
    )  # fmt: skip
    assert set(compared.undecided) == {"restitution", "viscoelastic"}
    assert compared.statement.startswith("the data cannot decide between")
    assert len(compared.further_shots) == 4


@pytest.mark.long
def test_a_further_shot_decides_no_better_if_noise_is_sampled_twice():
    chain = bench(hc.Viscoelastic(0.2e-6), velocity=0.2)
    times, seen = signals(chain, 500e-6, 54.2e-6, spacing=0.5e-6)
    noise = np.random.default_rng(2).standard_normal(seen.shape)
    twice = seen + 2.0 * noise[np.arange(len(seen)) // 2]
    once, both = (
        hc.compare_losses(
            recorded(times[::step], twice[::step], np.random.default_rng(3), noise=0.0), chain,
            laws=["viscoelastic", "restitution"], free=["stiffness", "time_offset"],
        )
        for step in (2, 1)
    )  # fmt: skip
    assert max(both.further_shots) == pytest.approx(max(once.further_shots), rel=0.01)
    expected = max(once.further_shots.values())
    assert max(both.further_shots.values()) == pytest.approx(expected, rel=0.3)


def test_laws_are_checked_before_the_first_fit(traces):
    done = []
    with pytest.raises(hc.InputError, match="viscous"):
        hc.compare_losses(
            traces, bench(LAW), laws=["viscoelastic", "viscous"], free=["stiffness", "loss.time"],
            progress=lambda *now: done.append(now),
        )  # fmt: skip
    assert not done


def test_samples_next_to_jumps_are_found():
    spacing = 0.125e-6
    grid = spacing * np.arange(3000)
    smooth = 30.0 * np.sin(np.pi * grid / 60e-6) ** 2
    times = 1e-6 * np.arange(300) + 0.3e-6
    assert not next_to_jumps(times, smooth, spacing, 0.01).any()
    jumping = smooth - 0.5 * (grid > 100e-6) + 0.5 * (grid > 200.9e-6)
    found = np.flatnonzero(next_to_jumps(times, jumping, spacing, 0.01))
    assert found.tolist() == [98, 99, 100, 101, 199, 200, 201, 202]
    # Two jumps within two intervals of the grid.
    double = smooth + 0.3 * (grid > 100e-6) + 0.3 * (grid > 100.1e-6)
    assert np.flatnonzero(next_to_jumps(times, double, spacing, 0.01)).tolist() == [
        98,
        99,
        100,
        101,
    ]
    # There is a jump of 0.005, less than the limit.
    assert not next_to_jumps(times, smooth + 0.005 * (grid > 1e-4), spacing, 0.01).any()


@pytest.mark.long
@pytest.mark.parametrize("law", [hc.UnloadingRatio(0.05), hc.VelocityPower(25.0, 1.8)])
def test_errors_of_laws_whose_force_jumps_are_not_too_small(law):
    squares = []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        offset = rng.uniform(0.0, 30e-6)
        traces = measured(bench(law, factor=1.03), rng, offset=offset)
        free = ["stiffness", "exponent", "time_offset"]
        free += [f"loss.{name}" for name in law.parameters() if name != "attractive"]
        start = dataclasses.replace(law, **{free[3][5:]: 0.7 * getattr(law, free[3][5:])})
        result = hc.fit(traces, bench(start), free=free)
        assert result.converged
        assert result.describes
        truth = {"stiffness": 1.03, "exponent": 1.5, "time_offset": offset}
        truth |= {name: getattr(law, name[5:]) for name in free[3:]}
        squares += [
            ((result.values[name] - truth[name]) / result.errors[name]) ** 2 for name in truth
        ]
    # Mean of at least twelve squares of expectation 1; errors ten times too small give 100.
    assert np.mean(squares) < 3.0


def assert_printed(scan, begin, size):
    """A printed scan has the method, the largest changes with their sizes, and the conclusion."""
    lines = str(scan).splitlines()
    assert lines[0].startswith(begin)
    (at,) = [i for i, line in enumerate(lines) if line.startswith("the fit without it")]
    assert f"chi2 {scan.result.chi2:.0f} of {scan.result.goodness.samples} samples" in lines[at]
    shown = [line.split() for line in lines[at + 2 : at + 7]]
    largest = np.sort(scan.improvements)[::-1]
    assert [float(row[1]) for row in shown] == pytest.approx(largest[:5], rel=6e-3)
    assert [row[0] for row in shown] == [scan.names[i] for i in np.argsort(-scan.improvements)[:5]]
    assert abs(float(shown[0][2].strip("%")) / size - 1.0) < 0.2
    assert float(lines[at + 7].split("at most ")[1]) == pytest.approx(largest[5], rel=6e-3)
    assert lines[-1] == f"{scan.best} explains more than noise would (a chi2 lower by 20)"
    assert max(map(len, lines)) <= 100
    second, first = np.argsort(scan.improvements)[-2:]
    improvements = scan.improvements.copy()
    improvements[[second, first]] = 950.0, 1000.0
    near = dataclasses.replace(scan, improvements=np.minimum(improvements, 1000.0 * (
        np.isin(np.arange(len(improvements)), (first, second)))))  # fmt: skip
    assert near.nearly == (scan.names[second],)
    assert f"uncertain: {scan.names[second]} explains nearly as much" in str(near)
    assert f"{scan.names[second]} explains nearly as much" in " ".join(repr(near).split())
    assert "nearly as much" in near._repr_html_()


def assert_the_best_gap_is_marked(scan):
    axes = scan.plot()
    curve, best, without, noise = axes.lines
    # Contact 0-1 is between the striker and ball 1.
    assert (curve.get_xdata()[0], best.get_xdata(), best.get_ydata()) == (
        0.5, [8.5], [pytest.approx(scan.result.chi2 - scan.improvements.max())]
    )  # fmt: skip
    assert curve.get_label().startswith("gap, best: balls 8 and 9, 0.")
    assert scan.found
    assert "significant" not in curve.get_label()
    weak = dataclasses.replace(scan, improvements=1e-3 * scan.improvements)
    assert weak.plot().lines[0].get_label() == f"{curve.get_label()} (not significant)"
    assert without.get_ydata()[0] == scan.result.chi2
    assert noise.get_ydata()[0] == scan.result.goodness.freedom
    # Another kind of defect shares the levels.
    assert scan.plot(ax=axes) is axes
    assert len(axes.lines) == 6
    plt.close(axes.figure)


@pytest.mark.long
def test_a_gap_beyond_the_sizes_that_were_tried_is_marked():
    scan = hc.scan_defects(hc.fit(*hc.example_experiment()))
    assert "largest gap" not in str(scan)
    assert str(scan).endswith("no gap explains more than noise would (a chi2 lower by 20)")
    sizes = scan.sizes.copy()
    sizes[3] = 1.28 * units_of(scan.result.chain).scales.length
    rows = str(dataclasses.replace(scan, sizes=sizes, improvements=np.eye(20)[3])).splitlines()
    assert [row.split()[0] for row in rows if row.endswith("  largest gap that was tried")] == [
        "gap[3-4]"
    ]


@pytest.mark.long
@pytest.mark.parametrize(("ball", "change"), [(12, -0.03), (3, 0.02), (7, 0.05), (7, -0.03)])
def test_odd_balls_between_and_beside_sensors_are_found(ball, change):
    """Extrapolated from 0.2%, these changes had the wrong size, sign or place."""
    law, radii = hc.Viscoelastic(0.8e-6), np.full(15, 4.7625e-3)

    def row(radii):
        balls = hc.Chain.from_materials(radii, "steel-52100").struck_by(velocity=0.6)
        return balls.replace(right_wall=hc.Wall.of("aluminium"), loss=law)

    nominal = row(radii)
    radii[ball - 1] *= 1.0 + change
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hc.ModelRangeWarning)
        data = measured(row(radii), np.random.default_rng(2), balls=(5, 10))
        free = ["stiffness", "struck_by.velocity", "loss.time", "time_offset"]
        fit = hc.fit(data, nominal, free=free, diagnose=False)
        scan = hc.scan_defects(fit, "bead")
        assert scan.best == f"radius[{ball}]"
        found = scan.fit(candidates=2)
    assert found.describes
    name = f"radius[{ball}]"
    assert abs(found.values[name] / radii[ball - 1] - 1.0) < 3e-3
    assert dict(found.rows())[name].endswith("% from 9.525 mm")
    assert "largest change" not in str(scan)


def test_hidden_gap_is_found_and_measured():
    data = measured(bench(LAW, gap=0.3e-6, behind=8), np.random.default_rng(3))
    free = ["stiffness", "struck_by.velocity", "loss.time", "time_offset", "gain[*]"]
    ignored = hc.fit(data, bench(LAW), free=free, priors=KNOWN, diagnose=False)
    assert not ignored.describes
    scan = hc.scan_defects(ignored)
    assert scan.best == "gap[8-9]"
    assert repr(scan).endswith("; call fit())")
    assert_printed(
        scan, "scan for a gap at each of 21 contacts, gap[0-1] to right_wall.gap: seven", 0.3
    )
    assert_the_best_gap_is_marked(scan)
    found = scan.fit(candidates=1)
    assert found.describes
    assert abs(found.values["gap[8-9]"] - 0.3e-6) < 3.0 * found.errors["gap[8-9]"] < 0.05e-6


@pytest.mark.long
def test_a_search_for_a_gap_needs_few_simulations():
    chain, nominal = (bench(LAW, beads=14, gap=gap, behind=9) for gap in (3e-7, 0.0))
    data = measured(chain, np.random.default_rng(2), balls=(5, 10), duration=300e-6)
    ignored = hc.fit(data, nominal, free=["stiffness", "loss.time", "time_offset"])
    simulator = ignored.model.simulator
    before = simulator.count
    scan = hc.scan_defects(ignored)
    scanned = simulator.count
    # There are 14 contacts; seven sizes are tried only if larger ones do not agree worse.
    assert scanned - before < 0.8 * 7 * 14
    found = fit_of_defect(scan)
    # Six contacts after the best one are tried, and only the best fit is completed.
    assert simulator.count - scanned < 10 * 14
    assert found.describes
    assert abs(found.values["gap[9-10]"] - 3e-7) < 3.0 * found.errors["gap[9-10]"] < 2e-8


@pytest.mark.long
def test_gap_as_large_as_the_overlaps_is_found_among_all_contacts():
    # With the stiffness free, chi-squared of the neighbours falls more in the linearised fit.
    balls = hc.Chain.from_materials(5e-3, "steel-52100", beads=15).struck_by(velocity=0.2)
    balls = balls.replace(right_wall=hc.Wall())
    gaps = np.zeros(15)
    gaps[8] = 0.4e-6
    times = np.arange(0.0, 450e-6, 1e-6)
    run = hc.simulate(balls.replace(gaps=gaps), until=times[-1], times=times)
    rng = np.random.default_rng(5)
    columns = {
        name: np.concatenate((np.zeros(40), force[:-40])) + 0.1 * rng.standard_normal(len(times))
        for name, force in (
            ("ball 5 [N]", run.sensor_force("ball 5").force),
            ("ball 12 [N]", run.sensor_force("ball 12").force),
            ("wall [N]", run.forces[:, -1]),
        )
    }
    ignored = hc.fit(
        hc.Traces.from_arrays(times, columns), balls, free=["stiffness", "time_offset"]
    )
    scan = hc.scan_defects(ignored)
    found = scan.fit()
    assert abs(found.values["gap[8-9]"] - 0.4e-6) < 3.0 * found.errors["gap[8-9]"] < 0.05e-6
    assert abs(found.values["stiffness"] - 1.0) < 3.0 * found.errors["stiffness"]
    assert found.describes
    # A gap at the wrong contact lowers chi-squared so much that the noise, of which few samples are
    # known, could almost explain the rest; but the residuals are correlated and the noise is not.
    only = np.array(scan.names) == "gap[7-8]"
    wrong = dataclasses.replace(scan, improvements=only.astype(float)).fit(candidates=1)
    assert "gap[7-8]" in wrong.names
    assert 3.0 < wrong.goodness.excess < 6.0 < wrong.goodness.correlation
    assert not wrong.describes
    assert "Successive residuals are correlated" in wrong.verdict


def test_odd_bead_is_found():
    radii = np.full(20, 5e-3)
    radii[11] *= 1.02
    chain = hc.Chain.from_materials(radii, "steel-52100").struck_by(velocity=0.3)
    data = measured(chain.replace(right_wall=hc.Wall(), loss=LAW), np.random.default_rng(4))
    free = ["stiffness", "struck_by.velocity", "loss.time", "time_offset"]
    nominal = hc.Chain.from_materials(5e-3, "steel-52100", beads=20).struck_by(velocity=0.3)
    ignored = hc.fit(data, nominal.replace(right_wall=hc.Wall(), loss=LAW), free=free,
                     priors={"struck_by.velocity": (0.3, 0.003)}, diagnose=False)  # fmt: skip
    scan = hc.scan_defects(ignored, "bead")
    assert scan.best == "radius[12]"
    assert_printed(
        scan, "scan for another radius of each of 20 beads, radius[1] to radius[20]: ", 2.0
    )


@pytest.mark.long
def test_random_starts_reach_the_optimum(traces):
    rng = np.random.default_rng(11)
    costs = []
    for _ in range(3):
        chain = bench(hc.Viscoelastic(np.exp(rng.uniform(-2.5, 1.0)) * 1e-6),
                      factor=np.exp(rng.uniform(-0.25, 0.25)),
                      exponent=1.5)  # fmt: skip
        found = hc.fit(traces, chain, free=NINE, priors=KNOWN)
        costs.append(found.chi2 + found._penalty)
    assert np.ptp(costs) < 0.01


@pytest.mark.long
def test_a_fit_that_does_not_converge_is_returned(traces, monkeypatch):
    monkeypatch.setattr(least_squares, "MAX_EVALUATIONS", 2)
    result = hc.fit(traces, bench(hc.Viscoelastic(0.1e-6)), free=NINE, priors=KNOWN, starts=1)
    assert not result.converged
    assert "the fit has not converged after 2 evaluations" in result.summary(width=None)


def test_precompression_and_velocity_signals_are_fitted():
    chain = bench(LAW, precompression=2.0, held_by="force")
    rng, grid = np.random.default_rng(0), 0.25e-6 * np.arange(1800)
    run = hc.simulate(chain, times=grid, rtol=1e-11)
    times = 1e-6 * np.arange(400)
    columns = {
        "ball 6 [N]": (run.sensor(7), 0.05), "ball 10 velocity [m/s]": (run.velocity(11), 5e-4),
    }  # fmt: skip
    traces = hc.Traces.from_arrays(times, {
        name: np.interp(times - 20e-6, grid, signal) + rng.normal(0.0, noise, len(times))
        for name, (signal, noise) in columns.items()
    })  # fmt: skip
    nominal = chain.replace(precompression=1.5, loss=hc.Viscoelastic(0.3e-6))
    free = ["stiffness", "precompression", "loss.time", "time_offset", "struck_by.velocity"]
    result = hc.fit(traces, nominal, free=free)
    truth = {"stiffness": 1.0, "precompression": 2.0, "loss.time": 0.6e-6,
             "struck_by.velocity": 0.3}  # fmt: skip
    for name, true in truth.items():
        assert abs(result.values[name] - true) < 3.0 * result.errors[name], name
        assert result.errors[name] < 0.01 * true
    assert "nan" not in result.summary(width=None)


def test_trial_values_issue_no_warnings():
    """A material below the limits of usual ones warns once, when it is made."""

    def row(young):
        balls = hc.Chain.from_materials(5e-3, hc.Material("gel", 1000.0, young, 0.48), beads=5)
        return balls.struck_by(velocity=0.01)

    with ignore_warnings():
        nominal = row(6e3)
        run = hc.simulate(row(5e3), times=np.linspace(0.0, 0.6, 400))
    values = run.sensor("ball 3")
    noise = 0.01 * float(np.ptp(values))
    traces = hc.Traces.from_arrays(run.times, {"ball 3 [N]": values}, noise=noise)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = hc.fit(traces, nominal, free=["materials[gel].young", "time_offset"])
    assert result.values["materials[gel].young"] == pytest.approx(5e3, rel=0.02)


def test_correlated_residuals_count_less():
    rng = np.random.default_rng(0)
    white = rng.normal(size=4000)
    assert correlation_length(white) < 1.2
    red = np.zeros(4000)
    for i in range(1, 4000):
        red[i] = 0.8 * red[i - 1] + white[i]
    # (1 + rho)/(1 - rho) of a first-order process.
    assert correlation_length(red) == pytest.approx(9.0, rel=0.25)


def test_files_with_shots_gaps_and_saturation(tmp_path):
    times = np.arange(0.0, 200.0)
    pulse = 30.0 * np.exp(-(((times - 120.0) / 12.0) ** 2))
    noise = np.random.default_rng(1).normal(0.0, 0.05, (2, 200))
    rows = ["shot,time [us],ball 6 [N],ball 3 velocity [mm/s]"]
    for shot in (1, 2):
        force = np.minimum(pulse + noise[0], 28.0 if shot == 2 else np.inf)
        for i, time in enumerate(times):
            cell = "" if (shot, i) == (1, 50) else f"{force[i]:.4f}"
            rows.append(
                f"{shot},{time + (0.5 if i > 100 else 0.0)},{cell},{pulse[i] + noise[1, i]}"
            )
    file = tmp_path / "data.csv"
    file.write_text("\n".join(rows) + "\n")
    traces = hc.load_traces(file)
    assert len(traces.shots) == 2
    assert traces.names == ("ball 6", "ball 3 velocity")
    first, second = (shot.signals[0] for shot in traces.shots)
    assert not first.valid[50]
    assert first.valid.sum() == 199
    clipped = np.flatnonzero(pulse + noise[0] >= 28.0)
    # One neighbour on each side is omitted, too.
    omitted = np.arange(clipped[0] - 1, clipped[-1] + 2)
    assert np.array_equal(np.flatnonzero(~second.valid), omitted)
    assert traces.shots[0].signals[1].values.max() == pytest.approx(0.03, rel=0.02)
    assert first.noise == pytest.approx(0.05, rel=0.3)
    notes = " ".join(traces.notes())
    for words in ("unevenly", "1 sample of ball 6 in shot 1 is missing", "saturated"):
        assert words in notes


HEAD = "time [us],ball 6 [N]\n"
GOOD = "".join(f"{i},{0.1 * (-1) ** i if i < 60 else 20 - abs(i - 80)}\n" for i in range(100))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (HEAD + GOOD[GOOD.index("\n55,") + 1 :], "record at least 25 samples before the pulse"),
        ("ball 6 [N]\n1\n", "one column of times"),
        ("time [us],ball 6 [m]\n0,1\n1,2\n", "'ball 6' must have a unit such as N"),
        ("time [us],ball 6\n0,1\n1,2\n", "has no unit; write ball 6 [N]"),
        ("time,ball 6 [N]\n0,1\n1,2\n", "column 'time' has no unit"),
        ("time [us],force [N]\n0,1\n1,2\n", "does not name the place of its sensor"),
        ("time [us],wall velocity [m/s]\n0,1\n1,2\n", "does not name the place of its sensor"),
        (HEAD + GOOD + "50,0.1\n", "times must increase"),
        ("ball 6 [N],time [us]\n" + GOOD, "all samples of ball 6 do: the headers of these two"),
        (HEAD + "".join(f"{i},{0.1 * (-1) ** i if i < 60 else 9.0}\n" for i in range(90)),
         "is saturated at 9 N during most of its pulse"),
        (HEAD + "0,1\n1\n", "line 3 has 1 cell, but the header has 2"),
        (HEAD + "0,1\n1,x\n", "column 'ball 6 [N]' is 'x' in line 3"),
        (HEAD + "0,1\n1,1\n", "has no signal"),
        (HEAD + "0,1\n1,1e200\n2,0\n", "sample of size 1e+200, but samples must be below 1e+30"),
        ("time [us],ball 6 [N],ball 6 [kN]\n0,1,1\n1,2,2\n", "two columns of 'ball 6'"),
        ("", "no header"),
    ],
)  # fmt: skip
def test_bad_files_are_refused_in_one_sentence(text, words, tmp_path):
    file = tmp_path / "data.csv"
    file.write_text(text)
    with pytest.raises(hc.InputError) as caught:
        hc.load_traces(file)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "head",
    [
        "Time (us),Ball 6 (N)",
        "t [us],ball 6 (N)",
        "T (µs),BALL  6 [N]",
        "times [us], ball 6 force (N)",
    ],
)
def test_units_may_be_in_parentheses(head, tmp_path):
    (tmp_path / "usual.csv").write_text(HEAD + GOOD)
    (tmp_path / "other.csv").write_text(f"{head}\n{GOOD}")
    usual, other = (hc.load_traces(tmp_path / name) for name in ("usual.csv", "other.csv"))
    assert other.names == ("ball 6",)
    np.testing.assert_array_equal(other.shots[0].times, usual.shots[0].times)
    np.testing.assert_array_equal(
        other.shots[0].signals[0].values, usual.shots[0].signals[0].values
    )


def test_columns_of_an_oscilloscope_are_given_places(tmp_path):
    file = tmp_path / "scope.csv"
    rows = "".join(f"{line}{line[line.index(',') :]}\n" for line in GOOD.splitlines())
    file.write_text(f"t (us),Force (kN),CH2 (mV)\n{rows}")
    found = hc.load_traces(file, sensors={"force": "wall", "CH2": "ball 6"})
    assert found.names == ("wall", "ball 6")
    wall, ball = found.shots[0].signals
    assert (wall.unit, ball.unit) == ("N", "V")
    assert wall.values.max() == pytest.approx(20e3)
    assert ball.values.max() == pytest.approx(20e-3)
    assert hc.load_traces(file, sensors={"Force": "wall"}).names == ("wall",)
    with pytest.raises(hc.InputError, match=r"give load_traces sensors=\{'Force': 'wall'\}"):
        hc.load_traces(file)
    with pytest.raises(hc.InputError, match="no column 'CH3'; the file has Force, CH2"):
        hc.load_traces(file, sensors={"CH3": "wall"})
    with pytest.raises(hc.InputError, match="wall is given for 'force' and for 'CH2'"):
        hc.load_traces(file, sensors={"force": "wall", "CH2": "wall"})
    with pytest.raises(hc.InputError, match="place of a sensor must be text, got 6"):
        hc.load_traces(file, sensors={"force": 6})


def test_missing_columns_are_named(tmp_path):
    file = tmp_path / "data.csv"
    file.write_text(HEAD + GOOD)
    with pytest.raises(hc.InputError, match="no column 'wall'; the file has ball 6"):
        hc.load_traces(file, sensors=["wall"])
    assert hc.load_traces(file, sensors=["ball 6"]).names == ("ball 6",)


def test_priors_and_starts_may_have_units(traces):
    chain = bench(hc.Restitution(0.97))
    free = ["struck_by.velocity", "loss.coefficient", "time_offset", "gap[8-9]"]
    priors = {"struck_by.velocity": ("30 cm/s", "3 mm/s"), "loss.coefficient": ("95%", "1%")}
    found = free_parameters(traces, [chain], free, priors, {"time_offset": "2 us", "gap[8-9]": 0.0})
    assert {str(each): each.prior for each in found[:2]} == {
        "struck_by.velocity": (0.3, 0.003), "loss.coefficient": (0.95, 0.01)
    }  # fmt: skip
    assert [each.start for each in found] == [0.3, 0.95, 2e-6, 0.0]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"free": ["stifness"]}, "did you mean 'stiffness'"),
        ({"free": ["loss.coefficient"]}, "unknown parameter 'loss.coefficient'"),
        ({"free": ["left_wall.gap"]}, "it has no left_wall"),
        ({"free": ["gap[20-22]"]}, "not a contact of this chain"),
        ({"free": ["radius[31]"]}, "not a ball of this chain"),
        ({"free": ["gain[ball 7]"]}, "unknown parameter 'gain[ball 7]'"),
        ({"free": ["gain[load cells]"]}, "(did you mean 'gain[wall]'?)"),
        ({"free": ["gaps[5-6]"]}, "(did you mean 'gap[5-6]'?)"),
        ({"free": ["masses[4]"]}, "(did you mean 'mass[4]'?)"),
        ({"free": ["gaps[500-501]"]}, "choose from stiffness, stiffness[8-9], gap[8-9]"),
        ({"free": ["stiffness", "stiffness"]}, "free twice"),
        ({"free": []}, "no parameter is free"),
        ({"free": ["stiffness@3"]}, "there is only one shot"),
        ({"free": ["stiffness"], "priors": {"exponent": (1.5, 0.1)}}, "prior but is not free"),
        ({"free": ["exponent"], "priors": {"exponent": (9.0, 0.1)}}, "exclude each other"),
        ({"free": ["gain[*]"], "priors": {"gain[*]": (1, 0.01), "gain[wall]": (2, 0.01)}},
         "exclude each other"),
        ({"free": ["exponent"], "priors": {"exponent": 1.5}}, "a value and its standard deviation"),
        ({"free": ["exponent"], "priors": {"exponent": ("1.5 m", 0.1)}}, "must have no unit"),
        ({"free": ["time_offset"], "priors": {"time_offset": ("1 m", "1 m")}},
         "prior of time_offset must have a unit such as s"),
        ({"free": ["gap[3-4]"], "priors": {"gap[3-4]": ("1%", "1 um")}}, "must have a unit"),
        ({"free": ["exponent"], "priors": {"exponent": ("much", 0.1)}}, "number or a percentage"),
        ({"start": {"exponent": 1.4}}, "unknown free parameter 'exponent'"),
        ({"chain": hc.Chain.uniform(20)}, "in scaled variables"),
        ({"chain": bench(LAW, beads=12)}, "a sensor in ball 16, but there is no ball 16"),
        ({"chain": bench(LAW).replace(right_wall=None)}, "the right end of the chain is free"),
        ({"starts": 0}, "starts must be a whole number"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)  # fmt: skip
def test_bad_fits_are_refused_in_one_sentence(changes, words, traces):
    arguments = {"traces": traces, "chain": bench(LAW)} | changes
    with pytest.raises(hc.InputError) as caught:
        hc.fit(**arguments)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


GIVEN = {"stiffness": bench(LAW).stiffness, "right_wall": hc.Wall(bench(LAW).wall_stiffness[1])}


@pytest.mark.parametrize(
    ("fields", "name", "words"),
    [
        (GIVEN, "materials[steel].young", "the stiffness of all its contacts is given; free 'stif"),
        (GIVEN, "materials[steel].poisson", "the stiffness of all its contacts is given"),
        ({"masses": bench(LAW).masses}, "materials[steel].density", "free 'mass[8]' of single"),
        (
            GIVEN | {"masses": bench(LAW).masses, "exponent": 1.6}, "radius[8]",
            "its mass and the stiffness of its contacts are given; free 'mass[8]', "
            "'stiffness[7-8]' or 'stiffness[8-9]' instead",
        ),
    ],
)  # fmt: skip
def test_parameters_without_an_effect_are_refused(fields, name, words, traces, monkeypatch):
    monkeypatch.setattr("hertzchain.fitting.simulations.simulate", None)  # before the search
    with pytest.raises(hc.InputError, match=re.escape(words)):
        hc.fit(traces, bench(LAW).replace(**fields), free=["time_offset", name])


def test_the_contacts_of_a_ball_or_a_material_are_named_as_parameters(traces):
    chain = bench(LAW)
    given = GIVEN | {"masses": chain.masses, "exponent": 1.6}
    kinds = [*chain.materials]
    kinds[-1] = dataclasses.replace(kinds[-1], name="other")
    kinds[4] = dataclasses.replace(kinds[4], name="third")
    mixed = chain.replace(**given, materials=kinds)
    balls = mixed.beads - mixed.strikers
    last, ball = f"stiffness[{balls - 1}-{balls}]", 5 - mixed.strikers
    around = [f"stiffness[{ball - 1}-{ball}]", f"stiffness[{ball}-{ball + 1}]"]
    for name, advised in (
        (f"radius[{balls}]", [f"mass[{balls}]", last]), ("materials[other].young", [last]),
        ("materials[third].young", around),
    ):  # fmt: skip
        with pytest.raises(hc.InputError) as caught:
            hc.fit(traces, mixed, free=["time_offset", name])
        words = str(caught.value).partition("; free ")[2]
        assert words == f"{' or '.join(map(repr, advised))} instead"
        # The names that are advised are accepted.
        for each in advised:
            assert value_of(mixed, parse_name(each)) > 0.0


def test_crosstalk_between_different_units_is_refused(traces):
    shot = traces.shots[0]
    columns = {"ball 6 [N]": shot.signals[0].values, "wall [V]": shot.signals[-1].values}
    mixed = hc.Traces.from_arrays(shot.times, columns)
    with pytest.raises(hc.InputError, match="no neighbouring column has the same unit"):
        hc.fit(mixed, bench(LAW), free=["gain[wall]", "time_offset", "crosstalk"])


def test_fewer_samples_than_parameters_are_refused():
    few = hc.Traces.from_arrays([0.0, 1e-6, 2e-6], {"wall [N]": [0.0, 1.0, 0.0]}, noise=0.1)
    with pytest.raises(hc.InputError, match="4 parameters cannot be fitted to 3 samples"):
        hc.fit(few, bench(LAW), free=["stiffness", "loss.time", "time_offset", "exponent"])


def test_runs_are_compared_with_traces():
    data, chain = hc.example_experiment()
    run = hc.simulate(hc.load_chain(chain), until=6e-4, times=1201)
    compared = run.compare(data)
    assert 0.005 < compared.differences["ball 6"] < 0.06
    assert len(compared.plot().axes) == 8
    with pytest.raises(hc.InputError, match="scaled variables"):
        hc.simulate(hc.Chain.uniform(9)).compare(data)


@pytest.mark.long
def test_results_can_be_shown_and_written(example, tmp_path):
    assert len(repr(example).splitlines()) <= 3
    assert len(repr(example.traces).splitlines()) <= 3
    file = tmp_path / "fitted.toml"
    file.write_text(example.chain_toml())
    # Files of fits have seven digits.
    assert np.allclose(hc.load_chain(file).stiffness, example.chain.stiffness, rtol=5e-7)
    data = example.to_xarray()
    assert str(data["unit"].sel(parameter="struck_by.velocity").values) == "m/s"
    assert data["correlation"].dims == ("parameter", "other_parameter")
    assert data.attrs["verdict"] == example.verdict
    rest = data["ball_6"] - data["ball_6_fit"]
    assert float((rest**2).mean()) ** 0.5 < 0.13
    assert float(data["value"].sel(parameter="lag")) == example.values["lag"]
    json.dumps(example.as_dict(), allow_nan=False)
    assert np.allclose(np.diag(example.correlation), 1.0)
    for figure in (example.plot(), example.plot_residuals(), example.plot_correlations()):
        figure.canvas.draw()


def test_sampling_needs_its_extra(example, monkeypatch):
    monkeypatch.setitem(sys.modules, "emcee", None)
    with pytest.raises(hc.InputError, match=r"pip install '\.\[fit\]'"):
        example.sample(10)


def test_sampling_rejects_seeds_that_numpy_cannot_use(example):
    pytest.importorskip("emcee")
    with pytest.raises(hc.InputError, match="from 0 to 4294967295, got 4294967296"):
        example.sample(10, seed=2**32)


def test_interrupted_sampling_prints_nothing(example, monkeypatch, capsys):
    pytest.importorskip("emcee")

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(Problem, "residuals", interrupted)
    with pytest.raises(KeyboardInterrupt):
        example.sample(10)
    assert capsys.readouterr() == ("", "")


@pytest.mark.long
def test_progress_of_a_fit_ends_with_it(traces):
    counts = []
    result = hc.fit(
        traces, bench(hc.Restitution(0.97)), free=["struck_by.velocity", "time_offset"], starts=1,
        progress=lambda done, total: counts.append((done, total)),
    )  # fmt: skip
    assert counts
    assert set(counts) == {(each, 0) for each in range(1, len(counts) + 1)}
    seen = len(counts)
    result.model.simulator.signals(bench(hc.Restitution(0.9)), 1e-4)
    assert len(counts) == seen


@pytest.mark.long
def test_posterior_agrees_with_least_squares():
    pytest.importorskip("emcee")
    # Without losses, all chains are alike, and no step needs a simulation.
    data = measured(bench(), np.random.default_rng(6), balls=(6,), duration=200e-6)
    one = hc.Traces((hc.Traces.from_arrays(
        data.shots[0].times, {"ball 6 [N]": data.shots[0].signals[0].values}
    ).shots[0],))  # fmt: skip
    free = ["stiffness", "struck_by.velocity", "time_offset"]
    result = hc.fit(one, bench(), free=free, priors={"struck_by.velocity": (0.3, 0.003)})
    before = result.model.simulator.count
    posterior = result.sample(150, seed=1)
    assert result.model.simulator.count == before
    for name in free:
        shift = abs(posterior.means[name] - result.values[name]) / result.errors[name]
        assert shift < 0.25
        assert posterior.errors[name] == pytest.approx(result.errors[name], rel=0.2)
    panels = posterior.plot().axes
    assert len(panels) == 6
    # Lower row of the corner: values in the units of the printed results.
    assert posterior.units == ("", "m/s", "s")
    head, *rows = posterior.summary(width=None).splitlines()[:4]
    assert head == f"posterior: {len(posterior.samples)} samples of 3 parameters"
    for row, name, unit in zip(rows, free, ("", " m/s", " us"), strict=True):
        assert re.fullmatch(rf"  {re.escape(name)} +\S+ \+- [\d.]+{unit}", row)
    labels = [axes.get_xlabel() for axes in panels if axes.get_xlabel()]
    assert labels == ["stiffness factor", "striker velocity\n[m/s]", "time offset\n[µs]"]
    middle = float(np.mean(panels[-1].get_xlim()))
    assert middle == pytest.approx(
        1e6 * posterior.means["time_offset"], abs=6e6 * posterior.errors["time_offset"]
    )


@pytest.fixture
def command(run):
    return functools.partial(run, "fit")


def test_command_fits_and_reports(tmp_path, command):
    _, chain = hc.example_experiment()
    done = command(chain.parent / "fast.csv", chain, "--json", "--out", tmp_path / "fitted.toml",
                   "--plot", tmp_path / "fit.png")  # fmt: skip
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    lag = document["parameters"]["lag"]
    assert abs(lag["value"] - 1.4e-6) < 3.0 * lag["error"]
    assert lag["unit"] == "s"
    assert {each.name for each in tmp_path.iterdir()} == {
        "fitted.toml", "fit.png", "fit-residuals.png", "fit-correlations.png"
    }  # fmt: skip


@pytest.mark.long
def test_an_interrupted_sampling_does_not_lose_the_fit(tmp_path, monkeypatch):
    from click.testing import CliRunner

    from hertzchain.cli import cli

    def interrupted(*_, **__):
        assert {each.name for each in tmp_path.iterdir()} == {
            "fitted.toml", "fit.png", "fit-residuals.png", "fit-correlations.png"
        }  # fmt: skip
        raise KeyboardInterrupt

    monkeypatch.setattr(hc.FitResult, "sample", interrupted)
    _, chain = hc.example_experiment()
    arguments = ["fit", str(chain.parent / "fast.csv"), str(chain), "--sample", "100", "--out",
                 str(tmp_path / "fitted.toml"), "--plot", str(tmp_path / "fit.png")]  # fmt: skip
    done = CliRunner().invoke(cli, arguments, standalone_mode=False)
    assert isinstance(done.exception, (KeyboardInterrupt, click.Abort))
    assert "the model describes the data" in done.output
    assert "11 parameters need about 155 steps, more than --sample 100" in done.output


@pytest.mark.long
@pytest.mark.parametrize("count", [2, 6])
def test_the_steps_of_a_gaussian_posterior_are_estimated(count):
    emcee = pytest.importorskip("emcee")
    walkers = max(MIN_WALKERS, 2 * count + 2)
    moves = moves_from(np.zeros(count), np.eye(count))
    sampler = emcee.EnsembleSampler(
        walkers, count, lambda rows: -0.5 * np.sum(rows**2, axis=1), vectorize=True, moves=moves
    )
    sampler.random_state = np.random.RandomState(0).get_state()
    sampler.run_mcmc(np.random.default_rng(0).normal(size=(walkers, count)), 5000)
    needed = 50.0 * float(np.max(sampler.get_autocorr_time(tol=0)))
    assert steps_needed(count) == pytest.approx(needed, rel=0.4)


@pytest.mark.long
def test_walkers_have_the_distribution_of_a_skew_posterior_far_from_that_of_the_fit():
    emcee = pytest.importorskip("emcee")

    def log_density(rows):
        # x is exponentially distributed, and y normal, with the mean x^2.
        x, y = rows.T
        return np.where(x > 0.0, -x - 0.5 * (y - x**2) ** 2, -np.inf)

    moves = moves_from(np.array([0.3, 0.0]), np.diag([0.8, 1.2]))
    sampler = emcee.EnsembleSampler(16, 2, log_density, vectorize=True, moves=moves)
    sampler.random_state = np.random.RandomState(0).get_state()
    sampler.run_mcmc(np.random.default_rng(0).uniform(0.1, 1.0, size=(16, 2)), 20_000)
    x, y = sampler.get_chain(discard=2000, flat=True).T
    quantiles = [0.1, 0.5, 0.9]
    assert np.quantile(x, quantiles) == pytest.approx(-np.log1p(-np.array(quantiles)), rel=0.06)
    assert np.std(y - x**2) == pytest.approx(1.0, rel=0.03)


@pytest.mark.long
def test_an_interrupted_diagnosis_keeps_the_fit_and_its_files(tmp_path):
    _, chain = hc.example_experiment()
    data, plain, out = chain.parent / "fast.csv", tmp_path / "plain.toml", tmp_path / "fitted.toml"
    plain.write_text(chain.read_text().partition("[fit]")[0])
    line = [sys.executable, "-m", "hertzchain", "fit", str(data), str(plain), "--out", str(out)]
    with subprocess.Popen(
        line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path
    ) as process:
        while LOOKING not in process.stderr.readline():
            assert process.poll() is None
        process.send_signal(SIGINT)
        began = monotonic()
        shown, rest = process.communicate(timeout=60)
    assert monotonic() - began < PROMPT
    assert process.returncode == 130
    assert "does not describe the data" in shown
    assert "the fit and its files are complete" in rest
    assert out.exists()


@pytest.mark.long
def test_command_reports_a_model_that_does_not_describe_the_data(tmp_path, command):
    _, chain = hc.example_experiment()
    data, plain = chain.parent / "fast.csv", tmp_path / "plain.toml"
    plain.write_text(chain.read_text().partition("[fit]")[0])
    done = command(data, plain)
    assert done.returncode == 3, done.stderr
    assert "the model does not describe the data" in done.stdout
    assert "Warning" not in done.stderr
    quick = command(data, plain, "--no-diagnosis")
    assert quick.returncode == 3
    assert done.stdout.startswith(quick.stdout)
    assert LOOKING in done.stderr
    assert LOOKING not in quick.stderr
    done = command(data, chain, "--free", "time_offset", "--prior", "exponent=1.5,0.1")
    assert done.returncode == 2
    assert "has a prior but is not free: add --also-free '" in done.stderr
    done = command(data, chain, "--free", "time_offset")
    assert done.returncode == 2
    assert "ball 11 is in V without calibration, so its gain must be free: add " in done.stderr
    assert "--also-free 'gain[*]'" in done.stderr


def test_command_reports_a_fit_that_does_not_converge(monkeypatch):
    from click.testing import CliRunner

    from hertzchain.cli import cli

    _, chain = hc.example_experiment()
    monkeypatch.setattr(least_squares, "MAX_EVALUATIONS", 2)
    arguments = ["fit", str(chain.parent / "fast.csv"), str(chain), "--starts", "1"]
    done = CliRunner().invoke(cli, arguments, standalone_mode=False)
    assert done.return_value == 1
    assert done.output.count("converged after 2 evaluations") == 1

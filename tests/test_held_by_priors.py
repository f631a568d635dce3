"""Parameters whose errors come from priors more than from the data."""

import json
import math

import numpy as np
import pytest
from click.testing import CliRunner
from scipy_row import FREE, VELOCITY, chain, recorded, traces

import hertzchain as hc
from hertzchain.cli import cli
from hertzchain.fitting.held_by_priors import HeldByPriors, held_by_priors, prior_notes
from hertzchain.fitting.weak_directions import WeakDirection, weak_directions

GAINS = ("gain[ball 5]", "gain[ball 10]", "gain[wall]")


def held(names, data, priors):
    """Parameters of a linear model that priors, by name, hold."""
    rows = np.zeros((len(priors), len(names)))
    for row, (name, sigma) in zip(rows, priors.items(), strict=True):
        row[names.index(name)] = 1.0 / sigma
    jacobian = np.concatenate((np.atleast_2d(data), rows))
    return held_by_priors(names, jacobian, [*priors], np.eye(len(names)))


@pytest.mark.parametrize(("sigma", "share"), [(0.5, 0.8), (0.99, 0.50505), (1.01, None)])
def test_one_parameter_is_held_if_its_variance_is_above_half_that_of_its_prior(sigma, share):
    # Data of error 1: the variance is 1/(1 + 1/s^2), and that of the prior s^2.
    found = held(["a"], [[1.0]], {"a": sigma})
    assert [each.share for each in found] == pytest.approx([] if share is None else [share], 1e-4)


def test_shares_of_a_sum_that_the_data_determine():
    # a + b is measured with error s, a and b are known with errors p and q.  With the weight
    # w = p^2/(p^2 + q^2 + s^2), a = a0 + w (y - a0 - b0), so that its variance is
    # (1 - w)^2 p^2 + w^2 q^2 + w^2 s^2.
    p, q, s = 0.1, 0.3, 0.05
    found = held(["a", "b"], [[1.0 / s, 1.0 / s]], {"a": p, "b": q})
    for name, own, other in (("a", p, q), ("b", q, p)):
        w = own**2 / (p**2 + q**2 + s**2)
        parts = {name: ((1.0 - w) * own) ** 2, "ba"[name == "b"]: (w * other) ** 2}
        variance = sum(parts.values()) + (w * s) ** 2
        (this,) = (each for each in found if each.name == name)
        assert this.priors == pytest.approx({k: v / variance for k, v in parts.items()}, rel=1e-12)
        assert this.share == pytest.approx(sum(parts.values()) / variance, rel=1e-12)
        # Both are held by the prior of a, which is the better one.
        assert this.main == ("a",)


def test_shares_do_not_depend_on_units():
    data = np.array([[3.0, 1.0], [0.5, 2.0]])
    one = held(["a", "b"], data, {"a": 0.1})
    other = held(["a", "b"], data * [1e6, 1.0], {"a": 0.1e-6})
    assert [each.priors for each in one] == [pytest.approx(each.priors, rel=1e-9) for each in other]


def test_data_alone_and_better_data_hold_no_parameter_by_priors():
    assert held(["a", "b"], np.eye(2), {}) == ()
    assert held(["a", "b"], 100.0 * np.eye(2), {"a": 0.5, "b": 0.5}) == ()


def test_notes_group_parameters_and_omit_those_of_weak_directions():
    alone = HeldByPriors("highpass", 0.9, {"highpass": 0.9})
    pair = [
        HeldByPriors(name, share, {"b": share - 0.05, "c": 0.05})
        for name, share in (("a", 0.7), ("b", 0.9999))
    ]
    assert prior_notes([alone, *pair], ()) == [
        "90% of the variance of highpass comes from its prior: a separate, more accurate "
        "measurement of it would reduce this error more than less noise",
        "70 to 99% of the variances of a and b come from priors, above all from that of b: a "
        "separate, more accurate measurement of b would reduce these errors more than less noise",
    ]
    direction = WeakDirection({"a": 1.0, "b": -1.0}, np.inf, True, ("b",))
    assert len(prior_notes([alone, *pair], [direction])) == 1
    assert repr(alone).startswith("HeldByPriors(")


def test_a_fit_names_a_lag_that_only_its_prior_holds():
    priors = {"lag": (0.0, 0.05e-6)}
    result = hc.fit(traces(), chain(), free=[*FREE, "lag"], priors=priors)
    assert result.errors["lag"] > 0.7 * 0.05e-6
    # The pulse begins later with a later trigger or a slower amplifier.
    assert [each.name for each in result.held] == ["time_offset", "lag"]
    assert "of the variances of time_offset and lag come from the prior of lag:" in result.summary()
    document = result.as_dict()["held_by_priors"]
    assert document[1]["priors"] == {"lag": pytest.approx(document[1]["share"])}


def test_gains_and_stiffness_of_traces_are_held_by_the_prior_of_the_velocity():
    # Signals remain the same if the velocity decreases by 1%, the stiffness increases by 0.5% and
    # the gains by 1%: only the priors fix this combination, and that of the velocity is the best.
    times, columns = recorded()
    volts = {name.replace("[N]", "[V]"): 0.02 * values for name, values in columns.items()}
    priors = dict.fromkeys(GAINS, (0.02, 0.05 * 0.02))
    priors["struck_by.velocity"] = VELOCITY, 0.01 * VELOCITY
    result = hc.fit(hc.Traces.from_arrays(times, volts), chain(), free=[*FREE, *GAINS],
                    priors=priors)  # fmt: skip
    found = {each.name: each for each in result.held}
    assert {*found} == {"stiffness", "struck_by.velocity", *GAINS}
    assert all(each.main == ("struck_by.velocity",) for each in found.values())
    # The weights of the priors are 1 : 1/25 : 1/25 : 1/25.
    expected = 0.01 / math.sqrt(1.0 + 3.0 / 25.0)
    for name in ("struck_by.velocity", *GAINS):
        error = result.errors[name] / result.values[name]
        assert error == pytest.approx(expected, rel=0.02)
        assert found[name].priors["struck_by.velocity"] == pytest.approx(1.0 / 1.12, rel=0.03)


@pytest.fixture(scope="module")
def weighed(tmp_path_factory):
    """A vertical row, whose weights determine the gains, but less well than the priors do."""
    file = tmp_path_factory.mktemp("weighed") / "row.toml"
    file.write_text(hc.chain_as_toml(chain(gravity=9.81)))
    return file


def forecast_of(file, noise):
    words = [each for name in GAINS for each in ("--sensor", f"{name[5:-1]} [V]")]
    priors = {"struck_by.velocity": "0.26,0.0026"} | dict.fromkeys(GAINS, "0.02,0.0006")
    words += [each for pair in priors.items() for each in ("--prior", "=".join(pair))]
    words += [each for name in (*FREE, *GAINS) for each in ("--free", name)]
    words += ["--noise", noise, "--interval", "1us"]
    return CliRunner().invoke(cli, ["forecast", str(file), *words, "--json"])


def test_a_forecast_names_the_prior_that_must_be_better(weighed):
    found = json.loads(forecast_of(weighed, "20 mV").stdout)
    assert "struck_by.velocity" in {each["name"] for each in found["held_by_priors"]}
    (note,) = (each for each in found["warnings"] if "from priors" in each)
    assert "measurement of struck_by.velocity would reduce these errors" in note
    assert not any("the data determine only" in each for each in found["warnings"])
    # With less noise, the data determine the velocity.
    assert json.loads(forecast_of(weighed, "0.5 mV").stdout)["held_by_priors"] == []


# The delays of two sensors are measured only from the time offset, each with an error of 1 ns.
DELAYS = ("time_offset", "delay[ball 5]", "delay[wall]")
SHIFTS = np.array([[1.0, 1.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 0.0]]) / 1e-9
# The size of the time offset is the time in which a pulse passes a ball.
TIMES = np.array([20e-6, 1e-6, 1e-6])


@pytest.mark.parametrize("prior", [0.5, 2.0, 200.0])
def test_a_prior_of_any_width_fixes_what_the_data_do_not_determine(prior):
    (found,) = weak_directions(DELAYS, SHIFTS, np.zeros(3), TIMES, {"delay[wall]": prior})
    assert found.exact
    assert found.fixed_by == ("delay[wall]",)
    assert {name: found.weights[name] / found.weights["time_offset"] for name in DELAYS} == (
        pytest.approx({"time_offset": 1.0, "delay[ball 5]": -1.0, "delay[wall]": -1.0})
    )
    assert "if the changes of these are in the ratio 1 : -1 : -1; only the prior" in str(found)


def test_directions_without_priors_are_not_fixed():
    (found,) = weak_directions(DELAYS, SHIFTS, np.zeros(3), TIMES, {})
    assert (found.fixed_by, {*found.weights}) == ((), {*DELAYS})


def test_changes_of_times_do_not_depend_on_their_values():
    values = np.array([3e-6, 2e-6, -0.05e-6])
    (found,) = weak_directions(DELAYS, SHIFTS, values, TIMES, {})
    assert [abs(each) for each in found.weights.values()] == pytest.approx([1.0, 1.0, 1.0])


def test_one_prior_fixes_only_one_of_two_directions():
    # Of a, b, c and d, the data determine a + b and c + d.
    data = np.array([[1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0]]) * 1e6
    turned = np.concatenate(([[0.6, 0.8], [-0.8, 0.6]] @ data, np.zeros((2, 4))))
    found = weak_directions("abcd", turned, np.ones(4), np.ones(4), {"a": 5.0})
    assert {each.fixed_by: {*each.weights} for each in found} == {
        ("a",): {"a", "b"}, (): {"c", "d"},
    }  # fmt: skip


def test_a_prior_fixes_a_weak_direction_if_it_is_narrower_than_the_data():
    # The data determine the sum well and the difference with an error of 10.
    data = np.array([[1e3, 1e3], [0.1, -0.1]]) / 2.0**0.5
    for sigma, fixed in ((3.0, ("a",)), (30.0, ())):
        (found,) = weak_directions("ab", data, np.ones(2), np.ones(2), {"a": sigma})
        assert (found.exact, found.fixed_by) == (False, fixed)


@pytest.mark.parametrize("sigma", [0.5e-6, 2e-6])
@pytest.mark.parametrize("with_prior", [0, 1, 3])
def test_errors_of_delays_with_a_free_time_offset_are_those_of_their_priors(sigma, with_prior):
    delays = ["delay[ball 5]", "delay[ball 10]", "delay[wall]"]
    plan = hc.forecast(
        chain(), ["ball 5", "ball 10", "wall"], noise="10 mN", interval="1 us",
        free=[*FREE, *delays], priors=dict.fromkeys(delays[:with_prior], (0.0, sigma)),
    )  # fmt: skip
    for name in ("time_offset", *delays):
        # The mean of the priors determines the common shift.
        expected = sigma / math.sqrt(with_prior) if with_prior else math.inf
        assert plan.errors[name] == pytest.approx(expected, rel=0.05)
    assert ("not determined" in plan.summary()) == (not with_prior)
    assert ("only the prior" in plan.summary()) == bool(with_prior)

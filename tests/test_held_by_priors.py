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
from hertzchain.fitting.weak_directions import WeakDirection

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

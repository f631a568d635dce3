"""Values of fits without the priors that the data contradict."""

import json
import math

import numpy as np
import pytest
from click.testing import CliRunner
from scipy_row import FREE, SENSORS, TRUTH, VELOCITY, chain, recorded, traces

import hertzchain as hc
from hertzchain.cli import cli

GAIN = 0.02
GAINS = [f"gain[{name}]" for name in SENSORS]


def volts():
    times, columns = recorded()
    return times, {name.replace("[N]", "[V]"): GAIN * each for name, each in columns.items()}


def priors(wrong, sigma=0.0004):
    known = dict.fromkeys(GAINS, (GAIN, 0.0004)) | {"gain[ball 10]": (wrong, sigma)}
    return known | {"struck_by.velocity": (VELOCITY, 0.01 * VELOCITY)}


# With the smaller error, the wrong prior biases the others, which the fit contradicts, too.
@pytest.mark.parametrize("sigma", [pytest.param(0.0004, marks=pytest.mark.long), 0.0001])
def test_values_without_the_wrong_prior_of_a_gain_are_those_of_the_experiment(sigma):
    free, given = [*FREE, *GAINS], priors(1.15 * GAIN, sigma)
    result = hc.fit(hc.Traces.from_arrays(*volts()), chain(), free=free, priors=given)
    truth = TRUTH | dict.fromkeys(GAINS, GAIN)
    biased = [name for name, true in truth.items()
              if abs(result.values[name] - true) > 2.5 * result.errors[name]]  # fmt: skip
    assert {"stiffness", "struck_by.velocity", *GAINS} >= {*biased} != set()
    (found,) = result.without_priors
    assert found.priors == ("gain[ball 10]",)
    assert found.result.prior_conflict == ""
    for name, true in truth.items():
        assert abs(found.result.values[name] - true) < 3.0 * found.result.errors[name]
    # The same as a fit that never had this prior.
    del given["gain[ball 10]"]
    start = {"gain[ball 10]": GAIN}
    direct = hc.fit(hc.Traces.from_arrays(*volts()), chain(), free=free, priors=given, start=start)
    assert found.result.values == pytest.approx(direct.values, rel=1e-3)
    (note,) = (each for each in result.notes if each.startswith("without the prior"))
    assert note == found.note
    assert note.startswith(
        "without the prior of gain[ball 10], the other priors agree with the data: gain[ball 10] = "
    )
    assert note.count(" mV/N") == 3
    assert "struck_by.velocity = 0.24" in note
    assert "loss.time" not in note
    assert note.endswith("; the others change by less than half of their errors")
    lines = result.summary(width=None).splitlines()
    # The advice that several notes of this kind have in common may be between them.
    before = lines[: lines.index(note)]
    assert any("from its prior, " in line for line in before[-2:])
    assert repr(found).startswith("WithoutPriors(")


def test_a_prior_that_biases_little_says_so():
    given = {"struck_by.velocity": (VELOCITY - 0.024, 2e-3)}
    (found,) = hc.fit(traces(), chain(), free=FREE, priors=given).without_priors
    assert found.note.startswith("without the prior of struck_by.velocity: struck_by.velocity = ")
    assert "stiffness" not in found.note


def test_priors_without_a_conflict_are_kept():
    given = {"struck_by.velocity": (VELOCITY, 2e-3)}
    assert hc.fit(traces(), chain(), free=FREE, priors=given).without_priors == ()


def test_either_of_two_priors_that_contradict_each_other_may_be_wrong():
    # Two priors of one combination of parameters, with the same relative error: the fit is
    # half-way between, and the data do not say which is wrong.
    times, columns = volts()
    wall = {name: each for name, each in columns.items() if name == "wall [V]"}
    known = {"struck_by.velocity": VELOCITY, "gain[wall]": 1.12 * GAIN}
    given = {name: (value, 0.01 * value) for name, value in known.items()}
    result = hc.fit(hc.Traces.from_arrays(times, wall), chain(), free=[*FREE, "gain[wall]"],
                    priors=given)  # fmt: skip
    assert {each.priors[0] for each in result.without_priors} == {*given}
    chi2 = [each.result.chi2 for each in result.without_priors]
    assert math.isclose(*chi2, rel_tol=1e-4)


def test_the_document_has_the_values_without_the_prior(tmp_path):
    times, columns = volts()
    header = ",".join(["time [us]", *columns])
    rows = np.column_stack([1e6 * times, *columns.values()])
    np.savetxt(tmp_path / "data.csv", rows, fmt="%.7g", delimiter=",", header=header, comments="")
    (tmp_path / "row.toml").write_text(hc.chain_as_toml(chain()))
    words = [each for name in (*FREE, *GAINS) for each in ("--free", name)]
    for name, (value, sigma) in priors(1.15 * GAIN).items():
        words += ["--prior", f"{name}={value},{sigma}"]
    files = [str(tmp_path / name) for name in ("data.csv", "row.toml")]
    done = CliRunner().invoke(cli, ["fit", *files, *words, "--json"])
    assert json.loads(done.stdout)["prior_conflict"].startswith("gain[ball 10] is 6.4")
    (found,) = json.loads(done.stdout)["without_priors"]
    assert found["priors"] == ["gain[ball 10]"]
    assert found["parameters"]["gain[wall]"]["value"] == pytest.approx(GAIN, rel=0.02)

"""Priors that contradict the data, and priors of a chain file whose parameters are not free."""

import json
import math

import numpy as np
import pytest
from scipy_row import FREE, RADIUS, VELOCITY, chain, recorded, traces

import hertzchain as hc
from hertzchain.fitting.parameters import free_parameters
from hertzchain.fitting.prior_conflicts import (
    ADVICE,
    COMPARED,
    _advised_once,
    conflict,
    contradicted,
)
from hertzchain.units import volts_per

CALIBRATION = "check the diameters, masses and materials of the chain, the calibration"
FILE = """
[fit]
free = ["stiffness", "loss.time", "struck_by.velocity", "time_offset"]
[fit.prior]
"struck_by.velocity" = ["25 cm/s", "5 mm/s"]
"""


@pytest.fixture
def files(tmp_path):
    times, columns = recorded()
    header = ",".join(["time [us]", *columns])
    rows = np.column_stack([1e6 * times, *columns.values()])
    np.savetxt(tmp_path / "data.csv", rows, fmt="%.7g", delimiter=",", header=header, comments="")
    (tmp_path / "row.toml").write_text(hc.chain_as_toml(chain()) + FILE)
    return tmp_path


def fitted(mean, sigma, **fields):
    return hc.fit(
        traces(), chain(**fields), free=FREE, priors={"struck_by.velocity": (mean, sigma)}
    )


def test_common_advice_is_given_once():
    notes = [("a", ADVICE), ("b", ""), ("c", "check c"), ("d", ADVICE)]
    assert _advised_once(notes[:3]) == (f"a: {ADVICE}", "b", "c: check c")
    *found, advice = _advised_once(notes)
    assert found == ["a", "b", "c: check c", "d"]
    assert advice.startswith(CALIBRATION)
    assert advice.endswith("the priors themselves")
    # A comparison keeps the loss and the velocity, which are common factors of all gains.
    *found, advice = _advised_once([("a", COMPARED), ("b", COMPARED)], COMPARED)
    assert found == ["a", "b"]
    assert advice.startswith("check the velocity of the impact, the loss, the diameters, masses")
    assert advice.endswith("the priors themselves")


@pytest.mark.parametrize(("mean", "deviations"), [(VELOCITY - 0.024, 12), (VELOCITY + 0.03, -15)])
def test_a_fit_far_from_its_prior_says_so(mean, deviations):
    result = fitted(mean, 2e-3)
    # The data determine the velocity much better than the prior.
    assert result.prior_deviations["struck_by.velocity"] == pytest.approx(deviations, rel=0.03)
    words = f"struck_by.velocity is {abs(deviations):.0f} standard deviations from its prior"
    assert result.describes
    assert result.prior_conflict == words
    assert result.verdict.endswith(f". However, {words}")
    (note,) = (each for each in result.notes if "from its prior" in each)
    assert CALIBRATION in note
    assert f"from its prior, {mean:.4f} +- 0.0020 m/s: " in note
    assert note in result.warnings
    assert note in result.summary(width=None).splitlines()
    assert result.as_dict()["prior_conflict"] == words


@pytest.mark.parametrize(
    ("factor", "error", "words"),
    [
        (0.1, 6e-4, "are 10 times too small, because a probe or an amplifier"),
        (0.5, 6e-4, CALIBRATION),
    ],
)  # fmt: skip
def test_a_gain_that_is_wrong_by_a_power_of_ten_is_explained(factor, error, words):
    times, columns = recorded()
    known = {name: values for name, values in columns.items() if "wall" not in name}
    header = next(name for name in columns if "wall" in name)
    # An amplifier of 20 mV/N, whose column is read with another unit.
    gain = 0.02
    volts = hc.Traces.from_arrays(times, known | {"wall [V]": factor * gain * columns[header]})
    result = hc.fit(
        volts, chain(), free=[*FREE, "gain[wall]"], priors={"gain[wall]": (1.03 * gain, error)}
    )
    assert result.values["gain[wall]"] == pytest.approx(factor * gain, rel=0.02)
    (note,) = (each for each in result.notes if "from its prior" in each)
    assert words in note
    assert note in result.warnings
    assert ("diameters" in note) == (words == CALIBRATION)


@pytest.mark.parametrize(("factor", "error"), [(1e-3, 6e-4), (1e3, 1.0)])
def test_a_column_in_another_unit_is_fitted_in_that_unit(factor, error):
    times, columns = recorded()
    known = {name: values for name, values in columns.items() if "wall" not in name}
    gain = 0.02
    volts = hc.Traces.from_arrays(times, known | {"wall [V]": factor * gain * columns["wall [N]"]})
    result = hc.fit(
        volts, chain(), free=[*FREE, "gain[wall]"], priors={"gain[wall]": (1.03 * gain, error)}
    )
    assert result.explained
    assert not result.describes
    (note,) = result.warnings
    assert note.startswith(f"with the values of wall multiplied by {1.0 / factor:g}, chi2 falls")
    assert "check the unit in the header of this column" in note
    # The values are those of the correct unit.
    assert result.values["gain[wall]"] == pytest.approx(gain, rel=0.02)


def test_a_prior_that_forbids_a_wrong_unit_names_the_column():
    times, columns = recorded()
    known = {name: values for name, values in columns.items() if "wall" not in name}
    volts = hc.Traces.from_arrays(times, known | {"wall [V]": 20.0 * columns["wall [N]"]})
    result = hc.fit(volts, chain(), free=[*FREE, "gain[wall]"], priors={"gain[wall]": (0.02, 6e-4)})
    assert not result.describes
    assert "the values of wall multiplied by 0.001" in result.summary(width=None)
    assert "check the unit in the header of this column" in result.summary(width=None)


def test_a_fit_near_its_prior_does_not_mention_it():
    result = fitted(VELOCITY - 2.5 * 2e-3, 2e-3)
    assert result.prior_deviations["struck_by.velocity"] == pytest.approx(2.5, abs=0.3)
    assert result.prior_conflict == ""
    assert "its prior" not in result.summary(width=None)


def test_a_wrong_diameter_contradicts_the_prior_of_the_velocity():
    """The pulse of smaller balls has the same shape at another velocity, as in scaled variables."""
    smaller = hc.Chain.from_materials(0.95 * RADIUS, "steel-52100", beads=15)
    smaller = smaller.struck_by(velocity=0.26).replace(
        right_wall=hc.Wall.of("steel-304"), loss=hc.Viscoelastic(0.4e-6)
    )
    prior = {"struck_by.velocity": (VELOCITY, 5e-3)}
    result = hc.fit(traces(), smaller, free=FREE, priors=prior)
    assert result.describes
    # The momentum m v is that of the data: the mass is proportional to the third power.
    assert result.values["struck_by.velocity"] == pytest.approx(VELOCITY / 0.95**3, rel=2e-3)
    assert "standard deviations from its prior" in result.verdict


def test_comparisons_of_losses_mention_a_contradicted_prior():
    prior = {"struck_by.velocity": (VELOCITY - 0.02, 2e-3)}
    compared = hc.compare_losses(
        traces(), chain(), laws=["viscoelastic", "elastic"], free=FREE, priors=prior
    )
    assert compared.statement.startswith("of the laws compared, viscoelastic describes")
    assert compared.statement.endswith("from its prior")


def test_comparisons_of_losses_keep_the_priors_of_materials_named_like_a_loss():
    steel = hc.material("steel-52100")
    alloy = hc.Material("lossy-alloy", steel.density, steel.young, steel.poisson)
    row = hc.Chain.from_materials(RADIUS, alloy, beads=15).struck_by(velocity=0.26)
    row = row.replace(right_wall=hc.Wall.of("steel-304"), loss=hc.Viscoelastic(0.4e-6))
    young, prior = "materials[lossy-alloy].young", (steel.young, 0.01 * steel.young)
    compared = hc.compare_losses(
        traces(), row, laws=["viscoelastic"], free=[young, *FREE[1:]], priors={young: prior}
    )
    assert list(compared.fits[0].result.prior_deviations) == [young]


def test_several_priors_may_be_contradicted_together():
    # The probability of a sum of two squares is exp(-sum/2), that of 3 standard deviations 0.27%.
    limit = math.sqrt(-math.log(math.erfc(3.0 / math.sqrt(2.0))))
    assert contradicted({"a": 0.99 * limit, "b": -0.99 * limit}) == ()
    both = {"a": 1.01 * limit, "b": -1.01 * limit}
    assert contradicted(both) == ("a", "b")
    assert conflict(both).startswith("the priors of a and b together contradict the data (chi2 12")
    assert contradicted({"a": 3.1, "b": 0.1}) == ("a",)
    assert conflict({}) == ""
    assert conflict({"a": 1e9}) == "a is more than 100 standard deviations from its prior"


@pytest.mark.long
def test_the_exit_code_of_a_contradicted_prior_is_that_of_a_bad_fit(run, files):
    where = ("fit", files / "data.csv", files / "row.toml", "--json")
    code, out, _ = run(*where)
    assert code == 0
    assert json.loads(out)["prior_conflict"] == ""
    code, out, _ = run(*where, "--prior", f"struck_by.velocity={VELOCITY - 0.02},0.002")
    assert code == 3
    assert json.loads(out)["describes"] is True
    assert "from its prior" in json.loads(out)["prior_conflict"]


@pytest.mark.long
def test_priors_with_units_of_parameters_that_are_not_free_are_ignored(run, files):
    free = [word for name in ("stiffness", "loss.time", "time_offset") for word in ("--free", name)]
    code, out, err = run("fit", files / "data.csv", files / "row.toml", *free, "--json")
    assert code in (0, 3), err
    assert [*json.loads(out)["parameters"]] == ["stiffness", "loss.time", "time_offset"]


@pytest.mark.parametrize("name", ["stifness", "stiffness[8-99]", "gain[ball 7]"])
def test_unknown_names_are_reported_before_priors(run, files, name):
    code, _, err = run("fit", files / "data.csv", files / "row.toml", "--free", name)
    assert code == 2
    assert "prior" not in err
    assert name.split("[")[0][:5] in err


def test_priors_of_arguments_must_be_free():
    with pytest.raises(hc.InputError, match=r"'struck_by.velocity' has a prior but is not free"):
        hc.fit(traces(), chain(), free=["stiffness"],
               priors={"struck_by.velocity": ("25 cm/s", "5 mm/s")})  # fmt: skip


def test_misspelled_names_of_priors_are_recognised():
    with pytest.raises(hc.InputError, match=r"did you mean 'struck_by.velocity'\?"):
        hc.fit(traces(), chain(), free=["stiffness"], priors={"struck_by.velocty": (0.25, 0.005)})


def test_a_modulus_and_the_exponent_cannot_both_be_free():
    free = ["materials[steel-52100].young", "exponent", "time_offset"]
    with pytest.raises(hc.InputError, match="free 'stiffness' instead"):
        hc.fit(traces(), chain(), free=free)


@pytest.mark.long
def test_priors_of_a_file_for_sensors_without_a_signal_are_not_used(tmp_path):
    file = tmp_path / "row.toml"
    prior = '[fit]\nfree = ["time_offset"]\n[fit.prior]\n"gain[{}]" = [0.02, 0.001]\n'
    file.write_text(f"{hc.chain_as_toml(chain())}\n{prior.format('ball 12')}")
    with pytest.warns(hc.InputWarning, match=r"'gain\[ball 12\]' of the chain file is not used"):
        assert hc.fit(traces(), file).names == ("time_offset",)
    # Other names may be misspelled.
    file.write_text(f"{hc.chain_as_toml(chain())}\n{prior.format('bal 12')}")
    with pytest.raises(hc.InputError, match="unknown parameter"):
        hc.fit(traces(), file)


def test_posteriors_name_the_steps_that_they_need_and_show_moduli_in_gpa():
    samples = np.array([[195e9], [197e9]])
    posterior = hc.Posterior(("young",), samples, 0.5, 9.25, 100, np.zeros(1), ("Pa",))
    assert "young  196.0 +- 1.0 GPa" in posterior.summary(width=None)
    assert posterior.summary(width=None).endswith(
        "an autocorrelation of 9 steps: take at least 463"
    )


def test_print_shows_the_whole_summary():
    result = fitted(VELOCITY, 2e-3)
    assert str(result) == result.summary()
    assert len(repr(result).splitlines()) <= 3


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (("0.5 V/m", "0.1 V/m"), "must have a unit such as V/N or mV/N, got '0.5 V/m'"),
        (("0.5 kg", "0.1"), "must have a unit such as V/N or mV/N, got '0.5 kg'"),
        ("0.5 V/N +- 0.1 V/N", "must be a value and its standard deviation > 0"),
    ],
)
def test_priors_of_gains_with_wrong_units_are_rejected(given, message):
    with pytest.raises(hc.InputError, match=message):
        hc.fit(*hc.example_experiment(), priors={"gain[ball 11]": given})


def test_the_gain_of_a_calibrated_sensor_has_no_unit():
    priors = {"gain[wall]": ("1 V/N", "0.1 V/N")}
    with pytest.raises(hc.InputError, match=r"gain\[wall\] must be a plain number.*wall is in N"):
        hc.fit(*hc.example_experiment(), priors=priors)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (("0.05 V/N", "0.002 V/N"), (0.05, 0.002)),
        (("50 mV/N", "2 mV/N"), (0.05, 0.002)),
        (["50 V/kN", 0.002], (0.05, 0.002)),
        ((0.05, 0.002), (0.05, 0.002)),
    ],
)
def test_priors_of_gains_have_units(given, expected):
    traces, chain = hc.example_experiment()
    chain = hc.load_chain(chain)
    (found,) = free_parameters(
        traces, [chain] * 2, ["gain[ball 11]"], {"gain[ball 11]": given}, {"gain[ball 11]": 0.04}
    )
    assert found.prior == pytest.approx(expected, rel=1e-14)
    (found,) = free_parameters(
        traces, [chain] * 2, ["gain[ball 11]"], {}, {"gain[ball 11]": "40 mV/N"}
    )
    assert found.start == pytest.approx(0.04, rel=1e-14)


@pytest.mark.parametrize("unit", ["V s/m", "V/(m/s)"])
def test_gains_of_velocity_sensors_are_in_volts_seconds_per_metre(unit):
    assert volts_per(f"0.3 {unit}", "m/s") == 0.3
    assert volts_per(f"300 m{unit}", "m/s") == pytest.approx(0.3, rel=1e-15)
    assert volts_per(f"0.3 {unit}", "N") is None


def test_priors_on_the_command_line_have_units_of_gains(run, tmp_path):
    file = hc.example_experiment()[1]
    data = file.parent / "fast.csv"
    row = tmp_path / "row.toml"
    row.write_text(file.read_text().partition("[fit]")[0])
    plan = ["forecast", row, "--sensor", "wall [V]", "--noise", "3 mV", "--interval", "1us",
            "--free", "stiffness", "--free", "gain[wall]"]  # fmt: skip
    done = run(*plan)
    assert done.returncode == 2
    advice = "add --prior 'gain[wall]=0.01 V/N,0.0003 V/N', or give it in [fit.prior] or [fit.start"
    assert advice in done.stderr
    prior = "gain[wall]=0.01 V/N,0.3 mV/N"
    with_unit, plain = (
        json.loads(run(*plan, "--prior", each, "--json").stdout)
        for each in (prior, "gain[wall]=0.01,0.0003")
    )
    assert with_unit == plain
    done = run("fit", data, row, "--free", "gain[ball 11]", "--prior", "gain[ball 11]=0.04 V/N,-1")
    assert "such as 0.3,0.003, got" in done.stderr


def test_a_prior_of_a_height_is_converted_in_the_message():
    # v^2 = 2 g h = 2 * 9.80665 * 0.003, and the relative error of v is half of that of h.
    words = r"'struck_by.velocity' with the value 0.2426 m/s and the error 0.004 m/s instead"
    with pytest.raises(hc.InputError, match=words):
        hc.fit(*hc.example_experiment(), priors={"struck_by.height": ("3 mm", "0.1 mm")})

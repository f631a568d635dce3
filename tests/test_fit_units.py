"""Fits to data in wrong units, to records without a pulse, and to two errors of sensors at once."""

import json
import re
import warnings
from types import SimpleNamespace

import numpy as np
import pytest
from scipy_row import BALLS, FACTOR, LOSS_TIME, SPACING, VELOCITY, chain, recorded, traces

import hertzchain as hc
from hertzchain.cli.fit import _laws
from hertzchain.cli.wording import on_command_line
from hertzchain.fitting.misread_times import time_factor
from hertzchain.fitting.result_text import clearly_larger

pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
MODULUS = ["materials[steel-52100].young", "loss.time", "time_offset"]
LOOSE = ["stiffness", "struck_by.velocity", "loss.time", "time_offset"]


def fitted(*, force=1.0, time=1.0, free=MODULUS):
    times, columns = recorded()
    columns = {name: force * values for name, values in columns.items()}
    return hc.fit(hc.Traces.from_arrays(time * times, columns), chain(), free=free, starts=1)


@pytest.mark.long
@pytest.mark.parametrize("free", [MODULUS, LOOSE], ids=["modulus", "loose"])
def test_forces_in_kilonewtons_are_recognised(free):
    result = fitted(force=1e-3, free=free)
    assert result.meaningless
    assert {row for _, row in result.rows()} == {"not determined"}
    (advice,) = result.advice
    assert "the values of ball 5, ball 10 and wall multiplied by 1000" in advice
    assert "check the unit in the header of these columns" in advice
    assert "so the fit is meaningless" in result.summary(width=None).splitlines()[1]
    assert advice == result.summary(width=None).splitlines()[2]
    # Only the advice has values, those of the fit to forces in N.
    assert "+-" not in result.summary(width=None).replace(result.verdict, "").replace(advice, "")


@pytest.mark.long
def test_times_with_a_wrong_factor_are_recognised():
    result = fitted(time=10.0, free=LOOSE)
    assert "with all times divided by 10, chi2 falls from" in result.advice[0]
    assert "so the fit is meaningless" in result.summary(width=None).splitlines()[1]
    (advice,) = result.advice
    action, _, _ = advice.partition(". The values are then\n")
    assert action.endswith("interval; traces.with_scaled_times(0.1) corrects them")
    assert on_command_line(action).endswith("interval; multiply them by 0.1 in the file")
    corrected = result.traces.with_scaled_times(0.1)
    np.testing.assert_allclose(corrected.shots[0].times, recorded()[0], rtol=1e-15)
    # The values of the fit to the corrected times are stated.
    truth = {"stiffness": FACTOR, "struck_by.velocity": VELOCITY, "loss.time": 1e6 * LOSS_TIME}
    for name, value in truth.items():
        stated = re.search(rf"{re.escape(name)} = ([\d.]+) \+- ([\d.]+)", advice)
        assert abs(float(stated[1]) - value) < 4.0 * float(stated[2]) < 0.01 * value


@pytest.mark.parametrize("factor", [0.1, 0.5, 2.0, 2.5, 10.0])
def test_the_factor_of_times_follows_from_durations_and_arrivals(factor):
    data = traces().shots[0]
    columns = [signal.values - signal.values[0] for signal in data.signals]
    slower = hc.Traces.from_arrays(factor * data.times, recorded()[1])
    assert time_factor(slower.shots[0], columns, data.times) == pytest.approx(factor)
    assert time_factor(data, columns, data.times) is None
    exchanged = [columns[1], columns[0], columns[2]]
    assert time_factor(slower.shots[0], exchanged, data.times) is None


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_times_in_another_unit_raise_an_error(factor):
    with pytest.raises(hc.InputError, match="unit of the"):
        fitted(time=factor)


def test_a_modulus_of_the_right_order_is_possible():
    assert not fitted().meaningless


def saved(folder, columns):
    (folder / "chain.toml").write_text(hc.chain_as_toml(chain()))
    times = SPACING * np.arange(len(next(iter(columns.values()))))
    data = np.column_stack([1e6 * times, *columns.values()])
    header = ",".join(["time [us]", *columns])
    np.savetxt(folder / "data.csv", data, delimiter=",", header=header, comments="")
    return [str(folder / "data.csv"), str(folder / "chain.toml")]


@pytest.mark.long
def test_the_command_exits_with_3_for_wrong_units(tmp_path, run):
    columns = {name: 1e-3 * values for name, values in recorded()[1].items()}
    names = [option for name in LOOSE for option in ("--free", name)]
    found = run("fit", *saved(tmp_path, columns), *names)
    assert found.returncode == 3
    assert "multiplied by 1000" in found.stdout


@pytest.mark.long
@pytest.mark.parametrize("slow", [0.0, 0.8])
def test_values_from_noise_are_not_printed(slow):
    rng, count = np.random.default_rng(4), 900
    noise = rng.standard_normal((3, count))
    for k in range(1, count):
        noise[:, k] += slow * noise[:, k - 1]
    columns = dict(zip(recorded()[1], 0.1 * noise, strict=True))
    result = hc.fit(
        hc.Traces.from_arrays(SPACING * np.arange(count), columns), chain(), free=LOOSE, starts=1
    )
    assert "so they contain no pulse" in result.verdict
    assert "+-" not in result.summary(width=None).replace(result.verdict, "")
    assert all("no pulse above their noise" in each for each in result.warnings)


@pytest.mark.long
def test_two_errors_of_one_sensor_are_named():
    name = "ball 10 [N]"
    data = traces(change=lambda c: c | {name: 1.05 * c[name] + 0.5})
    result = hc.fit(data, chain(), free=LOOSE, starts=1)
    assert not result.describes
    (advice,) = [each for each in result.advice if each.startswith("with ")]
    assert "offset[ball 10]" in advice
    assert "gain[ball 10]" in advice
    assert "and the model describes the data" in advice
    assert not any(each.startswith("none of the effects") for each in result.advice)


def slow_noise(rng, count, rho, sigma):
    steps = sigma * (1.0 - rho**2) ** 0.5 * rng.standard_normal(count)
    found = np.zeros(count)
    for k in range(1, count):
        found[k] = rho * found[k - 1] + steps[k]
    return found


def test_a_gain_that_slow_noise_hides_is_named():
    """The noise of ball 10 is so uncertain that its chi-squared does not exclude the model."""
    name, rng = "ball 10 [N]", np.random.default_rng(0)
    noise = slow_noise(rng, len(recorded()[0]), 0.8, 0.3)
    data = traces(change=lambda c: c | {name: 1.05 * c[name] + 0.2 + noise})
    priors = {"struck_by.velocity": (0.25, 0.0025)}
    result = hc.fit(data, chain(), free=[*LOOSE, "offset[*]"], priors=priors)
    assert result.describes
    assert any("with gain[ball 10] = 1.0" in each for each in result.warnings)
    assert "That of ball 10 is clearly larger" in result.summary(width=None)


@pytest.mark.parametrize(("independent", "found"), [(100.0, ["b"]), (10.0, [])])
def test_a_chi_squared_is_clearly_larger_beyond_three_standard_deviations(independent, found):
    """The logarithm of chi-squared of n samples has the standard deviation sqrt(2/n)."""
    ratios = {"a": 1.0, "b": 1.9, "c": 1.0}
    assert clearly_larger(ratios, dict.fromkeys(ratios, independent)) == found


@pytest.mark.long
def test_the_fit_with_the_best_law_is_printed_first(tmp_path, run):
    elastic = chain(loss=None)
    files = saved(tmp_path, recorded()[1])
    (tmp_path / "chain.toml").write_text(hc.chain_as_toml(elastic))
    names = [option for name in LOOSE if name != "loss.time" for option in ("--free", name)]
    options = ["fit", *files, *names, "--laws", "viscoelastic,elastic"]
    found = run(*options)
    assert any(line.startswith("  loss.time") for line in found.stdout.splitlines()[1:5])
    assert "because the data reject the law of the chain file, elastic" in found.stdout
    assert found.returncode == 0
    document = json.loads(run(*options, "--json").stdout)
    assert document["fit_with_best_law"]["describes"]


@pytest.mark.parametrize(("laws", "loss", "compared"), [
    ("restitution", hc.Viscoelastic(1e-6), ["restitution", "viscoelastic"]),
    ("dashpot,viscoelastic", hc.Viscoelastic(1e-6), ["dashpot", "viscoelastic"]),
    ("dashpot", None, ["dashpot", "elastic"]),
    ("dashpot", [hc.Viscoelastic(1e-6 * k) for k in range(1, BALLS + 1)], ["dashpot"]),
])  # fmt: skip
def test_the_law_of_the_chain_file_is_added_to_those_named(laws, loss, compared, monkeypatch):
    class Stopped(Exception):
        """Ends the command before fits, with the names of the laws."""

    def compare(*_, laws, **__):
        raise Stopped([each if isinstance(each, str) else each.name for each in laws])

    monkeypatch.setattr(hc, "compare_losses", compare)
    result = SimpleNamespace(traces=None, chain=chain(loss=loss))
    with pytest.raises(Stopped) as caught:
        _laws(result, {}, laws, "chain.toml", {})
    assert caught.value.args[0] == compared


@pytest.mark.long
def test_the_law_of_the_chain_file_is_compared_with_those_named(tmp_path, run):
    """Both laws describe the noisy data; that of the chain file is kept."""
    names = ["--free", "stiffness", "--free", "loss.time", "--free", "time_offset"]
    files = saved(tmp_path, {"wall [N]": recorded(noise=20.0)[1]["wall [N]"]})
    found = run("fit", *files, *names, "--starts", 1, "--laws", "restitution")
    assert found.returncode == 0
    assert any(line.startswith("  loss.time") for line in found.stdout.splitlines()[1:4])
    assert "viscoelastic, the law of the chain file, is compared, too" in found.stdout
    assert "reject" not in found.stdout


@pytest.mark.long
@pytest.mark.parametrize(("wall", "fastest"), [("steel-52100", 0.5), ("steel-304", 0.0)])
def test_suggested_shots_are_within_the_limits_of_hertz_law(wall, fastest):
    """Balls are below first yield at 0.25 m/s, but not at 1 m/s or on a soft wall."""
    row = chain(right_wall=hc.Wall.of(wall))
    laws = ["viscoelastic", "restitution"]
    found = hc.compare_losses(traces(noise=6.0), row, laws=laws, free=LOOSE)
    assert len(found.undecided) == 2
    assert max(found.further_shots, default=0.0) <= 1.05 * fastest
    for speed in found.further_shots:
        faster = row.replace(velocities=row.velocities * speed / row.velocities.max())
        with warnings.catch_warnings():
            warnings.simplefilter("error", hc.ModelRangeWarning)
            hc.simulate(faster, until=7e-4)

"""Warnings and advice of fits to traces that SciPy computed."""

import itertools
import re
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from scipy_row import BALLS, FREE, TRUTH, VELOCITY, chain, recorded, traces

import hertzchain as hc
from hertzchain.cli import cli
from hertzchain.fitting.shown_values import shown_with_error
from hertzchain.fitting.weak_directions import WeakDirection
from hertzchain.plotting.fits import residual_bins
from hertzchain.representation import with_error
from hertzchain.traces.noise import saturated


@pytest.fixture(scope="module")
def good():
    return hc.fit(traces(), chain(), free=FREE)


def test_traces_of_scipy_are_recovered(good):
    assert good.describes
    deviations = [(good.values[name] - true) / good.errors[name] for name, true in TRUTH.items()]
    assert np.abs(deviations).max() < 3.5


def test_a_fitted_wall_keeps_the_yield_strength_of_its_material(good):
    # Johnson, Eq. (4.24): the pressure is proportional to the third root of the force k d^(3/2),
    # and d is proportional to (v^2/k)^(2/5).
    start = hc.hertz_range(chain()).yield_ratio[-1]
    change = (0.25 / 0.26) ** 0.4 * 0.97 ** (2 / 15)
    assert hc.hertz_range(good.chain).yield_ratio[-1] == pytest.approx(change * start, rel=2e-3)
    # Annealed steel yields long before the balls do.
    assert start > 5.0
    assert good.chain.right_wall.material.name == "steel-304"
    assert "pressure / yield" in good.summary(width=None)
    with pytest.warns(hc.ModelRangeWarning, match="right wall"):
        hc.simulate(good.chain)


def test_a_wall_with_stiffness_and_material_is_kept_by_chain_files(good, tmp_path):
    (tmp_path / "fitted.toml").write_text(good.chain_toml())
    wall = hc.load_chain(tmp_path / "fitted.toml").right_wall
    # Files of fits have seven digits.
    assert wall.stiffness == pytest.approx(good.chain.right_wall.stiffness, rel=5e-7)
    assert wall.material.yield_strength == hc.material("steel-304").yield_strength
    assert repr(wall).startswith("Wall(steel-304, stiffness = ")


def clipped(columns, limit, step=0.0):
    """Columns of which that of the wall is rounded and clipped by a digitiser."""
    wall = columns["wall [N]"]
    rounded = step * np.round(wall / step) if step else wall
    return columns | {"wall [N]": np.minimum(rounded, limit)}


@pytest.mark.long
@pytest.mark.parametrize("step", [0.0, 0.0122, 0.05, 0.25])
@pytest.mark.parametrize("limit", [30, 38, 40, 43, 44, 45, 46, 47, 48, 49, 50, 51])
def test_every_clipped_crest_is_recognised(limit, step):
    # The largest force is 52.67 N.
    level = step * round(limit / step) if step else float(limit)
    for seed in range(10):
        times, columns = recorded(seed)
        wall = clipped(columns, level, step)["wall [N]"]
        signal = hc.Traces.from_arrays(times, {"wall [N]": wall}).shots[0].signals[0]
        assert not signal.valid[wall == level].any()
        # Nothing else but two neighbours is omitted, apart from dips of the noise.
        assert np.count_nonzero(~signal.valid) <= np.count_nonzero(wall == level) + 8


@pytest.mark.parametrize("noise", [0.05, 0.2])
@pytest.mark.parametrize("step", [0.05, 0.5, 1.0])
def test_rounded_crests_are_not_regarded_as_clipped(step, noise):
    found = 0
    for seed in range(40):
        _, columns = recorded(seed, noise=noise)
        for values in columns.values():
            found += bool(saturated(step * np.round(values / step)).any())
            found += bool(saturated(values).any())
    # Of 240 signals.
    assert found <= 2


def test_traces_are_rejected_if_most_of_a_pulse_is_clipped():
    times, columns = recorded()
    wall = columns["wall [N]"]
    # Later pulses of the wall are smaller.
    peak = int(np.argmax(wall))
    ends = np.flatnonzero(wall < 0.05 * 13.0)
    duration = ends[ends > peak][0] - ends[ends < peak][-1] - 1
    above = np.count_nonzero(wall > 13.0)
    with pytest.raises(hc.InputError, match="saturated at 13 N during most of its pulse") as caught:
        hc.Traces.from_arrays(times, clipped(columns, 13.0))
    counts = [int(each) for each in re.findall(r"\((\d+) of (\d+) samples\)", str(caught.value))[0]]
    assert counts == pytest.approx([above, duration], rel=0.15)
    assert above > 0.5 * duration


def test_a_record_that_ends_before_the_pulse_is_not_regarded_as_clipped():
    rng, step = np.random.default_rng(2), 0.5
    times, columns = recorded()
    # The noise of the wall reaches one step of the digitiser in some samples.
    columns = {name: values[:330] for name, values in columns.items()}
    size = len(columns["wall [N]"])
    columns["wall [N]"] = step * rng.choice([-1.0, 0.0, 1.0], size, p=[0.05, 0.9, 0.05])
    data = hc.Traces.from_arrays(times[:330], columns)
    assert not any("saturated" in note for note in data.notes())
    result = hc.fit(data, chain(), free=["time_offset"], starts=1, diagnose=False)
    assert ". No single sample of wall clearly exceeds its noise" in result.verdict


def test_a_dead_channel_is_named_and_not_its_gain():
    times, columns = recorded()
    rng = np.random.default_rng(3)
    dead = columns | {"wall [N]": 0.1 * rng.standard_normal(len(times))}
    data = hc.Traces.from_arrays(times, dead)
    (advice, *_) = hc.fit(data, chain(), free=["time_offset"], starts=1, diagnose=False).advice
    assert advice.startswith("with the column of wall removed, chi2 falls from ")
    assert ": this sensor shows no pulse above the noise, so check cables" in advice


def test_the_gain_of_a_sensor_without_a_pulse_is_not_determined(tmp_path):
    times, columns = recorded()
    # The record ends before the pulse arrives at the wall.
    columns = {name: values[:330] for name, values in columns.items()}
    data = hc.Traces.from_arrays(times[:330], columns)
    free = ["time_offset", "stiffness", "gain[ball 5]", "gain[wall]"]
    result = hc.fit(data, chain(), free=free, diagnose=False)
    assert result.undetermined == ("gain[wall]",)
    assert dict(result.rows())["gain[wall]"] == "not determined"
    assert "wall have no pulse above their noise, so gain[wall] is not determined" in result.verdict
    assert "bound" not in result.summary(width=None)
    # A gain with a prior is known without a pulse, and a pulse determines a gain.
    known = hc.fit(data, chain(), free=["time_offset", "gain[wall]"],
                   priors={"gain[wall]": (1.0, 0.1)}, diagnose=False)  # fmt: skip
    assert known.undetermined == ()
    file, chain_file = tmp_path / "data.csv", tmp_path / "chain.toml"
    table = np.column_stack((1e6 * times[:330], *columns.values()))
    np.savetxt(file, table, "%.6f", ",", header=f"time [us],{','.join(columns)}", comments="")
    chain_file.write_text(hc.chain_as_toml(chain()))
    names = itertools.chain(*(("--free", name) for name in FREE))
    command = ["fit", str(file), str(chain_file), "--no-diagnosis", *names]
    for more, code in (([], 0), (["--free", "gain[wall]"], 3)):
        assert cli.main([*command, *more], standalone_mode=False) == code


@pytest.mark.parametrize("limit", [30.0, 45.0])
def test_a_fit_without_clipped_samples_recovers_the_truth(limit):
    result = hc.fit(traces(change=lambda columns: clipped(columns, limit)), chain(), free=FREE)
    assert result.describes
    assert "samples of wall in shot 1 are saturated" in result.summary(width=None)
    deviations = [(result.values[name] - TRUTH[name]) / result.errors[name] for name in FREE]
    assert np.abs(deviations).max() < 3.5


@pytest.mark.parametrize(
    ("start", "words"),
    [
        ({"stiffness": -1.0}, "the start of stiffness must be from 0.001 to 1000, got -1"),
        ({"loss.time": -1e-6}, "the start of loss.time must be at least 0, got -1e-06"),
        ({"struck_by.velocity": 0.0}, "the start of struck_by.velocity must be above 0, got 0"),
        ({"time_offset": np.inf}, "start of time_offset must be finite"),
    ],
)
def test_starts_out_of_range_are_rejected(start, words):
    with pytest.raises(hc.InputError, match=re.escape(words)):
        hc.fit(traces(), chain(), free=FREE, start=start)


def test_a_file_without_samples_is_named(tmp_path):
    (tmp_path / "empty.csv").write_text("time [us],wall [N]\n")
    with pytest.raises(hc.InputError, match=r"empty\.csv: the file has a header but no samples"):
        hc.load_traces(tmp_path / "empty.csv")


def test_times_in_another_unit_are_suspected():
    times, columns = recorded()
    data = hc.Traces.from_arrays(1e3 * times, columns)
    with pytest.raises(hc.InputError, match="check that the times are in the unit of their header"):
        hc.fit(data, chain(), free=FREE)


@pytest.mark.long
def test_errors_of_a_model_that_does_not_describe_the_data_have_no_meaning(good):
    assert "The errors above have no meaning" not in good.summary(width=None)
    wrong = hc.fit(traces(gap=0.5e-6), chain(), free=FREE)
    assert not wrong.describes
    assert wrong.verdict.endswith("The errors above have no meaning")


@pytest.mark.long
def test_the_overlap_at_which_a_stiffness_is_defined_is_stated():
    free = ["stiffness", "exponent", "loss.time", "time_offset"]
    result = hc.fit(traces(exponent=1.45), chain().replace(velocities=[0.25] + [0.0] * BALLS),
                    free=free)  # fmt: skip
    (note,) = [each for each in result.notes if each.startswith("stiffness is the factor")]
    overlap = 1e-6 * float(re.findall(r"overlap of (\S+) um", note)[0])
    # The forces of the data were defined at an overlap of 2 um, as those of Hertz times 0.97.
    expected = TRUTH["stiffness"] * (overlap / 2e-6) ** (1.45 - 1.5)
    assert result.describes
    assert abs(result.values["stiffness"] - expected) < 4.0 * result.errors["stiffness"] < 0.01


@pytest.mark.long
def test_a_wall_that_does_not_follow_the_exponent_is_stated(good):
    own = chain(right_wall=hc.Wall(2e10, exponent=1.5))
    free = ["exponent", "time_offset"]
    result = hc.fit(traces(), own, free=free, starts=1)
    note = "right wall has its own exponent, which does not follow that of the beads"
    assert note in result.notes
    assert note not in good.notes


def test_offsets_have_the_unit_of_their_sensor():
    result = hc.fit(traces(), chain(), free=[*FREE, "offset[wall]"])
    assert dict(result.rows())["offset[wall]"].endswith(" N")


@pytest.mark.parametrize(
    ("weights", "exact", "priors", "text"),
    [
        ({"stiffness": -0.5, "struck_by.velocity": 1.0, "gain[a]": -1.0, "gain[b]": -1.0}, True, (),
         "the data determine only combinations of stiffness, struck_by.velocity and the gains: "
         "signals stay the same if the relative changes of these are in the ratio 0.5 : -1 : 1; "
         "fix one of them, or give it a prior"),
        ({"lag": 1.0, "time_offset": -0.4}, False, ("lag",),
         "the data hardly determine lag and time_offset separately: signals hardly "
         "change if the changes of these are in the ratio 1 : -0.4; only the prior of lag fixes "
         "them"),
        ({"stiffness": 0.02, "time_offset": 1.0}, False, (),
         "the data hardly determine stiffness and time_offset separately: signals hardly change if "
         "the relative changes of these, and the changes of time_offset in us, are in the ratio "
         "0.02 : 1; fix one of them, or give it a prior"),
        ({"gain[a]": 1.0, "gain[b]": 0.5}, True, ("gain[a]", "gain[b]"),
         "the data determine only a combination of the gains: signals stay the same if the "
         "relative changes of these are in the ratio 1 : 0.5; only the priors of the gains fix "
         "them"),
    ],
)  # fmt: skip
def test_weak_directions_state_what_is_determined(weights, exact, priors, text):
    assert str(WeakDirection(weights, 1.0, exact, priors)) == text


def test_one_parameter_on_which_the_data_do_not_depend():
    direction = WeakDirection({"highpass": 1.0}, np.inf, True, ())
    assert str(direction).endswith("do not depend on highpass: fix it, or give it a prior")


def test_files_in_the_wrong_order_are_named(run, tmp_path):
    (tmp_path / "base.toml").write_text("[chain]\ntaper = 'uniform'\nbeads = 9\n")
    (tmp_path / "m.csv").write_text("time [us],wall [N]\n0,0\n1,2\n")
    code, _, err = run("fit", tmp_path / "base.toml", tmp_path / "m.csv")
    assert code == 2
    assert "base.toml is a chain file" in err
    assert "the traces first and the chain file last" in err
    assert "hertzchain compare" not in err


def written(path, **options):
    """A CSV file of traces that SciPy computed, and the chain file of the nominal chain."""
    times, columns = recorded(**options)
    header = ",".join(["time [us]", *columns])
    rows = np.column_stack([1e6 * times, *columns.values()])
    np.savetxt(path / "data.csv", rows, delimiter=",", header=header, comments="", fmt="%.6g")
    (path / "row.toml").write_text(hc.chain_as_toml(chain()))
    return path / "data.csv", path / "row.toml"


@pytest.mark.long
def test_the_exit_code_is_that_of_the_fit_with_a_gap(run, tmp_path):
    files = written(tmp_path, gap=0.4e-6)
    free = [part for name in FREE for part in ("--free", name)]
    code, out, err = run("fit", *files, *free, "--starts", 1, "--defects",
                         "--out", tmp_path / "fitted.toml")  # fmt: skip
    assert code == 0, err
    _, first, scan, balls, without = out.strip().split("\n\n")
    value, error = map(float, re.findall(r"gap\[8-9\] +(\S+) \+- (\S+) um", first)[0])
    assert abs(value - 0.4) < 3.0 * error < 0.02
    assert ": the model describes the data" in first
    assert re.match(r"scan for a gap at each of 1\d contacts, gap\[0-1\] to ", scan)
    assert re.search(r"\n  gap\[8-9\] +\d+ +0\.\d+ um\n", scan)
    assert "the fit above has" not in out  # because the scan has the same best place
    assert scan.endswith("gap[8-9] explains more than noise would (a chi2 lower by 20)")
    # The kind of defect that does not describe the data has one line.
    assert re.fullmatch(r"rejected: the best fit with another radius instead, radius\[\d+\], has "
                        r"chi2 \d+, and that with gap\[8-9\] only \d+", balls)  # fmt: skip
    assert without.startswith("without gap[8-9]: chi2 ")
    assert ", far more than expected: the model does not describe the data" in without
    assert hc.load_chain(tmp_path / "fitted.toml").gaps[8] == pytest.approx(1e-6 * value, rel=1e-3)


@pytest.mark.long
def test_the_output_says_why_a_defect_is_not_the_best_one_of_the_scan(run, tmp_path):
    """In the scan, chi-squared falls more with a gap next to the true one, at contact 8-9."""
    row = hc.Chain.from_materials(5e-3, "steel-52100", beads=15).struck_by(velocity=0.2)
    row, gaps = row.replace(right_wall=hc.Wall()), np.zeros(15)
    gaps[8] = 0.4e-6
    times, rng = 1e-6 * np.arange(450), np.random.default_rng(5)
    seen = hc.simulate(row.replace(gaps=gaps), times=times)
    names = ("ball 5", "ball 12", "wall")
    forces = np.column_stack([seen.sensor(name) for name in names])
    forces = np.vstack((np.zeros((40, 3)), forces[:-40])) + 0.1 * rng.standard_normal((450, 3))
    header = "time [us]," + ",".join(f"{name} [N]" for name in names)
    np.savetxt(tmp_path / "data.csv", np.column_stack((1e6 * times, forces)), delimiter=",",
               header=header, comments="")  # fmt: skip
    (tmp_path / "row.toml").write_text(hc.chain_as_toml(row))
    code, out, err = run("fit", tmp_path / "data.csv", tmp_path / "row.toml", "--free", "stiffness",
                         "--free", "time_offset", "--starts", 1, "--defects")  # fmt: skip
    assert code == 0, err
    _, first, scan, why, *_ = out.split("\n\n")
    assert "  gap[8-9] " in first
    assert re.search(r"size\n  gap\[9-10\] ", scan)
    chi2 = float(re.findall(r"^chi2 (\S+) for", first, re.M)[0])
    assert why.startswith(
        "the fit above has gap[8-9], because fits with one defect at each of the "
    )
    assert f"have the smallest chi2 with it, {chi2:.0f}; " in why


@pytest.mark.long
@pytest.mark.parametrize("defects", [False, True])
def test_defects_that_were_searched_are_not_advised(defects, tmp_path, monkeypatch):
    nothing = SimpleNamespace(
        names=(), sizes=(), improvements=(), found=False, summary=lambda **_: "no defect"
    )
    monkeypatch.setattr(hc, "scan_defects", lambda *_, **__: nothing, raising=False)
    files = map(str, written(tmp_path, gap=0.4e-6))
    free = [part for name in FREE for part in ("--free", name)]
    options = [*free, "--starts", "1", *(["--defects"] if defects else [])]
    done = CliRunner().invoke(cli, ["fit", *files, *options], standalone_mode=False)
    assert done.return_value == 3, done.output
    assert ("no defect" in done.output) == defects
    words = "Consider gaps, odd balls and a ball of another material (--defects), other"
    assert (words in done.output) != defects
    assert ("Consider other loss laws (--laws all), " in done.output) == defects


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
def test_an_odd_ball_is_found_and_parameters_are_added(run, tmp_path):
    row = chain(loss=hc.Viscoelastic(0.6e-6))
    radii = row.radii.copy()
    radii[8] *= 1.03
    odd = hc.Chain.from_materials(radii[1:], "steel-52100").struck_by(velocity=0.26)
    odd = odd.replace(right_wall=row.right_wall, loss=row.loss)
    times = 0.7e-6 * np.arange(900)
    seen = hc.simulate(odd, times=times)
    rng, before = np.random.default_rng(4), 80
    signals = {"ball 5": seen.sensor("ball 5"), "ball 12": seen.sensor("ball 12")}
    signals["wall"] = seen.forces[:, -1]
    columns = [0.7 * np.arange(before + 900)]
    for values in signals.values():
        noise = 0.05 * rng.standard_normal(before + 900)
        columns.append(np.concatenate((np.zeros(before), values)) + noise)
    header = ",".join(["time [us]", *(f"{name} [N]" for name in signals)])
    np.savetxt(tmp_path / "data.csv", np.column_stack(columns), delimiter=",", header=header,
               comments="", fmt="%.6g")  # fmt: skip
    (tmp_path / "row.toml").write_text(hc.chain_as_toml(row))
    files = (tmp_path / "data.csv", tmp_path / "row.toml")
    free = ("--free", "stiffness", "--free", "time_offset", "--also-free", "struck_by.velocity")
    code, out, err = run("fit", *files, *free, "--starts", 1, "--defects")
    assert code == 0, err
    # The fit without the ball is printed before the search.
    without, _, out = out.partition("\n\n")
    assert without.startswith("3 parameters ")
    names = [line.split()[0] for line in out.splitlines()[1:5]]
    assert names == ["stiffness", "time_offset", "struck_by.velocity", "radius[8]"]
    value, error, unit = re.findall(r"radius\[8\] +(\S+) \+- (\S+) (\w+)", out)[0]
    unit_in_m = {"m": 1.0, "mm": 1e-3, "um": 1e-6}[unit]
    assert abs(unit_in_m * float(value) - 5.15e-3) < 4.0 * unit_in_m * float(error) < 1e-4
    shown = re.findall(r": diameter (\S+) \+- (\S+) mm, \+(\S+) \+- \S+% from 10 mm", out)[0]
    diameter, of_diameter, percent = map(float, shown)
    assert abs(diameter - 10.3) < 4.0 * of_diameter < 0.2
    assert percent == pytest.approx(10.0 * (diameter - 10.0), abs=0.1)
    parts = out.split("\n\n")
    assert parts[1].startswith("scan for another radius of each of 15 beads, radius[1] to ")
    assert re.match(r"(rejected|not excluded): the best fit with a gap instead, gap\[", parts[2])


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (0.6231, 0.002, "0.6231 +- 0.0020"), (171.5, 3.0, "171.5 +- 3.0"),
        (1.0, 0.01, "1.000 +- 0.010"), (-1e-9, 0.1, "0.00 +- 0.10"), (3.0, 0.0999, "3.00 +- 0.10"),
        (1234.5, 130.0, "1230 +- 130"), (1.2004e9, 1.3e6, "(1.2004 +- 0.0013)e+09"),
        (0.03, 0.5, "0.03 +- 0.50"), (1.2346e-6, 3.2e-8, "(1.235 +- 0.032)e-06"),
        (1.0, 1e-15, "1 +- 1e-15"), (1.5, np.inf, "1.5"), (1.5, 0.0, "1.5"),
    ],
)  # fmt: skip
def test_value_and_error_have_the_same_decimals(value, error, text):
    assert with_error(value, error) == text


def test_errors_of_stiffness_have_usual_units():
    for value, unit, text in (
        (5e7, "N/m", "50.0 +- 1.0 kN/mm"), (5e3, "N/m", "5.00 +- 0.10 N/mm"),
        (5e10, "N/m^1.5", "50.0 +- 1.0 N/um^1.5"), (5e3, "N/m^2", "5000 +- 100 N/m^2"),
    ):  # fmt: skip
        assert shown_with_error(value, 0.02 * value, unit) == text


def test_unknown_parameters_are_listed_with_the_sensors_of_the_data():
    data = traces()
    with pytest.raises(hc.InputError) as error:
        hc.fit(data, chain(), free=["stifness"])
    assert f"gain[{data.names[0]}]" in str(error.value)
    assert "gain[ball 6]" not in str(error.value)


@pytest.mark.long
def test_relative_changes_of_a_gap_are_relative_to_its_value():
    """Signals with v^-2, k, gap^-2 and gain^2 are the same: one dimension is not determined."""
    volts = {f"{each.name} [V]": 0.05 * each.values for _, each in traces(gap=0.3e-6)}
    data = hc.Traces.from_arrays(traces(gap=0.3e-6).shots[0].times, volts)
    priors = {"struck_by.velocity": (VELOCITY, 0.01 * VELOCITY)}
    result = hc.fit(data, chain(), free=[*FREE, "gap[8-9]", "gain[*]"], priors=priors)
    (weak,) = result.weak
    assert "ratio 0.5 : -1 : -1 : 1;" in str(weak)


@pytest.mark.long
def test_other_loss_laws_are_mentioned_only_if_a_loss_is_fitted(good, run):
    assert good.summary(width=None).endswith(good._loss_note)
    assert "others may describe the data equally well: compare_losses compares" in good._loss_note
    _, chain_file = hc.example_experiment()
    names = [name for name in good.names if "loss" not in name]
    assert hc.fit(good.traces, good.chain, free=names)._loss_note == ""
    options = ["fit", str(chain_file.parent / "fast.csv"), str(chain_file)]
    assert "--laws all compares them" in run(*options).stdout
    compared = run(*options, "--laws", "viscoelastic,elastic").stdout
    assert "delta BIC" in compared
    assert "only one loss law" not in compared


@pytest.mark.parametrize("step", [0.04, 0.3, 0.4, 2.0])
def test_bins_of_residuals_contain_equally_many_steps_of_the_digitiser(step):
    edges = residual_bins(step)
    assert edges[0] <= -5.0
    assert edges[-1] >= 5.0
    levels = step * np.arange(-400, 401)
    counts, _ = np.histogram(levels, edges)
    assert counts.min() == counts.max() >= 1

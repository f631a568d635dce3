"""Known time offsets: given, or those of a drive in the same file as the traces."""

import json
import re
import warnings

import numpy as np
import pytest

import hertzchain as hc

BEGIN = -50.0
TIMES = np.arange(-110.0, 350.0, 2.0)
GAIN = 0.01
CHAIN = """
[chain]
diameters = "10 mm"
beads = 8
materials = "steel-52100"
right_wall = {{material = "steel-52100"}}

[chain.drive]
kind = "table"
file = "{file}"
column = "CH1"
gain = "20 mV/N"
{drive}

[fit]
free = {free}
"""
SENSORS = {"CH2": "wall"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A hammer and a wall in one file, and the wall alone in another."""
    path = tmp_path_factory.mktemp("clock")
    pulse = np.linspace(0.0, 60.0, 31)
    force = 40.0 * np.sin(np.pi * pulse / 60.0)
    force[-1] = 0.0
    row = hc.Chain.from_materials("5 mm", "steel-52100", beads=8, right_wall=hc.Wall())
    driven = row.replace(drive=hc.TableDrive(1e-6 * pulse, force), velocities=None)
    run = hc.simulate(driven, until=450e-6, times=2001)
    wall = np.interp(TIMES - BEGIN, 1e6 * run.times, run.wall_force().force, left=0.0)
    hammer = np.interp(TIMES - BEGIN, pulse, force, left=0.0, right=0.0)
    noise = np.random.default_rng(3).normal(scale=(1e-4, 1e-3), size=(len(TIMES), 2))
    columns = np.column_stack((TIMES, 0.02 * hammer + noise[:, 0], GAIN * wall + noise[:, 1]))
    both = {"delimiter": ",", "comments": "", "fmt": "%.6g"}
    np.savetxt(path / "scope.csv", columns, header="Time (us),CH1 (V),CH2 (V)", **both)
    np.savetxt(path / "other.csv", columns[:, [0, 2]], header="Time (us),CH2 (V)", **both)
    return path


def chain_file(folder, *, start=BEGIN, free='["stiffness", "gain[wall]"]', fit="", name="a.toml"):
    begin = "" if start is None else f'start = "{start} us"\n'
    text = CHAIN.format(file="scope.csv", free=free, drive=f'{begin}end = "{BEGIN + 60} us"')
    (folder / name).write_text(text + fit)
    return folder / name


def data(folder, name="scope.csv"):
    return hc.load_traces(folder / name, sensors=SENSORS)


def test_the_start_of_a_drive_is_the_time_offset_of_traces_in_its_file(folder):
    result = hc.fit(data(folder), chain_file(folder))
    assert result.describes
    assert result.values["stiffness"] == pytest.approx(1.0, abs=5.0 * result.errors["stiffness"])
    assert (
        "time_offset is fixed at -50 us, the start of the drive in the same file; add "
        "'time_offset' to the free parameters (also_free) to fit it"
    ) in result.summary(width=None)


def test_the_start_of_a_drive_is_not_the_time_offset_of_other_files(folder):
    file = chain_file(folder, free='["stiffness", "gain[wall]", "time_offset"]')
    result = hc.fit(data(folder, "other.csv"), file)
    assert result.values["time_offset"] == pytest.approx(1e-6 * BEGIN, abs=1e-6)
    assert "is fixed" not in result.summary(width=None)


def test_a_time_offset_is_free_by_default_unless_it_is_known(folder):
    text = chain_file(folder).read_text().partition("[fit]")[0]
    (folder / "default.toml").write_text(text)
    assert "time_offset" not in hc.fit(data(folder), folder / "default.toml").names
    assert "time_offset" in hc.fit(data(folder, "other.csv"), folder / "default.toml").names


def test_the_user_can_free_the_time_offset_of_a_drive(folder):
    file = chain_file(folder, free='["stiffness", "gain[wall]", "time_offset"]')
    result = hc.fit(data(folder), file)
    own = result.values["time_offset"], result.errors["time_offset"]
    assert own[0] == pytest.approx(1e-6 * BEGIN, abs=5.0 * own[1])
    assert "is fixed" not in result.summary(width=None)


@pytest.mark.parametrize("how", ["argument", "start", "file", "start in the file"])
def test_a_known_time_offset_is_fixed(folder, how):
    fit = {"file": 'time_offset = "-50 us"', "start in the file": "start = {time_offset = -5e-5}"}
    keywords = {"argument": {"time_offset": "-50 us"}, "start": {"start": {"time_offset": -5e-5}}}
    file = chain_file(folder, fit=fit.get(how, ""))
    result = hc.fit(data(folder, "other.csv"), file, **keywords.get(how, {}))
    assert result.describes
    assert "time_offset" not in result.names
    assert "time_offset is fixed at -50 us, as given" in result.summary(width=None)


def test_a_free_time_offset_starts_from_the_known_one(folder):
    from hertzchain.fitting.clocks import with_clocks
    from hertzchain.fitting.settings import load_experiment

    file = chain_file(folder, free='["stiffness", "gain[wall]", "time_offset"]')
    traces, _, settings = load_experiment(data(folder), file, hc.load_traces)
    traces, settings = with_clocks(traces, settings)
    assert settings.start == {"time_offset": pytest.approx(1e-6 * BEGIN)}
    assert traces.shots[0].clock is None


def test_each_shot_can_have_its_time_offset(folder):
    traces = data(folder, "other.csv")
    both = traces + traces
    file = chain_file(folder)
    result = hc.fit(both, file, time_offset=[-5e-5, "-50 us"])
    assert result.describes
    later = hc.fit(both, file, time_offset=[-5e-5, "-45 us"], starts=1)
    assert "time_offset of shot 2 is fixed at -45 us, as given" in later.summary(width=None)
    with pytest.raises(hc.InputError, match="time_offset has 3 values, but there are 2 shots"):
        hc.fit(both, file, time_offset=[0.0, 0.0, 0.0])


def test_a_wrong_time_offset_is_named_with_its_estimate(folder):
    for given in ("0 us", "-46 us"):
        result = hc.fit(data(folder), chain_file(folder), time_offset=given)
        assert not result.describes
        shown = given.removesuffix(" us")
        assert f"us instead of {'0 s' if shown == '0' else f'{shown} us'}" in result.advice[0]
        estimate = float(re.match(r"with time_offset = (\S+) ", result.advice[0])[1])
        assert estimate == pytest.approx(BEGIN, abs=0.3)
        assert "to the free parameters (also_free), or correct it" in result.advice[0]


def test_the_command_has_the_same_options(run, folder):
    words = ("fit", folder / "other.csv", chain_file(folder), "--sensor", "CH2=wall", "--json")
    known = json.loads(run(*words, "--time-offset", "-50us").stdout)
    started = json.loads(run(*words, "--start", "time_offset=-50us").stdout)
    assert known["parameters"] == started["parameters"]
    assert known["describes"]
    wrong = run(*words, "--start", "time_offset")
    assert wrong.returncode == 2
    assert "--start must look like time_offset=80us, got 'time_offset'" in wrong.stderr


def test_the_fitted_file_keeps_the_time_offset(folder):
    text = hc.fit(data(folder), chain_file(folder)).chain_toml()
    assert 'time_offset = "-50 us"' in text.splitlines()
    (folder / "fitted.toml").write_text(text)
    assert hc.fit(data(folder), folder / "fitted.toml").describes


def test_the_fitted_file_keeps_the_time_offsets_of_some_shots(folder):
    traces = data(folder, "other.csv")
    # That of shot 1 is free, and that of shot 2 is known.
    free = ["stiffness", "gain[wall]", "time_offset@1"]
    given = {"start": {"time_offset@2": "-50 us"}, "starts": 1}
    first = hc.fit(traces + traces, chain_file(folder), free=free, **given)
    text = first.chain_toml()
    assert '"time_offset@2" = "-50 us"' in text.split("[fit.start]")[1].splitlines()
    (folder / "some.toml").write_text(text)
    again = hc.fit(traces + traces, folder / "some.toml", starts=1)
    assert "time_offset of shot 2 is fixed at -50 us, as given" in again.summary(width=None)
    assert [*again.values] == free
    assert again.chi2 == pytest.approx(first.chi2, rel=1e-3)


@pytest.mark.parametrize(
    ("more", "shown"),
    [
        ((), "time offset -50 us, the start of the drive in the same file"),
        (("--time-offset", "-49us"), "time offset -49 us, given"),
        (("--time-offset", "free"), "us, by least squares"),
    ],
)
def test_compare_uses_the_time_offset_of_the_drive(run, folder, more, shown):
    done = run("compare", folder / "scope.csv", chain_file(folder), "--sensor", "CH2=wall", *more)
    assert done.returncode == 0, done.stderr
    assert shown in done.stdout.splitlines()[2]


def test_compare_does_not_fix_a_time_offset_that_a_fit_frees(run, folder):
    file = chain_file(folder, free='["stiffness", "gain[wall]", "time_offset"]')
    done = run("compare", folder / "scope.csv", file, "--sensor", "CH2=wall")
    assert "by least squares" in done.stdout


def test_scaled_times_scale_the_time_offset():
    shot = hc.Traces.from_arrays([0.0, 1.0, 2.0], {"wall [N]": [0.0, 5.0, 1.0]}, noise=0.1)
    from hertzchain.traces.traces import with_time_offset

    scaled = with_time_offset(shot, 0.5).with_scaled_times(1e-3)
    assert scaled.shots[0].time_offset == pytest.approx(5e-4)


def test_a_force_that_is_over_before_the_simulation_begins_is_rejected(folder):
    file = chain_file(folder, start=20.0)
    text = file.read_text().replace(f'end = "{BEGIN + 60} us"', 'baseline = "-60 us"')
    file.write_text(text)
    with pytest.raises(hc.InputError, match="the force is over before the simulation begins, at"):
        hc.load_chain(file)


def test_an_end_at_a_sample_is_that_sample(folder):
    drive = hc.load_drive(
        folder / "scope.csv", column="CH1", gain="20 mV/N", start="-50 us", end="10 us"
    )
    assert drive.times[-1] == pytest.approx(60e-6)
    assert drive.values[-1] == 0.0
    assert np.diff(drive.times).min() > 1e-6


def test_parameters_without_any_effect_cause_no_numerical_warning(folder):
    row = hc.Chain.from_materials("5 mm", "steel-52100", beads=8, right_wall=hc.Wall())
    still = row.replace(drive=hc.TableDrive([0.0, 1e-5], [0.0, 1e-30]), velocities=None)
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        result = hc.fit(data(folder), still)
    assert result.meaningless or not result.describes


def test_a_second_blow_after_the_end_of_a_drive_is_reported(tmp_path):
    (tmp_path / "twice.csv").write_text("time [us],force [N]\n0,0\n10,80\n20,0\n30,40\n40,0\n")
    with pytest.warns(hc.InputWarning, match="still reaches 50% of its largest value.*second blow"):
        hc.load_drive(tmp_path / "twice.csv", end="20 us")


def test_a_given_time_offset_replaces_the_start_of_the_file():
    from hertzchain.fitting.settings import Settings

    file = Settings(start={"time_offset": 9e-5, "stiffness": 1.1})
    assert file.updated(None, None, None, 5e-5).start == {"stiffness": 1.1}
    assert file.updated(None, None, {"time_offset": 6e-5}, 5e-5).start["time_offset"] == 6e-5
    assert file.updated(None, None, None).start == file.start


@pytest.mark.parametrize("name", ["time_offsets", "time_offset[ball 6]"])
def test_starts_of_unknown_time_offsets_are_rejected(folder, name):
    path = chain_file(folder, name="unknown.toml")
    traces = hc.load_traces(folder / "scope.csv", sensors=SENSORS)
    with pytest.raises(hc.InputError, match=re.escape(f"unknown free parameter '{name}'")):
        hc.fit(traces, path, start={name: 1e-6})

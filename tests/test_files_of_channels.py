"""Files of one oscilloscope whose columns have the same names: each file is one sensor."""

import json

import numpy as np
import pytest

import hertzchain as hc

HEAD = "Time (s),Volt (V)"
NAMES = ("ch1.csv", "ch2.csv", "ch3.csv", "ch4.csv")
PLACES = ("ball 2", "ball 3", "ball 4", "wall")
SENSORS = dict(zip(NAMES, PLACES, strict=True))
# Gains of the amplifiers [V/N].
GAINS = (0.02, 0.05, 0.01, 0.03)
NOISE = 1e-3


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Four files with one channel each, and the chain file."""
    folder = tmp_path_factory.mktemp("scope")
    row = hc.Chain.from_materials(5e-3, "steel-52100", beads=6).struck_by(velocity=0.1)
    row = row.replace(right_wall=hc.Wall())
    (folder / "row.toml").write_text(hc.chain_as_toml(row))
    run, rng = hc.simulate(row, until=150e-6, times=301), np.random.default_rng(4)
    forces = (run.sensor(3), run.sensor(4), run.sensor(5), run.forces[:, -1])
    for name, gain, force in zip(NAMES, GAINS, forces, strict=True):
        seen = np.concatenate((np.zeros(60), gain * force)) + NOISE * rng.standard_normal(361)
        write(folder / name, seen)
    return folder


def write(path, *signals, head=HEAD):
    path.parent.mkdir(exist_ok=True)
    rows = [
        ",".join((f"{0.5e-6 * i:.9f}", *(f"{each:.6f}" for each in row)))
        for i, row in enumerate(zip(*signals, strict=True))
    ]
    path.write_text("\n".join([head, *rows]) + "\n")


@pytest.fixture
def files(folder):
    return [folder / name for name in NAMES]


def test_each_file_is_the_sensor_that_is_named(files):
    found = hc.load_traces(*files, sensors=SENSORS, channels=True)
    apart = [
        hc.load_traces(file, sensors={"Volt": place})
        for file, place in zip(files, PLACES, strict=True)
    ]
    assert found.names == PLACES
    for signal, one in zip(found.shots[0].signals, apart, strict=True):
        np.testing.assert_array_equal(signal.values, one.shots[0].signals[0].values)
        assert signal.unit == "V"


def test_a_file_may_be_named_in_several_ways(files, tmp_path):
    wanted = hc.load_traces(*files[:2], sensors={"ch1.csv": "ball 2", "ch2.csv": "wall"},
                            channels=True)  # fmt: skip
    for first, second in (
        (str(files[0]), str(files[1])),
        ("ch1.csv:Volt", "ch2.csv: volt (V)"),
        (f"{files[0]}:Volt", "ch2.csv"),
    ):
        found = hc.load_traces(*files[:2], sensors={first: "ball 2", second: "wall [V]"},
                               channels=True)  # fmt: skip
        assert repr(found) == repr(wanted)
    # One file, whose name has an equals sign, and a header without units.
    other = tmp_path / "v=0.1_ch1.csv"
    other.write_text(files[0].read_text().replace(HEAD, "X,Y"))
    sensors = {"X": "time [s]", "v=0.1_ch1.csv": "ball 2 [V]"}
    assert hc.load_traces(other, sensors=sensors).names == ("ball 2",)


def test_files_in_different_folders_may_have_the_same_name(files, tmp_path):
    same = [tmp_path / folder / "scope.csv" for folder in ("left", "right")]
    for path, file in zip(same, files, strict=False):
        path.parent.mkdir()
        path.write_text(file.read_text())
    sensors = {str(same[0]): "ball 2", str(same[1]): "wall"}
    assert hc.load_traces(*same, sensors=sensors, channels=True).names == ("ball 2", "wall")
    with pytest.raises(
        hc.InputError, match=r"2 files are called 'scope.csv'; write the path, such"
    ):
        hc.load_traces(*same, sensors={"scope.csv": "wall"}, channels=True)
    with pytest.raises(hc.InputError, match=r"is in .*left.scope.csv and in .*right.scope.csv"):
        hc.load_traces(*same, sensors={"Volt": "wall"}, channels=True)


def test_a_file_with_several_columns_requires_their_names(files):
    values = np.loadtxt(files[0], delimiter=",", skiprows=1)[:, 1]
    other = files[0].parent / "both" / "two.csv"
    write(other, values, 2.0 * values, head="Time (s),Volt A (V),Volt B (V)")
    with pytest.raises(hc.InputError, match=r"two.csv: the file has 2 columns of samples, Volt A, "
                       "Volt B; name one, as in 'two.csv:Volt A'"):  # fmt: skip
        hc.load_traces(other, sensors={"two.csv": "wall"})
    sensors = {"two.csv:Volt A": "ball 5", "two.csv:Volt B": "wall", "ch1.csv": "ball 2"}
    found = hc.load_traces(other, files[0], sensors=sensors, channels=True)
    assert found.names == ("ball 5", "wall", "ball 2")
    first, second, third = (each.values for each in found.shots[0].signals)
    np.testing.assert_allclose(second, 2.0 * first, atol=2e-6)
    np.testing.assert_array_equal(first, third)


def test_files_whose_headers_have_places_may_be_selected(files, tmp_path):
    paths = [tmp_path / "a.csv", tmp_path / "b.csv"]
    for path, file, head in zip(paths, files, ("wall [N]", "ball 2 [N]"), strict=False):
        path.write_text(file.read_text().replace("Volt (V)", head))
    found = hc.load_traces(*paths, sensors=["b.csv", "a.csv:wall"], channels=True)
    assert found.names == ("wall", "ball 2")
    assert found.shots[0].signals[0].unit == "N"


def test_columns_in_the_files_come_before_names_of_files(files, tmp_path):
    """So a column keeps its name if a file is called like it."""
    file = tmp_path / "wall"
    file.write_text(files[0].read_text().replace("Volt (V)", "wall [V]"))
    assert hc.load_traces(file, sensors=["wall"]).names == ("wall",)


@pytest.mark.parametrize(
    ("sensors", "words"),
    [
        ({"ch1.csv": "wall"}, r"ch2.csv: no sensor of this file is given; leave out the file, or "
         r"give load_traces sensors=\{'ch2.csv': 'wall'\}"),
        ({"ch1.csv": "wall", "ch5.csv": "ball 2"},
         r"unknown file of a sensor 'ch5.csv' .*: choose from ch1.csv, ch2.csv"),
        ({"ch1.csv": "wall", "ch2.csv": "wall"},
         "wall is given for 'ch1.csv' and for 'ch2.csv'; give each sensor its own place"),
        ({"ch1.csv": "wall", "ch2.csv": "ball 2", "ch2.csv:Volt": "ball 3"},
         "ch2.csv: column 'Volt' is given twice, as 'ch2.csv' and as 'ch2.csv:Volt'; keep one"),
        ({"ch1.csv": "wall", "Volt": "ball 3"},
         "ch1.csv: column 'Volt' is given twice, as 'Volt' and as 'ch1.csv'; keep one"),
        ({"ch1.csv": "wall", "ch2.csv:Amp": "ball 2"},
         "ch2.csv: there is no column 'Amp'; the file has Volt"),
        ({"Volt": "wall"}, r"column 'Volt' is in ch1.csv and in ch2.csv; give each file its own "
         r"place, as in sensors=\{'ch1.csv': 'wall', 'ch2.csv': 'ball 6'\}"),
        (None, "column 'Volt' is in ch1.csv and in ch2.csv; give each file its own place"),
        ({"Time": "time [s]"}, "column 'Volt' is in ch1.csv and in ch2.csv"),
        (["ch1.csv", "ch2.csv"], "column 'Volt' is in ch1.csv and in ch2.csv"),
        (["ch1.csv"], "ch2.csv: no sensor of this file is given"),
        (["ch1.csv", "ch1.csv"], "sensor 'ch1.csv' is given twice; give it once"),
        ({"ch1.csv": "wall", "ch2.csv": "anvil"}, "ch2.csv: 'anvil', given for column 'Volt'"),
    ],
)  # fmt: skip
def test_wrong_names_are_rejected(files, sensors, words):
    with pytest.raises(hc.InputError, match=words):
        hc.load_traces(*files[:2], sensors=sensors, channels=True)


def test_files_that_are_no_channels_are_rejected(files, tmp_path):
    with pytest.raises(hc.InputError, match=r"'ch1.csv' is that of one file; .* channels=True"):
        hc.load_traces(*files, sensors=SENSORS)
    with pytest.raises(hc.InputError, match=r"ch1.csv is given twice; give the file of a channel"):
        hc.load_traces(files[0], files[0], sensors=SENSORS, channels=True)
    short = tmp_path / "ch9.csv"
    short.write_text("\n".join(files[0].read_text().splitlines()[:-1]))
    sensors = {"ch1.csv": "wall", "ch9.csv": "ball 2"}
    with pytest.raises(hc.InputError, match=r"ch9.csv: channels have 361 and 360 samples; to"):
        hc.load_traces(files[0], short, sensors=sensors, channels=True)
    empty = tmp_path / "times.csv"
    empty.write_text("Time (s),shot\n0,1\n1e-6,1\n")
    with pytest.raises(hc.InputError, match=r"times.csv: the file has no column of samples"):
        hc.load_traces(empty, sensors={"times.csv": "wall"})
    none = tmp_path / "none.csv"
    none.write_text("a,b\n0,1\n1,1\n")
    with pytest.raises(hc.InputError, match="there must be one column of times"):
        hc.load_traces(none, sensors={"none.csv": "wall"})


@pytest.mark.parametrize("units", ["", ";;\n"])
def test_times_of_another_name_without_a_unit_can_be_given(run, tmp_path, folder, units):
    file = tmp_path / "scope.csv"
    rows = "".join(f"{0.001 * k:g};{k % 7};{k % 5}\n" for k in range(9)).replace(".", ",")
    file.write_text(f"Zeit;Kanal A;Kanal B\n{units}\n{rows}")
    sensors = {"Kanal A": "ball 2 [N]", "Kanal B": "wall [N]"}
    with pytest.raises(hc.InputError, match=r"among Zeit, Kanal A, Kanal B; if it is 'Zeit', give"):
        hc.load_traces(file, sensors=sensors)
    given = [f"--sensor={name}={place}" for name, place in sensors.items()]
    code, _, err = run("compare", file, folder / "row.toml", *given)
    assert (code, "if it is 'Zeit', add --sensor 'Zeit=time [ms]'" in err) == (2, True)
    traces = hc.load_traces(file, sensors={**sensors, "Zeit": "time [ms]"}, noise=0.1)
    assert traces.shots[0].times == pytest.approx(1e-6 * np.arange(9))


def test_commands_accept_a_sensor_for_each_file(run, files, folder):
    options = [word for name, place in SENSORS.items() for word in ("--sensor", f"{name}={place}")]
    code, out, err = run("compare", *files, folder / "row.toml", *options, "--json")
    assert code == 0, err
    sensors = json.loads(out)["sensors"]
    assert [each["name"] for each in sensors] == list(PLACES)
    # Noise over peak is up to 1e-3 / 0.3.
    for each, gain in zip(sensors, GAINS, strict=True):
        assert each["scale"] == pytest.approx(gain, rel=0.01)
    free = ("--free", "time_offset", "--free", "gain[*]")
    code, out, err = run("fit", *files, folder / "row.toml", *options, "--channels", *free)
    assert code == 0, err
    assert f"5 parameters from {4 * 361} samples of 4 sensors" in out


@pytest.mark.parametrize(
    ("command", "options", "words"),
    [
        ("compare", ["ch1.csv=ball 2"], "ch2.csv: no sensor of this file is given; leave out the "
         "file, or add --sensor 'ch2.csv=wall'\n"),
        ("compare", ["ch1.csv=ball 2", "ch1.csv=wall"],
         "--sensor ch1.csv is given twice; give each column one place\n"),
        ("compare", [], "column 'Volt' is in ch1.csv and in ch2.csv; give each file its own place, "
         "as in --sensor 'ch1.csv=wall' --sensor 'ch2.csv=ball 6'\n"),
        ("compare", ["ch1.csv=ball 2", "ch2.csv:Amp=wall"],
         "ch2.csv: there is no column 'Amp'; the file has Volt\n"),
        ("compare", ["ch1.csv=ball 2", "ch7.csv=wall"],
         "choose from ch1.csv, ch2.csv\n"),
        ("fit", ["ch1.csv=ball 2", "ch2.csv=wall"], "sensor 'ch1.csv' is that of one file; if the "
         "files are channels of one shot, add --channels\n"),
        ("compare", ["=wall"], "--sensor '=wall' names no column; write it as in CH1=wall\n"),
    ],
)  # fmt: skip
def test_wrong_options_are_rejected(run, files, folder, command, options, words):
    given = [word for each in options for word in ("--sensor", each)]
    code, out, err = run(command, *files[:2], folder / "row.toml", *given)
    assert (code, out) == (2, "")
    assert err.endswith(words)

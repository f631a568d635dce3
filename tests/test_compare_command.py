"""The command `compare`, and columns of oscilloscopes."""

import json
import re

import numpy as np
import pytest
from scipy_row import SPACING, chain, recorded

import hertzchain as hc

pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")


@pytest.fixture
def files(tmp_path):
    """Traces that SciPy computed, as of an oscilloscope, and the chain file of the nominal row."""
    times, columns = recorded()
    rows = np.column_stack([1e6 * times, columns["ball 5 [N]"], columns["wall [N]"]])
    header = "Time (us),Ch1 (N),Ch2 (N)"
    for name, shots in (("one.csv", 1), ("two.csv", 2)):
        table = np.vstack([np.insert(rows, 0, k + 1, axis=1) for k in range(shots)])
        fmt = ["%d", *["%.6g"] * 3]
        if shots == 1:
            table, fmt = rows, "%.6g"
        head = header if shots == 1 else f"shot,{header}"
        np.savetxt(tmp_path / name, table, delimiter=",", header=head, comments="", fmt=fmt)
    (tmp_path / "row.toml").write_text(hc.chain_as_toml(chain()))
    return tmp_path


PLACES = ("--sensor", "Ch1=ball 5", "--sensor", "ch2=wall")


def test_compare_prints_the_comparison_of_the_library(run, files):
    data = hc.load_traces(files / "one.csv", sensors={"Ch1": "ball 5", "Ch2": "wall"})
    record = float(np.ptp(data.shots[0].times))
    expected = hc.simulate(chain(), until=record, times=4000).compare(data)
    code, out, err = run("compare", files / "one.csv", files / "row.toml", *PLACES)
    assert code == 0, err
    first, *rest = out.splitlines()
    about = "15 steel-52100 beads, diameter 10 mm, and 1 striker, right wall of steel-304"
    assert first == f"{about}, viscoelastic 0.4 us"
    assert rest == expected.summary(width=None).splitlines()
    code, out, _ = run("compare", files / "one.csv", files / "row.toml", *PLACES, "--json",
                       "--plot", files / "compared.svg")  # fmt: skip
    document = json.loads(out)
    assert document["time_offset"] == pytest.approx(expected.time_offset, abs=SPACING)
    for each, sensor in zip(document["sensors"], expected.sensors, strict=True):
        assert each["name"] == sensor.name
        assert each["measured_peak"] == pytest.approx(sensor.measured_peak)
        assert each["simulated_peak"] == pytest.approx(sensor.simulated_peak)
        assert each["saturated"] is False
    assert document["notes"] == list(expected.notes)
    assert (files / "compared.svg").stat().st_size > 10_000


@pytest.mark.long
def test_another_speed_and_loss_replace_those_of_the_file(run, files):
    document = hc.chain_as_toml(chain(loss=None).replace(velocities=0.9 * chain().velocities))
    (files / "other.toml").write_text(document)
    speed = ("--speed", "0.26 m/s", "--loss", "viscoelastic=0.4us")
    same = run("compare", files / "one.csv", files / "row.toml", *PLACES).stdout.splitlines()
    found = run("compare", files / "one.csv", files / "other.toml", *PLACES, *speed)
    assert found.stdout.splitlines() == same
    plain = run("compare", files / "one.csv", files / "other.toml", *PLACES).stdout
    assert plain.splitlines()[1:] != same[1:]
    code, out, err = run("compare", files / "one.csv", files / "row.toml", *PLACES, "--speed", "1")
    assert (code, out) == (2, "")
    assert "--speed 1 has no unit; write, for example, --speed '1 m/s'" in err


@pytest.mark.parametrize("unit", ["ms", "s", "ns"])
def test_times_in_another_unit_are_rejected(run, files, unit):
    text = (files / "one.csv").read_text().replace("Time (us)", f"Time ({unit})")
    (files / "other.csv").write_text(text)
    code, out, err = run("compare", files / "other.csv", files / "row.toml", *PLACES)
    assert (code, out) == (2, "")
    assert "check the unit of the times of the data" in err


def test_times_of_compare_have_units(run, files):
    code, out, _ = run("compare", files / "one.csv", files / "row.toml", *PLACES, "--json",
                       "--time-offset", "70 us", "--until", "0.5 ms")  # fmt: skip
    assert code == 0
    document = json.loads(out)
    assert document["time_offset"] == pytest.approx(70e-6)
    assert document["interval"][1] == pytest.approx(0.5e-3, abs=SPACING)
    assert not any("before the record" in each for each in document["notes"])


def test_compare_states_the_pressure_if_it_is_below_yield(run, files):
    text = hc.chain_as_toml(chain(right_wall=hc.Wall()))
    (files / "hard.toml").write_text(text)
    code, out, err = run("compare", files / "one.csv", files / "hard.toml", *PLACES)
    assert code == 0, err
    # Johnson, Eqs. (4.22) to (4.24), for the isolated collision of striker and first ball, which
    # the other balls and the loss change by a few percent; first yield at 1.6 Y.
    steel, radius = hc.material("steel-52100"), 5e-3
    modulus = 0.5 * steel.young / (1.0 - steel.poisson**2)
    stiffness = 4 / 3 * modulus * (radius / 2) ** 0.5
    energy = 0.25 * steel.density * 4 / 3 * np.pi * radius**3 * 0.26**2
    overlap = (2.5 * energy / stiffness) ** 0.4
    pressure = 2 / np.pi * modulus * (overlap / (radius / 2)) ** 0.5
    line = out.splitlines()[1]
    assert line.startswith("pressure / yield 0.8")
    assert float(line.split()[3]) == pytest.approx(pressure / 1.6 / steel.yield_strength, rel=0.05)
    assert (
        "pressure / yield"
        not in run("compare", files / "one.csv", files / "row.toml", *PLACES).stdout
    )


def test_compare_and_fit_use_the_same_part_of_the_data(run, files):
    data = hc.load_traces(files / "one.csv", sensors={"Ch1": "ball 5", "Ch2": "wall"})
    part = data.between("30 us", "450 us")
    expected = hc.simulate(chain(), until=600e-6, times=4000).compare(part)
    cut = ("--from", "30us", "--until", "450 us", "--json")
    code, out, err = run("compare", files / "one.csv", files / "row.toml", *PLACES, *cut)
    assert code == 0, err
    found = json.loads(out)
    assert found["interval"] == pytest.approx([30e-6, 450e-6], abs=SPACING)
    assert found["time_offset"] == pytest.approx(expected.time_offset, abs=0.1 * SPACING)
    assert not any("before the record ends" in each for each in found["notes"])
    free = ("--free", "stiffness", "--free", "time_offset", "--starts", 1, "--no-diagnosis")
    out = run("fit", files / "one.csv", files / "row.toml", *PLACES, *free, *cut).stdout
    fitted = json.loads(out)
    assert fitted["samples"] == sum(int(each.valid.sum()) for _, each in part)


def test_a_part_of_the_data_after_the_impact_is_compared_to_its_end(run, files):
    """A cut at the front does not shorten the simulation."""
    whole = ("compare", files / "one.csv", files / "row.toml", *PLACES, "--json")
    offset = json.loads(run(*whole)[1])["time_offset"]
    code, out, err = run(*whole, "--from", "150us", "--time-offset", f"{1e6 * offset} us")
    assert code == 0, err
    document = json.loads(out)
    assert document["exchanged"] is False
    assert document["covered"] == pytest.approx(1.0, abs=0.01)
    assert document["interval"][0] == pytest.approx(150e-6, abs=SPACING)


@pytest.mark.parametrize("command", ["compare", "fit"])
def test_columns_without_places_are_explained(run, files, command):
    code, _, err = run(command, files / "one.csv", files / "row.toml")
    assert code == 2
    assert "column 'Ch1' does not name the place of its sensor" in err
    assert "add --sensor 'Ch1=wall'" in err


def test_fit_reads_the_columns_of_an_oscilloscope(run, files):
    free = ["--free", "stiffness", "--free", "loss.time", "--free", "time_offset"]
    options = ("--starts", 1, "--prior", "stiffness=0.97,0.001", "--json")
    out = run("fit", files / "one.csv", files / "row.toml", *PLACES, *free, *options).stdout
    assert {*json.loads(out)["chi2_per_sample"]} == {"ball 5", "wall"}


@pytest.mark.parametrize("command", ["compare", "fit"])
def test_noise_is_given_for_all_sensors_or_by_sensor(run, files, command, monkeypatch):
    given = []

    def read(*paths, noise, **options):  # noqa: ARG001
        given.append(noise)
        raise hc.InputError("the file is not read in this test")

    monkeypatch.setattr(hc, "load_traces", read)
    for noises in (["0.2"], ["3 mN"], ["wall=0.05 N", "ball 5 = 0.2"], [], ["wall=0.2 N", "3 mV"]):
        options = [each for noise in noises for each in ("--noise", noise)]
        code, _, _ = run(command, files / "one.csv", files / "row.toml", *options)
        assert code == 2
    assert given == [
        0.2,
        "3 mN",
        {"wall": "0.05 N", "ball 5": 0.2},
        None,
        {"*": "3 mV", "wall": "0.2 N"},
    ]


def test_two_noises_of_all_sensors_and_unknown_noise_are_explained(run, files):
    two = ("compare", files / "one.csv", files / "row.toml", *PLACES)
    code, _, err = run(*two, "--noise", "0.1 N", "--noise", "1 N")
    assert code == 2
    assert "--noise '1 N' names no sensor, nor does --noise '0.1 N'; give one for all" in err
    code, _, err = run(*two, "--noise", "ball 9=1 N")
    assert code == 2
    assert "unknown sensor of noise 'ball 9' (did you mean 'ball 5'?): choose from ball 5" in err


def test_traces_that_begin_with_the_pulse_lead_to_the_option_for_noise(run, files):
    lines = (files / "one.csv").read_text().splitlines()
    late = next(i for i, line in enumerate(lines[1:], 1) if float(line.split(",")[1]) > 1.0)
    (files / "late.csv").write_text("\n".join([lines[0], *lines[late:]]) + "\n")
    late = ("compare", files / "late.csv", files / "row.toml", *PLACES)
    code, _, err = run(*late)
    assert code == 2
    assert "or give --noise" in err
    code, _, err = run(*late, "--noise", "0.1 N")
    assert code == 0, err


def test_mistakes_of_compare_are_explained(run, files):
    (files / "wrong.csv").write_text("a,b\n1,2\n")
    for command in ("compare", "fit"):
        code, _, err = run(command, files / "wrong.csv", files / "none.toml")
        assert code == 2
        assert "none.toml' (No such file or directory)" in err
    code, _, err = run("compare", files / "two.csv", files / "row.toml", *PLACES)
    assert code == 2
    assert "the file has 2 shots: add --shot" in err
    assert run("compare", files / "two.csv", files / "row.toml", *PLACES, "--shot", 2)[0] == 0
    assert run("compare", files / "two.csv", files / "row.toml", *PLACES, "--shot", 3)[0] == 2
    code, _, err = run(
        "compare", files / "one.csv", files / "row.toml", *PLACES, "--until", "100us"
    )
    assert code == 2
    assert "the simulation explains no more of the data than noise would" in err
    assert run("compare", files / "row.toml", files / "one.csv")[0] == 2


def test_a_record_of_the_pulse_alone_is_compared(run, tmp_path, files):
    """The oscilloscope was triggered when the pulse arrived; by default, the run lasts longer."""
    times, columns = recorded()
    wall = columns["wall [N]"]
    begin = int(np.argmax(wall > 1.0)) - 30
    part = np.column_stack((1e6 * times[: len(times) // 8], wall[begin:][: len(times) // 8]))
    np.savetxt(tmp_path / "part.csv", part, "%.8g", ",", header="time [us],wall [N]", comments="")
    code, out, err = run("compare", tmp_path / "part.csv", files / "row.toml", "--json")
    assert code == 0, err
    # The impact was before the record began.
    assert json.loads(out)["time_offset"] < -1e-4
    assert abs(json.loads(out)["sensors"][0]["residual"]) < 0.2


# Bead 6 is ball 5 behind one striker.
@pytest.mark.parametrize("names", [("ball 5", "bead 6"), ("wall", "right wall")])
@pytest.mark.parametrize("function", [hc.fit, lambda traces, chain, free: hc.simulate(  # noqa: ARG005
    chain, until=3e-4, times=4000).compare(traces)])  # fmt: skip
def test_a_sensor_that_is_named_twice_is_rejected(function, names):
    times, columns = recorded()
    data = hc.Traces.from_arrays(times, {f"{name} [N]": columns["ball 5 [N]"] for name in names})
    assert chain().strikers == 1
    message = "{!r} and {!r} are the same place of this chain; keep one column".format(*names)
    with pytest.raises(hc.InputError, match=message):
        function(data, chain(), free=["struck_by.velocity"])


def test_shots_that_do_not_exist_and_times_without_a_unit_are_explained(run, files):
    code, _, err = run("compare", files / "one.csv", files / "row.toml", *PLACES, "--shot", "2")
    assert code == 2
    assert "the file has one shot" in err
    code, _, err = run("compare", files / "one.csv", files / "row.toml", *PLACES, "--until", "700")
    assert code == 2
    assert "--until '700 us'" in err


def test_exchanged_columns_are_reported_once_and_only_they(run, files):
    exchanged = ("--sensor", "Ch1=wall", "--sensor", "ch2=ball 5")
    code, out, err = run("compare", files / "one.csv", files / "row.toml", *exchanged)
    assert code == 3
    assert (out + err).count("check the names of these columns") == 1
    assert "check its gain" not in out + err
    assert "Warning" not in err
    first, second, third, *_ = out.splitlines()
    assert first.startswith("with the columns of ")
    assert first.endswith("; the values below are measured")
    assert second.endswith("1 striker, right wall of steel-304, viscoelastic 0.4 us")
    assert third.startswith("data from 0 s to ")
    # Neither the time offset nor simulated values have a meaning.
    assert "time offset" not in out
    assert "simulated" not in out


@pytest.mark.filterwarnings("ignore:with a time offset")
def test_a_sensor_in_another_ball_is_named(tmp_path):
    run = hc.simulate(chain(), until=6e-4, times=2001)
    run.save_forces(tmp_path / "run.csv", ["ball 5", "ball 11", "wall"])
    text = (tmp_path / "run.csv").read_text(encoding="utf-8")
    for number in (11, 12, 14):
        (tmp_path / "place.csv").write_text(text.replace("ball 11", f"ball {number}"))
        out = run.compare(hc.load_traces(tmp_path / "place.csv", noise=0.1)).summary(width=None)
        assert (f"the sensor named ball {number} is in ball 11, the rms" in out) == (number > 11)
        assert out.count("the sensor named") == (number > 11)
        assert "not the only cause" not in out
    # With a gap that the simulation lacks, two balls agree about as well, and neither well.
    gaps = np.zeros(chain().beads - 1)
    gaps[8] = 6e-6
    late = hc.simulate(chain().replace(gaps=gaps), until=6e-4, times=2001)
    columns = {"ball 8 [N]": late.sensor("ball 5"), "wall [N]": late.sensor("wall")}
    found = run.compare(hc.Traces.from_arrays(late.times, columns, noise=0.1))
    (note,) = (each for each in found.notes if "the sensor named" in each)
    assert re.match(
        r"if the sensor named ball 8 is in ball \d, the rms difference falls to \d+% of its value "
        r"\(in ball \d, to \d+%\): check the place of this sensor and the delay of its channel; a "
        r"difference of \d+% of the signals remains, so it is not the only cause$",
        note,
    )


def test_exchanged_columns_are_not_also_wrong_gains_or_signs(run, files):
    times, columns = recorded()
    rows = np.column_stack([1e6 * times, 0.02 * columns["wall [N]"], 0.02 * columns["ball 5 [N]"]])
    for head in ("ball 5 [V],wall [V]", "wall [V],ball 5 [V]"):
        np.savetxt(files / "v.csv", rows, delimiter=",", header=f"time [us],{head}", comments="")
        row = files / "gains.toml"
        priors = "".join(f'"gain[{name}]" = [0.0175, 0.0001]\n' for name in ("wall", "ball 5"))
        row.write_text(f"{hc.chain_as_toml(chain())}\n[fit.prior]\n{priors}")
        code, out, err = run("compare", files / "v.csv", row)
        exchanged = head.startswith("ball 5")
        assert code == (3 if exchanged else 0), err
        assert ("check the names of these columns" in out) == exchanged
        assert ("its prior in [fit]" in out) != exchanged
        assert "is inverted" not in out


@pytest.mark.parametrize(
    ("prior", "words"),
    [
        ('["25 mV/N", "0.5 mV/N"]', r"standard deviations from its prior in \[fit\], 25.00 \+- "
         r"0.50 mV/N: check the velocity of the impact, the loss, the diameters"),
        ("[0.0175, 0.001]", r"agrees with its prior in \[fit\], 17.5 \+- 1.0 mV/N$"),
        ("[0.0192, 0.001]", r"differs by [12]\.\d standard deviations from its prior in \[fit\], "
         r"19.2 \+- 1.0 mV/N$"),
        ("[17.5, 1.0]", "1,000 times too small, because the unit in its header is wrong, such as "
         "mV instead of V$"),
    ],
)  # fmt: skip
def test_the_gain_of_a_sensor_is_compared_with_its_prior(run, files, prior, words):
    times, columns = recorded()
    rows = np.column_stack([1e6 * times, 0.02 * columns["wall [N]"]])
    np.savetxt(files / "volts.csv", rows, delimiter=",", header="time [us],wall [V]", comments="")
    row = files / "prior.toml"
    row.write_text(f'{hc.chain_as_toml(chain())}\n[fit.prior]\n"gain[wall]" = {prior}\n'
                   '"gain[ball 5]" = [1.0, 0.1]\n')  # fmt: skip
    code, out, err = run("compare", files / "volts.csv", row)
    assert code == 0, err
    (note,) = (line for line in out.splitlines() if "[fit]" in line)
    assert note.startswith("the gain of wall, ")
    assert re.search(words, note), note
    document = json.loads(run("compare", files / "volts.csv", row, "--json").stdout)
    assert note in document["notes"]
    # The nominal row is struck faster than that of the data.
    data = hc.load_traces(files / "volts.csv")
    until = float(np.ptp(data.shots[0].times))
    (sensor,) = hc.simulate(chain(), until=until, times=4000).compare(data).sensors
    assert document["sensors"][0]["scale"] == pytest.approx(sensor.scale, rel=1e-6)
    assert f"wall, {sensor.scaling}, " in note

"""Files of oscilloscopes, as their makers write them, and units that are given with the sensors."""

import numpy as np
import pytest

import hertzchain as hc

COUNT = 200
TIMES = np.round(1e-6 * (np.arange(COUNT) - 50), 9)
PULSE = 2.0 * np.exp(-(((np.arange(COUNT) - 140) / 9.0) ** 2))
NOISE = np.random.default_rng(3).normal(0.0, 1e-3, (2, COUNT))
SIGNALS = np.round(np.array([PULSE, 0.5 * np.roll(PULSE, 20)]) + NOISE, 6)
PLACES = {"CH1": "ball 4", "CH2": "wall"}


def lines(factor=1.0, end=""):
    return "".join(
        f"{factor * time:.9g},{first:.6f},{second:.6f}{end}\n"
        for time, first, second in zip(TIMES, *SIGNALS, strict=True)
    )


TEKTRONIX = f"""Model,MDO3024,,
Firmware Version,1.26,,

Waveform Type,ANALOG,,
Point Format,Y,,
Horizontal Units,s,,
Sample Interval,1e-06,,
Record Length,{COUNT},,
Vertical Units,V,V,
Vertical Scale,1,0.5,
,,,
Label,,,
TIME,CH1,CH2,
"""
KEYSIGHT = "x-axis,1,2\nsecond,Volt,Volt\n"
PICOSCOPE = "Time,Channel A,Channel B\n(us),(V),(V)\n\n"
SIGLENT = "Record Length,Analog:200\nSample Interval,Analog:0.000001\nSource,CH1,CH2\n"
FORMATS = {
    "tektronix": (TEKTRONIX + lines(end=","), PLACES),
    "keysight": (KEYSIGHT + lines(), {"1": "ball 4", "2": "wall"}),
    # The smallest samples, not minutes.
    "minimum": (
        "Name,1,2\nmin,-0.003,-0.003\n" + KEYSIGHT + lines(),
        {"1": "ball 4", "2": "wall"},
    ),
    "picoscope": (PICOSCOPE + lines(1e6), {"Channel A": "ball 4", "Channel B": "wall"}),
    "siglent": (SIGLENT + "Second,Volt,Volt\n" + lines(), PLACES),
    # Lines of settings with the names of columns, and a time of day.
    "lecroy": (
        "LECROYWR64Xi,22222,Waveform\nSegments,1,SegmentSize,200\nTime,12:30:01\n"
        "Time,Ampl1,Ampl2\n" + lines(),
        {"Time": "time [s]", "Ampl1": "ball 4 [V]", "Ampl2": "wall [V]"},
    ),
    "no units": (
        "TIME,CH1,CH2\n" + lines(),
        {"TIME": "time [s]", "ch1": "ball 4 [V]", "CH2": "wall [V]"},
    ),
}


@pytest.mark.parametrize("name", FORMATS)
def test_files_of_oscilloscopes_are_read(name, tmp_path):
    text, places = FORMATS[name]
    (tmp_path / "scope.csv").write_text(text)
    traces = hc.load_traces(tmp_path / "scope.csv", sensors=places)
    assert traces.names == ("ball 4", "wall")
    np.testing.assert_allclose(traces.shots[0].times, TIMES, rtol=1e-8, atol=1e-15)
    for signal, expected in zip(traces.shots[0].signals, SIGNALS, strict=True):
        assert signal.unit == "V"
        np.testing.assert_allclose(signal.values, expected, atol=1e-12)
    (one,) = list(places)[-1:]
    also = {key: place for key, place in places.items() if key == one or "time" in place}
    assert hc.load_traces(tmp_path / "scope.csv", sensors=also).names == ("wall",)


def test_settings_may_be_beside_the_samples(tmp_path):
    settings = [
        f"Record Length,{COUNT}", "Sample Interval,1e-06", "Trigger Point,50", ",", ",", ",",
        "Source,CH1", "Vertical Units,mV", "Vertical Scale,1", "Horizontal Units,s",
    ]  # fmt: skip
    settings += [","] * (COUNT - len(settings))
    rows = [
        f"{setting},,{time:.9f},{1e3 * value:.4f},"
        for setting, time, value in zip(settings, TIMES, SIGNALS[0], strict=True)
    ]
    (tmp_path / "F0000CH1.CSV").write_text("\n".join(rows) + "\n")
    traces = hc.load_traces(tmp_path / "F0000CH1.CSV", sensors={"CH1": "ball 4"})
    np.testing.assert_allclose(traces.shots[0].times, TIMES, atol=1e-15)
    np.testing.assert_allclose(traces.shots[0].signals[0].values, SIGNALS[0], atol=1e-7)


def test_samples_may_be_numbered(tmp_path):
    rows = [
        f"{i},{first:.6f},{second:.6f},," for i, (first, second) in enumerate(SIGNALS.T.tolist())
    ]
    head = ["X,CH1,CH2,Start,Increment,", f"Sequence,Volt,Volt,{TIMES[0]:e},1.000000e-06"]
    file = tmp_path / "rigol.csv"
    file.write_text("\n".join([*head, *rows]) + "\n")
    traces = hc.load_traces(file, sensors=PLACES)
    np.testing.assert_allclose(traces.shots[0].times, TIMES, atol=1e-15)
    for signal, expected in zip(traces.shots[0].signals, SIGNALS, strict=True):
        np.testing.assert_allclose(signal.values, expected, atol=1e-12)
    file.write_text("\n".join([*head, *rows[:9], "9,0.1"]) + "\n")
    with pytest.raises(hc.InputError, match="line 12 must have a number and 2 samples"):
        hc.load_traces(file, sensors=PLACES)


def test_units_of_sensors_are_converted(tmp_path):
    (tmp_path / "scope.csv").write_text("TIME [s],CH1,CH2 [mV]\n" + lines())
    sensors = {"CH1": "ball 4 [mN]", "CH2": "wall [mV]"}
    first, second = hc.load_traces(tmp_path / "scope.csv", sensors=sensors).shots[0].signals
    assert (first.unit, second.unit) == ("N", "V")
    np.testing.assert_allclose(first.values, 1e-3 * SIGNALS[0])
    np.testing.assert_allclose(second.values, 1e-3 * SIGNALS[1])
    assert hc.load_traces(tmp_path / "scope.csv", sensors={"CH2 (mV)": "wall"}).names == ("wall",)


@pytest.mark.parametrize(
    ("head", "sensors", "words"),
    [
        ("TIME [s],CH1,CH2", None, "give load_traces sensors={'CH1': 'wall [V]'}"),
        ("TIME [s],CH1,CH2", {"CH1": "ball 4"},
         "column 'CH1' has no unit; give load_traces sensors={'CH1': 'ball 4 [V]'}, or [N] for"),
        ("TIME,CH1,CH2", {"CH1": "ball 4 [V]"},
         "column 'TIME' has no unit; write TIME [us], or give load_traces sensors={'TIME': 'time"),
        ("TIME [s],CH1 [mV],CH2", {"CH1": "ball 4 [V]"},
         "has the unit mV, but the sensor is given as 'ball 4 [V]'"),
        ("X,CH1,CH2", {"CH1": "ball 4 [V]"}, "one column of times"),
        ("TIME [s],CH1,CH2", {"CH3": "wall [V]"}, "no column 'CH3'; the file has CH1, CH2"),
        ("TIME,CH1,CH2\n(s),(V)", PLACES, "row of units has 2 cells, but the header has 3"),
        ("TIME,CH1,CH2\n(s),(A),(V)", PLACES, "unit of column 'ball 4' 'A'"),
        ("Model,X1\nTIME,CH1\n(s),(V)", {"CH1": "wall"}, "line 4 has 3 cells, but the"),
    ],
)  # fmt: skip
def test_messages_use_the_names_of_the_file(head, sensors, words, tmp_path):
    (tmp_path / "scope.csv").write_text(f"{head}\n" + lines())
    with pytest.raises(hc.InputError) as caught:
        hc.load_traces(tmp_path / "scope.csv", sensors=sensors)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "head",
    ["TIME [s],CH1,CH2\n", "TIME,CH1,CH2\n(S),(V),(V)\n", "TIME,CH1,CH2\nsecond,V,V\n", TEKTRONIX],
)
def test_a_unit_of_times_that_contradicts_the_file_is_rejected(head, tmp_path):
    file = tmp_path / "scope.csv"
    file.write_text(head + lines(end="," if head == TEKTRONIX else ""))
    places = {"CH1": "wall [V]"}
    for given in ("time", "time [s]"):
        found = hc.load_traces(file, sensors=places | {"TIME": given})
        np.testing.assert_allclose(found.shots[0].times, TIMES, atol=1e-15)
    with pytest.raises(hc.InputError) as caught:
        hc.load_traces(file, sensors=places | {"TIME": "time [ms]"})
    assert (
        "column 'TIME [s]' has the unit s, but the times are given as 'time [ms]'; leave out the "
        "unit, or correct the header"
    ) in str(caught.value)


def test_sensors_of_the_command_line_have_units(run, tmp_path):
    (tmp_path / "scope.csv").write_text("TIME,CH1,CH2\n" + lines())
    (tmp_path / "row.toml").write_text(
        hc.chain_as_toml(
            hc.Chain.from_materials(5e-3, "steel-52100", beads=6, velocity=0.1).replace(
                right_wall=hc.Wall()
            )
        )
    )
    files = ("compare", tmp_path / "scope.csv", tmp_path / "row.toml")
    code, _, err = run(*files, "--sensor", "TIME=time [s]", "--sensor", "CH1=ball 4")
    assert code == 2
    assert "add --sensor 'CH1=ball 4 [V]'" in err
    code, out, err = run(*files, "--sensor", "TIME=time [s]", "--sensor", "CH1=ball 4 [V]")
    assert code == 0, err
    assert "  ball 4 " in out
    assert " V " in out


def test_channels_in_files_of_their_own_are_merged(tmp_path):
    times, rng = 1e-6 * np.arange(80), np.random.default_rng(2)
    pulse = np.exp(-(((times - 50e-6) / 6e-6) ** 2))
    parts = []
    for name, place in (("CH1", "ball 4 [V]"), ("CH2", "wall [V]")):
        seen = pulse + 0.01 * rng.standard_normal(80)
        rows = "\n".join(
            f"{time!r},{value!r}" for time, value in zip(times.tolist(), seen.tolist(), strict=True)
        )
        # GW Instek writes seconds as S.
        (tmp_path / name).write_text(
            f"Horizontal Units,S\nVertical Units,V\nTIME,{name}\n{rows}\n", "utf-8"
        )
        parts.append(hc.load_traces(tmp_path / name, sensors={name: place}))
    both = parts[0].merge(parts[1])
    assert both.names == ("ball 4", "wall")
    assert len(both.shots) == 1
    np.testing.assert_array_equal(both.shots[0].times, times)
    assert repr(both.shots[0]) == "Shot(ball 4 [V], wall [V]: 80 samples, every 1 us)"
    with pytest.raises(hc.InputError, match="ball 4 is in both traces"):
        both.merge(parts[0])
    later = hc.Traces.from_arrays(times + 1e-6, {"ball 5 [V]": pulse}, noise=0.01)
    with pytest.raises(hc.InputError, match="must have the same times"):
        both.merge(later)
    with pytest.raises(hc.InputError, match="1 shot cannot be merged with 2 shots"):
        both.merge(later + later)


def test_the_noise_of_merged_channels_does_not_contain_their_crosstalk():
    index, rng = np.arange(800), np.random.default_rng(3)
    pulses = 100.0 * np.exp(-(((index - np.array([[120], [600]])) / 12.0) ** 2))
    seen = pulses + 0.02 * pulses[::-1] + rng.normal(0.0, 0.05, pulses.shape)
    columns = dict(zip(("ball 4 [N]", "wall [N]"), seen, strict=True))
    parts = [hc.Traces.from_arrays(1e-6 * index, {name: own}) for name, own in columns.items()]
    merged = parts[0].merge(parts[1])
    for signal in merged.shots[0].signals:
        assert signal.noise == pytest.approx(0.05, rel=4.0 / (2.0 * signal.quiet) ** 0.5)
    assert merged.shots == hc.Traces.from_arrays(1e-6 * index, columns).shots


def test_merged_channels_keep_what_was_given_for_each():
    times = 1e-6 * np.arange(4)
    one = hc.Traces.from_arrays(times, {"ball 4 [N]": [0.0, 3.0, 1.0, 0.0]}, noise=0.2)
    two = hc.Traces.from_arrays(
        times, {"wall [N]": [0.0, 5.0, np.inf, 1.0]}, noise=0.1, coupling="AC"
    )
    ball, wall = one.merge(two).shots[0].signals
    assert (ball.noise, wall.noise, ball.coupling, wall.coupling) == (0.2, 0.1, "", "AC")
    assert wall.valid.tolist() == [True, True, False, True]


def test_samples_beyond_the_range_are_not_used(tmp_path):
    places = {"TIME": "time [s]", "CH1": "ball 4 [V]", "CH2": "wall [V]"}
    rows = lines().splitlines()
    rows[60] = rows[60].rpartition(",")[0] + ",∞"
    (tmp_path / "scope.csv").write_text("TIME,CH1,CH2\n" + "\n".join(rows), "utf-8")
    data = hc.load_traces(tmp_path / "scope.csv", sensors=places)
    # A spike far from the pulse is missing.
    assert np.flatnonzero(np.isnan(data.shots[0].signals[1].values)).tolist() == [60]


@pytest.mark.parametrize("cell", ["9.91E37", "9.91e+37", "9.90999962E+37"])
def test_scpi_numbers_of_missing_samples(cell, tmp_path):
    rows = lines().splitlines()
    rows[60] = rows[60].rpartition(",")[0] + f",{cell}"
    (tmp_path / "scope.csv").write_text("TIME,CH1,CH2\n" + "\n".join(rows), "utf-8")
    places = {"TIME": "time [s]", "CH1": "ball 4 [V]", "CH2": "wall [V]"}
    data = hc.load_traces(tmp_path / "scope.csv", sensors=places)
    assert np.flatnonzero(np.isnan(data.shots[0].signals[1].values)).tolist() == [60]


@pytest.mark.parametrize(
    ("cell", "sign"),
    [("∞", 1), ("+∞", 1), ("-∞", -1), ("-inf", -1), ("9.9E+37", 1), ("-9.9e37", -1),
     ("9.89999975E+37", 1)],
)  # fmt: skip
def test_arrays_and_files_have_the_same_samples_beyond_the_range(cell, sign, tmp_path):
    times = 1e-6 * np.arange(200)
    rng = np.random.default_rng(2)
    force = sign * 20.0 * np.exp(-(((times - 120e-6) / 9e-6) ** 2)) + rng.normal(0.0, 0.05, 200)
    beyond = sign * force > 15.0
    rows = [
        f"{t!r},{cell if over else repr(float(value))}"
        for t, value, over in zip(times.tolist(), force, beyond, strict=True)
    ]
    (tmp_path / "data.csv").write_text("time [s],wall [N]\n" + "\n".join(rows), "utf-8")
    one = hc.load_traces(tmp_path / "data.csv")
    two = hc.Traces.from_arrays(times, {"wall [N]": np.where(beyond, sign * np.inf, force)})
    for each in (one, two):
        (signal,) = each.shots[0].signals
        assert not signal.valid[beyond].any()
        assert signal.valid.sum() >= (~beyond).sum() - 3
        # The limit of the range is at least the largest sample within it.
        limit = sign * (sign * force[~beyond]).max()
        np.testing.assert_array_equal(signal.values, np.where(beyond, limit, force))
        assert f"{200 - signal.valid.sum()} samples of wall in shot 1 are saturated" in repr(
            each.notes()
        )
    assert repr(one) == repr(two)


def test_equal_times_and_unknown_places_say_what_to_do(tmp_path):
    file = tmp_path / "scope.csv"
    file.write_text("time [s],Channel A [V]\n0.0001,0\n0.0001,1\n0.0002,0\n")
    with pytest.raises(hc.InputError, match="lines 2 and 3 are both at 0.0001 s; write the times"):
        hc.load_traces(file, sensors={"Channel A": "wall"}, noise=0.1)
    with pytest.raises(hc.InputError, match=r"sensors=\{'Channel A': 'wall'\}"):
        hc.load_traces(file, sensors={"Channel A": "sensor 1"}, noise=0.1)


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize("separator", [";", "\t"])
@pytest.mark.parametrize("decimal", [".", ","])
def test_columns_and_decimals_of_other_countries_are_read(name, separator, decimal, tmp_path):
    text, places = FORMATS[name]
    (tmp_path / "scope.csv").write_text(text.replace(",", separator).replace(".", decimal))
    (tmp_path / "usual.csv").write_text(text)
    found, usual = (
        hc.load_traces(tmp_path / file, sensors=places) for file in ("scope.csv", "usual.csv")
    )
    assert found.names == usual.names
    np.testing.assert_array_equal(found.shots[0].times, usual.shots[0].times)
    for one, other in zip(found.shots[0].signals, usual.shots[0].signals, strict=True):
        assert one.unit == other.unit
        np.testing.assert_array_equal(one.values, other.values)


def test_numbers_of_excel_in_german_are_read(tmp_path):
    rows = [f"{1e6 * time:g};{1e3 * value:.2E};" for time, value in zip(TIMES, PULSE, strict=True)]
    body = "\n".join(rows).replace(".", ",")
    (tmp_path / "scope.csv").write_text(f"Zeit (us);Kraft (mV);\n{body}\n", "utf-8-sig")
    traces = hc.load_traces(tmp_path / "scope.csv", sensors={"Kraft": "wall"})
    np.testing.assert_allclose(traces.shots[0].times, TIMES, atol=1e-15)
    np.testing.assert_allclose(traces.shots[0].signals[0].values, PULSE, rtol=1e-2, atol=1e-12)


def test_decimal_commas_may_be_in_quotation_marks(tmp_path):
    rows = [
        f'"{time:.7f}","{value:.5f}"'.replace(".", ",")
        for time, value in zip(TIMES, PULSE, strict=True)
    ]
    (tmp_path / "scope.csv").write_text("\n".join(["time [s],wall [V]", *rows]))
    (signal,) = hc.load_traces(tmp_path / "scope.csv").shots[0].signals
    np.testing.assert_allclose(signal.values, PULSE, atol=5.1e-6)


@pytest.mark.parametrize(
    ("head", "rows", "words"),
    [
        ("time [us];wall [V]", ["1,125;2,375", "2,125;4,125"],
         "1,125 may be 1.125 or 1125, like all numbers of this file; save the file with decimal"),
        ("time [us];wall [V]", ["1.125;2.375", "2.125;4.125"], "1.125 may be 1.125 or 1125"),
        ("time [us];wall [V]", ["1.0;0,5", "2.0;0,25"],
         "its numbers have commas and points, such as 0,5 and 1.0; save"),
        ("time [us];wall [V]", ["1;1.234,5", "2;1.234,6"], "commas and points, such as 1.234,5"),
        ("time [us],wall [V]", ["0,5,0,1", "1,5,0,2"],
         "line 2 has 4 cells, but the header has 2; if numbers have decimal commas, separate"),
        ("time [us],wall [V]", ["0,-0,1", "1,0,2"],
         "line 2 has 3 cells, but the header has 2; if numbers have decimal commas, separate"),
        ("time [us],wall [V]", ["0,0.1,3", "1,0.2,3"], "complete or remove the line"),
        ("shot,time [us],wall [V]", ["1,0,0.1", "1.5,1,0.2"],
         "the shot of line 3 is 1.5, but shots have whole numbers, such as 1 and 2"),
    ],
)  # fmt: skip
def test_numbers_that_can_be_read_in_two_ways_are_rejected(head, rows, words, tmp_path):
    (tmp_path / "scope.csv").write_text("\n".join([head, *rows]))
    with pytest.raises(hc.InputError) as caught:
        hc.load_traces(tmp_path / "scope.csv")
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("cell", "value"), [("0,125", 0.125), ("-0,125", -0.125), (",125", 0.125), ("1,25", 1.25),
                        ("1,125E+0", 1.125), ("1000,125", 1000.125)]
)  # fmt: skip
def test_one_number_decides_for_all(cell, value, tmp_path):
    rows = [f"{i};{each}" for i, each in enumerate(["1,125", "1,375"] * 9 + [cell, "1,625"])]
    (tmp_path / "scope.csv").write_text("\n".join(["time [us];wall [V]", *rows]))
    (signal,) = hc.load_traces(tmp_path / "scope.csv", noise=0.1).shots[0].signals
    assert signal.values[:2].tolist() == [1.125, 1.375]
    assert signal.values[18] == value


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252", "latin-1"])
def test_micro_signs_are_read_in_usual_encodings(encoding, tmp_path):
    (tmp_path / "scope.csv").write_text(
        "Room,21 °C,\ntime [µs],ball 4 [V],wall [V]\n" + lines(1e6), encoding
    )
    (shot,) = hc.load_traces(tmp_path / "scope.csv").shots
    np.testing.assert_allclose(shot.times, TIMES, atol=1e-15)


@pytest.mark.parametrize("content", [b"\x89PNG\r\n\x00\x00", bytes(range(1, 256))])
def test_files_without_text_are_rejected(content, tmp_path):
    (tmp_path / "scope.csv").write_bytes(content)
    with pytest.raises(hc.InputError, match=r"scope\.csv: is not a text file; save the table"):
        hc.load_traces(tmp_path / "scope.csv")


@pytest.mark.parametrize(
    ("head", "sensors"),
    [
        ("time [us]   ball 4 [V]  wall [V]\n", None),
        ("time [us] ball 4 [V] wall [V]\n", None),
        ("Scope 1000, serial 7\n\n  Time    CH1      CH2\n  (us)    (V)      (V)\n", PLACES),
        ("Time CH1 CH2\nus V V\n", PLACES),
    ],
)
@pytest.mark.parametrize("decimal", [".", ","])
def test_columns_may_be_separated_by_spaces(head, sensors, decimal, tmp_path):
    body = "".join(
        f"{1e6 * time:10.1f}  {first:10.5f}{second:10.5f}\n"
        for time, first, second in zip(TIMES, *SIGNALS, strict=True)
    )
    (tmp_path / "scope.txt").write_text(head + body.replace(".", decimal))
    traces = hc.load_traces(tmp_path / "scope.txt", sensors=sensors)
    assert traces.names == ("ball 4", "wall")
    np.testing.assert_allclose(traces.shots[0].times, TIMES, atol=1e-15)
    for signal, expected in zip(traces.shots[0].signals, SIGNALS, strict=True):
        np.testing.assert_allclose(signal.values, expected, atol=5.1e-6)


def test_errors_have_times_in_the_unit_of_the_file(tmp_path):
    file = tmp_path / "scope.csv"
    file.write_text("time [us],wall [V]\n0,0\n1.5,1\n0.7,0\n")
    with pytest.raises(hc.InputError, match="line 4 is at 0.7 us and the one before it at 1.5 us"):
        hc.load_traces(file, noise=0.1)
    with pytest.raises(hc.InputError, match="samples 2 and 3 are both at 1e-06 s"):
        hc.Traces.from_arrays([0.0, 1e-6, 1e-6], {"wall [V]": [0.0, 1.0, 0.0]}, noise=0.1)


@pytest.fixture
def channels(tmp_path):
    """Files with one channel each, a chain file, and the places of the channels."""
    row = hc.Chain.from_materials(5e-3, "steel-52100", beads=6).struck_by(velocity=0.1)
    row = row.replace(right_wall=hc.Wall())
    (tmp_path / "row.toml").write_text(hc.chain_as_toml(row))
    run, rng = hc.simulate(row, until=150e-6, times=301), np.random.default_rng(4)
    files = [tmp_path / "F1CH1.CSV", tmp_path / "F1CH2.CSV"]
    for file, name, force in zip(files, PLACES, (run.sensor(5), run.forces[:, -1]), strict=True):
        seen = np.concatenate((np.zeros(60), force)) + 0.05 * rng.standard_normal(361)
        rows = [f"{0.5e-6 * i:.9f},{value:.6f}" for i, value in enumerate(seen.tolist())]
        file.write_text("\n".join([f"time [s],{name} [N]", *rows]))
    return files


def test_files_of_channels_are_one_shot(channels):
    found = hc.load_traces(*channels, sensors={"CH2": "wall", "CH1": "ball 4"}, channels=True)
    parts = [hc.load_traces(file, sensors={name: place})
             for file, (name, place) in zip(channels, PLACES.items(), strict=True)]  # fmt: skip
    assert len(found.shots) == 1
    assert repr(found) == repr(parts[0].merge(parts[1]))
    with pytest.raises(hc.InputError, match="no column 'CH3'; the files have CH1, CH2"):
        hc.load_traces(*channels, sensors={**PLACES, "CH3": "ball 2"}, channels=True)
    with pytest.raises(hc.InputError, match="'CH1' is not in all files; .* channels=True"):
        hc.load_traces(*channels, sensors=PLACES)


def test_commands_accept_files_of_channels(run, channels):
    sensors = ("--sensor", "CH1=ball 4", "--sensor", "CH2=wall")
    chain = channels[0].with_name("row.toml")
    code, out, err = run("compare", *channels, chain, *sensors)
    assert code == 0, err
    assert "  ball 4 " in out
    assert "  wall " in out
    free = ("--free", "stiffness", "--free", "time_offset")
    code, out, err = run("fit", *channels, chain, *sensors, "--channels", *free)
    assert code == 0, err
    assert "2 parameters from 722 samples of 2 sensors" in out


@pytest.mark.parametrize("delimiter", [",", "  ", "\t", ";"])
def test_the_header_of_savetxt_is_read(delimiter, tmp_path):
    """NumPy writes it as a comment."""
    file = tmp_path / "data.csv"
    header = "measured on Monday\n" + delimiter.join(["time [us]", "ball 4 [N]", "wall [N]"])
    np.savetxt(file, np.c_[1e6 * TIMES, *SIGNALS], delimiter=delimiter, header=header)
    traces = hc.load_traces(file)
    np.testing.assert_allclose(traces.shots[0].times, TIMES, atol=1e-18)
    assert traces.names == ("ball 4", "wall")
    for signal, values in zip(traces.shots[0].signals, SIGNALS, strict=True):
        np.testing.assert_allclose(signal.values, values)


def test_a_file_with_comments_and_no_header_is_rejected(tmp_path):
    file = tmp_path / "data.csv"
    np.savetxt(file, np.c_[1e6 * TIMES, *SIGNALS], delimiter=",", header="measured on Monday")
    with pytest.raises(hc.InputError, match="the header with the names of the columns is missing"):
        hc.load_traces(file)
    # Numbers can be names of columns that are given.
    file.write_text("1,2\n0,0.0\n1e-6,4.0\n2e-6,0.5\n")
    assert hc.load_traces(file, sensors={"1": "time [s]", "2": "wall [N]"}, noise=0.1)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ("1e-06,1", "line {} has 2 cells, but the header has 3"),
        ("1e-06,x,1", "column 'CH1 [V]' is 'x' in line {}: it must be a number"),
        (",1,1", "the time of line {} is missing"),
        ("-1,1,1", "times must increase, but line {} is at -1 s"),
    ],
)
@pytest.mark.parametrize("before", ["", "# a comment\n\n"])
def test_messages_name_the_line_of_the_file(before, changed, words, tmp_path):
    content = (before + TEKTRONIX + lines()).splitlines()
    content[100] = changed
    (tmp_path / "scope.csv").write_text("\n".join(content))
    with pytest.raises(hc.InputError) as caught:
        hc.load_traces(tmp_path / "scope.csv", sensors=PLACES)
    assert words.format(101) in str(caught.value)


def test_shots_with_the_same_samples_are_named():
    rng = np.random.default_rng(3)
    shots = [
        hc.Traces.from_arrays(TIMES, {"wall [V]": PULSE + rng.normal(0.0, 0.01, len(PULSE))})
        for _ in range(2)
    ]
    words = "have the same samples"
    assert not any(words in note for note in (shots[0] + shots[1]).notes())
    (note,) = [note for note in (shots[0] + shots[1] + shots[0]).notes() if words in note]
    assert note.startswith("shots 1 and 3")

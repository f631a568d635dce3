"""Drives from measured signals: files of oscilloscopes, gains, offsets and baselines."""

import numpy as np
import pytest

import hertzchain as hc

COUNT = 200
TIMES = np.round(1e-6 * (np.arange(COUNT) - 40), 9)
# Half a period of a sine of 40 N, between 0 and 50 us.
FORCE = np.where((TIMES > 0) & (TIMES < 50e-6), 40.0 * np.sin(np.pi * TIMES / 50e-6), 0.0)
OFFSET = 0.012
VOLTS = OFFSET + 0.02 * FORCE


def write(path, *columns, head="Time (s),Volt (V)", times=TIMES):
    rows = [
        ",".join((f"{time:.9g}", *(f"{each:.15g}" for each in row)))
        for time, row in zip(times, zip(*columns, strict=True), strict=True)
    ]
    path.write_text("\n".join([head, *rows]) + "\n")
    return path


@pytest.fixture
def file(tmp_path):
    return write(tmp_path / "scope.csv", VOLTS)


@pytest.mark.parametrize(
    ("gain", "of", "factor"),
    [
        ("50 N/V", "force", 50.0),
        ("0.05 kN/V", "force", 50.0),
        ("0.05 N/mV", "force", 50.0),
        ("20 mV/N", "force", 50.0),
        ("0.02 V / N", "force", 50.0),
        ("-50 N/V", "force", -50.0),
        ("-2e1 mV/N", "force", -50.0),
        ("0.1 mm/V", "displacement", 1e-4),
        ("10 V/mm", "displacement", 1e-4),
        ("10 mV/um", "displacement", 1e-4),
    ],
)
@pytest.mark.filterwarnings("ignore:the force reaches")
def test_the_unit_of_the_gain_states_what_is_driven(file, gain, of, factor):
    """The gain of a sensor in a fit is in V/N, that of an amplifier often in N/V."""
    drive = hc.load_drive(file, gain=gain, offset="12 mV")
    assert drive.of == of
    np.testing.assert_allclose(drive.times, TIMES, rtol=1e-14)
    np.testing.assert_allclose(drive.values, factor * (VOLTS - OFFSET), atol=1e-12 * abs(factor))


@pytest.mark.parametrize("gain", ["5 mm/s/V", "200 V/(m/s)", "200 V s/m", "0.2 mV/(um/s)"])
def test_a_velocity_is_integrated(tmp_path, gain):
    """The displacement is 0 at time 0, and that of a sine is known."""
    times = np.maximum(TIMES, 0.0)
    speed = 3.0 * np.sin(2.0 * np.pi * times / 80e-6)
    drive = hc.load_drive(write(tmp_path / "laser.csv", speed), gain=gain)
    expected = 5e-3 * 3.0 * 80e-6 / (2.0 * np.pi) * (1.0 - np.cos(2.0 * np.pi * times / 80e-6))
    assert drive.of == "displacement"
    assert drive.value(0.0) == 0.0
    # The trapezoidal rule has a relative error of (2 pi 1 us / 80 us)^2 / 12.
    np.testing.assert_allclose(drive.values, expected, atol=6e-4 * expected.max())
    other = write(tmp_path / "speed.csv", 5.0 * speed, head="Time (s),velocity (mm/s)")
    np.testing.assert_allclose(hc.load_drive(other).values, drive.values, rtol=1e-12, atol=1e-20)


def test_the_baseline_is_the_mean_before_the_signal(tmp_path):
    noise = 1e-3 * np.random.default_rng(1).standard_normal(COUNT)
    file = write(tmp_path / "noisy.csv", VOLTS + noise)
    before = TIMES <= -5e-6
    expected = 50.0 * (VOLTS + noise - (VOLTS + noise)[before].mean())
    for baseline in ("-5 us", -5e-6):
        drive = hc.load_drive(file, gain="50 N/V", baseline=baseline)
        np.testing.assert_allclose(drive.values, expected, atol=1e-10)
    assert abs(drive.values[before].mean()) < 1e-12


def test_a_record_that_was_triggered_by_the_blow(tmp_path):
    """Time 0 of the file is 15 us after the beginning of the blow, and noise follows it."""
    times = TIMES - 15e-6
    noise = np.where(times > 40e-6, 2e-5, 0.0)
    file = write(tmp_path / "triggered.csv", VOLTS + noise, times=times)
    given = {"gain": "20 mV/N", "offset": "12 mV"}
    with pytest.warns(hc.InputWarning, match="reaches 77% of its largest value; give start, such"):
        cut = hc.load_drive(file, **given)
    assert cut.times[0] == pytest.approx(times[0])
    drive = hc.load_drive(file, **given, start="-15 us", end="40 us")
    clock = np.linspace(0.0, 55e-6, 56)
    whole = hc.load_drive(write(tmp_path / "scope.csv", VOLTS), **given)
    np.testing.assert_allclose(drive.value(clock), whole.value(clock), atol=1e-9)
    assert drive.end == pytest.approx(55e-6)
    assert drive.values[-1] == 0.0
    assert hc.load_drive(file, **given, start=-15e-6).end == np.inf


def test_a_column_is_chosen_by_name(tmp_path):
    file = write(tmp_path / "two.csv", 0.0 * VOLTS, 1e3 * VOLTS, head="TIME (s),CH1,CH2 (mV)")
    drive = hc.load_drive(file, column="ch2", gain="50 N/V", offset="0.012 V")
    np.testing.assert_allclose(drive.values, FORCE, atol=1e-10)
    assert not hc.load_drive(file, column="CH1 [V]", gain="1 N/V").values.any()


def test_units_of_other_columns_state_what_is_driven(tmp_path):
    file = write(tmp_path / "named.csv", FORCE, head="Time (s),Hammer (kN)")
    drive = hc.load_drive(file, offset="10 N")
    np.testing.assert_allclose(drive.values, 1e3 * FORCE - 10.0, atol=1e-9)
    assert hc.load_drive(write(file, FORCE, head="t (s),LVDT (um)")).of == "displacement"


def test_settings_of_oscilloscopes_are_not_read(tmp_path):
    head = "Model,X1\nSample Interval,1e-06\n\nx-axis,1\nsecond,Volt"
    file = write(tmp_path / "keysight.csv", VOLTS, head=head)
    drive = hc.load_drive(file, gain="20 mV/N", offset="12 mV")
    np.testing.assert_allclose(drive.values, FORCE, atol=1e-10)
    file.write_text(file.read_text().replace(",", ";").replace(".", ","))
    again = hc.load_drive(file, gain="20 mV/N", offset="12 mV")
    np.testing.assert_array_equal(again.values, drive.values)


def test_chain_files_have_the_same_arguments(file, tmp_path):
    text = (
        '[chain]\ndiameters = "10 mm"\nbeads = 5\nmaterials = "steel-52100"\n[chain.drive]\n'
        'kind = "table"\nfile = "scope.csv"\ncolumn = "Volt"\ngain = "20 mV/N"\n'
    )
    chain_file = tmp_path / "row.toml"
    for key, value in (("offset", "12 mV"), ("baseline", "-5 us")):
        chain_file.write_text(f'{text}{key} = "{value}"\n')
        drive = hc.load_chain(chain_file).drive
        expected = hc.load_drive(file, gain="20 mV/N", **{key: value})
        assert drive == expected or np.array_equal(drive.values, expected.values)
        assert drive.of == "force"
    # Chains are written with the values.
    again = hc.chain_from_toml(hc.chain_as_toml(hc.load_chain(chain_file))).drive
    np.testing.assert_array_equal(again.values, drive.values)
    chain_file.write_text(text + "offset = 0.012\n")
    with pytest.raises(hc.InputError, match="offset of .* must be text, got 0.012"):
        hc.load_chain(chain_file)


def test_a_measured_blow_moves_the_beads_as_its_sine_does(file):
    """The reference is the exact sine, of which the file has a sample per microsecond."""
    row = hc.Chain.from_materials(5e-3, "steel-52100", beads=5)
    blow = hc.SineBurst(40.0, 10e3, cycles=0.5, window="none")
    measured = hc.load_drive(file, gain="20 mV/N", offset="12 mV")
    one, other = (
        hc.simulate(row.replace(drive=drive), until=100e-6, times=101) for drive in (blow, measured)
    )
    # Linear interpolation reduces the impulse by (pi / 50)^2 / 12.
    np.testing.assert_allclose(other.velocities, one.velocities, atol=1e-3 * one.velocities.max())


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({}, r"column 'Volt \(V\)' is in V; give the gain of the sensor, such as '50 N/V' or"),
        ({"gain": 50.0}, "gain must be text with a unit, such as '50 N/V'.*got 50.0"),
        ({"gain": "50"}, "gain must be text with a unit, such as '50 N/V'.*got '50'"),
        ({"gain": "50 N"}, "gain must have a unit such as '50 N/V'.*got '50 N'"),
        ({"gain": "50 kg/V"}, "gain must have a unit such as"),
        ({"gain": "50 V/V"}, "gain must have a unit such as"),
        ({"gain": "0 N/V"}, "gain must not be 0, got '0 N/V'"),
        ({"gain": "50 N/V", "offset": 0.012}, "offset must be text with the unit of the signal, "
         "such as '0.1 V', got 0.012"),
        ({"gain": "50 N/V", "offset": "1 N"}, "offset must have the unit of the signal, V or mV, "
         "got '1 N'"),
        ({"gain": "50 N/V", "offset": "1 mV", "baseline": 0.0}, "either offset or baseline, not"),
        ({"gain": "50 N/V", "baseline": "-1 ms"},
         "no sample until baseline = '-1 ms', because the file begins at -40 us"),
        ({"gain": "50 N/V", "baseline": "1 mm"}, "baseline must have a unit such as s, ms"),
        ({"gain": "50 N/V", "column": "Amp"}, r"no column 'Amp'; choose one of Volt \(V\)"),
        ({"gain": "50 N/V", "column": "Volt [mV]"}, r"has the unit V, but is given as 'Volt \[mV"),
        ({"gain": "50 N/V", "end": "-50 us"}, "end must be above 0, got '-50 us'"),
        ({"gain": "0.1 mm/V", "end": "50 us"}, "end is the end of a force, but the drive is a dis"),
        ({"gain": "50 N/V", "start": "1 V"}, "unknown unit of start 'V': choose from s, ms"),
        ({"gain": "50 N/V", "column": 2}, "column of a drive must be text, got 2"),
    ],
)  # fmt: skip
def test_wrong_arguments_are_rejected(file, arguments, words):
    with pytest.raises(hc.InputError, match=rf"scope.csv: .*{words}"):
        hc.load_drive(file, **arguments)


@pytest.mark.parametrize(
    ("text", "arguments", "words"),
    [
        ("Time (s),Volt\n0,0\n1,1\n", {"gain": "1 N/V"},
         r"column 'Volt' has no unit; write Volt \[V\], in the file or as column = 'Volt \[V\]'"),
        ("Time,force [N]\n0,0\n1,1\n", {}, r"'time' has no unit, but 'force \[N\]' has one"),
        ("Time (s),force\n0,0\n1,1\n", {}, r"'force' has no unit; write force \[N\]"),
        ("Time (s),force [N]\n0,0\n1,1\n", {"gain": "2 N/V"},
         r"has the unit N, but gain = '2 N/V' is for signals in V; omit it"),
        ("time,force\n0,0\n1,1\n", {"gain": "2 N/V"}, "is in scaled variables, but gain"),
        ("time,force\n0,0\n1,1\n", {"offset": "2 N"}, "has no unit, so offset cannot be given"),
        ("time,force\n0,0\n1,1\n", {"baseline": "2 us"}, "baseline"),
        ("Time (s),force [mm]\n0,0\n1,1\n", {}, "column 'force' must have a unit such as N"),
        ("Time (s),area [mm^2]\n0,0\n1,1\n", {}, "a unit of force, displacement or velocity, or V"),
        ("Time (s),A (V),B (V)\n0,0,1\n1,1,1\n", {"gain": "1 N/V"}, r"column = 'A \(V\)'"),
        ("Time (s),A (V),A (V)\n0,0,1\n1,1,1\n", {"gain": "1 N/V", "column": "A"},
         "the file has 2 columns 'A'"),
        ("Time (s),Volt (V)\n0,0\n1,\n", {"gain": "1 N/V"}, "in line 3 is missing; a drive"),
        ("Time (s),Volt (V)\n0,0\n1,9.9e37\n", {"gain": "1 N/V"}, "line 3 is beyond the range"),
        ("Time (s),Volt (V)\n0,0\n1,a\n", {"gain": "1 N/V"}, "is 'a' in line 3"),
        ("Time (s),Volt (V)\n0,0\n1\n", {"gain": "1 N/V"}, "line 3 has 1 cell"),
        ("Time (s),speed (mm/s)\n0,0\n0,1\n", {}, "times of a drive must increase"),
        ("A (V),B (V)\n0,0\n1,1\n", {"gain": "1 N/V"}, "one column of times"),
    ],
)  # fmt: skip
def test_wrong_files_are_rejected(tmp_path, text, arguments, words):
    (tmp_path / "bad.csv").write_text(text)
    with pytest.raises(hc.InputError, match=rf"bad.csv: .*{words}") as caught:
        hc.load_drive(tmp_path / "bad.csv", **arguments)
    assert "\n" not in str(caught.value)


def test_a_scaled_drive_may_have_a_baseline(tmp_path):
    file = write(tmp_path / "scaled.csv", 2.0 + FORCE, head="time,force")
    np.testing.assert_allclose(hc.load_drive(file, baseline=0.0).values, FORCE, atol=1e-12)


def test_the_sign_and_the_offset_of_a_force_are_checked(tmp_path):
    times = np.arange(-20.0, 80.0, 2.0) * 1e-6
    rng = np.random.default_rng(3)
    blow = 60.0 * np.sin(np.pi * np.clip(times, 0.0, 40e-6) / 40e-6)
    noisy = blow + rng.normal(0.0, 0.05, len(times))

    def load(force, **options):
        rows = [f"{1e6 * t:.6f},{f:.9f}" for t, f in zip(times, force, strict=True)]
        path = tmp_path / "hammer.csv"
        path.write_text("\n".join(["time [us],force [N]", *rows]) + "\n")
        return hc.load_drive(path, start="-20 us", **options)

    load(noisy)  # without a warning
    with pytest.warns(hc.InputWarning, match="before the blow, the force is 1.8 N: .*baseline"):
        load(noisy + 1.8)
    load(noisy + 1.8, baseline="-4 us")
    with pytest.warns(hc.InputWarning, match="the force reaches -6.* check its sign"):
        load(-noisy)

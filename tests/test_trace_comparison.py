"""Comparison of runs with traces; the data are from SciPy."""

import re
import warnings
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy_row import BEFORE, FACTOR, LOSS_TIME, RADIUS, SPACING, VELOCITY, chain, forces

import hertzchain as hc
from hertzchain.fitting.advice import level_advice
from hertzchain.fitting.comparison_notes import level_notes
from hertzchain.fitting.model import make_model
from hertzchain.fitting.names import Name
from hertzchain.fitting.simulations import Simulator
from hertzchain.traces.missing_rows import gap_notes, gaps_between

pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
NOISE = 0.05
END = BEFORE * SPACING


def traces(names=("ball 5", "wall"), time=1.0, factor=1.0, unit="N"):
    """Data of SciPy with noise; times and forces may be multiplied."""
    rng, found = np.random.default_rng(7), {}
    for name in names:
        seen = np.concatenate((np.zeros(BEFORE), forces()[name]))
        found[f"{name} [{unit}]"] = factor * (seen + NOISE * rng.standard_normal(len(seen)))
    return hc.Traces.from_arrays(time * SPACING * np.arange(len(seen)), found)


def simulated(until=None, **fields):
    return hc.simulate(chain(**fields), until=until, times=3000)


def true_chain():
    """The chain of the data."""
    row = hc.Chain.from_materials(RADIUS, "steel-52100", beads=15).struck_by(velocity=VELOCITY)
    row = row.replace(right_wall=hc.Wall.of("steel-304"), loss=hc.Viscoelastic(LOSS_TIME))
    wall = hc.Wall(FACTOR * row.wall_stiffness[1])
    return row.replace(stiffness=FACTOR * row.stiffness, right_wall=wall)


def test_peaks_and_arrivals_of_the_true_chain_agree_with_the_data():
    data = traces()
    compared = hc.simulate(true_chain(), until=7e-4, times=6000).compare(data, time_offset=END)
    for sensor in compared.sensors:
        force = forces()[sensor.name]
        first = int(np.argmax(force > 0.5 * force.max()))
        arrival = END + SPACING * np.interp(
            0.5 * force.max(), force[first - 1 : first + 1], [first - 1, first]
        )
        # The data have noise, the run only errors of interpolation.
        assert sensor.simulated_peak == pytest.approx(force.max(), rel=1e-3)
        assert sensor.measured_peak == pytest.approx(force.max(), abs=4 * NOISE)
        # Half of the crest between two samples is reached 3 ns later than that of the largest one.
        assert sensor.simulated_arrival == pytest.approx(arrival, abs=5e-9)
        assert sensor.delay == pytest.approx(0.0, abs=0.2 * SPACING)
        assert sensor.residual == pytest.approx(NOISE / force.max(), rel=0.1)
    assert compared.covered == 1.0
    assert compared.notes == ()


@pytest.mark.parametrize("first", [0, 3, 6])
def test_coarse_samples_do_not_change_the_ratio_of_peaks(first):
    seen = np.concatenate((np.zeros(BEFORE), forces()["wall"]))[first::9]
    times = SPACING * np.arange(first, first + 9 * len(seen), 9)
    data = hc.Traces.from_arrays(times, {"wall [N]": seen}, noise=1e-3)
    run = hc.simulate(true_chain(), until=7e-4, times=6000)
    (wall,) = run.compare(data, time_offset=END).sensors
    assert wall.measured_peak < 0.999 * forces()["wall"].max()
    assert wall.peak_ratio == pytest.approx(1.0, abs=2e-4)


def cut(data, end, factors=None):
    """The data up to a time; signals may be multiplied, and are then in V."""
    keep = data.shots[0].times <= end
    columns, factors = {}, factors or {}
    for signal in data.shots[0].signals:
        unit = "V" if signal.name in factors else "N"
        columns[f"{signal.name} [{unit}]"] = factors.get(signal.name, 1.0) * signal.values[keep]
    return hc.Traces.from_arrays(data.shots[0].times[keep], columns)


def offset_error(names):
    """Least standard deviation of a time offset (Cramer and Rao): noise over the norm of slopes."""
    slopes = np.concatenate([np.gradient(forces()[name], SPACING) for name in names])
    return NOISE / np.linalg.norm(slopes)


@pytest.mark.parametrize("given", [None, END])
def test_the_time_offset_does_not_depend_on_the_first_saved_time(given):
    run = hc.simulate(true_chain(), times=np.linspace(20e-6, 7e-4, 6000))
    found = run.compare(traces(), time_offset=given)
    assert found.time_offset == pytest.approx(END, abs=4.0 * offset_error(("ball 5", "wall")))
    for sensor in found.sensors:
        assert sensor.residual == pytest.approx(NOISE / forces()[sensor.name].max(), rel=0.1)
    assert found.notes == ()


def test_a_sensor_without_a_pulse_does_not_prevent_the_comparison():
    traces, file = hc.example_experiment()
    run = hc.simulate(hc.load_chain(file), until=600e-6, times=1201)
    (shot,) = traces.shots
    columns = {f"{each.name} [{each.unit}]": each.values for each in shot.signals}
    noise = np.random.default_rng(3).normal(0.0, shot.signals[0].sigma, len(shot.times))
    first = next(iter(columns))
    dead = hc.Traces.from_arrays(shot.times, columns | {first: noise})
    with pytest.warns(hc.InputWarning, match="have no pulse above their noise"):
        found = run.compare(dead)
    del columns[first]
    others = run.compare(hc.Traces.from_arrays(shot.times, columns))
    assert found.time_offset == pytest.approx(others.time_offset, abs=1e-9)
    assert [each.residual for each in found.sensors[1:]] == pytest.approx(
        [each.residual for each in others.sensors], rel=1e-3
    )
    # Its gain is not doubted besides.
    assert not any(shot.signals[0].name in note and "gain" in note for note in found.notes)


@pytest.mark.parametrize("names", [("ball 5",), ("ball 5", "ball 10", "wall")])
@pytest.mark.parametrize("until", [7e-4, 4e-4])
def test_the_time_offset_is_that_of_the_data(names, until):
    run = hc.simulate(true_chain(), until=until, times=int(until / 1e-7))
    found = run.compare(traces(names)).time_offset
    assert found == pytest.approx(END, abs=4.0 * offset_error(names))


@pytest.mark.parametrize("factors", [None, {"ball 5": -0.02}, {"ball 5": 0.02, "wall": -0.03}])
@pytest.mark.parametrize("after", [-8e-6, -4e-6, 0.0, 4e-6, 12e-6, 60e-6])
def test_records_that_end_within_a_pulse_have_the_same_time_offset(after, factors):
    data = traces(("ball 5", "ball 10", "wall"))
    crest = END + SPACING * int(np.argmax(forces()["wall"]))
    run = hc.simulate(true_chain(), until=7e-4, times=6000)
    found = run.compare(cut(data, crest + after, factors=factors))
    # Those of the pulses in the balls, which are whole.
    error = offset_error(("ball 5", "ball 10"))
    assert found.time_offset == pytest.approx(END, abs=4.0 * error)
    assert found.sensors[1].residual == pytest.approx(NOISE / forces()["ball 10"].max(), rel=0.1)


@pytest.mark.parametrize("after", [-4e-6, 0.0, 8e-6])
def test_one_sensor_whose_pulse_is_cut_determines_the_time_offset(after):
    # Only the flank is known: its time and its amplitude are nearly degenerate.
    crest = END + SPACING * int(np.argmax(forces()["wall"]))
    run = hc.simulate(true_chain(), until=7e-4, times=6000)
    found = run.compare(cut(traces(["wall"]), crest + after))
    assert found.time_offset == pytest.approx(END, abs=1e-7)


@pytest.mark.parametrize("after", [-8e-6, -4e-6, 4e-6, 12e-6])
def test_runs_that_end_within_a_pulse_have_the_same_time_offset(after):
    until = SPACING * int(np.argmax(forces()["wall"])) + after
    run = hc.simulate(true_chain(), until=until, times=4000)
    found = run.compare(traces(("ball 5", "ball 10", "wall")))
    error = offset_error(("ball 5", "ball 10"))
    assert found.time_offset == pytest.approx(END, abs=4.0 * error)


def test_the_time_offset_of_precompressed_chains_does_not_depend_on_the_coupling():
    row = true_chain().replace(precompression=20.0, held_by="force")
    run = hc.simulate(row, until=6e-4, times=6000)
    rng = np.random.default_rng(3)
    times = np.arange(-60e-6, 330e-6, 0.5e-6)
    found = []
    for static in (0.0, 20.0):
        columns = {}
        for name in ("ball 5", "ball 10"):
            seen = np.interp(times - 20e-6, run.times, run.sensor(name)) - static
            columns[f"{name} [N]"] = seen + NOISE * rng.standard_normal(len(times))
        found.append(run.compare(hc.Traces.from_arrays(times, columns)).time_offset)
    assert found == pytest.approx([20e-6, 20e-6], abs=2e-8)


def test_the_summary_states_peaks_arrivals_and_the_compared_interval():
    data = traces()
    compared = simulated(7e-4).compare(data)
    lines = compared.summary(width=None).splitlines()
    last = 1e6 * data.shots[0].times[-1]
    assert lines[0].startswith(f"data from 0 s to {last:.4g} us, 100% of the record; time")
    assert "by least squares" in lines[0]
    row = next(line for line in lines if line.startswith("  wall"))
    sensor = compared.sensors[1]
    assert row.split()[1:4] == [f"{sensor.measured_peak:.4g}", "N", f"{sensor.simulated_peak:.4g}"]
    assert f"{sensor.simulated_peak / sensor.measured_peak - 1:+.1%}" in row
    assert f"{1e6 * (sensor.simulated_arrival - sensor.measured_arrival):+.2f} us" in row
    assert str(compared) == compared.summary()


@pytest.mark.parametrize("until", [2e-4, 1e-4])
def test_runs_that_end_before_the_pulse_arrives_are_rejected(until):
    with pytest.raises(hc.InputError, match=r"does not arrive at wall.*simulate for longer"):
        simulated(until).compare(traces(["wall"]))


def test_runs_that_end_before_the_measured_pulse_are_rejected():
    with pytest.raises(hc.InputError, match="the largest signal of wall is at"):
        simulated(5e-4).compare(traces(["wall"]), time_offset=-3e-4)


@pytest.mark.parametrize(("offset", "words"), [(1.0, "begins after the last sample"),
                                              (7e-4, "the simulated pulse reaches")])  # fmt: skip
def test_runs_that_begin_too_late_are_rejected(offset, words):
    with pytest.raises(hc.InputError, match=words):
        simulated(7e-4).compare(traces(["wall"]), time_offset=offset)


@pytest.mark.parametrize("factor", [1e3, 1e-3, 1e6])
def test_times_in_another_unit_are_rejected(factor):
    with pytest.raises(hc.InputError, match="check the unit of the times"):
        simulated(7e-4).compare(traces(["wall"], time=factor))


@pytest.mark.parametrize("factor", [1e3, 1e-3])
def test_peaks_in_another_unit_are_noted(factor):
    with pytest.warns(hc.InputWarning, match="check the unit in the header"):
        compared = simulated(7e-4).compare(traces(["wall"], factor=factor))
    assert "check the unit in the header" in compared.summary(width=None)
    # The residual is relative to the measured peak, which is 1000 times larger or smaller.
    rest = compared.sensors[0].residual
    assert 0.01 < rest < 0.5 if factor > 1.0 else 10.0 < rest < 500.0


def test_opposite_signs_are_noted():
    with pytest.warns(hc.InputWarning, match="check the polarity"):
        simulated(7e-4).compare(traces(["wall"], factor=-1.0), time_offset=END)


def test_opposite_signs_do_not_change_the_time_offset():
    right = simulated(7e-4).compare(traces(["ball 5", "wall"]))
    with pytest.warns(hc.InputWarning, match="polarity of the sensor and of its amplifier"):
        turned = simulated(7e-4).compare(traces(["ball 5", "wall"], factor=-1.0))
    assert turned.time_offset == pytest.approx(right.time_offset, abs=SPACING)
    assert [each.measured_peak for each in turned.sensors] == pytest.approx(
        [-each.measured_peak for each in right.sensors]
    )


@pytest.mark.filterwarnings("ignore::hertzchain.errors.InputWarning")
def test_times_in_another_unit_are_rejected_if_the_pulse_is_not_resolved():
    # The saved times of this run are 0.4 ms apart, the pulse lasts 40 us.
    slow = traces(["wall"], time=1e3)
    with pytest.raises(hc.InputError, match="check the unit of the times"):
        simulated(float(np.ptp(slow.shots[0].times))).compare(slow)


def test_long_times_do_not_run_together():
    sensor = simulated(7e-4).compare(traces(["wall"])).sensors[0]
    row = replace(sensor, measured_arrival=0.19882294, simulated_arrival=0.30826286).row
    rest = f"{100 * sensor.residual:.1f}"
    assert row.split("%")[1].split() == ["198.82", "ms", "308.26", "ms", "+109.44", "ms", rest]


def test_a_run_that_ends_before_the_record_says_so():
    data = traces(["wall"])
    record = data.shots[0].times[-1]
    with warnings.catch_warnings():
        warnings.simplefilter("error", hc.InputWarning)
        compared = simulated(4.5e-4).compare(data)
    assert compared.interval[1] == pytest.approx(compared.time_offset + 4.5e-4, abs=SPACING)
    assert compared.covered == pytest.approx(compared.interval[1] / record)
    (note,) = (each for each in compared.notes if "before the record" in each)
    until = float(re.search(r"until='([0-9.]+) us'", note)[1]) * 1e-6
    whole = simulated(1.001 * until).compare(data, time_offset=compared.time_offset)
    assert whole.covered == 1.0
    assert not whole.notes


def test_incomplete_peaks_are_noted():
    arrival = simulated(7e-4).compare(traces(["wall"])).sensors[0].simulated_arrival
    compared = simulated(arrival - END).compare(traces(["wall"]))
    assert any("peak of wall is not complete" in each for each in compared.notes)


def test_data_without_a_pulse_are_noted():
    rng = np.random.default_rng(1)
    noise = NOISE * rng.standard_normal(1000)
    data = hc.Traces.from_arrays(0.7e-6 * np.arange(1000), {"wall [N]": noise}, noise=NOISE)
    with pytest.warns(hc.InputWarning, match="the data of wall have no pulse above their noise"):
        compared = simulated(7e-4).compare(data)
    assert "no pulse above their noise" in compared.summary(width=None)
    # Noise determines the peak and the arrival.
    (sensor,) = compared.sensors
    assert sensor.silent
    assert sensor.cells[0] == "no pulse"
    assert "errors of measured" not in compared.summary(width=None)
    assert "the simulated pulse of" not in compared.summary(width=None)


@pytest.mark.parametrize("limit", [30.0, 45.0])
def test_saturated_signals_are_noted_and_compared_at_the_same_height(limit):
    times, columns = traces().shots[0].times, {}
    for signal in traces().shots[0].signals:
        columns[f"{signal.name} [N]"] = signal.values
    columns["wall [N]"] = np.minimum(columns["wall [N]"], limit)
    data = hc.Traces.from_arrays(times, columns)
    compared = hc.simulate(true_chain(), until=7e-4, times=6000).compare(data, time_offset=END)
    ball, wall = compared.sensors
    assert (ball.saturated, wall.saturated) == (False, True)
    assert wall.measured_peak == pytest.approx(limit, abs=4 * NOISE)
    # The simulated peak is that of the whole pulse, including the samples that are missing.
    assert wall.simulated_peak == pytest.approx(forces()["wall"].max(), rel=1e-3)
    assert wall.delay == pytest.approx(0.0, abs=0.2 * SPACING)
    assert wall.residual == pytest.approx(NOISE / limit, rel=0.1)
    row = next(line for line in str(compared).splitlines() if line.startswith("  wall"))
    assert row.split()[1] == f">{wall.measured_peak:.4g}"
    assert row.split()[5] == "saturated"
    (note,) = compared.notes
    assert note.startswith("wall is saturated at ")
    # A simulation that does not reach half of the measured peak has no arrival.
    gentle = chain().replace(velocities=0.2 * chain().velocities)
    slow = hc.simulate(gentle, until=1.5e-3, times=6000)
    with pytest.warns(hc.InputWarning, match="times the measured one"):
        weak = slow.compare(data)
    assert "nan" not in str(weak)
    assert np.isnan(weak.sensors[1].delay)


def with_gap(value, begin, end):
    """The data of two sensors; samples of the wall have another value between two times."""
    (shot,) = traces().shots
    columns = {f"{signal.name} [N]": signal.values.copy() for signal in shot.signals}
    gap = (shot.times > begin) & (shot.times < end)
    columns["wall [N]"][gap] = value
    return hc.Traces.from_arrays(shot.times, columns), columns["wall [N]"][~gap].max()


CREST = END + SPACING * int(np.argmax(forces()["wall"]))


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize(("before", "after"), [(4e-6, 4e-6), (3e-6, 10e-6), (10e-6, 3e-6)])
def test_peaks_without_a_crest_are_lower_bounds(value, before, after):
    run = hc.simulate(true_chain(), until=7e-4, times=6000)
    data, largest = with_gap(value, CREST - before, CREST + after)
    compared = run.compare(data, time_offset=END)
    ball, wall = compared.sensors
    assert (ball.lower_bound, wall.lower_bound) == (False, True)
    assert (wall.saturated, wall.crest_missing) == (np.isinf(value), np.isnan(value))
    assert wall.measured_peak == pytest.approx(largest, abs=4 * NOISE)
    assert wall.measured_peak < 0.99 * forces()["wall"].max()
    # The simulated peak is that of the whole pulse, and both arrive at the same height.
    assert wall.simulated_peak == pytest.approx(forces()["wall"].max(), rel=1e-3)
    assert wall.delay == pytest.approx(0.0, abs=0.2 * SPACING)
    row = next(line for line in str(compared).splitlines() if line.startswith("  wall"))
    assert row.split()[1] == f">{wall.measured_peak:.4g}"
    assert ("saturated" if np.isinf(value) else "no crest") in row
    *count, note = compared.notes
    assert len(count) == np.isnan(value)
    words = "is saturated at" if np.isinf(value) else "samples of wall are missing at its crest"
    assert words in note
    assert f"{wall.measured_peak:.4g} N" in note


@pytest.mark.parametrize(
    ("begin", "end"), [(-0.6e-6, 0.6e-6), (-25e-6, -12e-6), (12e-6, 25e-6), (-300e-6, -200e-6)]
)
def test_missing_samples_beside_a_crest_do_not_change_the_peak(begin, end):
    run = hc.simulate(true_chain(), until=7e-4, times=6000)
    data, _ = with_gap(np.nan, CREST + begin, CREST + end)
    compared = run.compare(data, time_offset=END)
    assert not compared.sensors[1].lower_bound
    assert compared.sensors[1].measured_peak == pytest.approx(forces()["wall"].max(), rel=0.01)
    # The second of the gaps contains the arrival.
    count, *others = compared.notes
    missing = int(np.isnan(data.shots[0].signals[1].values).sum())
    words = "1 sample of wall is" if missing == 1 else f"{missing} samples of wall are"
    assert count == f"{words} missing and not used"
    assert len(others) == np.isnan(compared.sensors[1].measured_arrival) == (begin == -25e-6)


def test_an_arrival_among_missing_samples_is_not_known():
    run = hc.simulate(true_chain(), until=7e-4, times=6000)
    complete = run.compare(traces(), time_offset=END).sensors[1]
    arrival = complete.measured_arrival
    for length, known in ((1.6 * SPACING, True), (12e-6, False)):
        gap = arrival - 0.5 * length, arrival + 0.5 * length
        compared = run.compare(with_gap(np.nan, *gap)[0], time_offset=END)
        wall = compared.sensors[1]
        # The level before the pulse is the mean of another number of samples.
        assert wall.measured_peak == pytest.approx(complete.measured_peak, abs=wall.peak_error)
        assert np.isfinite(wall.measured_arrival) == known
        assert ("its arrival is not known" in compared.summary(width=None)) != known
        if known:
            assert wall.measured_arrival == pytest.approx(arrival, abs=SPACING)


def without_rows(data, begin, end):
    """The data without the rows between two times, and the number of these rows."""
    (shot,) = data.shots
    gap = (shot.times > begin) & (shot.times < end)
    columns = {f"{signal.name} [N]": signal.values[~gap] for signal in shot.signals}
    return hc.Traces.from_arrays(shot.times[~gap], columns), int(gap.sum())


def numbers(compared):
    return [
        (each.measured_peak, each.simulated_peak, each.measured_arrival, each.simulated_arrival,
         each.residual)
        for each in compared.sensors
    ]  # fmt: skip


@pytest.mark.parametrize("gap", [(-10e-6, 5e-6), (-25e-6, -12e-6), (-300e-6, -200e-6)])
def test_missing_rows_are_missing_samples(gap):
    run = hc.simulate(true_chain(), until=7e-4, times=6000)
    begin, end = CREST + gap[0], CREST + gap[1]
    data, rows = without_rows(traces(), begin, end)
    (shot,) = traces().shots
    inside = (shot.times > begin) & (shot.times < end)
    cells = hc.Traces.from_arrays(
        shot.times,
        {f"{each.name} [N]": np.where(inside, np.nan, each.values) for each in shot.signals},
    )
    compared, expected = (run.compare(each, time_offset=END) for each in (data, cells))
    # The levels before the pulse are the means of slightly different samples.
    np.testing.assert_allclose(numbers(compared), numbers(expected), rtol=1e-4)
    wall = compared.sensors[1]
    assert wall.lower_bound == (gap == (-10e-6, 5e-6))
    assert np.isnan(wall.measured_arrival) == (gap == (-25e-6, -12e-6))
    note, *others = compared.notes
    first, last = (1e6 * each for each in shot.times[inside][[0, -1]])
    assert note == f"{rows} rows of the data are missing from {first:.6g} us to {last:.6g} us"
    counts = [f"{rows} samples of {name} are missing and not used" for name in ("ball 5", "wall")]
    assert [*counts, *others] == [*expected.notes]
    assert data.notes() == (note.replace("missing", "missing in shot 1"),)


def test_gaps_in_uneven_records_are_not_missing_rows():
    times = np.cumsum(np.random.default_rng(1).uniform(0.5, 2.5, 200)) * 1e-6
    slow = np.concatenate((np.arange(0.0, 100.0, 10.0), np.arange(100.0, 110.0)))
    for each in (times, 1e-6 * slow):
        assert gaps_between(each) == []
    some = np.delete(np.arange(400), [5, 100, 101, 200, 300])
    assert [gap.rows for gap in gaps_between(1e-6 * some)] == [1, 2, 1, 1]
    assert gap_notes(gaps_between(1e-6 * some)) == [
        "5 rows of the data are missing at 5 us, from 100 us to 101 us, at 200 us and in 1 further "
        "gap"
    ]


def test_the_peak_of_data_that_end_before_the_crest_is_a_lower_bound():
    run = hc.simulate(true_chain(), until=7e-4, times=6000)
    compared = run.compare(cut(traces(), CREST - 6e-6), time_offset=END)
    assert [each.crest_missing for each in compared.sensors] == [False, True]
    assert "the data end before it" in compared.notes[-1]


@pytest.mark.parametrize(("first", "second"), [("ball 5", "wall"), ("ball 5", "ball 10")])
def test_arrivals_in_another_order_are_noted(first, second):
    data = traces((first, second))
    one, two = data.shots[0].signals
    turned = {f"{first} [N]": two.values, f"{second} [N]": one.values}
    turned = hc.Traces.from_arrays(data.shots[0].times, turned)
    run = simulated(7e-4)
    words = f"with the columns of {first} and {second} exchanged, the rms difference falls to"
    with pytest.warns(hc.InputWarning, match=words):
        compared = run.compare(turned)
    statement, head, *rest = compared.summary(width=None).splitlines()
    assert statement.startswith(words)
    assert "check the names of these columns" in statement
    assert head.startswith("data from ")
    assert not any("exchanged" in line for line in rest)
    html = compared._repr_html_()
    assert html.index("check the names of these columns") < html.index("<svg")
    assert html.count("check the names of these columns") == 1
    assert not any("before" in each for each in run.compare(data).notes)


def from_later(begin, names, noise=NOISE):
    """The data of SciPy that begin this time after the impact, after 40 us without any signal."""
    rng, count = np.random.default_rng(5), round(40e-6 / SPACING)
    first = round(begin / SPACING)
    columns = {}
    for name in names:
        seen = np.concatenate((np.zeros(count), forces()[name][first:]))
        columns[f"{name} [N]"] = seen + noise * rng.standard_normal(len(seen))
    return hc.Traces.from_arrays(SPACING * (np.arange(len(seen)) + first - count), columns)


@pytest.mark.parametrize("name", ["ball 5", "ball 10"])
def test_records_that_begin_after_the_first_pulse_say_that_later_ones_are_compared(name):

    run = simulated(7e-4)
    words = f"first pulse arrives at {name} before the record begins, and later pulses"
    with pytest.warns(hc.InputWarning, match=words):
        compared = run.compare(from_later(3e-4, [name]))
    assert compared.time_offset == pytest.approx(0.0, abs=20e-6)
    assert "the simulated pulse of" not in str(compared)


@pytest.mark.parametrize(
    ("part", "noted"), [(0.001, False), (0.05, True), (0.5, True), (1.0, True)]
)
def test_a_record_that_begins_during_a_pulse_says_so(part, noted):
    crest = int(np.argmax(forces()["ball 5"]))
    first = int(np.argmax(forces()["ball 5"] >= part * forces()["ball 5"][: crest + 1].max()))
    rng, seen = np.random.default_rng(6), {}
    for name in ("ball 5", "ball 10"):
        own = forces()[name][first:]
        seen[f"{name} [N]"] = own + NOISE * rng.standard_normal(len(own))
    data = hc.Traces.from_arrays(SPACING * np.arange(len(own)), seen, noise=NOISE)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hc.InputWarning)
        notes = simulated(7e-4).compare(data).notes
    words = "the record begins during the first simulated pulse at ball 5, so the level"
    assert any(each.startswith(words) for each in notes) == noted
    assert not any("before the record begins" in each for each in notes)


def test_a_reflected_pulse_in_another_order_is_noted():
    words = "the measured pulse arrives at ball 10 .* before ball 5, .* whether the record begins"
    with pytest.warns(hc.InputWarning, match=words):
        simulated(7e-4).compare(from_later(3.3e-4, ["ball 5", "ball 10"]))


@pytest.mark.parametrize("first_saved", [0.0, 20e-6])
def test_another_time_offset_that_agrees_almost_as_well_is_noted(first_saved):
    # Without losses, both pulses in the ball have nearly the same height; the short run contains
    # only the first one.
    row = hc.Chain.from_materials(RADIUS, "steel-52100", beads=15).struck_by(velocity=VELOCITY)
    row = row.replace(right_wall=hc.Wall.of("steel-52100"))
    run = hc.simulate(row, until=7e-4, times=6000)
    rng = np.random.default_rng(4)
    times = SPACING * np.arange(-80, 1000)
    seen = np.interp(times, run.times, run.sensor("ball 5"))
    seen += NOISE * rng.standard_normal(len(times))
    data = hc.Traces.from_arrays(times, {"ball 5 [N]": seen})
    short = hc.simulate(row, times=np.linspace(first_saved, 3e-4, 3000))
    with pytest.warns(hc.InputWarning, match="with a time offset of about .* larger: a reflected"):
        compared = short.compare(data)
    (note,) = (each for each in compared.notes if "a reflected pulse may be" in each)
    other = float(re.search(r"about (-?[0-9.]+) us", note)[1]) * 1e-6
    first, second = sorted((compared.time_offset, other))
    assert first == pytest.approx(0.0, abs=2e-6)

    near = run.times > 4e-4
    later = run.times[near][np.argmax(run.sensor("ball 5")[near])]
    sooner = run.times[~near][np.argmax(run.sensor("ball 5")[~near])]
    assert second == pytest.approx(later - sooner, abs=5e-6)
    # The whole run decides.
    assert not any("reflected" in each for each in run.compare(data).notes)


@pytest.mark.parametrize("late", [30e-6, -30e-6])
def test_a_given_time_offset_that_makes_all_arrivals_late_is_noted(late):
    run, data = simulated(7e-4), traces(("ball 5", "ball 10", "wall"))
    words = f"arrivals are .* us {'late' if late > 0.0 else 'early'}: check the given time offset"
    with pytest.warns(hc.InputWarning, match=words):
        run.compare(data, time_offset=END + late)
    assert not any("arrivals are" in each for each in run.compare(data, time_offset=END).notes)


def test_simulated_pulses_outside_the_record_are_noted():
    run = simulated(7e-4)
    with pytest.warns(hc.InputWarning, match="the simulated pulse of wall is not in the record"):
        compared = run.compare(traces(["wall"]), time_offset=4.75e-4)
    assert not any("times the measured one" in each for each in compared.notes)


@pytest.mark.parametrize("factor", [0.0195, 0.2, 5.0, 300.0])
def test_a_column_in_a_wrong_unit_is_aligned(factor):
    data = traces(("ball 5", "ball 10", "wall"))
    right = simulated(7e-4).compare(data)
    wrong = {
        f"{signal.name} [N]": signal.values * (factor if signal.name == "wall" else 1.0)
        for signal in data.shots[0].signals
    }
    with pytest.warns(hc.InputWarning, match="the simulated peak of wall is"):
        found = simulated(7e-4).compare(hc.Traces.from_arrays(data.shots[0].times, wrong))
    assert found.time_offset == pytest.approx(right.time_offset, abs=0.1 * SPACING)
    expected = right.sensors[2].peak_ratio / factor
    assert f"the simulated peak of wall is {expected:.3g} times" in found.notes[0]


def test_the_level_before_the_pulse_does_not_change_a_comparison():
    def compared(level):
        pairs = zip(("ball 5 [V]", "wall [N]"), traces().shots[0].signals, (0.0125, 1), strict=True)
        columns = {
            name: factor * (signal.values + level) for name, signal, factor in pairs
        }  # fmt: skip
        return simulated(7e-4).compare(hc.Traces.from_arrays(traces().shots[0].times, columns))

    plain, shifted = compared(0.0), compared(4.0)
    for one, two in zip(plain.sensors, shifted.sensors, strict=True):
        assert two.scale == pytest.approx(one.scale, rel=1e-9)
        assert two.simulated_peak == pytest.approx(one.simulated_peak, rel=1e-9)
    assert shifted.sensors[0].residual == pytest.approx(plain.sensors[0].residual, rel=1e-9)
    np.testing.assert_allclose(shifted.scaled[0] - plain.scaled[0], 0.0125 * 4.0, rtol=1e-9)
    volts, newtons = (each for each in shifted.notes if "before the pulse" in each)
    assert "before the pulse, ball 5 is at 49.9 mV; the comparison is without this" in volts
    assert "in a fit, free 'offset[ball 5]'" in volts
    assert "before the pulse, wall is at 4 N, the simulation at 0 N" in newtons
    columns = {
        f"{each.name} [V]": 0.01 * each.values + level
        for each, level in zip(traces().shots[0].signals, (0.05, -0.02), strict=True)
    }
    both = simulated(7e-4).compare(hc.Traces.from_arrays(traces().shots[0].times, columns)).notes
    (said,) = (each for each in both if "before the pulse" in each)
    assert "and wall at -20 mV; the comparison is without these levels" in said
    assert said.endswith("in a fit, free 'offset[*]'")
    assert not any("before the pulse" in each for each in plain.notes)


def fitted_to(data, model):
    """A fit as far as the advice on levels depends on it."""
    names = SimpleNamespace(names=())
    rest = [[float(model[0])]]
    return SimpleNamespace(predicted=[[model]], at_rest=rest, traces=data, model=names)


@pytest.mark.parametrize(("zero", "noted"), [(0.0, False), (3.0, True)])
def test_zeros_of_rounded_samples_are_checked_with_the_error_of_rounding(zero, noted):
    times, static = 1e-6 * np.arange(600), 10.3
    model = static + 60.0 * np.exp(-(((times - 400e-6) / 20e-6) ** 2))
    noise = 0.02 * np.random.default_rng(1).standard_normal(len(times))
    data = hc.Traces.from_arrays(times, {"wall [N]": np.round(model + zero + noise)}, coupling="DC")
    fitted = fitted_to(data, model)
    # Without noise, all 300 samples before the pulse are rounded to 10 N.
    for notes in (level_notes(data.shots[0], [model], [model]), level_advice(fitted)):
        assert bool(notes) == noted


@pytest.mark.parametrize(("zero", "noted"), [(0.0, False), (3.0, True)])
def test_an_early_simulated_pulse_does_not_cast_doubt_on_zeros(zero, noted):
    times, static = 1e-6 * np.arange(600), 10.0
    measured, model = (
        static + 60.0 * np.exp(-(((times - at) / 20e-6) ** 2)) for at in (400e-6, 200e-6)
    )
    noise = 0.02 * np.random.default_rng(1).standard_normal(len(times))
    data = hc.Traces.from_arrays(times, {"wall [N]": measured + zero + noise}, coupling="DC")
    for notes in (
        level_notes(data.shots[0], [model], [model]),
        level_advice(fitted_to(data, model)),
    ):
        assert bool(notes) == noted


def test_zeros_are_not_doubted_if_the_unit_of_the_times_is_wrong():
    shot = traces(("ball 5", "wall")).shots[0]
    columns = {f"{signal.name} [N]": signal.values for signal in shot.signals}
    with pytest.warns(hc.InputWarning, match="check the unit of the times"):
        found = simulated(7e-4).compare(hc.Traces.from_arrays(0.6 * shot.times, columns))
    assert not any("before the pulse" in each for each in found.notes)


@pytest.mark.parametrize("coupling", ["AC", "DC"])
def test_the_level_of_a_model_at_rest_contains_the_static_force(coupling):
    pressed = chain(precompression=3.0, held_by="force")
    times = SPACING * np.arange(500)
    column = np.random.default_rng(0).standard_normal(len(times))
    data = hc.Traces.from_arrays(times, {"ball 5 [N]": column}, noise=1.0, coupling=coupling)
    names = [Name("time_offset"), Name("gain", "ball 5"), Name("offset", "ball 5"), Name("delay")]
    model = make_model(data, [pressed], [], Simulator([data.shots[0].signals[0].place]))
    values = dict(zip(names, (-50e-6, 1.1, 0.2, -5e-6), strict=True))
    expected = 0.2 + (1.1 * 3.0 if coupling == "DC" else 0.0)
    assert model.at_rest(0, values) == pytest.approx([expected], rel=1e-9)


def test_a_run_with_few_saved_times_is_not_compared():
    run = hc.simulate(chain(), until=7e-4, times=30)
    with pytest.raises(hc.InputError, match="too few saved times to compare: [1-4] are") as caught:
        run.compare(traces())
    needed = int(re.search(r"at least times=(\d+)", str(caught.value))[1])
    assert hc.simulate(chain(), until=7e-4, times=needed).compare(traces()).covered > 0.9


def test_a_run_agrees_with_its_forces_also_at_the_foot_of_the_pulse(tmp_path):
    run = hc.simulate(chain(), until=7e-4, times=701)
    run.save_forces(tmp_path / "forces.csv", ["ball 5", "wall"])
    found = run.compare(tmp_path / "forces.csv")
    assert found.notes == ()
    text = found.summary(width=None)
    assert "+0.00 us" in text
    assert "-0.0" not in text.replace("time offset -0", "")


def test_a_time_offset_that_is_zero_within_its_error_is_shown_so():
    run = simulated(7e-4)
    own = {"ball 5 [N]": run.sensor("ball 5"), "wall [N]": run.force(run.chain.beads)}
    same = run.compare(hc.Traces.from_arrays(run.times, own))
    step = run.times[1]
    assert same.time_offset_error == pytest.approx(1e-3 * step)
    assert "time offset 0.00000 +- 0.000" in same.summary(width=None)
    assert "time offset 0.00000 +- 0.000" in repr(same)
    given = run.compare(hc.Traces.from_arrays(run.times, own), time_offset=0.0)
    assert np.isnan(given.time_offset_error)
    assert "time offset 0 s, given" in given.summary(width=None)


@pytest.mark.long
def test_the_error_of_the_time_offset_is_its_scatter():
    run, rng, found = simulated(7e-4), np.random.default_rng(3), []
    own = {"ball 5 [N]": run.sensor("ball 5"), "wall [N]": run.force(run.chain.beads)}
    for _ in range(40):
        noisy = {name: each + rng.normal(0.0, 0.3, len(each)) for name, each in own.items()}
        compared = run.compare(hc.Traces.from_arrays(run.times, noisy))
        found.append((compared.time_offset, compared.time_offset_error))
    offsets, errors = np.transpose(found)
    # The standard deviation of 40 values has an error of 11%; free amplitudes increase it.
    assert offsets.std() == pytest.approx(errors.mean(), rel=0.4)


@pytest.mark.filterwarnings("ignore::hertzchain.errors.InputWarning")
@pytest.mark.parametrize("unit", ["N", "V"])
@pytest.mark.parametrize("begin", [-16, -4, 4])
def test_records_shorter_than_the_pulse_do_not_determine_the_time_offset(begin, unit):
    """The force in ball 5 exceeds half of its peak for 40 us."""
    run, force = simulated(7e-4), forces()["ball 5"]
    spacing = float(np.diff(run.times).mean())
    exact = np.interp(run.times, SPACING * np.arange(len(force)), force)
    first = int(np.argmax(exact)) + round(begin * 1e-6 / spacing)
    times = spacing * np.arange(round(12e-6 / spacing))
    part = exact[first : first + len(times)]
    data = hc.Traces.from_arrays(times, {f"ball 5 [{unit}]": part}, noise=f"0.05 {unit}")
    message = (
        "the record lasts .* us, less than the pulse at ball 5, which exceeds half of its peak for "
        "4[0-2][.].* us: the time offset and gains cannot be determined"
    )
    with pytest.raises(hc.InputError, match=message):
        run.compare(data)
    offset = -run.times[first]
    assert run.compare(data, time_offset=offset).time_offset == pytest.approx(offset)

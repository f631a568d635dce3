"""Records of noise, with spikes, exchanged columns or few samples, and gains of single shots."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from synthetic_traces import bench, measured, signals

import hertzchain as hc
from hertzchain.fitting.compared_part import check_reached
from hertzchain.fitting.time_offsets import difference_at_best_offset
from hertzchain.traces.signals import Clock

HOW_TO = Path(__file__).parents[1] / "docs/how-to"
NAMES = ("ball 3 [N]", "ball 6 [N]", "wall [N]")
CHAIN = bench(hc.Viscoelastic(0.6e-6), beads=8, behind=3)


@pytest.fixture(scope="module")
def recorded():
    """Times, and samples of three sensors with 0.1 N of noise."""
    times, seen = signals(CHAIN, 400e-6, 60e-6, balls=(3, 6))
    return times, seen + np.random.default_rng(0).normal(0.0, 0.1, seen.shape)


@pytest.fixture(scope="module")
def run():
    return hc.simulate(CHAIN, until=400e-6, times=4000)


def traces_of(times, samples, **options):
    return hc.Traces.from_arrays(times, dict(zip(NAMES, samples.T, strict=True)), **options)


@pytest.mark.long
@pytest.mark.parametrize("noise", [None, 0.1])
def test_noise_alone_is_neither_described_nor_compared(run, noise):
    times = 1e-6 * np.arange(400)
    traces = traces_of(times, np.random.default_rng(1).normal(0.0, 0.1, (400, 3)), noise=noise)
    free = ["stiffness", "struck_by.velocity", "time_offset"]
    result = hc.fit(traces, CHAIN, free=free, starts=1)
    assert not result.describes
    assert not result.goodness.undecided
    assert "explains no more of the data than noise would" in result.verdict
    words = "explains no more of the data than noise would|no pulse above their noise"
    with pytest.raises((hc.InputError, hc.InputWarning), match=words):
        run.compare(traces)


def test_a_pulse_of_twice_the_noise_is_described():
    """Chi-squared falls by the sum of the squares of the pulse, far more than noise explains."""
    rng = np.random.default_rng(2)
    times, seen = signals(CHAIN, 400e-6, 60e-6, balls=(3, 6))
    noise = 0.5 * float(seen[:, 0].max())
    traces = traces_of(times, seen + rng.normal(0.0, noise, seen.shape), noise=noise)
    result = hc.fit(traces, CHAIN, free=["struck_by.velocity", "time_offset"], starts=1)
    assert result.describes
    expected = float(np.sum((seen - seen.mean(axis=0)) ** 2)) / noise**2
    assert result.goodness.explained == pytest.approx(expected, rel=0.3)


@pytest.mark.parametrize(("sensor", "sample"), [(0, 20), (1, 380), (2, 200)])
def test_a_spike_does_not_shift_the_time_offset(recorded, run, sensor, sample):
    times, samples = recorded
    clean = run.compare(traces_of(times, samples))
    spiked = samples.copy()
    spiked[sample, sensor] += 300.0
    with pytest.warns(hc.InputWarning, match=rf"sample {sample + 1} \(at {sample} us\)"):
        found = run.compare(traces_of(times, spiked))
    assert found.time_offset == pytest.approx(60e-6, abs=0.2e-6)
    assert found.time_offset == pytest.approx(clean.time_offset, abs=0.05e-6)
    assert found.sensors[sensor].measured_peak == pytest.approx(
        clean.sensors[sensor].measured_peak, rel=1e-3
    )


def test_crests_of_coarse_samples_are_not_spikes(run):
    """The pulse exceeds half of its peak for about four samples."""
    times, seen = signals(CHAIN, 400e-6, 60e-6, balls=(3, 6), spacing=6e-6)
    traces = traces_of(times, seen, noise=0.01)
    assert not any("sample" in note for note in run.compare(traces).notes)


@pytest.mark.parametrize("pair", [(0, 1), (0, 2), (1, 2)])
@pytest.mark.parametrize("factor", [1.0, 0.05])
def test_exchanged_columns_are_named(recorded, run, pair, factor):
    times, samples = recorded
    order = [0, 1, 2]
    order[pair[0]], order[pair[1]] = pair[1], pair[0]
    exchanged = samples[:, order]
    exchanged[:, 0] *= factor
    names = ["ball 3 [V]" if factor != 1.0 else NAMES[0], *NAMES[1:]]
    traces = hc.Traces.from_arrays(times, dict(zip(names, exchanged.T, strict=True)))
    words = " and ".join(NAMES[i].split(" [")[0] for i in pair)
    with pytest.warns(hc.InputWarning, match=f"columns of {words} exchanged"):
        run.compare(traces)


def test_columns_in_order_are_not_exchanged(recorded, run):
    assert not any("exchanged" in note for note in run.compare(traces_of(*recorded)).notes)


def test_the_samples_before_a_pulse_are_counted():
    """The pulse begins with sample 23; 22 are before it."""
    values = np.random.default_rng(3).normal(0.0, 0.1, 60)
    values[22:] += 50.0
    words = "begins after 22 samples; record at least 25 samples before the pulse, or give noise"
    with pytest.raises(hc.InputError, match=words):
        hc.Traces.from_arrays(1e-6 * np.arange(60), {"wall [N]": values})
    enough = np.concatenate([0.1 * np.sin(np.arange(3.0)), values])
    with pytest.raises(hc.InputError, match="begins after 24 samples; record at least 25"):
        hc.Traces.from_arrays(1e-6 * np.arange(62), {"wall [N]": enough[1:]})
    hc.Traces.from_arrays(1e-6 * np.arange(63), {"wall [N]": enough})
    missing = np.where(np.arange(63) < 32, enough, enough - 50.0)
    missing[2:18:2] = np.nan
    with pytest.raises(hc.InputError, match="after 25 samples, and only 16 of those before its f"):
        hc.Traces.from_arrays(1e-6 * np.arange(63), {"wall [N]": missing})
    for page, words in {
        "fit.md": "Include at least 25 samples before", "fit_data.md": "pulse, at least 25, for"
    }.items():  # fmt: skip
        assert words in (HOW_TO / page).read_text(encoding="utf-8")


def test_gains_of_single_shots_name_the_others():
    one = measured(CHAIN, np.random.default_rng(4), balls=(3, 6), duration=300e-6)
    free = ["struck_by.velocity", "time_offset@*", "gain[wall]@1"]
    result = hc.fit(one + one, CHAIN, free=free, starts=1)
    assert (
        "gain[wall] is free in shot 1 only, and fixed at 1 in shot 2: free 'gain[wall]@*' for a "
        "value in each shot"
    ) in result.notes
    shot = one.shots[0]
    volts = hc.Traces.from_arrays(shot.times, {"wall [V]": 0.05 * shot.signals[-1].values})
    with pytest.raises(hc.InputError, match="free in some shots, but not in shot 2"):
        hc.fit(volts + volts, CHAIN, free=free)


@pytest.mark.parametrize("factor", [2.0, 10.0])
def test_times_with_a_wrong_factor_are_named(recorded, run, factor):
    times, samples = recorded
    times_as_long = "twice" if factor == 2.0 else "10 times"
    with pytest.warns(hc.InputWarning, match=f"last {times_as_long} as long .* sampling interval"):
        notes = run.compare(traces_of(factor * times, samples)).notes
    assert not any("reflected pulse" in note for note in notes)


def test_peaks_that_differ_by_more_than_two_are_compared_by_their_ratio(recorded, run):
    times, samples = recorded
    with pytest.warns(hc.InputWarning, match="check the unit in the header"):
        sensor = run.compare(traces_of(times, 1e-3 * samples)).sensors[0]
    assert sensor.cells[2] == f"{sensor.peak_ratio:.0f} times"
    assert sensor.peak_ratio == pytest.approx(1000.0, rel=0.05)
    assert run.compare(traces_of(times, samples)).sensors[0].cells[2].endswith("%")


def test_data_that_agree_exactly_differ_by_nothing():
    """Sums of rounding errors, whose sign depends on the data, have no root."""
    times = np.arange(100.0)
    for seed in range(20):
        rough = np.random.default_rng(seed).uniform(0.5, 1.5, 60) * np.hanning(60)
        pulse = np.concatenate((np.zeros(40), rough))
        traces = hc.Traces.from_arrays(times, {"ball 2 [N]": pulse}, noise=1e-3)
        assert 0.0 <= difference_at_best_offset(traces.shots[0], [pulse], 1.0) < 1e-6


@pytest.mark.filterwarnings("ignore::hertzchain.errors.InputWarning")
@pytest.mark.parametrize("until", [430e-6, 700e-6])
def test_exchanged_columns_are_named_also_if_the_run_ends_before_the_record(until):
    traces, chain = hc.example_experiment()
    shot = traces.shots[0]
    columns = {f"{each.name} [{each.unit}]": each.values for each in shot.signals}
    columns["ball 6 [N]"], columns["ball 16 [N]"] = columns["ball 16 [N]"], columns["ball 6 [N]"]
    exchanged = hc.Traces.from_arrays(shot.times, columns)
    run = hc.simulate(hc.load_chain(chain), until=until, times=4000)
    words = "with the columns of ball 6 and ball 16 exchanged, the rms difference falls to"
    compared = run.compare(exchanged)
    assert compared.exchanged
    # This is the first note, and the table is complete.
    assert compared.notes[0].startswith(words)
    assert "of its value: check the names" in compared.notes[0]
    assert len(compared.sensors) == 4


def test_a_record_that_ends_before_a_pulse_says_so(recorded):
    times, seen = recorded
    (shot,) = traces_of(times[:200], seen[:200]).shots
    grid = 0.1e-6 * np.arange(4000)
    # Parabolic pulses that reach half of their peaks at 50, 250 and 310 us.
    half = 20e-6 * 0.5**0.5
    columns = [
        np.maximum(1.0 - ((grid - at - half) / 20e-6) ** 2, 0.0) for at in (5e-5, 25e-5, 31e-5)
    ]
    moments = shot.times - 10e-6
    end = f"the record ends at {1e6 * shot.times[-1]:.4g} us, before the simulated pulse reaches "
    words = "ball 6 and wall (at 260 us and 320 us, with time_offset = 10 us); "
    advice = "record for longer, or omit the columns of these sensors"
    with pytest.raises(hc.InputError, match=re.escape(end + words + advice)):
        check_reached(shot, moments, columns, grid, 10e-6)
    known = replace(shot, clock=Clock(10e-6))
    with pytest.raises(hc.InputError, match="give an earlier time_offset, or record for longer"):
        check_reached(known, moments, columns, grid, 10e-6)
    check_reached(shot, moments, columns[:1] * 3, grid, 10e-6)


def test_the_number_of_missing_samples_is_stated(run, recorded):
    times, seen = recorded
    seen = seen.copy()
    seen[[3, 7, 8], 1] = np.nan
    notes = run.compare(traces_of(times, seen)).notes
    assert "3 samples of ball 6 are missing and not used" in notes


def test_a_wrong_unit_is_noted_with_the_ratio_of_the_table(run, recorded):
    times, seen = recorded
    with pytest.warns(hc.InputWarning, match="check the unit in the header"):
        compared = run.compare(traces_of(times, seen * [1.0, 1.0, 1e3]))
    ratio = compared.sensors[2].cells[2]
    assert ratio.endswith(" times")
    assert f"the simulated peak of wall is {ratio} the measured one" in " ".join(compared.notes)


def test_few_samples_before_the_pulse_are_counted(recorded):
    times, seen = recorded
    early = np.argmax(np.abs(seen[:, 0]) > 1.0) - 12
    words = "after 14 samples; record at least 25"
    with pytest.raises(hc.InputError, match=words):
        traces_of(times[early:], seen[early:])


@pytest.mark.parametrize("column", [0, 1, 2])
def test_one_delayed_sensor_is_named(recorded, column):
    """Its signal is 30 us late; the noise changes arrivals by less than 0.1 us."""
    times, seen = recorded
    late = seen.copy()
    late[:, column] = np.interp(times - 30e-6, times, seen[:, column])
    found = hc.simulate(CHAIN, until=400e-6, times=4000).compare(traces_of(times, late))
    (note,) = (each for each in found.notes if "the other sensors" in each)
    delay = re.match(rf"the measured signal of {NAMES[column][:-4]} is (\d+) us late", note)[1]
    assert float(delay) == pytest.approx(30.0, abs=1.0)


@pytest.mark.parametrize("column", [0, 1, 2])
def test_one_sensor_with_another_gain_is_named(recorded, run, column):
    times, seen = recorded
    factors = np.ones(3)
    factors[column] = 2.0
    found = run.compare(traces_of(times, factors * seen))
    (note,) = (each for each in found.notes if "the other sensors" in each)
    name = NAMES[column][:-4]
    assert re.match(rf"the simulated peak of {name} is 0\.(49|5|50)\d* times the measured", note)
    assert f"check the gain of {name}" in note


@pytest.mark.parametrize(
    "other",
    [
        CHAIN,
        CHAIN.replace(loss=hc.Viscoelastic(2e-6)),
        CHAIN.replace(loss=hc.Elastic()),
        CHAIN.replace(stiffness=0.7 * CHAIN.stiffness),
        CHAIN.replace(masses=1.3 * CHAIN.masses),
        CHAIN.replace(velocities=1.5 * CHAIN.velocities),
    ],
    ids=["true", "loss", "no loss", "stiffness", "masses", "velocity"],
)
def test_wrong_chains_do_not_make_one_sensor_odd(recorded, other):
    """A wrong loss changes amplitudes, and a wrong material delays, along the chain."""
    times, seen = recorded
    found = hc.simulate(other, until=400e-6, times=4000).compare(traces_of(times, seen))
    assert not any("the other sensors" in each for each in found.notes)


def test_a_wrong_wall_is_a_cause_of_an_odd_sensor_at_the_wall(recorded):
    times, seen = recorded
    soft = CHAIN.replace(right_wall=hc.Wall(0.1 * CHAIN.wall_stiffness[1]))
    found = hc.simulate(soft, until=400e-6, times=4000).compare(traces_of(times, seen))
    notes = [each for each in found.notes if "the other sensors" in each]
    assert notes
    assert all(each.endswith(", and the wall of the chain") for each in notes)

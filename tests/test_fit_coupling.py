"""Sensors that do not show the static force of a precompressed chain; the data are from SciPy."""

import numpy as np
import pytest
from scipy_row import BALLS, FACTOR, LOSS_TIME, RADIUS, SPACING, forces

import hertzchain as hc
from hertzchain.traces.coupling import static_force
from hertzchain.traces.places import place_named

STATIC, VELOCITY, NOISE = 22.0, 0.01, 0.02
NAMES = {"ball 5": "bead 6", "ball 10": "bead 11", "wall": "wall"}
FREE = ["stiffness", "loss.time", "time_offset", "precompression"]


def held(**fields):
    """The chain of `scipy_row` as 16 beads under a force that is known to 10%."""
    row = hc.Chain.from_materials(RADIUS, "steel-52100", beads=BALLS + 1)
    usual = {
        "right_wall": hc.Wall.of("steel-304"), "precompression": 20.0, "held_by": "force",
        "velocities": [VELOCITY] + [0.0] * BALLS, "loss": hc.Viscoelastic(0.4e-6),
    }  # fmt: skip
    return row.replace(**usual | fields)


def columns(static, unit="N", gain=1.0):
    rng, found = np.random.default_rng(3), {}
    for name, force in forces(static=STATIC, velocity=VELOCITY).items():
        seen = np.concatenate((np.full(120, STATIC), force)) - STATIC + static
        found[f"{NAMES[name]} [{unit}]"] = gain * (seen + NOISE * rng.standard_normal(len(seen)))
    return SPACING * np.arange(len(seen)), found


@pytest.mark.long
@pytest.mark.parametrize(("static", "coupling"), [(0.0, None), (0.0, "AC"), (STATIC, None)])
def test_static_forces_are_part_of_the_signal_or_not(static, coupling):
    data = hc.Traces.from_arrays(*columns(static), coupling=coupling)
    priors = {"precompression": (20.0, 2.0)}
    result = hc.fit(data, held(), free=FREE, priors=priors)
    assert result.describes
    truth = {"stiffness": FACTOR, "loss.time": LOSS_TIME, "precompression": STATIC}
    deviations = [(result.values[name] - truth[name]) / result.errors[name] for name in truth]
    assert np.abs(deviations).max() < 3.5
    assert ("AC coupling of bead 6, bead 11, wall" in result.summary(width=None)) == (static == 0.0)


def test_a_run_is_compared_with_the_dynamic_force():
    chain = held(
        precompression=STATIC, loss=hc.Viscoelastic(LOSS_TIME),
        stiffness=FACTOR * held().stiffness,
        right_wall=hc.Wall(FACTOR * held().wall_stiffness[1]),
    )  # fmt: skip
    run = hc.simulate(chain, times=np.arange(0.0, 7e-4, 0.1e-6))
    data = hc.Traces.from_arrays(*columns(0.0))
    compared = run.compare(data, time_offset=120 * SPACING)
    for name, force in forces(static=STATIC, velocity=VELOCITY).items():
        # Only the noise remains.
        expected = NOISE / (force.max() - STATIC)
        assert compared.differences[NAMES[name]] == pytest.approx(expected, rel=0.1)
    assert max(run.compare(data).differences.values()) < 0.03
    assert "AC coupling" in repr(compared)
    wrong = run.compare(hc.Traces.from_arrays(*columns(0.0), coupling="DC"))
    assert min(wrong.differences.values()) > 0.5


@pytest.mark.long
def test_the_chain_file_states_the_coupling(tmp_path):
    times, data = columns(0.0)
    file = tmp_path / "data.csv"
    table = np.column_stack((1e6 * times, *data.values()))
    np.savetxt(file, table, "%.6f", ",", header=f"time [us],{','.join(data)}", comments="")
    text = hc.chain_as_toml(held())
    given = {}
    for coupling in ('"AC"', '"DC"', '{wall = "DC"}'):
        (tmp_path / "chain.toml").write_text(f"{text}\n[fit]\ncoupling = {coupling}\n")
        result = hc.fit(file, tmp_path / "chain.toml", free=["time_offset"])
        given[coupling] = [signal.coupling for _, signal in result.traces]
    assert list(given.values()) == [["AC"] * 3, ["DC"] * 3, ["AC", "AC", "DC"]]
    assert [s.coupling for _, s in hc.load_traces(file, coupling={"wall": "AC"})] == ["", "", "AC"]


@pytest.mark.long
def test_voltages_are_recognised_by_a_level_of_zero():
    volts = hc.Traces.from_arrays(*columns(0.0, "V", 0.05))
    with_level = hc.Traces.from_arrays(*columns(STATIC, "V", 0.05))
    free = ["stiffness", "loss.time", "time_offset", "gain[*]"]
    chain = held(precompression=STATIC)
    result = hc.fit(volts, chain, free=free)
    assert result.describes
    assert [signal.coupling for _, signal in result.traces] == ["AC"] * 3
    assert result.values["gain[wall]"] == pytest.approx(0.05, rel=0.01)
    for gains, name in (("gain[*]", "gain[wall]"), ("gain", "gain")):
        other = hc.fit(with_level, chain, free=[*free[:3], gains])
        assert [signal.coupling for _, signal in other.traces] == ["DC"] * 3
        assert other.values[name] == pytest.approx(0.05, rel=0.01)


def small_static(level, noise=0.01, unit="V", smooth=1):
    """Traces of a row whose static force, 0.2 N, is less than 2% of the peaks.

    The noise is that of means of ``smooth`` samples, and of each sensor or of all.
    """
    rng, found = np.random.default_rng(3), {}
    of_sensors = np.broadcast_to(noise, 3)
    series = forces(static=0.2, velocity=0.25)
    for size, (name, force) in zip(of_sensors, series.items(), strict=True):
        seen = np.concatenate((np.full(120, 0.2), force)) - 0.2 + level
        white = rng.standard_normal(len(seen) + smooth - 1)
        noisy = seen + size * np.convolve(white, np.full(smooth, smooth**-0.5), "valid")
        found[f"{NAMES[name]} [{unit}]"] = noisy if unit == "N" else 0.05 * noisy
    return hc.Traces.from_arrays(SPACING * np.arange(len(seen)), found)


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
@pytest.mark.parametrize("priors", [{}, {"gain[wall]": (0.05, 0.001)}])
def test_gains_decide_whether_a_small_level_is_the_static_force(priors):
    chain = held(precompression=0.2, velocities=[0.25] + [0.0] * BALLS)
    free = ["stiffness", "loss.time", "time_offset", "gain[*]"]
    for level, coupling in ((0.2, "DC"), (0.0, "AC")):
        result = hc.fit(small_static(level), chain, free=free, priors=priors)
        assert [signal.coupling for _, signal in result.traces] == [coupling] * 3
        assert result.describes
        assert "too uncertain" not in result.summary(width=None)
    run = hc.simulate(chain, times=np.arange(0.0, 7e-4, 0.1e-6))
    # The level is that of the static force, so that nothing is shifted.
    notes = " ".join(run.compare(small_static(0.2)).notes)
    assert "AC coupling" not in notes
    assert "before the pulse" not in notes


def test_a_level_that_shows_no_coupling_is_named():
    chain = held(precompression=0.2, velocities=[0.25] + [0.0] * BALLS)
    free = ["stiffness", "loss.time", "time_offset", "gain[*]"]
    result = hc.fit(small_static(0.2, noise=3.0), chain, free=free)
    assert "the level of bead 6, bead 11 and wall is too uncertain to show it" in result.summary(
        width=None
    )
    assert 'if it does, set coupling = "DC"' in result.summary(width=None)


def small_run():
    chain = held(precompression=0.2, velocities=[0.25] + [0.0] * BALLS)
    return hc.simulate(chain, times=np.arange(0.0, 7e-4, 0.1e-6))


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_forces_below_the_noise_of_a_sample_are_seen_in_the_level():
    # The static force is twice the noise of a sample, and about 20 times the error of a level.
    run = small_run()
    absent = " ".join(run.compare(small_static(0.0, 0.1, "N")).notes)
    assert "AC coupling of bead 6, bead 11, wall" in absent
    assert "too uncertain" not in absent
    assert "before the pulse" not in absent
    present = " ".join(run.compare(small_static(0.2, 0.1, "N")).notes)
    assert "AC coupling" not in present
    assert "before the pulse" not in present
    # The means of 60 samples leave few independent ones before the pulse.
    slow = run.compare(small_static(0.0, 0.1, "N", smooth=60))
    assert "the level of bead 6 and bead 11 is too uncertain" in " ".join(slow.notes)


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
@pytest.mark.parametrize(("level", "coupling"), [(0.2, ""), (0.0, "bead 6, bead 11, wall")])
def test_an_uncertain_level_follows_the_clear_ones(level, coupling):
    compared = small_run().compare(small_static(level, (0.1, 3.0, 0.1), "N"))
    text = " ".join(compared.notes)
    assert ("AC coupling" in text) == bool(coupling)
    if coupling:
        assert f"AC coupling of {coupling}" in text
        assert "the level of bead 11 is too uncertain to show it" in text


def test_static_forces_of_sensors():
    # A force holds the free end, so that each contact has the same static force.
    for name in ("bead 6", "wall"):
        assert static_force(place_named(name), held()) == pytest.approx(20.0, rel=1e-9)
    assert static_force(place_named("bead 6 velocity"), held()) == 0.0
    # Without precompression, nothing is subtracted.
    assert static_force(place_named("bead 6"), held(precompression=0.0)) == 0.0


@pytest.mark.parametrize(
    ("coupling", "words"),
    [
        ("ac", "unknown coupling of bead 6 'ac' (did you mean 'AC'?): choose from AC, DC"),
        ({"ball 7": "AC"}, "unknown sensor of coupling 'ball 7'"),
        ({"wall": 1}, "unknown coupling of wall"),
    ],
)
def test_other_couplings_are_rejected(coupling, words):
    with pytest.raises(hc.InputError) as caught:
        hc.Traces.from_arrays(*columns(0.0), coupling=coupling)
    assert words in str(caught.value)

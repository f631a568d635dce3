"""Pulses and fronts where bead 1 is driven, or several beads strike: what exists, and what not."""

import json
import re

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.store.results import pulses_as_csv, pulses_as_json

STILL = hc.Chain.uniform(40)
HAMMER = STILL.replace(drive=hc.SineBurst(0.5, 0.125, cycles=0.5, window="none"))
PISTON = STILL.replace(
    drive=hc.TableDrive([0.0, 200.0], [0.0, 200.0], of="displacement"),
    left_wall=hc.Wall(stiffness=1.0),
)


def mean_speed(times, first, last):
    return (last - first) / (times[last - 1] - times[first - 1])


def test_a_hammer_sends_a_pulse():
    run = hc.simulate(HAMMER, until=60.0, times=6000)
    pulse = run.pulse()
    assert np.isfinite(pulse.arrival).all()
    assert pulse.arrival[0] == 0.0
    assert np.isnan(pulse.residence).tolist() == [True] + [False] * 38
    assert pulse.notes["residence"].startswith("bead 1: not struck")
    # Bead 1 like any other: its first maximum, as the saved times show it.
    velocity = run.velocity(1)
    first = np.flatnonzero((velocity[1:-1] > velocity[:-2]) & (velocity[1:-1] >= velocity[2:]))[0]
    assert pulse.velocity[0] == pytest.approx(velocity[first + 1], rel=1e-5)
    assert pulse.peak_time[0] == pytest.approx(run.times[first + 1], abs=0.01)
    # The shape of a strike is forgotten: speed and peak force belong to the exact wave.
    exact = 0.9074700784 * pulse.velocity[30] ** 0.2
    assert pulse.speed[30] / 2.0 == pytest.approx(exact, rel=3e-3)


@pytest.mark.parametrize(
    ("chain", "until", "speeds"),
    [
        # Means over beads 10-20 and 20-30, from a separate program.
        (HAMMER, 60.0, (0.84543, 0.84547)),
        (STILL.replace(drive=hc.StepDrive(0.3)), 60.0, (0.83179, 0.84157)),
        (STILL.replace(drive=hc.SineBurst(0.3, 1 / 40, cycles=0.5, window="none"),
                       precompression=0.3, held_by="force"), 60.0, (1.03722, 1.05684)),
    ],
    ids=["hammer", "step", "slow half-sine under precompression"],
)  # fmt: skip
def test_speeds_of_fronts(chain, until, speeds):
    fronts = hc.simulate(chain, until=until, times=3000).fronts()
    found = mean_speed(fronts.times, 10, 20), mean_speed(fronts.times, 20, 30)
    np.testing.assert_allclose(found, speeds, rtol=0, atol=1e-5)
    np.testing.assert_allclose(fronts.speed[15:18], 2.0 / np.diff(fronts.times)[14:17], rtol=1e-12)
    assert np.isnan(fronts.speed[0])


def test_a_slow_drive_shifts_crests_and_not_fronts():
    drive = hc.SineBurst(0.3, 1 / 40, cycles=0.5, window="none")
    chain = STILL.replace(drive=drive, precompression=0.3, held_by="force")
    run = hc.simulate(chain, until=60.0, times=3000)
    sound = np.sqrt(1.5 * 0.3 ** (1 / 3))  # beads per time, c^2 = p k^(1/p) F^(1-1/p) / m
    assert mean_speed(run.fronts().times, 10, 30) == pytest.approx(sound, rel=0.05)
    assert mean_speed(run.pulse().arrival[1:], 10, 30) > 1.3 * sound
    assert "a slow drive shifts; see Run.fronts" in run.pulse().notes["residence"]


@pytest.mark.parametrize("law", [hc.Viscoelastic(0.5), hc.VelocityPower(1.0, 1.0)], ids=repr)
def test_a_shock_without_a_maximum_has_fronts(law):
    run = hc.simulate(PISTON.replace(loss=law), until=28.0, times=3000)
    pulse, fronts = run.pulse(), run.fronts()
    for name in ("velocity", "peak_overlap", "residence"):
        assert np.isnan(pulse.column(name)).all()
    assert "no first maximum" in pulse.notes["peak_force"]
    # Behind the shock: velocity 1, force F; by mass and momentum V = F, with F = (1/V)^(3/2).
    assert mean_speed(fronts.times, 10, 15) == pytest.approx(1.0, abs=0.02)
    assert fronts.heights[10] == pytest.approx(1.0, abs=0.02)
    late = np.isnan(fronts.times)
    assert late[-10:].all()
    assert not late[:15].any()
    assert "still being loaded" in fronts.notes["times"]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"until": 60.0, "times": 60}, "contacts 1 to 39: fewer than 4 saved times in the rise"),
        ({"times": np.linspace(30.0, 60.0, 2000)}, "contacts 1 to .*: reached before the first"),
    ],
)
def test_fronts_that_the_saved_times_do_not_show(options, said):
    fronts = hc.simulate(HAMMER, **options).fronts()
    assert np.isnan(fronts.times[0])

    assert re.match(said, fronts.notes["times"])


def test_fronts_need_saved_times():
    with pytest.raises(hc.InputError, match="fronts require at least 2 saved times, the run has 0"):
        hc.simulate(HAMMER, until=10.0, times=0).fronts()


def test_fronts_converge_with_the_saved_times():
    coarse, fine = (hc.simulate(HAMMER, until=60.0, times=n).fronts() for n in (400, 12800))
    # The rise takes about 1; 400 times are one every 0.15.
    np.testing.assert_allclose(coarse.times, fine.times, rtol=0, atol=2e-3)


@pytest.mark.parametrize("count", [2, 3])
@pytest.mark.parametrize("as_strikers", [True, False])
def test_no_negative_speeds_among_strikers(count, as_strikers):
    if as_strikers:
        chain = hc.Chain.uniform(30).struck_by(count=count)
    else:
        velocities = np.append(np.ones(count), np.zeros(30))
        chain = hc.Chain.uniform(30 + count).replace(velocities=velocities)
    run = hc.simulate(chain, until=60.0, times=1500)
    pulse, fronts = run.pulse(), run.fronts()
    assert np.isnan(pulse.residence[:count]).all()
    assert (pulse.residence[count:] > 0.0).all()
    assert (pulse.speed[count:] > 0.0).all()
    assert pulse.notes["residence"].startswith(f"beads 1 to {count}: they move from the start")
    assert np.isnan(fronts.times[: count - 1]).all()
    assert (np.diff(fronts.times[count - 1 :]) > 0.0).all()
    with pytest.raises(hc.SimulationError, match="bead 2: it has no residence .* move from"):
        run.pulse_width(2)


def test_a_lossless_pulse_has_no_notes():
    assert hc.simulate(hc.Chain.uniform(30), times=0).pulse().notes == {}
    gentle = hc.Chain.uniform(60).replace(loss=hc.Restitution(0.97))
    assert hc.simulate(gentle, times=0).pulse().notes == {}


@pytest.mark.parametrize(
    "law", [hc.UnloadingRatio(0.19), hc.Restitution(0.6), hc.Viscoelastic(0.3)], ids=repr
)
def test_the_tail_of_strong_losses_is_noted(law):
    """From where the pulse is 1.3 to 2.4 times as wide, at half height, as a lossless one."""
    run = hc.simulate(hc.Chain.uniform(100).replace(loss=law), times=4000)
    note = run.pulse().notes["velocity"]
    assert "front of a shock-like tail" in note
    first = int(note.removeprefix("beads ").partition(" ")[0])
    assert 1.3 < run.pulse_width(first) / 1.57914 < 2.4
    assert run.pulse_width(first // 2) < run.pulse_width(first) < run.pulse_width(first + 20)
    assert run.pulse().notes["momentum"] == note
    assert "peak_time" not in run.pulse().notes


@pytest.mark.parametrize("rate", [0.02, 0.05, 0.1])
def test_tails_of_tapers_are_compared_with_those_without_losses(rate):
    """A forward taper has most of its momentum behind the crest; only losses make it a tail."""
    taper = hc.Chain.tapered("forward-exponential", rate, beads=80)
    # The strength of these losses is the same for all sizes and speeds.
    for law in (hc.Restitution(0.999), hc.Restitution(0.95)):
        assert "velocity" not in hc.simulate(taper.replace(loss=law), times=0).pulse().notes
    strong = hc.simulate(taper.replace(loss=hc.Restitution(0.5)), times=0).pulse()
    equal = hc.Chain.uniform(80).replace(loss=hc.Restitution(0.5))
    first = [
        int(pulse.notes["velocity"].removeprefix("beads ").partition(" ")[0])
        for pulse in (strong, hc.simulate(equal, times=0).pulse())
    ]
    assert first[0] == pytest.approx(first[1], abs=3)


def test_the_tail_of_a_strong_loss_in_a_taper_is_wider_than_its_pulse_without():
    taper = hc.Chain.tapered("forward-exponential", 0.05, beads=60)
    run, elastic = (
        hc.simulate(taper.replace(loss=law), times=4000) for law in (hc.Restitution(0.5), None)
    )
    note = run.pulse().notes["velocity"]
    first = int(note.removeprefix("beads ").partition(" ")[0])
    wider = [run.pulse_width(k) / elastic.pulse_width(k) for k in (first // 2, first)]
    assert wider[0] < wider[1]
    assert wider[1] > 1.3
    assert elastic.pulse().notes == {}


def test_a_lossy_wall_has_no_tail():
    taper = hc.Chain.tapered("forward-exponential", 0.05, beads=40)
    walled = taper.replace(right_wall=hc.Wall(loss=hc.Restitution(0.9)))
    assert "velocity" not in hc.simulate(walled, times=0).pulse().notes


def test_missing_values_in_files_tables_and_comparisons():
    chain = hc.Chain.uniform(12).struck_by(count=2)
    pulse = hc.simulate(chain, times=0).pulse()
    document = json.loads(pulses_as_json([pulse]))["pulses"][0]
    assert document["residence"][:2] == [None, None]
    assert document["notes"] == dict(pulse.notes)
    rows = [line.split(",") for line in pulses_as_csv([pulse]).splitlines()]
    at = rows[0].index("residence")
    assert [row[at] == "" for row in rows[1:5]] == [True, True, False, False]
    assert pulse.to_xarray().residence.attrs["comment"] == pulse.notes["residence"]
    assert "residence: beads 1 to 2: they move from the start" in str(pulse)
    half = hc.simulate(hc.Chain.uniform(30), until=20.0, times=0).pulse()
    theory = hc.bca(hc.Chain.uniform(30))
    compared, whole = theory.compare(half), theory.compare(hc.propagate(hc.Chain.uniform(30)))
    seen = np.isfinite(half.velocity)
    assert compared.worst("velocity") == pytest.approx(
        np.abs(whole.errors("velocity")[1:][seen[1:]]).max(), rel=1e-6
    )
    assert "nan" not in str(compared)
    with pytest.raises(hc.InputError, match="no bead from 29 on has velocity in both pulses"):
        compared.worst("velocity", first_bead=29)


def test_a_pulse_without_a_reason_has_no_missing_values():
    chain, velocity = hc.Chain.uniform(3), [1.0, np.nan, 1.0]
    with pytest.raises(hc.InputError, match="velocity of bead 2 is nan"):
        hc.Pulse(chain, "test", velocity, notes={"arrival": "bead 2: lost"})
    assert np.isnan(hc.Pulse(chain, "test", velocity, notes={"velocity": "lost"}).momentum[1])
    with pytest.raises(hc.InputError, match="unknown quantity of a note 'speed'"):
        hc.Pulse(chain, "test", [1.0] * 3, notes={"speed": "lost"})


def test_sweeps_over_driven_chains_say_what_is_missing():
    document = {
        "chain": {"taper": "uniform", "beads": 20,
                  "drive": {"kind": "sine-burst", "amplitude": 0.5, "frequency": 0.125,
                            "cycles": 0.5, "window": "none"}},
        "axes": {"method.until": [8.0, 60.0]},
        "sweep": {"methods": ["simulate"], "keep": ["peak_force", "residence"]},
    }  # fmt: skip
    with pytest.warns(hc.IncompleteWarning, match="1 of 2 points failed"):
        found = hc.sweep(document).squeeze("approach")
    assert found.status.values.tolist() == [2, 1]
    assert "peak_force: contacts" in str(found.reason.values[0])
    assert np.isfinite(found.peak_force.values[0, :3]).all()
    assert np.isfinite(found.peak_force.values[1]).all()
    assert "residence: bead 1: not struck" in str(found.reason.values[1])

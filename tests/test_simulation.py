import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from kernel_call import callable_from_python
from scipy_reference import peaks, trajectory

import hertzchain as hc
from hertzchain import collision
from hertzchain.kernels import compile_notice
from hertzchain.simulation import slow_run

# Constants of the uniform chain (scaled, p = 3/2), from an integration at rtol 1e-13 and,
# for amplitude and speed, from the fixed point of the travelling wave: two methods that
# share nothing with ours.
UNIFORM_VELOCITIES = [.751471736247, .714561003489, .698649441531, .690749497480,
                      .686608736488, .684377061915, .683155358512]  # fmt: skip
UNIFORM_TIMES = [1.8828111864, 3.1210959390, 4.3295734157, 5.5272747592,
                 6.7206217128, 7.9120858067, 9.1026863759]  # fmt: skip


@pytest.mark.parametrize("loss", [hc.Restitution(0.5), hc.Viscoelastic(0.3), hc.Dashpot(0.1)])
def test_collisions_whose_contact_still_acts_say_so(loss):
    pair = hc.Chain.uniform(2).replace(loss=loss)
    early, late = hc.simulate(pair), hc.simulate(pair, until=30.0)
    assert early.closed_contacts.tolist() == [1]
    assert "1 contact still closed, so velocities are not final" in " ".join(repr(early).split())
    assert late.closed_contacts.tolist() == []
    assert "closed" not in repr(late)
    rebound = [float(run.velocities[-1] @ [-1.0, 1.0]) for run in (early, late)]
    # Only the later velocity is that of the rebound.
    final = hc.simulate(pair, until=60.0).velocities[-1] @ [-1.0, 1.0]
    assert rebound[1] == pytest.approx(final, rel=1e-12)
    assert abs(rebound[0] - final) > 1e-7


def test_a_contact_at_its_residual_overlap_has_no_force():
    # The pulse has passed when the last velocity is largest, and the force of this law is then 0.
    pair = hc.Chain.uniform(2).replace(loss=hc.WaltonBraun(0.8))
    early, late = hc.simulate(pair), hc.simulate(pair, until=60.0)
    assert early.closed_contacts.tolist() == []
    assert early.state.velocities == pytest.approx(late.state.velocities, rel=1e-9)
    # During loading, the same overlap has a force.
    assert hc.simulate(pair, until=1.0).closed_contacts.tolist() == [1]


def test_closed_contacts_do_not_depend_on_the_saved_times():
    chain = hc.Chain.tapered(
        first_diameter="20 mm", last_diameter="5 mm", beads=40, materials="steel-52100",
        velocity="1 cm/s",
    ).replace(right_wall=hc.Wall())  # fmt: skip
    found = [hc.simulate(chain, times=times).closed_contacts for times in (50, 400, 4000)]
    assert len(found[0]) > 5
    assert all(each.tolist() == found[0].tolist() for each in found)


def test_closed_contacts_are_those_with_overlaps_at_the_end():
    run = hc.simulate(hc.Chain.tapered("forward-exponential", 0.05, beads=20))
    end = hc.simulate(run.chain, until=run.end_time, times=2)
    expected = 1 + np.flatnonzero(~end.open_contacts()[-1])
    assert run.closed_contacts.tolist() == expected.tolist()
    assert len(expected) > 5
    assert "closed" not in repr(run)
    assert hc.simulate(hc.Chain.uniform(2)).closed_contacts.tolist() == []


def test_closed_contacts_include_those_under_static_forces():
    """Contacts are closed if the overlap of the saved positions is not 0."""
    wall = hc.Wall()
    still = hc.Chain.uniform(5).replace(
        precompression=1.0, left_wall=wall, right_wall=wall, velocities=np.zeros(5)
    )
    assert hc.simulate(still, until=0.3).closed_contacts.tolist() == [1, 2, 3, 4]
    column = hc.Chain.uniform(5).replace(gravity=0.1, right_wall=wall)
    for until in (1.0, 5.0, 10.0, 20.0):
        run = hc.simulate(column, until=until)
        closed = [k for k in range(1, 5) if run.overlap(k)[-1] > 0.0]
        assert run.closed_contacts.tolist() == closed
    assert closed == [2, 3, 4]


def test_closed_contacts_are_not_those_one_step_before_the_end():
    chain = hc.Chain.from_radii([1.0, 0.8, 1.2, 0.9, 1.1, 0.7, 1.0, 1.3])
    chain = chain.replace(right_wall=hc.Wall())
    for until in np.arange(8.0, 40.0, 0.25):
        run = hc.simulate(chain, until=until, times=100)
        closed = [k for k in range(1, 8) if run.overlap(k)[-1] > 1e-8 * run.overlap(k).max()]
        assert run.closed_contacts.tolist() == closed, until


def test_contacts_open_at_their_dents():
    """The beads of a plastic collision separate at the dent, half of the largest overlap."""
    pair = hc.Chain.uniform(2).replace(loss=hc.WaltonBraun(0.5))
    run = hc.simulate(pair, until=4.0, times=401)
    overlap, force = run.overlap(1), run.force(1)
    dent = 0.5 * (1.25 * 0.5) ** 0.4
    separated = (run.times > run.times[np.argmax(overlap)]) & (overlap < dent)
    assert run.open_contacts()[separated].all()
    assert not run.open_contacts()[~separated].any()
    assert (overlap[separated] > 0.0).any()
    assert (force[separated] == 0.0).all()


def test_peaks_and_times_of_the_uniform_chain(uniform_run):
    pulse = uniform_run.pulse()
    np.testing.assert_allclose(pulse.velocity[1:8], UNIFORM_VELOCITIES, rtol=1e-11)
    np.testing.assert_allclose(pulse.peak_time[1:8], UNIFORM_TIMES, rtol=1e-10)
    assert pulse.velocity[20] == pytest.approx(0.681632351111, rel=1e-11)
    assert pulse.velocity[60] == pytest.approx(0.681631548571, rel=5e-11)


def test_solitary_wave_of_the_uniform_chain(uniform_run):
    pulse = uniform_run.pulse()
    middle = slice(50, 80)
    np.testing.assert_allclose(np.diff(pulse.peak_time)[middle], 1.1897555770, rtol=2e-10)
    np.testing.assert_allclose(pulse.residence[middle], 1.1897555770, rtol=2e-10)
    np.testing.assert_allclose(pulse.peak_force[middle], 0.6395542321, rtol=1e-9)
    np.testing.assert_allclose(pulse.peak_overlap[middle], 0.7423093281, rtol=1e-9)


def test_the_last_bead_flies_off_with_its_known_velocity(uniform_run):
    assert uniform_run.pulse().velocity[-1] == pytest.approx(0.98567886, abs=6e-9)


def test_what_is_thrown_back(uniform_run):
    thrown_back = [-0.07108502, -0.03027379, -0.0158334, -0.0088857, -0.00512658, -0.00298598]
    np.testing.assert_allclose(uniform_run.velocities[-1, :6], thrown_back, atol=6e-8)


@pytest.mark.parametrize(
    ("p", "amplitude"),
    [(1.25, .57733689), (1.75, .74714607), (2.0, .79433275), (2.5, .85911287),
     (3.0, .90128004), (4.0, .95024781)],
)  # fmt: skip
def test_amplitude_for_other_exponents(p, amplitude):
    pulse = hc.simulate(hc.Chain.uniform(100, exponent=p), times=0).pulse()
    assert pulse.velocity[80] == pytest.approx(amplitude, abs=6e-9)


@pytest.mark.parametrize(
    ("taper", "rate", "beads", "tolerance"),
    [
        ("backward-exponential", 0.05, 60, 8e-10),
        ("backward-exponential", 0.1, 60, 4e-9),
        ("forward-exponential", 0.1, 60, 8e-12),
        ("backward-linear", 0.9, 60, 2.4e-9),
        ("forward-linear", 0.009, 100, 4e-12),
    ],
)
def test_peaks_against_an_independent_integration(taper, rate, beads, tolerance):
    chain = hc.Chain.tapered(taper, rate, beads=beads)
    run = hc.simulate(chain, times=0)
    velocities, times = peaks(chain.radii, run.end_time)
    pulse = run.pulse()
    np.testing.assert_allclose(pulse.velocity[1:-1], velocities, rtol=tolerance)
    np.testing.assert_allclose(pulse.peak_time[1:-1], times, rtol=tolerance)


@pytest.mark.parametrize(
    ("taper", "rate", "beads"),
    [
        ("backward-exponential", 0.1, 100),
        ("forward-exponential", 0.1, 60),
        ("backward-linear", 0.9, 100),
        ("forward-linear", 0.009, 100),
    ],
)
def test_energy_and_momentum_are_conserved(taper, rate, beads):
    run = hc.simulate(hc.Chain.tapered(taper, rate, beads=beads), times=0)
    assert run.energy_drift < 1e-10
    assert run.momentum_drift < 1e-13


@pytest.mark.parametrize(
    ("taper", "rate", "log_rate"),
    [("backward-exponential", 0.05, -.08047222), ("backward-exponential", 0.3, -.67671292),
     ("backward-exponential", 0.5, -1.50724739), ("forward-exponential", 0.05, +.06748234),
     ("forward-exponential", 0.03, +.04253678)],
)  # fmt: skip
def test_exponential_tapers_settle_to_their_exact_rate(taper, rate, log_rate):
    pulse = hc.simulate(hc.Chain.tapered(taper, rate, beads=60), times=0).pulse()
    assert np.log(pulse.velocity[50] / pulse.velocity[49]) == pytest.approx(log_rate, abs=2e-8)


def test_two_beads_collide_as_two_bodies():
    chain = hc.Chain.from_radii([1.0, 0.6])
    pulse = hc.simulate(chain, times=0).pulse()
    assert pulse.velocity[1] == pytest.approx(2 / (1 + 0.6**3), rel=1e-11)
    reduced = collision.reduced_mass(1.0, 0.6**3)
    duration = collision.compression_time(reduced, chain.stiffness[0], 1.0)
    assert pulse.arrival[1] == pytest.approx(duration, rel=1e-9)
    overlap = collision.collision_overlap(reduced, chain.stiffness[0], 1.0)
    assert pulse.peak_overlap[0] == pytest.approx(overlap, rel=1e-11)


def test_saved_states_are_the_trajectory():
    chain = hc.Chain.tapered("forward-linear", 0.03, beads=20)
    times = np.linspace(0.5, 20.0, 40)
    run = hc.simulate(chain, times=times)
    expected = trajectory(chain.radii, 20.0).sol(times)
    np.testing.assert_array_equal(run.times, times)
    np.testing.assert_allclose(run.positions.T, expected[:20], atol=1e-10)
    np.testing.assert_allclose(run.velocities.T, expected[20:], atol=1e-10)


radii_lists = st.lists(st.floats(0.3, 3.0), min_size=4, max_size=16)


@settings(max_examples=25)
@given(radii_lists)
def test_any_chain_conserves(radii):
    run = hc.simulate(hc.Chain.from_radii(radii), times=0)
    # Light beads that rattle between heavy ones: up to 3e-10 has been met.
    assert run.energy_drift < 1e-9
    assert run.momentum_drift < 1e-13
    assert np.all(np.isfinite(run.pulse().velocity))


@settings(max_examples=15)
@given(radii_lists, st.floats(1e-3, 1e3))
def test_the_unit_of_radii_plays_no_part(radii, unit):
    plain = hc.simulate(hc.Chain.from_radii(radii), times=0).pulse()
    scaled = hc.simulate(hc.Chain.from_radii(np.array(radii) * unit), times=0).pulse()
    np.testing.assert_allclose(scaled.velocity, plain.velocity, rtol=1e-9)


def test_beads_far_ahead_change_nothing():
    short = hc.simulate(hc.Chain.tapered("backward-linear", 0.2, beads=40), times=0).pulse()
    long = hc.simulate(hc.Chain.tapered("backward-linear", 0.2, beads=60), times=0).pulse()
    np.testing.assert_allclose(long.velocity[:28], short.velocity[:28], rtol=1e-10)
    assert abs(long.velocity[39] / short.velocity[39] - 1) > 0.1


def test_tolerance_sets_the_error():
    exact = 0.681631548571
    errors = [
        abs(hc.simulate(hc.Chain.uniform(80), times=0, rtol=rtol).pulse().velocity[60] / exact - 1)
        for rtol in (1e-6, 1e-9, 1e-12)
    ]
    assert errors[0] > 10 * errors[1] > 100 * errors[2]
    assert errors[1] < 1e-8


def test_a_run_can_be_cut_into_pieces_without_a_trace(monkeypatch):
    chain = hc.Chain.tapered("backward-exponential", 0.1, beads=30)
    whole = hc.simulate(chain, times=100)
    monkeypatch.setattr("hertzchain.simulation.simulate.BEAD_STEPS_PER_CALL", 1)
    pieces = hc.simulate(chain, times=100)
    np.testing.assert_array_equal(pieces.velocities, whole.velocities)
    np.testing.assert_array_equal(pieces.pulse().velocity, whole.pulse().velocity)


def test_the_grid_of_saved_times_is_even_and_bounded():
    run = hc.simulate(hc.Chain.tapered("backward-exponential", 0.3, beads=40), times=64)
    assert 32 <= len(run.times) <= 64
    np.testing.assert_allclose(np.diff(run.times), run.times[1], rtol=1e-12)
    assert run.end_time - run.times[-1] < 2 * run.times[1]


def test_extreme_chain_within_range_and_one_that_underflows():
    pulse = hc.propagate(hc.Chain.tapered("backward-exponential", 0.5, beads=250))
    assert np.log(pulse.velocity[200] / pulse.velocity[199]) == pytest.approx(-1.507247, abs=1e-6)
    with pytest.raises(hc.SimulationError, match="too small to represent"):
        hc.simulate(hc.Chain.tapered("backward-exponential", 0.5, beads=330), times=0)


@pytest.mark.long
@pytest.mark.parametrize(
    "radii",
    [[1, 30, 1], [1, 200, 1], [1, 1, 1, 150, 1, 1], [1, 0.1, 20], [1, 0.05, 8], [1, 0.3, 1, 1, 1]],
)
def test_light_and_heavy_beads_among_others(radii):
    run = hc.simulate(hc.Chain.from_radii(radii), times=0)
    velocities, times = peaks(radii, run.end_time, foot=1e-10)
    pulse = run.pulse()
    np.testing.assert_allclose(pulse.velocity[1:-1], velocities, rtol=1e-7)
    np.testing.assert_allclose(pulse.peak_time[1:-1], times, rtol=1e-6)


@pytest.mark.parametrize("radii", [[1, 0.3, 1, 1, 1], [1, 0.1, 1, 1, 1], [1, 0.03, 1, 1, 1]])
def test_a_bead_that_turns_twice_in_a_step_is_seen_the_first_time(radii):
    chain = hc.Chain.from_radii(radii)
    loose, tight = (hc.simulate(chain, times=0, rtol=rtol).pulse() for rtol in (1e-6, 1e-13))
    np.testing.assert_allclose(loose.arrival, tight.arrival, rtol=1e-5)
    np.testing.assert_allclose(loose.peak_overlap, tight.peak_overlap, rtol=1e-5)


def test_one_collision_with_a_very_heavy_bead():
    pulse = hc.simulate(hc.Chain.from_radii([1, 127]), times=0).pulse()
    assert pulse.velocity[1] == pytest.approx(2 / (1 + 127**3), rel=1e-10)


def test_a_run_ends_when_nothing_more_happens():
    run = hc.simulate(hc.Chain.from_radii([1, 1e10, 1]))
    assert run.status == "nothing more happens"
    # Bead 3 is pushed with 2e-30.
    assert run.end_time < 1e8
    assert "the pulse had passed 1 of 3 beads" in run.message
    # The striker bounces off a bead that is as good as a wall.
    assert run.velocities[-1, 0] == pytest.approx(-1.0, abs=1e-12)
    with pytest.raises(hc.SimulationError, match="1 of 3 beads"):
        hc.propagate(run.chain)


def test_saved_times_are_right_where_the_grid_has_grown():
    chain = hc.Chain.tapered("backward-linear", 0.9, beads=20)
    grown = hc.simulate(chain, times=3000, rtol=1e-9)
    given = hc.simulate(chain, times=grown.times, rtol=1e-9)
    np.testing.assert_allclose(grown.velocities, given.velocities, atol=1e-8)


def test_a_step_with_nan_is_rejected():
    from hertzchain.kernels.dop853 import STAGES
    from hertzchain.kernels.dop853_step import error_norm

    stages = np.full((STAGES, 6), np.nan)
    norm = callable_from_python(error_norm)
    assert np.isnan(norm(0.1, stages, np.ones(3), 1e-9, np.empty((2, 6))))


def test_residence_keeps_its_digits_where_the_clock_has_lost_them():
    chain = hc.Chain.tapered("forward-exponential", 0.3, beads=100)
    pulse = hc.simulate(chain, times=0).pulse()
    ratio = pulse.residence[80:85] / pulse.residence[79:84]
    # Exact scale symmetry: the same ratio from bead to bead.
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-4)
    by_difference = np.diff(pulse.arrival)[80:85] / np.diff(pulse.arrival)[79:84]
    assert np.ptp(by_difference) > 10 * np.ptp(ratio)


def test_a_run_that_cannot_finish_says_so():
    with pytest.raises(hc.SimulationError, match=r"step limit .* raise max_steps"):
        hc.simulate(hc.Chain.uniform(50), max_steps=100)
    run = hc.simulate(hc.Chain.uniform(50), max_steps=100, check=False)
    assert (run.status, run.success, run.steps) == ("step limit", False, 100)
    passed = run.beads_passed
    assert 1 < passed < 50
    assert np.isfinite(run.pulse().velocity[:passed]).all()


def test_a_run_stopped_early_has_the_pulse_it_has_seen():
    chain = hc.Chain.uniform(50)
    run, whole = hc.simulate(chain, until=10.0), hc.simulate(chain, times=0).pulse()
    assert run.status == "time reached"
    assert run.times[-1] == 10.0
    pulse = run.pulse()
    for name, values in whole.columns().items():
        seen = np.isfinite(pulse.column(name))
        assert 7 <= np.count_nonzero(seen) <= 9
        np.testing.assert_allclose(pulse.column(name)[seen], values[seen], rtol=1e-12)
        assert "before the end of the run" in pulse.notes[name]


def test_weak_pulses_of_compressed_chains_are_not_lost():
    """The velocity of bead 2 is proportional to the impact, however small its overlaps are."""
    wall = hc.Wall()
    held = hc.Chain.uniform(5).replace(precompression=1.0, left_wall=wall, right_wall=wall)
    found = []
    for velocity in (1e-6, 1e-9):
        run = hc.simulate(held.replace(velocities=[velocity, 0.0, 0.0, 0.0, 0.0]), until=6.0)
        found.append(run.pulse().velocity[1] / velocity)
    assert found[1] == pytest.approx(found[0], rel=1e-5)


@pytest.mark.parametrize(
    ("parts", "moves"),
    [
        ({}, False),
        ({"precompression": 1.0, "held_by": "force"}, False),
        ({"precompression": 1.0, "left_wall": hc.Wall(), "held_by": "force"}, False),
        ({"gravity": 0.1, "right_wall": hc.Wall()}, False),
        ({"gravity": 0.1}, True),
        ({"gravity": 0.1, "right_wall": hc.Wall(gap=0.5)}, True),
        ({"drive": hc.SineBurst(0.1, 0.1)}, True),
        ({"velocities": [-1.0, 0.0, 0.0]}, True),
    ],
)
def test_a_run_in_which_nothing_moves_says_so(parts, moves):
    chain = hc.Chain.uniform(3).replace(**({"velocities": np.zeros(3)} | parts))
    run = hc.simulate(chain, until=5.0)
    assert (np.abs(run.velocities).max() > 1e-3) == moves
    said = "nothing moves, because bead 1 is not struck; give it a velocity, a striker or a drive"
    assert (said in run.message) != moves


def test_a_striker_that_falls_onto_a_column_moves():
    column = hc.Chain.from_materials(
        "5 mm",
        "steel-52100",
        beads=3,
        velocity=0,
        gravity=9.81,
        right_wall=hc.Wall.of("steel-52100"),
    )
    run = hc.simulate(column.struck_by(velocity=0, gap="5 mm"), until="33 ms")
    assert "nothing moves" not in run.message
    assert "nothing moves" in hc.simulate(column, until="33 ms").message


def test_no_pulse_where_no_contact_was_reached():
    chain = hc.Chain.uniform(3).replace(gaps=[2.0, 0.0])
    with pytest.raises(hc.SimulationError, match=r"stopped as requested at t = 1,.*no contact was"):
        hc.simulate(chain, until=1.0).pulse()
    assert np.isnan(hc.simulate(chain, until=2.1).pulse().velocity).tolist() == [False, True, True]


def test_progress_is_reported_and_interrupts_are_handled():
    told = []
    hc.simulate(hc.Chain.uniform(5000), times=0, progress=lambda *now: told.append(now))
    assert told[-1] == (5000, 5000)
    assert told == sorted(told)
    assert len(told) > 2

    def interrupt(*_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        hc.simulate(hc.Chain.uniform(300), progress=interrupt)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"until": -1.0}, "until must be above 0.*, got -1"),
        ({"until": "soon"}, "until must be a number, got 'soon'"),
        ({"rtol": 0.1}, "rtol must be at least 1e-14 and at most 1e-06, got 0.1"),
        ({"rtol": "1e-9"}, "rtol '1e-9' is text; give the number 1e-9 without quotes"),
        ({"until": True}, "until must be a number"),
        ({"max_steps": True}, "whole number"),
        ({"times": True}, "whole number or a list"),
        ({"times": 1}, "0 or at least 2"),
        ({"times": [2.0, 1.0]}, "increasing"),
        ({"times": [1.0, float("nan")]}, "finite"),
        ({"times": ["now"]}, "time of entry 1 is 'now'"),
        ({"times": []}, "list of increasing numbers"),
        ({"times": [1.0, 9.0], "until": 5.0}, "stops at until = 5"),
        ({"times": 10**12}, "GiB are free; save fewer times"),
        ({"max_steps": 0}, "at least 1, got 0"),
        ({"max_steps": 2.5}, "whole number"),
    ],
)
def test_bad_options_are_rejected_in_one_sentence(options, said):
    with pytest.raises(hc.InputError, match=said):
        hc.simulate(hc.Chain.uniform(5), **options)


def test_run_as_dataset(uniform_run):
    dataset = uniform_run.to_xarray()
    assert dataset.velocity.dims == ("time", "bead")
    assert dataset.bead.values[0] == 1
    label = {"long_name": "velocity of the bead", "symbol": "v"}
    assert dataset.velocity.attrs == label
    assert "rate" not in dataset.attrs
    taper = hc.Chain.tapered("forward-exponential", 0.03, beads=5)
    assert hc.simulate(taper, until=1.0, times=2).to_xarray().attrs["rate"] == 0.03


def test_motion_too_fast_for_any_clock_is_rejected():
    for chain in (
        hc.Chain.uniform(5).replace(masses=np.full(5, 1e-300), stiffness=np.full(4, 1e300)),
        hc.Chain.uniform(3).replace(velocities=[1e-90, 0.0, 0.0], stiffness=np.full(2, 1e300)),
    ):
        with pytest.raises(hc.InputError, match="pass contact 1 in 0( s)?, too short a time"):
            hc.simulate(chain)


@pytest.mark.parametrize(
    ("changes", "advice"),
    [
        ({"loss": hc.Dashpot(1e12)}, "use a weaker loss if"),
        ({"precompression": 1e9, "held_by": "force"}, "use less precompression if"),
        ({"right_wall": hc.Wall(stiffness=1e30)}, "use a softer right wall if"),
        ({}, "use fewer beads if"),
        ({"radii": [1.0, 0.9, 0.8]}, "use fewer beads or a weaker taper if"),
        ({"right_wall": hc.Wall()}, "use fewer beads if"),
        ({"radii": [1.0, 0.9, 0.8], "right_wall": hc.Wall.rigid()}, "beads or a weaker taper if"),
        ({"radii": [1.0, 1e-18, 1e-36]}, "must resolve both; use fewer beads or a weaker taper"),
        ({"radii": [1.0, 1e-36, 1e-18]}, "resolve both; use fewer beads or more similar beads"),
    ],
)
def test_advice_fits_what_is_stiff(changes, advice):
    chain = hc.Chain.uniform(3).replace(**changes)
    run = hc.simulate(chain, until=9.0, max_steps=10, check=False)
    assert run.status == "step limit"
    assert advice in run.message


def test_beads_that_do_not_part_again():
    chain = hc.Chain.uniform(3).replace(loss=hc.Viscoelastic(1e300))
    with pytest.warns(hc.ModelRangeWarning, match="relaxation time"):
        run = hc.simulate(chain)
    assert run.pulse().velocity[-1] == pytest.approx(1.0 / 3.0, rel=1e-12)


def test_a_run_is_compared_with_the_path_of_its_traces():
    traces, chain = hc.example_experiment()
    run = hc.simulate(hc.load_chain(chain), until=6e-4, times=1201)
    by_path = run.compare(chain.parent / "fast.csv")
    assert by_path.differences == run.compare(traces).differences
    assert run.compare(str(chain.parent / "fast.csv")).differences == by_path.differences


def test_a_long_run_writes_a_line_every_five_seconds():
    lines, now = [], [100.0]
    report = slow_run.slow_run_notice(lines.append, lambda: now[0])
    for second in range(15):
        now[0] = 100.0 + second
        report(second, 40)
    assert lines == [
        "hertzchain: simulating for 5 s; the pulse has passed 5 of 40 beads; a larger rtol or a "
        "smaller until shortens the run",
        "hertzchain: simulating for 10 s; the pulse has passed 10 of 40 beads",
    ]


def test_only_runs_without_progress_write_lines(monkeypatch):
    lines, calls = [], []
    monkeypatch.setattr(slow_run, "INTERVAL", 0.0)
    monkeypatch.setattr(compile_notice, "write_line", lines.append)
    chain = hc.Chain.uniform(5)
    hc.simulate(chain, progress=lambda *passed: calls.append(passed))
    assert (lines, calls[-1]) == ([], (5, 5))
    hc.simulate(chain)
    assert lines[-1].endswith("the pulse has passed all beads")

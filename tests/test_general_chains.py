"""Runs of general chains, compared with independent results."""

import warnings

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from kernel_call import callable_from_python
from scipy_chain import trajectory

import hertzchain as hc
from hertzchain.chain.equilibrium import equilibrium
from hertzchain.simulation.kernel_input import drive_pieces, kernel_chain, steps_are_implicit
from hertzchain.simulation.largest_overlaps import largest_between

LAWS = [
    None,
    hc.Restitution(0.8),
    hc.Restitution(0.5, attractive=False),
    hc.Viscoelastic(0.05),
    hc.UnloadingRatio(0.1),
    hc.UnloadingRatio(0.8),
    hc.WaltonBraun(0.6),
    hc.Dashpot(0.05),
    hc.Dashpot(0.2, attractive=False),
    hc.VelocityPower(0.05, 1.81),
    hc.VelocityPower(0.05, 0.5),
    hc.VelocityPower(0.2, 0.2, attractive=False),
    hc.Dashpot(1e4),
]
# Where the pulse is at t = 12, so that everything has happened by 30.
SHORT = hc.Chain.tapered("forward-linear", 0.05, beads=12)


@pytest.mark.parametrize(
    "changes",
    [
        {"right_wall": hc.Wall(gap=0.3), "left_wall": hc.Wall.rigid()},
        {"gaps": np.linspace(0.0, 0.2, 11)},
        {"gravity": 0.05, "right_wall": hc.Wall()},
        {"precompression": 0.2, "held_by": "force"},
        {"precompression": 0.2, "left_wall": hc.Wall(), "right_wall": hc.Wall()},
        {"drive": hc.SineBurst(0.3, 0.1, cycles=2.0)},
        {
            "drive": hc.SineBurst(0.3, 0.1, cycles=2.0, of="displacement"),
            "left_wall": hc.Wall(),
        },
        {"drive": hc.StepDrive(0.3, rise=2.0)},
        {"loss": hc.Restitution(0.8), "right_wall": hc.Wall()},
        {
            "loss": hc.Viscoelastic(0.05, attractive=True),
            "gravity": 0.02,
            "right_wall": hc.Wall(),
        },
    ],
    ids="+".join,
)
def test_trajectories_against_scipy(changes):
    chain = SHORT.replace(**changes)
    times = np.linspace(0.0, 30.0, 61)
    run, motion = hc.simulate(chain, times=times), trajectory(chain, times, rtol=1e-13)
    np.testing.assert_allclose(run.positions - run.positions[0], motion.displacements, atol=1e-9)
    np.testing.assert_allclose(run.velocities, motion.velocities, atol=1e-9)


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_the_budget_adds_up(law):
    chain = SHORT.replace(loss=law, gravity=0.02, right_wall=hc.Wall(), gaps=np.full(11, 0.01))
    run = hc.simulate(chain, until=80.0, times=300)
    budget = run.budget()
    for of in ("energy", "momentum"):
        # Measured: 1.7e-11 by implicit steps, whose tolerance is 1e-11 at least.
        assert np.abs(budget.residual(of)).max() < (5e-11 if steps_are_implicit(chain) else 1e-11)
    assert np.all(np.diff(budget.energy["lost"]) > -1e-12)
    assert (budget.energy["lost"][-1] > 1e-3) == (law is not None)
    assert run.energy_drift < (5e-11 if steps_are_implicit(chain) else 1e-11)


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_a_run_resumes_from_its_state_bit_for_bit(law):
    chain = SHORT.replace(loss=law, right_wall=hc.Wall())
    whole = hc.simulate(chain, until=40.0, times=80)
    first = hc.simulate(chain, until=13.7, times=0)
    second = hc.simulate(chain, start=first.state, until=40.0, times=whole.times[30:])
    for name in ("positions", "velocities", "forces"):
        np.testing.assert_array_equal(getattr(second, name), getattr(whole, name)[30:])
    assert second._impulses[1] == whole._impulses[1]
    for name in ("walls", "completion"):
        np.testing.assert_array_equal(second.state.arrays[name], whole.state.arrays[name])
    assert (second.steps, second.energy_drift) == (whole.steps, whole.energy_drift)
    np.testing.assert_array_equal(second.pulse().velocity, whole.pulse().velocity)


@pytest.mark.parametrize("changes", [{}, {"right_wall": hc.Wall(), "gravity": 0.01}])
def test_lossless_runs_go_back_where_they_came_from(changes):
    chain = SHORT.replace(**changes)
    state = hc.simulate(chain, until=25.0).state
    back = hc.simulate(chain, start=state.reversed(), times=[state.time])
    # Rounding grows with every contact that opens and closes.
    np.testing.assert_allclose(back.velocities[0], -chain.velocities, atol=2e-8)
    np.testing.assert_allclose(back.positions[0], equilibrium(chain).positions, atol=2e-8)


@pytest.mark.parametrize(
    ("changes", "cause"),
    [
        ({"loss": hc.Dashpot(0.1)}, "losses"),
        ({"right_wall": hc.Wall(loss=hc.Restitution(0.5))}, "losses"),
        ({"velocities": None, "drive": hc.StepDrive(1.0)}, "a drive"),
    ],
)
def test_chains_with_losses_or_drives_cannot_be_reversed(changes, cause):
    state = hc.simulate(SHORT.replace(**changes), until=1.0).state
    with pytest.raises(hc.InputError, match=f"a chain with {cause} cannot be reversed"):
        state.reversed()


def test_fifty_reflections_without_drift():
    """The runs are chaotic, so that the drift of a single one depends on rounding errors."""
    chain = hc.Chain.uniform(10).replace(left_wall=hc.Wall(), right_wall=hc.Wall.rigid())
    runs = [
        hc.simulate(chain.replace(velocities=speed * chain.velocities), until=600.0, times=0)
        for speed in (1.0, 1.0 + 1e-12, 1.0 + 2e-12)
    ]
    assert np.median([run.energy_drift for run in runs]) < 3e-10
    assert max(run.momentum_drift for run in runs) < 2e-12


def test_a_chain_at_rest_stays_at_rest():
    for law in LAWS:
        chain = hc.Chain.uniform(8).replace(
            gravity=0.1, right_wall=hc.Wall(), velocities=np.zeros(8), loss=law
        )
        run = hc.simulate(chain, until=100.0, times=2)
        np.testing.assert_allclose(run.forces[-1], equilibrium(chain).forces, atol=1e-13)
        assert np.abs(run.velocities[-1]).max() < 1e-13


def test_a_falling_bead_falls_freely():
    chain = hc.Chain.uniform(2).replace(
        gravity=0.5, velocities=[0.0, 0.0], right_wall=hc.Wall(gap=1.0)
    )
    run = hc.simulate(chain, times=[1.0, 1.9])
    np.testing.assert_allclose(run.positions[:, 1], [0.25, 0.25 * 1.9**2], rtol=1e-13)


@pytest.mark.parametrize(
    ("build", "place"),
    [
        (lambda gap: hc.Chain.uniform(3).replace(gaps=[0.0, gap]), "gap of contact 2"),
        (lambda gap: hc.Chain.uniform(3).struck_by(gap=gap), "gap"),
        (lambda gap: hc.Chain.uniform(3).replace(right_wall=hc.Wall(gap=gap)), "gap to a wall"),
    ],
)
def test_the_rounding_of_gaps_is_limited(build, place):
    with pytest.raises(hc.InputError, match=f"^{place} must be .*at most 1e.08, got 1e.10; a gap"):
        build(1e10)
    pulses = [hc.simulate(build(gap), times=0).pulse().velocity for gap in (10.0, 1e8)]
    np.testing.assert_allclose(*pulses, rtol=1.5e-6)


def test_beads_with_gaps_meet_when_they_must():
    chain = hc.Chain.uniform(3).replace(gaps=[2.0, 5.0])
    run = hc.simulate(chain, times=[1.99, 2.0 + 2.9433 + 3.0])
    assert run.velocities[0].tolist() == [1.0, 0.0, 0.0]
    # Equal beads exchange their velocities; the second has not reached the third.
    np.testing.assert_allclose(run.velocities[1], [0.0, 1.0, 0.0], atol=1e-12)


def test_sticking_contacts_are_found_and_hold():
    """With w = 0.9 a contact can neither close nor open under forces between F and F/10."""
    from hertzchain.kernels.forces import STUCK

    chain = hc.Chain.uniform(8).replace(
        gravity=0.2, velocities=np.zeros(8), right_wall=hc.Wall(gap=0.3),
        loss=hc.UnloadingRatio(0.9),
    )  # fmt: skip
    run = hc.simulate(chain, until=60.0, times=200)
    assert np.count_nonzero(run.state.arrays["mode"] == STUCK) >= 6
    # Settled: the forces are the weights above, though the overlaps are others.
    np.testing.assert_allclose(run.forces[-1, 1:], 0.2 * np.arange(1, 9), rtol=1e-9)
    assert np.abs(run.budget().residual("energy")).max() < 1e-11


def test_dents_stay():
    chain = hc.Chain.uniform(2).replace(loss=hc.WaltonBraun(0.5))
    run = hc.simulate(chain, until=20.0, times=[20.0])
    largest = (2.5 * 0.5 / 2) ** 0.4
    assert run.state.arrays["largest"][1] == pytest.approx(largest, rel=1e-10)


def test_walls_feel_what_the_chain_loses():
    chain = hc.Chain.uniform(20).replace(right_wall=hc.Wall())
    run = hc.simulate(chain, until=80.0, times=4000)
    wall = run.wall_force()
    assert wall.impulse == pytest.approx(1.0 - run.velocities[-1].sum(), rel=1e-12)
    sampled = np.trapezoid(wall.force, wall.times)
    assert sampled == pytest.approx(wall.impulse, rel=1e-6)
    assert 0.0 <= wall.peak - wall.force.max() < 1e-4
    assert wall.first_contact_impulse == wall.impulse_of_impact < wall.impulse
    with pytest.warns(hc.IncompleteWarning, match="had not reached the right wall at t = 20,"):
        early = hc.simulate(chain, until=20.0).wall_force()
    assert early.first_contact_impulse is None


def test_sensors_see_the_forces_around_them():
    run = hc.simulate(SHORT, until=12.0)
    np.testing.assert_array_equal(run.sensor(5), (run.force(4) + run.force(5)) / 2)
    mass = SHORT.masses[4]
    acceleration = np.gradient(run.velocity(5), run.times)
    net = (run.force(4) - run.force(5)) / mass
    np.testing.assert_allclose(acceleration[1:-1], net[1:-1], atol=6e-3)


def test_balls_are_counted_without_the_strikers():
    chain = hc.Chain.uniform(9).struck_by(count=2).replace(right_wall=hc.Wall())
    run = hc.simulate(chain, until=12.0)
    mean = (run.force(5) + run.force(6)) / 2
    for name in ("ball 4", " Ball  4", "bead 6", 6):
        np.testing.assert_array_equal(run.sensor(name), mean)
        np.testing.assert_array_equal(run.velocity(name), run.velocities[:, 5])
        np.testing.assert_array_equal(run.position(name), run.positions[:, 5])
        found = run.sensor_force(name)
        assert found.bead == 6
        assert found.largest_so_far == pytest.approx(mean.max(), rel=1e-3)
    with pytest.raises(hc.InputError, match="no ball 10: the chain has 9 balls after its strikers"):
        run.sensor_force("ball 10")
    np.testing.assert_array_equal(run.sensor("wall"), run.force(11))
    with pytest.raises(hc.InputError, match="a name such as 'ball 9' .* got 'wal'"):
        run.sensor("wal")


def test_overlaps_are_those_of_the_forces():
    chain = hc.Chain.uniform(9).replace(
        left_wall=hc.Wall(), right_wall=hc.Wall(gap=0.05), gaps=[0.1] + [0.0] * 7
    )
    run = hc.simulate(chain, until=20.0, times=400)
    for k in range(10):
        overlap = run.overlap(k)
        assert overlap.min() < 0.0
        assert overlap.max() > 0.0 or k == 0
        law = chain.contact_stiffness[k] * np.maximum(overlap, 0.0) ** 1.5
        np.testing.assert_allclose(run.force(k), law, rtol=1e-9, atol=1e-14)
    with pytest.raises(
        hc.InputError, match="contact 0 has no overlap: the left end of this chain is free"
    ):
        hc.simulate(hc.Chain.uniform(3)).overlap(0)


@pytest.mark.parametrize(
    "drive",
    [
        hc.SineBurst(2.0, 0.7, cycles=3.0),
        hc.SineBurst(2.0, 0.7, cycles=0.5, window="none"),
        hc.StepDrive(1.5, rise=2.0),
        hc.StepDrive(1.5),
        hc.TableDrive([0.5, 1.0, 3.0], [1.0, -2.0, 0.5]),
        hc.TableDrive([-1.0, 1.0], [0.0, 2.0]),
    ],
    ids=repr,
)
def test_pieces_of_drives_are_the_drives(drive):
    from hertzchain.kernels.driving import PUSH, drive_at

    starts, pieces = drive_pieces(drive)
    chain = hc.Chain.uniform(2).replace(drive=hc.StepDrive(1.0))
    setup = kernel_chain(chain)._replace(drive=PUSH, piece_starts=starts, pieces=pieces)
    times = np.linspace(0.013, 5.0, 97)
    value = callable_from_python(drive_at)
    values = [value(t, setup, np.searchsorted(starts, t, "right") - 1)[0] for t in times]
    np.testing.assert_allclose(values, drive.value(times), atol=1e-13)


def test_the_work_of_a_drive():
    chain = hc.Chain.uniform(30).replace(drive=hc.StepDrive(0.5))
    run = hc.simulate(chain, until=20.0, times=2)
    budget = run.budget()
    assert budget.momentum_given["drive"][-1] == pytest.approx(0.5 * 20.0, rel=1e-13)
    assert budget.energy_given["drive"][-1] == pytest.approx(0.5 * run.positions[-1, 0], rel=1e-11)


# A force that is cut off within an implicit step: the energy lost then limits the step.
@example(
    [1.5, 1.875, 0.6875], hc.VelocityPower(0.2, alpha=0.2, attractive=False), 0.0625, 0.08203125
)
@settings(max_examples=20)
@given(
    st.lists(st.floats(0.5, 2.0), min_size=3, max_size=10),
    st.sampled_from(LAWS),
    st.floats(0.0, 0.1),
    st.floats(0.0, 0.1),
)
def test_general_chains_conserve_energy_and_momentum(radii, law, gravity, gap):
    chain = hc.Chain.from_radii(radii).replace(
        loss=law, gravity=gravity, right_wall=hc.Wall(), gaps=np.full(len(radii) - 1, gap)
    )
    run = hc.simulate(chain, until=60.0, times=50)
    assert run.energy_drift < 1e-9
    assert np.abs(run.budget().residual("energy")).max() < 1e-9
    assert np.abs(run.budget().residual("momentum")).max() < 1e-11


@settings(max_examples=10)
@given(st.sampled_from(LAWS[:2] + LAWS[4:7]), st.floats(0.1, 10.0))
def test_units_of_time_play_no_part(law, speed):
    """Without a time scale, speeds are proportional to the impact velocity v, times to v^(-1/5)."""
    slow = SHORT.replace(loss=law, right_wall=hc.Wall())
    velocities = np.zeros(12)
    velocities[0] = speed
    fast = slow.replace(velocities=velocities)
    one, other = (hc.simulate(chain, times=0).wall_force() for chain in (slow, fast))
    assert other.peak / speed**1.2 == pytest.approx(one.peak, rel=1e-9)
    # Checks come 16 times in a transit of about 13.
    assert other.complete_since * speed**0.2 == pytest.approx(one.complete_since, abs=1.7)


def test_strikers_of_any_number():
    chain = hc.Chain.uniform(40).struck_by(count=3)
    pulse = hc.simulate(chain, times=0).pulse()
    assert pulse.velocity[:3].tolist() == [1.0, 1.0, 1.0]
    assert pulse.velocity[20] > 0.9


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"until": 5.0}, "starts at t = .* cannot stop at until = 5"),
        ({"times": [1.0, 20.0]}, "resumes from time .*, but the first time"),
    ],
)
def test_the_past_cannot_be_asked_for(options, said):
    state = hc.simulate(SHORT, until=10.0).state
    with pytest.raises(hc.InputError, match=said):
        hc.simulate(SHORT, start=state, **options)


def test_a_state_belongs_to_its_chain():
    state = hc.simulate(SHORT, until=1.0).state
    with pytest.raises(hc.InputError, match="another chain"):
        hc.simulate(hc.Chain.uniform(12), start=state, until=2.0)


def test_no_pulse_ends_a_driven_run():
    chain = hc.Chain.uniform(9).replace(drive=hc.StepDrive(1.0))
    with pytest.raises(hc.InputError, match="right end is free.*give until or a right_wall"):
        hc.simulate(chain)
    with pytest.raises(hc.InputError, match="drive of this chain does not end.*give until"):
        hc.simulate(chain.replace(right_wall=hc.Wall()))
    with pytest.raises(
        hc.InputError, match="not struck; give it a velocity, a striker or a drive, or until"
    ):
        hc.simulate(hc.Chain.uniform(9).replace(velocities=np.zeros(9)))


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (
            lambda run: run.force(99),
            "contact must .* from 0 to 12, where 0 and 12 are walls, got 99",
        ),
        (lambda run: run.sensor(0), "bead must be a whole number from 1 to 12, got 0"),
        (lambda run: run.velocity(1.5), "bead must be a whole number"),
        (lambda run: run.wall_force(), "right end of this chain is free"),
        (lambda run: run.wall_force("top"), "choose from left, right"),
        (lambda run: run.budget().residual("mass"), "unknown balance 'mass'"),
    ],
)
def test_what_a_run_cannot_tell(ask, said):
    with pytest.raises(hc.InputError, match=said):
        ask(hc.simulate(SHORT, until=1.0))


def test_leading_pulse_of_a_forward_taper_at_a_wall():
    chain = hc.Chain.tapered("forward-exponential", 0.05, beads=20)
    run = hc.simulate(chain.replace(right_wall=hc.Wall()), until=60.0, times=600)
    momentum = run.budget().momentum
    # A third of the strike's momentum reaches the wall at first, more later.
    assert 0.5 < momentum["leading pulse"].max() < 1.3
    assert momentum["right wall"][-1] > 1.5
    assert momentum["leading pulse"][-1] == 0.0


def test_a_train_of_waves_and_their_width():
    masses = np.ones(120)
    masses[0] = 8.0
    run = hc.simulate(hc.Chain.uniform(120).replace(masses=masses), until=120.0, times=4000)
    peaks = run.velocity_peaks(80)
    np.testing.assert_allclose(peaks.amplitudes[:3], [1.4413, 0.9331, 0.6331], atol=6e-5)
    assert np.all(np.diff(peaks.times) > 0.0)
    # Full width at half maximum of the exact wave: 1.57914 beads.
    speed = 0.9074700784 * peaks.amplitudes[0] ** 0.2
    assert peaks.widths[0] * speed == pytest.approx(1.57914, abs=6e-6)


BALLS = hc.Chain.from_materials(5e-3, "steel-52100", beads=6, velocity=0.3)
WALLED = BALLS.replace(
    right_wall=hc.Wall(), left_wall=hc.Wall(gap=1e-6), loss=hc.WaltonBraun(0.8), gravity=9.81
)
DRIVEN = BALLS.replace(
    velocities=None, drive=hc.StepDrive(20.0, rise=20e-6), loss=hc.Viscoelastic(1e-7)
)


@pytest.mark.parametrize("chain", [BALLS, WALLED, DRIVEN])
def test_a_run_in_other_units_is_the_run_of_the_chain_in_them(chain):
    scales = hc.Scales.of(chain, velocity=0.7)
    times = np.linspace(0.0, 200e-6, 41)
    in_si = hc.simulate(chain, times=times)
    scaled = hc.simulate(scales.to_scaled(chain), times=times / scales.time)
    for one, other in ((scales.to_scaled(in_si), scaled), (scales.to_si(scaled), in_si)):
        for ours, theirs in (
            (one.times, other.times),
            (one.positions, other.positions),
            (one.velocities, other.velocities),
            (one.forces, other.forces),
            (one.end_time, other.end_time),
            (one._crossings, other._crossings),
            (one._peaks, other._peaks),
            (one.state.start, other.state.start),
        ):
            np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-9 * np.abs(theirs).max())
        for of in ("energy", "momentum"):
            ours, theirs = one.budget().to_dataframe(of), other.budget().to_dataframe(of)
            largest = theirs.abs().to_numpy().max()
            np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-9 * largest)
            assert abs(one.budget().residual(of)).max() < 1e-9
        assert one.chain.units == other.chain.units
        if chain is WALLED:
            ours, theirs = one.wall_force("right"), other.wall_force("right")
            assert ours.peak == pytest.approx(theirs.peak, rel=1e-9)
            assert ours.peak_time == pytest.approx(theirs.peak_time, rel=1e-6)
            assert ours.impulse == pytest.approx(theirs.impulse, rel=1e-9)


def test_a_run_resumes_in_other_units():
    scales = hc.Scales.of(WALLED)
    state = scales.to_scaled(hc.simulate(WALLED, until=100e-6).state)
    times = np.linspace(100e-6, 200e-6, 11)
    later = hc.simulate(scales.to_scaled(WALLED), start=state, times=times[1:] / scales.time)
    whole = hc.simulate(WALLED, times=times)
    fastest = np.abs(whole.velocities).max()
    np.testing.assert_allclose(
        scales.to_si(later).velocities, whole.velocities[1:], rtol=0, atol=1e-9 * fastest
    )


def test_largest_overlaps_exist_at_the_foot_of_a_pulse():
    """Numbers ahead of a pulse whose squares underflow; found in a chain of steel balls."""
    times = np.array([0.0, 5e-8])
    overlaps = np.array([[0.0, 1e-6, 5e-324, 0.0], [0.0, 1.2e-6, 5e-324, 0.0]])
    velocities = np.array([[0.0, 1.43089e-317, 0.0], [0.0, -4.085854e-318, 0.0]])
    found = largest_between(times, overlaps, velocities)
    np.testing.assert_allclose(found, overlaps[1], rtol=1e-12, atol=1e-300)


def test_largest_overlaps_are_those_of_a_finely_saved_run():
    chain = WALLED.replace(loss=None)
    coarse = hc.simulate(chain, until=110e-6, times=0).largest_overlaps
    fine = hc.simulate(chain, until=110e-6, times=9001)
    apart = np.diff(np.pad(fine.positions, ((0, 0), (1, 1))), axis=1)
    seen = np.maximum(-apart - equilibrium(chain).gaps, 0.0).max(axis=0)
    np.testing.assert_allclose(coarse, seen, rtol=0, atol=3e-7 * seen.max())


@pytest.mark.parametrize("loss", [None, hc.Restitution(0.97), hc.Viscoelastic(1e-7)])
def test_largest_overlaps_of_later_waves_do_not_depend_on_the_saved_times(loss):
    # The forces of light beads have later maxima above the first.
    radii = np.linspace(10e-3, 2.5e-3, 25)
    chain = hc.Chain.from_materials(radii, "steel-52100", velocity=0.02)
    chain = chain.replace(right_wall=hc.Wall(), loss=loss)
    coarse = hc.simulate(chain, times=2)
    fine = hc.simulate(chain, times=40_001)
    apart = np.diff(np.pad(fine.positions, ((0, 0), (1, 1))), axis=1)
    seen = np.maximum(-apart, 0.0).max(axis=0)[1:-1]
    # The sampled maxima are up to (pi 36 ns / 20 us)^2 / 8 too small.
    np.testing.assert_allclose(coarse.largest_overlaps[1:-1], seen, rtol=1e-5)
    assert np.all(coarse.largest_overlaps[1:-1] > seen * (1.0 - 1e-9))
    assert np.any(coarse.largest_overlaps[1:-1] > 1.001 * coarse.pulse().peak_overlap)


@pytest.mark.parametrize("times", [2, 5, 10, 40, 100])
@pytest.mark.parametrize("loss", [None, hc.Restitution(0.9), hc.UnloadingRatio(0.2)])
def test_largest_overlaps_do_not_exceed_those_of_the_motion_between_few_saved_times(loss, times):
    """Between two walls, so few times are saved that a cubic through them means nothing."""
    wall = hc.Wall(gap=0.2)
    chain = hc.Chain.from_radii([1.0, 0.8, 1.2, 0.9, 1.0, 1.0, 1.0, 1.0])
    chain = chain.replace(left_wall=wall, right_wall=wall, loss=loss)
    coarse = hc.simulate(chain, until=40.0, times=times).largest_overlaps
    fine = hc.simulate(chain, until=40.0, times=8001)
    seen = -np.diff(np.pad(fine.positions, ((0, 0), (1, 1))), axis=1) - fine.chain.static_state.gaps
    # The sampled maxima are up to (0.005 / 2)^2 / 2 times the curvature too small.
    np.testing.assert_allclose(coarse[1:-1], seen.max(axis=0)[1:-1], rtol=2e-5)


def test_fixed_steps_do_not_interpolate_overlaps_between_few_saved_times():
    wall = hc.Wall()
    chain = hc.Chain.uniform(20).replace(left_wall=wall, right_wall=wall)
    largest = hc.simulate(chain, until=400.0, times=0).largest_overlaps
    for times in (20, 100):
        run = hc.simulate(chain, until=400.0, times=times, method="verlet", drift=1e-6)
        # Later waves differ, as the motion is unpredictable, but not by half.
        assert (run.largest_overlaps < 1.2 * largest).all(), times


def test_static_overlaps_count():
    held = BALLS.replace(left_wall=hc.Wall(), right_wall=hc.Wall(), precompression=50.0)
    run = hc.simulate(held.replace(velocities=np.zeros(6)), until=1e-5, times=2)
    static = (50.0 / held.contact_stiffness[:-1]) ** (2 / 3)
    np.testing.assert_allclose(run.largest_overlaps[:-1], static, rtol=1e-12)
    # A contact that is unloaded first has had its static overlap, whatever times are saved.
    unloaded = held.replace(precompression=5.0, velocities=[-1e-3, 0, 0, 0, 0, 0])
    for times in (0, 5):
        run = hc.simulate(unloaded, until=2e-6, times=times)
        assert run.largest_overlaps[1] == pytest.approx(0.1 ** (2 / 3) * static[1], rel=1e-12)


def test_a_run_out_of_the_range_of_hertz_warns_once():
    fast = BALLS.replace(velocities=[1.0, 0, 0, 0, 0, 0])
    with pytest.warns(hc.ModelRangeWarning) as caught:
        run = hc.simulate(fast)
    assert len(caught) == 1
    said = str(caught[0].message)
    assert said.startswith("simulation: pressure / yield is")
    assert (
        said.removeprefix("simulation: ") in hc.hertz_range(fast, run.largest_overlaps).violations
    )
    assert caught[0].filename == __file__
    with pytest.warns(hc.ModelRangeWarning) as caught:
        hc.simulate(hc.Chain.from_materials(5e-3, "aluminium", beads=5, velocity=200.0))
    said = [str(each.message).removeprefix("simulation: ") for each in caught]
    assert len(said) == 3
    assert said[0].startswith("pressure / yield is")
    assert said[1].startswith("overlap / radius is")
    assert said[2].startswith("speed / sound is")


def test_gentle_runs_and_those_without_materials_do_not_warn():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        hc.simulate(BALLS)
        hc.simulate(hc.Chain.uniform(5))
        hc.simulate(hc.Scales.of(BALLS, velocity=1e-3).to_scaled(BALLS))


def test_the_pulse_of_equal_beads_has_the_exact_speed_and_width():
    run = hc.simulate(hc.Chain.uniform(120), times=4000)
    pulse = run.pulse()
    # A bead is two radii long; the exact wave, by the fixed point of the travelling wave.
    exact = 0.9074700784 * pulse.velocity[99] ** 0.2
    assert pulse.speed[99] / 2.0 == pytest.approx(exact, rel=1e-9)
    assert run.pulse_width(100) == pytest.approx(1.57914, abs=6e-6)


def test_the_speed_of_a_pulse_in_steel():
    # The published check of these balls, struck with 1 m/s.
    steel = hc.Material("steel", density=7780.0, young=203e9, poisson=0.3)
    chain = hc.Chain.from_materials(5e-3, steel, beads=80)
    run = hc.simulate(chain, times=4000)
    assert run.pulse().speed[60] == pytest.approx(674.659, abs=6e-4)
    assert run.pulse_width(61) == pytest.approx(1.57914, abs=6e-6)
    scales = hc.Scales.of(chain)
    scaled = scales.to_scaled(run)
    ours = scaled.pulse().speed * scales.radius / scales.time
    np.testing.assert_allclose(ours, run.pulse().speed, rtol=1e-13)


def test_the_way_through_a_gap_counts_in_real_units():
    balls = hc.Chain.from_materials(5e-3, "steel-52100", beads=3, velocity=0.3)
    apart = balls.replace(gaps=[0.0, 1e-3])
    np.testing.assert_allclose(apart.centre_distances, [10e-3, 11e-3], rtol=1e-14)
    assert hc.modified_bca(hc.Chain.tapered("forward-linear", 0.005, beads=9)).speed is None


def test_no_width_where_the_pulse_has_not_been():
    run = hc.simulate(hc.Chain.uniform(20), until=8.0)
    with pytest.raises(hc.SimulationError, match="no width of the pulse at bead 15: stopped as"):
        run.pulse_width(15)
    with pytest.raises(hc.InputError, match="from 2 to 19"):
        run.pulse_width(20)


def test_a_width_from_few_times_is_announced():
    chain = hc.Chain.uniform(80, exponent=2.0)
    exact = hc.simulate(chain, times=4000).pulse_width(50)
    with pytest.warns(
        hc.InputWarning, match="an error of about 2%, because only 1.6 times"
    ) as seen:
        width = hc.simulate(chain, times=200).pulse_width(50)
    assert 0.005 < width / exact - 1.0 < 0.02
    advised = int(str(seen[0].message).partition("times=")[2].partition(" ")[0])
    assert hc.simulate(chain, times=advised).pulse_width(50) == pytest.approx(exact, rel=1e-5)


def test_a_width_that_is_not_seen_is_an_error():
    chain = hc.Chain.uniform(30)
    with pytest.raises(
        hc.SimulationError, match=r"among the 3 saved times .* times=\d+ is enough, or"
    ):
        hc.simulate(chain, times=4).pulse_width(10)
    # The last saved time is just past the crest.
    arrival = hc.simulate(chain).pulse().peak_time[9]
    times = np.linspace(0.0, arrival + 0.05, 500)
    with pytest.raises(hc.SimulationError, match="no width of the pulse at bead 10"):
        hc.simulate(chain, times=times).pulse_width(10)


@pytest.mark.parametrize(
    "law",
    [None, hc.UnloadingRatio(0.3), hc.VelocityPower(0.05, 1.81), hc.VelocityPower(0.05, 0.6)],
)
def test_a_run_in_pieces_is_the_run_at_once_also_where_beads_rest_and_fly(law):
    # The beads that are stepped follow from the state: few of them, ever others, back from a wall.
    chain = hc.Chain.tapered("backward-exponential", 0.1, beads=40).replace(
        loss=law, right_wall=hc.Wall.rigid()
    )
    end = hc.simulate(chain, times=0).end_time
    whole = hc.simulate(chain, until=2.0 * end, times=0)
    state = None
    while state is None or state.time < whole.state.time:
        state = hc.simulate(
            chain, start=state, until=2.0 * end, times=0, max_steps=11, check=False
        ).state
    # The last piece may have ended just before a check of the wall.
    state = hc.simulate(chain, start=state, until=2.0 * end, times=0).state
    for name, array in whole.state.arrays.items():
        assert np.array_equal(state.arrays[name], array), name


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
@pytest.mark.parametrize(("ratio", "rtol"), [(0.12, 1e-13), (0.18, 3e-10), (0.58, 3e-10)])
def test_contacts_that_stick_and_release_do_not_stop_the_run(ratio, rtol):
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=100)
    run = hc.simulate(
        chain.replace(loss=hc.UnloadingRatio(ratio)), times=0, rtol=rtol, max_steps=5000
    )
    assert np.all(np.diff(run.pulse().arrival) > 0.0)


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_the_first_contact_with_a_wall_ends_with_its_force(law):
    wall = hc.Wall(stiffness=1.0)
    chain = hc.Chain.uniform(3).replace(right_wall=wall, left_wall=wall, loss=law)
    run = hc.simulate(chain, until=20.0, times=4001)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hc.IncompleteWarning)  # of the peak
        felt = run.wall_force()
    pushed = felt.force != 0.0
    begin = int(np.argmax(pushed))
    if pushed[begin:].all():
        # A strong dashpot lets the beads creep apart for longer than this run.
        assert felt.first_contact_end is None
        return
    end = begin + int(np.argmin(pushed[begin:]))
    # The recorded end may be one step late, during free flight.
    assert run.times[end - 1] <= felt.first_contact_end < run.times[end] + 0.1
    sampled = np.trapezoid(felt.force[:end], run.times[:end])
    assert felt.first_contact_impulse == pytest.approx(sampled, rel=3e-3)


@pytest.mark.parametrize("law", [None, hc.Dashpot(0.1), hc.Viscoelastic(0.1)], ids=repr)
def test_a_wall_that_comes_and_goes_is_met(law):
    """Within a period the wall goes away and returns: no step may pass over its visit."""
    drive = hc.SineBurst(-0.6, 0.4, cycles=1.0, of="displacement", window="none")
    chain = hc.Chain.uniform(3).replace(left_wall=hc.Wall(gap=0.3), drive=drive, loss=law)
    run = hc.simulate(chain, times=[2.4])
    velocities = trajectory(chain, [0.0, 2.4]).velocities
    np.testing.assert_allclose(run.velocities[-1], velocities[-1], atol=9e-11)


@pytest.mark.parametrize("law", [None, hc.Dashpot(0.1)], ids=repr)
def test_a_bead_that_barely_reaches_a_wall(law):
    """Thrown up to a height of 0.25 below a wall at 0.2499."""
    chain = hc.Chain.uniform(2).replace(
        gravity=2.0, left_wall=hc.Wall(gap=0.2499), gaps=1e5, velocities=[-1.0, 0.0], loss=law
    )
    impulse = hc.simulate(chain, times=[5.0])._impulses[0]
    # Impulse of k d^p for undisturbed free flight, over the time 0.02 beyond the wall.
    t = np.linspace(-0.01, 0.01, 2001)
    d, closing = 1e-4 - t**2, -2.0 * t
    damped = 0.0 if law is None else 0.1 * closing
    force = np.sqrt(2.0) * np.maximum(d, 0.0) ** 1.5 + damped
    assert impulse == pytest.approx(np.trapezoid(force, t), rel=2e-3)


def test_a_chain_that_falls_freely_is_struck_as_one_at_rest():
    chain = hc.Chain.uniform(12).replace(masses=np.linspace(1.0, 3.0, 12))
    resting = hc.simulate(chain, until=25.0).pulse()
    for gravity in (0.1, -0.1):
        falling = hc.simulate(chain.replace(gravity=gravity), until=25.0)
        np.testing.assert_allclose(falling._crossings[0], resting.arrival[1:], rtol=1e-12)
        np.testing.assert_allclose(falling._crossings[1], resting.peak_overlap, rtol=1e-12)


def test_beads_that_part_do_not_hold_each_other():
    chain = hc.Chain.uniform(3).replace(velocities=[-1.0, 0.0, 0.0], loss=hc.Dashpot(0.5))
    assert (hc.simulate(chain, until=1.0).forces == 0.0).all()
    law = hc.Restitution(0.3, attractive=False)
    held = chain.replace(precompression=1.0, held_by="force", loss=law, velocities=[-9.0, 0, 0])
    run = hc.simulate(held, until=1.0, times=20)
    assert (run.forces >= 0.0).all()
    assert np.abs(run.budget().residual("energy")).max() < 1e-14


@pytest.mark.parametrize("window", ["none", "hann"])
def test_a_bead_that_a_drive_brings_to_rest_does_not_stop_the_clock(window):
    """A force whose impulse is zero, on a bead that it draws off the chain."""
    drive = hc.SineBurst(-0.5, 0.2, cycles=1.0, window=window)
    run = hc.simulate(hc.Chain.uniform(3).replace(drive=drive), times=[10.0], max_steps=2000)
    t = np.linspace(0.0, 5.0, 20001)
    moved = np.trapezoid((5.0 - t) * drive.value(t), t)
    assert run.positions[-1, 0] == pytest.approx(moved, rel=1e-7)
    assert np.abs(run.velocities[-1]).max() < 1e-14


def test_the_work_of_a_rising_force_on_a_free_bead():
    drive = hc.StepDrive(-0.5, rise=4.0)
    run = hc.simulate(hc.Chain.uniform(3).replace(drive=drive), until=6.0, times=99)
    assert np.abs(run.budget().residual("energy")).max() < 6e-11


@pytest.mark.parametrize(
    ("changes", "method"),
    [
        ({}, "RKN8(6)"),
        ({"right_wall": hc.Wall(), "gravity": 0.01, "drive": hc.StepDrive(0.1)}, "RKN8(6)"),
        ({"loss": hc.Dashpot(0.1)}, "DOP853"),
        ({"loss": hc.VelocityPower(0.2, alpha=0.2)}, "Radau IIA"),
    ],
)
def test_the_method_depends_on_the_forces(changes, method):
    assert hc.simulate(hc.Chain.uniform(5).replace(**changes), until=1.0, times=0).method == method

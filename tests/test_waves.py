"""Waves of a run against the exact solitary wave, symmetries, trains and known counts."""

import pickle
import re
import warnings

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import find_peaks, peak_prominences

import hertzchain as hc
from hertzchain.simulation.wave_events import MIN_SAMPLES, events_at


@pytest.fixture(scope="module")
def solitary():
    """Momentum, energy and force of the wave of unit beads, from its own velocity."""
    run = hc.simulate(hc.Chain.uniform(80), until=100.0, times=940)
    wave, velocity = hc.solitary_wave(), run.pulse().velocity[59]
    exact = {
        "momenta": wave.momentum(velocity),
        "energies": wave.energy(velocity),
        "amplitudes": wave.peak_force(velocity),
    }
    return run, exact, wave.speed(velocity)


def test_a_wave_that_crosses_an_interface_has_the_values_of_both_sides():
    chain = hc.Chain.from_radii(np.where(np.arange(120) < 60, 1.0, 0.5))
    waves = hc.simulate(chain, until=140.0, times=3000).waves()
    wave = waves[0]
    table = wave.to_dataframe().energy
    incident, transmitted = (f"{table.loc[k]:.4g}" for k in (30, 100))
    assert f"energy {incident} to {transmitted}" in " ".join(repr(wave).split())
    # The train beyond the interface has the energy of the incident wave.
    train = sum(float(each.to_dataframe().energy.loc[100]) for each in waves.passing(100))
    assert train == pytest.approx(table.loc[30], rel=0.03)
    # In equal beads, one value describes the whole track.
    assert " to 0." not in repr(hc.simulate(hc.Chain.uniform(60), until=60.0).waves()[0])


def test_a_wave_is_the_solitary_wave(solitary):
    run, exact, _ = solitary
    found = run.waves()
    assert len(found) == 1
    wave = found[0]
    assert wave.resolved
    # The pulse is the solitary wave from contact 40 on; the end affects contact 76.
    far = (wave.contacts > 40) & (wave.contacts < 75)
    for name, error in {"amplitudes": 1e-6, "momenta": 2e-8, "energies": 2e-8}.items():
        np.testing.assert_allclose(getattr(wave, name)[far], exact[name], rtol=error, err_msg=name)


def test_half_the_saved_times_are_not_enough_and_cost_digits_of_the_force_alone(solitary):
    run, exact, _ = solitary
    sparse = hc.simulate(run.chain, until=100.0, times=235)
    with pytest.raises(hc.InputError, match=r"only 4.1. are within .* times=\d+ is enough"):
        sparse.waves()
    events = [events_at(sparse, k, 0.1)[0] for k in range(41, 75)]
    assert not any(event.resolved for event in events)
    for name, error in {"amplitude": 3e-4, "momentum": 2e-8, "energy": 2e-8}.items():
        measured = [getattr(event, name) for event in events]
        plural = {"amplitude": "amplitudes", "momentum": "momenta", "energy": "energies"}[name]
        np.testing.assert_allclose(measured, exact[plural], rtol=error, err_msg=name)


def test_its_speed_and_width(solitary):
    run, _, speed = solitary
    wave = run.waves()[0]
    far = (wave.contacts > 40) & (wave.contacts < 75)
    slope = np.polyfit(wave.times[far], wave.contacts[far], 1)[0]
    assert slope == pytest.approx(speed, rel=1e-6)
    # Radii per time: two radii from contact to contact.  The first contacts are a little slower.
    assert wave.speed == pytest.approx(2.0 * speed, rel=3e-3)
    # The force of the exact wave follows from its overlap, where that is half^(2/3) of the largest.
    exact = hc.solitary_wave().overlap.width(0.5 ** (2.0 / 3.0))
    assert wave.width * speed == pytest.approx(exact, rel=2e-4)


@pytest.mark.parametrize("strikers", [1, 2, 3, 4, 5])
def test_so_many_strikers_make_so_many_waves(strikers):
    chain = hc.Chain.uniform(90).replace(
        velocities=np.repeat([1.0, 0.0], [strikers, 90 - strikers])
    )
    waves = hc.simulate(chain, until=100.0, times=1500).waves()
    assert len(waves) == len(waves.passing(60)) == strikers
    assert waves.right.waves == waves.waves
    assert len(waves.left) == 0


def test_the_train_of_a_heavy_striker():
    chain = hc.Chain.uniform(80).replace(masses=np.append(4.0, np.ones(79)))
    run = hc.simulate(chain, until=110.0, times=2200)
    train = run.waves().passing(60)
    assert len(train) == 4
    assert np.all(np.diff([wave.times[0] for wave in train]) > 0.0)
    # Forces from the velocities of the same waves, by the exact relation of a solitary wave.
    forces = hc.solitary_wave().peak_force(1.0) * run.velocity_peaks(61).velocities[:4] ** 1.2
    there = [wave.amplitudes[wave.contacts == 60].item() for wave in train]
    assert np.all(np.abs(there / forces - 1.0) < [1e-5, 1e-5, 1e-4, 3e-3])


def test_a_decorated_chain_at_its_resonance_carries_one_wave():
    waves = hc.simulate(hc.Chain.uniform(60).decorated(0.3), until=90.0, times=4000).waves()
    assert len(waves) == 1
    # The momentum of the solitary wave of the large beads: small ones only transmit.
    assert waves[0].momentum == pytest.approx(1.138, abs=2e-3)


def test_mirrored_chains_have_mirrored_waves():
    radii = np.random.default_rng(5).uniform(0.8, 1.2, 40)
    stuck = {"left_wall": None, "right_wall": hc.Wall()}
    velocities = np.append(1.0, np.zeros(39))
    # The same chain from the other end, with the units of its first bead.
    run = hc.simulate(
        hc.Chain.from_radii(radii).replace(velocities=velocities, **stuck), until=80.0, times=1600
    )
    chain = run.chain
    mirrored = hc.Chain.from_radii(np.ones(40)).replace(
        masses=chain.masses[::-1], stiffness=chain.stiffness[::-1], velocities=-velocities[::-1],
        left_wall=hc.Wall(stiffness=chain.wall_stiffness[1]),
    )  # fmt: skip
    image = hc.simulate(mirrored, until=80.0, times=1600)
    ours, theirs = run.waves(), image.waves()
    assert len(ours) == len(theirs) > 3

    def rows(waves, sign):
        return sorted(
            (wave.times[0], sign * wave.direction, len(wave.contacts), wave.energy)
            for wave in waves
        )

    np.testing.assert_allclose(rows(ours, 1), rows(theirs, -1), rtol=1e-6)
    flux, back = run.energy_flux(), image.energy_flux()
    np.testing.assert_allclose(flux.right, back.left[::-1], rtol=1e-6, atol=1e-9)


def test_waves_of_balls_are_those_of_their_scaled_chain():
    balls = hc.Chain.from_materials(5e-3, "steel-52100", beads=30, velocity=0.2)
    chain = balls.replace(right_wall=hc.Wall())
    scales = hc.Scales.of(chain)
    run = hc.simulate(scales.to_scaled(chain), until=60.0, times=900)
    plain, real = run.waves(), scales.to_si(run).waves()
    assert len(plain) == len(real) >= 2
    for ours, theirs in zip(plain, real, strict=True):
        assert theirs.amplitude == pytest.approx(scales.force * ours.amplitude, rel=1e-9)
        assert theirs.momentum == pytest.approx(scales.momentum * ours.momentum, rel=1e-9)
        assert theirs.energy == pytest.approx(scales.energy * ours.energy, rel=1e-9)
        assert theirs.width == pytest.approx(scales.time * ours.width, rel=1e-9)
        speed = scales.radius / scales.time * ours.speed
        assert theirs.speed == pytest.approx(speed, rel=1e-9)


def test_excess_over_a_static_force_is_what_counts():
    # A weak pulse on a strong precompression is sound: c = sqrt(K/m), K = p k^(1/p) F0^(1-1/p).
    chain = hc.Chain.uniform(60).replace(precompression=1.0, held_by="force")
    velocities = np.append(1e-3, np.zeros(59))
    run = hc.simulate(chain.replace(velocities=velocities), until=45.0, times=1500)
    front = run.waves()[0]
    assert front.direction == 1
    assert front.amplitude < 2e-3
    late = front.contacts > 30
    slope = np.polyfit(front.times[late], front.contacts[late], 1)[0]
    # The crest of the Airy front lags behind the sound.
    assert 0.95 * np.sqrt(1.5) < slope < np.sqrt(1.5)


def test_tables_and_pictures():
    chain = hc.Chain.uniform(30).replace(right_wall=hc.Wall())
    waves = hc.simulate(chain, until=60.0, times=600).waves()
    table = waves.to_dataframe()
    assert table.direction.tolist()[:2] == [1, -1]
    assert len(table) == len(waves) == len(list(waves))
    track = waves[0].to_dataframe()
    np.testing.assert_array_equal(track.time, waves[0].times)
    assert len(waves.plot().lines) >= len(waves)
    assert str(waves).splitlines()[1].startswith("  Wave(right, contacts 1 to 29")
    at = waves.at(30)
    assert at
    assert all(event.direction == 0 and np.isnan(event.momentum) for event in at)
    again = pickle.loads(pickle.dumps(waves))
    np.testing.assert_array_equal(again[1].energies, waves[1].energies)


def test_a_run_in_which_nothing_moves_has_no_waves():
    chain = hc.Chain.uniform(6).replace(velocities=np.zeros(6))
    run = hc.simulate(chain, until=3.0, times=50)
    assert len(run.waves()) == 0
    assert run.waves().to_dataframe().empty
    assert run.energy_flux().right.tolist() == [0.0] * 5
    assert "to the left 0 at" in repr(run.energy_flux())
    with pytest.raises(hc.SimulationError, match="no wave towards contact 5 passes contact 2"):
        run.reflection(2, 5)


def test_contacts_in_the_wrong_order_are_named():
    run = hc.simulate(hc.Chain.uniform(60), until=40.0, times=800)
    with pytest.raises(hc.SimulationError, match="waves from contact 10 do: exchange before and"):
        run.reflection(30, 10)


def test_weak_waves_that_are_not_resolved_are_marked():
    chain = hc.Chain.tapered("forward-exponential", 0.05, beads=40)
    radii = np.concatenate((np.ones(40), chain.radii[1:]))
    run = hc.simulate(hc.Chain.from_radii(radii), until=60.0, times=340)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        waves = run.waves()
    unresolved = [wave.resolved for wave in waves].count(False)
    assert f"{unresolved} of {len(waves)} waves" in str(told[0].message)
    assert all("may end early" in str(each.message) for each in told[1:])


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda run: run.waves(threshold=0.0), "threshold must be above 0"),
        (lambda run: run.waves(min_contacts=1), "min_contacts must be a whole number"),
        (lambda run: run.reflection(3, 3), "must be two contacts"),
        (lambda run: run.reflection(0, 5), "before must be a whole number from 1"),
        (lambda run: run.reflection(3, 99), "after must be a whole number from 0 to 12"),
        (lambda run: run.reflection(3, 9, since=5.0, until=4.0), "until must be above 5"),
        (lambda run: run.waves().passing(12), "contact must be a whole number from 1 to 11"),
        (lambda run: run.velocity_peaks(1), "bead must be a whole number from 2"),
        (lambda run: run.velocity_peaks("bead 1"), "bead must be a whole number from 2"),
        (lambda run: run.velocity_peaks("wall"), "a name such as 'ball 11'"),
    ],
)
def test_what_cannot_be_asked(ask, said):
    run = hc.simulate(hc.Chain.uniform(12), until=10.0, times=200)
    with pytest.raises(hc.InputError, match=said):
        ask(run)


@pytest.mark.parametrize("ask", ["waves", "energy_flux", "reflection"])
@pytest.mark.parametrize("times", [0, 5, 30])
def test_too_few_saved_times_are_rejected(ask, times):
    run = hc.simulate(hc.Chain.uniform(30), until=30.0, times=times)
    arguments = (10, 20) if ask == "reflection" else ()
    with pytest.raises(hc.InputError, match=r"times=\d+|give simulate more times"):
        getattr(run, ask)(*arguments)
    if times == 30:
        advised = 420
        again = hc.simulate(run.chain, until=30.0, times=advised)
        getattr(again, ask)(*arguments)


def force_maxima(chain, until, spacing):
    """Times and heights of the force maxima of each contact of a chain of unit beads, by SciPy."""
    n, masses = chain.beads, chain.masses

    def motion(_, y):
        force = np.pad(np.maximum(y[: n - 1] - y[1:n], 0.0) ** 1.5, 1)
        return np.concatenate((y[n:], -np.diff(force) / masses))

    times = np.arange(0.0, until, spacing)
    start = np.eye(2 * n)[n]
    y = solve_ivp(motion, (0.0, until), start, "DOP853", times, rtol=1e-11, atol=1e-14).y
    forces = np.maximum(-np.diff(y[:n], axis=0), 0.0) ** 1.5
    crests = [find_peaks(force, height=0.01)[0] for force in forces]
    # A maximum rises above the minima next to it by a tenth of its height.
    crests = [
        found[peak_prominences(force, found)[0] > 0.1 * force[found]]
        for found, force in zip(crests, forces, strict=True)
    ]
    return [(times[found], force[found]) for found, force in zip(crests, forces, strict=True)]


@pytest.mark.parametrize("mass", [4.0, 6.0, 8.0])
def test_wave_n_of_a_train_is_the_maximum_n_of_each_force(mass):
    # Before its waves have separated, a contact has fewer maxima than the train has waves.
    chain = hc.Chain.uniform(40).struck_by(mass=mass, radius=1.0)
    spacing = 0.02
    maxima = force_maxima(chain, 46.0, spacing)
    waves = hc.simulate(chain, until=70.0, times=2400).waves()
    for rank in range(4):
        wave = waves[rank]
        assert wave.direction == 1
        firsts = [k for k in range(1, 40) if len(maxima[k - 1][0]) > rank]
        assert wave.contacts[0] == firsts[0]
        for k, time, force in zip(wave.contacts, wave.times, wave.amplitudes, strict=True):
            if time < 40.0:
                there, height = maxima[k - 1]
                assert time == pytest.approx(there[rank], abs=spacing)
                assert force == pytest.approx(height[rank], rel=1e-3)


def test_waves_that_have_not_separated_are_marked():
    run = hc.simulate(hc.Chain.uniform(40).struck_by(mass=8.0, radius=1.0), until=70.0, times=2400)
    waves = run.waves()
    # All momentum of the striker passes the first contact in one event, and the leading wave
    # carries less than a third of it.
    (first,) = waves.at(1)
    assert first.merged
    assert "merged" in repr(first)
    assert first.impulse == pytest.approx(8.0 * (1.0 - run.velocities[-1, 0]), rel=1e-6)
    assert first.impulse_of_crest < 3.0
    assert [wave.merged for wave in waves] == [False] * 3 + [True] * 7
    assert "merged" in repr(waves[9])
    exact = hc.solitary_wave()
    for wave in waves[:3]:
        velocity = (wave.amplitude / exact.force_constant) ** (5 / 6)
        assert wave.momentum == pytest.approx(exact.momentum(velocity), rel=0.05)
        assert wave.energy == pytest.approx(exact.energy(velocity), rel=0.1)


def test_a_short_chain_whose_waves_are_not_listed_is_reported():
    # Seed 2000 of random chains: with 400 saved times, the wave that returns at the end is missed.
    row = hc.Chain.from_radii([1.0, 0.2189, 1.0, 0.2189, 1.0])
    wall = hc.Wall(stiffness=0.01 * float(row.stiffness[-1]))
    row = row.replace(right_wall=wall, precompression=0.55, held_by="force")
    for times in (400, 800):
        with pytest.warns(hc.InputWarning, match="more than half at 4 of 4 contacts"):
            hc.simulate(row, until=40.0, times=times).waves()


@pytest.mark.parametrize("precompression", [0.0, 0.1])
def test_beads_ahead_of_a_pulse_have_no_velocity_peaks(precompression):
    row = hc.Chain.uniform(40)
    if precompression:
        row = row.replace(precompression=precompression, held_by="force")
    run = hc.simulate(row, until=5.0, times=2000)
    assert len(run.velocity_peaks(2))
    for bead in range(12, 41):
        assert len(run.velocity_peaks(bead)) == 0
    # The foot of the pulse is there.
    assert run.velocity(12).max() > 0.0


STEP = hc.Chain.from_radii(np.where(np.arange(120) < 60, 1.0, 0.6))
FREE_END = hc.Chain.tapered("backward-exponential", 0.03, beads=60)
ROW = hc.Chain.from_materials(5e-3, "steel-52100", beads=30, velocity=0.1)
PRESSED = ROW.replace(precompression=20.0, held_by="force", right_wall=hc.Wall())


@pytest.mark.parametrize(
    ("chain", "until", "times"),
    [
        (STEP, 150.0, 60),
        (FREE_END, None, 60),
        (hc.Chain.tapered("forward-exponential", 0.03, beads=60, exponent=2.0), None, 60),
        (hc.Chain.tapered("backward-exponential", 0.02, beads=60), None, 60),
        (hc.Chain.dimer(0.5, beads=60), 80.0, 60),
        (PRESSED, 2e-3, 150),
        (ROW.replace(loss=hc.ElasticPlastic(), right_wall=hc.Wall()), 2e-3, 60),
    ],
)
@pytest.mark.filterwarnings("ignore:.*energy:hertzchain.InputWarning")
def test_the_advised_number_of_saved_times_is_enough(chain, until, times):
    with warnings.catch_warnings(record=True) as shown:
        warnings.simplefilter("always")
        try:
            hc.simulate(chain, until=until, times=times).waves()
        except hc.InputError as error:
            said = str(error)
        else:
            said = " ".join(str(each.message) for each in shown)
    # Warnings of NumPy do not leak.
    assert not [each for each in shown if each.category is RuntimeWarning]
    needed = int(re.search(r"times=(\d+) is enough", said)[1])
    waves = hc.simulate(chain, until=until, times=needed).waves()
    assert all(wave.resolved for wave in waves)
    assert min(wave.samples for wave in waves) <= 2.3 * MIN_SAMPLES


def test_velocity_peaks_of_a_run_without_saved_times_advise_a_number():
    chain = hc.Chain.uniform(40)
    with pytest.raises(hc.InputError, match=r"the run has 0; times=\d+ is enough") as caught:
        hc.simulate(chain, until=60.0, times=0).velocity_peaks(20)
    needed = int(re.search(r"times=(\d+)", str(caught.value))[1])
    (width,) = hc.simulate(chain, until=60.0, times=needed).velocity_peaks(20).widths
    exact = hc.simulate(chain, until=60.0, times=6000).velocity_peaks(20).widths[0]
    assert width == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("times", [400, 800])
def test_a_track_that_few_saved_times_end_early_is_announced(times):
    """The pulse passes all 39 contacts, as the largest overlaps show."""
    run = hc.simulate(hc.Chain.tapered("forward-exponential", 0.1, beads=40), times=times)
    assert run.largest_overlaps[1:40].min() > 0.0
    with (
        pytest.warns(hc.InputWarning, match="marked as unresolved"),
        pytest.warns(hc.InputWarning, match=r"track of a wave may end early at contact 3\d,"),
    ):
        last = run.waves()[0].contacts[-1]
    assert last < 39


def test_the_advice_of_a_reflection_is_enough():
    with pytest.raises(hc.InputError, match=r"times=\d+ is enough") as caught:
        hc.simulate(STEP, until=150.0, times=60).reflection(50, 75)
    needed = int(re.search(r"times=(\d+)", str(caught.value))[1])
    found = hc.simulate(STEP, until=150.0, times=needed).reflection(50, 75)
    assert found.reflected_energy + found.transmitted_energy == pytest.approx(1.0, abs=1e-3)


def test_a_run_that_ends_while_the_incident_wave_passes_is_too_short():
    with pytest.raises(hc.SimulationError, match="still passes contact 50 .* simulate for longer"):
        hc.simulate(STEP, until=60.0, times=1000).reflection(50, 75)


def test_a_wave_that_an_odd_bead_divides_has_both_of_its_energies():
    chain = hc.Chain.uniform(60).with_defects({30: 1.5})
    waves = hc.simulate(chain, until=75.0, times=1500).waves()
    row, wave = waves.to_dataframe().iloc[0], waves[0]
    # Energy and momentum of the solitary wave of the uniform chain, and their known ratio.
    assert (row.first_energy, row.first_momentum) == pytest.approx((0.4968, 1.1383), rel=2e-3)
    change = row.last_momentum / row.first_momentum
    assert row.last_energy / row.first_energy == pytest.approx(change**2, rel=5e-3)
    both = f"{row.first_momentum:.4g} to {row.last_momentum:.4g}"
    assert all(both in item._repr_html_() for item in (waves, wave))
    assert both in " ".join(repr(wave).split())
    lines = [line for line in waves.plot().lines if len(line.get_xdata()) > 1]
    by_contact = {line.get_ydata()[-1]: line.get_linewidth() for line in lines}
    assert by_contact[59] < 0.9 * lines[0].get_linewidth()


def test_the_legend_explains_the_widths_of_lines():
    row = hc.Chain.from_materials(5e-3, "steel-52100", beads=20)
    run = hc.simulate(row.struck_by(radius="10 mm", velocity="0.1 m/s"), until=1e-3, times=2001)
    waves = run.waves()
    axes = waves.plot()
    widths = {line.get_label(): line.get_linewidth() for line in axes.lines}
    strongest = max(wave.energy for wave in waves)
    assert widths[f"energy {1e6 * strongest:.3g} µJ"] == max(widths.values())
    expected = 0.8 + 2.2 * 0.1**0.5
    assert widths["a tenth of it"] == pytest.approx(expected)
    single = hc.simulate(hc.Chain.uniform(30), until=30.0).waves().plot()
    assert len(single.get_legend().get_texts()) == 1

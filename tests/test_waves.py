"""Waves of a run against the exact solitary wave, conservation, symmetries and known counts."""

import pickle
import warnings

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import find_peaks, peak_prominences

import hertzchain as hc
from hertzchain.simulation.budget import overlaps_of, stored_energy
from hertzchain.simulation.wave_events import events_at

# Two equal pulses that meet head on see each other as a wall of this stiffness (images).
IMAGE_WALL = hc.Wall(stiffness=2.0 * np.sqrt(2.0))


def interface(ratio):
    """Beads of radius 1, then of another one, struck at bead 1."""
    return hc.Chain.from_radii(np.where(np.arange(120) < 60, 1.0, ratio))


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
    with pytest.raises(hc.InputError, match="only 4.1. are within .* times=500"):
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


def test_a_rigid_wall_returns_the_energy_as_the_image_would():
    walled = hc.Chain.uniform(60).replace(right_wall=IMAGE_WALL)
    run = hc.simulate(walled, until=130.0, times=1300)
    found = run.reflection(45, 60)
    assert found.reflected_energy == pytest.approx(1.0, abs=1e-4)
    assert found.transmitted_energy == found.transmitted_momentum == 0.0
    assert (len(found.transmitted), found.disturbed) == (0, False)
    assert found.kept_energy == pytest.approx(0.0, abs=1e-4)

    velocities = np.zeros(120)
    velocities[[0, -1]] = 1.0, -1.0
    pair = hc.simulate(hc.Chain.uniform(120).replace(velocities=velocities), until=130.0,
                       times=1300)  # fmt: skip
    alone, mirrored = run.waves(), pair.waves()
    assert [wave.direction for wave in alone] == [1, -1, -1]
    half = [wave for wave in mirrored if wave.contacts.max() < 60]
    assert len(mirrored) == 2 * len(half) == 2 * len(alone)
    for wave, image in zip(alone, half, strict=True):
        np.testing.assert_array_equal(wave.contacts, image.contacts)
        for name in ("times", "amplitudes", "momenta", "energies"):
            np.testing.assert_allclose(getattr(wave, name), getattr(image, name), rtol=1e-7)


def test_a_weak_straggler_does_not_end_the_count():
    """Energies on the left of contact 14, from the velocities and forces of single beads."""
    gaps = np.zeros(19)
    gaps[9] = 10e-6
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=20, velocity=0.1, gaps=gaps)
    chain = chain.replace(right_wall=hc.Wall.of("ptfe", gap=20e-6))
    with pytest.warns(hc.ModelRangeWarning):
        run = hc.simulate(chain, until=4e-3, times=6000)
    found = run.reflection(14, 20)

    def energy(time):
        i = int(np.searchsorted(run.times, time))
        stored = 0.4 * run.forces[i, 1:15] ** (5 / 3) / chain.stiffness[:14] ** (2 / 3)
        kinetic = 0.5 * chain.masses[:14] @ run.velocities[i, :14] ** 2
        return kinetic + stored[:-1].sum() + stored[-1] / 2

    incident, straggler, back = run.waves().at(14)[:3]
    assert [incident.direction, straggler.direction, back.direction] == [1, 1, -1]
    before, between, after = (
        energy(incident.begin), energy(incident.end + 1e-6), energy(straggler.end + 1e-6)
    )  # fmt: skip
    entered = (between - after) / (before - between)
    assert 0.01 < entered < 0.05
    assert found.entered_energy == pytest.approx(entered, rel=1e-3)
    reflected = (energy(back.end + 1e-6) - after) / (before - between)
    first = found.reflected[0]
    assert first.energy / found.incident.energy == pytest.approx(reflected, rel=1e-3)
    assert abs(found.unexplained_energy) < 1e-3
    assert not found.disturbed
    assert f"waves with energy {entered:.4f} entered" in repr(found)


@pytest.mark.parametrize(
    ("ratio", "forward", "backward"),
    # Velocities over the incident one, from the first maxima; a stiff side reflects, a soft one
    # does not (Vergara, Phys. Rev. Lett. 95, 108002; Tichler et al., 111, 048001).
    [(0.8, 1.349, 0.0), (1.25, 0.691, 0.258), (2.0, 0.244, 0.722)],
)
def test_interfaces_conserve_energy_and_agree_with_the_velocities(ratio, forward, backward):
    run = hc.simulate(interface(ratio), until=140.0, times=2000)
    found = run.reflection(50, 75)
    total = found.reflected_energy + found.transmitted_energy + found.kept_energy
    assert total == pytest.approx(1.0, abs=2e-4)
    assert (found.reflected_energy > 0.0) == (backward > 0.0)
    # F grows as v^(6/5) times m^(3/5) k^(2/5), the masses as R^3 and the stiffness as R^(1/2).
    force = (ratio**1.8 * ratio**0.2) * forward**1.2
    assert found.transmitted_force == pytest.approx(force, rel=5e-3)
    assert found.reflected_force == pytest.approx(backward**1.2, rel=5e-3)


def test_a_count_that_is_not_of_one_wave_warns():
    run = hc.simulate(interface(2.0), until=140.0, times=2000)
    with pytest.warns(hc.InputWarning, match=r"100% of the incident energy is still between"):
        early = run.reflection(50, 75, until=68.0)
    assert (early.reflected, early.transmitted) == ((), ())
    with pytest.raises(hc.SimulationError, match="incident wave passes contact 50 until"):
        run.reflection(50, 75, until=early.incident.time + 0.1)
    # Two equal pulses between walls: each is there when the other enters.
    velocities = np.zeros(60)
    velocities[[0, -1]] = 1.0, -1.0
    pair = hc.Chain.uniform(60).replace(velocities=velocities)
    run = hc.simulate(pair, until=65.0, times=900)
    with pytest.warns(hc.InputWarning, match="other waves contribute"):
        found = run.reflection(20, 50)
    assert found.disturbed == (found.until < 65.0)


def test_the_tail_that_losses_leave_behind_a_wave_does_not_end_the_count():
    """The transmitted energy is the integral of force times velocity of the saved times."""
    run = hc.simulate(interface(2.0).replace(loss=hc.Restitution(0.9)), until=150.0, times=2000)
    found = run.reflection(55, 65)
    assert found.until == 150.0
    assert 0.01 < found.entered_energy < 0.05
    force, speed = run.force(65), run.velocities[:, 64:66].mean(axis=1)
    whole = np.trapezoid(force * speed, run.times) / found.incident.energy
    assert found.transmitted_energy == pytest.approx(whole, rel=5e-3)
    with pytest.warns(hc.InputWarning, match="still between the contacts at t = 97; simulate for"):
        early = run.reflection(55, 65, until=97.0)
    # Beads 56 to 65 at this time, the contacts between them by the law of Hertz, and half of both.
    now = int(np.searchsorted(run.times, 97.0))
    overlaps = np.maximum(-np.diff(run.positions[now]), 0.0)[54:65]
    stored = 0.4 * run.chain.stiffness[54:65] * overlaps**2.5
    inside = 0.5 * run.chain.masses[55:65] @ run.velocities[now, 55:65] ** 2
    inside += stored.sum() - 0.5 * (stored[0] + stored[-1])
    assert early.stored_energy == pytest.approx(inside / found.incident.energy, abs=1e-6)
    with pytest.raises(hc.SimulationError, match="or the tail that losses leave behind this one"):
        run.reflection(50, 72)


@pytest.mark.parametrize("mass", [0.2, 0.5, 2.0, 5.0])
def test_mass_defects_scatter_both_ways(mass):
    masses = np.ones(120)
    masses[59] = mass
    run = hc.simulate(hc.Chain.uniform(120).replace(masses=masses), until=140.0, times=2000)
    found = run.reflection(50, 70)
    assert 0.02 < found.reflected_energy < 0.4
    assert found.reflected_energy + found.transmitted_energy == pytest.approx(1.0, abs=2e-3)


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


@pytest.mark.parametrize("contacts", [(40, 60), (30, 50)])
def test_weak_waves_in_a_soft_material_are_counted(contacts):
    """Most of the train in PTFE is weaker than 1% of the force in the steel."""
    chain = hc.Chain.from_materials(
        "5 mm", ["steel-316"] * 50 + ["ptfe"] * 50, velocity="0.001 m/s"
    )
    run = hc.simulate(chain, until="25 ms", times=12_000)
    found = run.reflection(*contacts)
    before, after = (np.trapezoid(run.forces[:, k], run.times) for k in contacts)
    assert found.incident.impulse == pytest.approx(before, rel=1e-6)
    assert found.transmitted_momentum == pytest.approx(after / before, abs=1e-3)
    assert found.transmitted_energy + found.kept_energy == pytest.approx(1.0, abs=1e-4)
    assert abs(found.missing_momentum) < 1e-3


def test_momentum_that_belongs_to_no_wave_is_announced(monkeypatch):
    chain = hc.Chain.from_radii(np.where(np.arange(120) < 60, 1.0, 0.4))
    run = hc.simulate(chain, until=300.0, times=6000)
    assert abs(run.reflection(50, 75).missing_momentum) < 1e-3
    monkeypatch.setattr("hertzchain.simulation.reflection.THRESHOLD", 0.5)
    monkeypatch.setattr("hertzchain.simulation.reflection.MISSING", 0.02)
    with pytest.warns(hc.InputWarning, match="of the incident momentum passes one of the contacts"):
        found = run.reflection(50, 75)
    lost = np.trapezoid(run.forces[:, 75], run.times) / found.incident.impulse
    assert found.missing_momentum == pytest.approx(lost - found.transmitted_momentum, abs=1e-3)
    assert "unexplained 0." in repr(found)


def test_a_wave_to_the_left_is_reflected_like_its_mirror_image():
    chain = interface(2.0)
    mirrored = hc.Chain.from_radii(np.ones(120)).replace(
        masses=chain.masses[::-1], stiffness=chain.stiffness[::-1],
        velocities=-chain.velocities[::-1],
    )  # fmt: skip
    there = hc.simulate(chain, until=140.0, times=2000).reflection(50, 75)
    again = hc.simulate(mirrored, until=140.0, times=2000).reflection(70, 45)
    for name in ("reflected_energy", "transmitted_energy", "reflected_momentum", "kept_energy"):
        assert getattr(there, name) == pytest.approx(getattr(again, name), abs=1e-6)


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


@pytest.mark.parametrize("seed", range(3))
def test_net_flux_is_the_change_of_energy_beyond_each_contact(seed):
    chain = hc.Chain.from_radii(np.random.default_rng(seed).uniform(0.5, 1.5, 40))
    run = hc.simulate(chain.replace(right_wall=hc.Wall()), until=80.0, times=4000)
    flux = run.energy_flux()
    kinetic = 0.5 * chain.masses * run.velocities**2
    overlaps = overlaps_of(run.chain, run.times, run.positions)
    stored = stored_energy(run.chain, overlaps, run.forces)
    beyond = [
        kinetic[:, k:].sum(axis=1) + stored[:, k + 1 :].sum(axis=1) + 0.5 * stored[:, k]
        for k in range(1, chain.beads)
    ]
    gained = np.array([energy[-1] - energy[0] for energy in beyond])
    np.testing.assert_allclose(flux.net, gained, atol=2e-5)
    assert np.all(flux.left >= 0.0)
    assert flux.left.max() > 0.01


def test_a_rigid_wall_sends_all_the_energy_back_through_each_contact():
    chain = hc.Chain.uniform(40).replace(right_wall=IMAGE_WALL)
    flux = hc.simulate(chain, until=140.0, times=1500).energy_flux()
    np.testing.assert_allclose(flux.right[15:36], hc.solitary_wave().energy(0.681631549), rtol=1e-5)
    np.testing.assert_allclose(flux.left[15:36], flux.right[15:36], rtol=1e-4)


@pytest.mark.parametrize("wall", [None, hc.Wall.rigid()])
def test_the_flux_of_waves_between_saved_times_is_rejected(wall):
    run = hc.simulate(hc.Chain.uniform(30).replace(right_wall=wall), until=60.0, times=60)
    with pytest.raises(hc.InputError, match="the strongest wave has .* saved times"):
        run.energy_flux()


def test_in_strong_disorder_the_flux_is_recommended():
    chain = hc.Chain.from_radii(np.random.default_rng(1).uniform(0.5, 1.5, 60))
    waves = hc.simulate(chain, until=150.0, times=4000).waves()
    assert np.median([len(wave.contacts) for wave in waves]) < 15
    assert ("energy_flux" in str(waves)) == (len(waves) > 60)


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


@pytest.mark.parametrize(
    ("ratio", "drive"),
    [
        # Smaller beads reflect a compression as a rarefaction; every second half of a burst is one.
        (1.0 / 1.3, hc.SineBurst(0.01, 0.02, cycles=0.5, window="none")),
        (1.3, hc.SineBurst(0.01, 0.05, cycles=2)),
    ],
)
def test_reflection_rejects_rarefactions_and_names_the_flux(ratio, drive):
    """The flux agrees with the acoustic impedances, sqrt(K m) with K as R^(1/3) and m as R^3."""
    chain = interface(ratio).replace(precompression=1.0, held_by="force", velocities=np.zeros(120))
    run = hc.simulate(chain.replace(drive=drive), until=110.0, times=1200)
    with pytest.raises(hc.SimulationError, match="rarefactions, which reflection") as refused:
        run.reflection(30, 80)
    assert "flux.left[29] / flux.right[29]" in str(refused.value)
    flux, impedance = run.energy_flux(), ratio ** (5.0 / 3.0)
    acoustic = ((1.0 - impedance) / (1.0 + impedance)) ** 2
    # The linearised chain reflects 4% more at a frequency of 0.05 than in the limit of long waves.
    assert flux.left[29] / flux.right[29] == pytest.approx(acoustic, rel=0.05)


def test_reflection_of_strong_waves_in_a_weakly_compressed_chain():
    """Rarefactions have almost no energy there, and the coefficients are those without force."""
    found = [
        hc.simulate(chain, until=140.0, times=1500).reflection(50, 75)
        for chain in (interface(2.0), interface(2.0).replace(precompression=1e-6, held_by="force"))
    ]
    free, pressed = (each.reflected_energy for each in found)
    assert pressed == pytest.approx(free, rel=5e-3)


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
    chain = hc.Chain.uniform(5).replace(velocities=np.zeros(5))
    run = hc.simulate(chain, until=3.0, times=50)
    assert len(run.waves()) == 0
    assert run.waves().to_dataframe().empty
    assert run.energy_flux().right.tolist() == [0.0] * 4
    assert "to the left 0 at" in repr(run.energy_flux())
    with pytest.raises(hc.SimulationError, match="no wave towards contact 4 passes contact 2"):
        run.reflection(2, 4)


def test_weak_waves_that_are_not_resolved_are_marked():
    chain = hc.Chain.tapered("forward-exponential", 0.05, beads=40)
    radii = np.concatenate((np.ones(40), chain.radii[1:]))
    run = hc.simulate(hc.Chain.from_radii(radii), until=60.0, times=340)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        waves = run.waves()
    assert [wave.resolved for wave in waves].count(False) == len(told)


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

"""Energy that interfaces, defects and walls reflect, and the flux of energy through contacts."""

import warnings

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.recorded_warnings import ignore_warnings
from hertzchain.simulation.budget import overlaps_of, stored_energy

# Two equal pulses that meet head on see each other as a wall of this stiffness (images).
IMAGE_WALL = hc.Wall(stiffness=2.0 * np.sqrt(2.0))


def interface(ratio):
    """Beads of radius 1, then of another one, struck at bead 1."""
    return hc.Chain.from_radii(np.where(np.arange(120) < 60, 1.0, ratio))


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
    with pytest.warns(hc.InputWarning, match=r"rose from 0\.95\d+ to 1\.00\d+ in the last third"):
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
    with pytest.warns(hc.IncompleteWarning, match=r"100% of the incident energy is still between"):
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


def test_coefficients_of_dimers_that_depend_on_the_end_of_the_count_are_announced():
    """The energy that enters, from the velocities and forces of the saved times."""
    masses = np.where(np.arange(80) % 2, 0.3428, 1.0)
    chain = hc.Chain.uniform(80).replace(masses=masses, right_wall=hc.Wall.rigid())
    run = hc.simulate(chain, until=195.0, times=2340)
    early = run.reflection(40, 80, until=150.0)
    with pytest.warns(hc.InputWarning, match="reflected energy depends on the end of the count"):
        late = run.reflection(40, 80)
    growth = late.reflected_energy - early.reflected_energy
    assert growth > 0.01
    assert late.late_energy[0] >= growth
    power = run.force(40) * run.velocities[:, 39:41].mean(axis=1)
    behind = (run.times > early.incident.end) & (run.times < early.until)
    entered = np.trapezoid(np.where(behind, np.maximum(power, 0.0), 0.0), run.times)
    assert early.entered_energy == pytest.approx(entered / early.incident.energy, abs=1e-3)
    # Without the waves that entered, the balance had an error of 0.02.
    assert abs(early.unexplained_energy) < 5e-3


def test_contacts_near_an_interface_are_announced():
    run = hc.simulate(interface(2.0), until=140.0, times=1500)
    with pytest.warns(hc.InputWarning, match="contacts 58 and 61 are 3 apart, but a wave extends"):
        near = run.reflection(58, 61)
    assert near.reflected_energy == pytest.approx(run.reflection(50, 75).reflected_energy, abs=0.02)
    # Between its two contacts, a heavy bead would not reflect at all.
    with pytest.raises(hc.InputError, match="before and after must be at least 3 contacts apart"):
        run.reflection(59, 61)


def test_a_wave_that_has_not_returned_is_announced_with_the_result():
    """Without `until`, the run ends when the pulse has left the chain."""
    masses = np.ones(80)
    masses[71] = 0.5
    chain = hc.Chain.uniform(80).replace(masses=masses)
    run = hc.simulate(chain, times=1500)
    with pytest.warns(hc.IncompleteWarning, match="reflected energy, 0.0000, is not complete"):
        found = run.reflection(20, 75)
    with ignore_warnings():
        later = hc.simulate(chain, until=200.0, times=3200).reflection(20, 75)
    more = found.energy_on_its_way[0]
    assert 0.8 * more < later.reflected_energy <= more
    for shown in (repr(found), found._repr_html_()):
        assert f"0.0000 (up to {more:.4f} more)" in " ".join(shown.split())


def test_the_tail_that_losses_leave_behind_a_wave_does_not_end_the_count():
    """The transmitted energy is the integral of force times velocity of the saved times."""
    run = hc.simulate(interface(2.0).replace(loss=hc.Restitution(0.9)), until=150.0, times=2000)
    with pytest.warns(hc.InputWarning, match="transmitted energy depends on the end of the count"):
        found = run.reflection(55, 65)
    assert found.until == 150.0
    assert 0.01 < found.entered_energy < 0.05
    force, speed = run.force(65), run.velocities[:, 64:66].mean(axis=1)
    whole = np.trapezoid(force * speed, run.times) / found.incident.energy
    assert found.transmitted_energy == pytest.approx(whole, rel=5e-3)
    with pytest.warns(
        hc.IncompleteWarning, match="still between the contacts at t = 97; simulate for"
    ):
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
    monkeypatch.setattr("hertzchain.simulation.find_reflection.THRESHOLD", 0.5)
    monkeypatch.setattr("hertzchain.simulation.find_reflection.MISSING", 0.02)
    with pytest.warns(hc.InputWarning, match="of the incident momentum passes one of the contacts"):
        found = run.reflection(50, 75)
    lost = np.trapezoid(run.forces[:, 75], run.times) / found.incident.impulse
    with pytest.warns(hc.IncompleteWarning, match="transmitted momentum, 0.8"):
        assert found.missing_momentum == pytest.approx(lost - found.transmitted_momentum, abs=1e-3)
    assert "unexplained 0." in " ".join(repr(found).split())


def test_a_wave_to_the_left_is_reflected_like_its_mirror_image():
    chain = interface(2.0)
    mirrored = hc.Chain.from_radii(np.ones(120)).replace(
        masses=chain.masses[::-1], stiffness=chain.stiffness[::-1],
        velocities=-chain.velocities[::-1],
    )  # fmt: skip
    there = hc.simulate(chain, until=140.0, times=2000).reflection(50, 75)
    again = hc.simulate(mirrored, until=140.0, times=2000).reflection(70, 45)
    for each, contact in ((there, 50), (again, 70)):
        with pytest.warns(hc.IncompleteWarning, match=f"0.1694 .* towards contact {contact} at"):
            assert each.reflected_momentum == pytest.approx(0.7828, abs=1e-4)
    for name in ("reflected_energy", "transmitted_energy", "kept_momentum", "kept_energy"):
        assert getattr(there, name) == pytest.approx(getattr(again, name), abs=1e-6)


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
    assert "run.energy_flux().balance(30, 80): returned_energy" in str(refused.value)
    balance, impedance = run.energy_flux().balance(30, 80), ratio ** (5.0 / 3.0)
    acoustic = ((1.0 - impedance) / (1.0 + impedance)) ** 2
    # The linearised chain reflects 4% more at a frequency of 0.05 than in the limit of long waves.
    assert balance.returned_energy == pytest.approx(acoustic, rel=0.05)


def test_reflection_of_strong_waves_in_a_weakly_compressed_chain():
    """Rarefactions have almost no energy there, and the coefficients are those without force."""
    found = [
        hc.simulate(chain, until=140.0, times=1500).reflection(50, 75)
        for chain in (interface(2.0), interface(2.0).replace(precompression=1e-6, held_by="force"))
    ]
    free, pressed = (each.reflected_energy for each in found)
    assert pressed == pytest.approx(free, rel=5e-3)


def test_the_wall_has_a_name_and_contacts_next_to_it_cause_a_warning():
    chain = hc.Chain.uniform(40).replace(right_wall=hc.Wall())
    run = hc.simulate(chain, until=90.0, times=2000)
    named, numbered = run.reflection(25, "wall"), run.reflection(25, 40)
    assert (named.after, named.reflected_energy) == (40, numbered.reflected_energy)
    assert not named.overlapping
    assert "overlap" not in repr(named)
    with pytest.raises(hc.InputError, match="next to the wall, .* give the wall itself, 40$"):
        run.reflection(25, 39)
    with pytest.warns(hc.InputWarning, match="contact 38 is 2 from the end .* wall itself, 40$"):
        near = run.reflection(25, 38)
    assert near.overlapping
    assert "; the waves overlap;" in repr(near)
    assert "Contact 38 is 2 from the end of the chain" in near._repr_html_()
    free = hc.simulate(hc.Chain.uniform(40), until=60.0, times=1500)
    with pytest.warns(hc.InputWarning, match="at least 5 from the end$"):
        free.reflection(20, 39)
    with pytest.raises(hc.InputError, match="no left wall"):
        run.reflection(25, "left wall")


def test_energy_of_beads_that_have_separated_is_not_awaited():
    """At a free end, the last beads fly away one after another."""
    free = hc.Chain.uniform(40)
    early, late = (hc.simulate(free, until=t, times=1500) for t in (46.0, 90.0))
    with pytest.warns(hc.IncompleteWarning, match="still between .*; simulate for longer"):
        moving = early.reflection(20, 40)
    with pytest.warns(hc.InputWarning, match="100% .* beads that have separated .* free end"):
        gone = late.reflection(20, 40)
    assert moving.reflected_energy == gone.reflected_energy == 0.0
    assert moving.separated_energy < 1e-9
    # All of them move away from each other.
    assert gone.separated_energy == pytest.approx(1.0, abs=1e-4)
    assert np.all(np.diff(late.velocities[-1, 20:]) >= 0.0)
    words = " ".join(repr(gone).split())
    assert "kept 1.0000 (1.0000 in beads that have separated)" in words
    assert max(map(len, repr(gone).splitlines())) <= 100
    assert "in separated beads" in gone._repr_html_()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert gone.reflected_momentum == 0.0
    mirrored = free.replace(velocities=-free.velocities[::-1])
    with pytest.warns(hc.InputWarning, match="beads that have separated"):
        again = hc.simulate(mirrored, until=90.0, times=1500).reflection(20, 0)
    assert again.separated_energy == pytest.approx(gone.separated_energy, abs=1e-9)
    # A constant force brings the last bead back.
    held = free.replace(precompression=1e-3, held_by="force", velocities=free.velocities)
    with ignore_warnings():
        assert hc.simulate(held, until=45.0, times=1500).reflection(20, 40).separated_energy == 0.0


def test_times_of_a_reflection_have_units():
    balls = hc.Chain.from_materials(diameters="10 mm", materials="brass", beads=60)
    run = hc.simulate(balls.struck_by(velocity="0.02 m/s"), until="4 ms", times=2000)
    found, same = (run.reflection(20, 40, until=end) for end in (2.5e-3, "2.5 ms"))
    assert found.until == same.until
    assert found.transmitted_energy == same.transmitted_energy

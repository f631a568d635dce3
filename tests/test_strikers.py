"""Strikers of other masses, contacts and velocities in the local-rate law, and their trains."""

import warnings

import numpy as np
import pytest

import hertzchain as hc

K = np.arange(90)
TAPERS = {
    "uniform": np.ones(90),
    "exponential": np.exp(-0.03 * K),
    "linear": 1 + 0.02 * K,
    "sine": np.exp(0.2 * np.sin(K / 10)),
}


def errors(chain, quantity):
    return np.abs(hc.local_rate(chain).compare(hc.propagate(chain)).errors(quantity))


@pytest.mark.parametrize("taper", TAPERS)
@pytest.mark.parametrize("size", [0.65, 1.3, 1.9])
def test_spheres_of_other_sizes(taper, size):
    """Mass ratios 0.27, 2.2 and 6.9; the contact follows from the radius."""
    chain = hc.Chain.from_radii(TAPERS[taper]).struck_by(radius=size)
    assert errors(chain, "velocity")[1:-3].max() < 4e-3
    assert errors(chain, "arrival")[1:].max() < 1e-3
    assert errors(chain, "peak_force")[:-3].max() < 5e-3


def test_a_striker_that_falls_from_rest():
    column = hc.Chain.from_materials(
        5e-3, "steel-52100", beads=3, velocity=0, gravity=9.81, right_wall=hc.Wall.of("steel-52100")
    )
    dropped = column.struck_by(velocity=0, gap="5 mm")
    run = hc.simulate(dropped, until="33 ms", times=2000)
    assert run.velocities[:, 0].max() == pytest.approx(0.3132, rel=1e-3)
    impact = hc.simulate(dropped)
    assert impact.message.startswith("the impact on the right wall has ended at t = 32.0")
    largest = run._wall_force("right").largest_so_far
    assert impact.wall_force().peak == pytest.approx(largest, rel=1e-10)
    for other in (column, column.struck_by(velocity=0)):
        with pytest.raises(hc.InputError, match="bead 1 is not struck"):
            hc.simulate(other)


def test_any_contact_of_the_striker():
    for stiffness in (0.55, 1.8):
        chain = hc.Chain.uniform(60).struck_by(mass=3.0, stiffness=stiffness)
        assert errors(chain, "velocity")[1:-3].max() < 2e-3
        assert errors(chain, "peak_force")[:-3].max() < 2e-3


def test_the_factor_is_constant_far_from_the_striker():
    chain = hc.Chain.uniform(80)
    ratio = hc.local_rate(chain.struck_by(mass=4.0, radius=1.0)).velocity[1:]
    ratio = ratio / hc.local_rate(hc.Chain.uniform(81)).velocity[1:]
    assert np.ptp(ratio[41:]) < 1e-12
    # By two integrations, as in `hertzchain verify --only strikers`.
    assert ratio[45] * 0.68163155 == pytest.approx(1.21314076, rel=2e-4)


def test_an_equal_striker_makes_no_difference():
    plain = hc.local_rate(hc.Chain.uniform(30))
    struck = hc.local_rate(hc.Chain.uniform(29).struck_by())
    for name in ("velocity", "arrival", "peak_force"):
        np.testing.assert_allclose(struck.column(name), plain.column(name), rtol=1e-7)


def test_velocity_and_units():
    slow = hc.Chain.uniform(30).struck_by(mass=2.0, velocity=0.3)
    fast = hc.Chain.uniform(30).struck_by(mass=2.0)
    for name, power in (("velocity", 1.0), ("arrival", -0.2), ("peak_force", 1.2)):
        ratio = hc.local_rate(slow).column(name)[5] / hc.local_rate(fast).column(name)[5]
        assert ratio == pytest.approx(0.3**power, rel=1e-12)
    balls = hc.Chain.from_materials(5e-3, "steel-52100", beads=40)
    real = balls.struck_by(radius=8e-3, velocity=0.2)
    assert errors(real, "velocity")[1:-3].max() < 1e-3
    assert errors(real, "arrival")[1:].max() < 1e-3
    assert errors(real, "peak_force")[:-3].max() < 1e-3


@pytest.mark.parametrize(("chain", "message"), [
    (hc.Chain.uniform(30).struck_by(mass=20.0, radius=1.0), "mass of the striker must be 0.1"),
    (hc.Chain.uniform(30).struck_by(mass=2.0, stiffness=4.0), "stiffness of its contact"),
    (hc.Chain.uniform(30).struck_by(count=2), "supports one striker, but the chain has 2; use sim"),
    (hc.Chain.uniform(30).struck_by(gap=0.1), "gaps"),
    (hc.Chain.uniform(30).struck_by().replace(velocities=[-1.0] + 30 * [0.0]), "moves forwards"),
    (hc.Chain.dimer(0.5, beads=30), "does not support masses"),
    (hc.Chain.uniform(30, exponent=2.0).struck_by(mass=2.0, stiffness=1.0), "exponent 1.5"),
])  # fmt: skip
def test_other_strikers_are_rejected(chain, message):
    with pytest.raises(hc.InputError, match=message):
        hc.local_rate(chain)


def test_velocities_of_strikers_are_no_further_feature():
    chain = hc.Chain.tapered("forward-exponential", 0.03, beads=20).struck_by(velocity=0.5)
    with pytest.raises(hc.InputError) as raised:
        hc.bca(chain.struck_by(velocity=1.0))
    assert str(raised.value) == (
        "the BCA does not support strikers; use simulate (chain: forward-exponential, q = 0.03, "
        "20 beads, and 2 strikers, velocities)"
    )


def test_rates_beyond_the_table_are_announced():
    chain = hc.Chain.from_radii(np.exp(0.2 * np.arange(20))).struck_by(radius=1.5)
    with pytest.warns(hc.ModelRangeWarning, match="effect of the striker"):
        hc.local_rate(chain)


@pytest.mark.parametrize("mass", [2.7, 5.5])
def test_the_train_of_a_heavy_striker(mass):
    """Velocity maxima of bead 100, between the masses of the table."""
    chain = hc.Chain.uniform(330).struck_by(mass=mass, radius=1.0)
    run = hc.simulate(chain, until=330.0, times=4000, rtol=1e-9)
    v = run.velocity(101)
    peaks = v[1:-1][(v[1:-1] > v[:-2]) & (v[1:-1] >= v[2:]) & (v[1:-1] > 0.05 * v.max())]
    law = hc.striker_train(mass)
    waves = min(len(law), len(peaks))
    assert waves >= 3
    np.testing.assert_allclose(law[:waves], peaks[:waves], rtol=0.01)
    np.testing.assert_allclose(hc.striker_train(mass, 2.0), 2.0 * law, rtol=1e-14)


def test_energy_of_the_train():
    """Almost all energy of the striker is in its waves."""
    energy = hc.solitary_wave().energy_constant
    parts = [energy * (hc.striker_train(m) ** 2).sum() / (0.5 * m) for m in (1.25, 2.0, 4.0, 8.0)]
    assert all(0.985 < part < 1.0 for part in parts)


def test_light_strikers_create_no_train():
    with pytest.raises(hc.InputError, match="one wave"):
        hc.striker_train(0.5)


def test_fast_changes_at_a_heavy_striker_are_announced():
    chain = hc.Chain.from_radii(1 + 0.1 * K).struck_by(radius=1.9)
    with pytest.warns(hc.ModelRangeWarning, match="effect of the striker") as raised:
        law = hc.local_rate(chain)
    assert raised[0].filename == __file__
    errors = np.abs(law.compare(hc.propagate(chain)).errors("velocity"))
    assert (errors <= law.velocity_error)[:-3].all()


def test_a_striker_can_be_given_by_its_diameter():
    balls = hc.Chain.from_materials("4 mm", "steel-52100", beads=5)
    by_diameter, by_radius = balls.struck_by(diameter="6 mm"), balls.struck_by(radius="3 mm")
    np.testing.assert_array_equal(by_diameter.masses, by_radius.masses)
    np.testing.assert_array_equal(by_diameter.stiffness, by_radius.stiffness)
    assert by_diameter.masses[0] == pytest.approx(balls.masses[0] * (3.0 / 4.0) ** 3, rel=1e-12)
    with pytest.raises(hc.InputError, match="a radius or a diameter, not both"):
        balls.struck_by(diameter="6 mm", radius="3 mm")
    with pytest.raises(hc.InputError, match="diameter of a striker"):
        balls.struck_by(diameter=-1.0)


# Without the term of short chains, errors are up to 60 times the estimate.
@pytest.mark.parametrize("beads", [9, 11, 14, 19])
@pytest.mark.parametrize("rate", [-0.06, 0.0, 0.03])
@pytest.mark.parametrize("mass", [0.4, 2.5, 8.0])
def test_the_estimate_includes_the_overlap_of_striker_and_free_end(beads, rate, mass):
    chain = hc.Chain.from_radii(np.exp(rate * np.arange(beads))).struck_by(mass=mass, radius=1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hc.ModelRangeWarning)
        law = hc.local_rate(chain)
    error = np.abs(law.compare(hc.propagate(chain)).errors("velocity"))[-1]
    assert error < law.velocity_error[-1] < 0.025


def test_a_heavy_striker_on_a_short_chain_is_announced():
    chain = hc.Chain.uniform(9).struck_by(mass=8.0, radius=1.0)
    with pytest.warns(hc.ModelRangeWarning, match=r"so short that.* last bead .* 1\.\d%"):
        hc.local_rate(chain)


def test_counts_of_beads_do_not_include_strikers():
    chain = hc.Chain.uniform(20).struck_by()
    counts = []
    run = hc.simulate(chain, until=40.0, progress=lambda *found: counts.append(found))
    assert counts[-1] == (20, 20)
    assert run.beads_passed == 20
    assert "the pulse had passed 20 of 20 beads" in run.message
    assert "20 of 20" in run._repr_html_()
    hc.propagate(chain, progress=lambda *found: counts.append(found))
    assert counts[-1] == (20, 20)
    early = hc.simulate(chain, until=0.1)
    assert early.message.endswith("the pulse had passed 0 of 20 beads")
    for at_rest in (
        hc.Chain.uniform(3).replace(velocities=np.zeros(3)),
        hc.Chain.uniform(3).replace(velocities=None, drive=hc.StepDrive(1.0)),
    ):
        assert hc.simulate(at_rest, until=0.05).beads_passed == 0
    for table in (hc.propagate_many([chain, hc.Chain.uniform(9)]), hc.simulate_many([chain])):
        assert " of up to 20 beads and 1 striker" in repr(table)
    assert "up to 20 beads and 1 striker" in hc.propagate_many([chain])._repr_html_()


@pytest.mark.parametrize("keep", ["velocity", "wall_peak_force"])
def test_sweeps_of_struck_chains_are_complete(keep):
    found = hc.sweep({
        "chain": {"taper": "uniform", "right_wall": {}, "struck_by": {"mass": 2.0, "radius": 1.0}},
        "axes": {"beads": [4, 6]},
        "sweep": {"methods": ["simulate"], "keep": [keep, "wall_impulse"]},
    })  # fmt: skip
    assert (found.status == 1).all()


@pytest.mark.parametrize("stiffness", [0.7, 1.4])
@pytest.mark.parametrize("taper", ["linear", "sine"])
def test_the_law_is_continuous_where_the_striker_has_the_mass_of_a_bead(taper, stiffness):
    radii = TAPERS[taper]
    equal = (radii[0] ** 2 / radii[1]) ** 3
    below, above = (
        hc.local_rate(hc.Chain(radii).struck_by(mass=mass, radius=1.0, stiffness=stiffness))
        for mass in (equal * (1 - 1e-9), equal * (1 + 1e-9))
    )
    np.testing.assert_allclose(above.velocity, below.velocity, rtol=1e-8)


def test_derivatives_by_single_radii_are_those_of_the_simulation_only():
    """Derivatives by the second ball, of which the page states those of law and simulation."""
    chain = hc.Chain.uniform(50).struck_by(mass=3.0, radius=1.2)
    with pytest.raises(
        hc.InputError, match="local_rate_gradient does not support strikers; use gr"
    ):
        hc.local_rate_gradient(chain, bead=30)
    exact = hc.gradient(chain, "pulse.velocity@30", to="radii")
    slopes = exact["radii"] * chain.radii / exact.value
    assert slopes.max() == pytest.approx(0.32, abs=0.005)
    assert slopes[2] == pytest.approx(0.07, abs=0.005)

    def of_law(factor):
        changed = chain.radii * np.where(np.arange(51) == 2, factor, 1.0)
        return hc.local_rate(chain.replace(radii=changed)).velocity[29]

    assert np.log(of_law(1.0001) / of_law(0.9999)) / 2e-4 == pytest.approx(-0.24, abs=0.005)


def test_the_material_of_a_striker_is_not_counted_among_those_of_the_beads():
    beads = hc.Chain.from_materials("2.5 mm", "ptfe", beads=4)
    struck = beads.struck_by(material="brass", velocity=0.1)
    assert struck.description == "4 ptfe beads, diameter 5 mm, and 1 striker (brass, 0.5583 g)"
    assert beads.struck_by(velocity=0.1).description.endswith("and 1 striker")


def test_a_flat_face_can_be_given_as_text():
    """Specifications of sweeps have no infinite numbers."""
    balls = hc.Chain.from_materials("5 mm", "steel-52100", beads=4)
    given = {"mass": "50 g", "velocity": "0.1 m/s"}
    assert balls.struck_by(radius="inf mm", **given) == balls.struck_by(
        radius=float("inf"), **given
    )
    with pytest.raises(hc.InputError, match="must be .*finite, got 'inf m/s'"):
        balls.struck_by(mass="50 g", radius="inf mm", velocity="inf m/s")


@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize(("count", "questioned"), [(200, True), (6, True), (5, False)])
def test_a_number_of_strikers_that_may_be_grams_is_questioned(run, count, questioned):
    found = run("simulate", "--material", "brass", "--diameter", "9mm", "--beads", 5,
                "--speed", "0.1m/s", "--striker", count, "--until", "20us")  # fmt: skip
    assert (f"for a mass, write, for example, --striker '{count} g'" in found.stderr) is questioned


def test_the_height_of_a_fall_determines_the_velocity():
    """A ball dropped from 5 mm; a body under gravity falls this distance in the same time."""
    row = hc.Chain.from_materials(diameters="10 mm", materials="brass", beads=5)
    struck = row.struck_by(height="5 mm", mass="4 g")
    duration = (2.0 * 5e-3 / 9.80665) ** 0.5
    assert struck.velocities[0] == pytest.approx(9.80665 * duration, rel=1e-14)
    text = '[chain]\ndiameters = "10 mm"\nmaterials = "brass"\nbeads = 5\n[chain.struck_by]\n'
    read = hc.chain_from_toml(text + 'height = "5 mm"\nmass = "4 g"')
    assert read == struck
    assert hc.chain_from_toml(hc.chain_as_toml(read)) == read
    with pytest.raises(hc.InputError, match="a velocity or a height to fall from, not both"):
        hc.chain_from_toml(text + 'height = "5 mm"\nvelocity = "1 m/s"')
    with pytest.raises(hc.InputError, match="height requires a chain in SI units"):
        hc.Chain.uniform(5).struck_by(height=1.0)
    with pytest.raises(hc.InputError, match="height of the strikers"):
        row.struck_by(height=-1.0)


def test_the_height_of_a_fall_on_the_command_line(run):
    row = ("simulate", "--material", "steel-52100", "--diameter", "10 mm", "--beads", "5")
    code, out, _ = run(*row, "--striker", "4 g, height=0.2 mm")
    assert code == 0
    assert f"{(2.0 * 9.80665 * 2e-4) ** 0.5:.4g} m/s" in out
    code, _, err = run(*row, "--striker", "4 g, height=0.2 mm", "--speed", "1 m/s")
    assert code == 2
    assert "has a height to fall from" in " ".join(err.split())
    code, _, err = run(*row, "--striker", "4 g, height=5")
    assert code == 2
    assert "height of --striker 5 has no unit; write" in " ".join(err.split())


def test_the_energy_of_an_impact_determines_the_velocity(run):
    row = hc.Chain.from_materials(diameters="10 mm", materials="brass", beads=5)
    struck = row.struck_by(mass="300 g", radius="flat", energy="2 J")
    kinetic = 0.5 * struck.masses @ struck.velocities**2
    assert kinetic == pytest.approx(2.0, rel=1e-14)
    both = row.struck_by(energy="20 mJ", count=2)
    assert 0.5 * both.masses @ both.velocities**2 == pytest.approx(0.04, rel=1e-14)
    text = '[chain]\ndiameters = "10 mm"\nmaterials = "brass"\nbeads = 5\n[chain.struck_by]\n'
    assert hc.chain_from_toml(text + 'energy = "2 J"\nmass = "300 g"\nradius = "flat"') == struck
    with pytest.raises(hc.InputError, match="have a velocity or an energy, not both"):
        hc.chain_from_toml(text + 'energy = "2 J"\nvelocity = "1 m/s"')
    with pytest.raises(hc.InputError, match="have a height to fall from or an energy, not both"):
        row.struck_by(height="5 mm", energy="2 J")
    with pytest.raises(hc.InputError, match="energy requires a chain in SI units"):
        hc.Chain.uniform(5).struck_by(energy=1.0)
    with pytest.raises(hc.InputError, match="energy of the strikers"):
        row.struck_by(energy=-1.0)
    options = ("simulate", "--material", "steel-52100", "--diameter", "10 mm", "--beads", "5")
    code, out, _ = run(*options, "--striker", "20 g, 0.1 mJ")
    assert code == 0
    assert "impact at 0.1 m/s" in out
    code, _, err = run(*options, "--striker", "20 g, 0.1 mJ", "--speed", "1 m/s")
    assert code == 2
    assert "has an energy, which determines the speed" in " ".join(err.split())
    code, out, _ = run(*options, "--striker", "20 g, flat, 0.2 m/s")
    assert code == 0
    assert "impact at 0.2 m/s" in out
    code, _, err = run(*options, "--striker", "20 g, 0.2 m/s", "--height", "2 mm")
    assert code == 2
    assert "has a speed: omit it or --height" in " ".join(err.split())

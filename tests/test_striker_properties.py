"""Masses, faces and contacts of strikers, in chains whose other beads follow from their radii."""

import math
from contextlib import nullcontext

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.sweeps.plan import Plan
from hertzchain.sweeps.specification import read_specification

STEEL = "steel-52100"
SIZES = np.array([5.0, 4.0, 6.0, 4.5, 5.5, 5.0, 3.5, 4.0])
STRIKERS = {
    "mass": {"mass": 3.0, "radius": 1.2},
    "flat": {"mass": 4.0, "radius": math.inf},
    "stiffness": {"mass": 2.0, "stiffness": 1.3},
    "pair": {"mass": 2.0, "radius": 0.9, "count": 2},
    "faces": {"mass": 4.0, "radius": math.inf, "count": 2, "stiffness": 1.1},
    "gap": {"mass": 0.5, "radius": 1.0, "gap": 0.3},
}
WALL = {"right_wall": hc.Wall()}


def scaled_row(radii, striker):
    """A scaled row of balls and a striker, built from the radii of the balls."""
    return hc.Chain(radii, **WALL).struck_by(**striker)


def real_row(radii, striker, material=STEEL):
    """The same in SI units, with a striker in units of a ball of 10 mm."""
    units = {"mass": 4.07e-3, "radius": 5e-3, "stiffness": 7.4e9, "gap": 1e-5, "count": 1}
    own = {name: value * units[name] for name, value in striker.items()}
    balls = hc.Chain.from_materials(5e-3 * np.asarray(radii), material, **WALL)
    return balls.struck_by(**own, velocity=0.02)


ROWS = pytest.mark.parametrize("row", [scaled_row, real_row])
GIVEN = pytest.mark.parametrize("striker", [pytest.param(each, id=name)
                                            for name, each in STRIKERS.items()])  # fmt: skip


def peak(chain):
    return hc.simulate(chain, until=2e-3 if chain.units == "SI" else 60.0).wall_force().peak


@ROWS
@GIVEN
def test_other_radii_change_the_masses_of_the_balls(row, striker):
    chain, sizes = row(SIZES / 5.0, striker), SIZES / 5.0 * [1.0, *np.linspace(0.8, 1.3, 7)]
    radii = np.concatenate((chain.radii[: chain.strikers], sizes * chain.radii[chain.strikers]))
    changed, built = chain.replace(radii=radii), row(sizes, striker)
    assert changed == built
    assert changed.masses == pytest.approx(built.masses, rel=1e-14)
    assert changed.stiffness == pytest.approx(built.stiffness, rel=1e-14)
    assert peak(changed) == pytest.approx(peak(built), rel=1e-12)


@pytest.mark.long
@ROWS
@GIVEN
def test_derivatives_by_radii_are_differences_of_rebuilt_chains(row, striker):
    chain = row(SIZES / 5.0, striker)
    until = 2e-3 if chain.units == "SI" else 60.0
    _, slope = hc.gradient(chain, "wall_force.peak", to=["radii"], until=until, rtol=1e-11)

    def rebuilt(ball, factor):
        sizes = SIZES / 5.0
        sizes[ball] *= factor
        return hc.simulate(row(sizes, striker), until=until, rtol=1e-11).wall_force().peak

    step, first = 1e-4, chain.strikers
    for ball in (1, 4, 7):
        expected = (rebuilt(ball, 1 + step) - rebuilt(ball, 1 - step)) / (2 * step)
        found = slope["radii"][first + ball] * chain.radii[first + ball]
        assert found == pytest.approx(expected, rel=2e-5, abs=1e-6 * peak(chain))


def test_derivatives_by_the_size_and_mass_of_a_striker():
    """Of a sphere of given mass only the contact follows its radius, of a flat face nothing."""
    sizes = SIZES / 5.0
    for striker in (STRIKERS["mass"], STRIKERS["flat"]):
        chain = real_row(sizes, striker)
        found = hc.gradient(chain, "wall_force.peak", to=["radii", "masses", "density", "young"],
                            until=2e-3, rtol=1e-11)  # fmt: skip

        def peak_of(factor, name, own=striker):
            changed = real_row(sizes, own | {name: own[name] * factor})
            return hc.simulate(changed, until=2e-3, rtol=1e-11).wall_force().peak

        for name, field in (("radius", "radii"), ("mass", "masses")):
            difference = (peak_of(1 + 1e-4, name) - peak_of(1 - 1e-4, name)) / 2e-4
            slope = found[field][0] * getattr(chain, field)[0]
            assert slope == pytest.approx(difference, rel=2e-5, abs=1e-5)
        assert found["density"][0] == 0.0

        def peak_with(factor, own=striker):
            steel = hc.material(STEEL)
            other = hc.Material("other", steel.density, factor * steel.young, steel.poisson)
            changed = real_row(sizes, own, other)
            return hc.simulate(changed, until=2e-3, rtol=1e-11).wall_force().peak

        difference = (peak_with(1 + 1e-4) - peak_with(1 - 1e-4)) / 2e-4
        assert (found["young"] * hc.material(STEEL).young).sum() == pytest.approx(
            difference, rel=2e-5
        )


@ROWS
@GIVEN
def test_a_chain_file_describes_the_same_chain(row, striker):
    chain = row(SIZES / 5.0, striker).struck_by(velocity=0.7)
    text = hc.chain_as_toml(chain)
    assert hc.chain_from_toml(text) == chain
    assert "masses" not in text
    assert f"{chain.masses[-1]!r}" not in text


def test_a_chain_file_can_give_masses_of_strikers_with_units():
    text = (
        '[chain]\ndiameters = "10 mm"\nbeads = 5\nmaterials = "brass"\nstrikers = 1\n'
        'velocity = "1 m/s"\nstriker_properties = [{mass = "50 g", flat = true}]'
    )
    chain = hc.chain_from_toml(text)
    assert chain.masses[0] == 0.05
    balls = hc.Chain.from_materials(5e-3, "brass", beads=4)
    assert (
        chain.stiffness.tolist() == balls.struck_by(mass=0.05, radius=math.inf).stiffness.tolist()
    )


def test_a_chain_file_gives_masses_once():
    for name, item in (("masses", "mass"), ("stiffness", "stiffness")):
        text = f'[chain]\ntaper = "uniform"\nbeads = 4\nstrikers = 1\n{name} = 1.0\n'
        with pytest.raises(hc.InputError, match=f"has {name}, and striker_properties also has"):
            hc.chain_from_toml(text + f"striker_properties = [{{{item} = 2.0}}]")


@GIVEN
def test_converted_chains_keep_what_is_given(striker):
    chain = real_row(SIZES / 5.0, striker)
    scales = hc.Scales.of(chain)
    scaled = scales.to_scaled(chain)
    assert scaled.given.isdisjoint({"masses", "stiffness"})
    assert scaled.masses == pytest.approx(chain.masses / scales.mass, rel=1e-14)
    radii = scaled.radii * np.where(np.arange(chain.beads) == chain.beads - 2, 1.1, 1.0)
    assert scaled.replace(radii=radii).masses[-2] == pytest.approx(radii[-2] ** 3, rel=1e-14)
    back = scales.to_si(scaled)
    for name in ("radii", "masses", "stiffness"):
        assert getattr(back, name) == pytest.approx(getattr(chain, name), rel=1e-14)
    assert back.given == chain.given
    for one, other in zip(back.striker_properties, chain.striker_properties, strict=True):
        assert (one.mass is None, one.flat) == (other.mass is None, other.flat)


def test_a_striker_of_another_density_keeps_the_masses_of_scaled_balls_derived():
    balls = hc.Chain.from_materials(5e-3, STEEL, beads=6)
    chain = balls.struck_by(material="tungsten-carbide", velocity=0.02)
    scaled = hc.Scales.of(chain).to_scaled(chain)
    assert "masses" not in scaled.given
    assert scaled.masses[0] == pytest.approx(chain.masses[0] / chain.masses[1], rel=1e-14)


def test_pieces_keep_the_properties_of_their_strikers():
    chain = scaled_row(SIZES / 5.0, STRIKERS["mass"])
    assert chain[:5] == scaled_row(SIZES[:4] / 5.0, STRIKERS["mass"]).replace(right_wall=None)
    assert chain[1:].striker_properties == ()
    assert chain[1:].masses.tolist() == ((SIZES / 5.0) ** 3).tolist()
    longer = chain[:5] + hc.Chain.uniform(3)
    assert longer.masses.tolist() == [3.0, *(SIZES[:4] / 5.0) ** 3, 1.0, 1.0, 1.0]
    assert longer.replace(radii=np.full(8, 0.9)).masses[1:] == pytest.approx(0.9**3)


def test_a_ball_meets_the_flat_face_of_an_earlier_striker():
    balls = hc.Chain.from_materials(5e-3, STEEL, beads=3)
    chain = balls.struck_by(mass="50 g", radius=math.inf).struck_by(radius="3 mm", velocity=2)
    wall = hc.Chain.from_materials("3 mm", STEEL, beads=2, left_wall=hc.Wall()).wall_stiffness[0]
    assert chain.stiffness[0] == pytest.approx(wall, rel=1e-14)
    hammer = {"mass": "50 g", "radius": math.inf}
    touching = "flat faces of beads 1 and 2 touch, so that the stiffness of contact 1 cannot be"
    listed = balls.replace(stiffness=balls.stiffness)
    for row in (balls, listed):
        with pytest.raises(hc.InputError, match=touching):
            row.struck_by(**hammer).struck_by(**hammer)
        with pytest.raises(hc.InputError, match=touching):
            row.struck_by(**hammer, count=2)
    assert balls.struck_by(**hammer).struck_by(**hammer, stiffness=1e9).stiffness[0] == 1e9


def test_properties_belong_to_strikers():
    chain = hc.Chain.uniform(4).struck_by(mass=2.0, radius=1.0)
    with pytest.raises(hc.InputError, match="one item for each striker, got 1 for 2 strikers"):
        chain.replace(strikers=2)
    with pytest.raises(hc.InputError, match="a striker has a unit in its mass, but the chain is"):
        chain.replace(striker_properties=[hc.chain.striker_properties.StrikerProperties("2 g")])
    every = chain.replace(masses=[5.0, 1.0, 1.0, 1.0, 2.0])
    assert every.masses.tolist() == [5.0, 1.0, 1.0, 1.0, 2.0]
    assert every.striker_properties == ()


@pytest.mark.parametrize("striker", [STRIKERS["mass"], STRIKERS["flat"]])
def test_designs_of_a_chain_with_a_striker_of_given_mass(striker):
    """The chain of a design is that which is built from its radii."""
    chain = real_row(np.ones(5), striker)
    problem = hc.Design(chain, minimise="wall_force.peak", until=2e-3,
                        vary=[hc.vary.diameters("6 mm", "12 mm", beads="2:")])  # fmt: skip
    found = hc.design(problem, budget=150)
    built = real_row(found.chain.radii[1:] / 5e-3, striker)
    assert found.chain.masses == pytest.approx(built.masses, rel=1e-13)
    first = "flat" if striker == STRIKERS["flat"] else "12"
    assert f"diameters [mm], from the struck end: {first}, " in found.summary()
    run = hc.simulate(built, until=2e-3, rtol=1e-11)
    assert found.value == pytest.approx(run.wall_force().peak, rel=1e-6)
    with pytest.raises(hc.InputError, match="bead 1, a striker, varies, but its mass is given"):
        hc.design(hc.Design(chain, minimise="wall_force.peak",
                            vary=[hc.vary.diameters("6 mm", "12 mm", beads="1:")]))  # fmt: skip


def test_splines_of_radii_do_not_begin_at_a_striker():
    """Equal balls of any size belong to the designs, whatever the striker."""
    chain = real_row(np.ones(8), STRIKERS["flat"])
    block = hc.vary.radii("3 mm", "9 mm", by="spline", knots=5).block(chain)
    for size in (4e-3, 7e-3):
        sizes = np.full(8, size)
        assert block.sizes(block.coefficients(sizes)) == pytest.approx(sizes, rel=1e-9)


def test_the_table_of_sensitivities_shows_flat_faces(run, tmp_path):
    file = tmp_path / "chain.toml"
    file.write_text(hc.chain_as_toml(real_row(np.ones(3), STRIKERS["flat"])))
    _, out, _ = run("sensitivity", file, "--quantity", "wall_force.peak")
    (row,) = [line for line in out.splitlines() if "(striker)" in line]
    assert row.split()[2] == "flat"
    assert [float(each) for each in row.split()[3:]] == [0.0, 0.0]


def test_a_flat_striker_is_no_cylinder():
    chain = real_row(np.ones(3), STRIKERS["flat"])
    with pytest.raises(hc.InputError, match="a flat striker or cap is not a cylinder"):
        chain.with_contacts(hc.CrossedCylinders())
    crossed = chain.with_contacts({2: hc.CrossedCylinders()})
    assert crossed.stiffness[0] == chain.stiffness[0]


def test_orders_and_choices_of_balls_behind_a_striker_of_given_mass():
    chain = real_row(SIZES[:4] / 5.0, STRIKERS["mass"])
    for vary in (hc.vary.order(), hc.vary.balls(diameters=["8 mm", "10 mm"], materials=[STEEL])):
        found = hc.design(hc.Design(chain, minimise="wall_force.peak", vary=[vary], until=2e-3))
        built = real_row(found.chain.radii[1:] / 5e-3, STRIKERS["mass"])
        assert found.chain.masses == pytest.approx(built.masses, rel=1e-13)
        assert found.value == pytest.approx(peak(built), rel=1e-6)
    with pytest.raises(hc.InputError, match="bead 1 is the striker; the order .* use beads='2:'"):
        hc.design(hc.Design(chain, minimise="wall_force.peak", vary=[hc.vary.order(beads="1:")]))


def test_random_radii_behind_a_striker_of_given_mass():
    chain = scaled_row(np.ones(6), STRIKERS["mass"])
    random = chain.with_scatter(5, relative=0.1)
    assert random.masses.tolist() == [3.0, *random.radii[1:] ** 3]
    lot = hc.Scatter(radius=0.05, samples=4)
    found = hc.distribution(chain, "wall_force.peak", lot, seed=1)
    values = [
        peak(scaled_row(each.radii[1:], STRIKERS["mass"])) for each in lot.sample(chain, seed=1)
    ]
    assert np.sort(found.values) == pytest.approx(np.sort(values), rel=1e-6)


def test_sweeps_over_radii_behind_a_striker_of_given_mass():
    chain = real_row(np.ones(4), STRIKERS["mass"])
    found = hc.sweep({
        "chain": chain, "axes": {"radii.3": [4e-3, 6e-3]},
        "sweep": {"methods": ["simulate"], "keep": ["wall_force.peak"]},
        "method": {"until": 2e-3},
    })  # fmt: skip
    for size, value in zip((0.8, 1.2), np.ravel(found["wall_peak_force"]), strict=True):
        expected = peak(real_row([1.0, size, 1.0, 1.0], STRIKERS["mass"]))
        assert value == pytest.approx(expected, rel=1e-6)


def test_sweeps_over_the_mass_of_a_striker_and_the_radii_of_balls():
    chain = real_row(np.ones(4), STRIKERS["mass"])
    settings = {
        "sweep": {"methods": ["simulate"], "keep": ["wall_force.peak"]}, "method": {"until": 2e-3}
    }  # fmt: skip
    axes = {"striker_properties.1.mass": [8e-3, 12e-3], "radii.5": [4e-3, 6e-3]}
    found = hc.sweep({"chain": chain, "axes": axes} | settings)
    for i, j in np.ndindex(2, 2):
        striker = STRIKERS["mass"] | {"mass": (8e-3, 12e-3)[i] / 4.07e-3}
        expected = peak(real_row([1.0, 1.0, 1.0, (0.8, 1.2)[j]], striker))
        assert float(found["wall_peak_force"][i, j].item()) == pytest.approx(expected, rel=1e-6)
    with pytest.raises(hc.InputError, match=r"axes.masses.1: would fix the masses .* axes.radii.5"):
        hc.sweep({"chain": chain, "axes": {"masses.1": [8e-3], "radii.5": [4e-3, 6e-3]}} | settings)


def test_designs_in_which_masses_would_not_follow_radii_are_rejected():
    vary = [hc.vary.radii(0.5, 1.0, beads="2:4"), hc.vary.masses(0.5, 1.0, beads="5")]
    with pytest.raises(hc.InputError, match="that of bead 2 would not follow its radius"):
        hc.design(hc.Design(hc.Chain.uniform(6, **WALL), minimise="wall_force.peak", vary=vary))


def test_the_file_of_a_flat_striker_says_what_its_size_is():
    row = real_row(np.ones(3), STRIKERS["flat"])
    # A striker that moves away is not one of `struck_by`.
    text = hc.chain_as_toml(row.replace(velocities=[-1.0, *[0.0] * (row.beads - 2), 0.5]))
    said = "# The striker, bead 1, has a flat face; its size is that of a sphere of its mass."
    assert text.splitlines()[:2] == [said, "[chain]"]
    assert "#" not in hc.chain_as_toml(real_row(np.ones(3), STRIKERS["mass"]))


@pytest.mark.parametrize("name", ["flat", "stiffness"])
def test_fitted_radii_and_densities_change_masses(name):
    from hertzchain.fitting.chain_parameters import with_sizes
    from hertzchain.fitting.names import Name

    chain = real_row(SIZES / 5.0, STRIKERS[name])
    changed = with_sizes(chain, {Name("radius", "3"): 7e-3, Name("mass", "5"): 9e-3}, 1e-5)
    built = real_row([*SIZES[:2] / 5.0, 1.4, *SIZES[3:] / 5.0], STRIKERS[name]).masses.copy()
    built[5] = 9e-3
    assert changed.masses == pytest.approx(built, rel=1e-13)


def test_limits_of_hertz_law_at_a_flat_striker():
    """As for a ball of the material of the striker on a flat wall under the same force."""
    balls = hc.Chain.from_materials(5e-3, STEEL, beads=3)
    chain = balls.struck_by(mass="50 g", radius=math.inf, velocity=0.2)
    overlap = 1e-6
    found = hc.hertz_range(chain, [overlap, 0.0, 0.0])
    steel = hc.material(STEEL)
    modulus = steel.young / (2 * (1 - steel.poisson**2))
    pressure = 2 / math.pi * modulus * math.sqrt(overlap / 5e-3)
    assert found.overlap_ratio[1] == pytest.approx(overlap / 5e-3, rel=1e-12)
    assert found.yield_ratio[1] == pytest.approx(pressure / (1.6 * steel.yield_strength), rel=1e-12)
    pair = balls.struck_by(mass="50 g", radius=math.inf, count=2, stiffness=1e10)
    with pytest.raises(hc.InputError, match="two flat faces touch: give a yield_overlap"):
        pair.replace(loss=hc.ElasticPlastic())
    soft = chain.replace(loss=hc.ElasticPlastic())
    law = soft.contact_groups[0].law
    limit = law.strength(soft.contact_groups[0].contacts)
    touching = hc.Chain.from_materials(5e-3, STEEL, beads=2, left_wall=hc.Wall(),
                                       loss=hc.ElasticPlastic()).contact_groups[0]  # fmt: skip
    assert limit[1] == pytest.approx(touching.law.strength(touching.contacts)[0], rel=1e-12)


@pytest.mark.parametrize("build", [
    lambda v: hc.Chain.uniform(6).replace(velocities=[v, 0, 0, 0, 0, 0]),
    lambda v: hc.Chain.from_materials(5e-3, STEEL, beads=6, velocity=v),
    lambda v: hc.Chain.uniform(6).struck_by(velocity=v),
    lambda v: hc.Chain.from_materials(5e-3, STEEL, beads=6, velocities=[v, 0, 0, 0, 0, 0]),
])  # fmt: skip
def test_velocities_are_limited_to_those_with_representable_energies(build):
    """Up to the limit, simulations and theories give the velocities of a slower impact, scaled."""
    with pytest.raises(hc.InputError, match=r"velocity of .*1e\+100.*"):
        build(1e101)
    with pytest.raises(
        hc.InputError, match=r"velocity of bead 1.* is 1e-101: .* 1e-100 in magnitude"
    ):
        build(1e-101)
    fast, slow = build(1e100), build(1.0)
    with pytest.warns(hc.ModelRangeWarning) if fast.units == "SI" else nullcontext():
        found = hc.propagate(fast).velocity, hc.simulate(fast).pulse().velocity
        table = hc.simulate_many([fast], keep=["velocity"])
        expected = hc.propagate(slow).velocity
    assert found[0] == pytest.approx(1e100 * expected, rel=1e-7)
    assert found[1] == pytest.approx(1e100 * expected, rel=1e-5)
    assert table["velocity"][0] == pytest.approx(1e100 * expected, rel=1e-5)
    assert hc.propagate(build(1e-100)).velocity == pytest.approx(
        1e-100 * expected, rel=1e-7, abs=0.0
    )


@pytest.mark.parametrize(("mass", "advice"), [(1e6, "less unequal masses"), (None, "fewer beads")])
def test_long_runs_of_heavy_strikers_are_explained(mass, advice):
    with pytest.raises(hc.SimulationError, match=f"use {advice} if the time hardly advances"):
        hc.simulate(hc.Chain.uniform(6).struck_by(mass=mass, radius=1.0), max_steps=20)


@pytest.mark.parametrize("size", ["radius", "diameter"])
def test_flat_is_the_size_of_a_striker_with_a_flat_face(size):
    row = hc.Chain.from_materials(5e-3, "steel-52100", beads=3)
    flat = row.struck_by(velocity=0.1, mass=0.02, radius=math.inf)
    assert row.struck_by(velocity=0.1, mass=0.02, **{size: "flat"}) == flat
    table = {"diameters": 0.01, "beads": 3, "material": "steel-52100"}
    struck = {"velocity": 0.1, "mass": 0.02, size: "20 mm"}
    spec = {"chain": table | {"struck_by": struck}, "axes": {f"struck_by.{size}": ["flat", "9 mm"]}}
    plan = Plan(read_specification(spec))
    assert plan.chain((0,)) == flat
    assert not plan.chain((1,)).striker_properties[0].flat

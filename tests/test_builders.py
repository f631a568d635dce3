"""Chains of many beads by rules: periodic, decorated, with defects, scatter and strikers."""

import math

import numpy as np
import pytest

import hertzchain as hc
from hertzchain import Chain, InputError
from hertzchain.chain.materials import contact_modulus, sphere_stiffness
from hertzchain.chain.random_radii import BALL_GRADES


def test_a_dimer_has_one_parameter():
    chain = Chain.dimer(0.3428, beads=5)
    np.testing.assert_allclose(chain.masses, [1, 0.3428, 1, 0.3428, 1])
    np.testing.assert_array_equal(chain.stiffness, 1.0)
    np.testing.assert_allclose(chain.radii**3, chain.masses, rtol=1e-15)


def test_a_dimer_of_typed_sizes_is_in_si_units():
    chain = Chain.dimer(
        diameters=["10 mm", "6 mm"], materials=["steel-316", "ptfe"], beads=5, velocity="1 cm/s"
    )
    assert chain.radii.tolist() == [5e-3, 3e-3, 5e-3, 3e-3, 5e-3]
    assert [kind.name for kind in chain.materials] == ["steel-316", "ptfe"] * 2 + ["steel-316"]
    assert chain.velocities[0] == 0.01
    same = Chain.dimer(radii=["5 mm", "0.3 cm"], materials="brass", beads=4)
    assert same.radii.tolist() == [5e-3, 3e-3, 5e-3, 3e-3]
    scaled = Chain.dimer(radii=[5.0, 3.0], beads=3)
    assert scaled.units == "scaled"
    np.testing.assert_allclose(scaled.masses, [1.0, 0.6**3, 1.0])


def test_spheres_of_one_material_in_turn_are_such_a_dimer_in_another_time():
    ratio = 0.3428 ** (1 / 3)
    spheres = Chain.periodic([1.0, ratio], cells=3)
    np.testing.assert_allclose(spheres.masses, Chain.dimer(0.3428, beads=6).masses, rtol=1e-14)
    assert np.ptp(spheres.stiffness) < 1e-15


def test_small_beads_follow_the_taper_of_the_large_ones():
    large = Chain.tapered("forward-exponential", 0.1, beads=6)
    chain = large.decorated(0.3, between=2)
    assert chain.beads == 16
    np.testing.assert_allclose(chain.radii[::3], large.radii, rtol=1e-15)
    for j in range(5):
        small = 0.3 * math.sqrt(large.radii[j] * large.radii[j + 1])
        np.testing.assert_allclose(chain.radii[3 * j + 1 : 3 * j + 3], small, rtol=1e-14)


def test_small_beads_may_be_of_one_size_and_another_material():
    large = Chain.from_materials([5e-3, 4e-3, 3e-3], ["brass", "glass", "brass"], velocity=2.0)
    chain = large.decorated(radius=1e-3, material="aluminium", between=2)
    assert [each.name for each in chain.materials] == [
        "brass", "aluminium", "aluminium", "glass", "aluminium", "aluminium", "brass",
    ]  # fmt: skip
    np.testing.assert_array_equal(chain.radii, [5e-3, 1e-3, 1e-3, 4e-3, 1e-3, 1e-3, 3e-3])
    np.testing.assert_array_equal(chain.velocities, [2.0, 0, 0, 0, 0, 0, 0])
    assert large.decorated(0.3).materials[1].name == "brass"


@pytest.mark.parametrize("kind", ["scaled", "SI"])
def test_the_diameter_of_small_beads_is_twice_their_radius(kind):
    large, size = (Chain.uniform(4), 0.8) if kind == "scaled" else (BALLS, "8 mm")
    half = 0.4 if kind == "scaled" else "4 mm"
    assert large.decorated(diameter=size) == large.decorated(radius=half)


def test_what_the_chain_stands_between_stays():
    chain = Chain.uniform(4).replace(right_wall=hc.Wall(), loss=hc.Restitution(0.9))
    assert chain.decorated(0.3).right_wall == hc.Wall()
    assert chain.with_scatter(1, relative=0.1).loss == hc.Restitution(0.9)


def test_defects_are_counted_from_one():
    chain = Chain.from_materials(5e-3, "brass", beads=4).with_defects(
        {1: 4e-3, 3: 6e-3}, material="glass"
    )
    np.testing.assert_array_equal(chain.radii, [4e-3, 5e-3, 6e-3, 5e-3])
    assert [each.name for each in chain.materials] == ["glass", "brass", "glass", "brass"]


def test_defects_have_radii_or_diameters():
    chain = Chain.from_materials(5e-3, "brass", beads=9)
    given = chain.with_defects(diameters={8: "8 mm", 2: 6e-3})
    np.testing.assert_array_equal(given.radii, chain.with_defects({8: 4e-3, 2: 3e-3}).radii)
    scaled = Chain.uniform(5).with_defects(diameters={1: 1.0})
    np.testing.assert_array_equal(scaled.radii, [0.5, 1.0, 1.0, 1.0, 1.0])
    for sizes, words in (
        ({}, r"radii or diameters by bead number, such as diameters=.*: neither was given"),
        ({"radii": {8: 4e-3}, "diameters": {8: 8e-3}}, "both were given"),
        ({"diameters": 8e-3}, "diameters by bead number, .* got 0.008"),
        ({"diameters": {8: -1.0}}, "diameter of bead 8 must be above 0"),
        ({"diameters": {8: "8 kg"}}, "diameter of bead 8 must have a unit such as m"),
        ({"diameters": {10: 8e-3}}, "from 1 to 9, got 10"),
    ):
        with pytest.raises(hc.InputError, match=words):
            chain.with_defects(**sizes)


def test_balls_scatter_within_their_grade_and_by_their_seed():
    chain = Chain.from_materials(5e-3, "steel-52100", beads=2000)
    first, second = (chain.with_scatter(seed, grade=100) for seed in (7, 7))
    np.testing.assert_array_equal(first.radii, second.radii)
    diameters = 2 * first.radii
    # The lot diameter variation is 5 um; 2000 balls use more than 99% of it.
    assert 4.95e-6 < np.ptp(diameters) <= 5e-6
    assert abs(diameters.mean() - 0.01) < 1e-7
    assert not np.array_equal(chain.with_scatter(8, grade=100).radii, first.radii)


def test_grades_get_wider():
    widths = list(BALL_GRADES.values())
    assert widths == sorted(widths)


def test_relative_scatter_has_its_standard_deviation():
    radii = Chain.uniform(20_000).with_scatter(np.random.default_rng(3), relative=0.2).radii
    # Standard error of a standard deviation: 0.2/sqrt(2 N) = 0.001.
    assert np.log(radii).std() == pytest.approx(0.2, abs=0.004)


def test_beads_can_be_left_out_of_the_scatter(tmp_path):
    chain = Chain.from_materials(5e-3, "steel-52100", beads=6)
    everywhere = chain.with_scatter(3, relative=0.02).radii
    some = chain.with_scatter(3, relative=0.02, beads="2:4").radii
    np.testing.assert_array_equal(some[1:4], everywhere[1:4])
    np.testing.assert_array_equal(some[[0, 4, 5]], chain.radii[[0, 4, 5]])
    listed = chain.with_scatter(3, relative=0.02, beads=[4, 2, 3]).radii
    np.testing.assert_array_equal(listed, some)
    file = tmp_path / "lot.toml"
    file.write_text(
        '[chain]\nradii = 5e-3\nmaterials = "steel-52100"\nbeads = 6\n'
        '[chain.with_scatter]\nseed = 3\nrelative = 0.02\nbeads = "2:4"\n'
    )
    np.testing.assert_array_equal(hc.load_chain(file).radii, some)
    with pytest.raises(InputError, match="is outside 1 to 6"):
        chain.with_scatter(3, relative=0.02, beads="2:7")


def test_a_striker_is_a_bead_in_front():
    chain = Chain.uniform(3).struck_by(radius=2.0, velocity=0.5)
    np.testing.assert_array_equal(chain.masses, [8, 1, 1, 1])
    np.testing.assert_array_equal(chain.velocities, [0.5, 0, 0, 0])
    # Spheres of radius 2 and 1: the paper's factor.
    assert chain.stiffness[0] == pytest.approx(math.sqrt(2 * 2 * 1 / 3), rel=1e-15)
    assert chain.strikers == 1
    assert "masses" not in chain.features


def test_a_striker_of_given_mass_is_a_sphere_of_the_chains_density():
    chain = Chain.uniform(3).struck_by(mass=8.0)
    assert chain.radii[0] == pytest.approx(2.0, rel=1e-15)


def test_several_strikers_one_after_the_other():
    chain = Chain.uniform(2).struck_by(count=2, gap=0.1).struck_by(mass=8.0, velocity=3.0, gap=0.2)
    np.testing.assert_array_equal(chain.velocities, [3, 1, 1, 0, 0])
    np.testing.assert_array_equal(chain.gaps, [0.2, 0, 0.1, 0])
    assert chain.strikers == 3


def test_a_heavy_flat_piston():
    balls = Chain.from_materials(5e-3, "brass", beads=3)
    chain = balls.struck_by(mass=0.5, radius=math.inf, material="steel-304", velocity=0.3)
    modulus = contact_modulus(hc.material("steel-304"), hc.material("brass"))
    assert chain.stiffness[0] == pytest.approx(
        float(sphere_stiffness(5e-3, math.inf, modulus)), rel=1e-15
    )
    assert chain.masses[0] == 0.5
    scaled = Chain.uniform(3).struck_by(mass=10.0, radius=math.inf)
    assert scaled.stiffness[0] == pytest.approx(math.sqrt(2), rel=1e-15)


def test_a_striker_of_another_material():
    chain = Chain.from_materials(5e-3, "brass", beads=3).struck_by(material="ptfe", radius=4e-3)
    ptfe = hc.material("ptfe")
    assert chain.masses[0] == pytest.approx(4 / 3 * math.pi * 2170 * 4e-3**3, rel=1e-14)
    modulus = contact_modulus(ptfe, hc.material("brass"))
    assert chain.stiffness[0] == pytest.approx(float(sphere_stiffness(4e-3, 5e-3, modulus)))


DIMER = Chain.dimer(0.5, beads=4)
BALLS = Chain.from_materials(5e-3, "brass", beads=3)


@pytest.mark.parametrize(
    ("build", "said"),
    [
        (lambda: Chain.dimer(beads=4), "needs a mass ratio, two radii or two diameters"),
        (lambda: Chain.dimer(0.5, radii=[1, 2], beads=4), "only one of mass_ratio and radii"),
        (lambda: Chain.dimer(radii=[1, 2], diameters=[1, 2], beads=4), "only one of radii and"),
        (
            lambda: Chain.dimer(radii=[1, 2, 3], beads=4),
            "two sizes, .* got a list of 3; Chain.periodic",
        ),
        (lambda: Chain.dimer(diameters=["1 kg", "1 m"], beads=4), "diameter .* unit such as m"),
        (lambda: Chain.dimer(radii=[1e-3] * 2, materials=["ptfe"], beads=4), "2 beads, but 1 mat"),
        (lambda: Chain.dimer(0.0, beads=4), "mass ratio of a dimer must be above 0, got 0"),
        (lambda: Chain.periodic([1.0, 0.5], cells=0), "cells must be .* at least 1, got 0"),
        (lambda: Chain.periodic([1.0, -0.5], cells=2), "bead 2 is -0.5"),
        (lambda: Chain.periodic(cells=2), "a cell needs either radii or diameters"),
        (lambda: Chain.periodic([1, 2], diameters=[2, 4], cells=2), "either radii or diameters"),
        (lambda: Chain.periodic(diameters=["10 mm", "1 kg"], cells=2), "diameter .* such as m"),
        (
            lambda: Chain.periodic([1.0, 0.5], cells=2, materials=["brass"]),
            "the cell has 2 beads, but 1 materials",
        ),
        (lambda: Chain.uniform(3).decorated(), "ratio of the small beads .* a radius or a diam"),
        (
            lambda: Chain.uniform(3).decorated(0.3, radius=0.3),
            "ratio of the small beads .* a radius or a diameter",
        ),
        (lambda: Chain.uniform(3).decorated(radius=0.3, diameter=0.6), "one of these: the ratio"),
        (lambda: Chain.uniform(3).decorated(diameter=2.5), "have a diameter of 2.5, .* bead, 2;"),
        (lambda: BALLS.decorated(radius="12 mm"), "radius of 12 mm, .* bead, 5 mm; use a"),
        (lambda: BALLS.decorated(radius=4), "radius of 4 m, .*; if millimetres .* write '4 mm'"),
        (lambda: BALLS.decorated(diameter=8), "diameter of 8 m, .* 10 mm; .* write '8 mm'"),
        (lambda: BALLS.decorated(diameter="8 kg"), "diameter of the small beads must have a unit"),
        (lambda: Chain.uniform(3).decorated(1.0), "beads 1 and 2 have a radius of 1,"),
        (lambda: Chain.from_radii([1, 0.1, 1]).decorated(0.5), "radius of 0.158114, .* bead, 0.1;"),
        (lambda: Chain.uniform(3).decorated(0.3, between=0), "between must be .* got 0"),
        (
            lambda: Chain.uniform(3).decorated(0.3, material="brass"),
            "requires a chain with materials",
        ),
        (lambda: DIMER.decorated(0.3), "its masses and stiffness belong to the present"),
        (
            lambda: Chain.uniform(3).struck_by(mass=2.0).decorated(0.3),
            "its strikers belong to the present",
        ),
        (lambda: Chain.uniform(3).with_defects({4: 1.0}), "from 1 to 3, got 4"),
        (lambda: Chain.uniform(3).with_defects({2: 0.0}), "radius of bead 2 must be above 0"),
        (lambda: Chain.uniform(3).with_scatter(1), "give either relative, such as 0.01, or grade"),
        (lambda: Chain.uniform(3).with_scatter(1, grade=100), "micrometres"),
        (lambda: BALLS.with_scatter(1, grade=11), "no ball grade 11; choose from 3, 5, 10"),
        (lambda: BALLS.with_scatter(1, relative=0.31), "at least 0 and at most 0.3, got 0.31"),
        (lambda: BALLS.with_scatter(1, relative=-0.1), "relative scatter must be at least 0"),
        (lambda: Chain.uniform(3).struck_by(radius=math.inf), "has no default mass; give mass"),
        (lambda: Chain.uniform(3).struck_by(count=0), "count of strikers .* got 0"),
        (lambda: Chain.uniform(3).struck_by(mass=-1.0), "mass of a striker must be above 0"),
        (
            lambda: Chain.uniform(3).struck_by(gap=-1.0),
            "gap must be at least 0 .*, got -1; a gap is a free",
        ),
        (lambda: DIMER.struck_by(mass=1.0), "give stiffness"),
        (lambda: BALLS.struck_by(mass=1.0, radius=math.inf, count=2), "give stiffness"),
    ],
)
def test_impossible_beads_are_rejected(build, said):
    with pytest.raises(InputError, match=said) as caught:
        build()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("seed", [-1, "a", 1.5])
def test_a_seed_that_is_none(seed):
    with pytest.raises(hc.InputError, match="seed of a scatter"):
        hc.Chain.uniform(5).with_scatter(seed, relative=0.1)


def test_builders_accept_the_fields_of_a_chain():
    wall = hc.Wall()
    sizes = {"first": "10 mm", "last": "5 mm", "beads": 4, "materials": "brass"}
    for built, plain in (
        (hc.Chain.uniform(4, right_wall=wall), hc.Chain.uniform(4).replace(right_wall=wall)),
        (hc.Chain.from_radii([2, 1, 1], gravity=0.1),
         hc.Chain.from_radii([2, 1, 1]).replace(gravity=0.1)),
        (hc.Chain.tapered("forward-linear", 0.1, beads=4, right_wall=wall),
         hc.Chain.tapered("forward-linear", 0.1, beads=4).replace(right_wall=wall)),
        (hc.Chain.tapered(**sizes, velocity=0.2, right_wall=wall),
         hc.Chain.tapered(**sizes, velocity=0.2).replace(right_wall=wall)),
        (hc.Chain.periodic([2, 1], cells=2, right_wall=wall),
         hc.Chain.periodic([2, 1], cells=2).replace(right_wall=wall)),
    ):  # fmt: skip
        assert built.right_wall == plain.right_wall
        np.testing.assert_array_equal(built.contact_stiffness, plain.contact_stiffness)
        assert (built.exponent, built.gravity) == (plain.exponent, plain.gravity)
        assert repr(built) == repr(plain)


def test_strikers_warn_of_a_velocity_that_they_replace():
    balls = Chain.from_materials("5 mm", "brass", beads=5, velocity="0.3 m/s")
    with pytest.warns(hc.InputWarning, match="omits the velocity of bead 1, 0.3 m/s, because"):
        struck = balls.struck_by(velocity=0.1)
    assert struck.velocities.tolist() == [0.1, 0.0, 0.0, 0.0, 0.0, 0.0]
    # Not of the default, of other moving beads and of further strikers, which are kept.
    struck.struck_by()
    Chain.from_materials("5 mm", "brass", beads=5).struck_by()
    moving = Chain.from_materials("5 mm", "brass", beads=3, velocities=[0.0, 0.2, 0.0])
    assert moving.struck_by(velocity=0.1).velocities.tolist() == [0.1, 0.0, 0.2, 0.0]

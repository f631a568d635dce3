"""Messages about unknown and missing arguments of builders and functions."""

import pytest

import hertzchain as hc
from hertzchain.store.chain_files import chain_from

BALLS = {"first_diameter": "20 mm", "last_diameter": "5 mm", "beads": 5}
STEEL = "steel-52100"


@pytest.mark.parametrize(("call", "said"), [
    (lambda: hc.Chain.tapered(**BALLS, material=STEEL, speed=1),
     "Chain.tapered has no argument 'speed'; did you mean 'velocity'\\?"),
    (lambda: hc.Chain.tapered(**BALLS, materials=STEEL, speed=1),
     "no argument 'materials' and no argument 'speed'; did you mean 'material', 'velocity'"),
    (lambda: hc.Chain.tapered("forward-linear", 0.1),
     "Chain.tapered: missing the argument 'beads'; it takes taper, rate, beads"),
    (lambda: hc.Chain.from_materials(5e-3, STEEL, beads=3, speed=3),
     "Chain.from_materials has no argument 'speed'; did you mean 'velocity'"),
    (lambda: hc.Chain.from_materials(5e-3, STEEL, beads=3, units="SI"), "no argument 'units'"),
    (lambda: hc.Chain.uniform(5, speed=1), "no argument 'speed'; it takes beads, exponent"),
    (lambda: hc.Chain.from_radii([1, 2], masses=[1, 2]), "no argument 'masses'; it takes radii"),
    (lambda: hc.Chain.periodic([1, 2], cells=4, velocity=2), "no argument 'velocity'"),
    (lambda: hc.Chain.periodic([1, 2], cells=4, radius=2), "Chain.periodic has no argument"),
    (lambda: hc.Chain.dimer(0.5, beads=4, velocity=2), "of a mass ratio has no argument"),
    (lambda: hc.Chain.dimer(0.5, beads=4, masses=[1.0]), "of a mass ratio has no argument"),
    (lambda: hc.Chain.uniform(5, material=STEEL),
     "no argument 'material'; .*; Chain.from_materials and Chain.tapered make chains of materials"),
    (lambda: hc.Chain.dimer(diameters=[1, 2], beads=4, material=STEEL), "did you mean 'materials'"),
    (lambda: hc.Chain([1, 1], material=STEEL), "Chain has no argument 'material'; .* 'materials'"),
    (lambda: hc.Wall(materials=STEEL), "Wall has no argument 'materials'; did you mean 'material'"),
    (lambda: hc.Wall.of(material=STEEL), "Wall.of has no argument 'material'; .* 'name'"),
    (lambda: hc.Chain.uniform(5).struck_by(3), "struck_by: too many positional arguments"),
    (lambda: hc.Chain.uniform(5).with_scatter(1, sigma=0.1), "with_scatter has no argument"),
    (lambda: hc.attenuation(hc.Chain.uniform(5)), "attenuation: missing the argument 'velocity'"),
    (lambda: hc.hertz_range(hc.propagate(hc.Chain.uniform(5))), "use hertz_range.result.chain."),
    (lambda: hc.ElasticPlastic().restitution(1.0, reduced_mass=1e-3, stiffness=1e9),
     "use ElasticPlastic\\(yield_overlap=...\\).restitution"),
    (lambda: chain_from({"chain": {"taper": "uniform", "beads": 5, "diametres": 1,
                                   "rigth_wall": {}}}),
     "2 errors:\n.*'diametres'.*'diameters'.*\n.*'rigth_wall'.*did you mean 'right_wall'"),
])  # fmt: skip
def test_a_wrong_call_is_explained(call, said):
    with pytest.raises(hc.InputError, match=said):
        call()


def test_a_run_in_place_of_its_chain_is_explained():
    run = hc.simulate(hc.Chain.uniform(4))
    with pytest.raises(hc.InputError, match=r"hertz_range\(run.chain, run.largest_overlaps\)"):
        hc.hertz_range(run)


def test_a_list_of_materials_gives_the_number_of_equal_beads():
    kinds = ["brass", "glass"] * 7 + ["brass"]
    chain = chain_from({"chain": {"diameters": "10 mm", "materials": kinds}})
    assert chain.radii.tolist() == [5e-3] * 15
    assert [each.name for each in chain.materials] == kinds
    with pytest.raises(
        hc.InputError, match="one radius or diameter and one material .* give beads"
    ):
        chain_from({"chain": {"diameters": "10 mm", "materials": "brass"}})
    with pytest.raises(hc.InputError, match="must be 4 materials"):
        chain_from({"chain": {"diameters": "10 mm", "materials": kinds, "beads": 4}})


def test_the_yield_overlap_gives_the_restitution_in_si_units():
    law = hc.ElasticPlastic(yield_overlap=1e-6)
    slow = law.restitution(1e-4, reduced_mass=2e-3, stiffness=7.4e9)
    fast = law.restitution(1.0, reduced_mass=2e-3, stiffness=7.4e9)
    assert slow == pytest.approx(1.0, abs=1e-9)
    assert 0.1 < fast < 0.9


def test_kilometres_per_hour_are_a_unit_of_speed():
    chain = hc.Chain.from_materials(5e-3, "brass", beads=3, velocity="3.6 km/h")
    assert chain.velocities[0] == pytest.approx(1.0, rel=1e-15)

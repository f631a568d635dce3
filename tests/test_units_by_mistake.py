"""Numbers in a wrong unit, which are accepted with a warning, or rejected."""

import math
import warnings

import pytest

import hertzchain as hc

BALLS = hc.Chain.from_materials(5e-3, "steel-52100", beads=4, velocity=0.1)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: hc.Material("glass", density=2.5, young=69e9, poisson=0.2), "multiply by 1000"),
        (lambda: hc.Material("glass", density=2500, young=69, poisson=0.2), "and 1e9"),
        (
            lambda: BALLS.replace(velocities=None).struck_by(mass=5.0),
            "1,227 times the mass of the heaviest bead",
        ),
        (lambda: hc.simulate(BALLS, until=500, times=0), "check the unit"),
        (
            lambda: hc.Chain.from_materials(diameters=20, materials="brass", beads=3),
            "several beads have a diameter of 20 m; if millimetres are meant, write the diameter "
            "as '20 mm' or the radius as '10 mm', or divide by 1000",
        ),
        (
            lambda: hc.Chain.from_materials(diameters="10 nm", materials="brass", beads=3),
            "bead 1 has a diameter of 10 nm; .* adhere, which is not modelled: check the unit",
        ),
        (lambda: BALLS.replace(gravity=9810), "1000 times that of the earth; .* '9810 mm/s.2'"),
        (
            lambda: BALLS.replace(right_wall=hc.Wall(gap=1)),
            "the gap of the right wall is 1 m, but the beads are only 0.04 m long",
        ),
        (
            lambda: BALLS.replace(right_wall=hc.Wall(50, exponent=1)),
            "the stiffness of the right wall is 50, which without a unit is in N/m, softer than "
            "foam; .* '50 kN/mm' or '50 N/mm', otherwise '50 N/m'$",
        ),
        (
            lambda: BALLS.replace(left_wall=hc.Wall(50)),
            "the left wall is 50, .* in N/m.1.5, .* write '50 N/mm.1.5', otherwise '50 N/m.1.5'$",
        ),
        (lambda: hc.Pad(3), "the stiffness of the pad is 3, which without a unit is in N/m"),
        (
            lambda: BALLS.with_cap(5),
            "the cap has 1,227 times the mass of the heaviest ball, .* write mass='5 g', otherwise",
        ),
        (
            lambda: BALLS.with_cap("5 g", stiffness=2, exponent=1),
            "the stiffness of the contact of the cap is 2, which",
        ),
        (
            lambda: hc.chain_from_toml(
                '[chain]\ndiameters = "10 mm"\nmaterials = "brass"\nbeads = 5\ncap = {mass = 2}'
            ),
            "the cap has 448 times",
        ),
        # Two seconds instead of two milliseconds; the pulse needs 24 us per contact.
        (lambda: hc.simulate(BALLS, until=2, times=0), "until = 2 s is 2.* transits of a pulse"),
        (
            lambda: hc.Design(BALLS, minimise="velocity@4", vary=[hc.vary.radii(0.5, 1)]),
            "the radii vary from 0.5 m to 1 m; if millimetres are meant, write .1 mm.",
        ),
        (
            lambda: hc.Design(BALLS, minimise="velocity@4", vary=[hc.vary.radii(0.3, 0.6)]),
            "the radii vary from 0.3 m to 0.6 m; if millimetres are meant, write .0.6 mm.",
        ),
    ],
)
def test_numbers_of_improbable_size_get_a_warning(call, said):
    with pytest.warns(hc.InputWarning, match=said) as seen:
        call()
    assert [each.filename for each in seen] == [__file__]


@pytest.mark.parametrize(
    "call",
    [
        lambda: BALLS.replace(right_wall=hc.Wall("50 N/m", exponent=1)),
        lambda: BALLS.replace(right_wall=hc.Wall(5000, exponent=1)),
        lambda: BALLS.replace(right_wall=hc.Wall(1e6)),
        lambda: hc.Pad("3 N/m"),
        lambda: BALLS.with_cap("5 kg"),
        lambda: BALLS.with_cap(0.05),
        lambda: hc.Chain.uniform(3).replace(right_wall=hc.Wall(2.0)).with_cap(500.0),
    ],
)
def test_units_that_are_given_and_usual_numbers_get_no_warning(call):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        call()


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: BALLS.struck_by(velocity=-0.3), "towards the chain"),
        (lambda: hc.material("SS316"), "did you mean 'steel-316'"),
        (lambda: hc.Chain.periodic([1e-3, 2e-3, 3e-3], cells=3, materials=["brass", "ptfe"]),
         "the cell has 3 beads, but 2 materials"),
    ],
)  # fmt: skip
def test_impossible_values_are_rejected(call, said):
    with pytest.raises(hc.InputError, match=said):
        call()


def test_names_of_materials_may_have_capitals():
    assert hc.material("PTFE") is hc.material("ptfe")


def test_the_range_before_a_run_follows_the_pulse_to_the_wall():
    chain = hc.Chain.tapered(
        first_diameter="20 mm", last_diameter="5 mm", beads=40, material="steel-52100",
        velocity="0.02 m/s",
    ).replace(right_wall=hc.Wall())  # fmt: skip
    before = hc.hertz_range(chain).yield_ratio
    after = hc.hertz_range(chain, hc.simulate(chain, times=4000).largest_overlaps).yield_ratio
    assert before[0] == after[0] == 0.0
    # A binary collision is larger by up to 10%; several beads push against the wall.
    ratio = before[1:] / after[1:]
    assert ratio[:-1].min() > 0.99
    assert ratio[:-1].max() < 1.12
    assert 0.85 < ratio[-1] < 1.15


def test_a_hammer_may_be_much_heavier_than_small_balls():
    balls = hc.Chain.from_materials("1.5 mm", "brass", beads=3)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        hammer = balls.replace(velocities=None).struck_by(mass="200 g", velocity="0.1 m/s")
    assert hammer.masses[0] / hammer.masses[1] > 1500.0


@pytest.mark.parametrize(
    ("key", "ends"),
    [("diameters", "first_diameter and last_diameter"), ("radii", "first and last")],
)
def test_ranges_of_sizes_in_chain_files_name_the_keys_of_a_taper(tmp_path, key, ends):
    file = tmp_path / "chain.toml"
    file.write_text(f'[chain]\n{key} = "20 mm:8 mm"\nbeads = 5\nmaterials = "brass"\n')
    with pytest.raises(hc.InputError, match=f"'20 mm:8 mm' is a range; .*, give {ends}"):
        hc.load_chain(file)


def test_equal_balls_in_metres_are_named_once_and_the_odd_one_by_its_number():
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        row = hc.Chain.from_materials(diameters=12, materials="brass", beads=3)
        row.struck_by(mass="50 g", radius=math.inf, velocity="1 m/s").with_cap("40 g")
    said = {str(each.message) for each in warned if "a diameter of" in str(each.message)}
    assert len(said) == 1
    with pytest.warns(hc.InputWarning, match="bead 2 has a diameter of 12 m"):
        hc.Chain.from_materials(diameters=[0.01, 12], materials="brass")

"""Diameters of balls of a catalogue as a list or as a range."""

import re

import numpy as np
import pytest

import hertzchain as hc
from hertzchain import InputError
from hertzchain.designs.balls import load_balls

STEEL = "steel-52100"


def _sizes(**given):
    return {each.diameter for each in hc.vary.balls(materials=[STEEL], **given).balls}


@pytest.mark.parametrize(
    "text", ["4 mm to 16 mm", "4 to 16 mm", " 4mm to 1.6 cm ", "0.4 cm to 16 mm"]
)
def test_a_range_has_all_sizes_of_the_catalogue_within_it(text):
    known = {each.diameter for each in load_balls("bearing-balls") if each.material.name == STEEL}
    expected = {each for each in known if 3.99e-3 < each < 16.01e-3}
    assert {4e-3, 16e-3} < expected < known
    assert _sizes(diameters=text) == expected


@pytest.mark.parametrize("given", ["4 mm", {"min": "4 mm", "max": "8 mm"}, 4e-3, b"4 mm", "4-8 mm"])
def test_other_diameters_are_rejected_with_both_forms(given):
    with pytest.raises(InputError) as caught:
        hc.vary.balls(diameters=given)
    assert re.match(
        r"diameters must be a list such as \['4 mm', '6 mm'\], or a range such as '4 mm to 16 mm'; "
        r"got ",
        str(caught.value),
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("4.1 mm to 4.2 mm", "has no diameters from 4.1 mm to 4.2 mm; its balls have"),
        ("8 mm to 4 mm", "diameters = '8 mm to 4 mm' begins above its end"),
        ("4 mm to 8 N", "largest diameter of the range '4 mm to 8 N'"),
        ("4 to 8", "smallest diameter of the range '4 to 8'"),
    ],
)  # fmt: skip
def test_a_wrong_range_is_one_error(text, message):
    with pytest.raises(InputError, match=re.escape(message)):
        assert hc.vary.balls(materials=[STEEL], diameters=text).balls


def test_a_design_file_accepts_the_range(tmp_path):
    file = tmp_path / "row.toml"
    file.write_text(f"""[chain]
diameters = "10 mm"
beads = 4
materials = "{STEEL}"
velocity = "0.1 m/s"
right_wall = "same"
[design]
minimise = "wall_force.peak"
[[design.vary]]
balls = "bearing-balls"
materials = "{STEEL}"
diameters = "4 mm to 6 mm"
""")
    problem, _ = hc.load_design(file)
    sizes = sorted({each.diameter for each in problem.vary[0].balls})
    assert np.isclose(sizes[0], 4e-3)
    assert np.isclose(sizes[-1], 6e-3)
    assert len(sizes) > 3


def test_places_beyond_the_row_name_the_striker():
    row = hc.Chain.from_materials(diameters="10 mm", materials=STEEL, beads=10)
    struck = row.struck_by(mass="50 g", radius="flat", velocity="0.1 m/s").replace(
        right_wall=hc.Wall()
    )
    balls = hc.vary.balls(materials=[STEEL], diameters="4 mm to 6 mm", beads="2:14")
    with pytest.raises(InputError) as caught:
        hc.Design(struck, minimise="wall_force.peak", vary=[balls])
    assert (
        "beads = '2:14' is outside 1 to 11; bead 1 is the striker, and the balls are beads 2 to "
        "11, or 'ball 1:'" in str(caught.value)
    )
    named = hc.vary.balls(materials=[STEEL], diameters="4 mm to 6 mm", beads="ball 1:")
    assert len(named.space(struck).places) == 10

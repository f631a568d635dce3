"""Messages that state what to write instead."""

import pytest

import hertzchain as hc

ROW = """
[chain]
diameters = {diameters}
materials = "steel-52100"
beads = 3
{table}
mass = "50 g"
{striker}
"""


def row(striker, table="[[chain.struck_by]]", diameters='"8 mm"'):
    return ROW.format(diameters=diameters, table=table, striker=striker)


@pytest.mark.parametrize("table", ["[[chain.struck_by]]", "[chain.struck_by]"])
@pytest.mark.parametrize("flat", ["flat = true", 'radius = "flat"', "radius = inf"])
def test_a_flat_striker_has_three_spellings(flat, table):
    text = row(flat, table)
    assert hc.chain_from_toml(text).striker_properties[0].flat
    assert hc.chain_from_toml(text) == hc.chain_from_toml(row("radius = inf"))
    ball = hc.chain_from_toml(row("flat = false", table))
    assert not any(each.flat for each in ball.striker_properties)


@pytest.mark.parametrize(
    ("striker", "hint"),
    [
        ('flat = "yes"', 'for a flat face, write radius = "flat"'),
        ('flat = true\nradius = "5 mm"', "has flat = true and radius: omit one of them"),
        ('radius = "Inf"', "got 'Inf'; write inf without quotation marks"),
    ],
)
def test_mistakes_about_flat_strikers_are_explained(striker, hint, tmp_path):
    path = tmp_path / "chain.toml"
    path.write_text(row(striker))
    with pytest.raises(hc.InputError, match=hint):
        hc.load_chain(path)
    path.write_text(row("radius = inf"))
    assert hc.load_chain(path).striker_properties[0].flat


def test_an_empty_list_of_diameters_is_named_as_it_is_written(tmp_path):
    path = tmp_path / "chain.toml"
    path.write_text(row("radius = inf", diameters="[]"))
    with pytest.raises(hc.InputError, match="diameters .*must have at least one number"):
        hc.load_chain(path)


@pytest.mark.parametrize("name", ["steel-4140", "Steel 4140"])
def test_steels_that_are_not_in_the_catalogue_are_answered_with_its_steels(name):
    kinds = "did you mean 'steel-52100', 'steel-304', 'steel-316' or 'steel-440c'[?]"
    with pytest.raises(hc.InputError, match=kinds):
        hc.material(name)


def test_a_peak_force_without_a_bead_may_be_that_on_a_wall():
    chain = hc.Chain.uniform(9).replace(right_wall=hc.Wall())
    with pytest.raises(
        hc.InputError, match=r"peak_force@last; that on a wall is wall_force\.peak$"
    ):
        hc.Design(chain, minimise="peak_force", vary=[hc.vary.radii(0.5, 1.0)])

"""Short forms of the beads in chain files."""

import hertzchain as hc


def test_equal_balls_of_two_materials_have_one_diameter(tmp_path):
    kinds = ["steel-52100"] * 4 + ["brass"] * 3
    chain = hc.Chain.from_materials(diameters="12 mm", materials=kinds).struck_by(velocity=0.1)
    text = hc.chain_as_toml(chain)
    assert 'diameters = "12 mm"\n' in text
    assert "taper" not in text
    path = tmp_path / "row.toml"
    path.write_text(text, "utf-8")
    assert hc.load_chain(path) == chain

"""Chain files of tapers with a rate and the size of the first bead, as in `Chain.tapered`."""

import numpy as np
import pytest

import hertzchain as hc

MATERIAL = 'material = "steel-316"\nbeads = 25\n'


def loaded(tmp_path, text):
    path = tmp_path / "chain.toml"
    path.write_text(f"[chain]\n{text}")
    return hc.load_chain(path)


@pytest.mark.parametrize("size", ["first", "first_diameter"])
@pytest.mark.parametrize("taper", ["forward-exponential", "backward-linear"])
def test_a_rate_and_a_first_size_make_the_chain_of_python(tmp_path, size, taper):
    found = loaded(tmp_path, f'taper = "{taper}"\nrate = 0.0389\n{size} = "20 mm"\n{MATERIAL}')
    expected = hc.Chain.tapered(taper, 0.0389, beads=25, material="steel-316", **{size: "20 mm"})
    np.testing.assert_array_equal(found.radii, expected.radii)
    assert found.description == expected.description


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (f'taper = "forward-linear"\nrate = 0.01\nfirst = 1.0\nlast = 0.5\n{MATERIAL}', "give one"),
        (f"rate = 0.01\nfirst = 1.0\n{MATERIAL}", "needs a taper and its rate"),
        ('taper = "forward-linear"\nrate = 0.01\nfirst = 2.0\nbeads = 9\n', "omit its size"),
        (f'taper = "forward-linear"\nfirst = 2.0\n{MATERIAL}', "requires rate; give rate"),
    ],
)
def test_sizes_and_rates_that_contradict_each_other_are_rejected(tmp_path, text, said):
    with pytest.raises(hc.InputError, match=said):
        loaded(tmp_path, text)


def test_the_chain_of_a_written_file_is_the_same(tmp_path):
    chain = hc.Chain.tapered(
        "forward-exponential", 0.0389, first_diameter="20 mm", material="steel-316", beads=25
    )
    path = tmp_path / "chain.toml"
    path.write_text(hc.chain_as_toml(chain), "utf-8")
    again = hc.load_chain(path)
    np.testing.assert_array_equal(again.radii, chain.radii)
    np.testing.assert_array_equal(again.masses, chain.masses)
    assert again.description == chain.description

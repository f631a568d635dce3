"""Tables of spectra, comparisons and gradients."""

import re
from pathlib import Path

import numpy as np
import pytest

import hertzchain as hc

HELD = hc.Chain.uniform(40).replace(precompression=1.0, held_by="force")


@pytest.fixture(scope="module")
def odd():
    balls = hc.Chain.from_materials(5e-3, "steel-52100", beads=40)
    return hc.spectrum(
        balls.with_defects({20: 2.5e-3}).replace(precompression=10.0, held_by="force")
    )


def test_modes_have_a_table_and_shapes(odd):
    table, dataset = odd.to_dataframe(), odd.to_xarray()
    assert table.index[table.localised].tolist() == odd.localised.tolist() == [40]
    assert table.attrs["units"]["frequency"] == dataset.frequency.units == "Hz"
    # Stiffness times a shape is the squared angular frequency times the masses.
    springs, shape = odd.contacts.springs[1:-1], dataset["shape"].sel(mode=40).to_numpy()
    forces = springs * np.diff(shape)
    pull = np.append(0.0, forces) - np.append(forces, 0.0)
    omega = 2.0 * np.pi * table.frequency[40]
    np.testing.assert_allclose(pull, omega**2 * odd.chain.masses * shape, atol=1e-9 * pull.max())


def test_scaled_modes_have_no_units():
    assert set(hc.spectrum(HELD).to_dataframe().attrs["units"].values()) == {""}


def test_errors_of_pulses_have_a_table():
    chain = hc.Chain.uniform(9)
    theory, exact = hc.bca(chain), hc.propagate(chain)
    table = theory.compare(exact).to_dataframe()
    assert table.velocity[5] == pytest.approx(theory.velocity[4] / exact.velocity[4] - 1.0)
    assert np.isnan(table.residence).tolist() == [False] * 8 + [True]


def test_derivatives_of_beads_contacts_and_walls_have_a_table():
    chain = hc.Chain.uniform(5).replace(right_wall=hc.Wall(stiffness=2.0))
    found = hc.gradient(chain, "wall_force.peak", to=["radii", "gaps", "right_wall.stiffness"])
    table = found.to_dataframe()
    assert table.parameter.value_counts().to_dict() == {
        "radii": 5, "gaps": 4, "right_wall.stiffness": 1,
    }  # fmt: skip
    radii = table[table.parameter == "radii"]
    assert radii.number.tolist() == [1, 2, 3, 4, 5]
    assert radii.derivative.tolist() == found["radii"].tolist()
    wall = table[table.parameter == "right_wall.stiffness"]
    assert wall.number.isna().all()
    assert wall.value.tolist() == [2.0]
    # In percent per 1%: by differences of simulations with other radii.
    for k in (1, 5):
        more, less = (
            hc.simulate(chain.with_defects({k: 1.0 + step})).wall_force().peak
            for step in (1e-3, -1e-3)
        )
        relative = np.log(more / less) / np.log(1.001 / 0.999)
        assert radii.relative.iloc[k - 1] == pytest.approx(relative, rel=0.02)
    assert wall.relative.tolist() == [float(found.relative("right_wall.stiffness"))]


def test_numbers_of_hertz_range_have_a_table():
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=4, velocity=0.3)
    found = hc.hertz_range(chain.replace(right_wall=hc.Wall(stiffness=2.5e7, exponent=1)))
    table = found.to_dataframe()
    assert table.index.tolist() == [0, 1, 2, 3, 4]
    assert table.yield_ratio.iloc[1] == found.yield_ratio[1]
    assert table.columns[0] == "overlap_ratio"


def test_derivatives_have_a_labelled_dataset():
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=5, right_wall=hc.Wall(stiffness=1e9))
    names = ["radii", "gaps", "stiffness", "velocities", "young", "right_wall.stiffness"]
    chain = chain.replace(velocities=0.01 * chain.velocities)
    found = hc.gradient(chain, "wall_force.peak", to=names)
    dataset = found.to_xarray()
    # The table of the same derivatives labels beads and contacts on its own.
    for name, rows in found.to_dataframe().groupby("parameter"):
        values = dataset[name]
        dimension = {5: ("bead",), 4: ("contact",), 1: ()}[len(rows)]
        assert values.dims == dimension
        assert np.atleast_1d(values).tolist() == rows.derivative.tolist()
        if dimension:
            assert dataset[dimension[0]].to_numpy().tolist() == rows.number.tolist()
        assert values.units == rows.unit.iloc[0] == found.units[name]
    assert dataset.attrs == {"quantity": "wall_force.peak", "value": found.value, "unit": "N"}
    scaled = hc.gradient(hc.Chain.uniform(3), "pulse.velocity@3", to="radii").to_xarray()
    assert "units" not in scaled.radii.attrs


def test_tables_of_many_chains_have_a_row_for_each_bead_and_each_value():
    chains = [hc.Chain.uniform(4), hc.Chain.tapered("forward-linear", 0.05, beads=6)]
    table = hc.propagate_many(chains).to_dataframe()
    for row, chain in enumerate(chains):
        expected = hc.propagate(chain)
        np.testing.assert_allclose(table.velocity.loc[row], expected.velocity, rtol=1e-8)
        assert table.loc[row].index.tolist() == [*range(1, chain.beads + 1)]
    balls = hc.Chain.from_materials(5e-3, "brass", beads=5, velocity=1e-3, right_wall=hc.Wall())
    scatter = hc.Scatter(radius=0.01, samples=20)
    found = hc.distribution(balls, "wall_force.peak", scatter)
    rows = found.to_dataframe()
    assert rows["wall_force.peak"].tolist() == found.values.tolist()
    assert rows.attrs["units"] == {"wall_force.peak": "N"}


METHODS = ("to_dataframe", "to_xarray")


def test_the_page_lists_the_tables_of_all_results():
    page = Path(__file__).parent.parent.joinpath("docs/how-to/notebooks.md").read_text("utf-8")
    listed = {
        first.strip("`() "): set(re.findall(r"`(\w+)`", names))
        for first, names in re.findall(r"^\| (.+?) \| (.+) \|$", page, re.MULTILINE)
    }
    # Results are the public classes with a view in notebooks.
    results = {
        name: kind for name in dir(hc)
        if isinstance(kind := getattr(hc, name), type) and hasattr(kind, "_repr_html_")
    }  # fmt: skip
    for method in METHODS:
        assert listed[method] == {n for n, kind in results.items() if hasattr(kind, method)}
    without = {n for n, kind in results.items() if not any(hasattr(kind, m) for m in METHODS)}
    assert listed["attributes only"] == without


@pytest.mark.parametrize("name", ["sound_speed"])
def test_properties_that_a_chain_does_not_have_are_missing(odd, name):
    assert not hasattr(odd, name)
    assert getattr(odd, name, None) is None
    with pytest.raises(hc.InputError, match="do not repeat|does not repeat|repeat"):
        getattr(odd, name)
    assert hasattr(hc.spectrum(HELD), name)


def test_hosts_that_a_chain_does_not_have_are_missing():
    taper = hc.Chain.tapered("forward-exponential", 0.05, beads=20)
    found = hc.spectrum(taper.replace(precompression=1.0, held_by="force"))
    for name in ("host_edges", "host_sound_speed"):
        assert not hasattr(found, name)
        with pytest.raises(hc.InputError, match="has no host"):
            getattr(found, name)


def test_warnings_about_yield_name_their_method():
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=20, velocity=0.6)
    for method, name in ((hc.propagate, "propagation"), (hc.bca, "BCA")):
        with pytest.warns(hc.ModelRangeWarning, match=f"^{name}: pressure / yield is 1"):
            method(chain)


def test_the_taper_of_alternating_beads_is_named():
    for chain, said in (
        ({"taper": "dimer", "beads": 9}, "alternating beads have no taper but mass_ratio"),
        ({"mass_ratio": 0.5, "beads": 9, "materials": "brass"}, "describes a scaled chain"),
    ):
        with pytest.raises(hc.InputError, match=said):
            hc.sweep({"chain": chain, "axes": {"beads": [9, 11]}})

"""Modes of odd beads in a periodic host."""

import json

import numpy as np
import pytest
from scipy.linalg import eigh

import hertzchain as hc

STEEL = hc.Chain.from_materials(diameters="19.05 mm", materials="steel-52100", beads=41)
HELD = STEEL.replace(precompression="1 N", held_by="force")
ODD = STEEL.with_defects(diameters={21: "10 mm"}).replace(precompression="1 N", held_by="force")


@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_a_light_mass_between_equal_springs_has_the_known_frequency(share):
    masses = np.ones(101)
    masses[50] = share
    row = hc.Chain.from_radii(np.ones(101), masses=masses, stiffness=np.ones(100))
    found = hc.spectrum(row.replace(precompression=1.0, held_by="force"))
    # K = 3/2: the band ends at 4 K / m = 6.
    np.testing.assert_allclose(found.host_edges, [[0.0, 6.0**0.5 / (2 * np.pi)]])
    (mode,) = found.localised
    expected = 6.0 / (share * (2.0 - share))
    assert (2 * np.pi * found.frequencies[mode - 1]) ** 2 == pytest.approx(expected, rel=1e-9)
    # The amplitude decays by the factor -x / (2 - x) per bead: energies 1, r^2, r^4, ...
    r = (share / (2.0 - share)) ** 2
    energy, squares = share + 2 * r / (1 - r), share**2 + 2 * r**2 / (1 - r**2)
    assert found.participation[mode - 1] == pytest.approx(energy**2 / squares, rel=1e-9)


def test_a_heavy_mass_has_no_localised_mode():
    masses = np.ones(101)
    masses[50] = 3.0
    row = hc.Chain.from_radii(np.ones(101), masses=masses, stiffness=np.ones(100))
    assert hc.spectrum(row.replace(precompression=1.0, held_by="force")).localised.size == 0


def test_a_small_ball_agrees_with_a_direct_eigenvalue_solution():
    radii = np.full(41, 19.05e-3 / 2)
    radii[20] = 5e-3
    steel = ODD.materials[0]
    masses = steel.density * 4 / 3 * np.pi * radii**3
    reduced = radii[1:] * radii[:-1] / (radii[1:] + radii[:-1])
    stiffness = 4 / 3 * steel.young / 2 / (1 - steel.poisson**2) * np.sqrt(reduced)
    springs = 1.5 * stiffness ** (2 / 3)
    matrix = np.diag(np.append(0, springs) + np.append(springs, 0))
    matrix -= np.diag(springs, 1) + np.diag(springs, -1)
    squared = eigh(matrix, np.diag(masses), eigvals_only=True)
    found = hc.spectrum(ODD)
    (mode,) = found.localised
    assert mode == 41
    assert found.frequencies[mode - 1] == pytest.approx(squared[-1] ** 0.5 / (2 * np.pi), rel=1e-9)
    np.testing.assert_allclose(found.host_edges, hc.spectrum(HELD).band_edges(), rtol=1e-9)
    assert "around bead 21 " in repr(found)


def test_hosts_of_two_beads_and_chains_without_host():
    pair = hc.Chain.periodic([9.5e-3] * 2, cells=20, materials=["aluminium", "steel-316"])
    crystal = pair.replace(precompression=0.2, held_by="force")
    found = hc.spectrum(crystal)
    np.testing.assert_allclose(found.host_edges, found.band_edges())
    low, high = found.gaps()[0]
    (mode,) = found.localised  # at the light bead at the free end
    assert low < found.frequencies[mode - 1] < high
    odd = hc.spectrum(crystal.with_defects({20: 5e-3}))
    np.testing.assert_allclose(odd.host_edges, found.band_edges())
    assert len(odd.localised) > 1
    scattered = hc.spectrum(HELD.with_scatter(relative="1%", seed=1))
    assert scattered.localised.size == 0
    with pytest.raises(hc.InputError, match="do not repeat a cell of up to 4 beads"):
        _ = scattered.host_edges


@pytest.mark.parametrize("beads", [4, 5, 6, 8, 12])
def test_columns_under_gravity_have_no_host(beads):
    column = hc.Chain.uniform(beads).replace(gravity=0.1, right_wall=hc.Wall(stiffness=1.0))
    assert hc.spectrum(column).localised.size == 0


def test_a_contact_of_another_stiffness_has_a_host():
    stiffness = np.ones(39)
    stiffness[19] = 4.0
    row = hc.Chain.from_radii(np.ones(40), masses=np.ones(40), stiffness=stiffness)
    found = hc.spectrum(row.replace(precompression=1.0, held_by="force"))
    np.testing.assert_allclose(found.host_edges, [[0.0, 6.0**0.5 / (2 * np.pi)]])
    assert list(found.localised) == [40]


@pytest.mark.parametrize("time", [0.0, 0.1, 0.3])
def test_damped_modes_of_a_band_are_not_localised(time):
    row = hc.Chain(
        np.ones(40), masses=np.resize([1.0, 0.34], 40), velocities=np.zeros(40),
        precompression=1.0, held_by="force", left_wall=hc.Wall(stiffness=1.0),
        loss=hc.Viscoelastic(time) if time else None,
    )  # fmt: skip
    found = hc.spectrum(row)
    # Dampers lower the frequencies of the optical band into the gap.
    assert (found.frequencies[22] < found.band_edges()[1, 0]) == (time > 0.0)
    assert list(found.localised) == [21]


def test_localised_modes_are_marked_in_plots():
    axes = hc.spectrum(ODD).plot()
    labels = axes.get_legend_handles_labels()[1]
    assert labels == ["localised mode", "no plane waves"]
    edge = hc.spectrum(HELD).band_edges()[0, 1]
    assert axes.patches[0].get_y() == pytest.approx(1e-3 * edge)


def test_the_command_names_localised_modes(tmp_path, run):
    path = tmp_path / "odd.toml"
    path.write_text(
        "[chain]\nfirst_diameter = '19.05 mm'\nlast_diameter = '19.05 mm'\nbeads = 41\n"
        "materials = 'steel-52100'\nprecompression = '1 N'\nheld_by = 'force'\n"
        "[[chain.with_defects]]\nbead = 21\ndiameter = '10 mm'\n"
    )
    out = run("spectrum", path)[1]
    mode = hc.spectrum(ODD).frequencies[-1]
    assert f"localised    {1e-3 * mode:.5g} kHz, mode 41, around bead 21, participation 1.1" in out
    assert out.endswith("  shapes       --modes 41 --plot FILE\n")
    assert "host band 1  0 to " in out
    assert "no bands" not in out
    document = json.loads(run("spectrum", path, "--json")[1])
    (found,) = document["localised_modes"]
    assert (found["mode"], found["frequency"]) == (41, pytest.approx(mode))
    # The light bead.
    assert found["bead"] == 21
    assert document["host_bands"][0][0] == 0.0

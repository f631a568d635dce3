"""Figures of the shapes of modes."""

import numpy as np
import pytest
from figure_texts import legend_texts

import hertzchain as hc

STEEL = hc.Chain.from_materials(diameters="19.05 mm", materials="steel-52100", beads=41)
EQUAL = STEEL.replace(precompression="20 N", held_by="force")
ODD = STEEL.with_defects(diameters={21: "10 mm"}).replace(precompression="20 N", held_by="force")


def modes_of_a_matrix(radii, material, force):
    """Frequencies and displacements from the matrix of Hertz springs under a force."""
    masses = material.density * 4 / 3 * np.pi * radii**3
    reduced = radii[1:] * radii[:-1] / (radii[1:] + radii[:-1])
    stiffness = 4 / 3 * material.young / 2 / (1 - material.poisson**2) * np.sqrt(reduced)
    springs = 1.5 * stiffness ** (2 / 3) * force ** (1 / 3)
    matrix = np.diag(np.append(0, springs) + np.append(springs, 0))
    matrix -= np.diag(springs, 1) + np.diag(springs, -1)
    squared, vectors = np.linalg.eigh(matrix / np.sqrt(np.outer(masses, masses)))
    shapes = vectors / np.sqrt(masses)[:, None]
    return np.sqrt(np.abs(squared)) / (2 * np.pi), shapes / np.abs(shapes).max(axis=0)


def shapes_of(axes):
    return {str(line.get_label()): line.get_ydata() for line in axes.lines[1:]}


@pytest.mark.parametrize("modes", [None, [2, 5, 41]])
def test_shapes_are_those_of_the_dynamical_matrix(modes):
    radii = np.full(41, 19.05e-3 / 2)
    radii[20] = 5e-3
    frequencies, shapes = modes_of_a_matrix(radii, ODD.materials[0], 20.0)
    drawn = shapes_of(hc.spectrum(ODD).plot_modes(modes))
    assert len(drawn) == len(modes or [41])
    for number, (label, values) in zip(modes or [41], drawn.items(), strict=True):
        expected = shapes[:, number - 1]
        assert np.abs(values).max() == pytest.approx(1.0)
        sign = np.sign(values @ expected)
        np.testing.assert_allclose(values, sign * expected, atol=1e-8)
        local = "localised " if number == 41 else ""
        place = ", around bead 21" if number == 41 else ""
        frequency = 1e-3 * frequencies[number - 1]
        assert label == f"{local}mode {number}, {frequency:.4g} kHz{place}"
    (light,) = [values for label, values in drawn.items() if "localised" in label]
    assert light[20] == 1.0


def test_the_axes_state_the_chain_the_band_and_the_normalisation():
    axes = hc.spectrum(ODD).plot_modes()
    edge = 1e-3 * hc.spectrum(EQUAL).band_edges()[0, 1]
    title = axes.get_title().replace("\n", " ")
    assert title == (
        f"41 steel balls, 19.05 mm, except ball 21 (10 mm), under 20 N, "
        f"band of the host: 0 to {edge:.4g} kHz"
    )
    assert axes.get_xlabel() == "bead $k$"
    assert r"\max|x|" in axes.get_ylabel()
    np.testing.assert_array_equal(axes.lines[1].get_xdata(), np.arange(1, 42))


def test_the_first_three_modes_of_a_chain_without_localised_ones():
    labels = list(shapes_of(hc.spectrum(EQUAL).plot_modes()))
    assert [label.split(",")[0] for label in labels] == ["mode 1", "mode 2", "mode 3"]
    assert list(shapes_of(hc.spectrum(EQUAL).plot_modes(2))) == [labels[1]]


def test_modes_of_a_lossy_chain_are_drawn_at_the_maximum_of_a_bead():
    # Equal losses of all contacts would leave the modes real.
    found = hc.spectrum(ODD.replace(loss=[hc.Viscoelastic("3 us")] * 10 + [None] * 30))
    (values,) = shapes_of(found.plot_modes([30])).values()
    shape = found.modes[:, 29]
    assert np.abs(shape.imag).max() > 1e-3 * np.abs(shape).max()
    leader = np.argmax(ODD.masses * np.abs(shape) ** 2)
    phase = np.exp(-1j * np.angle(shape[leader]))
    np.testing.assert_allclose(values, (phase * shape).real / np.abs(shape).max(), atol=1e-12)


def test_an_overdamped_mode_has_no_frequency():
    held = hc.Chain.uniform(4).replace(
        precompression=1.0, left_wall=hc.Wall(), right_wall=hc.Wall(), loss=hc.Viscoelastic(5.0)
    )
    assert list(shapes_of(hc.spectrum(held).plot_modes(1))) == ["mode 1, overdamped"]


def test_modes_of_two_chains_in_the_same_axes_name_what_differs():
    light = STEEL.with_defects(diameters={21: "8 mm"})
    other = light.replace(precompression="20 N", held_by="force")
    axes = hc.spectrum(ODD).plot_modes()
    hc.spectrum(other).plot_modes(ax=axes)
    first, second = legend_texts(axes)
    assert first.endswith("kHz, around bead 21, except ball 21 (10 mm)")
    assert second.endswith("kHz, around bead 21, except ball 21 (8 mm)")
    assert axes.get_title() == "41 steel balls, 19.05 mm, under 20 N"
    assert len({line.get_color() for line in axes.lines[1:]}) == 2


@pytest.mark.parametrize(
    ("modes", "message"),
    [
        ([], "at least one number"),
        ([42], "a mode must be a whole number from 1 to 41, got 42"),
        ([0], "from 1 to 41, got 0"),
        (["first"], "whole number from 1 to 41, got 'first'"),
        ("1", "list of numbers of modes, got '1'"),
    ],
)
def test_modes_that_do_not_exist_are_reported(modes, message):
    with pytest.raises(hc.InputError, match=message):
        hc.spectrum(ODD).plot_modes(modes)


def test_localised_modes_are_numbers_that_plots_accept():
    found = hc.spectrum(ODD)
    assert list(shapes_of(found.plot_modes(found.localised))) == list(shapes_of(found.plot_modes()))


def test_representations_name_the_figure_of_localised_modes():
    found = hc.spectrum(ODD)
    assert "localised at 15093.3 Hz around bead 21 (plot_modes)" in " ".join(repr(found).split())
    assert "plot_modes() shows the shapes" in found._repr_html_()
    assert "plot_modes" not in hc.spectrum(EQUAL)._repr_html_() + repr(hc.spectrum(EQUAL))


OPTIONS = ["--material", "steel-52100", "--diameter", "10 mm", "--beads", 9,
           "--precompression", "20 N"]  # fmt: skip


def test_the_command_plots_modes(tmp_path, run, monkeypatch):
    drawn = []
    original = hc.Spectrum.plot_modes
    monkeypatch.setattr(hc.Spectrum, "plot_modes", lambda *a, **k: drawn.append(original(*a, **k))
                        or drawn[-1])  # fmt: skip
    path = tmp_path / "modes.png"
    assert run("spectrum", *OPTIONS, "--modes", "1, 3", "--plot", path)[0] == 0
    assert path.read_bytes().startswith(b"\x89PNG")
    assert [label.split(",")[0] for label in shapes_of(drawn[0])] == ["mode 1", "mode 3"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--modes", "1"], "--modes requires --plot FILE"),
        (["--modes", "x", "--plot", "a.png"], "--modes must look like 1,2, got 'x'"),
        (["--modes", "10", "--plot", "a.png"], "from 1 to 9, got 10"),
        (["--modes", "1", "--transfer", 2, "--plot", "a.png"], "give one of them"),
    ],
)
def test_the_command_reports_wrong_modes(tmp_path, run, monkeypatch, options, message):
    monkeypatch.chdir(tmp_path)
    code, _, err = run("spectrum", *OPTIONS, *options)
    assert (code, message in err) == (2, True), err

"""Labels of several transfer functions in the same axes, and of differences from long names."""

import numpy as np
import pytest
from figure_texts import legend_texts

import hertzchain as hc

CRYSTAL = hc.Chain.periodic(
    ["9.53 mm"] * 2, cells=10, materials=["silicon-nitride", "steel-52100"]
).replace(precompression="20 N", held_by="force", loss=hc.Viscoelastic("3 us"))


def test_transfer_functions_name_the_property_in_which_chains_differ():
    axes = hc.spectrum(CRYSTAL).plot_transfer(16)
    assert legend_texts(axes) == ["no plane waves"]
    hc.spectrum(CRYSTAL.replace(precompression="60 N")).plot_transfer(16, ax=axes)
    assert legend_texts(axes) == ["precompression 20 N", "precompression 60 N", "no plane waves"]
    assert "under" not in axes.get_title()
    assert "force on bead 1" in axes.get_title()


def test_contacts_and_drives_that_differ_are_named():
    found = hc.spectrum(CRYSTAL)
    axes = found.plot_transfer(16)
    found.plot_transfer(8, ax=axes)
    assert legend_texts(axes)[:2] == ["contact 16", "contact 8"]
    assert axes.get_ylabel() == "contact force\nper force on bead 1"
    axes = found.plot_transfer(16)
    found.plot_transfer(16, at=5, ax=axes)
    assert legend_texts(axes)[:2] == ["force on bead 1", "force on bead 5"]
    assert axes.get_ylabel() == "force in contact 16\nper force"
    assert "bead" not in axes.get_title()
    found.plot_transfer(16, drive="displacement", ax=axes)
    assert legend_texts(axes)[2] == "displacement of bead 1"
    assert axes.get_ylabel().endswith("per force or displacement [1 or N/m]")


def test_a_label_of_a_user_remains():
    axes = hc.spectrum(CRYSTAL).plot_transfer(16)
    axes.lines[0].set_label("mine")
    hc.spectrum(CRYSTAL.replace(loss=None)).plot_transfer(16, ax=axes)
    assert legend_texts(axes)[:2] == ["mine", "no loss"]


def test_only_frequencies_that_no_chain_transmits_are_shaded():
    chains = CRYSTAL, CRYSTAL.replace(precompression="60 N")
    axes = hc.spectrum(chains[0]).plot_transfer(16)
    hc.spectrum(chains[1]).plot_transfer(16, ax=axes)
    shaded = [(patch.get_x(), patch.get_x() + patch.get_width()) for patch in axes.patches]
    bands = [1e-3 * hc.spectrum(chain).band_edges() for chain in chains]
    for f in np.linspace(0.01, axes.get_xlim()[1] - 0.01, 301):
        transmitted = any(low < f < high for edges in bands for low, high in edges)
        assert transmitted != any(low < f < high for low, high in shaded)


def pulses(*losses):
    balls = hc.Chain.from_materials(diameters="10 mm", materials="steel-52100", beads=12,
                                    velocity="0.02 m/s")  # fmt: skip
    return [hc.simulate(balls.replace(loss=loss), times=0).pulse() for loss in losses]


def test_a_name_of_two_lines_is_that_of_the_differences():
    axes = hc.plot_pulses(pulses(hc.Viscoelastic("1 us"), None), residuals=True)
    lower = axes.figure.axes[1]
    assert lower.get_ylabel() == "difference from\nviscoelastic\n1 µs [%]"


@pytest.mark.parametrize("width", ["single column", None])
def test_a_long_name_is_marked_in_a_legend_that_is_inside_the_figure(width):
    balls = hc.Chain.from_materials(diameters="10 mm", materials="steel-52100", beads=12,
                                    velocity="0.02 m/s")  # fmt: skip
    chains = [
        balls.replace(right_wall=hc.Wall.of("brass"), loss=hc.Viscoelastic("1 us")),
        hc.Chain.from_materials(diameters="12 mm", materials="glass", beads=15)
        .struck_by(velocity="0.03 m/s", material="steel-52100", diameter="14 mm")
        .replace(right_wall=hc.Wall(), loss=hc.Restitution(0.9)),
    ]
    shown = [hc.simulate(chain, times=0, until="1 ms").pulse() for chain in chains]
    with hc.figure_style(width):
        axes = hc.plot_pulses(shown, residuals=True)
        figure = axes.figure
        figure.draw_without_rendering()
    first, second = (text.replace("\n", " ") for text in legend_texts(axes))
    assert first.endswith("(the first curve)")
    assert "first" not in second
    assert figure.axes[1].get_ylabel().replace("\n", " ") == "difference from the first curve [%]"
    box = axes.get_legend().get_window_extent()
    assert box.x0 >= figure.bbox.x0
    assert box.x1 <= figure.bbox.x1
    # The legend leaves the axes their width.
    assert axes.bbox.width > 0.6 * figure.bbox.width


def test_first_curves_of_different_methods():
    chains = [hc.Chain.tapered("backward-exponential", q, beads=20) for q in (0.01, 0.03)]
    found = [hc.propagate(chains[0]), hc.bca(chains[1]), hc.bca(chains[0]), hc.propagate(chains[1])]
    lower = hc.plot_pulses(found, residuals=True).figure.axes[1]
    label = lower.get_ylabel().replace("\n", " ")
    assert label == "difference from the first curve of each chain [%]"

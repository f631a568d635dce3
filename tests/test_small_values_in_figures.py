"""Axes of small values: changes of a static force, prefixes, and panels of small differences."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

import hertzchain as hc


def shaken(speed, unit=True, **held):
    """A row under a static force whose bead 5 moves."""
    row = hc.Chain.from_materials(5e-3, "steel-52100", beads=9) if unit else hc.Chain.uniform(9)
    row = row.replace(**{"precompression": 20.0, "held_by": "force", **held})
    return hc.simulate(row.replace(velocities=speed * np.eye(9)[4]), until=1e-4 if unit else 20.0)


def tick_labels(axis):
    axis.axes.figure.draw_without_rendering()
    return [label.get_text() for label in axis.get_ticklabels()], axis.get_offset_text().get_text()


WALLS = {"right_wall": hc.Wall(), "left_wall": hc.Wall(), "held_by": "walls"}


@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
@pytest.mark.parametrize(("bead", "walls"), [(5, {}), (3, {}), ("right wall", WALLS)])
def test_small_changes_of_a_static_force_are_shown_alone(bead, walls):
    run = shaken(1e-4, **walls)
    axes = run.plot_forces([bead])
    assert axes.get_ylabel().startswith("force \N{MINUS SIGN} static force of 20 N [")
    texts, offset = tick_labels(axes.yaxis)
    assert offset == ""
    factor = {"nN": 1e9, "µN": 1e6, "mN": 1e3, "N": 1.0}[axes.get_ylabel().rpartition("[")[2][:-1]]
    shown = [float(text.replace("\N{MINUS SIGN}", "-")) for text in texts]
    np.testing.assert_allclose(shown, factor * (axes.get_yticks() - 20.0), atol=1e-6 * max(shown))


def test_large_changes_of_a_static_force_are_not():
    assert shaken(0.2).plot_forces([5]).get_ylabel() == "force [N]"
    axes = shaken(1e-4).plot_forces([3])
    shaken(0.2).plot_forces([3], ax=axes)
    assert axes.get_ylabel() == "force [N]"


def test_small_changes_of_scaled_forces_have_a_power_of_ten():
    label = shaken(1e-5, unit=False).plot_forces([3]).get_ylabel()
    assert label.startswith("(force \N{MINUS SIGN} static force of 20) / $10^{-")


def test_a_map_of_small_changes_is_relative_to_the_static_force():
    run = shaken(1e-4)
    axes = run.plot("force")
    assert axes.get_xlim()[1] == pytest.approx(100.0, rel=0.01)
    assert axes.figure.axes[1].get_ylabel().startswith("force \N{MINUS SIGN} static force of 20 N")
    (mesh,) = axes.collections
    change = run.forces[:, 1:-1] - 20.0
    low, high = mesh.get_clim()
    assert max(-low, high) in (
        pytest.approx(np.abs(change).max() * k) for k in (1.0, 1e3, 1e6, 1e9)
    )


@pytest.mark.parametrize("log", [False, True])
def test_small_energies_have_a_prefix_on_each_scale(log):
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=20, velocity=0.01)
    pulse = hc.propagate(chain)
    axes = pulse.plot("energy", log=log)
    assert axes.get_ylabel() == "kinetic energy $E_k$ [nJ]"
    texts, _ = tick_labels(axes.yaxis)
    shown = [float(text) for text in texts if text]
    assert min(shown) < 1e9 * pulse.energy[0] < 2.0 * max(shown)


def test_the_colour_bar_of_slow_beads_has_a_prefix():
    assert shaken(1e-4).plot().figure.axes[1].get_ylabel() == "velocity [µm/s]"


@pytest.mark.parametrize("width", [None, "single column"])
def test_the_label_of_residuals_is_not_longer_than_its_panel(width):
    chain = hc.Chain.tapered(first_diameter="20 mm", last_diameter="5 mm", beads=40,
                             material="steel-52100", velocity="0.05 m/s")  # fmt: skip
    pulses = [hc.propagate(chain), hc.bca(chain), hc.local_rate(chain)]
    with hc.figure_style(width):
        axes = hc.plot_pulses(pulses, log=True, residuals=True)
        axes.figure.draw_without_rendering()
        lower = axes.figure.axes[1]
        label = lower.yaxis.label.get_window_extent()
        assert label.height <= 1.02 * lower.bbox.height
        bottom = lower.get_ylim()[0]
        for line in lower.lines:
            if isinstance(line.get_markevery(), list):
                values = np.asarray(line.get_ydata())[line.get_markevery()]
                assert (values > 1.2 * bottom).all()
    plt.close(axes.figure)

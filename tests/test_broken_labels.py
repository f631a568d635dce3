"""Labels of axes and shaded bodies in plots of sweeps, sensitivities and disorder."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

import hertzchain as hc


@pytest.mark.parametrize("width", [None, "single column"])
def test_long_labels_of_sweeps_are_inside_the_figure(width):
    found = hc.sweep({
        "chain": {"radii": 1.0, "beads": 40},
        "axes": {"radii.20": [0.8, 1.0, 1.2]},
        "sweep": {"methods": ["simulate"], "keep": ["reflection.reflected_energy@10-30"]},
    })  # fmt: skip
    with hc.figure_style(width):
        axes = hc.plot_sweep(found)
        figure = axes.figure
        figure.draw_without_rendering()
        box = axes.yaxis.label.get_window_extent()
    assert axes.get_ylabel().replace("\n", " ").endswith("contacts 10 to 30")
    assert box.y0 >= 0.0
    assert box.y1 <= figure.bbox.y1


def test_strikers_and_caps_are_shaded_in_plots_of_gradients():
    balls = hc.Chain.from_materials(diameters="10 mm", materials="steel-52100", beads=4)
    cell = hc.Wall("20 kN/mm", exponent=1)
    row = balls.replace(right_wall=cell).with_cap("15 g").struck_by(velocity="0.1 m/s")
    axes = hc.gradient(row, "wall_force.peak", to="radii").plot()
    spans = [patch.get_extents().transformed(axes.transData.inverted()) for patch in axes.patches
             if patch.get_label() == "striker and cap" or patch.get_width() == 1.0]  # fmt: skip
    assert [round(0.5 * (span.x0 + span.x1)) for span in spans] == [1, row.beads]
    assert "striker and cap" in axes.get_legend_handles_labels()[1]


def test_the_spread_of_disorder_is_drawn_around_differences():
    chain = hc.Chain.tapered("backward-exponential", 0.03, beads=30)
    disordered = hc.disorder(chain, 0.01)
    _, panels = plt.subplots(2)
    hc.plot_pulses([hc.propagate(chain), disordered], residuals=True, ax=panels)
    (band,) = (each for each in panels[1].collections if len(each.get_paths()[0].vertices) > 20)
    heights = band.get_paths()[0].vertices
    at = heights[:, 0] == 20.0
    spread = np.ptp(heights[at, 1])
    ratio = disordered.velocity[19] / hc.propagate(chain).velocity[19]
    sigma = disordered.column("velocity_spread")[19]
    assert spread == pytest.approx(100.0 * ratio * 2.0 * np.sinh(sigma), rel=1e-9)


@pytest.mark.parametrize("both", [False, True])
def test_the_legend_of_a_sensitivity_covers_no_name_of_a_shaded_body(monkeypatch, both):
    balls = hc.Chain.from_materials(diameters="12 mm", materials="steel-52100", beads=4)
    row = balls.with_cap("40 g").struck_by(velocity="0.01 m/s")
    problem = hc.Design(row, minimise="velocity@last", vary=[hc.vary.radii("5 mm", "6 mm")])
    found = hc.design(problem, budget=100, seed=1)
    larger = np.array([0.0, 0.1, 0.2, 0.1, 0.3, 0.0])
    changes = larger, -0.2 * larger if both else -larger
    monkeypatch.setattr(type(found), "changes", changes)
    axes = found.plot("sensitivity")
    # One colour needs no legend, which could be above the axes, where the names are.
    assert (axes.get_legend() is not None) == both
    assert {each.get_text() for each in axes.texts} == (set() if both else {"striker", "cap"})

"""Legends against the places of the data in a figure, at widths of journals and in panels."""

from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from figure_texts import legend_texts

import hertzchain as hc
from hertzchain.plotting import design_beads
from hertzchain.plotting.legends import covers_data, place_legend
from hertzchain.sweeps.methods import METHODS, pulse_by

TAPERS = {"backward-linear": 0.3, "backward-exponential": 0.05,
          "forward-linear": 0.009, "forward-exponential": 0.03}  # fmt: skip
COLUMN = 86.0 / 25.4


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def four_tapers(beads):
    return [hc.propagate(hc.Chain.tapered(name, q, beads=beads)) for name, q in TAPERS.items()]


def data_in(axes, box):
    """Number of points in a box, on curves with many points between neighbouring data."""
    found = 0
    for line in axes.lines:
        points = line.get_transform().transform(np.asarray(line.get_xydata(), float))
        points = points[np.isfinite(points).all(axis=1)]
        if line.get_linestyle() != "None" and len(points) > 1:
            place = np.linspace(0.0, len(points) - 1.0, 20 * len(points))
            points = np.column_stack(
                [np.interp(place, np.arange(len(points)), each) for each in points.T]
            )
        found += box.count_contains(points)
    return found


def assert_nothing_is_covered(axes):
    figure = axes.figure
    for dpi in (100, 300):
        figure.set_dpi(dpi)
        figure.draw_without_rendering()
        box = axes.get_legend().get_window_extent()
        assert data_in(axes, box) == 0
        for other in figure.axes:
            if other is not axes:
                assert not box.overlaps(other.get_window_extent())
        assert figure.bbox.x0 <= box.x0
        assert box.x1 <= figure.bbox.x1
        assert box.y1 <= figure.bbox.y1
        if axes.get_title():
            assert not box.overlaps(axes.title.get_window_extent())


@pytest.mark.parametrize("log", [True, False])
@pytest.mark.parametrize("beads", [100, 60])
@pytest.mark.parametrize("quantity", ["momentum", "velocity", "energy", "arrival", "peak_force"])
def test_pulses_in_a_column_are_not_covered(quantity, beads, log):
    with hc.figure_style("single column"):
        axes = hc.plot_pulses(four_tapers(beads), quantity, log=log)
    assert_nothing_is_covered(axes)
    assert axes.figure.get_figwidth() == pytest.approx(COLUMN)
    # The axes keep their height.
    assert axes.bbox.height / axes.figure.dpi > 0.65 * 0.72 * COLUMN


@pytest.mark.long
@pytest.mark.parametrize("width", [None, "single column", "double column"])
@pytest.mark.parametrize("residuals", [True, False])
def test_comparisons_are_not_covered(residuals, width):
    chain = hc.Chain.tapered("forward-linear", 0.015, beads=40)
    pulses = [hc.propagate(chain), hc.bca(chain), hc.local_rate(chain)]
    with hc.figure_style(width):
        assert_nothing_is_covered(hc.plot_pulses(pulses, log=True, residuals=residuals))


def test_long_legends_are_between_the_axes_and_their_title():
    pulses = four_tapers(60)
    axes = hc.plot_pulses([*pulses, *(hc.bca(each.chain) for each in pulses)], log=True)
    assert_nothing_is_covered(axes)
    assert axes.get_legend().get_window_extent().y0 >= axes.bbox.y1
    assert axes.get_title() == "60 beads"


def test_forces_and_waves_in_a_column_are_not_covered():
    run = hc.simulate(hc.Chain.uniform(24).replace(right_wall=hc.Wall()), until=90.0, times=2000)
    with hc.figure_style("single column"):
        for axes in (run.plot_forces([3, 6, 9, 12, 15, 18, 21, "wall"]), run.waves().plot()):
            assert_nothing_is_covered(axes)


def test_a_legend_is_inside_the_axes_if_there_is_room():
    with hc.figure_style("single column"):
        axes = hc.propagate(hc.Chain.uniform(20)).plot("velocity")
    axes.figure.draw_without_rendering()
    legend = axes.get_legend().get_window_extent()
    assert axes.bbox.contains(*legend.min)
    assert axes.bbox.contains(*legend.max)
    assert (25.4 * axes.figure.get_size_inches()).round(1).tolist() == [86.0, 61.9]


@pytest.mark.long
def test_panels_of_a_given_figure_keep_their_size_and_their_neighbours():
    figure, panels = plt.subplots(1, 2, figsize=(9.0, 4.0), layout="constrained")
    for axes, quantity in zip(panels, ("momentum", "velocity"), strict=True):
        hc.plot_pulses(four_tapers(60), quantity, log=True, ax=axes)
    assert figure.get_size_inches().tolist() == [9.0, 4.0]
    for axes in panels:
        assert_nothing_is_covered(axes)
    # A panel without room above keeps its axes and a legible legend.
    _, small = plt.subplots(2, 3, figsize=(6.0, 3.0), layout="constrained")
    axes = hc.plot_pulses(four_tapers(60), "velocity", log=True, ax=small[1, 2])
    assert axes.get_legend().get_frame_on()
    axes.figure.draw_without_rendering()
    assert axes.bbox.height > 0.2 * axes.figure.bbox.height


def test_legends_of_small_panels_leave_room_for_the_data():
    run = hc.simulate(hc.Chain.uniform(24), until=40.0, times=1000)
    figure, grid = plt.subplots(2, 3, layout="constrained")
    for axes in grid.flat[::2]:
        hc.plot_pulses(four_tapers(60)[:3], ax=axes)
    for axes in grid.flat[1::2]:
        run.plot_forces([5, 10, 15], ax=axes)
    figure.draw_without_rendering()
    for axes in grid.flat:
        assert axes.bbox.width > 0.12 * figure.bbox.width
        assert axes.get_legend().get_texts()[0].get_fontsize() < 8.0


@pytest.mark.parametrize(
    "draw",
    [
        lambda axes: axes.bar([0.5], [1.0], width=0.99, label="most of the axes"),
        lambda axes: axes.scatter(*np.random.default_rng(1).random((2, 2000)), label="points"),
        lambda axes: axes.fill_between([0.0, 1.0], [0.0, 0.02], [0.98, 1.0], label="band"),
    ],
)
def test_bars_points_and_bands_count_as_data(draw):
    with hc.figure_style("single column"):
        _, axes = plt.subplots()
        draw(axes)
        axes.margins(0.0)
        place_legend(axes, own=True)
    assert axes.get_legend().get_window_extent().y0 >= axes.bbox.y1


def test_texts_count_as_data():
    with hc.figure_style("single column"):
        _, axes = plt.subplots()
        axes.plot([0.0, 0.5], [0.0, 0.5], "o", label="points")
        axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
        text = axes.text(0.6, 0.9, "a note at the right")
        place_legend(axes, own=True)
    legend = axes.get_legend().get_window_extent()
    assert legend.y1 < axes.bbox.y1
    assert not legend.overlaps(text.get_window_extent())


def test_a_thick_line_is_as_wide_as_it_is_drawn():
    with hc.figure_style():
        _, axes = plt.subplots()
        axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
        line = axes.plot([0.0, 1.0], [0.5, 0.5], linewidth=1.0, label="line")[0]
        place_legend(axes)
        legend = axes.get_legend()
        legend.set_loc("upper right")
        bottom = legend.get_window_extent().y0
        points = axes.figure.dpi / 72.0
        below = axes.transData.inverted().transform((0.0, bottom - 8.0 * points))[1]
        line.set_ydata([below, below])
        assert not covers_data(legend)
        line.set_linewidth(14.0)
        assert covers_data(legend)


def test_shaded_ranges_do_not_count_as_data():
    _, axes = plt.subplots()
    axes.axvspan(0.0, 1.0, color="0.9")
    axes.plot([0.0, 1.0], [0.0, 1.0], label="line")
    place_legend(axes)
    assert axes.get_legend().get_window_extent().y1 < axes.bbox.y1


def test_legends_follow_the_layout_of_panels_that_are_drawn_later():
    with hc.figure_style("double column"):
        figure, panels = plt.subplots(1, 3)
        hc.plot_pulses(four_tapers(60)[:2], "momentum", ax=panels[0])
        run = hc.simulate(hc.Chain.uniform(24), times=400)
        run.plot(ax=panels[1])
        run.budget().plot(ax=panels[2])
        figure.draw_without_rendering()
    # Half of the width that the panel had first.
    assert data_in(panels[0], panels[0].get_legend().get_window_extent()) == 0


def test_without_a_layout_engine_a_legend_stays_inside_the_figure():
    figure, axes = plt.subplots()
    hc.plot_pulses(four_tapers(60), "velocity", log=True, ax=axes)
    figure.draw_without_rendering()
    assert figure.bbox.y1 >= axes.get_legend().get_window_extent().y1
    assert figure.bbox.y1 >= axes.title.get_window_extent().y1
    assert not axes.get_legend().get_window_extent().overlaps(axes.title.get_window_extent())


@pytest.mark.long
@pytest.mark.parametrize("width", [None, "single column"])
def test_sweeps_with_many_curves_are_not_covered(width):
    found = hc.sweep({
        "chain": {"taper": "forward-exponential"},
        "axes": {"rate": {"linspace": [0.01, 0.06, 6]}, "beads": [20, 30, 40, 50, 60, 70, 80]},
        "sweep": {"keep": ["momentum"], "at": "last"},
    })  # fmt: skip
    with hc.figure_style(width):
        assert_nothing_is_covered(hc.plot_sweep(found, log=True))


@pytest.mark.long
@pytest.mark.parametrize("place", ["left", "right"])
def test_letters_of_panels_are_above_the_legend(place):
    with hc.figure_style("double column"):
        figure, panels = plt.subplots(1, 2)
        letter = panels[1].set_title("(b)", loc=place)
        hc.plot_pulses(four_tapers(60), "velocity", log=True, ax=panels[1])
        figure.draw_without_rendering()
    legend = panels[1].get_legend().get_window_extent()
    assert legend.y0 >= panels[1].bbox.y1
    assert letter.get_window_extent().y0 >= legend.y1 - 1.0


@pytest.mark.parametrize(("beads", "rows"), [(9, 1), (60, 2), (90, 3), (180, 0)])
def test_designs_of_two_materials_show_diameters_and_all_beads(beads, rows, monkeypatch):
    chain = hc.Chain.dimer(
        diameters=["10 mm", "6 mm"], materials=["steel-316", "ptfe"], beads=beads,
        right_wall=hc.Wall.of("steel-316"),
    )  # fmt: skip
    monkeypatch.setattr(design_beads, "violations", lambda *_: [])
    monkeypatch.setattr(design_beads, "same_as", lambda _: "")
    row = SimpleNamespace(chain=chain, not_a_prediction=False)
    both = dict.fromkeys(("given chain", "design"), row)
    monkeypatch.setattr(design_beads, "shown_chains", lambda _: both)
    axes = design_beads.plot_beads(SimpleNamespace(chain=chain))
    axes.figure.draw_without_rendering()
    # All beads are in the axes.
    assert axes.get_legend().get_window_extent().y0 >= axes.bbox.y1
    assert {*legend_texts(axes)} == {"steel-316", "PTFE"}
    texts = [text for text in axes.texts if text.get_text() in ("10", "6")]
    boxes = [text.get_window_extent() for text in texts]
    if rows:
        assert len(texts) == beads
        assert len({round(box.y1) for box in boxes}) == rows
        assert not any(one.overlaps(other) for i, one in enumerate(boxes) for other in boxes[:i])
    else:
        assert "10 mm and 6 mm in turn" in [text.get_text() for text in axes.texts]


def two_chains_by_three_methods():
    chains = (hc.Chain.tapered("backward-exponential", 0.05, beads=20),
              hc.Chain.tapered("forward-exponential", 0.03, beads=30))  # fmt: skip
    return [by(chain) for chain in chains for by in (hc.propagate, hc.bca, hc.local_rate)]


def test_long_labels_have_two_columns_in_a_column():
    with hc.figure_style("single column"):
        axes = hc.plot_pulses(two_chains_by_three_methods(), residuals=True)
    assert_nothing_is_covered(axes)
    legend = axes.get_legend()
    assert len({round(text.get_window_extent().x0) for text in legend.get_texts()}) == 2
    assert all(text.get_fontsize() >= 6.0 for text in legend.get_texts())


@pytest.mark.parametrize("width", [None, "single column"])
def test_methods_with_a_common_colour_have_symbols_at_different_beads(width):
    with hc.figure_style(width):
        axes = hc.plot_pulses(two_chains_by_three_methods(), residuals=True)
    beads = {}
    for line in axes.lines:
        if line.get_linestyle() != "None" and len(line.get_xdata()):
            start, step = line.get_markevery()
            marked = {*line.get_xdata()[start::step].tolist()}
            assert marked
            assert not marked & beads.setdefault(line.get_color(), set())
            beads[line.get_color()] |= marked
    assert len(beads) == 2
    lower = axes.figure.axes[1]
    axes.figure.draw_without_rendering()
    low, high = lower.get_ylim()
    assert sum(low <= tick <= high for tick in lower.get_yticks()) in (3, 4)


def test_the_legend_of_two_parameters_does_not_cover_their_medians():
    values = np.array([1.2003e9, 3.97e-6])
    samples = values * (1.0 + 1e-3 * np.random.default_rng(1).standard_normal((500, 2)))
    names = ("materials[my ptfe].young", "loss.time")
    figure = hc.Posterior(names, samples, 0.5, 30.0, 500, values, ("Pa", "s")).plot()
    figure.draw_without_rendering()
    legend = figure.legends[0].get_window_extent()
    assert not any(legend.overlaps(axes.title.get_window_extent()) for axes in figure.axes)


def crowded_panel():
    """A small panel of two with a legend that covers curves everywhere and has no room above."""
    _, (_, axes) = plt.subplots(2, 1, figsize=(3.4, 4.0))
    x = np.linspace(0.0, 1.0, 400)
    for k in range(3):
        axes.plot(x, np.sin(60.0 * x + k), label=f"force on the wall of row {k}")
    return axes


def test_given_axes_become_longer_if_a_legend_has_no_other_place():
    axes = crowded_panel()
    limits = axes.get_ylim()
    for _ in range(3):  # several runs in the same axes do not make them longer and longer
        place_legend(axes)
        assert axes.get_ylim()[0] == limits[0]
        assert 1.2 < np.diff(axes.get_ylim())[0] / np.diff(limits)[0] < 2.6
    axes.figure.draw_without_rendering()
    assert not covers_data(axes.get_legend())
    assert axes.get_legend().get_window_extent().y1 <= axes.bbox.y1


def test_limits_of_users_remain_below_a_legend():
    axes = crowded_panel()
    axes.set_ylim(-1.0, 1.2)
    place_legend(axes)
    assert axes.get_ylim() == (-1.0, 1.2)
    assert axes.get_legend().get_frame().get_alpha() == 0.8


def test_no_legend_of_several_runs_covers_the_largest_peak():
    taper = hc.Chain.tapered("forward-exponential", 0.05, beads=11)
    dimer = hc.Chain.dimer(radii=[1.0, 0.7], beads=20)
    with hc.figure_style("single column"):
        axes = None
        for chain in (hc.Chain.uniform(20), taper, taper.decorated(0.4), dimer):
            run = hc.simulate(chain.replace(right_wall=hc.Wall()), until=40.0, times=2000)
            axes = run.plot_forces(["wall"], **({} if axes is None else {"ax": axes}))
        axes.figure.draw_without_rendering()
    assert not covers_data(axes.get_legend())


def test_all_methods_have_own_lines_and_symbols_and_room_for_their_differences():
    chain = hc.Chain.tapered("forward-exponential", 0.05, beads=20)
    pulses = [pulse_by(method, chain) for method in METHODS]
    axes = hc.plot_pulses(pulses, residuals=True)
    curves = [line for line in axes.lines if len(line.get_xdata()) > 1]
    assert len(curves) == len(METHODS)
    # Dashes have no public getter.
    assert len({str(line._unscaled_dash_pattern) for line in curves}) == len(METHODS)
    assert len({line.get_marker() for line in curves}) == len(METHODS)
    lower = axes.figure.axes[1]
    assert lower.bbox.height > 0.6 * axes.bbox.height
    # A handle has room for the longest pattern of dashes.
    legend = axes.get_legend()
    assert legend.handlelength * legend.get_texts()[0].get_fontsize() > 20.0


def test_wide_legends_keep_a_distance_from_the_edge_of_their_figure():
    distances = []
    for letters in range(8):
        _, axes = plt.subplots(layout="constrained")
        # The line covers all places inside the axes.
        axes.plot(np.linspace(0.0, 1.0, 99), np.resize([0.0, 1.0], 99), label="n" * 29)
        axes.plot([0.0, 1.0], [0.5, 0.5], label="n" * 29 + "i" * letters)
        place_legend(axes, own=True)
        distances.append(axes.get_legend().get_window_extent().x0 * 72.0 / axes.figure.dpi)
    # The widest one in two columns, and the first one in a column.
    assert min(distances) >= 0.9
    assert min(distances) < 5.0 < max(distances)


@pytest.mark.parametrize("given", [False, True])
def test_the_curves_of_a_chain_are_in_one_column_of_a_legend(given):
    chains = [hc.Chain.tapered(ratio=each, beads=30) for each in (0.5, 0.25)]
    pulses = [each(chain) for chain in chains for each in (hc.propagate, hc.bca, hc.local_rate)]
    labels = [f"taper to {each}, {i}" for each in ("1/2", "1/4") for i in range(3)]
    with hc.figure_style("single column"):
        axes = hc.plot_pulses(pulses, "momentum", labels=labels if given else None)
        axes.figure.draw_without_rendering()
    columns = {}
    for text in axes.get_legend().get_texts():
        columns.setdefault(round(text.get_window_extent().x0), []).append(text.get_text())
    first, second = columns.values()
    if given:
        assert (first, second) == ([*labels[:3], "last bead (free end)"], labels[3:])
    else:
        assert second == ["propagation", "BCA", "local-rate law"]

"""Labels, curves and legends of plots of sweeps."""

import itertools

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.legend import Legend

import hertzchain as hc
from hertzchain.cli.wording import on_command_line

FORWARD = {"taper": "forward-exponential", "beads": 40}
RATES = [0.02, 0.05, 0.08]


def swept(chain, axes, **settings):
    return hc.sweep({"chain": chain, "axes": axes, "sweep": settings})


def test_one_method_of_a_map_is_chosen_in_words_of_the_command_line():
    axes = {"rate": RATES, "beads": [20, 30]}
    found = swept({"taper": "forward-exponential"}, axes, methods=["propagate", "bca"], at="last")
    with pytest.raises(hc.InputError, match="such as approach='propagate', or a value") as raised:
        hc.plot_sweep(found, levels=[0.5])
    words = on_command_line(str(raised.value))
    assert words.endswith(
        "choose a method, such as --at approach=propagate, or a value, such as --at beads=20"
    )


def test_several_methods_for_several_values_have_colours_and_looks():
    axes = {"rate": [*RATES, 0.03], "beads": [20, 30]}
    methods = ["propagate", "bca", "local-rate"]
    found = swept({"taper": "forward-exponential"}, axes, methods=methods, at="last")
    handles, labels = hc.plot_sweep(found).get_legend_handles_labels()
    assert labels == ["beads = 20", "beads = 30", "propagation", "BCA", "local-rate law"]
    curves = [line for line in handles[0].axes.lines if line.get_xdata().size]
    assert len(curves) == 6
    for i, (beads, method) in enumerate(itertools.product((20, 30), methods)):
        expected = found.velocity.sel(beads=beads, approach=method).sortby("rate")
        np.testing.assert_array_equal(curves[i].get_ydata(), expected)
        value, look = handles[i // 3], handles[2 + i % 3]
        assert curves[i].get_color() == value.get_color()
        for get in ("get_linestyle", "get_marker"):
            assert getattr(curves[i], get)() == getattr(look, get)()
    assert len({curve.get_color() for curve in curves}) == 2
    # Importing the package changes no setting of Matplotlib.
    assert not [
        each for each in Legend.get_default_handler_map() if "hertzchain" in each.__module__
    ]


def test_too_many_dimensions_are_listed_without_the_methods():
    axes = {"rate": RATES, "beads": [20, 30], "exponent": [1.5, 2.0, 2.5]}
    methods = ["propagate", "local-rate"]
    found = swept({"taper": "forward-exponential"}, axes, methods=methods, at="last")
    with pytest.raises(hc.InputError, match="3 remaining dimensions") as raised:
        hc.plot_sweep(found)
    assert "approach" not in str(raised.value)
    assert str(raised.value).endswith("choose a value of the others, such as beads=20")


@pytest.mark.parametrize(("taper", "symbol"), [("forward-exponential", "q"),
                                               ("forward-linear", "S")])  # fmt: skip
def test_labels_have_the_selected_bead_and_the_symbol_of_the_rate(taper, symbol):
    rates = [0.002, 0.004, 0.006]
    found = swept({"taper": taper, "beads": 40}, {"rate": rates},
                  keep=["velocity", "peak_force"], methods=["bca", "propagate"])  # fmt: skip
    with hc.figure_style("single column"):
        axes = hc.plot_sweep(found, "velocity", bead=33)
        force = hc.plot_sweep(found, "peak_force", contact=7)
        every = hc.plot_sweep(found, "velocity", approach="bca", levels=[0.5])
    assert axes.get_ylabel().replace("\n", " ") == "velocity $v_{33}$"
    assert axes.get_xlabel() == f"rate of the taper ${symbol}$"
    assert force.get_ylabel().replace("\n", " ") == "largest force $F_{7}$"
    # Along the beads, no bead is selected.
    assert every.collections[0].colorbar.ax.get_ylabel() == "velocity $v_k$"
    assert every.get_xlabel() == f"rate of the taper ${symbol}$"
    assert hc.plot_sweep(found, "velocity", rate=0.004).get_title() == f"${symbol}$ = 0.004"


@pytest.mark.parametrize(("chain", "axes", "damped"), [
    ({"loss": {"law": "viscoelastic", "time": 0.01}}, {"beads": [4, 5]}, True),
    ({"loss": {"law": "unloading-ratio", "ratio": 0.9}}, {"beads": [4, 5]}, False),
    ({"beads": 4, "loss": {"law": "restitution", "coefficient": 0.9}},
     {"loss.coefficient": [0.8, 0.9]}, True),
])  # fmt: skip
def test_the_label_of_forces_excludes_damping_where_the_sweep_has_it(chain, axes, damped):
    found = swept({"taper": "uniform"} | chain, axes, keep=["peak_force"], methods=["simulate"],
                  at="last")  # fmt: skip
    label = hc.plot_sweep(found, "peak_force").get_ylabel().replace("\n", " ")
    words = "largest force without damping" if damped else "largest force"
    assert label == f"{words} $F_{{N-1}}$"
    # The chains of a dataset without its specification are not known.
    del found.attrs["specification"]
    label = hc.plot_sweep(found, "peak_force").get_ylabel().replace("\n", " ")
    assert label == "largest force without damping $F_{N-1}$"


def test_a_plot_of_a_dataset_without_its_specification_has_no_symbol():
    found = swept(FORWARD, {"rate": RATES}, at="last")
    del found.attrs["specification"]
    assert hc.plot_sweep(found).get_xlabel() == "rate of the taper"


def test_curves_that_agree_do_not_hide_each_other():
    methods = ["propagate", "local-rate", "modified-bca"]
    found = swept(FORWARD, {"rate": RATES}, methods=methods, at="last", errors=["velocity"])
    simulated, law, bca, *_ = hc.plot_sweep(found, "velocity").lines
    assert (simulated.get_linestyle(), simulated.get_marker()) == ("None", "o")
    assert simulated.get_zorder() > max(law.get_zorder(), bca.get_zorder())
    assert {law.get_marker(), bca.get_marker()} == {""}
    assert (law.get_linestyle(), bca.get_linestyle()) == ("-.", ":")
    # A simulation on its own has a line.
    (alone,) = hc.plot_sweep(found, "velocity", approach="propagate").lines
    assert (alone.get_linestyle(), alone.get_marker()) == ("-", "o")


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_plots_of_errors_omit_the_reference_and_mark_the_right_curves():
    found = swept({"taper": "forward-exponential", "beads": 30}, {"rate": [0.02, 0.05, 0.3]},
                  methods=["propagate", "bca", "local-rate"], errors=["velocity"])  # fmt: skip
    flagged = found.outside_range.sel(approach=["bca", "local-rate"]).values.astype(bool)
    assert flagged.any()
    axes = hc.plot_sweep(found, "worst_error_of_velocity")
    handles, labels = axes.get_legend_handles_labels()
    assert labels == ["BCA", "local-rate law", "outside the range of the method"]
    assert axes.get_title() == "relative to propagation"
    colours = {}
    for handle, name in zip(handles, ["bca", "local-rate"], strict=False):
        expected = 100.0 * found.worst_error_of_velocity.sel(approach=name)
        np.testing.assert_array_equal(handle.get_ydata(), expected)
        colours[name] = handle.get_color()
    # Marks have the colours of their curves; that of the legend is grey if there are several.
    marked = [name for name, flags in zip(colours, flagged.T, strict=True) if flags.any()]
    marks = [line for line in axes.lines if line.get_alpha() and len(line.get_xdata())]
    assert [mark.get_color() for mark in marks] == [colours[name] for name in marked]
    for mark, name in zip(marks, marked, strict=True):
        outside = found.outside_range.sel(approach=name).values.astype(bool)
        np.testing.assert_array_equal(mark.get_xdata(), found.rate.values[outside])
    shown = axes.get_legend().get_lines()[2]
    assert shown.get_alpha() == marks[0].get_alpha()
    assert (shown.get_color() in colours.values()) == (len(marked) == 1)
    # Curves have the colours that they have beside the reference.
    assert hc.plot_sweep(found, "velocity", bead=20).lines[1].get_color() == colours["bca"]


@pytest.fixture(scope="module")
def walls():
    """A sweep in SI units over two axes, some of whose points have flags."""
    chain = {"radii": 5e-3, "materials": "steel-52100", "beads": 3, "right_wall": {}}
    chain["struck_by"] = {"mass": 4e-3, "velocity": 0.1}
    axes = {"radii": {"linspace": ["2 mm", "5 mm", 7]}, "beads": [3, 4, 5, 6, 7, 8, 9]}
    found = swept(chain, axes, methods=["simulate"], keep=["wall_peak_force"]).load()
    found.outside_range[0, :2] = 1
    found["sensitive"] = (0 * found.outside_range).rename("sensitive")
    found.sensitive[0, 1], found.sensitive[3, 4] = 1, 1
    return found


@pytest.mark.parametrize("title", ["", "Ten balls against a steel plate"])
@pytest.mark.parametrize("width", [None, "single column"])
def test_the_legend_of_a_map_is_below_its_axes(walls, title, width):
    with hc.figure_style(width):
        axes = hc.plot_sweep(walls.assign_attrs(title=title))
    figure = axes.figure
    for dpi in (100, 300):
        figure.set_dpi(dpi)
        figure.draw_without_rendering()
        box = axes.get_legend().get_window_extent()
        assert box.y1 <= axes.xaxis.label.get_window_extent().y0
        assert min(box.x0, box.y0) >= 0.0
        assert box.x1 <= figure.bbox.x1
        if box.width < axes.bbox.width:
            shift = 0.5 * (box.x0 + box.x1 - axes.bbox.x0 - axes.bbox.x1)
            assert abs(shift) < 0.03 * axes.bbox.width
    # The figure is taller by the legend; the axes keep their height.
    assert axes.bbox.height > 0.6 * figure.bbox.height


def test_legends_of_maps_in_panels_are_in_the_figure(walls):
    with hc.figure_style():
        figure, panels = plt.subplots(1, 2, figsize=(9.6, 3.8))
        for axes in panels:
            hc.plot_sweep(walls, ax=axes)
        figure.draw_without_rendering()
    for axes in panels:
        box = axes.get_legend().get_window_extent()
        assert 0.0 <= box.y0 < box.y1 <= axes.xaxis.label.get_window_extent().y0


def test_sensitive_points_of_maps_and_curves_are_marked(walls):
    axes = hc.plot_sweep(walls)
    assert axes.get_title().endswith("2 points may be sensitive to small changes")
    marks = {each.get_label(): each.get_offsets().tolist() for each in axes.collections}
    assert marks["may be sensitive to small changes"] == [[2.0, 4.0], [3.5, 7.0]]
    curve = hc.plot_sweep(walls, beads=7)
    handles, labels = curve.get_legend_handles_labels()
    shown = handles[labels.index("may be sensitive to small changes")]
    marks = [line for line in curve.lines if line.get_marker() == shown.get_marker() != "None"]
    points = [line.get_xydata().tolist() for line in marks if len(line.get_xdata())]
    assert [[3.5, float(walls.wall_peak_force[3, 4, 0])]] in points


@pytest.mark.parametrize(("beads", "count"), [(3, ""), (4, "1 point"), (7, "1 point")])
def test_only_points_in_the_plot_are_counted(walls, beads, count):
    title = hc.plot_sweep(walls, beads=beads).get_title()
    assert title.partition(" may be")[0].partition("; ")[2] == count
    assert ("sensitive" in title) == bool(count)


BALLS = {
    "radii": "5 mm", "beads": 8, "materials": "steel-52100",
    "right_wall": {"material": "steel-52100"},
}  # fmt: skip


@pytest.mark.filterwarnings("ignore::hertzchain.IncompleteWarning")
@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_only_values_that_are_not_complete_are_called_so():
    found = hc.sweep({
        "chain": BALLS, "axes": {"velocity": [0.01, 0.1, 0.15, 0.4]}, "method": {"until": "200 us"},
        "sweep": {"methods": ["simulate"], "keep": ["wall_peak_force", "wall_impulse_of_impact",
                                                    "wall_largest_so_far", "largest_overlap"]},
    })  # fmt: skip
    peaks, impulses = (found[name].isnull().values.ravel() for name in (
        "wall_peak_force", "wall_impulse_of_impact"))  # fmt: skip
    assert 0 < peaks.sum() < found.incomplete.sum() == impulses.sum()
    axes = hc.plot_sweep(found, "wall_peak_force")
    assert axes.get_title() == f"{peaks.sum()} points not complete, blank"
    assert "not complete" not in axes.get_legend_handles_labels()[1]
    # The axis shows that points are blank.
    low, high = axes.get_xlim()
    assert low <= 0.01 < 0.4 <= high
    so_far = hc.plot_sweep(found, "wall_largest_so_far")
    assert "not complete" in so_far.get_legend_handles_labels()[1]
    overlaps = hc.plot_sweep(found, "largest_overlap", levels=[1e-9])
    assert "not complete" not in overlaps.get_legend_handles_labels()[1]
    bar = overlaps.collections[0].colorbar.ax
    assert bar.get_ylabel() == "largest overlap $d_k$ [µm]"
    assert bar.get_ylim()[1] == pytest.approx(1e6 * float(found.largest_overlap.max()))


def test_large_numbers_of_an_axis_have_a_power_of_ten():
    axes = {"rate": [0.2, 0.4, 0.6]}
    found = swept({"taper": "backward-exponential", "beads": 30}, axes, methods=["local-rate"],
                  keep=["momentum"], at="last")  # fmt: skip
    drawn = hc.plot_sweep(found)
    drawn.figure.canvas.draw()
    assert "10^{7}" in drawn.yaxis.get_offset_text().get_text()


def test_a_sweep_of_one_point_has_a_symbol_for_each_method():
    found = swept(FORWARD, {"rate": [0.05]}, methods=["propagate", "local-rate"], at="last",
                  keep=["momentum"])  # fmt: skip
    axes = hc.plot_sweep(found)
    assert axes.get_xlabel().startswith("rate of the taper")
    curves = [line for line in axes.lines if len(line.get_xdata())]
    assert len({line.get_marker() for line in curves} - {"", "None"}) == len(curves) == 2


def test_long_names_of_an_axis_do_not_overlap():
    names = ["steel-52100", "brass", "tungsten-carbide", "titanium", "silicon-nitride", "nylon"]
    found = swept(BALLS | {"velocity": "10 mm/s"}, {"materials": names}, methods=["simulate"],
                  keep=["wall_peak_force"])  # fmt: skip
    axes = hc.plot_sweep(found)
    axes.figure.draw_without_rendering()
    labels = axes.get_xticklabels()
    assert {label.get_rotation() for label in labels} == {30.0}
    # Inclined texts next to each other are apart if their right ends are a line height apart.
    ends = [label.get_window_extent().x1 for label in labels]
    height = labels[0].get_fontsize() * axes.figure.dpi / 72.0
    assert min(np.diff(ends)) > height / np.sin(np.radians(30.0))


def test_a_wide_legend_below_a_map_does_not_move_its_colour_bar(walls):
    axes = hc.plot_sweep(walls)
    axes.figure.draw_without_rendering()
    bar = axes.collections[0].colorbar.ax
    assert bar.bbox.x0 - axes.bbox.x1 < 0.1 * axes.bbox.width


@pytest.fixture(scope="module")
def last_beads():
    """Velocities and momenta of last beads by two methods."""
    return hc.sweep({
        "chain": {"taper": "forward-exponential"},
        "axes": {"rate": [0.02, 0.04], "beads": [10, 20]},
        "sweep": {"methods": ["propagate", "bca"], "keep": ["velocity", "momentum"], "at": "last"},
    })  # fmt: skip


def _looks_and_labels(axes):
    curves = [line for line in axes.lines if not str(line.get_label()).startswith("_")]
    return [(line.get_color(), line.get_marker()) for line in curves], [
        line.get_label() for line in curves
    ]


@pytest.mark.parametrize("together", [True, False])
def test_quantities_in_one_figure_have_own_colours_and_names(together):
    found = hc.sweep({
        "chain": {"taper": "uniform", "beads": 10, "masses": 1.0},
        "axes": {"masses.5": [0.5, 1.0]},
        "sweep": {"methods": ["simulate"], "keep": ["largest_velocity@4", "largest_velocity@7"]},
    })  # fmt: skip
    names = ["largest_velocity_4", "largest_velocity_7"]
    if together:
        axes = hc.plot_sweep(found, names)
    else:
        axes = hc.plot_sweep(found, names[0])
        assert hc.plot_sweep(found, names[1], ax=axes) is axes
    looks, labels = _looks_and_labels(axes)
    assert labels == ["largest velocity of bead 4", "largest velocity of bead 7"]
    assert len({colour for colour, _ in looks}) == len({marker for _, marker in looks}) == 2
    assert axes.get_ylabel() == "largest velocity"
    assert [text.get_text() for text in axes.get_legend().get_texts()] == labels


def test_values_in_one_figure_are_named_by_what_distinguishes_them(last_beads):
    axes = hc.plot_sweep(last_beads, "velocity", beads=10)
    hc.plot_sweep(last_beads, "velocity", beads=20, ax=axes)
    looks, labels = _looks_and_labels(axes)
    assert labels == ["propagation, beads = 10", "BCA, beads = 10",
                      "propagation, beads = 20", "BCA, beads = 20"]  # fmt: skip
    assert len({colour for colour, _ in looks}) == 4
    assert axes.get_ylabel() == "velocity $v_{N}$"


def test_methods_of_several_quantities_share_entries_of_the_legend(last_beads):
    axes = hc.plot_sweep(last_beads, ["velocity", "momentum"])
    _, labels = _looks_and_labels(axes)
    assert labels == [
        "beads = 10, velocity $v_{N}$", "beads = 20, velocity $v_{N}$",
        "beads = 10, momentum $P_{N}$", "beads = 20, momentum $P_{N}$", "propagation", "BCA",
    ]  # fmt: skip


def test_labels_of_users_remain_and_are_followed_by_the_method(last_beads):
    axes = hc.plot_sweep(last_beads, "velocity", beads=10, approach="bca", label="short")
    assert axes.get_legend() is not None
    hc.plot_sweep(last_beads, "velocity", beads=20, label="long", ax=axes)
    assert _looks_and_labels(axes)[1] == ["short", "long, propagation", "long, BCA"]


def test_quantities_of_other_axes_keep_the_unit_of_the_first():
    found = hc.sweep({
        "chain": {"taper": "uniform", "materials": "steel-52100", "radius": 0.005, "beads": 10},
        "axes": {"velocity": [0.01, 0.02]},
        "sweep": {"keep": ["energy"], "at": [1, 5]},
    })  # fmt: skip
    axes = hc.plot_sweep(found, "energy", bead=1)
    hc.plot_sweep(found, "energy", bead=5, ax=axes)
    for line, bead in zip(axes.lines, (1, 5), strict=False):
        expected = 1e9 * found.energy.sel(bead=bead).squeeze().to_numpy()
        np.testing.assert_allclose(line.get_ydata(), expected, rtol=1e-12)
    assert axes.get_ylabel().endswith("[nJ]")


@pytest.mark.parametrize(("quantities", "levels", "message"), [
    (["velocity", "momentun"], None, "did you mean 'momentum'"),
    (["velocity", "momentum"], [1.0], "a map has one quantity, got velocity and momentum"),
    ([], None, "at least one name"),
    (3, None, "names of quantities, or one name, got 3"),
])  # fmt: skip
def test_quantities_that_cannot_share_a_figure_are_errors(last_beads, quantities, levels, message):
    with pytest.raises(hc.InputError, match=message):
        hc.plot_sweep(last_beads, quantities, levels=levels, approach="bca")


def test_quantities_of_different_units_are_drawn_one_by_one():
    found = hc.sweep({
        "chain": {"taper": "uniform", "materials": "steel-52100", "radius": 0.005, "beads": 10},
        "axes": {"velocity": [0.01, 0.02]}, "sweep": {"keep": ["energy", "velocity"], "at": [5]},
    })  # fmt: skip
    with pytest.raises(hc.InputError, match="have the units J, m/s; call plot_sweep once for each"):
        hc.plot_sweep(found, ["energy", "velocity"])


def test_slopes_are_power_laws_above_the_first_curve():
    row = {"radii": "5 mm", "beads": 6, "materials": "steel-52100", "right_wall": {}}
    speeds = [0.01, 0.02, 0.04, 0.08, 0.16]
    found = swept(row, {"velocity": speeds}, methods=["simulate"], keep=["wall_peak_force"])
    for log in (False, True):
        axes = hc.plot_sweep(found, log=log, slope=["6/5", 2])
        lines = {line.get_label(): line for line in axes.lines}
        x, y = lines["slope 6/5"].get_data()
        assert np.allclose(np.diff(np.log(y)) / np.diff(np.log(x)), 1.2)
        # Hertz's law makes all forces proportional to this power of the velocity.
        forces = found["wall_peak_force"].to_numpy().squeeze()
        assert np.interp(speeds, x, y) == pytest.approx(1.25 * forces, rel=2e-3)
        x, y = lines["slope 2"].get_data()
        assert np.allclose(np.diff(np.log(y)) / np.diff(np.log(x)), 2.0)
        assert "slope 6/5" in [text.get_text() for text in axes.get_legend().get_texts()]
        plt.close(axes.figure)


@pytest.mark.parametrize(
    ("slope", "said"),
    [("six", "slope"), ("6/0", "a fraction such as '6/5', got '6/0'"), (np.nan, "slope")],
)
def test_slopes_are_numbers_or_fractions(slope, said):
    found = swept(FORWARD, {"rate": RATES}, at="last")
    with pytest.raises(hc.InputError, match=said):
        hc.plot_sweep(found, slope=slope)


def test_maps_and_names_have_no_slope():
    found = swept({"taper": "forward-exponential"},
                  {"rate": np.linspace(0.01, 0.07, 7).tolist(), "beads": [*range(20, 27)]},
                  at="last")  # fmt: skip
    with pytest.raises(hc.InputError, match="a map has no slopes; omit slope"):
        hc.plot_sweep(found, slope=1.0)
    flat = swept(FORWARD, {"rate": [0.0]}, at="last")
    with pytest.raises(hc.InputError, match="a slope requires a curve with positive values"):
        hc.plot_sweep(flat, slope=1.0)


def test_points_are_drawn_over_their_first_quantity_and_the_others_are_in_the_title(tmp_path):
    axes = {"velocity": [0.3, 0.2, 0.1], "radii": ["6 mm", "5 mm", "4 mm"]}
    chain = {"materials": "steel-52100", "beads": 12, "radii": 5e-3}
    spec = {"chain": chain, "axes": axes, "sweep": {"combine": "zip", "at": "last"}}
    expected = [hc.propagate(hc.Chain.from_materials(radius, "steel-52100", beads=12, velocity=v))
                for radius, v in ((4e-3, 0.1), (5e-3, 0.2), (6e-3, 0.3))]  # fmt: skip
    for found in (hc.sweep(spec), hc.sweep(spec, tmp_path / "zip")):
        drawn = hc.plot_sweep(found)
        assert drawn.get_xlabel() == "velocity [m/s]"
        assert drawn.get_title().startswith("radius = 4 to 6 mm")
        (curve,) = [line for line in drawn.lines if len(line.get_xdata()) == 3][:1]
        np.testing.assert_allclose(curve.get_xdata(), [0.1, 0.2, 0.3])
        np.testing.assert_allclose(curve.get_ydata(), [each.velocity[-1] for each in expected])


@pytest.mark.parametrize(("axes", "label", "title"), [
    ({"beads": [20, 20, 30], "rate": [0.02, 0.03, 0.02]}, "point", ""),
    ({"beads": [20, 20, 30], "rate": [0.02, 0.03, 0.05]}, "rate of the taper $q$",
     "beads varies too"),
    ({"rate": [0.02, 0.05, 0.08], "beads": [20, 20, 20]}, "rate of the taper $q$", "beads = 20"),
])  # fmt: skip
def test_points_without_a_quantity_that_distinguishes_them_keep_their_numbers(axes, label, title):
    found = swept({"taper": "forward-exponential"}, axes, combine="zip", at="last")
    drawn = hc.plot_sweep(found)
    assert drawn.get_xlabel() == label
    assert title in drawn.get_title()


def test_scales_of_axes_can_be_chosen():
    found = swept({"taper": "uniform"}, {"beads": [10, 20, 40, 80]}, at="last")
    assert hc.plot_sweep(found).get_xscale() == "linear"
    drawn = hc.plot_sweep(found, log_x=True, log_y=True)
    assert (drawn.get_xscale(), drawn.get_yscale()) == ("log", "log")
    axes = {"rate": np.linspace(0.01, 0.08, 8).tolist(), "beads": [*range(10, 18)]}
    drawn = hc.plot_sweep(swept({"taper": "forward-exponential"}, axes, at="last"), log_y=True)
    assert (drawn.get_xscale(), drawn.get_yscale()) == ("linear", "log")
    # Cells end halfway between neighbours on the logarithmic axis, and beyond the ends.
    np.testing.assert_allclose(drawn.get_ylim(), [10 * (10 / 11) ** 0.5, 17 * (17 / 16) ** 0.5])
    zero = swept({"taper": "forward-exponential", "beads": 10}, {"rate": [0.0, 0.05]}, at="last")
    with pytest.raises(hc.InputError, match="rate has values that are not above 0"):
        hc.plot_sweep(zero, log_x=True)


def test_values_without_a_place_on_a_logarithmic_axis_interrupt_the_curve():
    found = hc.sweep({
        "chain": {"taper": "uniform", "masses": 1.0, "beads": 80},
        "axes": {"masses.40": [0.05, 0.5, 1.0, 2.0, 5.0]},
        "sweep": {"methods": ["simulate"], "keep": ["reflection.reflected_energy@28-52"]},
        "method": {"until": 95.0},
    })  # fmt: skip
    drawn = hc.plot_sweep(found, log=True)
    assert drawn.get_xscale() == "log"
    shown = np.isfinite(drawn.lines[0].get_ydata())
    assert shown.tolist() == [True, True, False, True, True]
    assert "1 value not above 0, blank" in drawn.get_title()

"""Marks of many cells of a map."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr

import hertzchain as hc
from hertzchain.plotting.sweep_marks import mark_cells


def marked(flags):
    """Axes with a map of cells of width 1, whose first centre is at 0, and its marks."""
    across, down = flags.shape
    axes = plt.subplots()[1]
    drawn = xr.DataArray(
        np.ones(flags.shape), {"x": np.arange(across), "y": np.arange(down)}, ("x", "y")
    )
    mark_cells(axes, drawn, {"outside_range": drawn.copy(data=flags)}, law=True, own=False)
    return axes


def outline(axes):
    """Segments of the outline, whichever end is first."""
    lines = axes.collections[-1].get_segments()
    return {frozenset(map(tuple, line.tolist())) for line in lines}


def test_many_marked_cells_are_outlined_and_hatched():
    flags = np.zeros((10, 9), bool)
    flags[2:, 1:8] = True
    axes = marked(flags)
    corners = {(x, y) for line in outline(axes) for x, y in line}
    assert {(1.5, 0.5), (9.5, 0.5), (1.5, 7.5), (9.5, 7.5)} <= corners
    # The outline of 8 by 7 cells.
    assert len(outline(axes)) == 30
    assert axes.collections[0].get_hatch()
    assert [text.get_text() for text in axes.get_legend().get_texts()] == [
        "outside the range of the method or of Hertz's law"
    ]
    plt.close(axes.figure)


@pytest.mark.parametrize("count", [1, 12])
def test_few_marked_cells_have_a_marker_each(count):
    flags = np.zeros((10, 9), bool)
    flags.flat[:count] = True
    axes = marked(flags)
    assert [len(each.get_offsets()) for each in axes.collections] == [count]
    plt.close(axes.figure)


@pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
@pytest.mark.parametrize(("speeds", "methods"), [
    ([5.0, 6.0, 8.0], ["propagate"]),
    ([5.0, 6.0, 8.0], ["propagate", "bca"]),
    (np.linspace(5.0, 8.0, 8).tolist(), ["propagate"]),
    (np.linspace(0.001, 8.0, 8).tolist(), ["propagate"]),
])  # fmt: skip
def test_a_range_that_all_points_leave_is_in_the_title(speeds, methods):
    found = hc.sweep({
        "chain": {"radii": 5e-3, "materials": "steel-52100", "beads": 12},
        "axes": {"velocity": speeds, "radii": np.linspace(4e-3, 6e-3, 8).tolist()},
        "sweep": {"methods": methods, "keep": ["momentum"], "at": "last"},
    })  # fmt: skip
    some = min(speeds) < 0.1
    assert bool((found.outside_range == 1).all()) != some
    axes = hc.plot_sweep(found)
    stated = "all points outside the range of the method or of Hertz's law"
    assert (stated in axes.get_title().replace("\n", " ")) != some
    labels = axes.get_legend_handles_labels()[1]
    assert any("outside" in label for label in labels) == some
    assert any(each.get_hatch() for each in axes.collections) == some
    plt.close(axes.figure)

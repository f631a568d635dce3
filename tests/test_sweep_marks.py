"""Marks of many cells of a map."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr

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

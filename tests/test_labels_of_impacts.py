"""Heights, legends and coincident curves of peaks over impacts."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

import hertzchain as hc
from hertzchain.cli.repeated_impacts import _label
from hertzchain.plotting.peaks_over_impacts import plot_peaks

INSIDE = [(False, False, False)] * 2


@pytest.mark.parametrize(("height", "text"), [("20 m", "20 m"), ("30 mm", "30 mm"), ("1 m", "1 m")])
def test_heights_of_a_metre_and_more_are_in_metres(height, text):
    chain = hc.Chain.from_materials(diameters="10 mm", materials="steel-52100", beads=3)
    assert _label(chain.struck_by(mass="50 g", height=height), "height") == text


def test_elastic_lines_are_named_and_coincident_curves_are_both_visible():
    pairs = [(60.0, 80.0), (120.0, 160.0)]
    axes = plot_peaks(
        {"a": [1.0, 2.0], "b": [1.0, 2.0], "c": [1.0, 2.0]},
        {"a": [100.0, 200.0], "b": [100.1, 200.2], "c": [110.0, 190.0]},
        {"a": pairs, "b": pairs, "c": pairs}, {"a": INSIDE, "b": INSIDE, "c": INSIDE},
        factors=("1.6", "2.8"), where="the wall", units="SI",
    )  # fmt: skip
    names = [text.get_text() for text in axes.get_legend().get_texts()]
    assert names[:4] == ["a", "b (elastic: the same curve as a)", "c", "elastic"]
    a, b, c = (line for line in axes.lines if line.get_linestyle() == "-"
               and len(np.atleast_1d(line.get_xdata())) == 2)  # fmt: skip
    assert b.get_linewidth() < a.get_linewidth() == c.get_linewidth()
    assert b.get_markersize() < a.get_markersize()
    plt.close(axes.figure)

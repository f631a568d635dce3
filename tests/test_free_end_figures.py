"""Free ends in figures of differences, and the symbols of the legend."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

import hertzchain as hc

CHAIN = hc.Chain.tapered("backward-exponential", 0.05, beads=60)


def entry(axes, name):
    handles, labels = axes.get_legend_handles_labels()
    return handles[labels.index(name)]


def test_a_large_difference_of_the_free_end_does_not_set_the_axis():
    upper = hc.plot_pulses([hc.propagate(CHAIN), hc.modified_bca(CHAIN)], residuals=True)
    lower = upper.figure.axes[1]
    end = hc.modified_bca(CHAIN).velocity[-1] / hc.propagate(CHAIN).velocity[-1] - 1.0
    assert end < -0.2
    assert lower.get_ylim()[0] > -10.0
    assert [each.get_text() for each in lower.texts] == [
        f"free end: \N{MINUS SIGN}{-100 * end:.0f}%"
    ]
    plt.close(upper.figure)


def test_a_small_difference_of_the_free_end_is_on_the_axis():
    upper = hc.plot_pulses([hc.propagate(CHAIN), hc.bca(CHAIN)], residuals=True)
    lower = upper.figure.axes[1]
    bottom, top = lower.get_ylim()
    ends = [line.get_ydata()[0] for line in lower.lines if len(line.get_xdata()) == 1]
    assert len(ends) == 1
    assert bottom < ends[0] < top
    assert not lower.texts
    plt.close(upper.figure)


@pytest.mark.parametrize(("log", "named"), [(False, 1), (True, 0)])
def test_comparisons_explain_the_free_end(log, named):
    axes = hc.modified_bca(CHAIN).compare(hc.propagate(CHAIN)).plot("velocity", log=log)
    assert entry(axes, "last bead (free end)").get_marker() == "o"
    assert len(axes.texts) == named
    plt.close(axes.figure)


def test_the_legend_has_the_symbols_of_the_free_ends():
    axes = hc.plot_pulses([hc.propagate(CHAIN)])
    assert entry(axes, "last bead (free end)").get_marker() == "o"
    axes = hc.plot_pulses([hc.propagate(CHAIN), hc.local_rate(CHAIN), hc.modified_bca(CHAIN)])
    first = axes.lines[0]
    both = entry(axes, "last bead (free end)").get_marker()
    # A circle on the left, the five corners of a square on the right; the modified BCA neglects
    # the free end.
    assert np.sum(both.vertices[:, 0] > 0.0) == 5
    (end,) = [line for line in axes.lines if np.size(line.get_xdata()) == 1][2:]
    assert (end.get_markerfacecolor(), end.get_markersize()) == ("none", first.get_markersize())
    plt.close("all")


def test_symbols_of_later_curves_surround_those_of_earlier_ones_at_the_same_end():
    chain = hc.Chain.tapered("forward-exponential", 0.05, beads=20)
    pulses = [hc.propagate(chain), hc.bca(chain), hc.hard_sphere(chain), hc.local_rate(chain)]
    axes = hc.plot_pulses(pulses)
    ends = {line.get_marker(): line for line in axes.lines if np.size(line.get_xdata()) == 1}
    circle, cross, square = (ends[each] for each in "oxs")
    assert square.get_markersize() > 1.5 * circle.get_markersize()
    # A pale edge separates symbols of the same colour.
    assert {each.get_markeredgecolor() for each in (circle, square)} == {"white"}
    assert cross.get_markeredgecolor() == cross.get_color()
    assert square.get_zorder() < circle.get_zorder() < cross.get_zorder()
    dimers = hc.plot_pulses([hc.propagate(hc.Chain.dimer(m, beads=41)) for m in (0.3, 0.5)])
    first, second = [line for line in dimers.lines if np.size(line.get_xdata()) == 1]
    assert first.get_marker() == second.get_marker() == "*"
    assert second.get_markersize() > 1.3 * first.get_markersize()
    assert second.get_zorder() < first.get_zorder()
    plt.close("all")


def test_residuals_of_random_chains_have_three_ticks():
    row = hc.Chain.from_materials(
        diameters="10 mm", materials="steel-52100", beads=40, velocity=0.3
    )
    law = hc.disorder(row, 0.02)
    for pulses in ([law], [hc.propagate(row), law]):
        upper = hc.plot_pulses(pulses, residuals=True)
        lower = upper.figure.axes[1]
        bottom, top = lower.get_ylim()
        assert np.sum((lower.get_yticks() > bottom) & (lower.get_yticks() < top)) >= 3
    plt.close("all")


def test_heavy_beads_are_filled_and_light_ones_open():
    axes = hc.plot_pulses([hc.propagate(hc.Chain.dimer(0.5, beads=41))])
    assert entry(axes, "light beads").get_markerfacecolor() == "none"
    assert entry(axes, "heavy beads").get_markerfacecolor() != "none"
    curves = {line.get_xdata()[0]: line for line in axes.lines if len(line.get_xdata()) > 2}
    assert curves[2].get_markerfacecolor() == "none"
    assert curves[1].get_markerfacecolor() == curves[1].get_color()
    plt.close(axes.figure)


def test_free_ends_and_heavy_beads_of_several_dimers_have_different_symbols():
    chains = [hc.Chain.dimer(ratio, beads=41) for ratio in (0.3428, 0.5, 0.6)]
    axes = hc.plot_pulses([hc.propagate(chain) for chain in chains])
    assert entry(axes, "last bead (free end)").get_marker() == "*"
    assert entry(axes, "heavy beads").get_marker() == "o"
    curves = [line for line in axes.lines if len(line.get_xdata()) > 2]
    # A plus sign and a cross cannot be filled.
    assert {line.get_marker() for line in curves} == {"o", "s", "^"}
    assert sum(line.get_markerfacecolor() == "none" for line in curves) == 3
    plt.close(axes.figure)

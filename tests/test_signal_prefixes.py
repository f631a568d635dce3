"""Signals of some millivolts are shown in mV, and the panels of defects show small changes."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

import hertzchain as hc
from hertzchain.plotting.defects import _around_largest_change, _limit_to_change
from hertzchain.plotting.shared_axes import same_prefix, use_prefix
from hertzchain.plotting.signals import draw_crest

TIMES = 1e-6 * np.arange(400)
PULSE = np.exp(-(((TIMES - 2e-4) / 2e-5) ** 2))


def volts(peak):
    noise = 1e-3 * peak * np.random.default_rng(1).standard_normal(len(TIMES))
    return hc.Traces.from_arrays(TIMES, {"wall [V]": peak * PULSE + noise})


def shown(axes, value):
    return axes.yaxis.get_major_formatter()(value)


@pytest.mark.parametrize(
    ("peak", "unit", "factor"),
    [(5.0, "V", 1.0), (0.37, "mV", 1e3), (2e-3, "mV", 1e3), (2e-5, "µV", 1e6)],
)
def test_volts_have_the_prefix_of_their_size(peak, unit, factor):
    axes = volts(peak).plot()
    assert axes.get_ylabel() == f"signal [{unit}]"
    axes.figure.draw_without_rendering()
    labels = [text.get_text().replace("\N{MINUS SIGN}", "-") for text in axes.get_yticklabels()]
    assert [float(each) for each in labels] == pytest.approx(factor * axes.get_yticks())
    # The curves remain in V.
    assert axes.lines[0].get_ydata().max() == pytest.approx(peak, rel=0.01)


def test_a_force_drawn_after_millivolts_has_no_prefix():
    axes = volts(0.2).plot()
    balls = hc.Chain.from_materials("5 mm", "brass", beads=8, velocity="1 mm/s")
    run = hc.simulate(balls.replace(right_wall=hc.Wall()), until="1 ms")
    run.plot_forces(["wall"], ax=axes)
    assert axes.get_ylabel() == "force [N]"
    axes.figure.draw_without_rendering()
    assert [float(each.get_text().replace("\N{MINUS SIGN}", "-"))
            for each in axes.get_yticklabels()] == pytest.approx(axes.get_yticks())  # fmt: skip


def test_negative_numbers_with_a_prefix_have_a_minus_sign_and_panels_can_share_it():
    upper, crest = plt.subplots(2)[1]
    upper.set_ylim(-0.2, 0.2)
    upper.set_ylabel("signal [V]")
    use_prefix(upper)
    same_prefix(crest, upper)
    for axes in (upper, crest):
        assert [shown(axes, each) for each in (-0.1, -0.0, 0.05)] == [
            "\N{MINUS SIGN}100",
            "0",
            "50",
        ]


def test_too_few_samples_are_stated_inside_a_narrow_panel():
    signal = volts(0.3).shots[0].signals[0]
    with hc.figure_style("single column"):
        figure, (_, axes) = plt.subplots(1, 2, width_ratios=(2.4, 1.0), layout="constrained")
        draw_crest(axes, TIMES, signal, np.where(np.arange(400) == 200, 0.3, 0.0), "fit")
    figure.draw_without_rendering()
    box, words = axes.get_window_extent(), axes.texts[0].get_window_extent()
    assert box.x0 < words.x0
    assert words.x1 < box.x1


def test_a_small_change_beside_a_pulse_is_visible():
    # The fits differ by 0.01 in 20 samples, and the pulse of height 1 is next to them.
    change = np.zeros(400)
    change[250:270] = 0.01
    core, window = _around_largest_change(change)
    assert core.start < 250 <= 269 < core.stop
    assert window.start < 230
    data = PULSE + change
    _, axes = plt.subplots()
    axes.plot(TIMES, data, label="data")
    _limit_to_change(axes, data[core], (-0.003, 0.013), data[window])
    low, high = axes.get_ylim()
    assert low < 0.0 < 0.01 < high < 0.03
    outside = int(np.sum(data[window] > high))
    assert outside > 0
    assert axes.lines[0].get_label() == f"data ({outside} samples beyond the axes)"


def test_one_false_sample_does_not_set_the_limits_of_a_change():
    data = np.full(500, 0.005)
    data[100] = 1.0
    _, axes = plt.subplots()
    axes.plot(data, label="data")
    _limit_to_change(axes, data, (0.0, 0.01), data)
    assert axes.get_ylim()[1] < 0.02
    assert axes.lines[0].get_label() == "data (1 sample beyond the axes)"

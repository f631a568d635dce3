"""Curves of alternating beads, and small values with a prefix of their unit."""

import matplotlib.pyplot as plt
import numpy as np

import hertzchain as hc


def test_heavy_and_light_beads_are_two_curves():
    pulse = hc.propagate(hc.Chain.dimer(0.3428, beads=41))
    axes = hc.plot_pulses([pulse], "momentum")
    light, heavy = axes.lines[1:3] if len(axes.lines[0].get_xdata()) == 1 else axes.lines[:2]
    np.testing.assert_array_equal(light.get_xdata(), np.arange(2, 41, 2))
    np.testing.assert_array_equal(heavy.get_xdata(), np.arange(1, 40, 2))
    np.testing.assert_array_equal(light.get_ydata(), pulse.momentum[1:40:2])
    assert "light beads" in [each.get_text() for each in axes.get_legend().get_texts()]
    plt.close(axes.figure)


def test_equal_beads_are_one_curve():
    axes = hc.plot_pulses([hc.propagate(hc.Chain.uniform(20))])
    assert "light beads" not in [each.get_text() for each in axes.get_legend().get_texts()]
    plt.close(axes.figure)


def test_small_energies_have_a_prefix():
    balls = hc.Chain.from_materials("5 mm", "steel-52100", beads=20, velocity="0.3 m/s")
    pulse = hc.propagate(balls)
    axes = hc.plot_pulses([pulse], "energy")
    assert axes.get_ylabel() == "kinetic energy $E_k$ [µJ]"
    assert axes.yaxis.get_major_formatter()(1e-4) == "100"
    hc.plot_pulses([pulse], "energy", log=True, ax=axes)
    assert axes.get_ylabel() == "kinetic energy $E_k$ [µJ]"
    assert axes.yaxis.get_major_formatter()(1e-4) == "100"
    plt.close(axes.figure)

"""Axes that several quantities, laws or panels share."""

import matplotlib.pyplot as plt
import pytest
from figure_texts import legend_texts

import hertzchain as hc
from hertzchain.plotting.style import label_log_axis
from hertzchain.plotting.sweep_labels import axis_label, coordinate_text, with_symbols

CHAIN = hc.Chain.tapered("forward-exponential", 0.05, beads=30)
BALLS = hc.Chain.from_materials("5 mm", "brass", beads=12, velocity="1 mm/s")


def test_several_quantities_in_the_same_axes_are_named():
    pulse, axes = hc.propagate(BALLS), plt.subplots()[1]
    pulse.plot("velocity", ax=axes)
    assert axes.get_ylabel() == "velocity $v_k$ [mm/s]"
    assert legend_texts(axes)[0] == "propagation"
    for quantity in ("momentum", "peak_force"):
        pulse.plot(quantity, ax=axes)
    assert legend_texts(axes)[:3] == ["velocity $v_k$", "momentum $P_k$", "largest force $F_k$"]
    assert axes.get_ylabel() == "$v_k$ [m/s], $P_k$ [N s], $F_k$ [N]"
    assert axes.get_xlabel() == "bead or contact $k$"
    # Several methods are named, too; so is a user's own label.
    axes = plt.subplots()[1]
    hc.plot_pulses([hc.propagate(CHAIN), hc.bca(CHAIN)], ax=axes)
    hc.bca(CHAIN).plot("energy", ax=axes)
    hc.bca(CHAIN).plot("momentum", label="mine", ax=axes)
    assert legend_texts(axes)[:4] == [
        "propagation, velocity $v_k$", "BCA, velocity $v_k$", "BCA, kinetic energy $E_k$", "mine"
    ]  # fmt: skip


def test_panels_with_a_common_axis_have_one_label():
    run = hc.simulate(BALLS.replace(right_wall=hc.Wall()), times=200)
    pulse = run.pulse()
    for draw, label in (
        (lambda ax: pulse.plot(ax=ax), "bead $k$"),
        (lambda ax: run.plot_forces([5], ax=ax), "time [µs]"),
        (lambda ax: run.budget().plot(ax=ax), "time [µs]"),
        (lambda ax: run.plot(ax=ax), "time [µs]"),
    ):
        for sharex in (True, False):
            upper, lower = plt.subplots(2, sharex=sharex)[1]
            draw(upper)
            draw(lower)
            shown = [
                each.xaxis.label.get_visible() and each.get_xlabel() for each in (upper, lower)
            ]
            assert [each or "" for each in shown] == ["" if sharex else label, label]


@pytest.mark.parametrize(
    ("limits", "shown"),
    [((0.1, 1.0), "0.1"), ((0.6, 70.0), "10"), ((0.6, 400.0), "100"), ((2e-3, 5e3), "1000"),
     ((1e-7, 1.0), "$\\mathdefault{10^{-1}}$")],
)  # fmt: skip
def test_logarithmic_axes_have_plain_numbers_of_a_usual_size(limits, shown):
    axes = plt.subplots()[1]
    axes.set(yscale="log", ylim=limits)
    label_log_axis(axes.yaxis)
    axes.figure.draw_without_rendering()
    low, high = limits
    ticks = zip(axes.get_yticks(), axes.get_yticklabels(), strict=True)
    found = [text.get_text() for at, text in ticks if low <= at <= high]
    assert shown in found


@pytest.mark.parametrize(
    ("loss", "name", "values", "label"),
    [
        ({"law": "restitution"}, "coefficient", [0.9, 1.0], "coefficient of restitution"),
        ({"law": "elastic-plastic"}, "factor", [1.6, 2.8], "yield pressure / yield strength"),
        ({"law": "viscoelastic"}, "time", ["1 us", "2 us"], "relaxation time [µs]"),
        ({"law": "dashpot"}, "gamma", [0.1, 0.2], r"damping $\gamma$"),
        ({"law": "velocity-power", "gamma": 0.1}, "alpha", [1.2, 1.8],
         r"exponent $\alpha$ of damping"),
        ({"law": "walton-braun"}, "ratio", [0.8, 0.9], "loading / unloading stiffness"),
        ({"law": "unloading-ratio"}, "ratio", [0.1, 0.2], "unloading ratio $w$"),
        ({"law": "elastic-plastic"}, "yield_pressure", ["1 GPa", "2 GPa"], "yield pressure [GPa]"),
        ({"law": "elastic-plastic"}, "yield_overlap", ["1 um", "2 um"], "yield overlap [µm]"),
        ({"law": "viscoelastic", "speed": "1 m/s"}, "restitution", [0.9, 0.95],
         "coefficient of restitution"),
    ],
)  # fmt: skip
def test_axes_of_sweeps_name_parameters_of_losses(loss, name, values, label):
    chain = {
        "taper": "uniform",
        "radius": "5 mm",
        "materials": "brass",
        "beads": 5,
        "loss": loss,
        "velocity": "1 mm/s",
    }
    found = hc.sweep({
        "chain": chain, "axes": {f"loss.{name}": values},
        "sweep": {"methods": ["simulate"], "keep": ["velocity"]},
    })  # fmt: skip
    axis = with_symbols(found.velocity, found).coords[name]
    assert axis_label(axis) == label
    assert coordinate_text(axis[0], name).startswith(label.partition(" [")[0] + " = ")


@pytest.mark.parametrize(
    ("limits", "shown"),
    [
        ((1.2e-4, 1.5e-3), ["0.0002", "0.0005", "0.001"]),
        ((4e-5, 1.5e-3), [r"$\mathdefault{5\times10^{-5}}$", r"$\mathdefault{10^{-4}}$"]),
        ((9e4, 4e5), [r"$\mathdefault{10^{5}}$", r"$\mathdefault{2\times10^{5}}$"]),
        ((0.1, 9e4), ["0.1", "1", "10"]),
    ],
)
def test_a_logarithmic_axis_has_labels_in_one_notation(limits, shown):
    figure, axes = plt.subplots()
    axes.set_yscale("log")
    axes.set_ylim(*limits)
    label_log_axis(axes.yaxis)
    figure.canvas.draw()
    ticks = zip(axes.get_yticks(), axes.get_yticklabels(), strict=True)
    low, high = limits
    found = [label.get_text() for place, label in ticks if low <= place <= high]
    assert found[: len(shown)] == shown
    assert len({"10^" in text for text in found}) == 1
    plt.close(figure)


@pytest.mark.parametrize("name", ["radius", "diameter"])
def test_an_axis_of_sizes_of_small_beads_has_their_name(name):
    found = hc.sweep({
        "chain": {"diameter": "20 mm", "materials": "brass", "beads": 3, "velocity": "1 mm/s"},
        "axes": {f"decorated.{name}": ["2 mm", "4 mm"]},
        "sweep": {"methods": ["propagate"], "keep": ["velocity"]},
    })  # fmt: skip
    assert axis_label(found[name]) == f"{name} of the small beads [mm]"
    half = 0.5 if name == "diameter" else 1.0
    chain = hc.Chain.from_materials(10e-3, "brass", beads=3, velocity=1e-3)
    expected = hc.propagate(chain.decorated(radius=half * 4e-3)).velocity[-1]
    # Sweeps store single values of the last bead with full precision.
    assert found.velocity.sel(approach="propagate").values[1, -1] == pytest.approx(
        expected, rel=1e-12
    )

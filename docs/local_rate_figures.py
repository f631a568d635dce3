"""Figures of the pages on the local-rate law."""

import warnings
from typing import Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import hertzchain as hc
from hertzchain.collision import Array
from hertzchain.plotting.colours import COLOURS
from hertzchain.plotting.free_ends import row_style
from hertzchain.plotting.looks import method_style
from hertzchain.plotting.style import MARKERS, figure_style, label_log_axis, signed
from hertzchain.theory.universal_functions import bca_growth


def law_and_simulation(axes: Axes, law: hc.Pulse, exact: hc.Pulse, i: int, label: str) -> None:
    """Velocities by a law as a line, and by simulation as symbols."""
    shown = slice(None, len(exact.bead) - 3)
    style = {"color": COLOURS[i], "marker": MARKERS[i], "markerfacecolor": "none"}
    axes.plot(law.bead[shown], law.velocity[shown], color=COLOURS[i])
    axes.plot(exact.bead[shown], exact.velocity[shown], linestyle="none", markevery=(3 * i, 12),
              **style)  # fmt: skip
    # The legend has the line and the symbol of each chain.
    axes.plot([], [], label=label, **style)


def label_lines(axes: Axes, **lines: str) -> None:
    """Entries of the legend, in grey, for lines and symbols that all curves share."""
    for name, style in lines.items():
        look = {"linestyle": style}
        if style[0] in MARKERS:
            look = {"linestyle": "none", "markerfacecolor": "none", **row_style(style)}
        axes.plot([], [], color="0.4", label=name.replace("_", " "), **look)


def _growth(rate: float, exponent: float = 1.5) -> float:
    # The last bead but one of steep chains is outside the law.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hc.ModelRangeWarning)
        velocity = hc.local_rate(
            hc.Chain.from_radii(np.exp(rate * np.arange(90)), exponent=exponent)
        ).velocity
    return float(np.log(velocity[80] / velocity[79]))


def _error_and_estimate(chain: hc.Chain) -> tuple[Array, Array]:
    """Relative errors of the velocities from bead 2 on, and their estimates."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hc.ModelRangeWarning)
        law = hc.local_rate(chain)
    assert law.velocity_error is not None
    error = np.abs(law.compare(hc.propagate(chain)).errors("velocity"))
    return error[1:], law.velocity_error[1:]


def local_rate() -> Figure:
    """Velocities in four tapers by the law and the BCA; error of the law and its estimate."""
    tapers = {
        "backward-linear": hc.Chain.tapered("backward-linear", 0.5, beads=100),
        "backward-exponential": hc.Chain.tapered("backward-exponential", 0.02, beads=100),
        "wavy": hc.Chain.from_radii(np.exp(0.5 * np.sin(2.0 * np.pi * np.arange(100) / 60.0))),
        "forward-exponential": hc.Chain.tapered("forward-exponential", 0.01, beads=100),
    }
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.3, 4.2))
        for i, (name, chain) in enumerate(tapers.items()):
            law, exact, bca = hc.local_rate(chain), hc.propagate(chain), hc.bca(chain)
            assert law.velocity_error is not None
            law_and_simulation(left, law, exact, i, name)
            left.plot(bca.bead, bca.velocity, "--", color=COLOURS[i], linewidth=1.0)
            error = np.abs(law.compare(exact).errors("velocity"))
            shown = slice(1, 97)
            right.plot(law.bead[shown], 100.0 * error[shown], color=COLOURS[i])
            right.plot(law.bead[shown], 100.0 * law.velocity_error[shown], "--", color=COLOURS[i])
        label_lines(left, law="-", simulation="o+xs", BCA="--")
        label_lines(right, error="-", estimate="--")
        for axes, what in ((left, "velocity $v_k$"), (right, "error of the velocity [%]")):
            axes.set_yscale("log")
            label_log_axis(axes.yaxis)
            axes.set_xlabel("bead $k$")
            axes.set_ylabel(what)
        left.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)
        right.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)
        right.set_ylim(bottom=3e-4)
    return canvas


def growth_and_memory() -> Figure:
    """Growth on exponential chains in the local-rate law, and memory of a change of the rate."""
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.3, 3.6))
        rates = np.linspace(-0.14, 0.3, 89)
        growth = [_growth(rate) for rate in rates]
        bca_colour = method_style("bca")["color"]
        left.plot(rates, growth, color=COLOURS[0])
        left.plot(rates, bca_growth(rates), "--", color=bca_colour)
        inset = left.inset_axes((0.13, 0.14, 0.42, 0.34))
        inset.plot(rates, bca_growth(rates) - growth, color=bca_colour)
        inset.set_title("BCA \N{MINUS SIGN} exact", fontsize=8, pad=2.0)
        inset.set_ylim(0.0, 0.06)
        inset.tick_params(labelsize=8)
        left.annotate("exact", (-0.13, 0.13), xytext=(0, -18), textcoords="offset points",
                      color=COLOURS[0])  # fmt: skip
        left.annotate("BCA", (-0.11, 0.165), color=bca_colour)
        left.set_xlabel("rate $s$ (change of $\\ln R$ per bead)")
        left.set_ylabel(r"growth per bead $\sigma = \ln(v_{k+1}/v_k)$")
        changed, beads = 60, np.arange(-3, 15)
        for i, rate in enumerate((-0.1, 0.0, 0.1)):
            chain = hc.Chain.from_radii(np.exp(rate * np.arange(100)))
            response = [
                hc.local_rate_gradient(chain, bead=changed + k)[1][changed:].sum() for k in beads
            ]
            right.plot(beads, response, "o-", color=COLOURS[i], label=f"$s$ = {signed(rate)}")
        right.set_xticks(beads[::3])
        right.set_xlabel("bead $k - j$")
        right.set_ylabel(
            "response of the velocity to a\nchange of rate, $\\partial\\ln v_k/\\partial s_j$"
        )
        right.legend(title="rate")
    return canvas


def fast_changes() -> Figure:
    """Velocities in chains with alternating radii; errors as a function of the fast change."""
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.3, 4.2))
        for i, ratio in enumerate((1.0, 0.97, 0.94, 0.9)):
            chain = hc.Chain.from_radii(np.resize([1.0, ratio], 101))
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", hc.ModelRangeWarning)
                law = hc.local_rate(chain)
            exact = hc.propagate(chain)
            # Beads of radius 1 only: the smaller ones are faster.
            left.plot(law.bead[10:97:2], law.velocity[10:97:2], color=COLOURS[i],
                      label=f"1 : {ratio:g}")  # fmt: skip
            left.plot(exact.bead[10:97:8], exact.velocity[10:97:8], MARKERS[i], color=COLOURS[i],
                      markerfacecolor="none")  # fmt: skip
        left.set_xlabel("bead $k$ (radius 1)")
        left.set_ylabel("velocity $v_k$")
        label_lines(left, law="-", simulation="o+xs")
        left.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), title="radii", ncols=3)
        sizes = np.geomspace(1e-3, 0.1, 13)
        uniform = hc.Chain.uniform(100)
        for i, (name, chains) in enumerate({
            "alternating, 1 : (1 \N{MINUS SIGN} x)": [
                hc.Chain.from_radii(np.resize([1.0, 1.0 - x], 100)) for x in sizes
            ],
            "random, standard deviation x": [
                uniform.with_scatter(1, relative=float(x)) for x in sizes[sizes < 0.04]
            ],
        }.items()):  # fmt: skip
            largest = np.array([[part.max() for part in _error_and_estimate(c)] for c in chains])
            x = 100.0 * sizes[: len(chains)]
            right.loglog(x, 100.0 * largest[:, 0], MARKERS[i] + "-", color=COLOURS[i], label=name)
            right.loglog(x, 100.0 * largest[:, 1], "--", color=COLOURS[i])
        label_lines(right, error="-", estimate="--")
        right.axhline(0.5, color="0.4", linewidth=0.8)
        right.annotate("warning", (0.1, 0.5), xytext=(0, 3), textcoords="offset points",
                       color="0.4")  # fmt: skip
        for axis in (right.xaxis, right.yaxis):
            label_log_axis(axis)
        right.set_xlabel("change of the radii x [%]")
        right.set_ylabel("largest error of a velocity [%]")
        right.set_ylim(bottom=3e-4)
        right.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0))
    return canvas


def free_end() -> Figure:
    """Velocities of the last beads by the law; error of the last bead of short chains."""
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.3, 3.8))
        for i, rate in enumerate((-0.05, 0.0, 0.05)):
            chain = hc.Chain.from_radii(np.exp(rate * np.arange(60)))
            law, exact = hc.local_rate(chain), hc.propagate(chain)
            last = slice(-6, None)
            infinite = _growth(rate)
            for pulse, style in ((law, {}), (exact, {"linestyle": "", "marker": MARKERS[i]})):
                growth = np.exp(np.diff(np.log(pulse.velocity)) - infinite)
                left.plot(pulse.bead[last] - 60, growth[last], color=COLOURS[i],
                          markerfacecolor="none", label=None if style else f"$s$ = {signed(rate)}",
                          **style)  # fmt: skip
        left.set_xlabel("bead, counted from the last one: $k - N$")
        left.set_ylabel("growth relative to a long chain,\n$v_k\\,/\\,(e^{\\sigma(s)}\\,v_{k-1})$")
        label_lines(left, law="-", simulation="o+x")
        left.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, title="rate")
        beads = np.arange(9, 41)
        for i, exponent in enumerate((1.5, 1.6)):
            errors = [
                _error_and_estimate(
                    hc.Chain.from_radii(np.exp(-0.03 * np.arange(n)), exponent=exponent)
                )
                for n in beads
            ]
            error, estimate = 100.0 * np.array([[e[-1], d[-1]] for e, d in errors]).T
            right.semilogy(beads, error, MARKERS[i] + "-", color=COLOURS[i],
                           label=f"$p$ = {exponent:g}")  # fmt: skip
            right.semilogy(beads, estimate, "--", color=COLOURS[i])
        label_log_axis(right.yaxis)
        right.set_xlabel("number of beads")
        right.set_ylabel("error of the last bead [%]")
        label_lines(right, error="-", estimate="--")
        right.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, title="exponent")
    return canvas


def law_errors() -> Figure:
    """Largest error and largest estimate of random chains of three kinds."""
    rng = np.random.default_rng(11)
    with figure_style():
        canvas, axes = plt.subplots(figsize=(7.0, 4.2))
        for i, (name, scatter) in enumerate(
            {"smooth": 0.0, "scatter 0.3%": 0.003, "scatter 1%": 0.01}.items()
        ):
            found = []
            for _ in range(60):
                x = np.linspace(0.0, 1.0, 80)
                waves = rng.normal(size=3) @ np.sin(np.outer([1.0, 2.0, 3.0], np.pi * x))
                radii = np.exp(rng.uniform(-1.5, 2.5) * x + 0.2 * waves)
                radii *= np.exp(scatter * rng.normal(size=80))
                error, estimate = _error_and_estimate(hc.Chain.from_radii(radii))
                found.append((100.0 * estimate.max(), 100.0 * error.max()))
            axes.loglog(*np.array(found).T, MARKERS[i], color=COLOURS[i], markerfacecolor="none",
                        label=name)  # fmt: skip
        axes.axline((0.01, 0.01), (0.1, 0.1), color="0.4", linewidth=0.8, label="error = estimate")
        axes.axvline(0.5, color="0.4", linewidth=0.8, linestyle=":", label="warning")
        for axis in (axes.xaxis, axes.yaxis):
            label_log_axis(axis)
        axes.set_xlabel("largest estimate of a chain [%]")
        axes.set_ylabel("largest error of its velocities [%]")
        axes.legend()
    return canvas


def exponents_of_the_law() -> Figure:
    """Growth per bead on exponential chains, for exponents from 1.25 to 3, and by the BCA."""
    with figure_style():
        canvas, axes = plt.subplots(figsize=(7.0, 3.6))
        for i, p in enumerate((1.25, 1.4, 1.5, 2.0, 3.0)):
            lowest = -0.165 if p in (1.5, 2.0) else -0.165 * np.tanh((p - 1.15) / 0.32)
            rates = np.linspace(max(lowest, -0.12), 0.3, 60)
            growth = np.array([_growth(rate, p) for rate in rates])
            axes.plot(rates, bca_growth(rates) - growth, color=COLOURS[i], label=f"$p$ = {p:g}")
        axes.set_xlabel("rate $s$ (change of $\\ln R$ per bead)")
        axes.set_ylabel("growth $\\sigma$ per bead: BCA \N{MINUS SIGN} exact")
        axes.legend(title="exponent")
    return canvas


LOCAL_RATE_FIGURES: Final = (
    local_rate, growth_and_memory, fast_changes, free_end, law_errors, exponents_of_the_law,
)  # fmt: skip

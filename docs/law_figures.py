"""Figures of the pages on laws of the pulse, on gradients, on extensions and on other programs."""

import re
import warnings
from pathlib import Path
from typing import Final

import matplotlib.pyplot as plt
import numpy as np
from local_rate_figures import label_lines, law_and_simulation
from matplotlib.figure import Figure
from scipy.integrate import solve_ivp

import hertzchain as hc
from hertzchain.plotting.colours import COLOURS
from hertzchain.plotting.style import MARKERS, figure_style, label_log_axis

PAGES: Final = Path(__file__).parent


def steps() -> Figure:
    """Velocities in chains with one step in the radius."""
    with figure_style():
        canvas, axes = plt.subplots(figsize=(7.0, 3.6))
        for i, factor in enumerate((0.5, 0.8, 1.25, 2.0)):
            chain = hc.Chain.from_radii(np.where(np.arange(100) >= 40, factor, 1.0))
            law, exact = hc.piecewise_local_rate(chain), hc.propagate(chain)
            law_and_simulation(axes, law, exact, i, f"$f$ = {factor:g}")
        axes.set_yscale("log")
        label_log_axis(axes.yaxis)
        axes.set_xlabel("bead $k$")
        axes.set_ylabel("velocity $v_k$")
        label_lines(axes, law="-", simulation="o+xs")
        axes.legend(loc="lower left", ncols=2, title="step of the radius by the factor $f$")
    return canvas


def strikers() -> Figure:
    """Velocities ahead of strikers of several masses, and the waves of heavy ones."""
    ratio = r"mass of the striker / mass of a bead, $\mu$"
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.3, 3.6))
        for i, mass in enumerate((0.25, 1.0, 4.0)):
            chain = hc.Chain.uniform(80).struck_by(mass=mass, radius=1.0)
            law, exact = hc.local_rate(chain), hc.propagate(chain)
            law_and_simulation(left, law, exact, i, rf"$\mu$ = {mass:g}")
        left.set_xlabel("bead $k$")
        left.set_ylabel("velocity $v_k$")
        left.set_xlim(1.0, 45.0)
        label_lines(left, law="-", simulation="o+x")
        left.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, title=ratio)
        wave = hc.solitary_wave()
        momentum, energy = wave.momentum_constant, wave.energy_constant
        particle = momentum**2 / (2.0 * energy)
        # The mass of both panels has the same colour.
        for i, mass in ((3, 2.0), (2, 4.0), (4, 8.0)):
            train = hc.striker_train(mass)
            number = np.arange(1, len(train) + 1)
            first = momentum / (2.0 * energy) * 2.0 * mass / (mass + particle)
            formula = first * ((mass - particle) / (mass + particle)) ** (number - 1)
            right.semilogy(number, formula, color=COLOURS[i], linewidth=0.8)
            right.semilogy(number, train, MARKERS[i], color=COLOURS[i], label=rf"$\mu$ = {mass:g}")
        right.set_xlabel("wave $n$ of the train")
        right.set_ylabel("peak velocity")
        right.set_xticks(range(1, 11))
        label_lines(right, formula="-")
        right.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, title=ratio)
    return canvas


def disorder() -> Figure:
    """Velocities in chains with random radii: single chains, and the law of their mean."""
    chain, scatter = hc.Chain.uniform(110), 0.01
    table = hc.propagate_many([chain.with_scatter(seed, relative=scatter) for seed in range(100)])
    law = hc.disorder(chain, scatter)
    spread = law.velocity_spread
    assert spread is not None
    with figure_style():
        canvas, axes = plt.subplots(figsize=(7.0, 3.6))
        shown = slice(5, 105)
        axes.plot(law.bead[shown], table.velocity[:, shown].T, color="0.75", linewidth=0.5)
        axes.plot([], [], color="0.75", label="100 random chains")
        axes.plot(law.bead[shown], law.velocity[shown], color=COLOURS[1], linewidth=1.6,
                  label="law, mean")  # fmt: skip
        for sign, label in ((-1.0, "law, mean ± standard deviation"), (1.0, None)):
            axes.plot(law.bead[shown], (law.velocity * np.exp(sign * spread))[shown], "--",
                      color=COLOURS[1], label=label)  # fmt: skip
        axes.axhline(hc.propagate(chain).velocity[80], color="black", linestyle=":",
                     label="equal beads")  # fmt: skip
        axes.set_xlabel("bead $k$")
        axes.set_ylabel("velocity $v_k$")
        axes.set_ylim(0.612, 0.722)
        axes.legend(loc="lower left", ncols=2)
    return canvas


def attenuation() -> Figure:
    """Velocities along equal beads with a small loss, by `attenuation` and by simulation."""
    laws = (hc.Restitution(0.99), hc.Viscoelastic(2e-3), hc.Dashpot(2e-3))
    with figure_style():
        canvas, axes = plt.subplots(figsize=(7.0, 3.6))
        for i, law in enumerate(laws):
            chain = hc.Chain.uniform(100).replace(loss=law)
            velocity = hc.simulate(chain, times=0).pulse().velocity
            theory = [velocity[9]]
            for _ in range(10, 95):
                theory.append(theory[-1] * np.exp(-hc.attenuation(chain, theory[-1])))
            bead = np.arange(10, 96)
            name = type(law).__name__
            axes.plot(bead, theory, color=COLOURS[i], label=f"{name}, attenuation")
            axes.plot(bead, velocity[9:95], MARKERS[i], color=COLOURS[i], markerfacecolor="none",
                      markevery=(3 * i, 8), label=f"{name}, simulation")  # fmt: skip
        axes.set_xlabel("bead $k$")
        axes.set_ylabel("velocity $v_k$")
        axes.legend()
    return canvas


def lossy_law() -> Figure:
    """Velocities along tapers with loss, and a pulse that its tail overtakes."""
    k = np.arange(100)
    tapers = {
        "backward, restitution": (1 + 0.03 * k, hc.Restitution(0.95)),
        "equal beads, unloading ratio": (1 + 0.0 * k, hc.UnloadingRatio(0.05)),
        "forward, viscoelastic": (1 - 0.007 * k, hc.Viscoelastic(0.01)),
    }
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.3, 3.9))
        for i, (name, (radii, loss)) in enumerate(tapers.items()):
            chain = hc.Chain.from_radii(radii).replace(loss=loss)
            exact = hc.simulate(chain, times=0).pulse()
            law_and_simulation(left, hc.local_rate(chain), exact, i, name)
        rates = 0.045 * np.tanh((np.arange(110) - 55) / 12)
        turning = np.exp(np.concatenate(([0.0], np.cumsum(rates))))
        for i, loss in enumerate((hc.UnloadingRatio(0.05), hc.UnloadingRatio(0.1)), start=3):
            chain = hc.Chain.from_radii(turning).replace(loss=loss)
            exact, law = hc.simulate(chain, times=0).pulse(), _longest(turning, loss)
            right.plot(law.bead[:-3], law.velocity[:-3], color=COLOURS[i],
                       label=f"unloading ratio {loss.ratio:g}")  # fmt: skip
            right.plot(exact.bead, exact.velocity, MARKERS[i], color=COLOURS[i],
                       markerfacecolor="none", markevery=(3 * i, 8))  # fmt: skip
        for axes in (left, right):
            axes.set_yscale("log")
            label_log_axis(axes.yaxis)
            axes.set_xlabel("bead $k$")
            axes.set_ylabel("velocity $v_k$")
            if axes is right:
                label_lines(axes, law="-", simulation="s^")
            # Above the axes, where no curve is.
            axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=1 + (axes is right))
    return canvas


def _longest(radii: np.ndarray, loss: hc.Restitution | hc.UnloadingRatio) -> hc.Pulse:
    """The law for the longest part of a chain for which it holds."""
    for beads in range(len(radii), 50, -1):
        chain = hc.Chain.from_radii(radii[:beads]).replace(loss=loss)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", hc.ModelRangeWarning)
            try:
                return hc.local_rate(chain)
            except hc.InputError:
                continue
    raise RuntimeError("the tail overtakes the pulse too early")


def gradients() -> Figure:
    """Gradients of a force on a wall, compared with differences of simulations."""
    chain = hc.Chain.tapered("forward-exponential", 0.05, beads=20).replace(right_wall=hc.Wall())
    peak, slope = hc.gradient(chain, "wall_force.peak", to=("radii", "gaps"))
    beads = np.arange(2, 21)
    differences = []
    for k in beads:
        forces = []
        for sign in (-1.0, 1.0):
            radii = chain.radii.copy()
            radii[k - 1] *= 1.0 + sign * 1e-4
            changed = hc.Chain.from_radii(radii).replace(right_wall=hc.Wall())
            forces.append(hc.simulate(changed).wall_force().peak)
        differences.append((forces[1] - forces[0]) / (2e-4 * chain.radii[k - 1]))
    contact, steps_of_gap = 10, np.logspace(-6, -3, 7)
    errors = []
    for step in steps_of_gap:
        gaps = np.zeros(19)
        gaps[contact - 1] = step
        change = hc.simulate(chain.replace(gaps=gaps)).wall_force().peak - peak
        errors.append(abs(change / step / slope["gaps"][contact - 1] - 1.0))
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.3, 3.2))
        left.plot(beads, slope["radii"][1:], "o", color=COLOURS[1], markerfacecolor="none",
                  markersize=7, label="gradient")  # fmt: skip
        left.plot(beads, differences, "x", color=COLOURS[2], label="central differences")
        left.set_xlabel("bead $k$")
        left.set_ylabel("change of the force with\na radius, $\\partial F/\\partial R_k$")
        left.set_xticks(range(2, 21, 3))
        left.legend()
        right.loglog(steps_of_gap, errors, "o-", color=COLOURS[2])
        right.loglog(steps_of_gap, errors[2] * np.sqrt(steps_of_gap / steps_of_gap[2]), "--",
                     color="0.5", label=r"proportional to $\sqrt{\varepsilon}$")  # fmt: skip
        right.set_xlabel(rf"gap $\varepsilon$ at contact {contact}")
        right.set_ylabel("relative deviation of the\ndifference quotient")
        right.legend()
    return canvas


def extend() -> Figure:
    """Results of the recipes of the page: a taper, a theory, a loss law and a plot."""
    chain = hc.Chain.from_radii((1.0 + np.arange(30) / 10.0) ** -0.5)
    exact = hc.propagate(chain)
    run = hc.simulate(hc.Chain.uniform(10), times=np.linspace(0.0, 20.0, 400))
    with figure_style():
        canvas, panels = plt.subplot_mosaic("aaa;bcd", figsize=(7.4, 3.8), height_ratios=(1.0, 2.4))
        hc.plot_chain(chain, ax=panels["a"])
        panels["a"].set_title("")
        panels["a"].set_title("a taper: a power law of 30 beads", loc="left")
        panels["a"].set_axis_off()
        # The last bead leaves the free end, and is no part of the curve.
        panels["b"].plot(exact.bead[:-1], exact.velocity[:-1], color=COLOURS[0], label="simulation")
        panels["b"].plot(exact.bead[:-1], chain.masses[:-1] ** -0.5, "--", color=COLOURS[1],
                         label="energy kept")  # fmt: skip
        panels["b"].set(title="a theory", xlabel="bead $k$", ylabel="velocity $v_k$")
        for i, gamma in enumerate((0.0, 0.2, 1.0)):
            overlap, force = _collision(gamma)
            panels["c"].plot(overlap, force, color=COLOURS[i], label=rf"$\gamma$ = {gamma:g}")
        panels["c"].set(title="a loss law", xlabel="overlap $d$", ylabel="force $F$")
        panels["d"].plot(run.positions[:, 4], run.velocities[:, 4], color=COLOURS[3])
        panels["d"].set(title="a plot", xlabel="position $x_5$", ylabel="velocity $v_5$")
        for name in "bc":
            panels[name].legend()
    return canvas


def _collision(gamma: float) -> tuple[np.ndarray, np.ndarray]:
    """Overlap and force of two equal beads that collide, with F = d^(3/2) + gamma d d'."""

    def force(overlap: np.ndarray, rate: np.ndarray) -> np.ndarray:
        return np.maximum(overlap, 0.0) ** 1.5 + gamma * np.maximum(overlap, 0.0) * rate

    def separated(_: float, state: np.ndarray) -> float:
        return float(state[0])

    separated.terminal, separated.direction = True, -1.0  # type: ignore[attr-defined]
    solution = solve_ivp(lambda _, s: [s[1], -2.0 * force(s[0], s[1])], (0.0, 20.0), [1e-12, 1.0],
                         events=separated, rtol=1e-9, atol=1e-12, max_step=0.02)  # fmt: skip
    return solution.y[0], force(*solution.y)


def how_fast() -> Figure:
    """Ratios of computing times, from the table of the page."""
    page = (PAGES / "explanation" / "how_fast.md").read_text("utf-8")
    cells = [line.strip("| ").split(" | ") for line in page.splitlines() if line.startswith("| ")]
    rows = [(each[0], *(name.split(": ")[0].replace("`", "") for name in each[1:3]), float(each[3]))
            for each in cells[1:] if len(each) == 4]  # fmt: skip
    # The page states the method of SciPy; long labels would make the letters small.
    rows = [(*each[:2], each[2].replace(" DOP853, numba", ""), each[3]) for each in rows]
    assert len(rows) > 10
    with figure_style():
        canvas, axes = plt.subplots(figsize=(8.4, 0.29 * len(rows) + 0.8))
        for place, (_, ours, other, ratio) in enumerate(rows):
            colour = COLOURS[0] if ratio >= 1.0 else COLOURS[1]
            axes.plot([1.0, ratio], [place, place], color=colour, linewidth=2.0)
            axes.plot(ratio, place, "o", color=colour)
            axes.annotate(
                f"{ours} vs {other}", (max(ratio, 1.0), place), (6, 0),
                textcoords="offset points", va="center", fontsize=8.5,
            )  # fmt: skip
        for colour, name in ((COLOURS[0], "hertzchain is faster"),
                             (COLOURS[1], "the other program is faster")):  # fmt: skip
            axes.plot([], [], "o-", color=colour, linewidth=2.0, label=name)
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)
        axes.axvline(1.0, color="0.4", linewidth=0.8)
        axes.set_xscale("log")
        # The labels need the space beyond the largest ratio.
        axes.set_xlim(0.1, 3e6)
        axes.set_xticks([0.1, 1, 10, 100, 1000, 10000], ["0.1", "1", "10", "100", "1000", "10000"])
        axes.minorticks_off()
        axes.set_yticks(range(len(rows)), [row[0] for row in rows], fontsize=8.5)
        axes.invert_yaxis()
        axes.set_xlabel("time of the other program / time of hertzchain")
    return canvas


def against_others() -> Figure:
    """Error and time of each program, from the table of the page."""
    page = (PAGES / "explanation" / "against_others.md").read_text("utf-8")
    rows = re.findall(r"^\| (.+?) \| (\de-\d+) \| (\d+)(?: \(a\))? \|$", page, re.M)
    assert len(rows) == 8
    kinds = {"`propagate`": "hertzchain, propagate", "`simulate`": "hertzchain, simulate",
             "SciPy": "SciPy DOP853", "Verlet": "Verlet script", "LAMMPS": "LAMMPS"}  # fmt: skip
    with figure_style():
        canvas, axes = plt.subplots(figsize=(7.3, 3.8))
        for i, (key, name) in enumerate(kinds.items()):
            times, errors = np.array(
                [(float(time), float(error)) for row, error, time in rows if key in row]
            ).T
            axes.loglog(times, errors, MARKERS[i] + "-", color=COLOURS[i], markersize=6)
            settings = [re.search(r"(rtol|step) \S+", row) for row, *_ in rows if key in row]
            # Where they cover neither lines nor each other.
            side = -1 if key == "Verlet" else 1
            for time, error, setting in zip(times, errors, settings, strict=True):
                label = f"{name}, {setting[0]}" if setting else name
                axes.annotate(label, (time, error), xytext=(7 * side, 5 if key == "LAMMPS" else 0),
                              textcoords="offset points", va="center", color=COLOURS[i],
                              ha="left" if side > 0 else "right")  # fmt: skip
        axes.set_xlabel("computing time, relative to propagate")
        axes.set_ylabel("largest error of a velocity")
        # The labels need the space beyond the longest time.
        axes.set_xlim(0.7, 1e4)
        label_log_axis(axes.xaxis)
    return canvas


LAW_FIGURES: Final = (
    steps, strikers, disorder, attenuation, lossy_law, gradients, extend, how_fast,
    against_others,
)  # fmt: skip

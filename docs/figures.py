"""Draw the figures of the documentation during its build, which keeps them current."""

from collections.abc import Callable
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from experiment_figures import EXPERIMENT_FIGURES
from howto_figures import HOWTO_FIGURES
from law_figures import LAW_FIGURES
from local_rate_figures import LOCAL_RATE_FIGURES
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from page_figures import PAGE_FIGURES
from paper_figures import PAPER_FIGURES

import hertzchain as hc
from hertzchain.evaluation.evaluate import scoreboard
from hertzchain.paper.figures import reproduce_figure
from hertzchain.paper.listed_errata import errata_chains
from hertzchain.paper.reproduction import integrate_chains
from hertzchain.paper.velocity_formulas import draw_formula_errors
from hertzchain.plotting.colours import COLOURS
from hertzchain.plotting.pulses import plot_pulses
from hertzchain.plotting.scoreboard import plot_scoreboard
from hertzchain.plotting.style import (
    figure_bytes,
    figure_style,
    label_log_axis,
    label_right_ends,
    mark_horizon,
)
from hertzchain.plotting.sweeps import plot_sweep


def first_pulse() -> Figure:
    """Plot of the tutorial."""
    chain = hc.Chain.tapered("backward-exponential", 0.05, beads=60)
    canvas = plot_pulses([hc.propagate(chain), hc.bca(chain)], log=True).figure
    assert isinstance(canvas, Figure)
    return canvas


def first_force() -> Figure:
    """Forces in steel balls and on a wall, as in the first tutorial."""
    balls = hc.Chain.from_materials("6 mm", "steel-52100", beads=12)
    chain = balls.struck_by(velocity="0.1 m/s").replace(right_wall=hc.Wall())
    run = hc.simulate(chain, times=400)
    with figure_style():
        canvas, axes = plt.subplots(figsize=(7.0, 3.6))
        run.plot_forces(["ball 3", "ball 6", "ball 9", "wall"], ax=axes)
    return canvas


def force_trace() -> Figure:
    """Forces at sensors in a chain of steel balls in front of a wall."""
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=20)
    struck = chain.struck_by(velocity=0.3).replace(right_wall=hc.Wall(), loss=hc.Restitution(0.97))
    run = hc.simulate(struck, until=700e-6, times=1401)
    with figure_style():
        canvas, axes = plt.subplots(figsize=(7.0, 3.6))
        run.plot_forces(["ball 5", "ball 10", "ball 15", "wall"], ax=axes)
    return canvas


def budget() -> Figure:
    """Energy and momentum of a forward taper in front of a wall."""
    chain = hc.Chain.tapered("forward-exponential", 0.05, beads=20).replace(right_wall=hc.Wall())
    found = hc.simulate(chain, until=60.0, times=600).budget()
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.3, 3.9), layout="constrained")
        found.plot("energy", legend=False, ax=left)
        found.plot("momentum", legend=False, ax=right)
        # Both panels share one legend, although not all parts occur in both.  The caption states
        # that the energies of the pulse are kinetic.
        shown = {
            label.removesuffix(" (kinetic)"): handle
            for axes in (left, right)
            for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
        }
        # The energy in the contact with the wall, and the momentum that it receives.
        shown["wall"] = shown.pop("walls")
        del shown["right wall"]
        shown["total input"] = shown.pop("total input")
        left.set_title("")
        right.set_title("")
        canvas.legend(shown.values(), shown.keys(), loc="outside lower center", ncols=4)
    return canvas


def waves() -> Figure:
    """A wave train and its reflection from a wall: forces as a map, and tracks of the waves."""
    masses = np.append(4.0, np.ones(49))
    chain = hc.Chain.uniform(50).replace(masses=masses, right_wall=hc.Wall.rigid())
    run = hc.simulate(chain, until=65.0, times=1040)
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.0), sharey=True)
        run.plot("force", ax=right)
        run.waves().plot(ax=left)
        left.set_xlim(right.get_xlim())
        for axes in (left, right):
            axes.set_title("")
        right.set_ylabel("")
    return canvas


def horizon() -> Figure:
    """A pulse between two walls: estimated and true error, and a velocity for two tolerances."""
    wall = hc.Wall(stiffness=np.sqrt(2.0))
    chain = hc.Chain.uniform(100).replace(left_wall=wall, right_wall=wall)
    times = np.linspace(0.0, 700.0, 2801)
    run, tight = (hc.simulate(chain, times=times, rtol=rtol) for rtol in (1e-13, 1e-14))
    found = run.horizon()
    true = np.abs(run.velocities - tight.velocities).max(axis=1) / np.abs(run.velocities).max()
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.3, 3.9))
        left.semilogy(times[1:], found.error[1:], color=COLOURS[1], label="estimated error")
        left.semilogy(times[1:], true[1:], color=COLOURS[0], linewidth=0.8,
                      label="difference from rtol = 1e-14")  # fmt: skip
        left.axhline(found.within, color="0.5", linewidth=0.8)
        left.annotate("1%", (0.0, found.within), (0, 3), textcoords="offset points", color="0.4")
        left.set_ylim(1e-15, 10.0)
        right.plot(times, run.velocity(50), color=COLOURS[1], label="bead 50, rtol = 1e-13")
        right.plot(times, tight.velocity(50), "--", color=COLOURS[2], label="bead 50, rtol = 1e-14")
        right.set_xlim(430.0, 700.0)
        for axes in (left, right):
            mark_horizon(axes, found, 1.0)
            axes.set_xlabel("time $t$")
            axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0))
        left.set_ylabel("error / largest velocity")
        right.set_ylabel("velocity $v_{50}$")
        right.set_ylim(-0.8, 0.8)
    return canvas


def moments() -> Figure:
    """Peaks and arrivals on the velocities of a few beads."""
    chain = hc.Chain.tapered("backward-exponential", 0.3, beads=8)
    run = hc.simulate(chain, until=9.0, times=2000)
    pulse = hc.propagate(chain)
    assert pulse.peak_time is not None
    assert pulse.arrival is not None
    with figure_style():
        canvas, axes = plt.subplots(figsize=(6.4, 3.6))
        for i in range(4):
            colour = COLOURS[i]
            axes.plot(run.times, run.velocities[:, i], color=colour, linewidth=1.1)
            if i > 0:
                peak = pulse.peak_time[i], pulse.velocity[i]
                crossing = np.interp(pulse.arrival[i], run.times, run.velocities[:, i])
                axes.plot(*peak, "o", color=colour, markersize=6)
                axes.plot(pulse.arrival[i], crossing, "x", color="black", markersize=8)
                axes.annotate(f"$v_{i + 1}$", peak, xytext=(5, 4), textcoords="offset points",
                              color=colour)  # fmt: skip
        axes.annotate("$v_1$", (0.62, 0.9), xytext=(4, 2), textcoords="offset points")
        axes.annotate("$v_4$", (8.4, 0.09), xytext=(0, 6), textcoords="offset points",
                      color=COLOURS[3])  # fmt: skip
        axes.plot([], [], "o", color="0.4", label="first maximum: velocity, peak_time")
        axes.plot([], [], "x", color="black", label="crossing: arrival")
        axes.axhline(0.0, color="0.7", linewidth=0.6)
        axes.set_xlim(0.0, 9.0)
        axes.set_xlabel("time $t$")
        axes.set_ylabel("velocity $v_k(t)$")
        axes.legend(loc="upper right")
    return canvas


def figure12() -> Figure:
    """Figure 12 of the paper, recomputed, and the error of the theory."""
    curves = reproduce_figure("figure12").curves
    colours = plt.colormaps["viridis"](np.linspace(0, 0.72, len(curves)))
    shown, window = slice(1, 90, 4), slice(4, 90)
    with figure_style():
        canvas, (upper, lower) = plt.subplots(2, 1, figsize=(6.4, 7.0), sharex=True)
        for axes, what in ((upper, "velocity"), (lower, "error")):
            ends = []
            for curve, colour in zip(curves, colours, strict=True):
                exact, theory = curve.integration.velocity, curve.theory.velocity
                error = 100.0 * (theory / exact - 1.0)
                if what == "velocity":
                    axes.semilogy(curve.k[shown], exact[shown], "o", color=colour,
                                  markerfacecolor="none")  # fmt: skip
                    axes.semilogy(curve.k[shown], theory[shown], "+", color=colour, markersize=5)
                else:
                    axes.plot(curve.k[window], error[window], color=colour)
                last = float(exact[89] if what == "velocity" else error[89])
                ends.append((90.0, last, f"$q$ = {curve.rate:g}", to_hex(colour)))
            axes.set_xlim(0.0, 91.0)
            label_right_ends(axes, ends)
        upper.plot([], [], "o", color="0.25", markerfacecolor="none", label="simulation")
        upper.plot([], [], "+", color="0.25", markersize=5, label="modified BCA, recalibrated")
        upper.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)
        label_log_axis(upper.yaxis)
        upper.set_ylabel("velocity $v_k$")
        lower.axhline(0.0, color="0.7", linewidth=0.6, zorder=0)
        lower.set_ylabel("error of the\nmodified BCA [%]")
        lower.set_xlabel("bead $k$")
    return canvas


def formula_errors() -> Figure:
    """Errors of the paper's velocity formulas, as printed and as corrected."""
    return draw_formula_errors(integrate_chains(errata_chains()))


def scores() -> Figure:
    """Scoreboard of all theories on all families of chains."""
    canvas = plot_scoreboard(scoreboard()).figure
    assert isinstance(canvas, Figure)
    return canvas


def sweep() -> Figure:
    """Momentum as a function of taper and length, and range of validity of the local-rate law."""
    families = {
        "backward-linear": (0.05, 1.5), "backward-exponential": (0.01, 0.4),
        "forward-linear": (0.0005, 0.0094), "forward-exponential": (0.005, 0.2),
    }  # fmt: skip
    with figure_style():
        canvas, grid = plt.subplots(2, 2, figsize=(7.4, 5.6), layout="constrained")
        for axes, (taper, (low, high)) in zip(grid.flat, families.items(), strict=True):
            found = hc.sweep({
                "chain": {"taper": taper},
                "axes": {"rate": {"linspace": [low, high, 60]}, "beads": list(range(20, 101, 3))},
                "sweep": {"methods": ["propagate", "local-rate"], "keep": ["momentum"],
                          "at": "last", "errors": ["velocity"]},
            })  # fmt: skip
            plot_sweep(found, "momentum", approach="propagate", log=True, ax=axes)
            error = found.worst_error_of_velocity.sel(approach="local-rate").T
            if (error > 0.01).any():
                place = found.rate, found.beads, error
                with plt.rc_context({"hatch.color": "white", "hatch.linewidth": 1.2}):
                    axes.contourf(*place, levels=[0.01, np.inf], colors="none", hatches=["//"])
                axes.contour(*place, levels=[0.01], colors="white", linewidths=1.2)
            axes.set_xlabel("taper rate " + ("$S$" if taper.endswith("linear") else "$q$"))
            axes.set_ylabel("beads $N$")
            axes.set_title(taper)
            axes.xaxis.set_major_locator(MaxNLocator(4))
        beyond = Patch(facecolor="0.4", edgecolor="white", hatch="//",
                       label="error of the local-rate law above 1%")  # fmt: skip
        canvas.legend(handles=[beyond], loc="outside lower center")
    return canvas


def fit_before() -> Figure:
    """Data of the example, and the simulation with nominal values."""
    traces, chain_file = hc.example_experiment()
    return hc.simulate(hc.load_chain(chain_file), until=600e-6, times=1201).compare(traces).plot()


def fit_result() -> Figure:
    """Data, fit and residuals of the example."""
    return hc.fit(*hc.example_experiment()).plot()


def fit_correlations() -> Figure:
    """Correlations of the parameters of the example."""
    return hc.fit(*hc.example_experiment()).plot_correlations()


def fit_causes() -> Figure:
    """Residuals of one sensor for four causes that a fit does not include."""
    balls = hc.Chain.from_materials("5 mm", "steel-52100", beads=15).struck_by(velocity=0.25)
    chain = balls.replace(right_wall=hc.Wall(), loss=hc.Viscoelastic(6e-7))
    gaps = np.zeros(15)
    gaps[8] = 0.5e-6
    # The forces at an overlap of 2 um do not depend on the exponent.
    factor = 2e-6**0.05
    softer = chain.replace(
        exponent=1.45, stiffness=factor * chain.stiffness,
        right_wall=hc.Wall(factor * chain.wall_stiffness[1]),
    )  # fmt: skip
    causes = {
        "offset of 0.6 N": (chain, 0.6, 1.0), "gain of 1.02": (chain, 0.0, 1.02),
        "gap of 0.5 µm between balls 8 and 9": (chain.replace(gaps=gaps), 0.0, 1.0),
        "exponent 1.45 instead of 1.5": (softer, 0.0, 1.0),
    }  # fmt: skip
    free = ["stiffness", "loss.time", "struck_by.velocity", "time_offset"]
    with figure_style():
        canvas, panels = plt.subplots(2, 2, figsize=(8.0, 4.6), sharex=True, layout="constrained")
        for axes, (title, (true, offset, gain)) in zip(panels.flat, causes.items(), strict=True):
            result = hc.fit(_three_sensors(true, offset, gain), chain, free=free)
            _, _, residuals = result.residuals()[1]
            axes.plot(1e6 * result.traces.shots[0].times, residuals, ".", color="0.35",
                      markersize=2.0)  # fmt: skip
            axes.axhline(0.0, color="black", linewidth=0.6)
            axes.set_title(title)
            axes.margins(x=0.0)
        for axes in panels[1]:
            axes.set_xlabel("time [µs]")
        for axes in panels[:, 0]:
            axes.set_ylabel("residual of ball 10 / noise")
    return canvas


def fit_defects() -> Figure:
    """Chi-squared with an odd ball or a gap at each place, of a chain whose ball 8 is smaller."""

    def row(diameters: list[float]) -> hc.Chain:
        balls = hc.Chain.from_materials(0.5e-3 * np.array(diameters), "steel-52100")
        struck = balls.struck_by(velocity="0.3 m/s").replace(loss=hc.Viscoelastic("0.6 us"))
        return struck.replace(right_wall=hc.Wall())

    run = hc.simulate(row([10.0] * 7 + [9.7] + [10.0] * 4), times=1e-6 * np.arange(400))
    noise = 0.1 * np.random.default_rng(1).standard_normal((2, 500))
    ball, wall = np.pad([run.sensor("ball 4"), run.sensor("wall")], ((0, 0), (100, 0))) + noise
    traces = hc.Traces.from_arrays(1e-6 * np.arange(500), {"ball 4 [N]": ball, "wall [N]": wall})
    equal = hc.fit(traces, row([10.0] * 12), free=["stiffness", "loss.time", "time_offset"])
    balls, gaps = hc.scan_defects(equal, "bead"), hc.scan_defects(equal, "gap")
    return gaps.plot(ax=balls.plot()).get_figure(root=True)


def _three_sensors(chain: hc.Chain, offset: float, gain: float) -> hc.Traces:
    """Synthetic traces; ball 10 has an offset and a gain."""
    run = hc.simulate(chain, times=np.arange(0.0, 7e-4, 1e-6))
    forces = {
        "ball 5 [N]": run.sensor("ball 5"), "ball 10 [N]": gain * run.sensor("ball 10") + offset,
        "wall [N]": run.force(run.chain.beads),
    }  # fmt: skip
    rng = np.random.default_rng(1)
    columns = {
        name: np.pad(force, (100, 0), "edge") + 0.1 * rng.standard_normal(800)
        for name, force in forces.items()
    }
    return hc.Traces.from_arrays(1e-6 * np.arange(800), columns)


def design_shock_absorber() -> Figure:
    """The shock absorber of the how-to guide."""
    chain = hc.Chain.from_materials(
        3.175e-3, "steel-52100", beads=9, velocity=0.3, right_wall=hc.Wall.of("steel-52100")
    )
    balls = hc.vary.balls(
        materials=["steel-52100"], diameters=["3 mm", "4 mm", "5 mm", "6.35 mm", "8 mm"],
        optional=True,
    )  # fmt: skip
    problem = hc.Design(
        chain, minimise="wall_force.peak", vary=[balls],
        subject_to={"length": "<= 60 mm", "yield_ratio": "<= 1"},
    )  # fmt: skip
    return hc.design(problem, budget=4000, seed=1).plot()


FIGURES: dict[str, Callable[[], Figure]] = {
    "first-force": first_force,
    "force-trace": force_trace,
    "budget": budget,
    "first-pulse": first_pulse,
    "waves": waves,
    "horizon": horizon,
    "moments": moments,
    "figure12": figure12,
    "formula-errors": formula_errors,
    "scoreboard": scores,
    "sweep": sweep,
    "fit-before": fit_before,
    "fit-result": fit_result,
    "fit-correlations": fit_correlations,
    "fit-causes": fit_causes,
    "fit-defects": fit_defects,
    "design-shock-absorber": design_shock_absorber,
    **{
        draw.__name__.replace("_", "-"): draw
        for figures in (
            PAGE_FIGURES,
            HOWTO_FIGURES,
            EXPERIMENT_FIGURES,
            PAPER_FIGURES,
            LAW_FIGURES,
            LOCAL_RATE_FIGURES,
        )
        for draw in figures
    },
}


def draw_all(folder: Path) -> None:
    """Save every figure into a folder, as SVG."""
    folder.mkdir(exist_ok=True)
    for name, draw in FIGURES.items():
        canvas = draw()
        (folder / f"{name}.svg").write_bytes(figure_bytes(canvas, "svg"))
        plt.close(canvas)


if __name__ == "__main__":
    draw_all(Path(__file__).parent / "_generated")

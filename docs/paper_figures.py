"""Figures of the guide to figures for a paper, drawn by the examples of its page."""

from typing import Final

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

import hertzchain as hc


def compared_pulses() -> Figure:
    """Velocities in three chains, and of two theories with their differences."""
    rates = (0.01, 0.03, 0.05)
    chains = [hc.Chain.tapered("backward-exponential", rate, beads=40) for rate in rates]
    steepest = chains[-1]
    with hc.figure_style("double column"):
        canvas, panels = plt.subplot_mosaic(
            [["chains", "theories"], ["chains", "errors"]], height_ratios=[3, 1.2]
        )
        hc.plot_pulses(
            [hc.propagate(chain) for chain in chains],
            labels=[f"$q$ = {rate}" for rate in rates], log=True, ax=panels["chains"],
        )  # fmt: skip
        hc.plot_pulses(
            [hc.propagate(steepest), hc.bca(steepest), hc.local_rate(steepest)],
            log=True, residuals=True, ax=[panels["theories"], panels["errors"]],
        )  # fmt: skip
    return canvas


def _steel_and_titanium() -> hc.Run:
    """The run of the page on figures: a pulse that passes from steel to titanium."""
    kinds = ["steel-52100"] * 12 + ["titanium"] * 8
    balls = hc.Chain.from_materials(diameters="10 mm", materials=kinds)
    chain = balls.struck_by(velocity="0.05 m/s").replace(right_wall=hc.Wall.of("steel-52100"))
    return hc.simulate(chain, until="1 ms", times=2001)


def composed_panels() -> Figure:
    """A chain, a map of its velocities and two forces in one figure."""
    run = _steel_and_titanium()
    with hc.figure_style("double column"):
        canvas, panels = plt.subplot_mosaic(
            [["chain", "chain"], ["map", "forces"]], figsize=(178 / 25.4, 3.2),
            height_ratios=[0.45, 2],
        )  # fmt: skip
        for letter, axes in zip("abc", panels.values(), strict=True):
            axes.set_title(f"({letter})", loc="left")
        hc.plot_chain(run.chain, ax=panels["chain"])
        panels["chain"].set_axis_off()
        materials = panels["chain"].get_legend().legend_handles
        panels["chain"].legend(
            handles=materials, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2
        )
        run.plot(ax=panels["map"])
        run.plot_forces(["ball 6", "wall"], legend=False, ax=panels["forces"])
        panels["forces"].set_ylim(top=13.0)
        panels["forces"].legend(["in ball 6", "on the wall"], loc="upper left")
    return canvas


def measured_traces() -> Figure:
    """Measured and simulated forces in a ball and on the wall."""
    traces, chain_file = hc.example_experiment()
    run = hc.simulate(hc.load_chain(chain_file), until="600 us", times=1201)
    compared = run.compare(traces)
    with hc.figure_style("double column"):
        canvas, panels = plt.subplots(1, 2, figsize=(178 / 25.4, 2.3), sharey=True)
        for axes, sensor in zip(panels, ["ball 6", "wall"], strict=True):
            compared.plot(sensor, legend=sensor == "ball 6", ax=axes)
        panels[1].set_ylabel("")
    return canvas


def own_quantities() -> Figure:
    """Kinetic energies of beads, and loops of force and overlap in contacts with loss."""
    run = _steel_and_titanium()
    data = run.to_xarray()
    energy = 0.5 * data.mass * data.velocity**2
    lossy = hc.simulate(run.chain.replace(loss=hc.Restitution(0.8)), until="400 us", times=2001)
    with hc.figure_style("double column"):
        canvas, (left, right) = plt.subplots(1, 2, figsize=(178 / 25.4, 2.4))
        for bead, dashes in ((5, "-"), (10, "--"), (15, "-.")):
            left.plot(1e6 * data.time, 1e6 * energy.sel(bead=bead), dashes, label=f"bead {bead}")
        left.set_xlim(0.0, 650.0)
        left.set_xlabel("time [µs]")
        left.set_ylabel("kinetic energy [µJ]")
        left.legend()
        for contact, dashes in ((4, "-"), (8, "--")):
            overlap, force = lossy.overlap(contact), lossy.force(contact)
            closed = force > 0.0
            right.plot(1e6 * overlap[closed], force[closed], dashes, label=f"contact {contact}")
        right.set_xlabel("overlap [µm]")
        right.set_ylabel("force [N]")
        right.legend()
    return canvas


PAPER_FIGURES: Final = (compared_pulses, composed_panels, measured_traces, own_quantities)

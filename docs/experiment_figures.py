"""Figures of the guides to experiments: places of sensors, the lab sheet, and a hammer."""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, MultipleLocator
from scipy.signal import lsim

import hertzchain as hc
from hertzchain.plotting.chains import draw_beads, draw_walls
from hertzchain.plotting.colours import COLOURS
from hertzchain.plotting.style import figure_style, label_log_axis

# The hammer of the page, and the row that its design finds.
HAMMER: Final = {"mass": "50 g", "radius": "flat", "velocity": "0.1 m/s"}
DESIGNED: Final = ("8 mm", "6.35 mm", "8 mm", "8 mm", "8 mm", "12 mm", "10 mm", "5 mm")


def sensor_places() -> Figure:
    """Signals of sensors in four beads and in the wall, and the force in one contact."""
    balls = hc.Chain.from_materials(diameters="10 mm", materials="steel-52100", beads=30)
    chain = balls.struck_by(velocity="0.1 m/s").replace(right_wall=hc.Wall())
    run = hc.simulate(chain, until="1.2 ms", times=6001)
    time = 1e6 * run.times
    with figure_style():
        canvas, axes = plt.subplots(figsize=(7.2, 3.2))
        for colour, ball in zip(COLOURS[1:], (1, 15, 27, 29), strict=False):
            axes.plot(time, run.sensor(f"ball {ball}"), color=colour, label=f"ball {ball}")
        axes.plot(time, run.sensor("wall"), color=COLOURS[0], label="wall")
        axes.plot(
            time, run.force(16), color=COLOURS[2], linestyle=":", label="between balls\n15 and 16"
        )
        axes.set_xlim(0.0, 1000.0)
        axes.set_xlabel("time [µs]")
        axes.set_ylabel("force [N]")
        axes.legend(loc="upper left")
    return canvas


def lab_sheet() -> Figure:
    """Predictions for balls of a pendulum, on axes to which readings can be added by hand."""
    speeds = np.geomspace(0.02, 1.0, 50)
    material = {"materials": "steel-52100", "diameters": "20 mm"}
    cradle = hc.Chain.from_materials(**material, beads=5, velocities=[0.2, 0.0, 0.0, 0.0, 0.0])
    restitutions = np.linspace(0.9, 0.995, 15)
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.4, 5.3), layout="constrained")
        for diameter, colour in (("10 mm", COLOURS[1]), ("20 mm", COLOURS[0])):
            pair = hc.Chain.from_materials(diameters=diameter, materials="steel-52100", beads=2)
            mass = hc.collision.reduced_mass(*pair.masses)
            times = [hc.collision.compression_time(mass, pair.stiffness[0], v) for v in speeds]
            left.loglog(1e3 * speeds, 2e6 * np.array(times), color=colour, label=diameter)
        left.set_xlabel("velocity [mm/s]")
        left.set_ylabel("time of contact [µs]")
        left.set_ylim(20.0, 200.0)
        label_log_axis(left.yaxis)
        label_log_axis(left.xaxis)
        # Fine enough for readings of a few percent.
        left.yaxis.set_minor_locator(FixedLocator([*range(22, 60, 2), *range(60, 200, 5)]))
        left.xaxis.set_minor_locator(FixedLocator([*range(30, 100, 10), *range(100, 1000, 100)]))
        for gap, dashes, balls in ((0.0, "-", (5, 4, 1)), ("20 um", "--", (5, 4))):
            after = np.array([
                hc.simulate(cradle.replace(loss=hc.Restitution(e), gaps=gap), until="20 ms")
                .velocities[-1] / 0.2 for e in restitutions
            ])  # fmt: skip
            for ball in balls:
                spacing = f"ball {ball}, touching" if gap == 0.0 else f"ball {ball}, gaps"
                # Behind gaps, the first four balls have nearly the same velocity.
                label = "balls 1 to 4, gaps" if (gap, ball) == ("20 um", 4) else spacing
                colour = {5: COLOURS[0], 4: COLOURS[1], 1: COLOURS[2]}[ball]
                right.plot(restitutions, after[:, ball - 1], dashes, color=colour, label=label)
        right.set_xlabel("coefficient of restitution")
        right.set_ylabel("velocity / velocity of impact")
        right.xaxis.set_minor_locator(MultipleLocator(0.01))
        right.yaxis.set_minor_locator(MultipleLocator(0.05))
        for axes in (left, right):
            axes.tick_params(which="minor", length=0.0, labelleft=False, labelbottom=False)
            axes.grid(visible=True, which="minor", linewidth=0.3, color="0.85")
            axes.grid(visible=True, which="major", linewidth=0.6, color="0.7")
            # Above the grid, which is for readings.
            axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, fontsize="small")
    return canvas


def _row(*diameters: str) -> hc.Chain:
    """Steel balls, without hammer and wall."""
    return hc.Chain.from_materials(diameters=diameters, materials="steel-52100")


def hammer() -> Figure:
    """Forces on a wall behind eight equal balls and behind the designed row."""
    rows = {"eight balls of 10 mm": _row(*["10 mm"] * 8), "design": _row(*DESIGNED)}
    with figure_style():
        canvas, (*pictures, axes) = plt.subplots(
            3, 1, figsize=(6.4, 4.6), layout="constrained", height_ratios=(1.0, 1.0, 4.5)
        )
        for i, (picture, (name, balls)) in enumerate(zip(pictures, rows.items(), strict=True)):
            struck = balls.struck_by(**HAMMER).replace(right_wall=hc.Wall())
            draw_beads(struck, 1e3, picture)
            draw_walls(struck, 1e3, 6.0, picture)
            picture.set_aspect("equal")
            picture.set_anchor("W")
            picture.set_xlim(-8.0, 102.0)
            picture.set_ylim(-7.0, 7.0)
            picture.set_axis_off()
            picture.set_title(name, loc="left")
            run = hc.simulate(struck, until="0.7 ms", times=2801)
            found, colour = run.wall_force(), (COLOURS[0], COLOURS[2])[i]
            axes.plot(1e6 * run.times, run.sensor("wall"), color=colour,
                      label=f"{name}, largest {found.peak:.1f} N")  # fmt: skip
        axes.set_xlim(0.0, 700.0)
        axes.set_ylim(0.0, 70.0)
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)
        axes.set_xlabel("time [µs]")
        axes.set_ylabel("force on the wall [N]")
    return canvas


def instrument() -> Figure:
    """Accelerations of boxes behind a row, and of parts on mounts in one of them."""
    gravity = 9.80665
    row = _row(*["10 mm"] * 8)
    with figure_style():
        canvas, (left, right) = plt.subplots(1, 2, figsize=(7.3, 3.3))
        for i, mass in enumerate(("20 g", "100 g", "500 g")):
            run = hc.simulate(row.with_cap(mass).struck_by(**HAMMER), until="4 ms", times=8001)
            acceleration = run.force(9) / run.chain.masses[-1]
            left.semilogy(1e6 * run.times, acceleration / gravity, color=COLOURS[i + 1],
                          label=f"box of {mass}")  # fmt: skip
            if mass == "100 g":
                right.plot(1e3 * run.times, acceleration / gravity, color=COLOURS[2], label="box")
                for frequency, colour in ((2000, COLOURS[0]), (500, COLOURS[5])):
                    w = 2.0 * np.pi * frequency
                    mount = [0.1 * w, w**2], [1.0, 0.1 * w, w**2]
                    response = lsim(mount, acceleration, run.times)[1] / gravity
                    right.plot(1e3 * run.times, response, color=colour,
                               label=f"part, {frequency} Hz")  # fmt: skip
        left.set_xlim(100.0, 1000.0)
        left.set_ylim(0.5, 500.0)
        label_log_axis(left.yaxis)
        left.set_xlabel("time [µs]")
        left.set_ylabel("acceleration / $g_0$")
        left.legend()
        right.axhline(0.0, color="0.7", linewidth=0.6, zorder=0)
        right.set_xlim(0.0, 4.0)
        right.set_xlabel("time [ms]")
        right.set_ylabel("acceleration / $g_0$")
        right.legend()
    return canvas


def raw_record() -> Figure:
    """Fits to channel 2 of the record on the page, without and with a gap."""
    page = Path(__file__).parent.joinpath("how-to", "raw_record.md").read_text("utf-8")
    blocks = re.findall(r"^\$ cat (\S+)\n(.*?)(?=^\$ |^```)", page, re.M | re.S)
    sensors = {"CH1": "ball 4 [V]", "CH2": "wall [V]"}
    with tempfile.TemporaryDirectory() as folder:
        for name, text in blocks:
            Path(folder, name).write_text(text, "utf-8")
        script = [sys.executable, os.fspath(Path(folder, "make_record.py"))]
        subprocess.run(script, cwd=folder, check=True)
        traces = hc.load_traces(Path(folder, "scope.csv"), sensors=sensors)
        row = Path(folder, "row.toml")
        touching = hc.fit(traces, row, starts=1, diagnose=False)
        apart = hc.fit(traces, row, also_free=["gap[6-7]"], starts=1, diagnose=False)
    with figure_style():
        canvas, panels = plt.subplots(
            2, 2, figsize=(7.4, 4.4), sharex=True, layout="constrained", height_ratios=(2.0, 1.0)
        )
        fits = {"touching balls": touching, "gap between balls 6 and 7": apart}
        for (upper, lower), (title, result) in zip(panels.T, fits.items(), strict=True):
            result.plot("wall", ax=(upper, lower))
            upper.set_title(title)
    return canvas


EXPERIMENT_FIGURES: Final = (sensor_places, lab_sheet, hammer, instrument, raw_record)

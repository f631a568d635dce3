"""The command `simulate`: integrate the whole chain."""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

import click

from .chain_options import ChainOptions, chain_from, chain_options
from .options import PICTURES, check_writable, time_from, with_width
from .output import save_figure, show_json, show_table
from .progress import progress_bar
from .stream import check_stream_options, stream_into

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..simulation.run import Run
    from ..simulation.sensor_force import SensorForce
    from ..simulation.wall_force import WallForce
    from ..simulation.waves import Waves


@click.command()
@chain_options
@click.option(
    "--until",
    metavar="TIME",
    help="Stop time, such as 2e-3 or, in SI units, 2ms.  [default: when the peak force on the "
    "right wall is complete, at most 10 transits of the pulse; without a right wall, when the "
    "pulse has left the chain]",
)
@click.option("--times", type=int, default=400, show_default=True, help="Number of saved times.")
@click.option(
    "--rtol", type=float, default=1e-13, show_default=True, help="Relative tolerance per step."
)
@click.option(
    "--method",
    type=click.Choice(["adaptive", "symplectic", "verlet", "forward-4"]),
    default="adaptive",
    show_default=True,
    help="Method; symplectic takes fixed steps, for long runs of elastic chains.",
)
@click.option("--step", metavar="TIME", help="Step of the symplectic method.")
@click.option("--drift", type=float, help="Largest energy drift of the symplectic method.")
@click.option(
    "--max-steps", type=int, help="Step limit.  [default: 2000 per bead, at least a million]"
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Save the trajectories to FILE (.nc or .csv).",
)
@click.option(
    "--plot",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Plot velocities or, with --sensor, forces to FILE (.png, .svg or .pdf).",
)
@click.option(
    "--animate",
    "animation",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write an animation of the beads to FILE (.gif, or .mp4 with ffmpeg).",
)
@click.option(
    "--sensor",
    "sensors",
    type=int,
    multiple=True,
    metavar="BEAD",
    help="Print the first maximum and the largest value of the force in a sensor in this bead; "
    "repeatable.",
)
@click.option(
    "--stream",
    type=click.Path(path_type=Path),
    metavar="FOLDER",
    help="Write a long run to FOLDER as it proceeds; run the command again to resume.",
)
@click.option("--budget", is_flag=True, help="Print the final energy and momentum by location.")
@click.option(
    "--waves", is_flag=True, help="Print the travelling waves: pulses, trains and reflections."
)
@click.option(
    "--horizon", is_flag=True, help="Print how long the run is predictable (takes twice as long)."
)
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON.")
@with_width("plot")
def simulate(
    options: ChainOptions, until: str | None, times: int, rtol: float, method: str,
    step: str | None, drift: float | None, max_steps: int | None, out: Path | None,
    plot: Path | None, animation: Path | None, sensors: tuple[int, ...], stream: Path | None,
    budget: bool, waves: bool, horizon: bool, as_json: bool,
) -> None:  # fmt: skip
    """Integrate the whole chain and keep its trajectories.

    The forces on walls and in sensors are printed.  The force in a sensor in a bead is the mean
    of the forces on both halves of the bead.  Its first maximum belongs to the first pulse; a
    later wave may be larger.

    With --stream, trajectories are kept only on disk, in netCDF files, so that memory does not
    grow with the run.  If a run is interrupted, run the same command again and it resumes.

    \b
    Examples:
      hertzchain simulate --beads 50 --until 60 --out run.nc
      hertzchain simulate --taper forward-exponential --rate 0.05 --beads 60 --plot run.png
      hertzchain simulate --material steel-52100 --diameter "20 mm:5 mm" --beads 40 \\
          --speed "0.1 m/s" --wall same --animate impact.gif
      hertzchain simulate experiment.toml --until 7e-4 --budget
      hertzchain simulate experiment.toml --until 7e-4 --sensor 6 --sensor 11 --plot forces.png
      hertzchain simulate experiment.toml --until 10 --times 100000 --stream long
      hertzchain simulate --beads 50 --until 60 --times 600 --waves --horizon
    """
    import hertzchain

    from ..store.results import save_run
    from ..validation.numbers import whole_number

    check_writable(plot, "--plot", PICTURES)
    check_writable(animation, "--animate", (".gif", ".mp4"))
    check_writable(out, "--out", (".nc", ".csv"))
    if budget and as_json:
        raise click.UsageError("--budget and --json cannot be combined")
    if times < 2 and (out or plot or animation or sensors or stream or budget or waves or horizon):
        raise click.UsageError(
            "--out, --plot, --animate, --sensor, --stream, --budget, --waves and --horizon require "
            f"saved times: --times {times} is too few"
        )
    if stream is not None:
        check_stream_options(
            out=out, plot=plot, animate=animation, sensor=sensors, budget=budget, waves=waves,
            horizon=horizon, max_steps=max_steps,
            method=method if method != "adaptive" else None, step=step, drift=drift,
        )  # fmt: skip
    chain = chain_from(options)
    end = time_from("--until", until, chain)
    for bead in sensors:
        whole_number("--sensor", bead, least=1, most=chain.beads)
    if stream is not None:
        stream_into(stream, chain, until=end, times=times, rtol=rtol, as_json=as_json)
        return
    with progress_bar("beads passed") as progress:
        run = hertzchain.simulate(
            chain, until=end, times=times, rtol=rtol, method=method,
            step=time_from("--step", step, chain), drift=drift, max_steps=max_steps,
            progress=progress,
        )  # fmt: skip
    if horizon:
        with progress_bar("beads passed, second integration") as progress:
            run.horizon(progress=progress)
    if out is not None:
        save_run(run, out)
    walls = _walls(run)
    if plot is not None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", hertzchain.IncompleteWarning)  # already shown
            save_figure(_drawn(run, sensors, walls), plot)
    if animation is not None:
        with progress_bar("frames") as progress:
            run.animate(animation, progress=progress)
    felt = [run.sensor_force(bead) for bead in sensors]
    _show_run(run, walls, felt, run.waves() if waves else None, as_json)
    if budget:
        click.echo(run.budget())


def _drawn(run: Run, sensors: tuple[int, ...], walls: list[WallForce]) -> Axes:
    """Plot forces in sensors and on walls, or else the map of all velocities."""
    if not sensors:
        return run.plot()
    ends = {"left": 0, "right": run.chain.beads + 1}
    return run.plot_forces([*sensors, *(ends[wall.side] for wall in walls)])


def _walls(run: Run) -> list[WallForce]:
    from ..simulation.wall_force import SIDES

    return [run.wall_force(side) for side in SIDES if f"{side} wall" in run.chain.features]


def _show_run(
    run: Run, walls: list[WallForce], sensors: list[SensorForce], waves: Waves | None, as_json: bool
) -> None:
    from ..store import results
    from .wave_tables import horizon_as_dict, wave_table, waves_as_list

    summary: dict[str, object] = {
        "status": run.status,
        "message": run.message,
        "end_time": run.end_time,
        "steps": run.steps,
        "evaluations": run.evaluations,
        "energy_drift": run.energy_drift,
        "momentum_drift": run.momentum_drift,
        "saved_times": len(run.times),
    }
    if as_json:
        document = {"schema_version": results.SCHEMA_VERSION} | summary
        document |= {"walls": [*map(_numbers, walls)], "sensors": [*map(_numbers, sensors)]}
        if run.known_horizon is not None:
            document["horizon"] = horizon_as_dict(run.known_horizon)
        if waves is not None:
            document["waves"] = waves_as_list(waves)
        document["chain"] = results.chain_as_dict(run.chain)
        show_json(document)
        return
    click.echo(f"{run.chain.description}\n{run.message}")
    click.echo(f"energy drift {run.energy_drift:.1e}, momentum drift {run.momentum_drift:.1e}")
    click.echo(f"{len(run.times)} times saved, {run.evaluations} evaluations of the force")
    newton, second, impulse = (" N", " s", " N s") if run.chain.units == "SI" else ("", "", "")
    for wall in walls:
        click.echo(_wall_line(wall, newton, second, impulse))
    for sensor in sensors:
        click.echo(_sensor_line(sensor, newton, second))
    if run.known_horizon is not None:
        click.echo(f"horizon: {run.known_horizon.message}")
    elif run.prediction:
        click.echo("a long run between walls: --horizon shows how long it is predictable")
    if waves is not None:
        show_table(wave_table(waves))


def _is_nan(value: object) -> bool:
    return isinstance(value, float) and math.isnan(value)


def _numbers(force: WallForce | SensorForce) -> dict[str, object]:
    """All fields except the trace; null for a number that does not exist."""
    found = {name: value for name, value in vars(force).items() if name not in ("times", "force")}
    return {name: None if _is_nan(value) else value for name, value in found.items()}


def _wall_line(wall: WallForce, newton: str, second: str, impulse: str) -> str:
    """Describe the force on a wall; an incomplete one has no peak."""
    if wall.largest_so_far == 0.0:
        return f"{wall.side} wall: not reached"
    largest = f"{wall.largest_so_far:.6g}{newton} at t = {wall.largest_so_far_time:.6g}{second}"
    if not wall.complete:
        return (
            f"{wall.side} wall: peak not complete, largest so far {largest}, up to "
            f"{wall.bound:.6g}{newton} may follow; impulse so far {wall.impulse:.6g}{impulse}"
        )
    first = ""
    if wall.first_contact_impulse is not None:
        first = f", of the first contact {wall.first_contact_impulse:.6g}{impulse}"
    touches = "1 contact" if wall.touches == 1 else f"{wall.touches} contacts"
    return (
        f"{wall.side} wall: peak {largest}; impulse of the impact {wall.impulse_of_impact:.6g}"
        f"{impulse} ({touches}){first}, in total {wall.impulse:.6g}{impulse}"
    )


def _sensor_line(sensor: SensorForce, newton: str, second: str) -> str:
    first = "no maximum yet"
    if not math.isnan(sensor.first_maximum):
        first = (
            f"first maximum {sensor.first_maximum:.6g}{newton} at t = "
            f"{sensor.first_maximum_time:.6g}{second}"
        )
    return (
        f"sensor in bead {sensor.bead}: {first}; largest so far {sensor.largest_so_far:.6g}"
        f"{newton} at t = {sensor.largest_so_far_time:.6g}{second}"
    )

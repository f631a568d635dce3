"""The command `simulate`: the whole chain and its trajectories."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from hertzchain.cli.long_run import refuse_with_stream, stream_into
from hertzchain.cli.options import PICTURES, chain_from, chain_options, check_writable
from hertzchain.cli.progress import progress_of
from hertzchain.cli.show import save_axes, show_json, show_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from hertzchain.simulation.run import Run
    from hertzchain.simulation.wall_force import WallForce
    from hertzchain.simulation.waves import Waves


@click.command()
@chain_options
@click.option(
    "--until",
    type=float,
    help="Time to stop at.  [default: when the pulse has left or is in the wall]",
)
@click.option("--times", type=int, default=400, show_default=True, help="Times to save.")
@click.option("--rtol", type=float, default=1e-13, show_default=True, help="Tolerance of a step.")
@click.option(
    "--max-steps", type=int, help="Step limit.  [default: 2000 per bead, at least a million]"
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Save the trajectories into FILE (.nc or .csv).",
)
@click.option(
    "--plot",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Draw velocities, or with --sensor forces, into FILE (.png, .svg or .pdf).",
)
@click.option(
    "--sensor",
    "sensors",
    type=int,
    multiple=True,
    metavar="BEAD",
    help="Print the peak force in a sensor in this bead, and when; repeat it for more.",
)
@click.option(
    "--stream",
    type=click.Path(path_type=Path),
    metavar="FOLDER",
    help="Save a long run into FOLDER as it goes on; repeated, go on where it stopped.",
)
@click.option("--budget", is_flag=True, help="Print where energy and momentum are at the end.")
@click.option(
    "--waves", is_flag=True, help="Print the travelling waves: pulses, trains, reflections."
)
@click.option(
    "--horizon", is_flag=True, help="Print how far the run can be predicted (integrates it twice)."
)
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON.")
def simulate(
    file: Path | None, chain_file: Path | None, taper: str | None, rate: float | None,
    beads: int | None, until: float | None, times: int, rtol: float, max_steps: int | None,
    out: Path | None, plot: Path | None, sensors: tuple[int, ...], stream: Path | None,
    budget: bool, waves: bool, horizon: bool, as_json: bool,
) -> None:  # fmt: skip
    """Integrate the whole chain and keep its trajectories.

    What walls felt is printed, and what sensors in beads showed (the mean of the forces on both
    halves of the bead).

    With --stream they are on disk alone, in netCDF files: memory does not grow with the run,
    and one that was interrupted goes on when the command is repeated.

    \b
    Examples:
      hertzchain simulate --beads 50 --until 60 --out run.nc
      hertzchain simulate --taper forward-exponential --rate 0.05 --beads 60 --plot run.png
      hertzchain simulate experiment.toml --until 7e-4 --budget
      hertzchain simulate experiment.toml --until 7e-4 --sensor 6 --sensor 11 --plot forces.png
      hertzchain simulate experiment.toml --until 10 --times 100000 --stream long
      hertzchain simulate --beads 50 --until 60 --times 600 --waves --horizon
    """
    import hertzchain
    from hertzchain.checks import whole_number
    from hertzchain.store.results import save_run

    check_writable(plot, "--plot", PICTURES)
    check_writable(out, "--out", (".nc", ".csv"))
    if budget and as_json:
        raise click.UsageError("--budget and --json exclude each other")
    if times < 2 and (out or plot or sensors or stream or budget or waves or horizon):
        raise click.UsageError(
            "--out, --plot, --sensor, --stream, --budget, --waves and --horizon need saved times: "
            f"--times {times} is too few"
        )
    if stream is not None:
        refuse_with_stream(
            out=out, plot=plot, sensor=sensors, budget=budget, waves=waves, horizon=horizon,
            max_steps=max_steps,
        )  # fmt: skip
    chain = chain_from(file, chain_file, taper, rate, beads)
    for bead in sensors:
        whole_number("--sensor", bead, least=1, most=chain.beads)
    if stream is not None:
        stream_into(stream, chain, until=until, times=times, rtol=rtol, as_json=as_json)
        return
    with progress_of("beads passed") as progress:
        run = hertzchain.simulate(
            chain, until=until, times=times, rtol=rtol, max_steps=max_steps, progress=progress
        )
    if horizon:
        with progress_of("beads passed, second integration") as progress:
            run.horizon(progress=progress)
    if out is not None:
        save_run(run, out)
    if plot is not None:
        save_axes(_drawn(run, sensors), plot)
    _show_run(run, sensors, run.waves() if waves else None, as_json)
    if budget:
        click.echo(run.budget())


def _drawn(run: Run, sensors: tuple[int, ...]) -> Axes:
    """Forces in time of sensors and walls, or the map of all velocities."""
    if not sensors:
        return run.plot()
    ends = {"left": 0, "right": run.chain.beads + 1}
    return run.plot_forces([*sensors, *(ends[wall.side] for wall in _walls(run))])


def _walls(run: Run) -> list[WallForce]:
    from hertzchain.simulation.wall_force import SIDES

    return [run.wall_force(side) for side in SIDES if f"{side} wall" in run.chain.features]


def _show_run(run: Run, sensors: tuple[int, ...], waves: Waves | None, as_json: bool) -> None:
    from hertzchain.cli.wave_tables import horizon_as_dict, wave_table, waves_as_list
    from hertzchain.store import results

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
    names = ("side", "peak", "peak_time", "first_impulse", "first_end", "impulse")
    walls = [{name: getattr(wall, name) for name in names} for wall in _walls(run)]
    shown = [_peak(run, bead) for bead in sensors]
    if as_json:
        document = {"schema_version": results.SCHEMA_VERSION} | summary
        document |= {"walls": walls, "sensors": shown}
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
    for wall in _walls(run):
        click.echo(_wall_line(wall, run.end_time, newton, second, impulse))
    for sensor in shown:
        click.echo(
            f"sensor in bead {sensor['bead']}: peak {sensor['peak']:.6g}{newton} at t = "
            f"{sensor['peak_time']:.6g}{second}"
        )
    if run.known_horizon is not None:
        click.echo(f"horizon: {run.known_horizon.message}")
    elif run.prediction:
        click.echo("a long run between walls: --horizon tells how far it can be predicted")
    if waves is not None:
        show_table(wave_table(waves))


def _wall_line(wall: WallForce, end: float, newton: str, second: str, impulse: str) -> str:
    """What a wall felt; a force that still rises has no peak to tell."""
    if wall.peak == 0.0:
        return f"{wall.side} wall: not reached"
    if wall.peak_time >= (1.0 - 1e-9) * end:
        return (
            f"{wall.side} wall: {wall.peak:.6g}{newton} at the end, t = {end:.6g}{second}, and "
            f"rising: a later --until shows the peak; impulse so far {wall.impulse:.6g}{impulse}"
        )
    first = "the first contact is not over"
    if wall.first_impulse is not None:
        first = f"impulse of the first contact {wall.first_impulse:.6g}{impulse}"
    return (
        f"{wall.side} wall: peak {wall.peak:.6g}{newton} at t = {wall.peak_time:.6g}{second}; "
        f"{first}, impulse in all {wall.impulse:.6g}{impulse}"
    )


def _peak(run: Run, bead: int) -> dict[str, float]:
    """Largest force that a sensor showed at the saved times, and when."""
    force = run.sensor(bead)
    at = int(force.argmax())
    return {"bead": bead, "peak": float(force[at]), "peak_time": float(run.times[at])}

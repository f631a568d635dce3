"""The command `simulate`: integrate the whole chain."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from .chain_options import ChainOptions, chain_options
from .chain_runs import runs_of
from .compared_runs import compared_runs, peaks_of
from .compared_yield import beyond_yield, figure_title
from .hit_tables import check_hits, hit_table, hits_as_list
from .options import (
    Fraction,
    StrictCommand,
    bead_from,
    check_writable,
    figure_option,
    json_option,
    time_from,
)
from .output import save_figure, show_json, show_table
from .peaks_over_impacts import drawn_over_impacts, nothing_to_plot
from .progress import progress_bar
from .reflections import Contacts, check_reflection, reflection_option
from .repeated_impacts import chains_at_impacts
from .run_summary import peaks_if_yielding, run_as_dict, show_run, together
from .stream import check_stream_options, stream_into
from .wrapped_text import show_text
from .yield_range import second_run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from rich.table import Table

    from ..chain.chain import Chain
    from ..simulation.run import Run
    from .compared_runs import Peaks
    from .compared_yield import Yielding
    from .repeated_impacts import Impacts

USUAL_TIMES: Final = 400
NOTHING: Final = "--plot has nothing to plot, because no peak is complete; give a later --until"
SINGLE: Final = (
    "--out, --forces, --animate and --stream require one chain FILE and one --speed or --height"
)


@click.command(cls=StrictCommand)
@chain_options
@click.option(
    "--until",
    metavar="TIME",
    help="Stop time, such as 60 or, in SI units, 2ms.  By default, a run without a right wall ends "
    "when the pulse has left the chain and no larger force on a cap can follow.  A run with this "
    "wall ends when the peak force on it is complete and the impact is over, at the latest after "
    "ten transits of the pulse.  If the left end is free, the wall soft or the striker heavy, more "
    "transits are allowed.",
)
@click.option(
    "--times",
    type=int,
    help="Number of saved times.  Without --until, it is the largest number; usually more than "
    "half of it are saved.  [default: 400; with --sensor, --forces, --plot of forces, --animate "
    "or several files, 4000; with --waves or --reflection, more if the waves require them]",
)
@click.option(
    "--rtol",
    type=Fraction(),
    default=1e-13,
    show_default=True,
    help="Relative tolerance per step.",
)
@click.option(
    "--method",
    type=click.Choice(["adaptive", "symplectic", "verlet", "forward-4"]),
    default="adaptive",
    show_default=True,
    help="Method of integration.  The methods with fixed steps, verlet and forward-4, suit long "
    "runs of elastic chains; symplectic chooses the faster of the two.",
)
@click.option("--step", metavar="TIME", help="Step of the methods with fixed steps.")
@click.option(
    "--drift",
    type=Fraction(),
    help="Largest energy drift with fixed steps, instead of --step.  "
    "[default: 1e-5 without --step]",
)
@click.option(
    "--max-steps",
    type=int,
    help="Step limit.  [default: 2000 per bead, at least a million; 10^12 with fixed steps]",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Save the trajectories to FILE (.nc or .csv).",
)
@click.option(
    "--forces",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Save the forces on walls and, with --sensor, in sensors over time to FILE (.csv); of a "
    "cap without a wall, also its force and acceleration.",
)
@figure_option(
    "Plot velocities or, with --sensor, forces to FILE.  Velocities that differ much from bead to "
    "bead are divided by the largest one of the bead.  Of several chains, the forces in sensors "
    "and on walls are plotted, or the leading pulses."
)
@click.option(
    "--animate",
    "animation",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write an animation of the beads to FILE (.gif, or .mp4 with ffmpeg).",
)
@click.option(
    "--magnify",
    type=click.FloatRange(min=0.0, min_open=True),
    metavar="FACTOR",
    help="With --animate, the factor by which displacements, gaps and overlaps are enlarged.  "
    "[default: so that the motion is visible and no overlap exceeds 0.2 radii]",
)
@click.option(
    "--sensor",
    "sensors",
    multiple=True,
    metavar="BEAD",
    help="Put a force sensor into this bead, and print the first maximum and the largest value.  "
    "Give its number with the strikers, such as 12, or without them, such as 'ball 11', or give "
    "'last'.  Can be repeated.  With 'wall' or 'load cell', --plot plots the force on it.",
)
@click.option(
    "--stream",
    type=click.Path(path_type=Path),
    metavar="FOLDER",
    help="Write a long run to FOLDER as it proceeds; run the command again to resume.",
)
@click.option("--budget", is_flag=True, help="Print the final energy and momentum by location.")
@click.option(
    "--contacts",
    is_flag=True,
    help="Print the materials and a table of contacts: stiffness, largest overlap, largest "
    "pressure over that at first yield and, with a loss that leaves dents, dent.",
)
@click.option(
    "--hits",
    type=click.IntRange(min=2),
    metavar="NUMBER",
    help="With a loss that leaves dents, simulate this number of equal impacts.  Each begins "
    "after the one before has ended.  The forces and the deepest dent of each are printed.",
)
@click.option(
    "--waves", is_flag=True, help="Print the travelling waves: pulses, trains and reflections."
)
@reflection_option
@click.option(
    "--horizon", is_flag=True, help="Print how long the run is predictable (takes twice as long)."
)
@json_option("Print the summary as JSON.")
def simulate(
    options: ChainOptions, until: str | None, times: int | None, rtol: float, method: str,
    step: str | None, drift: float | None, max_steps: int | None, out: Path | None,
    forces: Path | None, plot: Path | None, animation: Path | None, magnify: float | None,
    sensors: tuple[str, ...], stream: Path | None, budget: bool, contacts: bool, waves: bool,
    reflection: Contacts | None, horizon: bool, hits: int | None, as_json: bool,
) -> None:  # fmt: skip
    """Integrate the whole chain and keep its trajectories.

    The forces on walls and in sensors are printed.  Two impulses are printed for a wall: that
    of the impact and that of the whole run.  The impact ends when the contact with the wall
    opens and no stronger impact follows.  At a free end, the velocity and the momentum of the
    last bead are printed.  If this bead is a cap or has a sensor, the largest force on it, its
    acceleration (this force over its mass, without a filter) and the duration of the force are
    printed, too.  The force in a sensor in a bead is the mean of the forces on both halves of
    the bead.  Its first maximum belongs to the first pulse; a later wave may be larger.  It is
    the highest point before the force drops by 10% of its rise; maxima below 1% of the largest
    force are ignored.

    If contacts yield at the assumed pressure of the loss elastic-plastic, 1.6 times the yield
    strength, a second simulation at 2.8 times shows the range of the forces.

    Several chain files are simulated one after another.  A table and --plot compare them.  If
    --speed or --height is repeated, the table has each chain at each speed or height, and --plot
    shows the peaks over it.  The table has a column with the first maximum in each sensor, and
    --plot a panel for each.  Summaries are then printed only with an option such as --contacts.

    With --stream, trajectories are kept only on disk, in netCDF files, and memory does not
    grow with the run.  If a run is interrupted, run the same command again and it resumes.

    \b
    Examples:
      hertzchain simulate --beads 50 --until 60 --out run.nc
      hertzchain simulate --taper forward-exponential --rate 0.05 --beads 60 --plot run.png
      hertzchain simulate --material steel-52100 --diameter "20 mm:5 mm" --beads 40 \\
          --speed "0.1 m/s" --wall same --animate impact.gif
      hertzchain simulate experiment.toml --until 700us --budget
      hertzchain simulate experiment.toml --until 700us --sensor "ball 5" --plot forces.png
      hertzchain simulate experiment.toml --sensor "ball 5" --forces forces.csv
      hertzchain simulate experiment.toml --cap "100 g"
      hertzchain simulate equal.toml tapered.toml --plot comparison.png
      hertzchain simulate equal.toml tapered.toml --speed 0.1m/s --speed 0.2m/s
      hertzchain simulate experiment.toml --height 1mm --height 2mm --plot peaks.png
      hertzchain simulate experiment.toml --loss elastic-plastic --hits 3
      hertzchain simulate experiment.toml --loss "elastic-plastic, factor=2.8"
      hertzchain simulate experiment.toml --until 10s --times 100000 --stream long
      hertzchain simulate --beads 50 --until 60 --times 600 --waves --horizon
      hertzchain simulate --beads 60 --wall rigid --reflection 45:wall
    """
    check_writable(animation, "--animate", (".gif", ".mp4"))
    check_writable(out, "--out", (".nc", ".csv"))
    check_writable(forces, "--forces", (".csv",))
    if magnify is not None and animation is None:
        raise click.UsageError("--magnify requires --animate")
    chains, impacts = chains_at_impacts(options)
    resolve_waves = bool(waves or reflection) and times is None
    if times is None:
        times = _usual_times(chains, plot, fine=bool(sensors or forces or animation))
    of_saved_times = {
        "out": out, "forces": forces, "plot": plot, "animate": animation, "sensor": sensors,
        "budget": budget, "waves": waves, "reflection": reflection, "horizon": horizon,
    }  # fmt: skip
    _check_times(times, stream=stream, **of_saved_times)
    if len(chains) > 1 and (out or forces or animation or stream):
        raise click.UsageError(SINGLE)
    check_hits(hits, chains.values())
    check_reflection(reflection, chains.values())
    beads = {name: _beads(chain, sensors, forces) for name, chain in chains.items()}
    if stream is not None:
        check_stream_options(**of_saved_times, contacts=contacts, hits=hits, max_steps=max_steps)
        (chain,) = chains.values()
        steps = {"rtol": rtol, "method": method, "step": time_from("--step", step, chain),
                 "drift": drift}  # fmt: skip
        stream_into(stream, chain, until=until, times=times, steps=steps, as_json=as_json)
        return
    settings = {"times": times, "rtol": rtol, "method": method, "drift": drift,
                "max_steps": max_steps}  # fmt: skip
    runs = runs_of(chains, until, step, settings, horizon=horizon,
                   resolve_waves=resolve_waves, quiet=bool(impacts))  # fmt: skip
    for name, run in runs.items():
        _save(run, beads[name], out, forces, animation, magnify)
    others = {name: _at_other_pressure(run, until, step, settings) for name, run in runs.items()}
    yielding = {name: peaks_if_yielding(run) for name, run in runs.items()}
    peaks = peaks_of(runs, others, yielding, beads) if len(runs) > 1 else None
    drawn = plot is None or _plot(plot, runs, peaks, impacts, beads, yielding, sensors)
    again = {name: _hits(run, hits, until, step, settings) for name, run in runs.items()}
    shown: dict[str, Any] = {"second": hits is None, "waves": waves, "contacts": contacts,
                             "budget": budget, "reflection": reflection}  # fmt: skip
    if as_json:
        found = [run_as_dict(run, beads[name], others[name], yielding[name], **shown)
                 for name, run in runs.items()]  # fmt: skip
        for each, (name, every) in zip(found, again.items(), strict=True):
            each |= {"hits": hits_as_list(every, beads[name])} if hits else {}
        show_json(found[0] if len(found) == 1 else together(runs, found))
    else:
        compared = compared_runs(runs, others, yielding, beads, impacts, peaks)
        if not (impacts and compared) or horizon or hits or any([*shown.values()][1:]):
            typed = shown | {"sensors": sensors}
            _show(runs, others, yielding, beads, again if hits else {}, typed)
        _show_table(compared, only=bool(impacts))
    if not drawn:
        raise click.ClickException(NOTHING)


def _plot(
    plot: Path, runs: dict[str, Run], peaks: Peaks | None, impacts: Impacts,
    beads: dict[str, list[int]], yielding: dict[str, Yielding], sensors: tuple[str, ...],
) -> bool:  # fmt: skip
    """Save the figure; whether there is anything to plot."""
    if nothing_to_plot(runs, peaks, impacts, beads):
        return False
    over = drawn_over_impacts(runs, peaks, impacts, beads)
    save_figure(over or _drawn(runs, beads, yielding, peaks, forces=bool(sensors)), plot)
    return True


def _show_table(compared: tuple[Table, list[str]] | None, *, only: bool) -> None:
    """Print the table of several chains, if there is one, and its notes."""
    if compared is None:
        return
    table, notes = compared
    if not only:
        click.echo()
    show_table(table)
    for note in notes:
        show_text(note)


def _show(
    runs: dict[str, Run], others: dict[str, Run | None], yielding: dict[str, Yielding],
    beads: dict[str, list[int]], again: dict[str, list[Run]], shown: dict[str, Any],
) -> None:  # fmt: skip
    """Print the summaries of runs and of their repetitions."""
    for i, (name, run) in enumerate(runs.items()):
        heading = f"{name}: " if len(runs) > 1 else ""
        click.echo("\n" * (i > 0) + heading, nl=False)
        show_run(run, beads[name], others[name], yielding[name], **shown)
        if name in again:
            show_table(hit_table(again[name], beads[name]))


def _usual_times(chains: dict[str, Chain], plot: Path | None, *, fine: bool) -> int:
    """Number of saved times without the option; forces require many."""
    from ..simulation.sensor_force import MANY_TIMES

    many = fine or len(chains) > 1 or (plot is not None and _with_forces(chains))
    return MANY_TIMES if many else USUAL_TIMES


def _check_times(times: int, **options: object) -> None:
    """Raise `click.UsageError` if an option requires more saved times."""
    names = [f"--{name}" for name in options]
    if times < 2 and any(options.values()):
        raise click.UsageError(
            f"{', '.join(names[:-1])} and {names[-1]} require saved times: --times {times} is too "
            "few"
        )


def _beads(chain: Chain, sensors: tuple[str, ...], forces: Path | None) -> list[int]:
    """Numbers of the beads with sensors, from numbers or names such as ``ball 11``.

    Walls are omitted, because their forces are always reported.
    """
    from ..chain.bead_names import bead_label, bead_number, wall_number

    inside = [each for each in sensors if wall_number(chain, each) is None]
    beads = [bead_number(chain, bead_from(each), "--sensor", walls=True) for each in inside]
    for i, bead in enumerate(beads):
        if bead in beads[:i]:
            raise click.UsageError(f"--sensor names {bead_label(chain, bead)} twice; keep one")
    if forces is not None and not _places(chain, beads):
        raise click.UsageError(
            "--forces requires a force: add --sensor BEAD, --wall MATERIAL or --cap MASS"
        )
    return beads


def _places(chain: Chain, beads: list[int]) -> list[int | str]:
    """Sensors, walls and a cap without a wall, for a table of forces."""
    from ..chain.bead_names import walls_of

    body = ["body"] * chain._free_cap
    return [*beads, *(f"{side} wall" for side in walls_of(chain)), *body]


def _hits(
    run: Run, hits: int | None, until: str | None, step: str | None, settings: dict[str, Any]
) -> list[Run]:
    """The run and its repetitions with the dents of the previous ones."""
    from ..errors import ModelRangeWarning
    from ..recorded_warnings import ignore_warnings
    from ..simulation.hits import struck_repeatedly

    end, length = time_from("--until", until, run.chain), time_from("--step", step, run.chain)
    # Warnings are those of the first hit.
    with ignore_warnings(ModelRangeWarning), progress_bar("beads passed, later hits") as progress:
        options = {"until": end, "step": length, "progress": progress} | settings
        return struck_repeatedly(run, hits or 1, **options)


def _at_other_pressure(
    run: Run, until: str | None, step: str | None, settings: dict[str, Any]
) -> Run | None:
    """The run at the largest possible yield pressure, if contacts yield at an assumed one."""
    end, length = time_from("--until", until, run.chain), time_from("--step", step, run.chain)
    return second_run(run, until=end, step=length, **settings)


def _save(
    run: Run, beads: list[int], out: Path | None, forces: Path | None, animation: Path | None,
    magnify: float | None,
) -> None:  # fmt: skip
    """Write the files of a run other than plots."""
    if out is not None:
        run.save(out)
    if forces is not None:
        run.save_forces(forces, _places(run.chain, beads))
    if animation is not None:
        from ..plotting.animation import SENSORS

        if len(beads) > len(SENSORS):
            click.echo(f"the animation shows the first {len(SENSORS)} sensors only", err=True)
        with progress_bar("frames") as progress:
            sensors = beads[: len(SENSORS)]
            run.animate(animation, magnify=magnify, sensors=sensors, progress=progress)


def _curves(chain: Chain, beads: list[int]) -> list[int | str]:
    """Sensors, walls and a cap without a wall, whose forces are plotted."""
    from ..chain.bead_names import walls_of

    walls = walls_of(chain).values()
    if not chain._free_cap:
        return [*beads, *walls]
    return [*(bead for bead in beads if bead != chain.beads), *walls, "body"]


def _with_forces(chains: dict[str, Chain]) -> bool:
    """Whether a figure without sensors has forces on walls or caps."""
    return any(_curves(chain, []) for chain in chains.values())


def _drawn(
    runs: dict[str, Run], beads: dict[str, list[int]], yielding: dict[str, Yielding],
    peaks: Peaks | None, *, forces: bool,
) -> Axes:  # fmt: skip
    """Plot forces in sensors, on walls and on caps, and velocities of one run as a map.

    A sensor in a cap without a wall is replaced by the whole force on it.  The figure of the forces
    of several runs has a title if elastic contacts are beyond yield.
    """
    from ..plotting.decades import extends_over_decades, is_pale
    from ..plotting.labels import with_losses
    from ..plotting.legends import figure_of
    from ..plotting.pulses import plot_pulses
    from ..plotting.run_overview import plot_run_and_forces
    from ..plotting.runs import plot_forces_of_runs
    from ..plotting.style import literal, set_figure_title, with_line

    title = figure_title(runs, yielding, peaks.at if peaks else {})
    beyond = beyond_yield(runs, yielding)
    labels = with_losses({name: run.chain for name, run in runs.items()})
    runs = {labels[name]: run for name, run in runs.items()}
    beads = {labels[name]: places for name, places in beads.items()}
    first, *others = runs.values()
    shown = {name: _curves(run.chain, beads[name]) for name, run in runs.items()}
    if not others and not forces:
        places = next(iter(shown.values()))
        if places:
            return with_line(plot_run_and_forces(first, places), beyond)
        return first.plot(relative=is_pale(first))
    if not all(shown.values()):
        pulses = [run.pulse() for run in runs.values()]
        log = extends_over_decades(pulses, "velocity")
        return plot_pulses(pulses, labels=[*map(literal, runs)], log=log)
    if not others:
        return with_line(first.plot_forces(*shown.values()), beyond)
    axes = plot_forces_of_runs(runs, shown)
    if title:
        set_figure_title(figure_of(axes), title)
    return axes

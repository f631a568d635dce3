"""The command `compare`: compare a simulation with measured traces, without a fit."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from ..recorded_warnings import ignore_warnings
from ..simulation.yielding import pressures_below_yield
from .chain_changes import at_speed, law_from
from .chain_completion import complete_losses
from .exit_codes import DONE, OUTSIDE_TOLERANCE
from .fit_options import begin_option, part_of, until_option
from .options import (
    StrictCommand,
    check_chain_file,
    figure_option,
    json_option,
    noise_from,
    noise_option,
    seconds_from,
    sensors_from,
    sensors_option,
)
from .output import save_figure, show_json
from .progress import progress_bar
from .wording import on_command_line
from .wrapped_text import show_text

if TYPE_CHECKING:
    from ..fitting.settings import Settings
    from ..fitting.trace_comparison import TraceComparison
    from ..traces.traces import Traces

# Value of --time-offset that finds it by least squares.
FREE: Final = "free"


@click.command(cls=StrictCommand)
@click.argument("traces", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.argument("chain", type=click.Path(path_type=Path))
@sensors_option
@noise_option
@click.option(
    "--speed",
    "--velocity",
    "speed",
    metavar="SPEED",
    help="Velocity of the impact instead of that of CHAIN, such as '0.1 m/s'.",
)
@click.option(
    "--loss",
    metavar="LAW",
    shell_complete=complete_losses,
    help="Loss law instead of that of CHAIN, such as restitution=0.96 or viscoelastic='0.6 us'.",
)
@click.option("--shot", type=int, metavar="NUMBER", help="Shot of the traces, from 1.")
@begin_option
@until_option
@click.option(
    "--time-offset",
    metavar="TIME",
    help="Time of the data at which the simulation begins, or 'free' to find it by least squares.  "
    "[default: that of the table [fit] of CHAIN, or the start of a drive in the file of the "
    "traces; otherwise free]",
)
@json_option()
@figure_option("Plot data and simulation to FILE.")
def compare(
    traces: tuple[Path, ...], chain: Path, sensors: tuple[str, ...], noises: tuple[str, ...],
    speed: str | None, loss: str | None, shot: int | None, begin: str | None,
    until: str | None, time_offset: str | None, as_json: bool, plot: Path | None,
) -> int:  # fmt: skip
    """Compare a simulation with measured traces, without a fit.

    TRACES is a CSV file, or one for each channel, and CHAIN a chain file, as for `hertzchain fit`.
    If the files of channels have the same header, name the files, as in --sensor ch1.csv=wall.
    The chain is simulated, and peaks, arrivals and residuals of all sensors are printed.
    --from and --until select samples by the times of the data, as in `hertzchain fit`; the
    simulation lasts as long as they do.

    The exit code is 3 if columns are probably exchanged, which the first line then says.

    \b
    Examples:
      hertzchain compare data.csv experiment.toml
      hertzchain compare scope.csv experiment.toml --sensor CH1=wall --sensor "CH2=ball 5"
      hertzchain compare ch1.csv ch2.csv experiment.toml --sensor ch1.csv=wall \\
          --sensor "ch2.csv=ball 5"
      hertzchain compare data.csv experiment.toml --time-offset 80us --plot compared.png
      hertzchain compare data.csv experiment.toml --until 634us
      hertzchain compare data.csv experiment.toml --speed "0.32 m/s" --loss restitution=0.96
    """
    import hertzchain

    from ..chain.yield_pressure import assumed_for_all
    from ..errors import InputWarning
    from ..fitting.arrival_notes import ALL_ARRIVALS
    from ..fitting.compared_run import run_to_compare
    from ..fitting.parameters import priors_of_gains
    from ..fitting.prior_conflicts import gain_notes
    from ..fitting.settings import load_experiment

    check_chain_file(chain)
    noise: Any = noise_from(noises)
    seen = hertzchain.load_traces(
        *traces, sensors=sensors_from(sensors), channels=True, noise=noise
    )
    seen, (described, *_), settings = load_experiment(seen, chain, hertzchain.load_traces)
    data = _one_shot(_timed(seen, settings, time_offset), shot)
    priors = priors_of_gains(settings.priors, data)
    if speed is not None:
        described = at_speed(described, speed)
    if loss is not None:
        described = described.replace(loss=law_from(loss, described))
    first = float(data.shots[0].times[0])
    data = part_of(data, begin, until)
    # Without a time offset, the impact may be before the samples that --from selects.
    if data.shots[0].clock is not None:
        first = min(data.shots[0].time_offset, first)
    with progress_bar("beads passed") as progress:
        run = run_to_compare(described, data, first, progress=progress)
    with ignore_warnings(InputWarning):  # the summary lists them as notes
        found = run.compare(data)
    if not (found.exchanged or any(each.startswith(ALL_ARRIVALS) for each in found.notes)):
        found = dataclasses.replace(found, notes=(*found.notes, *gain_notes(found.sensors, priors)))
    if plot is not None:
        save_figure(found.plot().axes[0], plot)
    if as_json:
        show_json(_as_dict(found))
    else:
        shown = on_command_line(found.summary(width=None)).splitlines()
        lines = [described.description, *pressures_below_yield(run)]
        # The statement that columns are exchanged is the first line.
        lines = [*shown[:1], *lines, *shown[1:]] if found.exchanged else [*lines, *shown]
        if assumed := assumed_for_all(described):
            lines.append(on_command_line(f"note: {assumed}"))
        show_text("\n".join(lines))
    return OUTSIDE_TOLERANCE if found.exchanged else DONE


def _timed(traces: Traces, settings: Settings, time_offset: str | None) -> Traces:
    """Traces with the time offset of the option, or with those that a fit would fix."""
    from ..fitting.clocks import with_clocks
    from ..traces.traces import Traces, with_time_offset

    if time_offset == FREE:
        return Traces(tuple(dataclasses.replace(shot, clock=None) for shot in traces.shots))
    if time_offset is not None:
        return with_time_offset(traces, seconds_from("--time-offset", time_offset))
    return with_clocks(traces, settings)[0]


def _one_shot(traces: Traces, shot: int | None) -> Traces:
    from ..traces.traces import Traces
    from ..validation.numbers import whole_number

    count = len(traces.shots)
    if shot is None and count > 1:
        raise click.UsageError(f"the file has {count} shots: add --shot with a number from 1")
    if shot is not None and count == 1 and shot != 1:
        raise click.UsageError(f"the file has one shot, so --shot {shot} does not exist; omit it")
    number = whole_number("--shot", 1 if shot is None else shot, least=1, most=count)
    return Traces(traces.shots[number - 1 : number])


def _as_dict(found: TraceComparison) -> dict[str, Any]:
    """Plain values for JSON: numbers that do not exist are `None`."""
    from ..validation.json_types import finite

    sensors = [finite(dataclasses.asdict(each)) for each in found.sensors]
    return {
        "time_offset": found.time_offset,
        "time_offset_error": None if found.time_offset_given else found.time_offset_error,
        "interval": list(found.interval),
        "covered": found.covered, "exchanged": found.exchanged,
        "sensors": sensors, "notes": list(found.notes),
    }  # fmt: skip

"""The command line: parse, call one library function, show.

Results go to stdout, messages and progress to stderr.  Exit codes: 0 done,
1 failed, 2 bad usage or input or a run that cannot finish, 3 finished but outside
tolerance, 130 interrupted.
"""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

# Nothing heavier here: `--help` must answer at once, so commands import what they need.
if TYPE_CHECKING:
    from rich.table import Table

    from hertzchain.calibration import Calibration
    from hertzchain.chain import Chain
    from hertzchain.paper.reproduction import Reproduction
    from hertzchain.pulse import Pulse, Quantity
    from hertzchain.run import Run
    from hertzchain.scoreboard import Scoreboard
    from hertzchain.verification import Verdict

DONE, FAILED, BAD_INPUT, OUTSIDE_TOLERANCE, INTERRUPTED = 0, 1, 2, 3, 130
METHODS: Final = (
    "propagate", "simulate", "bca", "modified-bca", "modified-bca-printed", "two-thirds-bca",
    "hard-sphere", "local-rate",
)  # fmt: skip
TABLE_ROWS: Final = 26
# Where no bar can be drawn, a line of progress appears so often.
SECONDS_PER_LINE: Final = 5.0


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(package_name="hertzchain")
def cli() -> None:
    """Impacts on granular chains: simulate, predict, compare.

    \b
    Example:
      hertzchain pulse --taper backward-exponential --rate 0.05 --beads 100
    """


def main() -> None:
    """Run the command line and leave with its exit code."""
    from hertzchain.errors import InputError, SimulationError

    try:
        with warnings.catch_warnings():
            warnings.showwarning = _show_warning
            code = cli.main(standalone_mode=False)
    except click.ClickException as error:
        error.show()
        code = error.exit_code
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted", err=True)
        code = INTERRUPTED
    except InputError as error:
        click.echo(f"Error: {error}", err=True)
        code = BAD_INPUT
    except SimulationError as error:
        click.echo(f"Error: {error}", err=True)
        code = BAD_INPUT
    except OSError as error:
        # Such as a pipe that was closed or a disk that is full.
        if not isinstance(error, BrokenPipeError):
            click.echo(f"Error: cannot write the results: {error.strerror}", err=True)
        sys.stdout = None
        code = FAILED
    sys.exit(code or DONE)


def _show_warning(message: Warning | str, *_: object, **__: object) -> None:
    click.echo(f"Warning: {message}", err=True)


def chain_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options that describe a chain, shared by the commands that need one."""
    for option in (
        click.argument("file", required=False, type=click.Path(path_type=Path)),
        click.option(
            "--chain",
            "chain_file",
            type=click.Path(path_type=Path),
            metavar="FILE",
            help="The same as FILE: TOML, or CSV with a row a bead.",
        ),
        click.option(
            "--taper",
            help="uniform, or backward-/forward- with linear/exponential.  [default: uniform]",
        ),
        click.option("--rate", type=float, help="Tapering parameter: S (linear), q (exponential)."),
        click.option("--beads", type=int, help="Number of beads N.  [default: 100]"),
    )[::-1]:
        command = option(command)
    return command


@cli.command()
@chain_options
@click.option(
    "--method",
    "methods",
    multiple=True,
    default=("propagate",),
    show_default=True,
    metavar="NAME",
    help=f"Repeatable: {', '.join(METHODS)}.",
)
@click.option(
    "--quantity",
    default="velocity",
    show_default=True,
    metavar="NAME",
    help="What to draw, and to show side by side when there are several methods: "
    "velocity, momentum, energy, peak_time, arrival, residence, peak_overlap, peak_force, "
    "velocity_error.",
)
@click.option("--log", is_flag=True, help="Draw with a logarithmic ordinate.")
@click.option("--all", "every_bead", is_flag=True, help="Show every bead in the table.")
@click.option("--json", "as_json", is_flag=True, help="Print everything as JSON.")
@click.option("--csv", "as_csv", is_flag=True, help="Print everything as CSV.")
@click.option(
    "--plot",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Also draw the quantity into FILE (.png, .svg or .pdf).",
)
def pulse(
    file: Path | None, chain_file: Path | None, taper: str | None, rate: float | None,
    beads: int | None, methods: tuple[str, ...], quantity: str, every_bead: bool, as_json: bool,
    as_csv: bool, plot: Path | None, log: bool,
) -> None:  # fmt: skip
    """Follow the leading pulse along a chain, by one or several methods.

    The chain comes from the options or from a FILE, TOML or CSV.  One in SI units is
    followed in the paper's scaled variables and shown in SI.

    \b
    Examples:
      hertzchain pulse --taper backward-exponential --rate 0.05 --beads 100
      hertzchain pulse --taper forward-linear --rate 0.009 --method propagate --method bca
      hertzchain pulse chain.toml --csv > pulse.csv
    """
    from hertzchain import store
    from hertzchain.errors import InputError
    from hertzchain.pulse import QUANTITIES

    if as_json and as_csv:
        raise click.UsageError("--json and --csv exclude each other")
    _known("method", methods, METHODS)
    _known("quantity", (quantity,), tuple(QUANTITIES))
    _writable(plot, "--plot", (".png", ".svg", ".pdf"))
    chain = _chain(file, chain_file, taper, rate, beads)
    with _progress("beads passed") as progress:
        pulses = [_compute(method, chain, progress) for method in dict.fromkeys(methods)]
    if plot is not None:
        from hertzchain import plotting

        _save_axes(plotting.plot_pulses(pulses, quantity, log=log), plot)  # type: ignore[arg-type]
    if as_json:
        click.echo(store.pulses_as_json(pulses))
    elif as_csv:
        click.echo(store.pulses_as_csv(pulses), nl=False)
    elif len(pulses) == 1:
        _show(_pulse_table(pulses[0], every_bead))
    else:
        for missing in (other for other in pulses if other.column(quantity) is None):  # type: ignore[arg-type]
            raise InputError(f"{missing.method} does not predict {quantity}")
        _show(_side_by_side(pulses, quantity, every_bead))  # type: ignore[arg-type]
        for other in pulses[1:]:
            click.echo(f"\n{other.compare(pulses[0])}")


@cli.command()
@chain_options
@click.option("--until", type=float, help="Time to stop at.  [default: when the pulse has left]")
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
    help="Draw velocities over time and bead into FILE (.png, .svg or .pdf).",
)
@click.option("--budget", is_flag=True, help="Print where energy and momentum are at the end.")
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON.")
def simulate(
    file: Path | None, chain_file: Path | None, taper: str | None, rate: float | None,
    beads: int | None, until: float | None, times: int, rtol: float, max_steps: int | None,
    out: Path | None, plot: Path | None, budget: bool, as_json: bool,
) -> None:  # fmt: skip
    """Integrate the whole chain and keep its trajectories.

    \b
    Examples:
      hertzchain simulate --beads 50 --until 60 --out run.nc
      hertzchain simulate --taper forward-exponential --rate 0.05 --beads 60 --plot run.png
      hertzchain simulate experiment.toml --until 7e-4 --budget
    """
    from hertzchain import simulation, store

    _writable(plot, "--plot", (".png", ".svg", ".pdf"))
    _writable(out, "--out", (".nc", ".csv"))
    if budget and as_json:
        raise click.UsageError("--budget and --json exclude each other")
    if times < 2 and (out is not None or plot is not None or budget):
        raise click.UsageError(
            f"--out, --plot and --budget need saved times: --times {times} is too few"
        )
    chain = _chain(file, chain_file, taper, rate, beads)
    with _progress("beads passed") as progress:
        run = simulation.simulate(
            chain, until=until, times=times, rtol=rtol, max_steps=max_steps, progress=progress
        )
    if out is not None:
        store.save_run(run, out)
    if plot is not None:
        _save_axes(run.plot(), plot)
    _show_run(run, as_json)
    if budget:
        click.echo(run.budget())


@cli.command()
@click.option(
    "--only", metavar="NAMES", help="Parts to do, separated by commas: table1, figure5, errata, ..."
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("reproduction"),
    show_default=True,
    metavar="DIR",
    help="Folder for report, figures and data.",
)
@click.option(
    "--window-exponential",
    metavar="FIRST:LAST",
    default="5:80",
    show_default=True,
    help="Beads of the fits in tables 1 and 2.",
)
@click.option(
    "--window-linear",
    metavar="FIRST:LAST",
    default="5:60",
    show_default=True,
    help="Beads of the fit in table 3.",
)
@click.option("--json", "as_json", is_flag=True, help="Print verdict.json.")
def reproduce(
    only: str | None, out: Path, window_exponential: str, window_linear: str, as_json: bool
) -> None:
    """Regenerate every table and figure of the paper and say where they agree.

    Writes report.html, verdict.json, summary.md and figures/ into the folder.
    Leaves with exit code 3 if anything is outside its tolerance.

    \b
    Examples:
      hertzchain reproduce
      hertzchain reproduce --only table1,figure5 --out check
    """
    import json

    from hertzchain.paper import report, reproduction

    parts = None if only is None else [part.strip() for part in only.split(",") if part.strip()]
    windows = {
        "exponential": _window("--window-exponential", window_exponential),
        "linear": _window("--window-linear", window_linear),
    }
    report.check_writable(out)
    with _progress("chains integrated") as progress:
        result = reproduction.reproduce(parts, windows=windows, progress=progress)  # type: ignore[arg-type]
    with _progress("figures drawn") as progress:
        page = report.write_report(result, out, progress=progress)
    if as_json:
        click.echo(json.dumps(report.verdict(result), indent=2, allow_nan=False))
    else:
        _show_reproduction(result)
        click.echo(f"Report: {page}")
    if not result.within_tolerance:
        sys.exit(OUTSIDE_TOLERANCE)


@cli.command()
@click.option(
    "--taper",
    "tapers",
    multiple=True,
    metavar="NAME",
    help="Taper to calibrate; repeatable.  [default: all four]",
)
@click.option(
    "--rates",
    metavar="NUMBERS",
    help="Its S or q, separated by commas; with one --taper.  [default: those of the paper]",
)
@click.option(
    "--window", metavar="FIRST:LAST", default="5:80", show_default=True, help="Beads of the fit."
)
@click.option("--beads", type=int, default=100, show_default=True, help="Beads of each chain.")
@click.option(
    "--output",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Also write the constants into FILE (.toml).",
)
@click.option("--json", "as_json", is_flag=True, help="Print everything as JSON.")
def calibrate(
    tapers: tuple[str, ...], rates: str | None, window: str, beads: int, output: Path | None,
    as_json: bool,
) -> None:  # fmt: skip
    """Fit the constants of the modified BCA to the integration, as the paper did.

    Shows each constant with its standard error and what the paper prints for it, and how
    far the fitted velocity is off.

    \b
    Examples:
      hertzchain calibrate
      hertzchain calibrate --taper forward-linear --rates 0.01,0.015 --beads 60 --window 5:50
    """
    import json

    from hertzchain import calibration, store
    from hertzchain.chain import TAPERS

    _known("taper", tapers, TAPERS)
    _writable(output, "--output", (".toml",))
    chosen = tuple(dict.fromkeys(tapers)) or TAPERS
    if rates is not None and len(chosen) != 1:
        raise click.UsageError("--rates are those of one taper: give one --taper")
    numbers = None if rates is None else _numbers("--rates", rates)
    beads_of_fit = _window("--window", window)
    with _progress("chains integrated") as progress:
        found = [
            calibration.calibrate(
                taper,  # type: ignore[arg-type]
                rates=numbers,
                window=beads_of_fit,
                beads=beads,
                progress=progress,
            )
            for taper in chosen
        ]
    if output is not None:
        store.write_bytes(output, calibration.calibrated_toml(found).encode())
    if as_json:
        document: dict[str, Any] = {"schema_version": store.SCHEMA_VERSION}
        document["calibrations"] = [result.as_dict() for result in found]
        click.echo(json.dumps(document, indent=2, allow_nan=False))
        return
    for result in found:
        _show_calibration(result)


@cli.command()
@click.option(
    "--quantity",
    default="velocity",
    show_default=True,
    metavar="NAME",
    help="What to judge: velocity, momentum, energy, arrival, peak_force.",
)
@click.option(
    "--first-bead", type=int, default=10, show_default=True, help="First bead that counts."
)
@click.option("--rms", is_flag=True, help="Show the root mean square instead of the worst error.")
@click.option("--all", "every_chain", is_flag=True, help="A row for each chain, not each family.")
@click.option(
    "--figure",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Also draw the table into FILE (.png, .svg or .pdf).",
)
@click.option(
    "--json", "as_json", is_flag=True, help="Print all quantities, from beads 2 and 10 on, as JSON."
)
def scoreboard(
    quantity: str, first_bead: int, rms: bool, every_chain: bool, figure: Path | None,
    as_json: bool,
) -> None:  # fmt: skip
    """Hold every theory against the integration: which one to trust where.

    The paper's four tapers at its rates and beyond, and tapers that no theory was fitted
    to; 100 beads each. Errors count up to bead 97, short of the free end.

    \b
    Examples:
      hertzchain scoreboard
      hertzchain scoreboard --quantity arrival --first-bead 2 --figure arrival.png
    """
    import json

    from hertzchain import scoreboard as board_module
    from hertzchain import store

    _known("quantity", (quantity,), board_module.JUDGED)
    _writable(figure, "--figure", (".png", ".svg", ".pdf"))
    with _progress("chains integrated") as progress:
        board = board_module.scoreboard(progress=progress)
    what: dict[str, Any] = {"quantity": quantity, "first_bead": first_bead}
    what["statistic"] = "rms" if rms else "worst"
    board.table(**what)  # refuses a bead that is not there, before anything is written
    if figure is not None:
        from hertzchain import plotting

        _save_axes(plotting.plot_scoreboard(board, **what), figure)
    if as_json:
        document = {"schema_version": store.SCHEMA_VERSION} | board.as_dict()
        click.echo(json.dumps(document, indent=2, allow_nan=False))
    else:
        _show(_scoreboard_table(board, by="case" if every_chain else "family", **what))


@cli.command()
@click.option(
    "--only", metavar="NAMES", help="Groups of cases, separated by commas: walls, dimers, ..."
)
@click.option("--json", "as_json", is_flag=True, help="Print everything as JSON.")
def verify(only: str | None, as_json: bool) -> None:
    """Compute quantities with exact or published values and hold them against these.

    Leaves with exit code 3 if any is outside its tolerance.

    \b
    Examples:
      hertzchain verify
      hertzchain verify --only restitution,walls
    """
    import json

    from hertzchain import verification

    groups = None if only is None else [part.strip() for part in only.split(",") if part.strip()]
    with _progress("cases computed") as progress:
        verdicts = verification.verify(groups, progress=progress)
    if as_json:
        click.echo(json.dumps(verification.as_dict(verdicts), indent=2, allow_nan=False))
    else:
        _show_verdicts(verdicts)
    if not all(verdict.agrees for verdict in verdicts):
        sys.exit(OUTSIDE_TOLERANCE)


@cli.command()
def cite() -> None:
    """Print what to cite: the paper, the methods, this software.

    \b
    Example:
      hertzchain cite
    """
    from hertzchain.citations import CITATIONS

    click.echo("\n\n".join(CITATIONS))


def _chain(
    file: Path | None,
    chain_file: Path | None,
    taper: str | None,
    rate: float | None,
    beads: int | None,
) -> Chain:
    from hertzchain.chain import TAPERS, Chain
    from hertzchain.chain_files import load_chain
    from hertzchain.errors import unknown_name

    if file is not None and chain_file is not None:
        raise click.UsageError("give the chain as FILE or as --chain FILE, not both")
    file = chain_file if file is None else file
    if file is not None:
        if not (taper is None and rate is None and beads is None):
            raise click.UsageError("give a chain FILE or --taper, --rate and --beads, not both")
        return load_chain(file)
    count = 100 if beads is None else beads
    if taper is None and rate is not None:
        raise click.UsageError(f"--rate needs --taper: {', '.join(TAPERS)}")
    if taper is None or taper == "uniform":
        if rate is not None:
            raise click.UsageError("a uniform chain has no --rate")
        return Chain.uniform(count)
    if taper not in TAPERS:
        raise unknown_name("taper", taper, (*TAPERS, "uniform"))
    if rate is None:
        usual = "its S, such as 0.005" if taper.endswith("linear") else "its q, such as 0.05"
        raise click.UsageError(f"--taper {taper} needs --rate, {usual}")
    return Chain.tapered(taper, rate, beads=count)


def _compute(method: str, chain: Chain, progress: Callable[[int, int], None]) -> Pulse:
    from hertzchain import Scales, propagate, simulate
    from hertzchain.hertz_range import warn_outside_hertz
    from hertzchain.theory.catalogue import THEORIES

    if chain.units == "SI" and method != "simulate":
        scales = Scales.of(chain)
        pulse = scales.to_si(_compute(method, scales.to_scaled(chain), progress))
        if pulse.peak_overlap is not None:
            warn_outside_hertz(chain, pulse.peak_overlap)
        return pulse
    if method == "propagate":
        return propagate(chain, progress=progress)
    if method == "simulate":
        return simulate(chain, times=0, progress=progress).pulse()
    return THEORIES[method](chain)


def _known(what: str, names: tuple[str, ...], choices: tuple[str, ...]) -> None:
    from hertzchain.errors import unknown_name

    for name in names:
        if name not in choices:
            raise unknown_name(what, name, choices)


def _window(option: str, text: str) -> tuple[int, int]:
    try:
        first, last = (int(part) for part in text.split(":"))
    except ValueError:
        raise click.UsageError(f"{option} must look like 5:60, got {text!r}") from None
    return first, last


def _numbers(option: str, text: str) -> tuple[float, ...]:
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise click.UsageError(f"{option} must look like 0.01,0.02, got {text!r}") from None


@contextmanager
def _progress(what: str) -> Iterator[Callable[[int, int], None]]:
    """A bar on stderr that vanishes when done; in a pipe or file, a line now and then."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn()
    console = Console(stderr=True)
    if not console.is_terminal:
        yield _lines_of_progress(what)
        return
    with Progress(
        *columns, TimeElapsedColumn(), console=console, transient=True
    ) as bar:  # fmt: skip
        task = bar.add_task("starting; the first use on a machine compiles", total=None)
        yield lambda done, total: bar.update(task, description=what, completed=done, total=total)


def _lines_of_progress(what: str) -> Callable[[int, int], None]:
    told: list[float] = []

    def update(done: int, total: int) -> None:
        now = time.monotonic()
        if told and now - told[-1] < SECONDS_PER_LINE:
            return
        if told:
            click.echo(f"{what}: {done} of {total}", err=True)
        told.append(now)

    return update


def _show(table: Table) -> None:
    from rich.console import Console

    # Never shorten a number: a narrow terminal folds the line itself.
    needed = Console(width=1000).measure(table).maximum
    Console(width=max(needed, Console().width)).print(table)


def _rows(beads: int, every_bead: bool) -> list[int]:
    """Indices of the beads to show: all, or evenly spread ones with both ends."""
    import numpy as np

    if every_bead or beads <= TABLE_ROWS:
        return list(range(beads))
    return [int(i) for i in np.unique(np.linspace(0, beads - 1, TABLE_ROWS).round())]


def _table(title: str, shown: int, beads: int) -> Table:
    from rich import box
    from rich.table import Table

    caption = None if shown == beads else f"{shown} of {beads} beads; --all shows every one"
    table = Table(title=title, caption=caption, box=box.SIMPLE_HEAD, title_justify="left")
    table.add_column("bead k", justify="right")
    return table


def _pulse_table(pulse: Pulse, every_bead: bool) -> Table:
    from rich.markup import escape

    from hertzchain.pulse import QUANTITIES

    beads = pulse.chain.beads
    rows = _rows(beads, every_bead)
    table = _table(f"{pulse.method}: {pulse.chain.description}", len(rows), beads)
    columns = pulse.columns()
    for name in columns:
        symbol = QUANTITIES[name][0]
        unit = "" if pulse.chain.units == "scaled" else f" [{pulse.unit(name)}]"
        table.add_column(f"{name}\n{symbol}{escape(unit)}", justify="right", no_wrap=True)
    for i in rows:
        cells = (f"{values[i]:.6g}" if i < len(values) else "" for values in columns.values())
        table.add_row(str(i + 1), *cells)
    return table


def _side_by_side(pulses: list[Pulse], quantity: Quantity, every_bead: bool) -> Table:
    chain = pulses[0].chain
    rows = _rows(chain.beads, every_bead)
    unit = "" if chain.units == "scaled" else f" in {pulses[0].unit(quantity)}"
    table = _table(f"{quantity}{unit}: {chain.description}", len(rows), chain.beads)
    columns = [pulse.column(quantity) for pulse in pulses]
    for pulse in pulses:
        table.add_column(pulse.method, justify="right")
    for i in rows:
        cells = (
            f"{values[i]:.8g}" if values is not None and i < len(values) else ""
            for values in columns
        )
        table.add_row(str(i + 1), *cells)
    return table


def _show_run(run: Run, as_json: bool) -> None:
    import json

    from hertzchain import store

    summary = {
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
        document = {"schema_version": store.SCHEMA_VERSION} | summary
        document["chain"] = store.chain_as_dict(run.chain)
        click.echo(json.dumps(document, indent=2, allow_nan=False))
        return
    click.echo(f"{run.chain.description}\n{run.message}")
    click.echo(f"energy drift {run.energy_drift:.1e}, momentum drift {run.momentum_drift:.1e}")
    click.echo(f"{len(run.times)} times saved, {run.evaluations} evaluations of the force")


def _show_calibration(result: Calibration) -> None:
    from rich import box
    from rich.table import Table

    from hertzchain.chain import rate_symbol

    first, last = result.window
    click.echo(f"{result.taper}, beads {first}..{last} of {result.beads}")
    table = Table(title=result.correction.formula, box=box.SIMPLE_HEAD, title_justify="left")
    for heading in ("constant", "value", "standard error", "printed in the paper"):
        table.add_column(heading, justify="right")
    for name, value in result.constants.items():
        error, printed = result.standard_errors[name], result.printed[name]
        table.add_row(name, f"{value:.6g}", f"{error:.2g}", f"{printed:.3g}")
    _show(table)
    click.echo(
        f"relative error of velocity: worst {result.worst_error:.2%}, rms {result.rms_error:.2%}"
    )
    for rate, worst in zip(result.rates, result.worst_by_rate, strict=True):
        click.echo(f"  {rate_symbol(result.taper)} = {rate:<6g} worst {worst:7.2%}")
    click.echo()


def _scoreboard_table(
    board: Scoreboard, *, quantity: str, first_bead: int, statistic: str, by: str
) -> Table:
    from rich import box
    from rich.table import Table

    from hertzchain.scoreboard import percentage
    from hertzchain.scoreboard_cases import GROUPS

    errors = board.table(quantity, first_bead=first_bead, statistic=statistic, by=by)  # type: ignore[arg-type]
    outside = board.outside(by)  # type: ignore[arg-type]
    table = Table(
        title=f"{quantity}: {statistic} relative error in %, k = {first_bead}..{board.last_bead} "
        f"of {len(board.cases)} chains",
        caption="– not covered   * outside its range, as the theory itself warns",
        box=box.SIMPLE_HEAD, title_justify="left", caption_justify="left", pad_edge=False,
        collapse_padding=True,
    )  # fmt: skip
    table.add_column("", no_wrap=True)
    for theory in board.theories:
        table.add_column(theory.replace("-", "-\n"), justify="right", vertical="bottom")
    group = None
    for label, members in board.rows(by).items():  # type: ignore[arg-type]
        if board.cases[members[0]].group != group:
            group = board.cases[members[0]].group
            table.add_section()
            table.add_row(f"[bold]{GROUPS[group]}[/]")
        cells = [percentage(error) for error in errors.loc[label]]
        starred = (
            cell + ("*" if warned and cell != "–" else " ")
            for cell, warned in zip(cells, outside.loc[label], strict=True)
        )
        table.add_row(f" {label}", *starred)
    return table


def _show_reproduction(result: Reproduction) -> None:
    click.echo(result.verdict)
    for table in result.tables:
        for entry in table.entries:
            if not entry.agrees:
                click.echo(
                    f"  outside tolerance: {entry.table}, {entry.taper}, {entry.column}, rate "
                    f"{entry.rate:g}: printed {entry.printed.text}, ours {entry.ours:.7f}"
                )
    for figure in result.figures:
        if not figure.statement.holds:
            click.echo(f"  does not hold: {figure.published.name}: {figure.statement.claim}")


def _show_verdicts(verdicts: list[Verdict]) -> None:
    from rich import box
    from rich.table import Table

    agreeing = sum(verdict.agrees for verdict in verdicts)
    title = f"{agreeing} of {len(verdicts)} cases agree"
    table = Table(title=title, box=box.SIMPLE_HEAD, title_justify="left")
    for name, side in (("quantity", "left"), ("expected", "right"), ("ours", "right"),
                       ("difference", "right"), ("allowed", "right"), ("", "left"),
                       ("source", "left")):  # fmt: skip
        table.add_column(name, justify=side, no_wrap=True)  # type: ignore[arg-type]
    for i, verdict in enumerate(verdicts):
        case = verdict.case
        if i == 0 or case.group != verdicts[i - 1].case.group:
            table.add_row(f"[bold]{case.group}[/bold]")
        table.add_row(
            f"  {case.name}", f"{case.expected:.10g}", f"{verdict.ours:.10g}",
            f"{verdict.difference:+.1e}", f"{case.tolerance:.0e}",
            "" if verdict.agrees else "OUTSIDE", case.source,
        )  # fmt: skip
    _show(table)


def _writable(path: Path | None, option: str, endings: tuple[str, ...]) -> None:
    """Refuse a file that could not be written, before any work is done for it."""
    if path is None:
        return
    if path.suffix not in endings:
        raise click.UsageError(f"{option} {path} must end in {' or '.join(endings)}")
    if not path.parent.is_dir():
        raise click.UsageError(f"{option} {path}: there is no folder {path.parent}")


def _save_axes(axes: Any, plot: Path) -> None:
    from hertzchain import plotting, store

    store.write_bytes(plot, plotting.figure_bytes(axes.figure, plot.suffix[1:]))

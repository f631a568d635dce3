"""The command `sweep`: compute a grid of parameters into a store that survives interruptions."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from ..recorded_warnings import ignore_warnings
from .exit_codes import DONE, FAILED
from .options import (
    PICTURES,
    Fraction,
    StrictCommand,
    as_typed,
    check_writable,
    json_option,
    with_width,
)
from .output import save_figure, show_json
from .progress import progress_bar

if TYPE_CHECKING:
    from ..store.sweep_store import SweepStore


_skip_damaged = click.option(
    "--skip-damaged", is_flag=True, help="Count batches with damaged files as missing."
)


class _Sweep(click.Group):
    """A group whose first argument is a command or the specification to run."""

    command_class = StrictCommand

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        if args and args[0] not in self.commands:
            args = ["run", *args]
        return super().resolve_command(ctx, args)

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        options = [name for option in self.params for name in option.opts]
        if args and args[0].startswith("-") and args[0] not in (*options, "-h", "--help"):
            args = ["run", *args]
        return super().parse_args(ctx, args)


# Number of failed points that are grouped by their reasons, and of reasons that are shown.
MAX_GROUPED, MAX_REASONS = 1000, 5
# Variables that flag points (`hertzchain.store.sweep_export.FLAGS`), and what they say of these.
FLAGGED: Final = {
    "outside_range": "outside the validity range of a method",
    "incomplete": "with an incomplete reflection or force on the wall or the cap",
    "sensitive": "whose largest force on the wall may be sensitive to small changes",
}
# Not contained in an estimate.
START: Final = "starting and compiling (seconds to minutes)"


@click.group(cls=_Sweep)
def sweep() -> None:
    """Compute a grid of parameters: `hertzchain sweep SPEC.toml`.

    The specification defines the axes, the methods and the quantities to keep.  Results are
    written to a zarr folder.  If a sweep is interrupted, run the same command again and it
    resumes.

    \b
    Examples:
      hertzchain sweep taper.toml --dry-run
      hertzchain sweep taper.toml
      hertzchain sweep status taper.zarr
      hertzchain sweep export taper.zarr taper.csv
      hertzchain sweep plot taper.zarr taper.png --quantity momentum

    Workers, shards and a dask scheduler: `hertzchain sweep run --help`.
    """


@sweep.command()
@click.argument("specification", type=click.Path(path_type=Path), metavar="SPEC.toml")
@click.option(
    "--store",
    type=click.Path(path_type=Path),
    metavar="FOLDER",
    help="Folder for results.  [default: the name of SPEC with .zarr, in the working folder]",
)
@click.option("--workers", type=int, help="Threads or processes.  [default: one per processor]")
@click.option("--processes", is_flag=True, help="Use processes instead of threads.")
@click.option(
    "--scheduler", metavar="ADDRESS", help="Use a running dask scheduler: tcp://host:8786."
)
@click.option("--shard", metavar="i/n", help="Compute only part i of n, into a separate store.")
@_skip_damaged
@click.option(
    "--dry-run",
    is_flag=True,
    help="Estimate points, disk space and time; compute nothing.  The specification and an "
    "existing store are checked as for a sweep.",
)
@json_option("Print the outcome as JSON.")
def run(
    specification: Path, store: Path | None, workers: int | None, processes: bool,
    scheduler: str | None, shard: str | None, skip_damaged: bool, dry_run: bool, as_json: bool,
) -> int:  # fmt: skip
    """Compute the points of SPEC.toml that are missing from the store (`run` may be omitted).

    Exit codes: 0 all points are done, 1 some failed or the disk is full, 2 the specification or
    store is invalid, 130 interrupted.
    """
    import hertzchain

    from ..store.sweep_store import SweepStore

    if scheduler is not None and (processes or workers is not None):
        raise click.UsageError("--scheduler has its own workers; omit --processes and --workers")
    part = _shard(shard)
    target = _store_of(specification, part) if store is None else store
    if dry_run:
        _show_estimate(specification, target, workers, as_json)
        return DONE
    with ExitStack() as stack:
        pool = stack.enter_context(_pool(scheduler, processes, workers))
        progress = stack.enter_context(progress_bar("points done", rate=True))
        # The outcome states the numbers of points that failed or are outside the range.
        unshown = hertzchain.ModelRangeWarning, hertzchain.IncompleteWarning
        stack.enter_context(ignore_warnings(*unshown))
        try:
            hertzchain.sweep(
                specification, target, executor=pool, shard=part, skip_damaged=skip_damaged,
                progress=progress,
            )  # fmt: skip
        except KeyboardInterrupt:
            click.echo(_interrupted(target), err=True)
            raise
        except hertzchain.StoreError as error:
            click.echo(f"Error: {error}; run the same command again to resume", err=True)
            return FAILED
    return _show_outcome(SweepStore(target, skip_damaged=skip_damaged), part, as_json)


def _interrupted(target: Path) -> str:
    """Where the finished points of an interrupted sweep are, if there are any."""
    from ..store.sweep_store import SweepStore

    counts = SweepStore(target, skip_damaged=True).counts() if target.exists() else {}
    if not counts.get("done", 0) + counts.get("failed", 0):
        return "no points are finished; run the same command again"
    return f"finished points are in {target}; run the same command again to resume"


@sweep.command()
@click.argument("store", type=click.Path(path_type=Path))
@_skip_damaged
@json_option("Print the status as JSON.")
def status(store: Path, skip_damaged: bool, as_json: bool) -> int:
    """Check all files of a store; show the progress of the sweep and why points failed."""
    from ..store.sweep_store import SweepStore

    opened = SweepStore(store, skip_damaged=skip_damaged)
    with progress_bar("batches checked") as progress:
        opened.check(progress=progress)
    return _show_outcome(opened, None, as_json)


@sweep.command()
@click.argument("store", type=click.Path(path_type=Path))
@click.argument("target", type=click.Path(path_type=Path), metavar="FILE")
@_skip_damaged
def export(store: Path, target: Path, skip_damaged: bool) -> None:
    """Write a store as one FILE: .csv, .parquet or .nc (netCDF-4)."""
    import hertzchain

    from ..store.sweep_export import ENDINGS, export_sweep
    from ..store.sweep_store import SweepStore

    check_writable(target, "FILE", ENDINGS)
    export_sweep(hertzchain.open_sweep(store, skip_damaged=skip_damaged), target)
    counts = SweepStore(store, skip_damaged=skip_damaged).counts()
    if counts["missing"]:
        click.echo(
            f"Warning: {counts['missing']} of {sum(counts.values())} points are missing; run the "
            "specification again with this store",
            err=True,
        )
    click.echo(target)


@sweep.command()
@click.argument("into", type=click.Path(path_type=Path))
@click.argument("stores", type=click.Path(path_type=Path), nargs=-1, required=True)
@_skip_damaged
@json_option("Print the outcome as JSON.")
def merge(into: Path, stores: tuple[Path, ...], skip_damaged: bool, as_json: bool) -> int:
    """Join the STORES of all shards into the store INTO."""
    import hertzchain

    from ..store.sweep_store import SweepStore

    _, missing = hertzchain.merge_sweeps(list(stores), into, skip_damaged=skip_damaged)
    if missing:
        click.echo(
            f"{into} lacks {missing} points; run the missing shards, or the specification with "
            "this store",
            err=True,
        )
    return _show_outcome(SweepStore(into), None, as_json)


@sweep.command()
@click.argument("store", type=click.Path(path_type=Path))
@click.argument("target", type=click.Path(path_type=Path), metavar="FILE")
@click.option("--quantity", metavar="NAME", help="Quantity to plot.  [default: the first kept]")
@click.option(
    "--at",
    multiple=True,
    metavar="NAME=VALUE",
    help="Value along another dimension, such as bead=20, diameters=10mm or rate=5%.  If an axis "
    "does not have it, the nearest one is used, with a warning; numbers of beads and seeds must be "
    "exact.",
)
@click.option(
    "--level",
    type=Fraction(),
    multiple=True,
    help="Draw a contour line at this value in a map, such as 0.01 or 1%.",
)
@click.option("--log", is_flag=True, help="Use a logarithmic scale for the quantity.")
@click.option(
    "--log-x/--linear-x",
    default=None,
    help="Scale of the x axis.  [default: logarithmic if the values extend over a decade or more "
    "in even ratios]",
)
@click.option(
    "--log-y/--linear-y",
    default=None,
    help="Scale of the y axis of a map, with the same default; of curves, the same as --log.",
)
@click.option(
    "--slope",
    "slopes",
    multiple=True,
    metavar="EXPONENT",
    help="Draw a dashed line of a power law for comparison, such as 1.2 or 6/5; repeatable.",
)
@click.option(
    "--band",
    metavar="AXIS",
    help="Plot the median over this axis, such as seed, with the band from 5% to 95%.",
)
@_skip_damaged
@with_width("target")
def plot(
    store: Path, target: Path, quantity: str | None, at: tuple[str, ...],
    level: tuple[float, ...], log: bool, log_x: bool | None, log_y: bool | None,
    slopes: tuple[str, ...], band: str | None, skip_damaged: bool,
) -> None:  # fmt: skip
    """Plot a store to FILE (.png, .svg or .pdf): curves over one axis, a map over two.

    If one of two axes has at most six values, and the other has more, there is one curve for each
    value of the shorter axis.
    """
    import hertzchain

    from ..plotting.sweeps import plot_sweep

    check_writable(target, "FILE", PICTURES)
    chosen = dict(map(_place, at))
    found = hertzchain.open_sweep(store, skip_damaged=skip_damaged)
    axes = plot_sweep(found, quantity, log=log, log_x=log_x, log_y=log_y,
                      levels=list(level) or None, slope=slopes or None, band=band,
                      **chosen)  # fmt: skip
    save_figure(axes, target)
    click.echo(target)


def _pool(scheduler: str | None, processes: bool, workers: int | None) -> Any:
    from ..sweeps.executors import dask_pool, local_pool

    if scheduler is not None:
        return dask_pool(scheduler)
    return local_pool("processes" if processes else "threads", workers)


def _shard(text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    try:
        i, n = map(int, text.split("/"))
    except ValueError:
        raise click.UsageError(f"--shard must look like 2/8, got {text!r}") from None
    return i, n


def _store_of(specification: Path, part: tuple[int, int] | None) -> Path:
    """Default store in the working folder; the store of a shard has its number."""
    name = specification.stem if part is None else f"{specification.stem}.{part[0]}-of-{part[1]}"
    return Path(f"{name}.zarr")


def _place(text: str) -> tuple[str, Any]:
    name, _, value = text.partition("=")
    if not value:
        raise click.UsageError(f"--at must look like bead=20, got {text!r}")
    return name, as_typed(value)


def _show_estimate(specification: Path, store: Path, workers: int | None, as_json: bool) -> None:
    from ..sweeps.sweep import estimate

    if sys.stderr.isatty():
        click.echo("computing a few points to estimate the time", err=True)
    found = estimate(specification, workers=workers, store=store)
    if as_json:
        show_json({
            "points": found.points, "batches": found.batches,
            "bytes_on_disk": found.bytes_on_disk, "files": found.files, "seconds": found.seconds,
            "unfinished": found.unfinished, "renamed": found.renamed,
        })  # fmt: skip
        return
    from rich.filesize import decimal

    from ..representation import counted, duration_in_words

    batches = "1 batch" if found.batches == 1 else f"{found.batches} batches"
    click.echo(f"{counted(found.points, 'point')} in {batches}")
    for axis, name in found.renamed.items():
        click.echo(f"axis {axis} is called {name} in the results, where its own name is taken")
    click.echo(f"at most {decimal(found.bytes_on_disk)} of values on disk, and metadata, in about "
               f"{found.files} files")  # fmt: skip
    about = "more than" if found.unfinished else "about"
    duration = duration_in_words(found.seconds)
    click.echo(f"{about} {duration} of computing, without {START}, on this machine")
    if found.unfinished:
        click.echo("a point was not finished within ten seconds; shorter chains take less time")


def _show_outcome(opened: SweepStore, part: tuple[int, int] | None, as_json: bool) -> int:
    from ..chain.hertz_ratios import CONTACTS_YIELD
    from ..chain.stiff_walls import TOO_STIFF
    from ..sweeps.assumed_yield import assumed_by
    from ..sweeps.free_faces import note_on_free_faces
    from ..sweeps.plan import plan_of

    store = opened.folder
    counts = opened.counts()
    flags = {name: opened.flagged(name) for name in FLAGGED}
    plan = plan_of(opened.specification)
    stiff = opened.explained(TOO_STIFF) if plan.units == "SI" else 0
    yielding = opened.explained(CONTACTS_YIELD) if flags["outside_range"] else 0
    failures = opened.failures(5) if counts["failed"] else []
    if as_json:
        show_json({
            "store": str(store), **counts, **flags, "stiff_wall": stiff, "yielding": yielding,
            "failures": [{"point": place, "reason": reason} for place, reason in failures],
        })  # fmt: skip
    else:
        total = sum(counts.values())
        click.echo(f"{store}: {counts['done']} of {total} points done, {counts['failed']} failed, "
                   f"{counts['missing']} missing")  # fmt: skip
        _show_failures(opened, counts["failed"])
        for name, number in flags.items():
            if number:
                click.echo(f"  points {FLAGGED[name]}: {number} (see variable `{name}`)")
        if yielding:
            click.echo(f"  points at which {CONTACTS_YIELD}: {yielding} (see variable `reason`; "
                       'loss = "elastic-plastic" includes it)')  # fmt: skip
        if stiff:
            click.echo(f"  points at which the spring of a {TOO_STIFF}: {stiff} (see variable "
                       "`reason`)")  # fmt: skip
        if note := note_on_free_faces(plan, plan.variables):
            click.echo(f"  note: {note}")
        if assumed := assumed_by(plan):
            click.echo(f"  note: {assumed} (factor in [chain.loss])")
    unfinished = counts["missing"] and part is None
    return FAILED if counts["failed"] or unfinished else DONE


def _show_failures(opened: SweepStore, failed: int) -> None:
    """Print the reasons of failed points, each with the first point that has it."""
    from ..representation import counted

    groups = opened.failures_by_reason(MAX_GROUPED) if failed else []
    for reason, count, place in groups[:MAX_REASONS]:
        at = ", ".join(f"{name} = {value}" for name, value in place.items())
        similar = f" (and {counted(count - 1, 'more point')}, similarly)" if count > 1 else ""
        click.echo(f"  {at}{similar}: {reason}")
    shown = sum(count for _, count, _ in groups[:MAX_REASONS])
    if failed > shown:
        click.echo(f"  and {failed - shown} more (see variable `reason`)")

"""The command `sweep`: parameters that vary, into a store that any interruption leaves good."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hertzchain.cli.exit_codes import DONE, FAILED
from hertzchain.cli.options import PICTURES, check_writable
from hertzchain.cli.progress import progress_of
from hertzchain.cli.show import save_axes, show_json

if TYPE_CHECKING:
    from hertzchain.store.sweep_store import SweepStore


_skip_damaged = click.option(
    "--skip-damaged", is_flag=True, help="Count batches with damaged files as missing."
)


class _Sweep(click.Group):
    """A group whose first argument, if it is no command, is the specification to run."""

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        if args and args[0] not in self.commands:
            args = ["run", *args]
        return super().resolve_command(ctx, args)

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        options = [name for option in self.params for name in option.opts]
        if args and args[0].startswith("-") and args[0] not in (*options, "-h", "--help"):
            args = ["run", *args]
        return super().parse_args(ctx, args)


@click.group(cls=_Sweep)
def sweep() -> None:
    """Compute a grid of parameters: `hertzchain sweep SPEC.toml`.

    The specification says what varies, by which methods, and what is kept.  Results go into a
    zarr folder; the same command after an interruption does only what is missing.

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
    help="Where results go.  [default: the name of SPEC with .zarr, in the working folder]",
)
@click.option("--workers", type=int, help="Threads or processes.  [default: one a processor]")
@click.option("--processes", is_flag=True, help="A pool of processes in place of threads.")
@click.option("--scheduler", metavar="ADDRESS", help="A running dask scheduler: tcp://host:8786.")
@click.option("--shard", metavar="i/n", help="Only the i-th of n parts, into a store of its own.")
@_skip_damaged
@click.option("--dry-run", is_flag=True, help="Say what it would take, and compute nothing.")
@click.option("--json", "as_json", is_flag=True, help="Print the outcome as JSON.")
def run(
    specification: Path, store: Path | None, workers: int | None, processes: bool,
    scheduler: str | None, shard: str | None, skip_damaged: bool, dry_run: bool, as_json: bool,
) -> int:  # fmt: skip
    """Compute what SPEC.toml says, or what is missing of it (`run` may be left out).

    Exit codes: 0 all points are done, 1 some failed or the disk is full, 2 the specification or
    store cannot be used, 130 interrupted.
    """
    import hertzchain
    from hertzchain.store.sweep_store import SweepStore

    if scheduler is not None and (processes or workers is not None):
        raise click.UsageError("--scheduler has workers of its own: leave --processes and "
                               "--workers out")  # fmt: skip
    part = _shard(shard)
    if dry_run:
        _show_estimate(specification, workers, as_json)
        return DONE
    target = _store_of(specification, part) if store is None else store
    with ExitStack() as stack:
        pool = stack.enter_context(_pool(scheduler, processes, workers))
        progress = stack.enter_context(progress_of("points done", rate=True))
        try:
            hertzchain.sweep(
                specification, target, executor=pool, shard=part, skip_damaged=skip_damaged,
                progress=progress,
            )  # fmt: skip
        except KeyboardInterrupt:
            click.echo(f"what is done is in {target}; the same command goes on", err=True)
            raise
        except hertzchain.StoreError as error:
            click.echo(f"Error: {error}; the same command goes on from what is done", err=True)
            return FAILED
    return _show_outcome(SweepStore(target, skip_damaged=skip_damaged), part, as_json)


@sweep.command()
@click.argument("store", type=click.Path(path_type=Path))
@_skip_damaged
@click.option("--json", "as_json", is_flag=True, help="Print it as JSON.")
def status(store: Path, skip_damaged: bool, as_json: bool) -> int:
    """Check all files, and show how far a sweep is, also while it runs, and why points failed."""
    from hertzchain.store.sweep_store import SweepStore

    opened = SweepStore(store, skip_damaged=skip_damaged)
    with progress_of("batches checked") as progress:
        opened.check(progress=progress)
    return _show_outcome(opened, None, as_json)


@sweep.command()
@click.argument("store", type=click.Path(path_type=Path))
@click.argument("file", type=click.Path(path_type=Path))
@_skip_damaged
def export(store: Path, file: Path, skip_damaged: bool) -> None:
    """Write a store as one FILE: .csv, .parquet or .nc (netCDF-4)."""
    import hertzchain
    from hertzchain.store.sweep_files import ENDINGS, export_sweep

    check_writable(file, "FILE", ENDINGS)
    export_sweep(hertzchain.open_sweep(store, skip_damaged=skip_damaged), file)
    click.echo(file)


@sweep.command()
@click.argument("into", type=click.Path(path_type=Path))
@click.argument("stores", type=click.Path(path_type=Path), nargs=-1, required=True)
@_skip_damaged
def merge(into: Path, stores: tuple[Path, ...], skip_damaged: bool) -> int:
    """Join the STORES of all shards into the store INTO."""
    import hertzchain
    from hertzchain.store.sweep_store import SweepStore

    _, missing = hertzchain.merge_sweeps(list(stores), into, skip_damaged=skip_damaged)
    if missing:
        click.echo(
            f"{into} lacks {missing} points: run the shards that are missing, or the "
            "specification itself into it",
            err=True,
        )
    return _show_outcome(SweepStore(into), None, as_json=False)


@sweep.command()
@click.argument("store", type=click.Path(path_type=Path))
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--quantity", metavar="NAME", help="What to draw.  [default: the first kept]")
@click.option(
    "--at",
    multiple=True,
    metavar="NAME=VALUE",
    help="Where along other dimensions; between the values of an axis the nearest.",
)
@click.option("--level", type=float, multiple=True, help="Draw a line at this value into a map.")
@click.option("--log", is_flag=True, help="Logarithmic scale of the quantity.")
@_skip_damaged
def plot(
    store: Path, file: Path, quantity: str | None, at: tuple[str, ...], level: tuple[float, ...],
    log: bool, skip_damaged: bool,
) -> None:  # fmt: skip
    """Draw a store into FILE (.png, .svg or .pdf): curves over one axis, a map over two."""
    import hertzchain
    from hertzchain.plotting.sweeps import plot_sweep

    check_writable(file, "FILE", PICTURES)
    chosen = dict(map(_place, at))
    found = hertzchain.open_sweep(store, skip_damaged=skip_damaged)
    axes = plot_sweep(found, quantity, log=log, levels=list(level) or None, **chosen)
    save_axes(axes, file)
    click.echo(file)


def _pool(scheduler: str | None, processes: bool, workers: int | None) -> Any:
    from hertzchain.sweeps.executors import dask_pool, local_pool

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
    """Beside what is run, in the working folder; a shard's has its number."""
    name = specification.stem if part is None else f"{specification.stem}.{part[0]}-of-{part[1]}"
    return Path(f"{name}.zarr")


def _place(text: str) -> tuple[str, Any]:
    name, _, value = text.partition("=")
    if not value:
        raise click.UsageError(f"--at must look like bead=20, got {text!r}")
    try:
        return name, float(value)
    except ValueError:
        return name, value


def _show_estimate(specification: Path, workers: int | None, as_json: bool) -> None:
    from hertzchain.store.results import SCHEMA_VERSION
    from hertzchain.sweeps.sweep import estimate

    found = estimate(specification, workers=workers)
    if as_json:
        show_json({
            "schema_version": SCHEMA_VERSION, "points": found.points, "batches": found.batches,
            "bytes_on_disk": found.bytes_on_disk, "seconds": found.seconds,
        })  # fmt: skip
        return
    from rich.filesize import decimal

    click.echo(f"{found.points} points in {found.batches} batches")
    click.echo(f"at most {decimal(found.bytes_on_disk)} on disk")
    click.echo(f"about {_duration(found.seconds)} on this machine")


def _show_outcome(opened: SweepStore, part: tuple[int, int] | None, as_json: bool) -> int:
    from hertzchain.store.results import SCHEMA_VERSION

    store = opened.folder
    counts = opened.counts()
    outside, incomplete = opened.flagged("outside_range"), opened.flagged("incomplete")
    failures = opened.failures(5) if counts["failed"] else []
    if as_json:
        show_json({
            "schema_version": SCHEMA_VERSION, "store": str(store), **counts,
            "outside_range": outside, "incomplete": incomplete,
            "failures": [{"point": place, "reason": reason} for place, reason in failures],
        })  # fmt: skip
    else:
        total = sum(counts.values())
        click.echo(f"{store}: {counts['done']} of {total} points done, {counts['failed']} failed, "
                   f"{counts['missing']} missing")  # fmt: skip
        for place, reason in failures:
            click.echo(f"  {', '.join(f'{name} = {value}' for name, value in place.items())}: "
                       f"{reason}")  # fmt: skip
        if counts["failed"] > len(failures):
            click.echo(f"  and {counts['failed'] - len(failures)} more: variable `reason`")
        if outside:
            click.echo(f"  at {outside} points a method is outside its range: variable "
                       "`outside_range`")  # fmt: skip
        if incomplete:
            click.echo(f"  at {incomplete} points the largest force on the wall is not complete: "
                       "variable `incomplete`")  # fmt: skip
    unfinished = counts["missing"] and part is None
    return FAILED if counts["failed"] or unfinished else DONE


def _duration(seconds: float) -> str:
    if seconds < 60:
        return f"{seconds:.2g} s"
    hours, minutes = divmod(round(seconds / 60), 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min"

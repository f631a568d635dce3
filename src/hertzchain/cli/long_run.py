"""The command `simulate` with `--stream`: a long run, kept on disk alone."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from hertzchain.cli.progress import progress_of
from hertzchain.cli.show import show_json

if TYPE_CHECKING:
    from hertzchain.chain.chain import Chain
    from hertzchain.contacts import Array


def refuse_with_stream(**others: object) -> None:
    """Refuse options, by their names, that ask for what a streamed run does not have."""
    for name, value in others.items():
        if value:
            option = f"--{name.replace('_', '-')}"
            raise click.UsageError(f"--stream and {option} exclude each other")


def stream_into(
    folder: Path, chain: Chain, *, until: float | None, times: int, rtol: float, as_json: bool
) -> None:
    """Run a chain into a folder, or go on with the run in it, and say what is there."""
    from hertzchain.simulation.run import LONG_RUN, transits_between_walls
    from hertzchain.store import results
    from hertzchain.store.streaming import stream

    moments = _moments(until, times)
    try:
        with progress_of("times saved") as progress:
            stored = stream(chain, folder, times=moments, rtol=rtol, progress=progress)
    except KeyboardInterrupt:
        click.echo("the same command goes on from what is saved", err=True)
        raise
    files, end = len(stored.files), float(moments[-1])
    if as_json:
        document = {"schema_version": results.SCHEMA_VERSION, "chain": results.chain_as_dict(chain)}
        document |= {"folder": str(folder), "files": files, "saved_times": times, "end_time": end}
        show_json(document)
        return
    unit = " s" if chain.units == "SI" else ""
    noun = "file" if files == 1 else "files"
    click.echo(f"{chain.description}\n{times} times up to t = {end:g}{unit} in {files} {noun}")
    if transits_between_walls(chain, end) > LONG_RUN:
        click.echo(
            "a long run between walls: --horizon, without --stream, tells how far it can be "
            "predicted"
        )


def _moments(until: float | None, times: int) -> Array:
    """Evenly spaced times from 0, as many as asked for."""
    import numpy as np

    from hertzchain.checks import number

    if until is None:
        raise click.UsageError("--stream needs --until, the time to stop at")
    try:
        return np.linspace(0.0, number("until", until, above=0.0), times)
    except MemoryError:
        raise click.UsageError(f"--times {times} do not fit in memory: save fewer") from None

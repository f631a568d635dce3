"""The command `simulate --stream`: a long run that is kept only on disk."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .options import time_from
from .output import show_json
from .progress import progress_bar

if TYPE_CHECKING:
    from ..chain.chain import Chain
    from ..collision import Array


def check_stream_options(**others: object) -> None:
    """Reject options that cannot be combined with --stream."""
    for name, value in others.items():
        if value:
            option = f"--{name.replace('_', '-')}"
            raise click.UsageError(f"--stream and {option} cannot be combined")


def stream_into(
    folder: Path,
    chain: Chain,
    *,
    until: str | None,
    times: int,
    steps: dict[str, Any],
    as_json: bool,
) -> None:
    """Write a run to a folder, or resume the run in it, and summarise it."""
    from ..representation import counted, measure
    from ..simulation.run_message import LONG_RUN, transits_between_walls
    from ..store import results
    from ..store.streaming import stream

    saved_times = _saved_times(time_from("--until", until, chain), times)
    try:
        with progress_bar("times saved") as progress:
            stored = stream(chain, folder, times=saved_times, progress=progress, **steps)
    except KeyboardInterrupt:
        click.echo(f"saved times are in {folder}; run the same command again to resume", err=True)
        raise
    files, end = len(stored.files), float(saved_times[-1])
    if as_json:
        document = results.document_of(chain)
        document |= {"folder": str(folder), "files": files, "saved_times": times, "end_time": end}
        show_json(document)
        return
    last = measure(end, "s", chain.units, 6)
    click.echo(f"{chain.description}\n{times} times up to t = {last} in {counted(files, 'file')}")
    transits = transits_between_walls(chain, None, end)
    if transits > LONG_RUN:
        click.echo(
            f"the run lasts {transits:.3g} transits of the pulse: --horizon, without --stream, "
            "shows how long it is predictable"
        )


def _saved_times(until: float | None, times: int) -> Array:
    """The requested number of evenly spaced times from 0."""
    import numpy as np

    if until is None:
        raise click.UsageError("--stream requires --until, the stop time")
    try:
        return np.linspace(0.0, until, times)
    except MemoryError:
        raise click.UsageError(f"--times {times} do not fit in memory; save fewer") from None

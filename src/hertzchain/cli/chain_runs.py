"""Simulations of the chains of the command `simulate`."""

from __future__ import annotations

from contextlib import nullcontext
from typing import TYPE_CHECKING, Any, Final

from .options import time_from
from .progress import progress_bar
from .range_warnings import warn_of_limits

if TYPE_CHECKING:
    from ..chain.chain import Chain
    from ..simulation.run import Run

# Saved times, multiplied by beads, up to which a run is repeated for its waves (0.5 GB of arrays).
MOST_VALUES: Final = 20_000_000


def runs_of(
    chains: dict[str, Chain], until: str | None, step: str | None, settings: dict[str, Any], *,
    horizon: bool, resolve_waves: bool, quiet: bool,
) -> dict[str, Run]:  # fmt: skip
    """Runs of all chains; if ``quiet``, with one warning on each limit of Hertz's law."""
    from ..errors import ModelRangeWarning
    from ..recorded_warnings import ignore_warnings

    with ignore_warnings(ModelRangeWarning) if quiet else nullcontext():
        runs = {name: _run(chain, until, step, settings, horizon=horizon, resolve=resolve_waves)
                for name, chain in chains.items()}  # fmt: skip
    if quiet:
        warn_of_limits(runs)
    return runs


def _run(
    chain: Chain, until: str | None, step: str | None, settings: dict[str, Any], *,
    horizon: bool, resolve: bool,
) -> Run:  # fmt: skip
    import hertzchain

    options = settings | {
        "until": time_from("--until", until, chain), "step": time_from("--step", step, chain)
    }  # fmt: skip
    with progress_bar("beads passed") as progress:
        run = hertzchain.simulate(chain, progress=progress, **options)
    if resolve:
        run = _with_resolved_waves(run, options)
    if horizon:
        with progress_bar("beads passed, second integration") as progress:
            run.horizon(progress=progress)
    return run


def _with_resolved_waves(run: Run, options: dict[str, Any]) -> Run:
    """The run, or its repetition with so many saved times that all waves are resolved."""
    import hertzchain

    from ..recorded_warnings import ignore_warnings
    from ..simulation.wave_samples import enough_times

    times = min(enough_times(run), MOST_VALUES // run.chain.beads)
    if times <= options["times"]:
        return run
    # Warnings are those of the first run.
    with ignore_warnings(), progress_bar("beads passed, more saved times") as progress:
        return hertzchain.simulate(run.chain, progress=progress, **options | {"times": times})

"""Simulations of the chains of the paper."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from ..calibration import BEADS
from ..chain.chain import Chain
from ..pulse.pulse import Pulse
from ..simulation.simulate import DEFAULT_RTOL, simulate
from ..validation.objects import Progress

# By taper and rate.
Pulses = Mapping[tuple[str, float], Pulse]


def integrate_chains(
    chains: Iterable[tuple[str, float]],
    *,
    progress: Progress | None = None,
    drifts: list[tuple[float, float]] | None = None,
) -> dict[tuple[str, float], Pulse]:
    """Simulate tapered chains with `simulate`, which integrates all beads."""
    ordered = sorted(chains)
    pulses = {}
    for done, (taper, rate) in enumerate(ordered, start=1):
        run = simulate(Chain.tapered(taper, rate, beads=BEADS), times=0, rtol=DEFAULT_RTOL)
        pulses[taper, rate] = run.pulse()
        if drifts is not None:
            drifts.append((run.energy_drift, run.momentum_drift))
        if progress is not None:
            progress(done, len(ordered))
    return pulses

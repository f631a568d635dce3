"""The figure of peaks over several speeds or heights, of which some may not be known."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from ..simulation.yield_range import depends_on_yield_pressure
from .compared_yield import has_law_of_yield, possible_factors

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..simulation.run import Run
    from .compared_runs import Peaks
    from .repeated_impacts import Impacts


def drawn_over_impacts(
    runs: Mapping[str, Run], peaks: Peaks | None, impacts: Impacts,
    beads: Mapping[str, Sequence[int]],
) -> Axes | None:  # fmt: skip
    """Plot the peaks of each chain over several speeds or heights, also with contacts that yield.

    Panels below have the first maxima in sensors, except that of the peaks.  There is no figure
    without several impacts or without peaks.
    """
    if not impacts or peaks is None:
        return None
    from ..plotting.peaks_over_impacts import plot_peaks
    from .compared_sensors import forces_over_impacts
    from .repeated_impacts import value_of_impact

    others = {name: each[peaks.place == "sensor" :] for name, each in beads.items()}
    names: dict[str, list[str]] = {}
    for at_impact in impacts.names.values():
        for chain, name in at_impact.items():
            names.setdefault(chain, []).append(name)
    caps = all(run.chain.cap is not None for run in runs.values())
    where = "the cap" if peaks.place == "body" and caps else peaks.where
    lawful = [chain for chain, own in names.items()
              if any(depends_on_yield_pressure(runs[name]) for name in own)]  # fmt: skip
    known = [chain for chain, own in names.items()
             if chain in lawful or any(peaks.at[name].elastic for name in own)]  # fmt: skip
    given = any(has_law_of_yield(runs[name]) and math.isinf(peaks.at[name].smallest)
                for chain, own in names.items() if chain not in lawful for name in own)  # fmt: skip
    return plot_peaks(
        {chain: [value_of_impact(runs[name].chain, impacts.kind) for name in own]
         for chain, own in names.items()},
        {chain: [peaks.own[name] for name in own] for chain, own in names.items()},
        {chain: [peaks.at[name].both for name in names[chain]] for chain in known},
        {chain: [(name in peaks.unpredicted, *peaks.at[name].outside) for name in own]
         for chain, own in names.items()},
        factors=possible_factors(), where=where, units=next(iter(runs.values())).chain.units,
        heights=impacts.kind == "height", sensors=forces_over_impacts(runs, others, impacts),
        lawful=lawful, given_pressure=given,
    )  # fmt: skip


def nothing_to_plot(
    runs: Mapping[str, Run], peaks: Peaks | None, impacts: Impacts,
    beads: Mapping[str, Sequence[int]],
) -> bool:  # fmt: skip
    """Whether no force is known that `drawn_over_impacts` would plot."""
    from .compared_sensors import forces_over_impacts

    if not impacts or peaks is None:
        return False
    at_places = forces_over_impacts(runs, beads, impacts).values()
    known = [*peaks.own.values(), *(each for at in peaks.at.values() for each in at.both)]
    known += [each for at in at_places for own in at.values() for each in own]
    return not any(map(math.isfinite, known))

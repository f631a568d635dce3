"""The largest pressure in comparison with yield, and the peak on a wall with yielding contacts."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, Final

from ..errors import InputError, SimulationError
from ..recorded_warnings import ignore_warnings

if TYPE_CHECKING:
    from ..chain.chain import Chain
    from ..chain.hertz_range import HertzRange
    from ..validation.objects import Progress
    from .run import Run

# Longest chain for which a further simulation, of contacts with kinks, takes about a second.
MAX_BEADS: Final = 100


def pressures_below_yield(*runs: Run) -> list[str]:
    """A line with the largest pressure of all runs, if it is known and below its limit."""
    from ..chain.hertz_range import hertz_range

    if any(run.chain.materials is None or run.chain.units != "SI" for run in runs):
        return []
    found = [hertz_range(run.chain, run.largest_overlaps) for run in runs]
    known = [each for each in found if not math.isnan(each.largest_yield_ratio)]
    line = max(known, key=lambda each: each.largest_yield_ratio)._below_yield if known else ""
    return [line] if line else []


def contacts_staying_elastic(chain: Chain) -> list[str]:
    """A line with the materials that no yield strength is known of, if others have a law of it."""
    from ..chain.hertz_ratios import bodies_of

    if not any(law.needs_yield_strength for law in chain.contact_losses):
        return []
    contacts = zip(itertools.pairwise(bodies_of(chain)), chain.contact_stiffness, strict=True)
    pairs = dict.fromkeys(
        " with ".join(sorted(body.name for body in pair))
        for pair, stiffness in contacts
        if stiffness > 0.0 and all(body.yield_strength is None for body in pair)
    )
    if not pairs:
        return []
    return [f"contacts of {' and of '.join(pairs)} have no known yield strength and stay elastic"]


def yields(limits: HertzRange | None) -> bool:
    """Whether elastic contacts exceed the pressure at first yield, if it is known."""
    return limits is not None and limits.largest_yield_ratio > 1.0


def dented_chain(chain: Chain) -> Chain | None:
    """The chain with `ElasticPlastic` contacts; None if they do not apply to it."""
    from ..chain.laws.elastic_plastic import ElasticPlastic

    if not chain.lossless:
        return None
    try:
        return chain.replace(loss=ElasticPlastic())
    except InputError:
        return None


def peak_with_yielding_contacts(run: Run, progress: Progress | None = None) -> float | None:
    """Peak on the right wall of an elastic run that yields; `None` if it is not complete."""
    from ..chain.hertz_range import hertz_range
    from .simulate import simulate

    chain = run.chain
    if chain.materials is None or chain.units != "SI" or chain.beads > MAX_BEADS:
        return None
    if chain.right_wall is None or not run._wall_force("right").complete:
        return None
    dented = dented_chain(chain)
    if dented is None or not yields(hertz_range(chain, run.largest_overlaps)):
        return None
    with ignore_warnings():  # those of the elastic run are shown
        try:
            again = simulate(dented, times=0, check=False, progress=progress)
        except (InputError, SimulationError):
            return None
        wall = again._wall_force("right")
    return wall.peak if wall.complete else None

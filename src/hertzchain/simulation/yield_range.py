"""A second simulation that shows how much a run depends on its assumed yield pressure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..errors import InputError, SimulationError
from ..recorded_warnings import ignore_warnings
from .yielding import (
    MAX_BEADS,
    dented_chain,
    may_dent,
    peak_at_pressure,
    peak_of,
    peak_with_yielding_contacts,
)

if TYPE_CHECKING:
    from ..validation.objects import Progress
    from .run import Run
    from .yielding import WithYield


def depends_on_yield_pressure(run: Run) -> bool:
    """Whether contacts of a run have yielded at an assumed pressure."""
    from ..chain.yield_pressure import yields_at_assumed_pressure

    return yields_at_assumed_pressure(run.chain, run._furthest_overlaps)


def same_at_any_pressure(run: Run) -> bool:
    """Whether no contact yields, in a run with a law of yield or in one that could have one."""
    import numpy as np

    from ..chain.contact_groups import law_yield_ratios
    from ..chain.hertz_range import hertz_range

    chain = run.chain
    if any(law.yields for law in chain.contact_losses):
        # A given pressure at which contacts yield is none of the possible ones.
        ratios = law_yield_ratios(chain.contact_groups, run._furthest_overlaps)
        return not bool(np.any(ratios >= 1.0))
    if chain.materials is None or chain.units != "SI" or dented_chain(chain) is None:
        return False
    return not may_dent(hertz_range(chain, run.largest_overlaps))


def peaks_at_both_pressures(
    run: Run, progress: Progress | None = None
) -> tuple[WithYield | None, WithYield | None]:
    """Peaks at the smallest and at the largest possible yield pressure, of the right end.

    The run is elastic and beyond first yield, or yields at an assumed pressure; `None` otherwise.
    """
    from ..chain.materials import FULLY_PLASTIC

    if depends_on_yield_pressure(run):
        first = peak_of(run)
        return first, None if first is None else peak_at_pressure(run, FULLY_PLASTIC, progress)
    if (first := peak_with_yielding_contacts(run, progress)) is None:
        return None, None
    return first, peak_with_yielding_contacts(run, progress, factor=FULLY_PLASTIC)


def at_fully_plastic_pressure(run: Run, **options: Any) -> Run | None:
    """The run with the largest possible yield pressure, with these options of `simulate`.

    `None` if nothing yields at an assumed pressure, for chains of more than `MAX_BEADS` beads, and
    if the simulation fails.
    """
    from ..chain.materials import FULLY_PLASTIC
    from ..chain.yield_pressure import with_factor
    from .simulate import simulate

    if run.chain.beads > MAX_BEADS or not depends_on_yield_pressure(run):
        return None
    with ignore_warnings():  # those of the run itself are shown
        try:
            return simulate(with_factor(run.chain, FULLY_PLASTIC), check=False, **options)
        except (InputError, SimulationError):
            return None

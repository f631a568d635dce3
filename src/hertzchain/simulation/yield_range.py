"""A second simulation that shows how much a run depends on its assumed yield pressure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..errors import InputError, SimulationError
from ..recorded_warnings import ignore_warnings
from .yielding import MAX_BEADS

if TYPE_CHECKING:
    from .run import Run


def depends_on_yield_pressure(run: Run) -> bool:
    """Whether contacts of a run have yielded at an assumed pressure."""
    from ..chain.yield_pressure import yields_at_assumed_pressure

    return yields_at_assumed_pressure(run.chain, run._furthest_overlaps)


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

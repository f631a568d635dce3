"""The force on a free body behind the row, such as an instrument, and its acceleration."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from ..chain.bead_names import bead_label
from ..chain.chain import Chain
from ..chain.materials import FULLY_PLASTIC
from ..simulation.body_force import ABOVE, MAY_FOLLOW, body_force, force_on_body
from ..simulation.body_peak import BodyForce
from ..simulation.run import Run
from ..simulation.sensor_force import MANY_TIMES
from ..simulation.yield_range import at_fully_plastic_pressure
from ..simulation.yielding import pressures_below_yield
from ..units import STANDARD_GRAVITY
from .yield_notes import known_peak, peaks_if_yielding

# Name of the curve among those of sensors and walls.
BODY: Final = "body"
ACCELERATION: Final = "largest acceleration (force / mass, unfiltered)"
IN_G0: Final = "in multiples of standard gravity"


def body_peaks(run: Run, progress: Callable[..., None] | None) -> dict[str, Any]:
    """Largest force on the last body, its acceleration and duration, and forces with yield.

    ``run`` is long enough for the largest force, if the engine can exclude a larger one.
    ``progress`` is `None` in a draft, which simulates nothing else.
    """
    chain, found = run.chain, body_force(run)
    above = " above the static force" if chain.static_state.forces.any() else ""
    words = f"largest force {'so far' if progress is None else 'in this run'}{above}"
    names = {
        # A chain with such a body has no right wall, whose colour this is.
        "name": "wall-right",
        "label": f"free body behind the row, {bead_label(chain, chain.beads)}",
        "ball": "free body behind the row",
    }
    if found is None:
        largest = float(force_on_body(run).max(initial=0.0))
        words = f"largest force so far{above} ({MAY_FOLLOW})"
        return {**names, "shown": [[words, largest, None]], "yielding": None}
    if not found.complete and progress is not None:
        words = f"largest force so far{above} ({MAY_FOLLOW})"
    shown: list[list[Any]] = [[words, found.force, found.time]]
    with_yield = [] if progress is None else _with_yield(run, progress)
    yielding = known_peak(with_yield)
    # Contacts yield in this run, or not at all.
    yields = any(law.yields for law in chain.contact_losses)
    if yielding is None and (yields or pressures_below_yield(run)):
        yielding = found.force
    return {
        **names, "shown": shown + with_yield, "impact": _motion(chain, found),
        "yielding": yielding,
    }  # fmt: skip


def _motion(chain: Chain, found: BodyForce) -> list[tuple[str, float, str]]:
    """Acceleration, in SI units also in multiples of standard gravity, and its duration."""
    numbers = [(ACCELERATION, found.acceleration, "m/s²")]
    if chain.units == "SI":
        numbers.append((IN_G0, found.acceleration / STANDARD_GRAVITY, "g0"))
    return [*numbers, (f"duration above {ABOVE:.0%} of it", found.duration, "s")]


def _with_yield(run: Run, progress: Callable[..., None]) -> list[list[Any]]:
    """Largest forces with contacts that yield, at first yield and at the largest pressure."""
    options = {"until": run.end_time, "times": MANY_TIMES, "progress": progress}
    if (other := at_fully_plastic_pressure(run, **options)) is not None:
        found = body_force(other)
        words = f"largest force if contacts yield at {FULLY_PLASTIC:g} Y"
        return [] if found is None else [[words, found.force, None]]
    return peaks_if_yielding(run, progress)

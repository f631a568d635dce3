"""The force on a free body behind the row, such as an instrument, and its acceleration."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from ..chain.bead_names import bead_label
from ..chain.chain import Chain
from ..simulation.body_force import ABOVE, MAY_FOLLOW, body_force, force_on_body
from ..simulation.body_peak import BodyForce
from ..simulation.run import Run
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
    with_yield = [] if progress is None else peaks_if_yielding(run, progress)
    yielding = known_peak(run, with_yield, found.force)
    return {
        **names, "shown": shown + with_yield, "impact": _motion(chain, found),
        "yielding": yielding,
    }  # fmt: skip


def _motion(chain: Chain, found: BodyForce) -> list[tuple[str, float, str]]:
    """Acceleration, in SI units also in multiples of standard gravity, and its duration."""
    numbers = [(ACCELERATION, found.acceleration, "m/s²")]
    if chain.units == "SI":
        numbers.append((IN_G0, found.acceleration / STANDARD_GRAVITY, "g0"))
    return [*numbers, (f"duration above {ABOVE:.0%} of it", *duration_shown(chain, found.duration))]


def duration_shown(chain: Chain, duration: float) -> tuple[float, str]:
    """Duration of an impact in one unit for all chains that are compared."""
    return (1e6 * duration, "µs") if chain.units == "SI" else (duration, "s")

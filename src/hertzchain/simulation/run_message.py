"""Messages about the end of a run, and about its predictability."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..kernels import state_layout
from ..representation import counted, measure
from .run_end import Status
from .time_scales import fall_time, is_static, transit_times
from .wall_bound import LATER_IMPACTS, LEFT, RIGHT, motion_can_escape

FAILURES: Final = ("step limit", "step too small", "unstable steps", "underflow")

# Features that can make the motion of a chain stiff, and what to try instead.
MILDER: Final = {
    "loss": "a weaker loss",
    "mixed losses": "weaker losses",
    "precompression": "less precompression",
    "gravity": "less gravity",
    "left wall": "a softer left wall",
    "right wall": "a softer right wall",
    "drive": "a slower drive",
    "masses": "less unequal masses",
    "stiffness": "less unequal stiffness",
}

NOT_STRUCK: Final = "bead 1 is not struck; give it a velocity, a striker or a drive"

# Ratio of the times in which a pulse passes two contacts, beyond which more steps hardly help.
WIDE_RANGE: Final = 1e9
# Stiffness of the contact with a wall, relative to that of the last two beads: up to 2.83 for a
# rigid wall and equal beads of the same material.
STIFF_WALL: Final = 3.0

# Transits of a pulse after which a run between walls may have become unpredictable.
LONG_RUN: Final = 3.0
# Second arrival of the pulse at the right wall, over the first; it is at the left wall before.
SECOND_ARRIVAL: Final = 3.0


def end_message(
    chain: Chain, status: Status, time: float, steps: int, passed: int, *,
    sensitive: bool = False,
) -> str:  # fmt: skip
    """Describe the status of a run in a sentence, with advice if it failed.

    The argument ``sensitive`` is that of `hertzchain.WallForce` of the right wall.
    """
    at = f"at t = {measure(time, 's', chain.units, digits=6)}, after {steps} steps"
    milder = _milder(chain)
    so_far = f"the pulse had passed {passed} of {counted(chain.beads - chain.strikers, 'bead')}"
    # A free body behind the row has the number of all beads with the strikers.
    if chain.strikers and chain._free_cap:
        so_far += f" behind the striker{'s' * (chain.strikers > 1)}"
    return {
        "pulse left": _pulse_left(chain, at),
        "wall force complete": _complete(chain, at, sensitive=sensitive),
        "transit limit": (
            f"stopped {at}, because a run without until lasts no longer; the force on the "
            f"{'cap' if chain.right_wall is None else 'right wall'} is not complete"
        ),
        "nothing more happens": f"all beads are in free flight and separating {at}; {so_far}",
        "time reached": f"stopped as requested {at}; "
        + (f"nothing moves, because {NOT_STRUCK}" if is_static(chain) else so_far),
        "step limit": f"stopped by the step limit {at}; {so_far}; {_more_steps(chain, milder)}",
        "underflow": f"the motion became too small to represent {at}; {so_far}; use {milder}",
        "step too small": (
            f"the step size fell below the resolution of t {at}; {so_far}; use {milder}"
        ),
        "unstable steps": (
            f"the energy has changed by more than half {at}, because the steps are too long; give "
            "a shorter step, or drift instead of step"
        ),
    }[status]


def _pulse_left(chain: Chain, at: str) -> str:
    """Message of a run that ended by itself at a free right end."""
    static = chain.static_state
    held = static.forces.any() or static.body_forces.any()
    if not chain._free_cap or held:
        return f"the pulse left the chain {at}"
    return f"ended {at}: the pulse has left, and no larger force on the cap can follow"


def _complete(chain: Chain, at: str, *, sensitive: bool) -> str:
    """Message of a run that ended with a complete peak on the right wall."""
    if motion_can_escape(chain, RIGHT):
        motion = " in this run" if sensitive else ""
        return f"ended {at}, since no larger force on the right wall can follow{motion}"
    return f"the impact on the right wall has ended {at}; {LATER_IMPACTS}"


def wide_range(chain: Chain) -> str:
    """State that a chain has contacts of very different durations; empty if it has not."""
    times = transit_times(chain)
    fast, slow = int(np.argmin(times)), int(np.argmax(times))
    if not times[slow] > WIDE_RANGE * times[fast]:
        return ""
    steps = np.diff(chain.radii)
    taper = (steps <= 0.0).all() or (steps >= 0.0).all()
    change = "a weaker taper" if taper else "more similar beads"
    return (
        f"a pulse passes contact {fast + 1} {times[slow] / times[fast]:.0e} times faster than "
        f"contact {slow + 1}, and the steps must resolve both; use fewer beads or {change}"
    )


def _more_steps(chain: Chain, milder: str) -> str:
    return wide_range(chain) or f"raise max_steps, or use {milder} if the time hardly advances"


def _milder(chain: Chain) -> str:
    """Changes of this chain that would make its motion less stiff."""
    names = {*chain.features} | ({"masses"} if not chain.strikers_are_spheres else set())
    found = [
        advice
        for name, advice in MILDER.items()
        if name in names and (not name.endswith("wall") or _stiff_wall(chain, name))
    ]
    even = np.ptp(chain.radii) == 0.0
    return " or ".join(found or ["fewer beads" if even else "fewer beads or a weaker taper"])


def _stiff_wall(chain: Chain, name: str) -> bool:
    """Whether a softer wall could help: it is stiffer than the contacts of the beads."""
    end = 0 if name == "left wall" else -1
    if np.ptp(chain.contact_exponents[[end, 1 if end == 0 else -2]]) != 0.0:
        return True
    return bool(chain.wall_stiffness[end] > STIFF_WALL * chain.stiffness[end])


def is_sensitive(chain: Chain, walls: Array, side: int) -> bool:
    """Whether the largest force on a wall follows its first impact in a chain without losses.

    ``walls`` are the records of a run.
    """
    if not chain.lossless or ("left wall", "right wall")[side] not in chain.features:
        return False
    peak_time = float(walls[state_layout.WALL_PEAK_TIME, side])
    # Bead 1 may touch the left wall before the pulse returns from the right one.
    returns = SECOND_ARRIVAL * float(walls[state_layout.TURNED_BACK, RIGHT]) * (side == LEFT)
    first_end = float(walls[state_layout.FIRST_END, side])
    return bool(follows_first_contact(peak_time, first_end)) and peak_time > returns


def follows_first_contact(peak_time: Array | float, first_end: Array | float) -> Any:
    """Whether largest forces are later than the end of the first contact, 0 before that end."""
    return np.less(0.0, first_end) & np.less(first_end, peak_time)


def recommended_horizon(chain: Chain, walls: Array, time: float) -> str:
    """Recommend `hertzchain.Run.horizon` for a run that may be unpredictable; empty otherwise.

    ``walls`` are the records of the run, which ended at ``time``.
    """
    transits = transits_between_walls(chain, walls, time)
    found = [f"{transits:.0f} transits long"] if transits > LONG_RUN else []
    if any(is_sensitive(chain, walls, side) for side in (LEFT, RIGHT)):
        found.append("wall peak not in the first contact")
    advice = "run.horizon() shows how long it is predictable"
    return f"{', '.join(found)}: {advice}" if found else ""


def transits_between_walls(chain: Chain, walls: Array | None, time: float) -> float:
    """Number of transits of a pulse in a chain that traps it without losses, as two walls do.

    One wall traps waves if there is gravity or precompression, or if beads have returned to it in
    a chain of unequal beads: those of a taper, for example, turn back the beads that rebound.
    Without records of the ``walls``, beads of such a chain are assumed to have returned.
    """
    returned = walls is None or bool((walls[state_layout.TOUCHES] > 1.0).any())
    turned_back = returned and np.ptp(chain.masses) > 0.0
    held = turned_back or chain.gravity != 0.0 or chain.precompression > 0.0
    if not chain.lossless or sum(np.array(chain.wall_stiffness) > 0.0) <= (0 if held else 1):
        return 0.0
    return max(0.0, time - fall_time(chain)) / float(transit_times(chain).sum())

"""The last bead of a free end, its acceleration, and the velocities after the impact."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from ..simulation.run import Run

# Largest number of beads whose final velocities are printed.
SHORT: Final = 10
# Part of the largest velocity above which a bead moves.
MOVES: Final = 1e-3


def last_bead_of(run: Run) -> dict[str, float] | None:
    """Velocity and momentum that the leading pulse gives the last bead of a free end."""
    if run.chain.right_wall is not None or not run._reached:
        return None
    # A shaker that does not stop creates no pulse of its own.
    if run.chain.drive is not None and math.isinf(run.chain.drive.end):
        return None
    pulse = run.pulse()
    velocity, momentum = float(pulse.velocity[-1]), float(pulse.momentum[-1])
    return None if math.isnan(velocity) else {"velocity": velocity, "momentum": momentum}


def free_end_lines(run: Run, beads: Sequence[int]) -> list[str]:
    """Motion of the last bead of a free end; of a cap, or with a sensor, also the force on it.

    ``beads`` have sensors.
    """
    from ..chain.bead_names import bead_label

    chain, last = run.chain, last_bead_of(run)
    lines = [] if last is None else [last_bead_line(run, last)]
    if chain._free_cap or chain.beads in beads:
        forces = body_lines(run)
        if forces and not lines:
            lines.append(f"{bead_label(chain, chain.beads)} at the free end:")
        lines += forces
    return lines


def _is_over(run: Run) -> bool:
    """Whether a pulse has reached the free end, and all contacts are open for good."""
    return last_bead_of(run) is not None and not (len(run.closed_contacts) or run._unfinished)


def velocity_after_impact(run: Run) -> float | None:
    """The velocity of a body behind the row once it is final, which is not that in the pulse."""
    return float(run.state.velocities[-1]) if run.chain._free_cap and _is_over(run) else None


def _velocity_after_impact(run: Run) -> list[str]:
    """The velocity and momentum of a body behind the row after the impact."""
    from ..representation import measure

    chain = run.chain
    if (velocity := velocity_after_impact(run)) is None:
        return []
    shown = measure(velocity, "m/s", chain.units, 5)
    momentum = measure(float(chain.masses[-1]) * velocity, "N s", chain.units)
    return [f"  velocity after the impact: {shown}, momentum {momentum}"]


def last_bead_line(run: Run, last: dict[str, float]) -> str:
    """Velocity and momentum of the last bead of a free end."""
    from ..chain.bead_names import bead_label
    from ..representation import measure

    velocity = measure(last["velocity"], "m/s", run.chain.units, 5)
    momentum = measure(last["momentum"], "N s", run.chain.units)
    return (
        f"{bead_label(run.chain, run.chain.beads)} at the free end: velocity {velocity}, momentum "
        f"{momentum} in the leading pulse"
    )


def body_as_dict(run: Run) -> dict[str, object] | None:
    """Force on the last body of a free end, its acceleration and their duration, if known.

    A duration that is not known is None, as is the acceleration in g0 in scaled variables.
    """
    from ..simulation.body_force import ABOVE, body_force
    from ..units import STANDARD_GRAVITY
    from ..validation.json_types import finite

    if (found := body_force(run)) is None:
        return None
    si = run.chain.units == "SI"
    numbers: dict[str, object] = finite(
        {
            "force": found.force, "force_time": found.time, "force_error": found.error,
            "acceleration": found.acceleration,
            "acceleration_in_g0": found.acceleration / STANDARD_GRAVITY if si else math.nan,
            "duration": found.duration, "duration_above": ABOVE,
        }
    )  # fmt: skip
    return numbers | {"complete": found.complete}


def body_lines(run: Run) -> list[str]:
    """Force of the last contact on the body behind it, its acceleration, and the duration."""
    from ..representation import measure
    from ..simulation.body_force import ABOVE, MAY_FOLLOW, body_force, force_on_body
    from ..simulation.sensor_force import SHOWN

    units = run.chain.units
    contact = f"contact {run.chain.beads - 1}"
    if (found := body_force(run)) is None:
        largest = float(force_on_body(run).max(initial=0.0))
        if not (run.chain._free_cap and largest > 0.0):
            return []
        return [f"  force on it, from {contact}: no maximum yet, largest so far "
                f"{measure(largest, 'N', units, 5)}; {MAY_FOLLOW}"]  # fmt: skip
    force = f"{measure(found.force, 'N', units, 5)} at t = {measure(found.time, 's', units, 5)}"
    error = ""
    if found.error > SHOWN * found.force:
        size = measure(found.error, "N", units, 2)
        error = f" (error at most {size})"
    so_far = "" if found.complete else " so far"
    later = "" if found.complete else f"; the run ends before the peak is complete: {MAY_FOLLOW}"
    above = " above the static force" if run.chain.static_state.forces.any() else ""
    lasts = "not known, because the run begins or ends during it"
    if not math.isnan(found.duration):
        lasts = measure(found.duration, "s", units, 3)
    return [
        f"  largest force on it{so_far}, from {contact}{above}: {force}{error}{later}",
        f"  largest acceleration (this force / mass, unfiltered): "
        f"{acceleration_in_words(found.acceleration, units)}",
        f"  duration of the acceleration (around the largest, above {ABOVE:.0%} of it): {lasts}",
    ]


def acceleration_in_words(value: float, units: str) -> str:
    """An acceleration with four digits, in SI units also as a multiple of standard gravity."""
    from ..units import STANDARD_GRAVITY

    shown, in_g0 = shown_acceleration(value, units)
    return f"{shown}, {in_g0} g0 (g0 = {STANDARD_GRAVITY:g} m/s^2)" if in_g0 else shown


def shown_acceleration(value: float, units: str) -> tuple[str, str]:
    """An acceleration, and in SI units its multiple of standard gravity, with four digits."""
    from ..representation import without_exponent
    from ..units import STANDARD_GRAVITY

    own, multiple = map(without_exponent, (value, value / STANDARD_GRAVITY))
    return (f"{own} m/s^2", multiple) if units == "SI" else (own, "")


def final_velocities(run: Run) -> list[str]:
    """Velocities after the impact of a body and of few beads, if more than one of them moves."""
    from ..chain.bead_names import bead_label

    velocities, chain = run.state.velocities, run.chain
    moving = abs(velocities) > MOVES * abs(velocities).max()
    of_body = _velocity_after_impact(run)
    if chain.beads > SHORT or moving.sum() < 2 or not _is_over(run):
        return of_body
    unit = " m/s" if chain.units == "SI" else ""
    last = abs(velocities).max()
    # Velocities have the decimals of the fastest bead, of which five digits are shown.
    decimals = max(0, 4 - math.floor(math.log10(last)))
    shown = ", ".join(f"{each:z.{decimals}f}" for each in velocities)
    return [
        *of_body,
        f"velocities at the end of the run, from {bead_label(chain, 1)} to "
        f"{bead_label(chain, chain.beads)}: {shown}{unit}",
    ]

"""Forces of a run at its assumed yield pressure and at the largest possible one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from ..errors import IncompleteWarning
from ..recorded_warnings import ignore_warnings
from ..simulation.yield_range import at_fully_plastic_pressure, depends_on_yield_pressure
from .progress import progress_bar
from .wording import on_command_line

if TYPE_CHECKING:
    from ..simulation.run import Run

# Digits of both ends of a range: more if they would coincide.  Velocities have at least four.
DIGITS: Final = (3, 4, 5, 6)


class Ends(NamedTuple):
    """A value at the assumed yield pressure and at the largest possible one."""

    name: str
    unit: str
    assumed: float
    other: float
    # Whether values at pressures between them can be outside the range.
    irregular: bool = False
    # Whether later forces may exceed both values.
    so_far: bool = False


def second_run(run: Run, **options: Any) -> Run | None:
    """The run at the largest possible yield pressure, if contacts yield at an assumed one."""
    from ..chain.materials import FULLY_PLASTIC

    if not depends_on_yield_pressure(run):
        return None
    what = f"beads passed, yield pressure of {FULLY_PLASTIC:g} times the yield strength"
    with progress_bar(what) as progress:
        return at_fully_plastic_pressure(run, progress=progress, **options)


def ends_of_range(run: Run, other: Run | None, beads: Sequence[int]) -> list[Ends]:
    """Complete peaks on walls, forces in sensors and on a cap, and velocities at a free end."""
    from ..chain.bead_names import bead_label, walls_of
    from ..simulation.body_force import body_force
    from .last_bead import last_bead_of, velocity_after_impact

    if other is None:
        return []
    found = []
    for side in walls_of(run.chain):
        one = run.wall_force(side)
        with ignore_warnings(IncompleteWarning):  # `_without_range` states it
            two = other.wall_force(side)
        if one.complete and two.complete and one.reached:
            # One of several pulses can be the largest.
            several = max(one.touches, two.touches) > 1
            proven = one.proven and two.proven
            found.append(Ends(f"{side} wall", "N", one.peak, two.peak, several, not proven))
    for bead in beads:
        at = f"sensor in {bead_label(run.chain, bead)}"
        values = [each.sensor_force(bead).largest_so_far for each in (run, other)]
        found.append(Ends(at, "N", values[0], values[1]))
    last = bead_label(run.chain, run.chain.beads)
    forces, several = (body_force(run), body_force(other)), False
    if run.chain._free_cap and forces[0] is not None and forces[1] is not None:
        several = forces[0].later or forces[1].later
        so_far = not (forces[0].complete and forces[1].complete)
        at = f"force on {last}"
        found.append(Ends(at, "N", forces[0].force, forces[1].force, several, so_far))
    of = {
        f"{last} in the leading pulse": [(last_bead_of(each) or {}).get("velocity")
                                         for each in (run, other)],
        f"{last} after the impact": [velocity_after_impact(each) for each in (run, other)],
    }  # fmt: skip
    for name, (one_end, other_end) in of.items():
        if one_end is not None and other_end is not None:
            found.append(Ends(name, "m/s", one_end, other_end, several))
    return found


def range_as_dict(run: Run, other: Run | None, beads: Sequence[int]) -> dict[str, Any] | None:
    """Values at both yield pressures as plain data; `None` if nothing yields at an assumed one."""
    from ..chain.materials import FIRST_YIELD, FULLY_PLASTIC
    from ..validation.json_types import finite

    if not depends_on_yield_pressure(run):
        return None
    values = [
        finite(
            {
                "name": each.name,
                "unit": each.unit,
                "values": [each.assumed, each.other],
                "irregular": each.irregular,
            }
        )
        for each in ends_of_range(run, other, beads)
    ]
    return {"factors": [FIRST_YIELD, FULLY_PLASTIC], "assumed": FIRST_YIELD, "ranges": values}


def range_lines(run: Run, other: Run | None, beads: Sequence[int]) -> list[str]:
    """Lines with values at both yield pressures; none if nothing yields at an assumed one."""
    from ..chain.yield_pressure import ASSUMED_PRESSURE, OTHER_PRESSURE

    if not depends_on_yield_pressure(run):
        return []
    lines = [on_command_line(f"{ASSUMED_PRESSURE} ({OTHER_PRESSURE.removeprefix('use ')})")]
    found = ends_of_range(run, other, beads)
    for each in found:
        so_far = "peak so far " if each.so_far else ""
        lines.append(f"  {each.name}: {so_far}{range_in_words(each, run.chain.units)}")
    return lines + [f"  {each}" for each in _without_range(run, other)]


def _without_range(run: Run, other: Run | None) -> list[str]:
    """Walls whose peak is complete at the assumed yield pressure only."""
    from ..chain.bead_names import walls_of
    from ..chain.materials import FULLY_PLASTIC

    if other is None:
        return []
    with ignore_warnings(IncompleteWarning):
        sides = [
            side for side in walls_of(run.chain)
            if run.wall_force(side).complete and not other.wall_force(side).complete
        ]  # fmt: skip
    return [
        f"{side} wall: no range, because the peak at {FULLY_PLASTIC:g} times is not complete"
        for side in sides
    ]


def range_in_words(ends: Ends, units: str) -> str:
    """The values at both yield pressures, and these pressures."""
    from ..chain.yield_pressure import BETWEEN
    from ..representation import measure

    for digits in DIGITS[ends.unit == "m/s" :]:
        low, high = (measure(each, ends.unit, units, digits) for each in (ends.assumed, ends.other))
        if low != high:
            break
    else:
        between = "; values between can differ" if ends.irregular else ""
        low = measure(ends.assumed, ends.unit, units)
        return f"{low} for yield pressures of {BETWEEN}{between}"
    if low.rpartition(" ")[2] == high.rpartition(" ")[2]:
        low = low.rpartition(" ")[0]
    between = "; values between can be outside this range" if ends.irregular else ""
    return f"{low} to {high} for yield pressures of {BETWEEN}{between}"

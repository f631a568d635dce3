"""Waves as a table and as JSON, and the horizon of a run as JSON."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ..validation.json_types import finite

if TYPE_CHECKING:
    from rich.table import Table

    from ..simulation.horizon import Horizon
    from ..simulation.waves import Waves


def wave_table(waves: Waves) -> Table:
    """Table of the waves, one row per wave, in order of time."""
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    from ..pulse.quantities import WAVE_QUANTITIES
    from ..representation import usual_unit

    rows = waves_as_list(waves)
    counts = f"{len(waves.right)} to the right, {len(waves.left)} to the left"
    missed = sum(not wave.resolved for wave in waves)
    doubts = [f"{missed} marked * have too few saved times to be reliable"] if missed else []
    doubts += [waves._unlisted] if waves._unlisted else []
    caption = "\n".join(doubts) or None
    table = Table(
        title=f"waves: {counts}", caption=caption, box=box.SIMPLE_HEAD, title_justify="left"
    )
    last = max((row["last_time"] for row in rows), default=0.0)
    factor, time_unit = usual_unit(last, "s") if waves.chain.units == "SI" else (1.0, "")
    for name in ("", "contacts", "times", "amplitude", "momentum", "energy", "width", "speed"):
        quantity = WAVE_QUANTITIES.get("first_time" if name == "times" else name)
        real = quantity is not None and waves.chain.units == "SI"
        unit = "" if quantity is None else quantity.unit
        unit = time_unit if unit == "s" else unit
        shown = f"{name} [{unit}]" if real else name
        table.add_column(escape(shown), justify="right", no_wrap=True)
    columns = [
        _ranges([(factor * row["first_time"], factor * row["last_time"]) for row in rows]),
        *(_along(waves, name) for name in ("amplitude", "momentum", "energy")),
        _along(waves, "width", factor),
        _ranges([() if row["speed"] is None else (row["speed"],) for row in rows]),
    ]
    for row, *shown in zip(rows, *columns, strict=True):
        table.add_row(
            row["direction"] + ("" if row["resolved"] else " *"),
            f"{row['first_contact']}..{row['last_contact']}",
            *shown,
        )
    return table


def _along(waves: Waves, name: str, factor: float = 1.0) -> list[str]:
    """A quantity of waves; where it changes along a track, those of its begin and its end."""
    return _ranges([[factor * value for value in wave._along(name)] for wave in waves])


def _ranges(rows: Sequence[Sequence[float]]) -> list[str]:
    """Cells with no, one or two numbers, of which those that are not finite are omitted."""
    from ..representation import in_column

    kept = [[value for value in row if math.isfinite(value)] for row in rows]
    texts = iter(in_column([value for row in kept for value in row], 4))
    return ["..".join(itertools.islice(texts, len(row))) for row in kept]


def waves_as_list(waves: Waves) -> list[dict[str, Any]]:
    """Waves as plain data; unknown values are None."""
    from ..simulation.waves import DIRECTIONS

    rows = waves.to_dataframe().to_dict("records")
    for row, wave in zip(rows, waves, strict=True):
        row["direction"] = DIRECTIONS[wave.direction]
        row["resolved"] = wave.resolved
    found: list[dict[str, Any]] = finite(rows)
    return found


def horizon_as_dict(horizon: Horizon) -> dict[str, Any]:
    """A horizon as plain data; the time is None if it was not reached."""
    found: dict[str, Any] = finite(
        {
            "within": horizon.within,
            "time": horizon.time,
            "last_time": float(horizon.times[-1]),
            "error": float(horizon.error[-1]),
            "rtol": horizon.rtol,
            "shadow_rtol": horizon.shadow_rtol,
            "step": horizon.step,
            "shadow_step": horizon.shadow_step,
        }
    )
    return found

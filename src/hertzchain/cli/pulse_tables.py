"""Pulses as tables, one row per bead."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from rich.table import Table

    from ..collision import Array
    from ..pulse.pulse import Pulse

TABLE_ROWS: Final = 26
# Columns of a pulse with spreads, for which all columns would be too wide, and their digits.
WITH_SPREADS: Final = {
    "velocity": 4, "velocity_spread": 3, "arrival": 4, "arrival_spread": 3, "residence": 4,
    "peak_force": 4, "peak_force_spread": 3, "velocity_error": 2,
}  # fmt: skip
SPREADS: Final = (
    "spread: relative standard deviation over random chains, error: that of the velocity; "
    "all quantities: --csv, --json"
)


def pulse_table(pulse: Pulse, every_bead: bool) -> Table:
    """Table of a pulse with one column per quantity; with spreads, of those that have one."""
    from rich.markup import escape

    from ..pulse.notes import OUT_OF_ORDER, out_of_order
    from ..pulse.quantities import QUANTITIES

    beads = pulse.chain.beads
    rows = table_rows(beads, every_bead)
    table = _bead_table(f"{pulse.method}: {pulse.chain.description}", len(rows), beads)
    columns = pulse.columns()
    spreads = "velocity_spread" in columns
    digits = WITH_SPREADS if spreads else dict.fromkeys(columns, 6)
    shown = [name for name in digits if name in columns]
    for name in shown:
        symbol = QUANTITIES[name].symbol
        heading, unit = name, "" if pulse.chain.units == "scaled" else f" [{pulse.unit(name)}]"
        if spreads and name.endswith(("_spread", "_error")):
            heading, unit = name.rpartition("_")[2], ""
        table.add_column(f"{heading}\n{symbol}{escape(unit)}", justify="right", no_wrap=True)
    cells = [_cells(columns[name], rows, digits[name]) for name in shown]
    for i, *row in zip(rows, *cells, strict=True):
        table.add_row(str(i + 1), *row)
    notes = [SPREADS] * spreads + [OUT_OF_ORDER] * out_of_order(pulse.residence)
    notes += [note for name in shown for note in _static_notes(pulse, name)]
    _add_notes(table, [pulse], *notes)
    return table


def side_by_side(
    pulses: list[Pulse], quantity: str, every_bead: bool, names: Sequence[str] = ()
) -> Table:
    """Table of one quantity with one column per pulse; ``names`` are those of several chains."""
    from rich.markup import escape

    from ..pulse.notes import OUT_OF_ORDER, out_of_order
    from ..pulse.quantities import COLUMN_QUANTITIES

    chain = pulses[0].chain
    per = COLUMN_QUANTITIES[quantity].per
    count = max(pulse.chain.beads for pulse in pulses) - (per == "contact")
    rows = table_rows(count, every_bead)
    unit = "" if chain.units == "scaled" else f" in {pulses[0].unit(quantity)}"
    title = f"{quantity}{unit}: {pulses[0].method if names else chain.description}"
    table, cells = _bead_table(title, len(rows), count, per), []
    for pulse, name in zip(pulses, names or [each.method for each in pulses], strict=True):
        table.add_column(escape(name), justify="right")
        cells.append(_cells(pulse.column(quantity), rows, 8))
    spread, more = f"{quantity}_spread", []
    if len(pulses) == 1 and spread in COLUMN_QUANTITIES and pulses[0].column(spread) is not None:
        table.add_column("spread", justify="right")
        cells.append(_cells(pulses[0].column(spread), rows, 3))
        more = [SPREADS.partition(", ")[0]]
    for i, *row in zip(rows, *cells, strict=True):
        table.add_row(str(i + 1), *row)
    timed = quantity in ("residence", "speed")
    unordered = timed and any(out_of_order(each.residence) for each in pulses)
    speeds = [note for each in pulses for note in _speed_notes(each)] if quantity == "speed" else []
    static = [note for each in pulses for note in _static_notes(each, quantity)]
    _add_notes(table, pulses, OUT_OF_ORDER if unordered else "", *speeds, *static, *more)
    return table


def _static_notes(pulse: Pulse, quantity: str) -> list[str]:
    """Note on a force or overlap that contains the one at rest."""
    from ..pulse.quantities import QUANTITIES
    from ..representation import measure

    chain = pulse.chain
    at_rest = {"peak_force": chain.static_state.forces, "peak_overlap": chain.static_state.overlaps}
    if quantity not in at_rest or not at_rest[quantity].any():
        return []
    unit = QUANTITIES[quantity].unit
    between = at_rest[quantity][1:-1]
    low, high = (measure(float(each), unit, chain.units) for each in (between.min(), between.max()))
    shown = low if low == high else f"{low} to {high}"
    noun = quantity.removeprefix("peak_")
    return [f"{quantity}: it includes the static {noun}, {shown}"]


def _speed_notes(pulse: Pulse) -> list[str]:
    """Notes on speeds that are not those of the whole pulse."""
    from ..pulse.alternating_speed import alternates_at, over_two_contacts
    from ..pulse.free_end import ends_free

    found, k = [], pulse.chain.beads // 2
    if alternates_at(pulse.speed, k) and pulse.residence is not None:
        mean = over_two_contacts(pulse.chain, pulse.residence, k)
        found.append(f"speed: it alternates from bead to bead; the mean is {mean}")
    if ends_free(pulse, "velocity") and pulse.speed is not None:
        found.append(
            "speed: the last one is that to the free end, where no bead ahead delays the arrival"
        )
    return found


def _cells(values: Array | None, rows: Sequence[int], digits: int) -> list[str]:
    """Numbers of some rows; empty without values, a dash for NaN."""
    from ..representation import in_column

    count = 0 if values is None else sum(i < len(values) for i in rows)
    shown = [] if values is None else in_column([float(values[i]) for i in rows[:count]], digits)
    return shown + [""] * (len(rows) - count)


def _add_notes(table: Table, pulses: list[Pulse], *more: str) -> None:
    """Add the reasons for missing values below the table."""
    from ..pulse.notes import WARNING, notes_in_words
    from ..pulse.pulse import EFFECTIVE_CHAIN

    notes = [note for pulse in pulses for note in notes_in_words(pulse.notes)]
    # Other theories warn themselves.
    notes += [each.notes[WARNING] for each in pulses if each.method == EFFECTIVE_CHAIN]
    notes += filter(None, more)
    lines = [str(table.caption)] if table.caption else []
    if notes:
        table.caption_justify = "left"
        table.caption = "\n".join(lines + list(dict.fromkeys(notes)))


def _bead_table(title: str, shown: int, count: int, per: str = "bead") -> Table:
    from rich import box
    from rich.table import Table

    caption = None if shown == count else f"{shown} of {count} {per}s; --all shows every one"
    table = Table(title=title, caption=caption, box=box.SIMPLE_HEAD, title_justify="left")
    table.add_column(f"{per} k", justify="right")
    return table


def table_rows(beads: int, every_bead: bool) -> list[int]:
    """Indices of the rows to show: all, or evenly spread ones with both ends."""
    import numpy as np

    if every_bead or beads <= TABLE_ROWS:
        return list(range(beads))
    return [int(i) for i in np.unique(np.linspace(0, beads - 1, TABLE_ROWS).round())]

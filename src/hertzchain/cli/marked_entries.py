"""Marks of entries in the table of several chains, and the notes that explain them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

from ..representation import listed

if TYPE_CHECKING:
    from .compared_yield import AtPressures
    from .repeated_impacts import Impacts

NONE: Final = "-"
OF_LAST_BEAD: Final = ("velocity of last bead", "momentum of last bead")
# Beginnings of the columns of sensors.
FIRST: Final = "first maximum in "
LARGEST: Final = "largest in "
# Sign of a force that is not a prediction.
UNPREDICTED: Final = "?"


def mark(rows: dict[str, dict[str, str]], column: str, names: Sequence[str]) -> None:
    """Mark the entries of these rows in a column as the smallest."""
    _put(rows, column, names, "*")


def _put(rows: dict[str, dict[str, str]], column: str, names: Sequence[str], sign: str) -> None:
    for name in names:
        rows[name][column] = f"{sign} {rows[name][column]}"


def mark_unpredicted(
    rows: dict[str, dict[str, str]], names: Sequence[str], columns: Sequence[str]
) -> None:
    """Mark the forces of these rows as no predictions."""
    for column in columns:
        _put(rows, column, [name for name in names if rows[name].get(column, NONE) != NONE],
             UNPREDICTED)  # fmt: skip


def sign_notes(rows: Mapping[str, Mapping[str, str]]) -> list[str]:
    """The meaning of the sign of forces that are not a prediction, if a table has it."""
    from ..chain.hertz_ratios import NO_PREDICTION

    entries = [entry for row in rows.values() for entry in row.values()]
    if not any(entry.startswith(UNPREDICTED) for entry in entries):
        return []
    return [
        f"{UNPREDICTED}: overlap / radius is above {NO_PREDICTION:g} with these contacts, where "
        "forces are not a prediction; they are not compared"
    ]


def dash_notes(
    rows: Mapping[str, Mapping[str, str]], at: Mapping[str, AtPressures], impacts: Impacts, *,
    ends_differ: bool = False,
) -> list[str]:  # fmt: skip
    """The reasons of all dashes in a table, with the chains to which they apply."""
    chains = {name: chain for names in impacts.names.values() for chain, name in names.items()}
    reasons: dict[str, dict[str, None]] = {}
    for column in shown_columns(rows):
        for name, row in rows.items():
            if row.get(column, NONE) == NONE:
                walled = row.get("peak", NONE) != NONE
                end = ends_differ and _reason_of_end(column, row, walled=walled)
                reason = end or _reason_of_dash(column, row, at.get(name))
                reasons.setdefault(reason, {})[chains.get(name, name)] = None
    return [
        f"{NONE}: {reason}{f', {listed([*names])}' if any(names) else ''}"
        for reason, names in reasons.items()
    ]


def shown_columns(rows: Mapping[str, Mapping[str, str]]) -> list[str]:
    """The columns in which any row has an entry."""
    return [
        key for key in dict.fromkeys(key for row in rows.values() for key in row)
        if any(row.get(key, NONE) != NONE for row in rows.values())
    ]  # fmt: skip


def _reason_of_end(column: str, row: Mapping[str, str], *, walled: bool) -> str:
    """Why a row has no entry in a column of other ends, if its end is the reason."""
    if column in ("peak", "time", "impulse", "duration") and not walled:
        return "no right wall"
    if column in (*OF_LAST_BEAD, "force on the cap", "acceleration") and walled:
        return "no free end"
    if column in ("force on the cap", "acceleration") and "force on the cap" not in row:
        return "no cap"
    return ""


def _reason_of_dash(column: str, row: Mapping[str, str], at: AtPressures | None) -> str:
    """Why a row has no entry in a column that its end can have."""
    if column.startswith("peak at "):
        return (
            "no right wall and no cap" if at is None
            else f"no peak at a yield pressure ({at.reason or 'not complete'})"
        )  # fmt: skip
    if column.startswith((FIRST, LARGEST)):
        return "no sensor in this bead"
    others = dict.fromkeys(OF_LAST_BEAD, "the pulse has not left the chain")
    others |= {"pressure/yield": "no known yield strength", "deepest dent": "no dents"}
    known = not row.get("peak", "not").startswith("not")
    return others.get(column, "the impact is not over" if known else "the force is not complete")

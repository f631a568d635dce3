"""Marks of entries in the table of several chains, and the notes that explain them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

from ..representation import listed

if TYPE_CHECKING:
    from .compared_yield import AtPressures
    from .repeated_impacts import Impacts

NONE: Final = "-"
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
    rows: Mapping[str, Mapping[str, str]], at: Mapping[str, AtPressures], impacts: Impacts
) -> list[str]:
    """The reasons of dashes in columns of yield."""
    chains = {name: chain for names in impacts.names.values() for chain, name in names.items()}
    reasons: dict[str, dict[str, None]] = {}
    for name, row in rows.items():
        chain = chains.get(name, name)
        if any(entry == NONE for key, entry in row.items() if key.startswith("peak at ")):
            reason = f"no peak at a yield pressure ({at[name].reason or 'not complete'})"
            reasons.setdefault(reason, {})[chain] = None
        if row.get("pressure/yield") == NONE:
            reasons.setdefault("no known yield strength", {})[chain] = None
    return [
        f"{NONE}: {reason}{f', {listed([*names])}' if any(names) else ''}"
        for reason, names in reasons.items()
    ]

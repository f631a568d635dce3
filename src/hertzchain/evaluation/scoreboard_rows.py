"""Rows of the table of a scoreboard, and this table as text."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Final

import numpy as np

from ..validation.keywords import checked_arguments
from .cases import GROUPS

if TYPE_CHECKING:
    from .scoreboard import Row, Scoreboard, Statistic

CAPTION: Final = "– not supported   * outside the range of the theory, which issues a warning"


@checked_arguments("percentage")
def percentage(error: float) -> str:
    """Format a relative error in % with two digits, or a dash for NaN.

    Parameters
    ----------
    error : float
        Relative error; NaN if a theory does not support a chain.

    Returns
    -------
    str
        Number without the % sign.

    Examples
    --------
    >>> import hertzchain as hc
    >>> errors = 26.517, 0.5312, 0.0718, 0.00123, float("nan")
    >>> [hc.evaluation.percentage(error) for error in errors]
    ['2652', '53', '7.2', '0.12', '–']
    """
    if np.isnan(error):
        return "–"
    percent = 100.0 * error
    exponent = int(f"{percent:.1e}".partition("e")[2])
    decimals = 0 if percent == 0.0 else max(0, 1 - exponent)
    return f"{percent:.{decimals}f}"


def scoreboard_title(board: Scoreboard, quantity: str, first_bead: int, statistic: str) -> str:
    """Quantity, statistic and beads of the numbers in the table."""
    return (
        f"{quantity}: {statistic} relative error in %, k = {first_bead}..{board.last_bead} "
        f"of {len(board.cases)} chains"
    )


def scoreboard_rows(
    board: Scoreboard, quantity: str = "velocity", first_bead: int = 10,
    statistic: Statistic = "worst", by: Row = "family",
) -> list[tuple[str, list[str]]]:  # fmt: skip
    """Label and errors of each row; headings of groups have no errors."""
    errors = board.table(quantity, first_bead=first_bead, statistic=statistic, by=by)
    outside, group = board.outside(by), None
    rows: list[tuple[str, list[str]]] = []
    for label, members in board.rows(by).items():
        if board.cases[members[0]].group != group:
            group = board.cases[members[0]].group
            rows.append((GROUPS[group], []))
        cells = [percentage(error) for error in errors.loc[label]]
        rows.append((label, [
            cell + ("*" if warned and cell != "–" else " ")
            for cell, warned in zip(cells, outside.loc[label], strict=True)
        ]))  # fmt: skip
    return rows


def scoreboard_text(board: Scoreboard) -> str:
    """Largest errors of the velocity from bead 10 on, by family of chains."""
    rows = scoreboard_rows(board)
    names = [theory.replace("-", "-\n").split("\n") for theory in board.theories]
    height, first = max(map(len, names)), max(len(label) for label, cells in rows if cells) + 1
    # The last column of a cell is that of its mark.
    widths = [
        max(*map(len, name), *(len(cells[t]) for _, cells in rows if cells))
        for t, name in enumerate(names)
    ]

    def line(label: str, cells: Iterable[str]) -> str:
        shown = (f"{cell:>{width}}" for cell, width in zip(cells, widths, strict=True))
        return " ".join((f"{label:<{first}}", *shown)).rstrip()

    heads = zip(*([""] * (height - len(name)) + name for name in names), strict=True)
    lines = [scoreboard_title(board, "velocity", 10, "worst"), *(line("", each) for each in heads)]
    for label, cells in rows:
        lines += [line(f" {label}", cells)] if cells else ["", label]
    return "\n".join((*lines, "", CAPTION))

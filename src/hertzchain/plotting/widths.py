"""Widths of figures in journals, and the text sizes that remain readable there."""

from __future__ import annotations

from contextvars import ContextVar
from typing import Final

from ..errors import InputError, short_repr
from ..units import quantity
from ..validation.numbers import number

METRES_PER_INCH: Final = 0.0254
# In metres, as in the instructions of most journals of physics.
COLUMNS: Final = {"single column": 0.086, "double column": 0.178}
# Size of a figure for which none is given.
HEIGHT_RATIO: Final = 0.72
MAX_HEIGHT: Final = 0.090 / METRES_PER_INCH

# Width of a figure [inches] below which panels and legends are below or above each other.
NARROW: Final = 5.0

# Width in inches of the enclosing `figure_style(width)`.
journal_width: ContextVar[float | None] = ContextVar("journal_width", default=None)
# Whether there is an enclosing `figure_style`, whose settings a user may have changed since.
styled: ContextVar[bool] = ContextVar("styled", default=False)


def width_in_inches(width: str | float) -> float:
    """Convert the name of a column, a length with a unit, or a number of inches."""
    if isinstance(width, str) and width in COLUMNS:
        return COLUMNS[width] / METRES_PER_INCH
    if isinstance(width, str) and quantity(width) is None:
        raise InputError(
            f"width must be {' or '.join(map(repr, COLUMNS))}, a length such as '86 mm', or a "
            f"number of inches, got {short_repr(width)}"
        )
    if isinstance(width, str):
        width = number("width", width, unit="m") / METRES_PER_INCH
    return number("width in inches", width, least=1.0, most=20.0, hint="for mm, give '86 mm'")


def journal_settings(width: float) -> dict[str, object]:
    """Settings of Matplotlib for a figure of this width in inches, printed without scaling."""
    sizes = {"font.size": 8, "axes.labelsize": 8, "axes.titlesize": 8, "legend.fontsize": 7,
             "xtick.labelsize": 7, "ytick.labelsize": 7, "lines.markersize": 3}  # fmt: skip
    height = min(HEIGHT_RATIO * width, MAX_HEIGHT)
    return {**sizes, "figure.figsize": (width, height), "savefig.dpi": 300}


def figure_size(width: float, height: float) -> tuple[float, float]:
    """The given size or, at the width of a journal, one with a height that leaves room for text."""
    inches = journal_width.get()
    return (width, height) if inches is None else (inches, height * (inches / width) ** 0.5)

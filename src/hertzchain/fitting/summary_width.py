"""Width of the lines of summaries."""

from __future__ import annotations

from ..validation.numbers import whole_number

# Lines of a summary shorter than this would consist mostly of their indent.
NARROWEST = 40


def summary_width(width: int | None) -> int | None:
    """Check the argument `width` of summaries."""
    return None if width is None else whole_number("width", width, least=NARROWEST)

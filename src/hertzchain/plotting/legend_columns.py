"""Order of the entries of a legend in which no column begins inside a group of curves."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from itertools import groupby
from typing import Any, Final

import numpy as np
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D

# Lines and symbols that are not drawn.
NOTHING: Final = ("None", "none", "", " ", None)


def in_whole_groups(
    handles: Sequence[Any], labels: Sequence[str], columns: int
) -> tuple[list[Any], list[str]]:
    """The entries, in another order if it keeps each group of curves in one column.

    Curves of one colour with symbols are a group, such as those of a chain, or of all methods.
    """
    sizes = [len(each) for each in np.array_split(np.arange(len(labels)), columns)]
    numbers = range(len(labels))
    groups = [[*each] for _, each in groupby(numbers, lambda i: _group(handles[i]))]
    order = _packed(groups, sizes) or [*numbers]
    return [handles[i] for i in order], [labels[i] for i in order]


def _group(handle: Any) -> Hashable:
    if not isinstance(handle, Line2D) or handle.get_marker() in NOTHING:
        return type(handle).__name__
    return to_hex(handle.get_color()), handle.get_linestyle() in NOTHING


def _packed(groups: Sequence[list[int]], sizes: Sequence[int]) -> list[int]:
    """Entries of all columns; none if some group has no room."""
    columns: list[list[int]] = [[] for _ in sizes]
    # Single entries fill what the groups leave.
    for group in sorted(groups, key=lambda each: len(each) == 1):
        room = (i for i, size in enumerate(sizes) if len(columns[i]) + len(group) <= size)
        if (place := next(room, None)) is None:
            return []
        columns[place] += group
    return [entry for column in columns for entry in column]

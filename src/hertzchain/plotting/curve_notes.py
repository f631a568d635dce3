"""Data of curves, which later curves in the same axes need for their labels and colours."""

from __future__ import annotations

import weakref
from typing import Generic, TypeVar

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

T = TypeVar("T")


class CurveNotes(Generic[T]):
    """Data of one kind, by curve; they are forgotten together with the figure."""

    def __init__(self) -> None:
        self._notes: weakref.WeakKeyDictionary[Line2D, T] = weakref.WeakKeyDictionary()

    def add(self, line: Line2D, note: T) -> None:
        """Remember the data of a curve."""
        self._notes[line] = note

    def of(self, axes: Axes) -> dict[Line2D, T]:
        """Curves of axes that have data, in the order in which they were drawn."""
        return {line: self._notes[line] for line in axes.lines if line in self._notes}

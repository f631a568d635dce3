"""Curves of several quantities or sweeps in the same axes: their unit, colours and labels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import takewhile
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from ..representation import MICROSECONDS, MILLISECONDS
from ..units import PERCENT
from .colours import COLOURS
from .curve_notes import CurveNotes
from .labels import distinguish, numbered
from .shared_axes import PREFIXED, SMALL, prefixed
from .style import broken_label
from .sweep_labels import ERRORS

if TYPE_CHECKING:
    import xarray as xr

# Words at the end of the common part of several labels that mean nothing without the next word.
LINKS: Final = frozenset(("of", "in", "at", "bead", "ball", "contact", "contacts"))


@dataclass(frozen=True)
class Unit:
    """Unit of the data of a sweep, and that of a plot, which is smaller by a factor."""

    own: str
    shown: str
    factor: float = 1.0


@dataclass(frozen=True, eq=False)
class Group:
    """Curves that are drawn together: their unit, quantity, title, and name by a user."""

    unit: Unit
    quantity: str
    caption: tuple[str, ...] = ()
    name: str = ""


@dataclass(frozen=True)
class _Noted:
    group: Group
    label: str
    colour: int


_curves: Final = CurveNotes[_Noted]()


def shared_unit(axes: Axes, drawn: Sequence[xr.DataArray]) -> Unit:
    """The unit of curves that the axes already have, or one that suits the largest value.

    Times are in us or ms, errors in percent, and small values have a prefix.
    """
    own = str(drawn[0].attrs.get("units", "1"))
    for noted in _curves.of(axes).values():
        if noted.group.unit.own == own:
            return noted.group.unit
    largest = max(
        float(np.nanmax(np.abs(each.values), initial=0.0)) if own in PREFIXED else 0.0
        for each in drawn
    )
    if all(str(each.name).startswith((*ERRORS,)) for each in drawn):
        return Unit(own, PERCENT, 100.0)
    if own in PREFIXED and own != "s" and 0.0 < largest < SMALL:
        factor, shown = prefixed(largest, own)
        return Unit(own, shown, factor)
    if own == "s" and 0.0 < largest < MILLISECONDS:
        return Unit(own, "µs", 1e6) if largest < MICROSECONDS else Unit(own, "ms", 1e3)
    return Unit(own, own)


def in_unit(drawn: xr.DataArray, unit: Unit) -> xr.DataArray:
    """Values in the unit of a plot."""
    if unit.factor == 1.0:
        return drawn
    return (unit.factor * drawn).assign_attrs({**drawn.attrs, "units": unit.shown})


def first_free_colour(axes: Axes, first: int, count: int) -> int:
    """Number of the first colour: a given one, unless other curves in the axes have this colour."""
    noted = _curves.of(axes)
    used = {each.colour for each in noted.values()}
    others = sum(
        line not in noted and len(line.get_xdata()) > 0  # type: ignore[arg-type]
        and not str(line.get_label()).startswith("_")
        for line in axes.lines
    )  # fmt: skip
    first += 0 if used else others
    taken = {each % len(COLOURS) for each in used if each >= 0}
    for begin in (first, *range(first + 1, first + len(COLOURS))):
        if taken.isdisjoint(i % len(COLOURS) for i in range(begin, begin + count)):
            return begin
    return max(used) + 1


def has_curves(axes: Axes) -> bool:
    """Whether axes have curves of a sweep."""
    return bool(_curves.of(axes))


def note_curve(line: Line2D, group: Group, label: str, colour: int) -> None:
    """Remember a curve, for curves of others in the same axes."""
    _curves.add(line, _Noted(group, label, colour))


def label_shared(axes: Axes) -> list[str] | None:
    """Label the curves of several groups in axes, and these; return the common parts of the title.

    None if the axes have one group.
    """
    noted = _curves.of(axes)
    groups = [*dict.fromkeys(each.group for each in noted.values())]
    for line, each in noted.items():
        if name := each.group.name:
            several = sum(other.group is each.group for other in noted.values()) > 1
            line.set_label(f"{name}, {each.label}" if several and each.label else name)
    if len(groups) < 2:
        return None
    names = [each.quantity.rpartition(" [")[0] or each.quantity for each in groups]
    quantities = dict(zip(groups, names, strict=True))
    described = [
        (each.label, *quantities[each.group].split(", "), *each.group.caption)
        for each in noted.values()
    ]
    for line, text in zip(noted, numbered(distinguish(described)[0]), strict=True):
        if not noted[line].group.name:
            line.set_label(text)
    axes.set_ylabel(broken_label(axes, "height", _common_label(groups, names)))
    first = groups[0].caption
    return [part for part in first if all(part in each.caption for each in groups)]


def _common_label(groups: Sequence[Group], names: Sequence[str]) -> str:
    """The words that quantities of the same unit have in common, or all quantities."""
    labels = [*dict.fromkeys(each.quantity for each in groups)]
    if len(labels) == 1:
        return labels[0]
    units = {each.quantity.rpartition(" [")[2] for each in groups if each.quantity.endswith("]")}
    whole = ", ".join(labels)
    if len({each.unit for each in groups}) > 1:
        return whole
    words = [name.split() for name in dict.fromkeys(names)]
    start, end = _common(words), _common([each[::-1] for each in words])[::-1]
    while start and start[-1].rstrip(",") in LINKS:
        start = start[:-1]
    text = " ".join(end if len(end) > len(start) else start).rstrip(",")
    if not text or text.count("$") % 2 or text.startswith("/"):
        return whole
    return f"{text} [{units.pop()}" if units else text


def _common(lists: Sequence[Sequence[str]]) -> list[str]:
    """The words with which all lists begin."""
    same = takewhile(lambda words: len({*words}) == 1, zip(*lists, strict=False))
    return [words[0] for words in same]

"""Titles of figures of sweeps."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from ..chain.laws.elastic_plastic import ElasticPlastic
from ..chain.yield_pressure import YIELD_STATED
from ..representation import counted
from .methods import name_of
from .style import literal
from .sweep_labels import coordinate_text
from .sweep_points import together_in_words

if TYPE_CHECKING:
    import xarray as xr

# Flags of the largest force on a wall, in words.
FLAGGED_PEAKS: Final = {
    "incomplete": "not complete", "sensitive": "may be sensitive to small changes",
}  # fmt: skip
# The flag of points outside the range of a method or of Hertz's law.
OUTSIDE: Final = "outside_range"
# Part of the names of quantities that have values where a force is not complete.
SO_FAR: Final = "so_far"


def caption_of(dataset: xr.Dataset, drawn: xr.DataArray, reference: str | None) -> list[str]:
    """Parts of the title: that of the sweep, selected values, and the reference of errors."""
    only = {"approach"} if dataset.sizes.get("approach") == 1 else set()
    caption = [
        literal(str(dataset.attrs.get("title", ""))),
        *(coordinate_text(value, str(name)) for name, value in drawn.coords.items()
          if value.ndim == 0 and name not in only),
        f"relative to {name_of(reference)}" if reference is not None else "",
        YIELD_STATED
        if "yield_pressure" in dataset.attrs and _may_yield(drawn) else "",
    ]  # fmt: skip
    return [part for part in (*caption, *together_in_words(drawn)) if part]


def _may_yield(drawn: xr.DataArray) -> bool:
    """Whether the values are not all those of a selected law without yield."""
    laws = [
        value
        for name, value in drawn.coords.items()
        if value.dtype.kind not in "ifb" and "loss" in f"{name} {value.attrs.get('long_name')}"
    ]
    return all(any(ElasticPlastic.name in str(law) for law in value.to_numpy().ravel())
               for value in laws)  # fmt: skip


def words_of_flags(
    drawn: xr.DataArray, flagged: dict[str, xr.DataArray], *, law: bool, log: bool, curves: bool
) -> list[str]:
    """Numbers of points whose force on a wall is flagged, or without a place, in words.

    The flags of the range are removed if every value has one: marks would distinguish none.
    """
    found = _take_common_range(drawn, flagged, law=law)
    if log and (count := int((drawn <= 0.0).sum())):
        found += [f"{counted(count, 'value')} not above 0, blank"]
    for flag, words in FLAGGED_PEAKS.items():
        count = _number_of_points(flagged[flag]) if flag in flagged else 0
        blank = flag == "incomplete" and SO_FAR not in str(drawn.name) and curves
        found += [f"{counted(count, 'point')} {words}{', blank' * blank}"] * bool(count)
    return found


def _take_common_range(
    drawn: xr.DataArray, flagged: dict[str, xr.DataArray], *, law: bool
) -> list[str]:
    """Remove the flags of the range from ``flagged`` if every value has one, and say so in words.

    Marks at every value would hide the values and distinguish none of them.
    """
    known = drawn.notnull()
    if OUTSIDE not in flagged or not known.any() or not flagged[OUTSIDE].where(known, True).all():
        return []
    del flagged[OUTSIDE]
    return ["all points outside the range of the method" + " or of Hertz's law" * law]


def _number_of_points(flags: xr.DataArray) -> int:
    """Number of points at which at least one plotted value is flagged."""
    within = [name for name in ("approach", *("bead", "contact")) if name in flags.dims]
    return int(flags.any(within).sum())

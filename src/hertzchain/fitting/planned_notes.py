"""Notes on the assumptions of a forecast."""

from __future__ import annotations

from ..chain.chain import Chain
from ..representation import listed, measure
from .cap_notes import planned_cap_notes
from .model import Model, Values
from .simulations import PASSES, range_notes


def planned_notes(model: Model, values: Values, duration: float, *, given: bool) -> tuple[str, ...]:
    """Notes on closed gaps, on the duration of the record unless it is given, and on the chain."""
    assumed = model.chain(0, values)
    return (
        *_of_closed_gaps(model, values), *([] if given else _of_record(assumed, duration)),
        *range_notes(assumed, duration), *planned_cap_notes(assumed, duration),
    )  # fmt: skip


def _of_closed_gaps(model: Model, values: Values) -> list[str]:
    """A note on gaps that are 0, next to which a gap has another error than one that is open."""
    closed = [str(name) for name in model.names if name.key == "gap" and values[name] == 0.0]
    if not closed:
        return []
    verb, its = ("is", "its error is") if len(closed) == 1 else ("are", "their errors are")
    what = "an open gap" if len(closed) == 1 else "open gaps"
    return [
        f"{listed(closed)} {verb} assumed to be closed, and {its} not that of {what}, which may be "
        "several times as large: give the expected size in the chain"
    ]


def _of_record(chain: Chain, duration: float) -> list[str]:
    """A note on reflections that a record of the default duration may not contain."""
    if not (chain.right_wall or chain.cap):
        return []
    return [
        f"the record is assumed to end after {measure(duration, 's')}, {PASSES:g} times the time "
        "in which the pulse passes the chain; a longer one, with the reflected pulse in all "
        "sensors, may determine parameters such as the loss better: give until"
    ]

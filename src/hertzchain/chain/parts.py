"""Base class of walls, drives and losses, which are created before their chain."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

from ..frozen import Frozen
from ..validation.numbers import has_unit


@dataclass(frozen=True, eq=False)
class Part(Frozen):
    """A part of a chain.

    Numbers with a unit are stored in SI.  A part is independent of its chain; it stores the names
    of the fields that had a unit, so that a scaled chain can reject them.

    Attributes
    ----------
    with_units : frozenset of str
        Names of the fields that were given with a unit.
    """

    with_units: frozenset[str] = field(init=False, repr=False, compare=False, default=frozenset())

    def __post_init__(self) -> None:
        found = {
            item.name for item in fields(self) if item.init and has_unit(getattr(self, item.name))
        }
        object.__setattr__(self, "with_units", frozenset(found))

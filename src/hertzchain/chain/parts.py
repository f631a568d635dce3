"""What walls, drives and losses have in common: they are described before their chain is."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

from ..frozen import Frozen
from ..validation.numbers import has_unit


@dataclass(frozen=True)
class Part(Frozen):
    """A part of a chain, whose numbers may have been given with units.

    Numbers with a unit are kept in SI.  Since a part does not know its chain, it keeps the names
    of those fields, so that a scaled chain can refuse them.

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

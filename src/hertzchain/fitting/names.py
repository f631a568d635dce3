"""Names of parameters, such as ``loss.time``, ``gap[8-9]``, ``gain[ball 6]``, ``loss.time@2``."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from ..errors import InputError, short_repr
from ..representation import listed
from ..traces.places import usual_name

# Walls, whose names begin those of their parameters.
ENDS: Final = ("left_wall", "right_wall")
TIME_OFFSET: Final = "time_offset"
NAME: Final = re.compile(
    r"(?P<base>[a-z_.]+?)(?:\[(?P<item>[^\]]+)\])?(?:\.(?P<field>[a-z_.]+))?(?:@(?P<shot>\d+|\*))?"
)


@dataclass(frozen=True)
class Name:
    """Parts of the name of a parameter.

    Attributes
    ----------
    key : str
        The name without brackets and shot, such as ``"loss.time"``.
    item : str
        Text in brackets: a ball, a contact, a material, a sensor; empty for all.
    shot : str
        Number of the shot, from 1; ``"*"`` for each shot; empty for a parameter that all shots
        have in common.
    """

    key: str
    item: str = ""
    shot: str = ""

    def __str__(self) -> str:
        base, *field = self.key.split(".", 1) if self.item else (self.key,)
        item = f"[{self.item}]" if self.item else ""
        rest = f".{field[0]}" if field else ""
        return f"{base}{item}{rest}{f'@{self.shot}' if self.shot else ''}"


def parse_name(text: object) -> Name:
    """Parse a name; raises `InputError` for text of another form."""
    found = NAME.fullmatch(text) if isinstance(text, str) else None
    if found is None:
        raise InputError(
            f"the name of a parameter must be like 'stiffness', 'loss.time', 'gap[8-9]' or "
            f"'gain[ball 6]', got {short_repr(text)}"
        )
    key = found["base"] + (f".{found['field']}" if found["field"] else "")
    item = found["item"] or ""
    # Names of materials are followed by a field.
    return Name(key, item if found["field"] else usual_name(item), found["shot"] or "")


def is_time_offset(text: object) -> bool:
    """Whether a name is that of the time offset of all shots or of one."""
    found = parse_name(text)
    return found.key == TIME_OFFSET and not found.item


def to_free(names: Sequence[Name | str]) -> str:
    """The advice to free further parameters."""
    return f"add {listed([repr(str(each)) for each in names])} to the free parameters (also_free)"

"""Types of which schemas of TOML files consist: a key, and a section of keys."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from ..units import UNITS

Kind = Literal[
    "number", "integer", "boolean", "choice", "text", "material", "file", "signal", "law"
]
Per = Literal["", "bead", "contact", "row", "item"]


@dataclass(frozen=True)
class Key:
    """A key of a section.

    Attributes
    ----------
    name : str
        Name of the key.
    kind : str
        ``"number"``, ``"integer"``, ``"boolean"``, ``"choice"``, ``"text"``, ``"material"``
        (a name), ``"file"`` (a path relative to the chain file), ``"signal"`` (text on the signal
        in a file) or ``"law"`` (a table such as ``[chain.loss]``).
    description : str
        Meaning of the value.
    default : object
        Value if the key is omitted; `None` if the value then follows from other keys.
    required : bool
        Whether the key must be present.
    unless : str
        Name of another key with which a required key may be omitted.
    dimension : str
        A key of `hertzchain.units.UNITS`, if the value has a unit in SI chains; text such as
        ``"5 mm"`` is then allowed.  Scaled chains accept only plain numbers.  A stiffness is in
        N/m^p, with the exponent p of the chain.
    fraction : bool
        Whether text such as ``"5%"`` is allowed.
    dimension_if_displacement : str
        Dimension if the key ``of`` is ``"displacement"``, where that differs.
    choices : tuple of str
        Allowed values of a choice.
    other : str
        Words for the message about any other value, on keys to use instead.
    above, least, most, below : float
        Bounds of a number.
    per : str
        ``"bead"``, ``"contact"``, ``"row"`` or ``"item"`` for a list with one value for each.
    one_for_all : bool
        Whether one value may be given instead of a list.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.store.schema_keys import Key
    >>> Key("gap", "number", "distance", default=0.0, dimension="length").si_unit
    'm'
    """

    name: str
    kind: Kind
    description: str
    default: float | bool | str | None = None
    required: bool = False
    unless: str = ""
    dimension: str = ""
    fraction: bool = False
    dimension_if_displacement: str = ""
    choices: tuple[str, ...] = ()
    other: str = ""
    above: float = -math.inf
    least: float = -math.inf
    most: float = math.inf
    below: float = math.inf
    per: Per = ""
    one_for_all: bool = False

    @property
    def si_unit(self) -> str:
        """Unit in SI; empty without one."""
        return UNITS[self.dimension][0] if self.dimension else ""


@dataclass(frozen=True)
class Section:
    """A table of a chain file.

    Attributes
    ----------
    name : str
        Name, such as ``"chain.right_wall"``; ``NAME`` denotes any name.
    description : str
        Meaning of the section.
    keys : tuple of Key
        Keys of the section.
    repeated : bool
        Whether several tables are allowed, as in ``[[chain.struck_by]]``.
    variant_key : str
        A required key whose value selects further keys; empty if there is none.
    variants : mapping of str to tuple of Key
        Further keys, by the value of `variant_key`.
    texts : tuple of str
        Examples of texts that can replace the table; empty if none can.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.store.schema_keys import Section
    >>> from hertzchain.store.schema_keys import Key
    >>> Section("chain.end", "an end", (Key("gap", "number", "distance"),)).keys[0].name
    'gap'
    """

    name: str
    description: str
    keys: tuple[Key, ...]
    repeated: bool = False
    variant_key: str = ""
    variants: Mapping[str, tuple[Key, ...]] = field(default_factory=dict)
    texts: tuple[str, ...] = ()


def section_as_dict(section: Section) -> dict[str, Any]:
    """Convert a section to plain types."""
    return {
        "description": section.description,
        "repeated": section.repeated,
        "keys": [_key_as_dict(key) for key in section.keys],
        "variant_key": section.variant_key,
        "variants": {
            name: [_key_as_dict(key) for key in keys] for name, keys in section.variants.items()
        },
        "texts": list(section.texts),
    }


def _key_as_dict(key: Key) -> dict[str, Any]:
    entry = {"unit": key.si_unit, **dataclasses.asdict(key), "choices": list(key.choices)}
    # JSON has no infinite numbers: infinite bounds are omitted.
    return {
        name: value
        for name, value in entry.items()
        if not (isinstance(value, float) and math.isinf(value))
    }

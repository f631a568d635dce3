"""Exponents of the contacts whose stiffness an axis varies, which determine its unit N/m^p."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Final

from ..chain.chain import Chain
from ..collision import HERTZ_EXPONENT
from ..store.schema_paths import is_place

# Contacts of the tables of [chain] that have a stiffness, counted as in `Chain.contact_exponents`.
_CONTACT: Final = {"left_wall": 0, "right_wall": -1, "cap": -2, "struck_by": 1, "stiffness": 1}


def stiffness_exponent(
    path: tuple[str, ...], chain: Chain | Any, paths: Iterable[tuple[str, ...]]
) -> float | None:
    """Exponent of the contact of an axis of stiffness, if it is the same at all points.

    ``chain`` is a chain or the table [chain]; ``paths`` are those of all axes.
    """
    words = tuple(word for word in path if not is_place(word))
    if words[-1] != "stiffness" or words[0] not in _CONTACT:
        return None
    varying = [tuple(word for word in each if not is_place(word)) for each in paths]
    if {("exponent",), (words[0], "exponent"), words[:-1]} & {*varying}:
        return None
    if isinstance(chain, Chain):
        if words[0] == "stiffness":
            return chain.exponents if isinstance(chain.exponents, float) else None
        return float(chain.contact_exponents[_CONTACT[words[0]]])
    return _of_table(chain, words[0]) if isinstance(chain, Mapping) else None


def _of_table(table: Mapping[str, Any], name: str) -> float | None:
    """Exponent of a contact in [chain], of which the table ``name`` may have its own."""
    part = table.get(name)
    own = part.get("exponent") if isinstance(part, Mapping) else None
    found = table.get("exponent", HERTZ_EXPONENT) if own is None else own
    return float(found) if isinstance(found, int | float) else None

"""Losses of a chain with other values of their parameters."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from ..chain.chain import Chain
from ..chain.laws import Loss
from ..chain.per_contact import MaterialPairs
from ..errors import InputError
from .ball_counts import numbers_in_words
from .law_parameters import has, walls_with_own_laws
from .names import ENDS, Name


def contact_index(chain: Chain, name: Name) -> int:
    """Index of the contact of two balls, such as ``8-9``; ball 0 is the last striker."""
    try:
        first, second = (int(part) for part in name.item.split("-"))
    except ValueError:
        raise InputError(
            f"{name} must name two neighbouring balls, such as {Name(name.key, '8-9')}"
        ) from None
    index = first + chain.strikers - 1
    if second != first + 1 or not 0 <= index < chain.beads - 1:
        raise InputError(
            f"{name} is not a contact of this chain, whose {numbers_in_words(chain)}; name two "
            f"neighbours, such as {Name(name.key, '8-9')}"
        )
    return index


def changed_losses(
    chain: Chain, values: Mapping[Name, float]
) -> tuple[dict[str, Any], dict[str, Loss]]:
    """The field ``loss`` of a chain with other values, and the laws that walls then need.

    A parameter of all contacts is not one of a wall with its own law.
    """
    laws, common = list(chain.contact_losses), chain.loss
    one = not isinstance(common, tuple | MaterialPairs) and not any(name.item for name in values)
    # Values of single contacts and walls are set after those of all contacts.
    for name in sorted(values, key=lambda each: bool(each.item) or _is_of_wall(each)):
        change: dict[str, Any] = {name.key.rsplit(".", 1)[1]: values[name]}
        laws = _changed_laws(chain, laws, name, change)
        if isinstance(common, Loss) and not name.item and not _is_of_wall(name):
            common = dataclasses.replace(common, **change)
    changes = {} if all(map(_is_of_wall, values)) else {"loss": common if one else laws[1:-1]}
    # Walls without a law of their own have that of the contact next to them.
    following = chain.replace(**changes).contact_losses if changes else chain.contact_losses
    sides = zip(ENDS, (0, -1), strict=True)
    return changes, {
        end: laws[side]
        for end, side in sides
        if getattr(chain, end) is not None and following[side] != laws[side]
    }


def _is_of_wall(name: Name) -> bool:
    return name.key.startswith(ENDS)


def _changed_laws(
    chain: Chain, laws: list[Loss], name: Name, change: Mapping[str, Any]
) -> list[Loss]:
    """Laws of all contacts with one parameter changed; shared law objects remain shared."""
    if _is_of_wall(name):
        chosen = {0 if name.key.startswith("left") else chain.beads}
    elif name.item:
        chosen = {contact_index(chain, name) + 1}
    else:
        (field,) = change
        chosen = {k for k, law in enumerate(laws) if has(law, field)}
        chosen -= {*walls_with_own_laws(chain).values()}
    made: dict[int, Loss] = {}
    out = list(laws)
    for k in chosen:
        law = laws[k]
        if id(law) not in made:
            made[id(law)] = dataclasses.replace(law, **change)
        out[k] = made[id(law)]
    return out

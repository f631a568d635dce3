"""Laws of loss and exponents in chain files: of all contacts, of each, or of pairs of materials."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any, Final, TypeAlias

from ..chain.chain import Chain
from ..chain.laws import LAWS, Loss
from ..chain.laws.given_restitution import usual_contact
from ..chain.per_contact import OTHERS
from ..chain.walls import materials_with_walls
from ..errors import InputError, errors_at
from .schema_checks import has_tables

# Materials of a file by their names.
MaterialsNamed: TypeAlias = Callable[[Any], Any]
# Keys of a collision whose restitution determines a parameter of a law.
COLLISION: Final = ("restitution", "speed", "contact")


def law_from(
    entry: Mapping[str, Any], chain: Chain, contact: int | None, place: str = "[chain.loss]"
) -> Loss:
    """The law of a table, which may give the restitution of a contact instead of a parameter."""
    law = LAWS[entry["law"]]
    collision = {key: entry[key] for key in COLLISION if key in entry}
    values = {
        key: value for key, value in entry.items() if key not in ("law", "between", *COLLISION)
    }
    if not collision:
        return law(**values)
    for key, example in (("restitution", "0.93"), ("speed", '"0.8 m/s"')):
        if key not in collision:
            raise InputError(
                f"{place} has {' and '.join(collision)} but no {key}: the restitution of a "
                f"collision and its speed belong together, so add {key}, such as {key} = {example}"
            )
    used = collision.get("contact", contact)
    if used is None:
        raise InputError(
            f"{place} has the restitution of materials that touch nowhere in this chain: give the "
            "contact in which it was measured, or the parameter of the law"
        )
    with errors_at(place):
        return law.from_restitution(
            collision["restitution"], speed=collision["speed"], chain=chain, contact=used,
            given=values,
        )  # fmt: skip


def losses_from(given: Any, materials: MaterialsNamed, chain: Chain) -> Any:
    """A law of all contacts, a list with one for each, or a mapping from pairs of materials."""
    listed = [given] if isinstance(given, Mapping) else given
    if len(listed) == 1 and "between" not in listed[0]:
        return law_from(listed[0], chain, usual_contact(chain))
    if not any("between" in each for each in listed):
        return [law_from(each, chain, k) for k, each in enumerate(listed, start=1)]
    tables = _by_pairs("loss", listed, materials)
    return {
        pair: law_from(each, chain, _contact_of(pair, tables.keys(), chain))
        for pair, each in tables.items()
    }


def _contact_of(pair: Any, pairs: Collection[Any], chain: Chain) -> int | None:
    """The first contact of a pair of materials, of strikers and walls only if there is no other."""
    if chain.materials is None:
        return usual_contact(chain)
    walls, last = (chain.left_wall, chain.right_wall), chain.beads
    bodies, first = materials_with_walls(chain.materials, walls), min(chain.strikers + 1, last)
    ends = [contact for contact, wall in zip((0, last), walls, strict=True) if wall is not None]
    for contact in (*range(first, last), *range(1, first), *ends):
        found = frozenset(bodies[contact : contact + 2])
        if found == pair or (pair == OTHERS and found not in pairs):
            return contact
    return None


def exponent_from(given: Any, materials: MaterialsNamed) -> Any:
    """An exponent of all contacts, a list with one for each, or a mapping from pairs."""
    if not has_tables(given):
        return given
    listed = [given] if isinstance(given, Mapping) else given
    if not any("between" in each for each in listed):
        raise InputError(
            "[chain.exponent] requires between, two materials; for all contacts, write "
            f"exponent = {listed[0]['value']:g}"
        )
    tables = _by_pairs("exponent", listed, materials)
    return {pair: each["value"] for pair, each in tables.items()}


def _by_pairs(
    name: str, listed: Sequence[Mapping[str, Any]], materials: MaterialsNamed
) -> dict[Any, Mapping[str, Any]]:
    """Tables by pairs of materials; the one without between is for all other pairs."""
    found: dict[Any, Mapping[str, Any]] = {}
    for each in listed:
        pair: Any = OTHERS
        if "between" in each:
            names = each["between"]
            if len(names) != 2:
                raise InputError(
                    f"between of [chain.{name}] must have two materials, got {names!r}; a table "
                    "without between is for all other pairs"
                )
            pair = frozenset(materials(names))
        if pair in found:
            same = "are without between" if pair == OTHERS else "have the same between"
            raise InputError(f"two tables of [[chain.{name}]] {same}: omit one")
        found[pair] = each
    return found

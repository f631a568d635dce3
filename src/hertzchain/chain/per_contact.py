"""Exponents and laws of loss of contacts: given as one, as a list, or by pairs of materials."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Generic, TypeAlias, TypeVar

import numpy as np

from ..collision import HERTZ_EXPONENT, Array
from ..errors import InputError, short_repr
from ..representation import listed
from ..validation.numbers import real_numbers
from .input_checks import checked_exponent, checked_wall_exponent
from .laws import Loss
from .laws.elastic import Elastic
from .laws.elastic_plastic import ElasticPlastic
from .materials import Material, Materials, material
from .walls import Wall, material_of_wall, materials_with_walls

T = TypeVar("T")
Walls: TypeAlias = tuple[Wall | None, Wall | None]
ELASTIC: Final = Elastic()
# Exponent of a linear spring, such as a pad, which walls and strikers next to it do not share.
LINEAR: Final = 1.0
# Name of all pairs of materials that are not given, and their key in `MaterialPairs`.
OTHERS: Final = "others"
# Most separate ranges of contacts that messages list.
MAX_RANGES: Final = 4
OTHER_PAIRS: Final[frozenset[Material]] = frozenset()


@dataclass(frozen=True)
class MaterialPairs(Generic[T]):
    """A value for each pair of materials in contact, in either order, or for the other pairs."""

    what: str
    values: Mapping[frozenset[Material], T]

    def between(self, one: Material, other: Material, place: str) -> T:
        """The value of a contact of two materials."""
        for pair in (frozenset((one, other)), OTHER_PAIRS):
            if pair in self.values:
                return self.values[pair]
        raise InputError(
            f"there is no {self.what} for {one.name} on {other.name}, which meet at {place}: "
            f"give it for the pair ({one.name!r}, {other.name!r}) or for {OTHERS!r}"
        )

    def __repr__(self) -> str:
        items = (f"{_pair_name(pair)}: {value!r}" for pair, value in self.values.items())
        return "{" + ", ".join(items) + "}"


def _pair_name(pair: frozenset[Material]) -> str:
    """Two materials in words; the name of other pairs."""
    names = sorted(each.name for each in pair)
    return " on ".join(names if len(names) == 2 else 2 * names) or OTHERS


Exponent: TypeAlias = Any  # a float, an array with one per contact, or MaterialPairs
Losses: TypeAlias = Loss | tuple[Loss | None, ...] | MaterialPairs[Loss | None] | None


def _pairs(what: str, given: Mapping[Any, Any], check: Callable[[Any], T]) -> MaterialPairs[T]:
    """Check the pairs of a mapping, and look up names of materials."""
    values: dict[frozenset[Material], T] = {}
    for pair, value in given.items():
        if isinstance(pair, str) and pair == OTHERS:
            values[OTHER_PAIRS] = check(value)
            continue
        names = tuple(pair) if isinstance(pair, tuple | frozenset) else ()
        if len(names) == 1 and isinstance(pair, frozenset):
            names *= 2
        if len(names) != 2:
            raise InputError(
                f"{what} by materials needs pairs such as ('steel-316', 'ptfe'), or {OTHERS!r}, "
                f"got {short_repr(pair)}"
            )
        values[frozenset(map(material, names))] = check(value)
    if not values:
        raise InputError(f"{what} by materials has no pairs: give one for each kind of contact")
    return MaterialPairs(what, values)


def _one_if_equal(values: Sequence[T]) -> T | tuple[T, ...]:
    """One value if all are equal."""
    return values[0] if all(each == values[0] for each in values) else tuple(values)


def checked_exponents(given: Any, contacts: int) -> Exponent:
    """An exponent for all contacts, an array with one for each, or one for pairs of materials."""
    if isinstance(given, MaterialPairs):
        return given
    if isinstance(given, Mapping):
        return _pairs("exponent", given, checked_exponent)
    listed = isinstance(given, list | tuple) or (isinstance(given, np.ndarray) and given.ndim)
    if not listed:
        # The only contact of two bodies can be that of a pad.
        return checked_exponent(given) if contacts > 1 else _of_single_contact(given)
    values = real_numbers("exponent", given, "contact")
    _check_count("exponents", values.shape, contacts)
    one = _one_if_equal([_of_single_contact(each) for each in values.tolist()])
    if not isinstance(one, tuple):
        if one == LINEAR and contacts > 1:
            raise InputError(
                f"all {contacts} contacts have the exponent 1, but only some contacts of a chain "
                "can be linear springs, such as that of a pad between two beads; Hertz contacts "
                "have 1.5"
            )
        return one
    array = np.array(one)
    array.setflags(write=False)
    return array


def _of_single_contact(exponent: Any) -> float:
    """Check the exponent of one contact, which may be that of a linear spring."""
    return checked_wall_exponent(exponent, "exponent of the contact force")


def usual_exponent(exponents: Iterable[float]) -> float:
    """Exponent of a further contact: the first one that is not that of a linear spring."""
    return next((each for each in exponents if each != LINEAR), HERTZ_EXPONENT)


def checked_losses(given: Any, contacts: int) -> Losses:
    """A law for all contacts or `None`, one for each, or one for pairs of materials."""
    if isinstance(given, MaterialPairs):
        return given
    if isinstance(given, Mapping):
        return _pairs("loss", given, _checked_loss)
    if not isinstance(given, list | tuple):
        return _checked_loss(given)
    _check_count("laws of loss", (len(given),), contacts)
    return _one_if_equal([_checked_loss(each) for each in given])


def _checked_loss(given: Any) -> Loss | None:
    if given is not None and not isinstance(given, Loss):
        raise InputError(
            f"loss must be a law, such as Restitution(0.95) with the coefficient of restitution "
            f"0.95, or None, got {short_repr(given)}"
        )
    return None if given == ELASTIC else given


def _check_count(what: str, shape: tuple[int, ...], contacts: int) -> None:
    if contacts == 0:
        raise InputError(f"a single bead has no contact and no list of {what}: give one value")
    if shape != (contacts,):
        got = shape[0] if len(shape) == 1 else f"shape {shape}"
        raise InputError(
            f"there must be {contacts} {what}, one for each contact of two beads, got {got}; a "
            "wall has its own, Wall(exponent=..., loss=...)"
        )


def given_laws(loss: Losses) -> Iterable[Loss]:
    """All laws that a chain's `loss` names."""
    values: Iterable[Loss | None] = (
        loss.values.values() if isinstance(loss, MaterialPairs)
        else loss if isinstance(loss, tuple) else (loss,)
    )  # fmt: skip
    return [each for each in values if each is not None]


def contact_name(contact: int, beads: int) -> str:
    """Name of one of contacts 0..N in messages."""
    walls = {0: "the left wall", beads: "the right wall"}
    return walls.get(contact, f"contact {contact}")


def contacts_in_words(contacts: Array, beads: int) -> str:
    """``contacts 1 to 3 and 5 and the right wall``, of contacts in increasing order."""
    walls = [contact_name(c, beads) for c in contacts.tolist() if c in (0, beads)]
    inner = contacts[(contacts > 0) & (contacts < beads)]
    groups = np.split(inner, np.flatnonzero(np.diff(inner) > 1) + 1) if len(inner) else []
    ranges = [f"{each[0]} to {each[-1]}" if len(each) > 1 else f"{each[0]}" for each in groups]
    if len(ranges) > MAX_RANGES:
        words = [f"{len(inner)} contacts of two beads"]
    else:
        words = [f"contact{'s' * (len(inner) > 1)} {listed(ranges)}"] if ranges else []
    return listed([*words, *walls])


def spread(given: Any, own: tuple[Any, Any], materials: Materials, walls: Walls, beads: int) -> Any:
    """One value for each contact 0..N; ``own`` are the values of the walls, or None.

    The value of a wall without its own, or of a free end, is that of the contact next to it or,
    with pairs of materials, that of the wall's pair.
    """
    if isinstance(given, MaterialPairs):
        if materials is None:
            raise InputError(
                f"{given.what} by pairs of materials needs a chain of materials: use "
                "Chain.from_materials, or give a list with one for each contact"
            )
        inner = [
            given.between(materials[k], materials[k + 1], contact_name(k + 1, beads))
            for k in range(beads - 1)
        ]
    else:
        listed = isinstance(given, tuple | np.ndarray)
        inner = list(given) if listed else [given] * (beads - 1)
    ends = [inner[0], inner[-1]] if inner else [_any_value(given)] * 2
    for end, (wall, bead) in enumerate(zip(walls, (0, beads - 1), strict=True)):
        if own[end] is not None:
            ends[end] = own[end]
        elif wall is not None and isinstance(given, MaterialPairs):
            assert materials is not None
            place, own_material = contact_name(end * beads, beads), materials[bead]
            other = material_of_wall(wall, own_material)
            ends[end] = given.between(own_material, other, place)
    return [ends[0], *inner, ends[1]]


def _any_value(given: Any) -> Any:
    """Value at a free end of a single bead, which has no contact next to it."""
    return next(iter(given.values.values())) if isinstance(given, MaterialPairs) else given


def contact_exponents(exponent: Exponent, materials: Materials, walls: Walls, beads: int) -> Array:
    """Exponents of contacts 0..N."""
    own = tuple(None if wall is None else wall.exponent for wall in walls)
    if isinstance(exponent, float) and exponent != LINEAR and own == (None, None):
        return np.full(beads + 1, exponent)
    found = spread(exponent, own, materials, walls, beads)  # type: ignore[arg-type]
    inner = found[1:-1]
    for end, order in ((0, inner), (-1, inner[::-1])):
        if own[end] is None and found[end] == LINEAR:
            found[end] = usual_exponent(order)
    return np.array(found)


def contact_losses(
    loss: Losses, materials: Materials, walls: Walls, exponents: Array
) -> tuple[Loss, ...]:
    """Laws of contacts 0..N; `Elastic()` without one, or without the yield strength it needs.

    A law of spheres that is not given for a single contact does not apply to pads between two
    beads, nor to walls that are springs.
    """
    own, beads = tuple(None if wall is None else wall.loss for wall in walls), len(exponents) - 1
    laws = spread(loss, own, materials, walls, beads)  # type: ignore[arg-type]
    for c in _springs_without_law(loss, walls, exponents):
        laws[c] = None if isinstance(laws[c], ElasticPlastic) else laws[c]
    found = tuple(ELASTIC if each is None else each for each in laws)
    unknown = unknown_strengths(found, materials, walls)
    return tuple(ELASTIC if c in unknown else law for c, law in enumerate(found))


def _springs_without_law(loss: Losses, walls: Walls, exponents: Array) -> list[int]:
    """Pads, and walls of other exponents than spheres, for which no law is given by itself.

    None if there is no other contact, so that a law of spheres does not apply to the chain.
    """
    last = len(exponents) - 1
    ends = {c: wall for c, wall in ((0, walls[0]), (last, walls[1])) if wall is not None}
    springs = [c for c in ends if exponents[c] != HERTZ_EXPONENT]
    if last == 1 and springs == [*ends]:
        return []
    given = isinstance(loss, tuple)
    pads = [c for c in range(1, last) if exponents[c] == LINEAR and not given]
    return [*(c for c in springs if ends[c].loss is None), *pads]


def unknown_strengths(
    laws: Sequence[Loss], materials: Materials, walls: Walls
) -> dict[int, tuple[str, str]]:
    """Materials, by contact, of contacts whose law needs a yield strength and that have none.

    Raises `InputError` if these are all contacts with such a law.
    """
    needing = [c for c, law in enumerate(laws) if law.needs_yield_strength]
    if materials is None or not needing:
        return {}
    pairs = list(itertools.pairwise(materials_with_walls(materials, walls)))
    unknown = {
        c: (pairs[c][0].name, pairs[c][1].name)
        for c in needing
        if all(body.yield_strength is None for body in pairs[c])
    }
    ends = {0: walls[0], len(materials): walls[1]}
    touching = [c for c in needing if ends.get(c, True) is not None]
    if touching and unknown.keys() >= set(touching):
        place = contact_name(c := touching[0], len(materials))
        one, other = unknown[c]
        raise InputError(
            f"ElasticPlastic() needs a known yield strength for at least one contact, but "
            f"{one!r} and {other!r}, which meet at {place}, have none, nor have the materials of "
            "any other contact with this law; give ElasticPlastic(yield_pressure='5 MPa') or "
            "materials with yield_strength"
        )
    return unknown

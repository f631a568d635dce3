"""Words for the properties in which chains differ, for the labels of curves in all figures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ..chain.chain import Chain
from ..chain.chain_words import (
    cap_in_words,
    described_loss,
    described_strikers,
    described_wall,
    description_parts,
)
from ..chain.description import law_in_words, length_in_words
from ..chain.laws import Loss
from ..chain.laws.elastic import Elastic
from ..chain.laws.given_numbers import law_with_value
from ..chain.walls import Wall
from ..representation import MAX_DIGITS, measure
from .style import with_micro
from .titles import (
    cap_in_title,
    load_in_title,
    loss_in_title,
    short_material,
    title_parts,
    wall_in_words,
)

# Digits of values; the second number is for values that the first one does not distinguish.
DIGITS: Final = (4, MAX_DIGITS)
# Arrays of a chain, with their names and units, by which chains of equal beads in words differ.
ARRAYS: Final = (
    ("radii", "radius", "m"), ("materials", "material", ""), ("masses", "mass", "kg"),
    ("velocities", "velocity", "m/s"), ("gaps", "gap", "m"), ("stiffness", "stiffness", ""),
    ("contact_exponents", "exponent", ""), ("contact_losses", "loss", ""),
)  # fmt: skip
VAGUE: Final = ("given masses", "given stiffness", "mixed exponents")
OF_CONTACTS: Final = ("gaps", "stiffness", "contact_exponents", "contact_losses")


@dataclass(frozen=True)
class _Property:
    """A property in words, with a number of digits, and the parts of titles that it replaces."""

    words: Callable[[Chain, int], str]
    replaced: Callable[[Chain], Sequence[str]] = lambda _: ()


def words_of_chains(chains: Sequence[Chain]) -> list[list[str]]:
    """Words of each chain, in parts; every property in which the chains differ is among them.

    Beads are described as in titles, unless their short words are the same for different beads.
    """
    found = [_differing(each, chains) for each in PROPERTIES]
    named = [[*parts] for parts in zip(*(words for words in found if words), strict=True)]
    replaced = [each for each, words in zip(PROPERTIES, found, strict=True) if words]
    strikers = STRIKERS not in replaced
    titles, described = (
        [_without(parts(chain), replaced, chain) for chain in chains]
        for parts in (
            lambda chain: _title_parts(chain, strikers=strikers, walls=len(chains) > 1),
            description_parts,
        )
    )
    for words in (titles, described):
        _omit_vague(words)
    longer = any(chain.scaled for chain in chains) or _kinds(described) > _kinds(titles)
    beads = described if longer else titles
    every = [[*both, *own] for both, own in zip(beads, named or [[]] * len(chains), strict=True)]
    for array in ARRAYS:
        _name_places(every, chains, *array)
    return every


def _title_parts(chain: Chain, *, strikers: bool, walls: bool) -> list[str]:
    """The parts of a title; with ``walls``, also those of the material of the beads."""
    parts = [*title_parts(chain, strikers=strikers), *filter(None, (load_in_title(chain),))]
    if not walls:
        return parts
    for side, wall, end in (("left", chain.left_wall, 0), ("right", chain.right_wall, -1)):
        if wall is not None and not wall_in_words(chain, wall, end):
            parts.append(f"{side} wall")
    return parts


def _kinds(words: Sequence[Sequence[str]]) -> int:
    return len({*map(tuple, words)})


def _differing(about: _Property, chains: Sequence[Chain]) -> list[str]:
    """Words of a property of each chain, empty if these do not differ."""
    short, exact = ([about.words(chain, digits) for chain in chains] for digits in DIGITS)
    words = exact if len(set(exact)) > len(set(short)) else short
    return words if len(set(words)) > 1 else []


def _without(parts: list[str], replaced: Sequence[_Property], chain: Chain) -> list[str]:
    omitted = {part for each in replaced for part in each.replaced(chain)}
    return [part for part in parts if part not in omitted]


def _omit_vague(words: list[list[str]]) -> None:
    """Omit features that only some chains have, and whose values `ARRAYS` name."""
    for feature in VAGUE:
        if not all(feature in parts for parts in words):
            words[:] = [[part for part in parts if part != feature] for parts in words]


def _name_places(
    words: list[list[str]], chains: Sequence[Chain], field: str, name: str, unit: str
) -> None:
    """Add a value of an array to the words of chains that have the same ones, but not its values.

    It is that of the bead or contact with the largest number of different values.
    """
    groups: dict[tuple[str, ...], list[int]] = {}
    for i, parts in enumerate(words):
        groups.setdefault(tuple(parts), []).append(i)
    for group in groups.values():
        columns = [_values(chains[i], field) for i in group]
        kinds = [len({*values}) for values in zip(*columns, strict=False)]
        if max(kinds, default=1) == 1:
            continue
        place = int(np.argmax(kinds))
        where = f"contact {place + (field in ('gaps', 'stiffness'))}"
        if field not in OF_CONTACTS:
            where = f"bead {place + 1}"
        for i, column in zip(group, columns, strict=True):
            value = column[place]
            if not isinstance(value, str):
                value = _number(value, unit, chains[i].units, 6)
            words[i].append(f"{name} of {where}: {value}")


def _number(value: float, unit: str, units: str, digits: int) -> str:
    """A number with its usual unit, or a scaled one."""
    if unit == "m" and units == "SI":
        return with_micro(length_in_words(value, digits))
    return with_micro(measure(value, unit, units, digits).strip())


def _values(chain: Chain, field: str) -> list[Any]:
    """Values per bead or contact; those of contacts of absent walls are empty."""
    if field == "contact_losses":
        found = [words_of_loss(law, chain.units, MAX_DIGITS) for law in chain.contact_losses]
        for place, wall in ((0, chain.left_wall), (-1, chain.right_wall)):
            found[place] = "" if wall is None else found[place]
        return found
    if field == "materials":
        return [each.name for each in chain.materials or ()]
    return list(getattr(chain, field).tolist())


def words_of_loss(law: Loss, units: str, digits: int = DIGITS[0]) -> str:
    """The law in words, with the spelling of figures, such as ``viscoelastic 0.5 µs``."""
    return with_micro(law_with_value(law, units, digits, law.words))


def loss_in_words(chain: Chain, digits: int = DIGITS[0]) -> str:
    """The loss of contacts between beads; that of a wall belongs to the wall."""
    inner = chain.contact_losses[1 : max(chain.beads, 2)]
    laws = [words_of_loss(law, chain.units, digits) for law in inner]
    counts = Counter(laws)
    lossless = words_of_loss(Elastic(), chain.units)
    if len(counts) == 2 and lossless in counts:
        ((words, count),) = ((each, n) for each, n in counts.items() if each != lossless)
        if count > 1:
            return f"{words} in {count} contacts"
        return f"{words} in contact {laws.index(words) + 1}"
    if len(counts) == 2 and min(counts.values()) == 1 < max(counts.values()):
        (usual, _), (odd, _) = counts.most_common()
        return f"{usual} except {odd} in contact {laws.index(odd) + 1}"
    return "mixed losses" if len(counts) > 1 else next(iter(counts))


def _loss_of_walls(chain: Chain) -> tuple[str, ...]:
    """Words for losses in titles and descriptions, if walls alone have them."""
    inner = loss_in_words(chain) == "no loss"
    return (loss_in_title(chain), described_loss(chain)) if inner else ()


def _walled(chain: Chain, wall: Wall | None, side: str, digits: int) -> str:
    if wall is None:
        return f"no {side} wall"
    end = 0 if side == "left" else -1
    own = f"{short_material(chain.materials[end])} wall" if chain.materials else "wall"
    words = wall_in_words(chain, wall, end) or "wall"
    words = (own if words == "wall" else words).replace("wall", f"{side} wall", 1)
    if wall.exponent is not None:
        words += f" with p = {wall.exponent:g}"
    if wall.loss is not None:
        words += f" with {words_of_loss(wall.loss, chain.units, digits)}"
    return words


def _impact(chain: Chain, digits: int) -> str:
    speed = float(chain.velocities.max())
    return f"impact at {measure(speed, 'm/s', chain.units, digits)}" if speed > 0.0 else "at rest"


def _gaps(chain: Chain, digits: int) -> str:
    if "gaps" not in chain.given or not chain.gaps.any():
        return "no gaps"
    (open_ones,) = np.nonzero(chain.gaps)
    size = _number(float(chain.gaps.max()), "m", chain.units, digits)
    if len(open_ones) == 1:
        return f"gap of {size} in contact {open_ones[0] + 1}"
    return f"gaps up to {size}"


def _load(chain: Chain, digits: int) -> str:
    if not chain.precompression:
        return "no precompression"
    force = measure(chain.precompression, "N", chain.units, digits)
    return f"precompression {force}"


def _gravity(chain: Chain, digits: int) -> str:
    value = measure(chain.gravity, "m/s^2", chain.units, digits)
    return f"gravity {value}" if chain.gravity else "no gravity"


def _striker(chain: Chain, digits: int) -> str:
    """Materials, and masses or sizes, of strikers; the words of scaled chains contain them."""
    count = chain.strikers
    if chain.scaled or not count:
        return "" if chain.scaled else "no striker"
    names = " and ".join(dict.fromkeys(map(short_material, (chain.materials or ())[:count])))
    size = f"{1e3 * float(chain.masses[:count].sum()):.{digits}g} g"
    if chain.strikers_are_spheres:
        ends = dict.fromkeys(length_in_words(2.0 * r, digits) for r in chain.radii[:count])
        size = with_micro(" and ".join(ends))
    number = f"{count} " if count > 1 else ""
    return f"{number}{names} striker{'s' * (count > 1)} of {size}".strip()


def _drive(chain: Chain, digits: int) -> str:
    """Kind of the drive with its numbers."""
    if chain.drive is None:
        return "no drive"
    of, kind = chain.drive.of, type(chain.drive).__name__
    words = {"SineBurst": "sine burst", "StepDrive": "step", "TableDrive": "table"}[kind]
    numbers = {
        name: value for name, value in vars(chain.drive).items()
        if isinstance(value, float) and np.isfinite(value)
    }  # fmt: skip
    units = {"amplitude": {"force": "N", "displacement": "m"}[of], "frequency": "Hz"}
    shown = [
        f"{name} {_number(value, units.get(name, ''), chain.units, digits)}"
        for name, value in numbers.items()
    ]
    return f"{of} drive by a {words}" + (f" ({' and '.join(shown)})" if shown else "")


STRIKERS: Final = _Property(_striker, lambda chain: (described_strikers(chain),))
PROPERTIES: Final = (
    _Property(_impact, lambda _: ("velocities", "at rest")),
    STRIKERS,
    _Property(
        lambda chain, _: cap_in_title(chain) or "no cap",
        lambda chain: (cap_in_title(chain), cap_in_words(chain)),
    ),
    _Property(
        lambda chain, _: law_in_words(chain.exponents) or "p = 1.5",
        lambda chain: (law_in_words(chain.exponents),),
    ),
    _Property(_gaps, lambda _: ("gaps",)),
    _Property(_load, lambda chain: ("precompression", load_in_title(chain))),
    _Property(lambda chain, _: f"held by {chain.held_by}" if chain.precompression else ""),
    _Property(_gravity, lambda _: ("gravity", "under gravity")),
    _Property(
        lambda chain, digits: _walled(chain, chain.left_wall, "left", digits),
        lambda chain: ("left wall", described_wall(chain, "left"), *_loss_of_walls(chain)),
    ),
    _Property(
        lambda chain, digits: _walled(chain, chain.right_wall, "right", digits),
        lambda chain: (
            "right wall",
            described_wall(chain, "right"),
            wall_in_words(chain, chain.right_wall),
            *_loss_of_walls(chain),
        ),
    ),
    _Property(_drive, lambda _: ("drive",)),
    _Property(loss_in_words, lambda chain: (described_loss(chain), loss_in_title(chain))),
)

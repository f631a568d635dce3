"""Lists in [chain] of which an axis such as ``radii.5`` varies one value."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from ..chain.chain import Chain
from ..chain.materials import catalogue
from ..errors import unknown_name_error
from ..store.chain_as_toml import chain_document, listed_chain_document
from ..store.chain_files import ARRAYS
from ..store.chain_schema import MATERIAL_CONSTANTS
from ..store.schema_paths import is_material_constant, is_place
from ..validation.json_types import to_json_types
from .axes import Axis

# Keys of [chain] with one value for all beads, or one per bead.
FOR_ALL: Final = ("radii", "diameters", "materials", "masses")
OTHER_SIZE: Final = {"radii": "diameters", "diameters": "radii"}


def chain_as_document(chain: Chain, axes: Sequence[Axis] = ()) -> Any:
    """Tables of a chain file, with lists of the values of which axes vary single ones."""
    # Axes change radii, which then do not have the scatter of the chain.
    chain, keys = chain.replace(scatter=None), _keys(axes)
    if not keys:
        return to_json_types(chain_document(chain, struck_by=False), "chain")
    document = to_json_types(listed_chain_document(chain), "chain")
    table, balls = document["chain"], chain._balls.stop  # without a cap
    if "radii" in keys and "taper" in table and chain.radii[0] == 1.0:
        for name in ("taper", "beads", *dict(chain.taper_parameters)):
            table.pop(name)
        table["radii"] = chain.radii[:balls].tolist()
    if "diameters" in keys and chain.units == "SI":
        table["diameters"] = (2.0 * chain.radii[:balls]).tolist()
        del table["radii"]
    for key in keys & {*ARRAYS}:
        table[key] = getattr(chain, key).tolist()
    if "velocities" in keys:
        table.pop("velocity", None)
    return document | {"chain": with_lists(table, axes)}


def with_lists(table: Mapping[str, Any], axes: Sequence[Axis]) -> dict[str, Any]:
    """[chain] with a list instead of one value for all beads, if their number does not vary."""
    found = dict(table)
    beads = [key for key in FOR_ALL if key != "masses"]
    counts = [len(table[key]) for key in beads if isinstance(table.get(key), list)]
    counts += [each for each in [table.get("beads")] if isinstance(each, int)]
    if counts and ("beads",) not in [axis.path for axis in axes]:
        for key in _keys(axes) & {*FOR_ALL}:
            if isinstance(found.get(key), str | int | float):
                # Masses include that of a cap.
                extra = 1 if key == "masses" and "cap" in table else 0
                found[key] = [found[key]] * (counts[0] + extra)
    if any(isinstance(found.get(key), list) for key in _keys(axes) & OTHER_SIZE.keys()):
        found.pop("beads", None)
    return found


def missing_parts(
    table: Mapping[str, Any], materials: Mapping[str, Any], axes: Sequence[Axis]
) -> list[str]:
    """Find axes of strikers, materials and single values that [chain] and the other axes lack."""
    whole = {axis.path[0] for axis in axes if len(axis.path) == 1}
    named = {*_texts([table, [axis.values for axis in axes]])}
    known = {*materials, *catalogue()}
    problems = []
    for axis in axes:
        if is_material_constant(axis.path):
            _, name, constant = axis.path
            if constant not in MATERIAL_CONSTANTS:
                unknown = unknown_name_error("constant of a material", constant, MATERIAL_CONSTANTS)
                problems.append(f"axes.{axis.long_name}: {unknown}")
            elif name not in named & known:
                used = ", ".join(sorted(named & known)) or "no materials"
                problems.append(
                    f"axes.{axis.long_name}: [chain] has nothing of {name!r}; it has {used}"
                )
            continue
        key = axis.path[0]
        if key == "struck_by" and key not in (whole | table.keys()):
            problems.append(
                f"axes.{axis.long_name}: [chain] has no striker: add a table 'struck_by', or vary "
                "'velocity', the velocity of bead 1"
            )
            continue
        if key in whole or key not in _keys([axis]) or isinstance(table.get(key), list):
            continue
        has = f"one value of {key}, {table[key]!r}, for all" if key in table else f"no list {key}"
        advice = f"list the {key}"
        if key == "masses" and key not in table:
            advice = "give masses, one for all beads or a list"
        if key == "radii" and table.get("taper") == "uniform":
            radius = table.get("radius", 1.0)
            beads = f"beads = {table['beads']}" if "beads" in table else "the number of beads"
            advice += f", or write radii = {radius!r} and {beads} instead of the taper"
        elif key in ("radii", "diameters") and key in table and "beads" not in table:
            advice += ", or give beads, the number of equal beads"
        if OTHER_SIZE.get(key) in table:
            advice = f"list the {key}, or vary {OTHER_SIZE[key]}.{axis.path[1]}"
        problems.append(f"axes.{axis.long_name}: [chain] has {has}: {advice}")
    return problems


def _texts(given: Any) -> Iterator[str]:
    """All text among the values of tables and lists."""
    if isinstance(given, str):
        yield given
    elif isinstance(given, Mapping | list | tuple):
        for each in given.values() if isinstance(given, Mapping) else given:
            yield from _texts(each)


def _keys(axes: Sequence[Axis]) -> set[str]:
    """Keys of [chain] of which single values vary, ``radii`` of ``radii.5``."""
    return {axis.path[0] for axis in axes if len(axis.path) > 1 and is_place(axis.path[1])}

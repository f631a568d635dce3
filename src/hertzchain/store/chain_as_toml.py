"""Writing of chains as TOML chain files."""

from __future__ import annotations

import contextlib
import dataclasses
import tomllib
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from ..chain.chain import Chain
from ..chain.feature_support import require_chain
from ..chain.laws import Loss
from ..chain.laws.elastic import Elastic
from ..chain.materials import RIGID, Material, catalogue
from ..chain.per_contact import MaterialPairs
from ..chain.walls import Wall
from ..errors import InputError
from ..recorded_warnings import ignore_warnings
from ..simulation.state import fingerprint
from ..validation.keywords import checked_arguments
from .chain_files import ARRAYS, LATER, chain_from
from .compact_beads import compact_beads, in_usual_units, listed_beads, one_for_all
from .drive_tables import DRIVES
from .strikers_as_toml import balls_of, struck_by_entries
from .toml_files import toml_key, toml_text

FLAT_FACE: Final = (
    "# The striker, bead {}, has a flat face; its size is that of a sphere of its mass.\n"
)


@checked_arguments("chain_as_toml")
def chain_as_toml(chain: Chain) -> str:
    """Write a chain as the text of a TOML chain file, which describes the same chain.

    `chain_from_toml` reads the text, and `load_chain` a file that contains it.

    Equal beads, repeated cells and tapers are written as such if their radii are the same, bit for
    bit.  Strikers are written as ``[[chain.struck_by]]`` if the chain read back is the same;
    otherwise they are listed among the beads, and a comment states that the size of a striker with
    a flat face is that of a sphere of its mass.  In SI units, sizes from 0.01 mm to 1 m are written
    in mm, so that the numbers read are those of the chain to the last bit.  Materials of the
    catalogue are written by name, others with their properties; different materials of one name are
    given different names.

    Parameters
    ----------
    chain : Chain
        Any chain.

    Raises
    ------
    InputError
        If the chain read back would move differently, which is always checked.

    Examples
    --------
    >>> import hertzchain as hc
    >>> print(hc.chain_as_toml(hc.Chain.uniform(2).replace(right_wall=hc.Wall.rigid())))
    [chain]
    taper = "uniform"
    beads = 2
    right_wall = {rigid = true, gap = 0.0}
    >>> print(hc.chain_as_toml(hc.Chain.from_materials("4.7 mm", "brass", beads=9, velocity=0.1)))
    [chain]
    diameters = "9.4 mm"
    beads = 9
    materials = "brass"
    velocity = "0.1 m/s"
    """
    require_chain("chain_as_toml", chain, beads=1)
    text = _shortest_text(chain, with_units=True)
    listed = "striker_properties" in tomllib.loads(text)["chain"]
    flat = [i + 1 for i, each in enumerate(chain.striker_properties) if listed and each.flat]
    return "".join(FLAT_FACE.format(bead) for bead in flat) + text


def chain_document(chain: Chain, *, struck_by: bool = True) -> dict[str, Any]:
    """Tables of a chain file that describes a chain, as `chain_as_toml`, in plain numbers."""
    return tomllib.loads(_shortest_text(chain, with_units=False, struck_by=struck_by))


def listed_chain_document(chain: Chain) -> dict[str, Any]:
    """Tables of a chain file, as those of `chain_document`, with one radius per bead."""
    return tomllib.loads(_checked_text(chain, compact=False))


def _shortest_text(chain: Chain, *, with_units: bool, struck_by: bool = True) -> str:
    for apart in (True, False) if struck_by and chain.strikers else (False,):
        for compact in (True, False):
            with contextlib.suppress(InputError):
                return _checked_text(chain, compact=compact, with_units=with_units, struck_by=apart)
    return _checked_text(chain.replace(scatter=None), compact=False, with_units=with_units)


def _checked_text(
    chain: Chain, *, compact: bool, with_units: bool = False, struck_by: bool = False
) -> str:
    """Text of the chain, which describes the same chain if it is read."""
    listed = balls_of(chain) if struck_by else chain
    # The materials of a scaled chain have no effect, but in a file they would select SI units.
    materials = chain.materials or () if chain.units == "SI" else ()
    names = _names_of_materials(chain, materials)
    kinds = [names[each] for each in materials[chain.beads - listed.beads :]]
    entries = _beads_entries(listed, names, kinds, compact=compact) | _loads(chain)
    if with_units and chain.units == "SI":
        entries = in_usual_units(entries)
    for name in ("left_wall", "right_wall"):
        wall = getattr(chain, name)
        if wall is not None:
            entries[name] = _wall_entry(wall, names)
    if chain.loss is not None:
        entries["loss"] = _loss_entries(chain.loss, names)
    if chain.drive is not None:
        kind = next(label for label, cls in DRIVES.items() if type(chain.drive) is cls)
        entries["drive"] = {"kind": kind} | _fields(chain.drive)
    lines = ["[chain]", *(f"{name} = {toml_text(value)}" for name, value in entries.items())]
    if struck_by:
        for striker in struck_by_entries(chain, listed, names, with_units=with_units):
            lines += ["", "[[chain.struck_by]]"]
            lines += [f"{name} = {toml_text(value)}" for name, value in striker.items()]
    known = catalogue()
    for each, name in names.items():
        if known.get(name) == each:
            continue
        lines += ["", f"[materials.{toml_key(name)}]"]
        lines += [
            f"{key} = {toml_text(value)}" for key, value in _fields(each).items() if key != "name"
        ]
    text = "\n".join(lines)
    _check_round_trip(chain, text, every_field=struck_by)
    return text


def _beads_entries(
    chain: Chain, names: Mapping[Material, str], kinds: Sequence[str], *, compact: bool
) -> dict[str, Any]:
    """Keys of [chain] that describe the beads, of which ``kinds`` are the materials."""
    # The keys of the beads, unlike lists of their masses and the like, exclude the cap.
    balls = chain if chain.cap is None else chain.replace(precompression=0.0)[:-1]
    described, scatter = _without_scatter(balls)
    names_of_balls = kinds[: balls.beads]
    entries = (compact_beads if compact else listed_beads)(described, names_of_balls)
    entries |= scatter
    usual = {item.name: item.default for item in dataclasses.fields(chain)}
    if isinstance(chain.exponent, MaterialPairs):
        entries["exponent"] = [
            _pair(pair, names) | {"value": p} for pair, p in chain.exponent.values.items()
        ]
    elif np.any(chain.exponents != usual["exponent"]):
        entries["exponent"] = np.asarray(chain.exponents).tolist()
    for name in ("units", "strikers"):
        # Materials imply SI units.
        if (value := getattr(chain, name)) != usual[name] and not (name == "units" and kinds):
            entries[name] = value
    if chain.cap is not None:
        entries["cap"] = _fields(chain.cap)
        if kinds and kinds[-1] != kinds[-2]:
            entries["cap"]["material"] = kinds[-1]
    if chain.striker_properties:
        entries["striker_properties"] = [
            {name: value for name, value in _fields(each).items() if value is not False}
            for each in chain.striker_properties
        ]
    entries |= {name: one_for_all(getattr(chain, name)) for name in ARRAYS if name in chain.given}
    if kinds and "velocities" in chain.given and not chain.velocities[1:].any():
        entries["velocity"] = float(chain.velocities[0])
        del entries["velocities"]
    return entries


def _loads(chain: Chain) -> dict[str, Any]:
    usual = {item.name: item.default for item in dataclasses.fields(chain)}
    return {name: getattr(chain, name) for name in LATER if getattr(chain, name) != usual[name]}


def _without_scatter(chain: Chain) -> tuple[Chain, dict[str, Any]]:
    """The chain without deviations of its radii, and the key that adds them."""
    if chain.scatter is None:
        return chain, {}
    own = {name: getattr(chain.scatter, name) for name in ("radii", "taper", "taper_parameters")}
    size = {"relative": chain.scatter.relative, "grade": chain.scatter.grade}
    given = {name: value for name, value in size.items() if value is not None}
    return chain.replace(**own), {"with_scatter": given | {"radii": chain.radii.tolist()}}


def _names_of_materials(chain: Chain, kinds: Sequence[Material]) -> dict[Material, str]:
    """Different names for the materials of beads, walls and pairs."""
    walls = (chain.left_wall, chain.right_wall)
    used = [*kinds, *(wall.material for wall in walls if wall is not None)]
    for given in (chain.loss, chain.exponent):
        if isinstance(given, MaterialPairs):
            used += sorted({each for pair in given.values for each in pair}, key=str)
    names: dict[Material, str] = {}
    taken: set[str] = set()
    for each in used:
        if each is None or each == RIGID or each in names:
            continue
        name, number = each.name, 2
        while name in taken:
            name, number = f"{each.name} ({number})", number + 1
        names[each] = name
        taken.add(name)
    if RIGID in kinds:
        names[RIGID] = RIGID.name
    return names


def _check_round_trip(chain: Chain, text: str, *, every_field: bool) -> None:
    """Reject a file that does not describe the chain: its motion or, if required, every field."""
    try:
        with ignore_warnings():
            read = chain_from(tomllib.loads(text))
        same = fingerprint(read) == fingerprint(chain) and (not every_field or read == chain)
        reason = "the chain read back moves differently"
    except (InputError, tomllib.TOMLDecodeError) as error:
        same, reason = False, str(error)
    if not same:
        raise InputError(f"this chain cannot be written as a chain file: {reason}")


def _law_entry(law: Loss | None) -> dict[str, Any]:
    law = Elastic() if law is None else law
    return {"law": law.name} | _fields(law)


def _loss_entries(given: Any, names: Mapping[Material, str]) -> Any:
    """One table or, if contacts differ, a list of tables."""
    if isinstance(given, MaterialPairs):
        return [_pair(pair, names) | _law_entry(law) for pair, law in given.values.items()]
    if isinstance(given, tuple):
        return [_law_entry(law) for law in given]
    return _law_entry(given)


def _pair(pair: frozenset[Material], names: Mapping[Material, str]) -> dict[str, list[str]]:
    """The key of two materials, which a table of all other pairs does not have."""
    found = sorted(names[each] for each in pair)
    return {"between": found if len(found) == 2 else 2 * found} if found else {}


def _wall_entry(wall: Wall, names: Mapping[Material, str]) -> dict[str, Any]:
    entry: dict[str, Any] = {}
    if wall.stiffness is not None:
        entry["stiffness"] = wall.stiffness
    if wall.material == RIGID:
        entry["rigid"] = True
    elif wall.material is not None:
        entry["material"] = names[wall.material]
    entry["gap"] = wall.gap
    if wall.exponent is not None:
        entry["exponent"] = wall.exponent
    return entry if wall.loss is None else entry | {"loss": _law_entry(wall.loss)}


def _fields(item: Any) -> dict[str, Any]:
    """Fields of a part or material other than `None`, in plain types."""
    values = {each.name: getattr(item, each.name) for each in dataclasses.fields(item) if each.init}
    return {
        name: value.tolist() if isinstance(value, np.ndarray) else value
        for name, value in values.items()
        if value is not None
    }

"""The schema of chain files: every section and key, with type, unit, default and range.

`SECTIONS` is the only description of what a chain file can contain.  Reading, the command line,
sweeps and the documentation use it; an application can generate its controls from
`chain_schema`.  `check_document` compares a parsed file with it, before anything is built.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import numbers
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Final, Literal

import numpy as np

from ..chain.boundary_checks import HELD_BY
from ..chain.drives import DRIVEN, WINDOWS
from ..chain.laws import LAWS
from ..chain.laws.base import Parameter
from ..chain.tapers import PARAMETERS, TAPERS, parameter_description
from ..errors import short_repr, unknown_name_error
from ..units import UNITS, quantity

Kind = Literal["number", "integer", "boolean", "choice", "text", "material", "file", "law"]
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
        (a name), ``"file"`` (a path relative to the chain file) or ``"law"`` (a table such as
        ``[chain.loss]``).
    description : str
        What it is.
    default : object
        Its value if it is omitted; `None` if it then follows from other keys.
    required : bool
        Whether it must be there.
    dimension : str
        A key of `hertzchain.units.UNITS`, if it has a unit in SI chains; then text such as
        ``"5 mm"`` is understood.  Scaled chains take plain numbers only.  A stiffness is in
        N/m^p, with the exponent p of the chain.
    dimension_if_displacement : str
        Its dimension if the key ``of`` is ``"displacement"``, where that differs.
    choices : tuple of str
        What a choice can be.
    above, least, most, below : float
        Bounds of a number.
    per : str
        ``"bead"``, ``"contact"``, ``"row"`` or ``"item"`` if it is a list, with a value for each.
    one_for_all : bool
        Whether one value may be given in place of a list.

    Examples
    --------
    >>> Key("gap", "number", "distance", default=0.0, dimension="length").si_unit
    'm'
    """

    name: str
    kind: Kind
    description: str
    default: float | bool | str | None = None
    required: bool = False
    dimension: str = ""
    dimension_if_displacement: str = ""
    choices: tuple[str, ...] = ()
    above: float = -math.inf
    least: float = -math.inf
    most: float = math.inf
    below: float = math.inf
    per: Per = ""
    one_for_all: bool = False

    @property
    def si_unit(self) -> str:
        """Unit in SI; empty if it has none."""
        return UNITS[self.dimension][0] if self.dimension else ""


@dataclass(frozen=True)
class Section:
    """A table of a chain file.

    Attributes
    ----------
    name : str
        Its name, such as ``"chain.right_wall"``; ``NAME`` stands for any name.
    description : str
        What it describes.
    keys : tuple of Key
        Its keys.
    repeated : bool
        Whether there may be several, as ``[[chain.struck_by]]``.
    variant_key : str
        A required key whose value selects further keys; empty if there is none.
    variants : mapping of str to tuple of Key
        Further keys, by the value of `variant_key`.

    Examples
    --------
    >>> [key.name for key in SECTIONS["chain.loss"].variants["dashpot"]]
    ['gamma', 'attractive']
    """

    name: str
    description: str
    keys: tuple[Key, ...]
    repeated: bool = False
    variant_key: str = ""
    variants: Mapping[str, tuple[Key, ...]] = field(default_factory=dict)


def _number(name: str, description: str, dimension: str = "", **more: Any) -> Key:
    return Key(name, "number", description, dimension=dimension, **more)


_MATERIAL: Final = Key("material", "material", "material, in a chain of materials")
_OF: Final = Key(
    "of", "choice", "force on bead 1, or displacement of the left wall", default="force",
    choices=DRIVEN,
)  # fmt: skip
_AMPLITUDE: Final = _number(
    "amplitude", "amplitude of the force or displacement", "force",
    dimension_if_displacement="length", required=True,
)  # fmt: skip
_WALL: Final = (
    _MATERIAL,
    Key("rigid", "boolean", "whether the wall is rigid", default=False),
    _number("stiffness", "stiffness of its contact", "stiffness", above=0.0),
    _number("gap", "distance to the bead at time 0", "length", default=0.0, least=0.0),
    _number("exponent", "exponent of its contact; the chain's if omitted", above=1.0, most=50.0),
    Key("loss", "law", "law of loss of its contact; the chain's if omitted"),
)

# Forms in which the beads are given: the key that tells the form, and keys that go with it.
FORMS: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        "taper": (*PARAMETERS, "beads", "radius"),
        "radii": ("beads",),
        "cell": ("cells",),
        "mass_ratio": ("beads",),
        "file": (),
    }
)

_CHAIN: Final = (
    Key("taper", "choice", "name of a taper, or uniform", choices=(*TAPERS, "uniform")),
    *(_number(name, parameter_description(name)) for name in PARAMETERS),
    Key("beads", "integer", "number of beads", least=2),
    _number("radius", "radius of the first bead of a taper", "length", above=0.0),
    _number("radii", "radius of each bead; scaled, in any one unit", "length", above=0.0,
            per="bead", one_for_all=True),
    _number("cell", "radii of the beads of one cell", "length", above=0.0, per="bead",
            one_for_all=True),
    Key("cells", "integer", "how often the cell is repeated", least=1),
    _number("mass_ratio", "mass of the light beads over that of the heavy ones of a dimer",
            above=0.0),
    Key("file", "file", "CSV file with one row per bead"),
    _number("exponent", "exponent of the contact force", default=1.5, above=1.0, most=50.0,
            per="contact", one_for_all=True),
    Key("units", "choice", "units of the chain; SI follows from materials",
        choices=("scaled", "SI")),
    Key("materials", "material", "material of all beads, or of each bead (of the cell)",
        per="bead", one_for_all=True),
    _number("velocity", "velocity of bead 1 of a chain of materials", "velocity"),
    Key("strikers", "integer", "number of beads at the front that are strikers", default=0,
        least=0),
    _number("masses", "masses, if they do not follow from radii", "mass", above=0.0, per="bead",
            one_for_all=True),
    _number("stiffness", "stiffness of the contacts, if it does not follow", "stiffness",
            above=0.0, per="contact", one_for_all=True),
    _number("velocities", "velocities at time 0", "velocity", per="bead", one_for_all=True),
    _number("gaps", "distances of neighbours at time 0", "length", least=0.0, per="contact",
            one_for_all=True),
    _number("precompression", "static force on the contacts", "force", default=0.0, least=0.0),
    Key("held_by", "choice", "what holds a precompressed chain", default="walls",
        choices=HELD_BY),
    _number("gravity", "component of gravity along the chain", "acceleration", default=0.0),
)  # fmt: skip

_DECORATED: Final = (
    _number("ratio", "radius over the geometric mean of the large neighbours", above=0.0),
    _number("radius", "radius, in place of the ratio", "length", above=0.0),
    Key("between", "integer", "number of small beads between two large ones", default=1, least=1),
    _MATERIAL,
)
_DEFECTS: Final = (
    Key("bead", "integer", "number of the bead", required=True, least=1),
    _number("radius", "its radius", "length", required=True, above=0.0),
    _MATERIAL,
)
_SCATTER: Final = (
    Key("seed", "integer", "seed of the random numbers", required=True, least=0),
    _number("relative", "standard deviation of the logarithm of the radius", least=0.0, most=1.0),
    Key("grade", "integer", "ball grade of ISO 3290-1, in place of relative"),
)
_STRUCK_BY: Final = (
    _number("velocity", "velocity of the strikers", "velocity", default=1.0),
    _number("radius", "radius of a striker; inf is a flat face", "length", above=0.0),
    _number("mass", "mass of a striker", "mass", above=0.0),
    _MATERIAL,
    _number("stiffness", "stiffness of the new contacts", "stiffness", above=0.0),
    Key("count", "integer", "number of strikers", default=1, least=1),
    _number("gap", "distance to the chain", "length", default=0.0, least=0.0),
)
_BETWEEN: Final = Key(
    "between", "material", "the two materials whose contacts have this law", per="item"
)


def _law_key(name: str, about: Parameter, default: Any) -> Key:
    """A key for a parameter of a law."""
    kind: Kind = "boolean" if about.boolean else "number"
    required = default is dataclasses.MISSING
    bounds: dict[str, Any] = dict(about.bounds)
    return Key(
        name, kind, about.description, required=required, default=None if required else default,
        dimension=about.dimension, **bounds,
    )  # fmt: skip


_LAWS: Final[Mapping[str, tuple[Key, ...]]] = MappingProxyType(
    {
        name: tuple(
            _law_key(item.name, law.parameters()[item.name], item.default)
            for item in dataclasses.fields(law)
            if item.name in law.parameters()
        )
        for name, law in LAWS.items()
    }
)
_DRIVES: Final[Mapping[str, tuple[Key, ...]]] = MappingProxyType(
    {
        "sine-burst": (
            _AMPLITUDE,
            _number("frequency", "frequency", "frequency", required=True, above=0.0),
            _number("cycles", "number of periods, a multiple of 1/2", default=5.0, above=0.0),
            _OF,
            Key("window", "choice", "window of the burst", default="hann", choices=WINDOWS),
        ),
        "step": (
            _AMPLITUDE,
            _number("rise", "rise time", "time", default=0.0, least=0.0),
            _OF,
        ),
        "table": (
            _number("times", "increasing times, at least two", "time", per="row"),
            _number("values", "forces or displacements at these times", "force",
                    dimension_if_displacement="length", per="row"),
            _OF,
            Key("file", "file", "CSV file with columns time and force or displacement"),
        ),
    }
)  # fmt: skip
_MATERIALS: Final = (
    _number("density", "density", "density", required=True, above=0.0),
    _number("young", "Young's modulus; inf is rigid", "pressure", required=True, above=0.0),
    _number("poisson", "Poisson's ratio", required=True, above=-1.0, below=0.5),
    _number("yield_strength", "stress in tension at which it yields", "pressure", above=0.0),
    Key("source", "text", "where the numbers are from", default=""),
)

_LISTED: Final = (
    Section("chain", "the beads, and how they start", _CHAIN),
    Section("chain.decorated", "small beads between large ones", _DECORATED, repeated=True),
    Section("chain.with_defects", "a bead of another size or material", _DEFECTS, repeated=True),
    Section("chain.with_scatter", "radii that scatter", _SCATTER, repeated=True),
    Section("chain.struck_by", "strikers in front of the chain", _STRUCK_BY, repeated=True),
    Section("chain.left_wall", "the wall behind bead 1", _WALL),
    Section("chain.right_wall", "the wall in front of the last bead", _WALL),
    Section("chain.loss", "the law of loss; or one for each contact or pair of materials",
            (_BETWEEN,), repeated=True, variant_key="law", variants=_LAWS),
    Section("chain.drive", "force on bead 1 or motion of the left wall", (), variant_key="kind",
            variants=_DRIVES),
    Section("materials.NAME", "a material of your own", _MATERIALS),
)  # fmt: skip
SECTIONS: Final[Mapping[str, Section]] = MappingProxyType({each.name: each for each in _LISTED})
# Tables within [chain], in the order in which they are applied.
TABLES: Final = tuple(name.removeprefix("chain.") for name in SECTIONS if name.startswith("chain."))
# All that [chain] can contain.
KEYS: Final = (*(key.name for key in _CHAIN), *TABLES)


def chain_schema() -> dict[str, Any]:
    """All of the schema in plain types, as JSON can carry them.

    Returns
    -------
    dict
        ``sections``, ``forms`` and ``units``; bounds that a number does not have are left out.

    Examples
    --------
    >>> wall = chain_schema()["sections"]["chain.right_wall"]
    >>> [key["name"] for key in wall["keys"]]
    ['material', 'rigid', 'stiffness', 'gap', 'exponent', 'loss']
    >>> wall["keys"][3]["unit"], wall["keys"][3]["least"]
    ('m', 0.0)
    """
    forms = {form: list(keys) for form, keys in FORMS.items()}
    return {
        "sections": {name: section_as_dict(section) for name, section in SECTIONS.items()},
        "forms": forms,
        "units": {name: list(units) for name, units in UNITS.items()},
    }


def section_as_dict(section: Section) -> dict[str, Any]:
    """A section in plain types."""
    return {
        "description": section.description,
        "repeated": section.repeated,
        "keys": [_key_as_dict(key) for key in section.keys],
        "variant_key": section.variant_key,
        "variants": {
            name: [_key_as_dict(key) for key in keys] for name, keys in section.variants.items()
        },
    }


def _key_as_dict(key: Key) -> dict[str, Any]:
    entry = {"unit": key.si_unit, **dataclasses.asdict(key), "choices": list(key.choices)}
    # JSON has no infinite numbers: a bound that is none is left out.
    return {
        name: value
        for name, value in entry.items()
        if not (isinstance(value, float) and math.isinf(value))
    }


def check_document(document: Mapping[str, Any], *, complete: bool = True) -> Iterator[str]:
    """What in a parsed chain file is not as the schema has it: one sentence each.

    Parameters
    ----------
    document : mapping
        Tables ``chain`` and, if there are any, ``materials``.
    complete : bool
        Whether required keys must be there; not in a sweep, whose axes may give them.

    Yields
    ------
    str

    Examples
    --------
    >>> document = {"chain": {"beads": 2.5, "right_wall": {"rigid": "false"}}}
    >>> [*check_document(document)][1]
    "rigid of [chain.right_wall] must be true or false, got 'false'"
    """
    for name in document:
        # `hertzchain.fit` reads [fit].
        if name not in ("chain", "materials", "fit"):
            yield str(unknown_name_error("table or key", name, ("chain", "materials", "fit")))
    table = document.get("chain")
    if not isinstance(table, Mapping):
        yield "a chain file needs a table [chain]"
        return
    values = {name: value for name, value in table.items() if name not in TABLES}
    yield from _check_keys(values, "[chain]", SECTIONS["chain"].keys, KEYS, complete=complete)
    for name in TABLES:
        if name in table:
            yield from _check_tables(table[name], SECTIONS[f"chain.{name}"], complete)
    materials = document.get("materials", {})
    if not isinstance(materials, Mapping):
        yield f"[materials] must be a table of tables, got {short_repr(materials)}"
        return
    for name, entry in materials.items():
        if isinstance(entry, Mapping):
            keys = SECTIONS["materials.NAME"].keys
            yield from _check_keys(entry, f"[materials.{name}]", keys, complete=complete)
        else:
            yield f"[materials.{name}] must be a table, got {short_repr(entry)}"


def _check_tables(entry: Any, section: Section, complete: bool, place: str = "") -> Iterator[str]:
    """A table or, of what may be repeated, a list of tables."""
    several = section.repeated and not place and isinstance(entry, list | tuple)
    place = place or f"[{section.name}]"
    for table in entry if several else [entry]:
        if not isinstance(table, Mapping):
            yield f"{place} must be a table{_example(section)}, got {short_repr(entry)}"
            return
        keys, chosen = section.keys, table.get(section.variant_key)
        if section.variant_key:
            if chosen is None and not complete:
                continue
            if chosen is None:
                yield f"{place} has no {section.variant_key}: choose from {_names(section)}"
                continue
            if not isinstance(chosen, str) or chosen not in section.variants:
                what = f"{section.variant_key} of {place}"
                yield str(unknown_name_error(what, chosen, section.variants))
                continue
            keys = (*section.keys, *section.variants[chosen])
        values, known = dict(table), [key.name for key in keys]
        if section.variant_key:
            del values[section.variant_key]
            known.insert(0, section.variant_key)
        yield from _check_keys(values, place, keys, known, complete=complete)


def _names(section: Section) -> str:
    return ", ".join(section.variants)


def _example(section: Section) -> str:
    """What to write in place of a single value."""
    examples = {
        "chain.left_wall": ', such as {rigid = true}, {material = "brass"} or {}',
        "chain.right_wall": ', such as {rigid = true}, {material = "brass"} or {}',
        "chain.loss": ', such as {law = "restitution", coefficient = 0.95}',
        "chain.drive": ', such as {kind = "step", amplitude = 10.0}',
    }
    return examples.get(section.name, "")


def _check_keys(
    table: Mapping[str, Any],
    place: str,
    keys: Sequence[Key],
    known: Sequence[str] | None = None,
    *,
    complete: bool,
) -> Iterator[str]:
    own = {key.name: key for key in keys}
    for name, value in table.items():
        if name in own:
            yield from problems_of(own[name], value, f"{name} of {place}")
        else:
            yield str(unknown_name_error(f"key of {place}", name, known or tuple(own)))
    if complete:
        for key in keys:
            if key.required and key.name not in table:
                yield f"{place} has no {key.name}: {key.description}"


def problems_of(key: Key, value: Any, what: str) -> Iterator[str]:
    """Why a value is not of the type of a key: a sentence, or nothing if it is."""
    if not key.per:
        yield from _problem_of_one(key, value, what)
    elif isinstance(value, Mapping):
        yield from _problem_of_list_with_unit(key, value, what)
    elif isinstance(value, list | tuple | np.ndarray):
        noun = "names" if key.kind == "material" else "numbers"
        for place, item in enumerate(value, start=1):
            if isinstance(item, list | tuple | Mapping | np.ndarray):
                yield f"{what} must be a list of {noun}, got {short_repr(value)}"
                return
            yield from _problem_of_one(key, item, f"value {place} of {what}")
    elif key.one_for_all:
        yield from _problem_of_one(key, value, what)
    else:
        yield f"{what} must be a list, got {short_repr(value)}"


# Other kinds than numbers and choices: Python's type, and what to say.
_TYPES: Final[Mapping[str, tuple[tuple[type, ...], str]]] = MappingProxyType(
    {
        "boolean": ((bool, np.bool_), "true or false"),
        "text": ((str,), "text"),
        "material": ((str,), "a name"),
        "file": ((str,), "a path"),
    }
)


def _problem_of_one(key: Key, value: Any, what: str) -> Iterator[str]:
    if key.kind == "law":
        yield from _check_tables(value, SECTIONS["chain.loss"], complete=True, place=what)
    elif key.kind in _TYPES:
        types, allowed = _TYPES[key.kind]
        if not isinstance(value, types) or (value == "" and key.kind != "text"):
            yield f"{what} must be {allowed}, got {short_repr(value)}"
    elif key.kind == "choice":
        if not isinstance(value, str) or value not in key.choices:
            yield str(unknown_name_error(what, value, key.choices))
    elif key.kind == "integer":
        if isinstance(value, bool) or not isinstance(value, numbers.Integral):
            yield f"{what} must be a whole number, got {short_repr(value)}"
    elif isinstance(value, str) and key.dimension and quantity(value) is not None:
        return
    elif isinstance(value, bool) or not isinstance(value, numbers.Real):
        units = UNITS[key.dimension] if key.dimension else ()
        with_unit = f", or text with a unit such as '5 {units[:3][-1]}'" if units else ""
        yield f"{what} must be a number{with_unit}, got {short_repr(value)}"


def _problem_of_list_with_unit(key: Key, value: Mapping[str, Any], what: str) -> Iterator[str]:
    """``{list = [4, 5], unit = "mm"}``, as axes of sweeps have it."""
    if not key.dimension:
        noun = "names" if key.kind == "material" else "numbers"
        yield f"{what} must be a list of {noun}, got {short_repr(value)}"
    elif set(value) != {"list", "unit"} or not isinstance(value["list"], list | tuple):
        yield (
            f'{what} must be a list, or a table such as {{list = [4, 5], unit = "mm"}}, got '
            f"{short_repr(value)}"
        )
    elif not isinstance(value["unit"], str):
        yield f"unit of {what} must be text, got {short_repr(value['unit'])}"
    else:
        for item in value["list"]:
            if isinstance(item, bool) or not isinstance(item, numbers.Real):
                yield (
                    f"{what} must be a list of plain numbers next to its unit, "
                    f"got {short_repr(item)}"
                )
                return


def dimensions_of(path: Sequence[str]) -> set[str]:
    """Dimensions that the value at a place of [chain] can have; ``""`` if it may have none."""
    words = [word for word in path if not word.isdigit()]
    section = SECTIONS["chain"]
    if words and words[0] in TABLES:
        section, words = SECTIONS[f"chain.{words[0]}"], words[1:]
    if len(words) > 1 and any(key.name == words[0] and key.kind == "law" for key in section.keys):
        section, words = SECTIONS["chain.loss"], words[1:]
    keys = itertools.chain(section.keys, *section.variants.values())
    found = [key for key in keys if [key.name] == words]
    dimensions = {key.dimension for key in found}
    dimensions |= {key.dimension_if_displacement for key in found if key.dimension_if_displacement}
    return dimensions or {""}


def without_units(value: Any) -> Any:
    """Lists with a unit, also within tables, as lists of text; anything else as it is."""
    if isinstance(value, Mapping) and set(value) == {"list", "unit"}:
        return [f"{item!r} {value['unit']}" for item in value["list"]]
    if isinstance(value, Mapping):
        return {name: without_units(item) for name, item in value.items()}
    return value

"""The schema of chain files: every section and key, with type, unit, default and range.

`SECTIONS` is the only description of the content of a chain file.  Reading, the command line,
sweeps and the documentation use it; an application can generate its controls from
`chain_schema`.  `hertzchain.store.schema_checks` compares a parsed file with it.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any, Final

from ..chain.boundary_checks import HELD_BY
from ..chain.contact_shapes import MIN_ANGLE
from ..chain.drives import DRIVEN, WINDOWS
from ..chain.input_checks import MAX_EXPONENT
from ..chain.laws import LAWS
from ..chain.laws.base import Loss, Parameter
from ..chain.materials import MAX_DENSITY, MIN_DENSITY
from ..chain.random_radii import MAX_SCATTER
from ..chain.taper_sizes import SHAPES
from ..chain.tapers import PARAMETERS, TAPERS, parameter_description
from ..errors import InputError
from ..units import UNITS
from ..validation.keywords import FIELD_ALIASES
from .flat_strikers import with_flat_radius
from .schema_keys import Key, Kind, Section, section_as_dict
from .text_forms import with_tables


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
    _number(
        "exponent", "exponent of its contact; the chain's if omitted", least=1.0, most=MAX_EXPONENT
    ),
    Key("loss", "law", "law of loss of its contact; the chain's if omitted"),
)
_WALLS_AS_TEXT: Final = ("same", "rigid", "brass", "5 kN/mm", "2e10 N/m^1.5")

# Further keys of a taper that is given by sizes.
_SIZES: Final = ("ratio", "length", "taper", "beads")
# Forms in which the beads are given: the key that selects the form, and further keys of the form.
FORMS: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        "first": ("last", *_SIZES, *PARAMETERS),
        "first_diameter": ("last_diameter", *_SIZES, *PARAMETERS),
        "taper": (*PARAMETERS, "beads", "radius"),
        "radii": ("beads",),
        "diameters": ("beads",),
        "cell": ("cells",),
        "cell_diameters": ("cells",),
        "mass_ratio": ("beads",),
        "file": (),
    }
)

MASS_RATIO_IN_SI: Final = (
    "[chain] has mass_ratio, which describes a scaled chain, and also materials or units = 'SI'; "
    "omit these, or give cell_diameters, such as [0.01, 0.008], and cells instead of mass_ratio"
)
_CHAIN: Final = (
    Key("taper", "choice", "name of a taper, or uniform; exponential or linear with sizes",
        choices=(*TAPERS, "uniform", *SHAPES),
        other="; alternating beads have no taper but mass_ratio (or cell) and beads (cells)"),
    *(_number(name, parameter_description(name), fraction=True) for name in PARAMETERS),
    Key("beads", "integer", "number of beads", least=1),
    _number("radius", "radius of the first bead of a taper", "length", above=0.0),
    _number("first", "radius of the first bead of a taper of given sizes", "length", above=0.0),
    _number("last", "radius of its last bead", "length", above=0.0),
    _number("first_diameter", "diameter of the first bead, instead of its radius", "length",
            above=0.0),
    _number("last_diameter", "diameter of the last bead", "length", above=0.0),
    _number("ratio", "radius of the last bead over that of the first", fraction=True,
            above=0.0),
    _number("length", "sum of the diameters", "length", above=0.0),
    _number("radii", "radius of each bead; scaled, in any one unit", "length", above=0.0,
            per="bead", one_for_all=True),
    _number("diameters", "diameter of each bead, instead of its radius", "length", above=0.0,
            per="bead", one_for_all=True),
    _number("cell", "radii of the beads of one cell", "length", above=0.0, per="bead",
            one_for_all=True),
    _number("cell_diameters", "diameters of the beads of one cell, instead of their radii",
            "length", above=0.0, per="bead", one_for_all=True),
    Key("cells", "integer", "number of repetitions of the cell", least=1),
    _number("mass_ratio", "mass of the light beads of a dimer over that of the heavy ones",
            fraction=True, above=0.0),
    Key("file", "file", "CSV file with one row per bead"),
    _number("exponent", "exponent of the contact force", default=1.5, least=1.0, most=MAX_EXPONENT,
            per="contact", one_for_all=True),
    Key("units", "choice", "units of the chain; SI follows from materials",
        choices=("scaled", "SI")),
    Key("materials", "material", "material of all beads, of each (of the cell), or several in "
        "turn; or material",
        per="bead", one_for_all=True),
    _number("velocity", "velocity of bead 1 of a chain of materials", "velocity"),
    Key("strikers", "integer", "number of beads at the front that are strikers; "
        "[[chain.struck_by]] adds others", default=0, least=0),
    _number("masses", "masses, if they do not follow from radii", "mass", above=0.0, per="bead",
            one_for_all=True),
    _number("stiffness", "stiffness of the contacts, if it does not follow", "stiffness",
            above=0.0, per="contact", one_for_all=True),
    _number("velocities", "velocities at time 0", "velocity", per="bead", one_for_all=True),
    _number("gaps", "distances of neighbours at time 0, the first that of balls 1 and 2; strikers "
            "of [[chain.struck_by]] and walls have a gap of their own", "length", least=0.0,
            per="contact", one_for_all=True),
    _number("precompression", "static force on the contacts", "force", default=0.0, least=0.0),
    Key("held_by", "choice", "what holds a precompressed chain", default="walls",
        choices=HELD_BY),
    _number("gravity", "component of gravity along the chain", "acceleration", default=0.0),
)  # fmt: skip

_DECORATED: Final = (
    _number(
        "ratio", "radius over the geometric mean of the large neighbours", fraction=True, above=0.0
    ),
    _number("radius", "radius, instead of the ratio", "length", above=0.0),
    _number("diameter", "diameter, instead of the ratio", "length", above=0.0),
    Key("between", "integer", "number of small beads between two large ones", default=1, least=1),
    _MATERIAL,
)
_DEFECTS: Final = (
    Key("bead", "integer", "number of the bead", required=True, least=1),
    _number("radius", "radius of the bead", "length", required=True, unless="diameter", above=0.0),
    _number("diameter", "diameter of the bead, instead of its radius", "length", above=0.0),
    _MATERIAL,
)
_SCATTER: Final = (
    Key("seed", "integer", "seed of the random numbers", required=True, least=0, unless="radii"),
    _number(
        "relative",
        "standard deviation of the logarithm of the radius",
        fraction=True,
        least=0.0,
        most=MAX_SCATTER,
    ),
    Key("grade", "integer", "ball grade of ISO 3290-1, instead of relative"),
    _number("gaps", "scale of random, half-normal gaps between these beads", "length", above=0.0),
    Key("beads", "text", "beads that deviate, such as 2:; all but strikers and a cap if omitted"),
    _number("radii", "radius of each bead, instead of a seed", "length", above=0.0, per="bead"),
)
_STRUCK_BY: Final = (
    _number("velocity", "velocity of the strikers", "velocity", default=1.0),
    _number("height", "height from which the strikers fall at 9.80665 m/s^2, instead of their "
            "velocity", "length", least=0.0),
    _number("energy", "kinetic energy of each striker, instead of its velocity", "energy",
            least=0.0),
    _number("radius", "radius of a striker; 'flat' or inf, or flat = true, is a flat "
            "face", "length", above=0.0),
    _number("diameter", "diameter of a striker, instead of its radius", "length", above=0.0),
    _number("mass", "mass of a striker", "mass", above=0.0),
    _MATERIAL,
    _number("stiffness", "stiffness of the new contacts", "stiffness", above=0.0),
    Key("count", "integer", "number of strikers", default=1, least=1),
    _number("gap", "distance to the chain", "length", default=0.0, least=0.0),
)  # fmt: skip
_CAP: Final = (
    _number("mass", "mass of the cap", "mass", above=0.0, required=True, unless="frequency"),
    _number("frequency", "resonance frequency of the cap on the linear right wall, instead of the "
            "mass", "frequency", above=0.0),
    _MATERIAL,
    _number("stiffness", "stiffness of its contact with the last ball", "stiffness", above=0.0),
    _number("exponent", "exponent of this contact, such as 1 for a pad with a stiffness", least=1.0,
            most=MAX_EXPONENT),
)  # fmt: skip
_STRIKER_PROPERTIES: Final = (
    _number("mass", "mass, if it is not that of a sphere", "mass", above=0.0),
    Key("flat", "boolean", "whether the face is flat", default=False),
    _number("stiffness", "stiffness of the contact with the next bead, if it is not that of "
            "Hertz's law", "stiffness", above=0.0),
)  # fmt: skip
_BETWEEN: Final = Key(
    "between",
    "material",
    "the two materials whose contacts have this law; the law is for all other pairs without it",
    per="item",
)
_COLLISION: Final = (
    _number("restitution", "coefficient of restitution of a collision, from which the parameter of "
            "the law follows", fraction=True, above=0.0, below=1.0),
    _number("speed", "relative speed before this collision", "velocity", above=0.0),
    Key("contact", "integer", "contact of this collision, 0 and N of walls; that of the law, or "
        "the first one of two balls that has it, if omitted", least=0),
)  # fmt: skip
_EXPONENTS: Final = (
    Key(
        "between",
        "material",
        "the two materials of the contacts; all other pairs without it",
        per="item",
    ),
    _number("value", "exponent of these contacts", required=True, above=1.0, most=MAX_EXPONENT),
)
_CONTACTS: Final = Key(
    "contacts", "integer", "numbers of the contacts, 0 and N of walls; all of two beads if omitted",
    least=0, per="item", one_for_all=True,
)  # fmt: skip
_SHAPES: Final[Mapping[str, tuple[Key, ...]]] = MappingProxyType(
    {
        "cone": (
            _number("half_angle", "angle between axis and side, in degrees", required=True,
                    above=0.0, below=90.0),
        ),
        "crossed-cylinders": (
            _number("radius", "radius of one cylinder; that of the bead if omitted", "length",
                    above=0.0),
            _number("other_radius", "radius of the other; that of the other bead if omitted",
                    "length", above=0.0),
            _number("angle", "angle between the axes, in degrees", default=90.0, least=MIN_ANGLE,
                    most=90.0),
        ),
        "pad": (
            _number("stiffness", "stiffness of the pad, a linear spring", "stiffness",
                    required=True, above=0.0),
        ),
    }
)  # fmt: skip


def _law_key(name: str, about: Parameter, default: Any) -> Key:
    """A key for a parameter of a law."""
    kind: Kind = "boolean" if about.boolean else "number"
    required = default is dataclasses.MISSING
    bounds: dict[str, Any] = dict(about.bounds)
    return Key(
        name, kind, about.description, required=required, default=None if required else default,
        unless="restitution" if required else "", dimension=about.dimension,
        fraction=about.fraction, **bounds,
    )  # fmt: skip


@functools.cache
def _law_keys(law: type[Loss]) -> tuple[Key, ...]:
    """Keys for all parameters of a law."""
    return tuple(
        _law_key(item.name, law.parameters()[item.name], item.default)
        for item in dataclasses.fields(law)
        if item.name in law.parameters()
    )


class _KeysOfLaws(Mapping[str, tuple[Key, ...]]):
    """Keys of all laws by name, including laws that are defined later, in a script."""

    def __getitem__(self, name: str) -> tuple[Key, ...]:
        return _law_keys(LAWS[name])  # type: ignore[arg-type]

    def __iter__(self) -> Iterator[str]:
        return iter(LAWS)

    def __len__(self) -> int:
        return len(LAWS)


_LAWS: Final = _KeysOfLaws()
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
            Key("file", "file", "CSV file with columns time and force, displacement or velocity, "
                "or a signal in V"),
            Key("column", "signal", "column of the signal of a file, if there are several"),
            Key("gain", "signal", "gain of a signal in V, such as `50 N/V`, `20 mV/N` or "
                "`0.1 mm/V`"),
            Key("offset", "signal", "signal without force or displacement, such as `12 mV`"),
            Key("baseline", "signal", "time until which the mean signal is the offset, such as "
                "`20 us`"),
            Key("start", "signal", "time in the file at which the simulation begins, such as "
                "`-40 us`; by default 0"),
            Key("end", "signal", "time in the file at which a force ends, such as `150 us`; by "
                "default, the drive keeps its last value"),
        ),
    }
)  # fmt: skip
# Keys of a drive that describe the signal of its file.
SIGNAL_KEYS: Final = tuple(key.name for key in _DRIVES["table"] if key.kind == "signal")
_MATERIALS: Final = (
    _number("density", "density", "density", required=True, least=MIN_DENSITY, most=MAX_DENSITY),
    _number("young", "Young's modulus; inf is rigid", "pressure", required=True, above=0.0),
    _number("poisson", "Poisson's ratio", required=True, above=-1.0, below=0.5),
    _number(
        "yield_strength", "stress in tension at which the material yields", "pressure", above=0.0
    ),
    Key("source", "text", "source of the numbers", default=""),
)
MATERIAL_CONSTANTS: Final = tuple(key.name for key in _MATERIALS if key.kind == "number")

_LISTED: Final = (
    Section("chain", "beads, contacts and initial state", _CHAIN),
    Section("chain.decorated", "small beads between large ones", _DECORATED, repeated=True),
    Section("chain.with_defects", "a bead of another size or material", _DEFECTS, repeated=True),
    Section("chain.with_scatter", "random deviations of the radii and gaps", _SCATTER,
            repeated=True),
    Section("chain.struck_by", "strikers in front of the chain", _STRUCK_BY, repeated=True),
    Section("chain.cap", "a flat body behind the last ball: with a right wall, the cap of a load "
            "cell; without one, a free body such as a box", _CAP,
            texts=("5 g", "8 kHz", "5 g, steel-304", "5 g, 1 kN/mm")),
    Section("chain.striker_properties", "properties of one of the first beads counted by strikers",
            _STRIKER_PROPERTIES, repeated=True),
    Section("chain.exponent", "the exponent of one pair of materials", _EXPONENTS, repeated=True),
    Section("chain.with_contacts", "contacts of bodies other than spheres", (_CONTACTS,),
            repeated=True, variant_key="shape", variants=_SHAPES),
    Section("chain.left_wall", "the wall behind bead 1", _WALL, texts=_WALLS_AS_TEXT),
    Section("chain.right_wall", "the wall behind the last bead", _WALL,
            texts=_WALLS_AS_TEXT),
    Section("chain.loss", "the law of loss; or one for each contact or pair of materials",
            (_BETWEEN, *_COLLISION), repeated=True, variant_key="law", variants=_LAWS,
            texts=("restitution=0.95", "viscoelastic=0.6 us", "elastic-plastic")),
    Section("chain.drive", "force on bead 1 or motion of the left wall", (), variant_key="kind",
            variants=_DRIVES),
    Section("materials.NAME", "a custom material", _MATERIALS),
)  # fmt: skip
SECTIONS: Final[Mapping[str, Section]] = MappingProxyType({each.name: each for each in _LISTED})
# Tables within [chain].
TABLES: Final = tuple(name.removeprefix("chain.") for name in SECTIONS if name.startswith("chain."))
# Names of all keys and tables of [chain]; the exponent can be either.
KEYS: Final = tuple(dict.fromkeys([*(key.name for key in _CHAIN), *TABLES]))


def chain_schema() -> dict[str, Any]:
    """Convert the schema to plain types, which JSON supports.

    Returns
    -------
    dict
        ``sections``, ``forms`` and ``units``; infinite bounds are omitted.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.store.chain_schema import chain_schema
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


def with_usual_names(document: Mapping[str, Any]) -> Mapping[str, Any]:
    """The document with the usual names of the fields of [chain], and tables instead of texts."""
    table = document.get("chain")
    if not isinstance(table, Mapping):
        return document
    if table.get("taper") == "uniform" and "diameter" in table:
        raise InputError("[chain] has taper = 'uniform' and also diameter: omit taper")
    # The diameter of a taper with a rate is that of its first bead, as on the command line.
    of_taper = {"diameter": "first_diameter"} if "taper" in table else {}
    aliases: Mapping[str, str] = {**FIELD_ALIASES, **of_taper}
    for other, name in aliases.items():
        if {other, name} <= table.keys():
            raise InputError(f"[chain] has {name} and {other}, which are the same: omit one")
    names = (aliases.get(name, name) for name in table)
    chain = with_tables(dict(zip(names, table.values(), strict=True)))
    if "struck_by" in chain:
        chain["struck_by"] = with_flat_radius(chain["struck_by"])
    return {**document, "chain": chain}


def without_units(value: Any) -> Any:
    """Convert lists with a unit, also within tables, to lists of text."""
    if isinstance(value, Mapping) and set(value) == {"list", "unit"}:
        return [f"{item!r} {value['unit']}" for item in value["list"]]
    if isinstance(value, Mapping):
        return {name: without_units(item) for name, item in value.items()}
    return value

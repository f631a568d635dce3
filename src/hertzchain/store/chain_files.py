"""Chain files: TOML files with the arguments of `Chain` and its methods, and CSV tables of beads.

A TOML file has a table ``[chain]`` with the beads in one of these forms::

    taper = "backward-exponential"   # or "uniform", without a rate
    rate = 0.05
    beads = 100

    first = 10.0                     # a taper between two radii; or diameters, as last_diameter;
    last = 2.5                       # or ratio, length or, with materials, a rate instead of last
    beads = 40

    radii = [5.0, 4.5, 4.0]          # or diameters; or one value and beads

    cell = [1.0, 0.5]                # radii, here repeated 20 times; or cell_diameters
    cells = 20

    mass_ratio = 0.3428              # a dimer with equal contacts, and beads

    file = "beads.csv"               # one row per bead

With ``materials`` (one, one per bead, or several in turn; also called ``material``) the chain is in
SI units; a taper then requires the ``radius`` of its first bead, and ``velocity`` is that of the
impact.  All other keys are fields of `hertzchain.Chain`.  The tables ``[chain.decorated]``,
``[[chain.with_defects]]``, ``[chain.with_scatter]``, ``[chain.cap]``, ``[[chain.struck_by]]`` and
``[[chain.with_contacts]]`` are its methods, applied in this order; lists of masses, stiffness,
velocities and gaps include the cap, which is the last bead.  ``[chain.left_wall]``,
``[chain.right_wall]``, ``[chain.loss]`` and ``[chain.drive]`` are its parts.  Walls and the cap can
be text, as on the command line.  Custom materials are tables ``[materials.NAME]``.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator, Mapping, Sequence
from numbers import Integral
from pathlib import Path
from typing import Any, Final

import numpy as np

from ..chain.builder_arguments import materials_in_turn, repeated_sizes
from ..chain.chain import Chain
from ..chain.contact_shapes import Cone, CrossedCylinders, Pad, Shape
from ..chain.input_checks import checked_sizes
from ..chain.materials import RIGID, Material, material
from ..chain.striker_properties import StrikerProperties
from ..chain.taper_sizes import Sizes, si_radii
from ..chain.tapers import PARAMETERS, taper_named
from ..chain.walls import Wall
from ..errors import InputError, errors_at, raise_all
from ..validation.keywords import checked_arguments
from ..validation.numbers import number, whole_number
from ..validation.objects import check_type, file_path, shown_path
from .bead_tables import load_beads
from .chain_schema import FORMS, MASS_RATIO_IN_SI, with_usual_names, without_units
from .contact_values import exponent_from, law_from, losses_from
from .drive_tables import drive_from
from .schema_checks import check_document, has_tables
from .toml_files import parse_toml, read_toml

ARRAYS: Final = ("masses", "stiffness", "velocities", "gaps")
# Keys of a taper of given sizes, which are arguments of `Chain.tapered`.
SIZE_KEYS: Final = tuple(item.name for item in dataclasses.fields(Sizes))
# Keys of a cell, and the arguments of `Chain.periodic`.
CELLS: Final = {"cell": "cell", "cell_diameters": "diameters"}
LATER: Final = ("precompression", "held_by", "gravity")
# Methods of a chain that change its beads, in the order in which they are applied.
MORE_BEADS: Final = ("decorated", "with_defects", "with_scatter")
BEAD_METHODS: Final = (*MORE_BEADS, "cap", "struck_by")
PARTS: Final = ("left_wall", "right_wall", "loss", "drive")
SHAPES: Final[Mapping[str, type[Shape]]] = {
    "cone": Cone, "crossed-cylinders": CrossedCylinders, "pad": Pad,
}  # fmt: skip


@checked_arguments("load_chain")
def load_chain(path: str | os.PathLike[str]) -> Chain:
    r"""Read a chain from a TOML or CSV file.

    Parameters
    ----------
    path : path-like
        TOML: see `hertzchain.store.chain_files`.  CSV (ending ``.csv``): one row per bead, with
        columns ``radius [mm]`` or ``diameter [mm]``, ``material``, ``mass [g]`` (where it is
        empty, that of a sphere), ``velocity [m/s]`` and, for the contact with the next bead,
        ``gap [um]`` and ``stiffness [N/m^1.5]``; in any order and unit, or all without units for a
        scaled chain.

    Raises
    ------
    InputError
        If the file is missing or unreadable, a key or column is unknown, missing or
        contradicts another, or a value is out of range.  The message names the file.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from pathlib import Path
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "chain.toml"
    ...     _ = file.write_text('[chain]\ntaper = "uniform"\nbeads = 20\n')
    ...     hc.load_chain(file)
    Chain(uniform, 20 beads)
    """
    file = file_path("chain file", path)
    if file.suffix.lower() == ".csv":
        return load_beads(path)
    document = read_toml("chain file", path, "give the path of a TOML or CSV file")
    with errors_at(shown_path(path)):
        return chain_from(document, file.parent)


@checked_arguments("chain_from_toml")
def chain_from_toml(text: str, folder: str | os.PathLike[str] = ".") -> Chain:
    r"""Read a chain from the text of a TOML chain file; the inverse of `chain_as_toml`.

    Parameters
    ----------
    text : str
        The text; see `hertzchain.store.chain_files`.
    folder : path-like
        Folder of the files to which the text refers, by default the working directory.

    Raises
    ------
    InputError
        If the text is not valid TOML, a key is unknown, missing or contradicts another, or a value
        is out of range.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.chain_from_toml('[chain]\ntaper = "uniform"\nbeads = 20')
    >>> chain
    Chain(uniform, 20 beads)
    >>> hc.chain_from_toml(hc.chain_as_toml(chain)).radii.tolist() == chain.radii.tolist()
    True
    """
    check_type("text", text, str, "load_chain reads a file")
    document = parse_toml("text of a chain file", text, "; hc.load_chain reads a file by its path")
    with errors_at("text of a chain file"):
        return chain_from(document, file_path("folder", folder))


def chain_from(document: Mapping[str, Any], folder: Path = Path()) -> Chain:
    """Build the chain that a parsed chain file describes."""
    document = with_usual_names(document)
    raise_all([*check_document(document)])
    return _ChainFile(document, folder).chain()


class _ChainFile:
    """A parsed TOML file of the right types, and the folder of the files it names."""

    def __init__(self, document: Mapping[str, Any], folder: Path) -> None:
        self.table: dict[str, Any] = without_units(document["chain"])
        self.folder = folder
        self.materials = {
            str(name): Material(name, **entry)
            for name, entry in document.get("materials", {}).items()
        }

    def chain(self) -> Chain:
        # Lists of one value per bead are set with the beads, unless a method changes these first.
        listed = (*ARRAYS, "exponent") if self._is_list("exponent") else ARRAYS
        own: dict[str, Any] = {name: self.table[name] for name in listed if name in self.table}
        changed = any(name in self.table for name in MORE_BEADS)
        capped = "cap" in self.table
        self._check_changed_radii()
        chain = self._beads({} if changed else _without_last(own) if capped else own)
        for name in MORE_BEADS:
            before = chain.gaps
            for arguments in self._arguments(name):
                chain = getattr(chain, name)(**arguments)
        # The last of these methods adds random gaps.
        random = chain.gaps - before if "with_scatter" in self.table else np.zeros(0)
        if capped:
            chain = self._with_cap(chain)
        mass = float(chain.masses[-1])
        own = own if changed or capped or self._form == "file" else {}
        if "strikers" in self.table and chain.strikers != self.table["strikers"]:
            own["strikers"] = self.table["strikers"]
        if "striker_properties" in self.table:
            own["striker_properties"] = self._striker_properties()
        chain = chain.replace(**own) if own else chain
        if "gaps" in own and random.any():
            random = np.pad(random, (0, len(chain.gaps) - len(random)))  # none at a cap
            chain = chain.replace(gaps=chain.gaps + random)
        if capped and chain.masses[-1] != mass:
            raise InputError(
                f"[chain] has masses, which include the cap, and the last one, "
                f"{chain.masses[-1]:g}, is not the mass of [chain.cap], {mass:g}: omit masses or "
                "give the same"
            )
        for arguments in self._arguments("struck_by"):
            chain = chain.struck_by(**arguments)
        rest: dict[str, Any] = {name: self.table[name] for name in LATER if name in self.table}
        rest |= {name: self._part(name) for name in PARTS if name in self.table and name != "loss"}
        chain = chain.replace(**rest) if rest else chain
        for arguments in self._arguments("with_contacts"):
            numbers = arguments.pop("contacts", range(1, chain.beads))
            shape = SHAPES[arguments.pop("shape")](**arguments)
            one = isinstance(numbers, Integral)
            chain = chain.with_contacts(dict.fromkeys([numbers] if one else numbers, shape))
        losses = self._losses(chain)
        return chain.replace(**losses) if losses else chain

    def _with_cap(self, chain: Chain) -> Chain:
        """The chain with its cap, whose frequency is that on the right wall."""
        (given,) = self._arguments("cap")
        if "stiffness" in self.table:
            if "stiffness" in given:
                raise InputError("[chain] has stiffness, and cap also has stiffness: omit one")
            given["stiffness"] = np.atleast_1d(self.table["stiffness"])[-1].item()
        if self._is_list("exponent"):
            if "exponent" in given:
                raise InputError(
                    "[chain] lists the exponents, which include that of the cap, and cap also has "
                    "exponent: omit one"
                )
            given["exponent"] = np.atleast_1d(self.table["exponent"])[-1].item()
        if "frequency" in given and "right_wall" in self.table:
            chain = chain.replace(right_wall=self._part("right_wall"))
        return chain.with_cap(**given)

    def _striker_properties(self) -> list[StrikerProperties]:
        given = [*self._arguments("striker_properties")]
        for name, item in (("masses", "mass"), ("stiffness", "stiffness")):
            if name in self.table and any(item in each for each in given):
                raise InputError(
                    f"[chain] has {name}, and striker_properties also has {item}: omit one"
                )
        return [StrikerProperties(**each) for each in given]

    def _is_list(self, name: str) -> bool:
        """Whether a key has one value per contact."""
        value = self.table.get(name)
        return isinstance(value, list | tuple | np.ndarray) and not has_tables(value)

    def _beads(self, own: dict[str, Any]) -> Chain:
        table = self.table
        present = [form for form in FORMS if form in table]
        if not present:
            missing = [key for key in ("taper", "beads") if key not in table]
            others = ", ".join(form for form in FORMS if form != "taper")
            raise InputError(
                f"[chain] has no {' and no '.join(missing)}; give taper, rate and beads (equal "
                f"beads are taper = 'uniform', without a rate), or one of {others}"
            )
        form = self._form = present[0]
        keys = {key for more in FORMS.values() for key in more} | set(FORMS)
        self._require_without(form, sorted(keys - {form, *FORMS[form]}))
        one = "exponent" in table and not self._is_list("exponent")
        law = {"exponent": exponent_from(self.table["exponent"], self._material)} if one else {}
        if table.get("units") == "scaled" and "materials" in table:
            raise InputError(
                "[chain] has units = 'scaled' and also materials, which make a chain in SI units: "
                "omit one"
            )
        if form == "file":
            return self._beads_of_file(law)
        if "materials" in table or table.get("units") == "SI":
            return self._si_beads(form, law, own)
        if "radius" in table or "velocity" in table:
            key = "radius" if "radius" in table else "velocity"
            raise InputError(
                f"[chain] has {key} but no materials: scaled chains begin with radius 1 and "
                f"velocity 1; omit {key}, or give materials"
            )
        return self._scaled_beads(form, law, own)

    def _beads_of_file(self, law: dict[str, Any]) -> Chain:
        self._require_without("file", ["materials"], "name them in the file")
        self._require_without("file", ["velocity"], "give velocities, or a column velocity")
        chain = load_beads(self.folder / self.table["file"], self.materials)
        units = self.table.get("units", chain.units)
        if units != chain.units:
            raise InputError(
                f"[chain] has units = {units!r}, but the table of beads is "
                f"{'in SI units' if chain.units == 'SI' else 'without units'}"
            )
        return chain.replace(**law) if law else chain

    def _scaled_beads(self, form: str, law: dict[str, Any], own: dict[str, Any]) -> Chain:
        table = self.table
        if form in ("radii", "diameters"):
            if "beads" in table and not self._is_list(form):
                raise InputError(
                    f"materials is missing in [chain], which has {form} and beads: give materials, "
                    "such as 'steel-52100'; equal beads in scaled variables are taper = 'uniform'"
                )
            self._require_without(form, ["beads"], f"omit beads if {form} is a list")
            if form == "radii" and table.get("strikers"):
                return Chain(table["radii"], strikers=table["strikers"], **law, **own)
            sizes = table[form]
            radii = sizes if form == "radii" else 0.5 * checked_sizes("diameter", sizes, None)
            chain = Chain.from_radii(radii, **law)
        elif form in CELLS:
            chain = Chain.periodic(**self._cell(), **law)
        elif form == "mass_ratio":
            chain = Chain.dimer(table["mass_ratio"], beads=self._needed("beads"), **law)
        else:
            chain = self._tapered(law)
        return chain.replace(**own) if own else chain

    def _tapered(self, law: dict[str, Any]) -> Chain:
        table = self.table
        beads = self._needed("beads")
        if self._form != "taper":
            given = {name: table[name] for name in (*SIZE_KEYS, *PARAMETERS) if name in table}
            return Chain.tapered(table.get("taper"), beads=beads, **given, **law)
        if table["taper"] == "uniform":
            self._require_without('taper = "uniform"', list(PARAMETERS))
            return Chain.uniform(beads, **law)
        for name, symbol in (symbols := taper_named(table["taper"]).symbols).items():
            if name not in table:
                raise InputError(
                    f"[chain] has taper = {table['taper']!r} but no {name}, its parameter {symbol}"
                )
        others = [name for name in PARAMETERS if name not in symbols]
        self._require_without(f"taper = {table['taper']!r}", others)
        parameters = {name: table[name] for name in symbols}
        return Chain.tapered(table["taper"], beads=beads, **parameters, **law)

    def _si_beads(self, form: str, law: dict[str, Any], own: dict[str, Any]) -> Chain:
        table = self.table
        if form == "mass_ratio":
            raise InputError(MASS_RATIO_IN_SI)
        if "velocity" in table:
            self._require_without("velocity", ["velocities"])
        radii: Any = None
        if form == "taper":
            first = number("radius", self._needed("radius"), unit="m", above=0.0)
            radii = first * self._tapered({}).radii
        elif form in SIZE_KEYS:
            names = (SIZE_KEYS, PARAMETERS)
            given, rates = ({key: table[key] for key in each if key in table} for each in names)
            radii = si_radii(table.get("taper"), self._needed("beads"), Sizes(**given), rates)
        elif form == "diameters":
            radii = 0.5 * checked_sizes("diameter", table[form])
        elif form in CELLS:
            radii = repeated_sizes(**self._cell())
        else:
            radii = table[form]
        if "materials" not in table:
            self._require_without('units = "SI" without materials', ["beads", "velocity"])
            return Chain(radii, units="SI", **law, **own)
        kinds = materials_in_turn(self._material(table["materials"]), table.get("beads"))
        fields = law | own | {"velocity": table.get("velocity")}
        if form in CELLS:
            return Chain.periodic(**self._cell(), materials=kinds, **fields)
        if form in ("radii", "diameters"):
            fields |= {form: table[form], "beads": table.get("beads")}
        else:
            fields["radii"] = radii
        return Chain.from_materials(materials=kinds, **fields)

    def _cell(self) -> dict[str, Any]:
        """Arguments of a cell and the number of its repetitions."""
        sizes = {argument: self.table.get(key) for key, argument in CELLS.items()}
        return sizes | {"cells": whole_number("cells", self._needed("cells"), least=1)}

    def _arguments(self, name: str) -> Iterator[dict[str, Any]]:
        given = self.table.get(name, [])
        for entry in given if isinstance(given, list | tuple) else [given]:
            arguments = dict(entry)
            if "material" in arguments:
                arguments["material"] = self._material(arguments["material"])
            if name == "with_defects":
                if {"radius", "diameter"} <= arguments.keys():
                    raise InputError(
                        f"[[chain.with_defects]] of bead {arguments['bead']} has a radius and a "
                        "diameter: omit one"
                    )
                size = "radius" if "radius" in arguments else "diameter"
                sizes = {"radius": "radii", "diameter": "diameters"}[size]
                arguments[sizes] = {arguments.pop("bead"): arguments.pop(size)}
            if name == "with_scatter" and not {"relative", "grade", "gaps"} & arguments.keys():
                raise InputError(
                    "[chain.with_scatter] has neither relative, such as 0.01, nor grade, such as "
                    "100, nor gaps, such as '5 um': give one of them"
                )
            yield arguments

    def _check_changed_radii(self) -> None:
        """Reject masses and stiffness that would not follow changed radii, as the methods do."""
        given = " and ".join(name for name in ("masses", "stiffness") if name in self.table)
        scatter = self.table.get("with_scatter")
        keys = scatter.keys() if isinstance(scatter, dict) else {"relative"}
        # Random gaps change no radii, and files that hertzchain writes list the radii.
        kept = "radii" in keys or not {"relative", "grade"} & keys
        for name in ("with_defects", "with_scatter"):
            if given and name in self.table and not (name == "with_scatter" and kept):
                raise InputError(
                    f"[chain] has {given}, which would not follow the radii that {name} changes: "
                    f"omit {name} and give the radii and {given} of all beads, or omit {given}"
                )

    def _losses(self, chain: Chain) -> dict[str, Any]:
        """Laws of all contacts and walls, which may follow from the restitution of a contact."""
        found: dict[str, Any] = {}
        for name, contact in (("left_wall", 0), ("right_wall", chain.beads)):
            if (entry := self.table.get(name, {}).get("loss")) is None:
                continue
            if "between" in entry:
                raise InputError(
                    f"loss of [chain.{name}] has between, but is the law of one contact: omit "
                    "between, or use [[chain.loss]]"
                )
            law = law_from(entry, chain, contact, f"loss of [chain.{name}]")
            found[name] = dataclasses.replace(getattr(chain, name), loss=law)
        if "loss" in self.table:
            found["loss"] = losses_from(self.table["loss"], self._material, chain)
        return found

    def _part(self, name: str) -> Any:
        entry = {key: value for key, value in self.table[name].items() if key != "loss"}
        if name.endswith("wall"):
            given = entry.pop("material", None)
            own = None if given in (None, "same") else self._material(given)
            if entry.pop("rigid", False):
                if given is not None:
                    raise InputError(f"[chain.{name}] is rigid and has a material: omit one")
                own = RIGID
            return Wall(**entry, material=own)
        return drive_from(entry, self.folder)

    def _material(self, given: Any) -> Any:
        if isinstance(given, str):
            return self.materials.get(given) or material(given)
        return [self._material(each) for each in given]

    def _needed(self, key: str) -> Any:
        if key not in self.table:
            raise InputError(f"[chain] has no {key}, which goes with {self._form}")
        return self.table[key]

    def _require_without(self, what: str, others: Sequence[str], advice: str = "omit one") -> None:
        present = [key for key in others if key in self.table]
        if present:
            raise InputError(f"[chain] has {what} and also {', '.join(present)}: {advice}")


def _without_last(own: Mapping[str, Any]) -> dict[str, Any]:
    """Lists of values per bead or contact without that of a cap, and no gaps, which follow it."""
    lists = (list, tuple, np.ndarray)
    return {k: v[:-1] if isinstance(v, lists) else v for k, v in own.items() if k != "gaps"}

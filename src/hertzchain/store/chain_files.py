"""Chain files: TOML that says what `Chain` and its methods say, and CSV with a row a bead.

A TOML file has a table ``[chain]`` with the beads in one of these forms::

    taper = "backward-exponential"   # or "uniform", which has no rate
    rate = 0.05
    beads = 100

    radii = [5.0, 4.5, 4.0]          # or one radius and beads

    cell = [1.0, 0.5]                # repeated so often:
    cells = 20

    mass_ratio = 0.3428              # a dimer with equal contacts, and beads

    file = "beads.csv"               # a row a bead

With ``materials`` (one, or one a bead) the chain is in SI units; a taper then needs the
``radius`` of its first bead, and ``velocity`` is that of the strike.  All other keys are
fields of `hertzchain.Chain`; tables ``[chain.decorated]``, ``[[chain.with_defects]]``,
``[chain.with_scatter]`` and ``[[chain.struck_by]]`` are its methods, applied in this order;
``[chain.left_wall]``, ``[chain.right_wall]``, ``[chain.loss]`` and ``[chain.drive]`` are its
parts.  Materials of your own are tables ``[materials.NAME]``.
"""

from __future__ import annotations

import dataclasses
import inspect
import json
import os
import tomllib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from hertzchain.arguments import file_path, one_of
from hertzchain.chain.chain import TAPERS, Chain
from hertzchain.chain.coverage import check_chain
from hertzchain.chain.drives import Drive, SineBurst, Step, Table
from hertzchain.chain.losses import (
    Dashpot,
    Loss,
    Restitution,
    UnloadingRatio,
    VelocityPower,
    Viscoelastic,
    WaltonBraun,
)
from hertzchain.chain.materials import RIGID, Material, material
from hertzchain.chain.walls import Wall
from hertzchain.errors import InputError, unknown_name
from hertzchain.store.bead_tables import load_beads, load_drive

# Forms of [chain]: the key that tells the form, and the keys that go with it.
FORMS: Final[Mapping[str, tuple[str, ...]]] = {
    "taper": ("rate", "beads", "radius"),
    "radii": ("beads",),
    "cell": ("cells",),
    "mass_ratio": ("beads",),
    "file": (),
}
ARRAYS: Final = ("masses", "stiffness", "velocities", "gaps")
LATER: Final = ("precompression", "held_by", "gravity")
METHODS: Final = ("decorated", "with_defects", "with_scatter", "struck_by")
PARTS: Final = ("left_wall", "right_wall", "loss", "drive")
LAWS: Final[Mapping[str, type[Loss]]] = {
    "restitution": Restitution,
    "viscoelastic": Viscoelastic,
    "unloading-ratio": UnloadingRatio,
    "velocity-power": VelocityPower,
    "dashpot": Dashpot,
    "walton-braun": WaltonBraun,
}
DRIVES: Final[Mapping[str, type[Drive]]] = {"sine-burst": SineBurst, "step": Step, "table": Table}
KEYS: Final = (
    *dict.fromkeys(key for form, more in FORMS.items() for key in (form, *more)),
    "exponent", "units", "materials", "velocity", "strikers", *ARRAYS, *LATER, *METHODS, *PARTS,
)  # fmt: skip


def load_chain(path: str | os.PathLike[str]) -> Chain:
    r"""Read a chain from a TOML or CSV file.

    Parameters
    ----------
    path : path-like
        The file.  TOML: see the top of `hertzchain.store.chain_files`.  CSV (ending ``.csv``): a
        row a bead, with columns ``radius [mm]`` or ``diameter [mm]``, ``material``,
        ``mass [g]``, ``velocity [m/s]`` and, between a bead and the next,
        ``gap [um]`` and ``stiffness [N/m^1.5]``; in any order and unit, or all without
        units for a scaled chain.

    Returns
    -------
    Chain

    Raises
    ------
    InputError
        If the file is missing or unreadable, a key or column is unknown, missing or
        contradicts another, or a value is out of range; the file is named.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "chain.toml"
    ...     _ = file.write_text('[chain]\ntaper = "uniform"\nbeads = 20\n')
    ...     load_chain(file)
    Chain(uniform, 20 beads)
    """
    file = file_path("chain file", path)
    name = os.fspath(path)
    if file.suffix.lower() == ".csv":
        return load_beads(path)
    try:
        document = tomllib.loads(file.read_text("utf-8-sig"))
    except OSError as error:
        raise InputError(
            f"cannot read chain file {name!r} ({error.strerror}); give the path of a TOML or "
            "CSV file"
        ) from None
    except UnicodeDecodeError:
        raise InputError(f"chain file {name!r} is not UTF-8 text; chain files are TOML") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"chain file {name!r} is not valid TOML: {error}") from None
    try:
        return chain_from(document, file.parent)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def chain_from(document: Mapping[str, Any], folder: Path = Path()) -> Chain:
    """The chain that a parsed chain file describes.

    Parameters
    ----------
    document : mapping
        Tables ``chain`` and, if there are any, ``materials``.
    folder : pathlib.Path
        Where the files are that it names.

    Returns
    -------
    Chain

    Raises
    ------
    InputError
        As `load_chain`.

    Examples
    --------
    >>> chain_from({"chain": {"taper": "uniform", "beads": 20}})
    Chain(uniform, 20 beads)
    """
    return _ChainFile(document, folder).chain()


def chain_as_toml(chain: Chain) -> str:
    """A chain as a TOML chain file, from which `load_chain` makes the same chain.

    Parameters
    ----------
    chain : Chain
        Any chain.

    Returns
    -------
    str

    Examples
    --------
    >>> print(chain_as_toml(Chain.uniform(2).replace(right_wall=Wall.rigid())))
    [chain]
    radii = [1.0, 1.0]
    right_wall = {rigid = true, gap = 0.0}
    """
    check_chain("chain_as_toml", chain)
    entries: dict[str, Any] = {}
    if chain.taper is not None:
        entries |= {"taper": chain.taper, "rate": chain.rate, "beads": chain.beads}
    else:
        entries["radii"] = chain.radii.tolist()
    plain = {item.name: item.default for item in dataclasses.fields(chain)}
    for name in ("exponent", "units", "strikers", *LATER):
        if (value := getattr(chain, name)) != plain[name]:
            entries[name] = value
    entries |= {name: getattr(chain, name).tolist() for name in ARRAYS if name in chain.given}
    own: dict[str, Material] = {}
    if chain.materials is not None:
        own = {each.name: each for each in chain.materials}
        entries["materials"] = [each.name for each in chain.materials]
    for name in ("left_wall", "right_wall"):
        wall = getattr(chain, name)
        if wall is not None:
            entries[name] = _wall_entry(wall)
            if wall.material not in (None, RIGID):
                own[wall.material.name] = wall.material
    for name, kinds, key in (("loss", LAWS, "law"), ("drive", DRIVES, "kind")):
        part = getattr(chain, name)
        if part is not None:
            kind = next(label for label, cls in kinds.items() if type(part) is cls)
            entries[name] = {key: kind} | {
                item.name: _plain(getattr(part, item.name)) for item in dataclasses.fields(part)
            }
    lines = ["[chain]", *(f"{name} = {_toml(value)}" for name, value in entries.items())]
    for each in own.values():
        lines += ["", f"[materials.{json.dumps(each.name)}]"]
        lines += [
            f"{item.name} = {_toml(value)}"
            for item in dataclasses.fields(each)
            if item.name != "name" and (value := getattr(each, item.name)) is not None
        ]
    return "\n".join(lines)


class _ChainFile:
    """A parsed TOML file, and where the files it names are."""

    def __init__(self, document: Mapping[str, Any], folder: Path) -> None:
        for key in document:
            if key not in ("chain", "materials"):
                raise unknown_name("table or key", key, ("chain", "materials"))
        table = document.get("chain")
        if not isinstance(table, dict):
            raise InputError("a chain file needs a table [chain]")
        for key in table:
            if key not in KEYS:
                raise unknown_name("key of [chain]", key, KEYS)
        self.table, self.folder = table, folder
        self.materials = {
            name: _built(Material, {"name": name} | _a_table(f"materials.{name}", entry))
            for name, entry in _a_table("materials", document.get("materials", {})).items()
        }

    def chain(self) -> Chain:
        chain = self._beads()
        for name in METHODS[:-1]:
            for arguments in self._arguments(name):
                chain = _called(getattr(chain, name), f"chain.{name}", arguments)
        own = {name: self.table[name] for name in (*ARRAYS, "strikers") if name in self.table}
        if own:
            chain = chain.replace(**own)
        for arguments in self._arguments("struck_by"):
            chain = _called(chain.struck_by, "chain.struck_by", arguments)
        rest = {name: self.table[name] for name in LATER if name in self.table}
        rest |= {name: self._part(name) for name in PARTS if name in self.table}
        return chain.replace(**rest) if rest else chain

    def _beads(self) -> Chain:
        table = self.table
        present = [form for form in FORMS if form in table]
        if not present:
            missing = [key for key in ("taper", "beads") if key not in table]
            raise InputError(
                f"[chain] has no {' and no '.join(missing)}; give taper, rate and beads, or one "
                f"of {', '.join(list(FORMS)[1:])}"
            )
        form = self._form = present[0]
        keys = {key for more in FORMS.values() for key in more} | set(FORMS)
        self._refuse_beside(form, sorted(keys - {form, *FORMS[form]}))
        law = {"exponent": table["exponent"]} if "exponent" in table else {}
        if form == "file":
            if "materials" in table:
                raise InputError("[chain] has file and also materials: name them in the file")
            chain = load_beads(self.folder / table["file"], self.materials)
            return chain.replace(**law) if law else chain
        if "materials" in table or table.get("units") == "SI":
            return self._si_beads(form, law)
        if "radius" in table or "velocity" in table:
            key = "radius" if "radius" in table else "velocity"
            raise InputError(
                f"[chain] has {key} but no materials: scaled chains begin with radius 1 and "
                f"velocity 1; leave {key} out, or give materials"
            )
        return self._scaled_beads(form, law)

    def _scaled_beads(self, form: str, law: dict[str, Any]) -> Chain:
        table = self.table
        if form == "radii":
            self._refuse_beside("radii", ["beads"])
            if table.get("strikers"):
                return Chain(np.asarray(table["radii"]), strikers=table["strikers"], **law)
            return Chain.from_radii(table["radii"], **law)
        if form == "cell":
            return Chain.periodic(table["cell"], cells=self._needed("cells"), **law)
        if form == "mass_ratio":
            return Chain.dimer(table["mass_ratio"], beads=self._needed("beads"), **law)
        return self._tapered(law)

    def _tapered(self, law: dict[str, Any]) -> Chain:
        table = self.table
        one_of("taper", table["taper"], (*TAPERS, "uniform"))
        beads = self._needed("beads")
        if table["taper"] == "uniform":
            self._refuse_beside('taper = "uniform"', ["rate"])
            return Chain.uniform(beads, **law)
        if "rate" not in table:
            raise InputError(f"[chain] has taper = {table['taper']!r} but no rate, its S or q")
        return Chain.tapered(table["taper"], table["rate"], beads=beads, **law)

    def _si_beads(self, form: str, law: dict[str, Any]) -> Chain:
        table = self.table
        if form == "mass_ratio":
            raise InputError("[chain] has mass_ratio, a scaled chain, and also materials or SI")
        if "velocity" in table:
            self._refuse_beside("velocity", ["velocities"])
        if form == "taper":
            radii: Any = self._needed("radius") * self._tapered({}).radii
        elif form == "cell":
            radii = np.tile(table["cell"], self._needed("cells"))
        else:
            radii = table["radii"]
        if "materials" not in table:
            self._refuse_beside('units = "SI" without materials', ["beads", "velocity"])
            bodies = {name: table[name] for name in ARRAYS if name in table}
            return Chain(np.asarray(radii), units="SI", **bodies, **law)
        kinds = self._material(table["materials"])
        if form == "cell" and not isinstance(kinds, Material):
            kinds = list(kinds) * table["cells"]
        count = table.get("beads") if form == "radii" else None
        return Chain.from_materials(
            radii, kinds, beads=count, velocity=table.get("velocity"), **law
        )

    def _arguments(self, name: str) -> list[dict[str, Any]]:
        given = self.table.get(name, [])
        listed = given if isinstance(given, list) else [given]
        found = []
        for entry in listed:
            arguments = dict(_a_table(f"chain.{name}", entry))
            if "material" in arguments:
                arguments["material"] = self._material(arguments["material"])
            if name == "with_defects":
                bead, radius = arguments.pop("bead", None), arguments.pop("radius", None)
                if bead is None or radius is None:
                    raise InputError("[[chain.with_defects]] needs bead and radius")
                arguments["radii"] = {bead: radius}
            if name == "with_scatter":
                arguments["rng"] = arguments.pop("seed", None)
                if arguments["rng"] is None:
                    raise InputError(
                        "[chain.with_scatter] needs a seed, so that it can be repeated"
                    )
            found.append(arguments)
        return found

    def _part(self, name: str) -> Any:
        entry = dict(_a_table(f"chain.{name}", self.table[name]))
        if name.endswith("wall"):
            if entry.pop("rigid", False):
                if "material" in entry:
                    raise InputError(f"[chain.{name}] is rigid and of a material: leave one out")
                entry["material"] = RIGID
            elif "material" in entry:
                entry["material"] = self._material(entry["material"])
            return _called(Wall, f"chain.{name}", entry)
        kinds, key = (LAWS, "law") if name == "loss" else (DRIVES, "kind")
        if key not in entry:
            raise InputError(f"[chain.{name}] has no {key}: choose from {', '.join(kinds)}")
        kind = one_of(f"{key} of [chain.{name}]", entry.pop(key), kinds)
        if kind == "table" and "file" in entry:
            if len(entry) > 1:
                raise InputError("[chain.drive] has file and also other keys: leave them out")
            return load_drive(self.folder / entry["file"])
        return _called(kinds[kind], f"chain.{name}", entry)

    def _material(self, given: Any) -> Any:
        if isinstance(given, list):
            return [self._material(each) for each in given]
        if not isinstance(given, str):
            raise InputError(f"a material must be a name, got {given!r}")
        return self.materials.get(given) or material(given)

    def _needed(self, key: str) -> Any:
        if key not in self.table:
            raise InputError(f"[chain] has no {key}, which goes with {self._form}")
        return self.table[key]

    def _refuse_beside(self, what: str, others: Sequence[str]) -> None:
        present = [key for key in others if key in self.table]
        if present:
            raise InputError(f"[chain] has {what} and also {', '.join(present)}: leave one out")


def _a_table(name: str, entry: Any) -> dict[str, Any]:
    if not isinstance(entry, dict):
        raise InputError(f"[{name}] must be a table, got {entry!r}")
    return entry


def _built(kind: type[Any], entry: dict[str, Any]) -> Any:
    return _called(kind, f"materials.{entry['name']}", entry)


def _called(function: Callable[..., Any], where: str, arguments: dict[str, Any]) -> Any:
    """Call with the keys of a table, after holding them against what there is."""
    parameters = inspect.signature(function).parameters
    for key in arguments:
        if key not in parameters:
            raise unknown_name(f"key of [{where}]", key, parameters)
    for key, parameter in parameters.items():
        if parameter.default is inspect.Parameter.empty and key not in arguments:
            raise InputError(f"[{where}] has no {key}")
    return function(**arguments)


def _wall_entry(wall: Wall) -> dict[str, Any]:
    if wall.stiffness is not None:
        return {"stiffness": wall.stiffness, "gap": wall.gap}
    if wall.material is None:
        return {"gap": wall.gap}
    kind = {"rigid": True} if wall.material == RIGID else {"material": wall.material.name}
    return kind | {"gap": wall.gap}


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else value


def _toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {_toml(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value, ensure_ascii=False)

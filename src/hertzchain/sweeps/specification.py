"""The specification of a sweep: its schema, and how a TOML file or a mapping is read.

::

    [chain]                       # as in a chain file
    taper = "forward-exponential"
    rate = 0.05
    beads = 60

    [axes]                        # parameters that vary, in every combination
    rate = {linspace = [0.01, 0.1, 19]}
    beads = [20, 40, 60]

    [sweep]
    methods = ["propagate", "local-rate"]
    keep = ["momentum"]           # quantities of the pulse, right wall, sensors or run
    at = "last"                   # or "every" bead, or a list of beads
    errors = ["velocity"]         # of the other methods relative to the first

    [method]
    rtol = 1e-8
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from ..chain.chain import Chain
from ..errors import InputError, raise_all, short_repr, unknown_name_error
from ..pulse.quantities import QUANTITIES
from ..representation import short
from ..store.chain_files import chain_from
from ..store.chain_schema import KEYS, chain_schema, with_usual_names, without_units
from ..store.schema_checks import check_document
from ..store.schema_keys import Key, Section, section_as_dict
from ..store.sweep_export import FLAGS
from ..store.toml_files import read_toml
from ..validation.json_types import to_json_types
from ..validation.numbers import whole_number
from ..validation.objects import shown_path
from .axes import (
    Axis,
    conflicts,
    duplicates,
    fixed_by_others,
    flattened,
    second_strikers,
    too_many_points,
    unequal_lengths,
)
from .kept import OF_RUNS, SWEEP_QUANTITIES, unknown_quantity, variable_name
from .listed_points import columns_of_points
from .listed_values import chain_as_document, missing_parts, with_lists
from .methods import METHODS, OPTIONS_OF, check_option
from .placed import placed
from .stiffness_axes import stiffness_exponent

# Names that the dataset uses itself; an axis of such a name gets its full path as name.
TAKEN: Final = ("approach", "bead", "contact", "point", "status", "reason", *FLAGS)


@dataclass(frozen=True, eq=False)
class Specification:
    """A checked specification of a sweep.

    Attributes
    ----------
    title : str
        Title of figures and of the dataset; may be empty.
    chain : mapping
        Table ``[chain]`` of a chain file, to which the axes are applied.
    materials : mapping
        Custom materials by name, as in a chain file.
    axes : tuple of Axis
        Parameters that vary.
    combine : str
        ``"product"``: every combination of values; ``"zip"``: all first values, all second
        values, and so on.
    methods : tuple of str
        Names of `hertzchain.sweeps.methods.METHODS`.
    keep : tuple of str
        Quantities of the pulse, the right wall, sensors or the whole run.
    at : str or tuple of int
        ``"every"`` bead, the ``"last"`` one, or the numbers of beads.
    errors : tuple of str
        Quantities whose relative errors are kept as well.
    reference : str
        Method relative to which errors are computed.
    batch : int or None
        Number of points computed together; chosen automatically if `None`.
    options : mapping
        Options of the simulations: rtol, until, max_steps.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.sweeps.specification import read_specification
    >>> spec = read_specification({"chain": {"taper": "uniform"}, "axes": {"beads": [20, 40]}})
    >>> spec.methods, len(spec.axes[0])
    (('propagate',), 2)
    """

    title: str
    chain: Mapping[str, Any]
    materials: Mapping[str, Any]
    axes: tuple[Axis, ...]
    combine: str
    methods: tuple[str, ...]
    keep: tuple[str, ...]
    at: str | tuple[int, ...]
    errors: tuple[str, ...]
    reference: str
    batch: int | None
    options: Mapping[str, Any]

    def __repr__(self) -> str:
        axes = [f"{axis.long_name} ({len(axis)})" for axis in self.axes]
        return short(
            "Specification", self.title, f"{self.combine} of {', '.join(axes) or 'no axes'}",
            f"methods {', '.join(self.methods)}", f"keep {', '.join(self.keep)}",
        )  # fmt: skip

    def as_json(self) -> str:
        """Convert to JSON text, which is the same for the same sweep.

        Examples
        --------
        >>> import hertzchain as hc
        >>> from hertzchain.sweeps.specification import read_specification
        >>> spec = read_specification({"chain": {"taper": "uniform"}, "axes": {"beads": [20]}})
        >>> spec.as_json()[:42]
        '{"title": "", "chain": {"taper": "uniform"'
        """
        axes = {axis.long_name: dict(_entry(axis)) for axis in self.axes}
        settings = {
            "combine": self.combine, "methods": list(self.methods), "keep": list(self.keep),
            "at": self.at if isinstance(self.at, str) else list(self.at),
            "errors": list(self.errors), "reference": self.reference,
        }  # fmt: skip
        if self.batch is not None:
            settings["batch"] = self.batch  # type: ignore[assignment]
        document = {
            "title": self.title, "chain": _sorted(self.chain), "materials": _sorted(self.materials),
            "axes": axes, "sweep": settings, "method": _sorted(self.options),
        }  # fmt: skip
        return json.dumps(document, allow_nan=False)


def _entry(axis: Axis) -> Mapping[str, Any]:
    """Entry of an axis as it was specified."""
    if isinstance(axis.entry, Mapping) and "list" not in axis.entry:
        return axis.entry
    if axis.unit is not None:
        return {"list": axis.coordinate().tolist(), "unit": axis.unit}
    return {"list": axis.values}


def _sorted(table: Mapping[str, Any]) -> Any:
    return json.loads(json.dumps(table, sort_keys=True))


# Tables of a specification, and its title.
TABLES: Final = ("title", "chain", "materials", "axes", "points", "sweep", "method")

_SWEEP: Final = (
    Key("combine", "choice", "every combination of values, or all first, all second values, ...",
        default="product", choices=("product", "zip")),
    Key("methods", "choice", "simulations and theories", default="propagate", choices=METHODS,
        per="item", one_for_all=True),
    Key("keep", "choice", "quantities of the pulse, the right wall or the whole run, or of "
        "one place, such as 'sensor.largest@ball 4'",
        default="velocity", choices=(*SWEEP_QUANTITIES,), per="item", one_for_all=True),
    Key("at", "choice", "beads to keep: every, the last, or a list of their numbers",
        default="every", choices=("every", "last")),
    Key("errors", "choice", "quantities whose relative errors are kept", choices=(*QUANTITIES,),
        per="item", one_for_all=True),
    Key("reference", "choice", "method relative to which errors are computed; the first by default",
        choices=METHODS),
    Key("batch", "integer", "number of points computed together", least=1, most=10**6),
)  # fmt: skip
_METHOD: Final = (
    Key("rtol", "number", "tolerated error of a step", above=0.0),
    Key("until", "number", "time to stop at", dimension="time", above=0.0),
    Key("max_steps", "integer", "step limit", least=1),
)
SECTIONS: Final[Mapping[str, Section]] = MappingProxyType(
    {
        "sweep": Section("sweep", "what is computed and kept", _SWEEP),
        "method": Section("method", "options of the simulations", _METHOD),
    }
)
SETTINGS: Final[Mapping[str, Key]] = MappingProxyType({key.name: key for key in _SWEEP})
METHOD_KEYS: Final = tuple(key.name for key in _METHOD)


def specification_schema() -> dict[str, Any]:
    """Schema of specifications in plain types, including the schema of chain files.

    Returns
    -------
    dict
        As of `hertzchain.store.chain_schema.chain_schema`.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.sweeps.specification import specification_schema
    >>> found = specification_schema()["sections"]
    >>> found["sweep"]["keys"][0]["choices"], "chain.loss" in found
    (['product', 'zip'], True)
    """
    found = chain_schema()
    found["sections"] |= {name: section_as_dict(each) for name, each in SECTIONS.items()}
    return found


def read_specification(given: Any) -> Specification:
    """Read a specification from a TOML file or from a mapping with the same tables."""
    if isinstance(given, Specification):
        return given
    if isinstance(given, Mapping):
        return _Reader(given, Path()).specification()
    if not isinstance(given, str | os.PathLike):
        raise InputError(f"specification must be a TOML file or a mapping, got {short_repr(given)}")
    document = read_toml("specification", given, "give the path of a TOML file")
    return _Reader(document, Path(given).parent, f"{shown_path(given)}: ").specification()


def specification_from_json(text: str) -> Specification:
    """Read a specification from the text that `Specification.as_json` returns."""
    return read_specification(json.loads(text))


class _Reader:
    """Read a document and collect all errors in it."""

    def __init__(self, document: Mapping[str, Any], folder: Path, heading: str = "") -> None:
        self.folder, self.heading = folder, heading
        self.problems: list[str] = []
        # A chain that the document contains or describes by files.
        self.inlined: Chain | None = None
        try:
            self.document = with_usual_names(document)
        except InputError as error:
            raise InputError(f"{heading}{error}") from None

    def specification(self) -> Specification:
        for key in self.document:
            if key not in TABLES:
                self._add("", unknown_name_error("table or key", key, TABLES))
        settings = self._table("sweep")
        for key in settings:
            if key not in SETTINGS:
                meant = f"{key} of [method]" if key in METHOD_KEYS else ""
                self._add("sweep", unknown_name_error("key", key, SETTINGS, meant=meant))
        chain, materials = self._chain()
        axes, combine = self._axes(settings)
        if self.inlined is not None:
            chain = chain_as_document(self.inlined, axes)["chain"]
        chain = with_lists(chain, axes)
        self.problems += [] if self.problems else missing_parts(chain, materials, axes)
        methods = self._names(settings, "methods")
        keep = self._names(settings, "keep")
        errors = self._names(settings, "errors")
        reference = settings.get("reference", methods[0] if methods else "")
        if reference not in methods:
            self._add("sweep.reference", unknown_name_error("reference", reference, methods))
        if errors and len(methods) == 1:
            self._add("sweep.errors", f"there is only one method, {methods[0]}: add others")
        of_runs = [name for name in keep if name in OF_RUNS or placed(name)]
        if "simulate" not in methods and of_runs:
            self._add("sweep.keep", f"{', '.join(of_runs)}: only the method 'simulate' gives it")
        title, batch = self._title(), self._batch(settings)
        at = self._at(settings.get("at", SETTINGS["at"].default))
        options = self._options(axes, methods)
        raise_all(self.problems, self.heading)
        return Specification(
            title, chain, materials, axes, combine, methods, keep, at, errors, reference, batch,
            options,
        )  # fmt: skip

    def _title(self) -> str:
        title = self.document.get("title", "")
        if not isinstance(title, str):
            self._add("title", f"must be text, got {short_repr(title)}")
        return str(self._try("title", to_json_types, title))

    def _batch(self, settings: Mapping[str, Any]) -> int | None:
        batch, allowed = settings.get("batch"), SETTINGS["batch"]
        if batch is None:
            return None
        bounds = {"least": int(allowed.least), "most": int(allowed.most)}
        return self._try("sweep.batch", whole_number, "batch", batch, **bounds)

    def _chain(self) -> tuple[Mapping[str, Any], Mapping[str, Any]]:
        given, materials = self.document.get("chain"), self._table("materials")
        if isinstance(given, Chain):
            return self._inlined(given)
        if not isinstance(given, Mapping):
            self._add("chain", "a sweep needs a table [chain], as in a chain file")
            return {}, materials
        drive = given.get("drive")
        names_files = "file" in given or (isinstance(drive, Mapping) and "file" in drive)
        if names_files:
            # Workers may run on other machines, which get the specification but no files.
            document = {"chain": self._table("chain"), "materials": materials}
            found = self._try("chain", chain_from, document, self.folder)
            return ({}, materials) if found is None else self._inlined(found)
        plain = self._try("chain", to_json_types, given)
        if plain is not None:
            # An axis may provide the keys that are missing.
            document = {"chain": plain, "materials": materials}
            self.problems += check_document(document, complete=False)
        return (without_units(plain) if not self.problems else {}), materials

    def _inlined(self, chain: Chain) -> tuple[Mapping[str, Any], Mapping[str, Any]]:
        document = self._try("chain", chain_as_document, chain) or {}
        self.inlined = chain if document else None
        return document.get("chain", {}), document.get("materials", {})

    def _axes(self, settings: Mapping[str, Any]) -> tuple[tuple[Axis, ...], str]:
        combine = settings.get("combine", SETTINGS["combine"].default)
        if combine not in SETTINGS["combine"].choices:
            known = SETTINGS["combine"].choices
            self._add("sweep.combine", unknown_name_error("combination", combine, known))
        points = self.document.get("points")
        entries: dict[tuple[str, ...], Any] = {}
        if points is not None:
            if "axes" in self.document or "combine" in settings:
                self._add("points", "there are also axes or combine: remove them or points")
            entries, combine = self._try("", columns_of_points, points, self.folder) or {}, "zip"
        else:
            found_axes = list(flattened(self._mapping("axes")))
            entries = dict(found_axes)
            if not entries:
                self._add("axes", "nothing varies: add parameters and their values")
            self.problems += conflicts([path for path, _ in found_axes])
        self.problems += second_strikers(entries, self.inlined)
        self.problems += fixed_by_others(entries, self.inlined)
        if combine != "zip" and (excess := too_many_points(entries)):
            self.problems += excess
            return (), combine
        place = "points" if points is not None else "axes"
        read = [self._axis(place, path, entries) for path in entries]
        axes = tuple(axis for axis in read if axis is not None)
        self.problems += unequal_lengths(axes) if combine == "zip" else duplicates(axes)
        return axes, combine

    def _axis(self, place: str, path: tuple[str, ...], entries: Mapping[Any, Any]) -> Axis | None:
        where = f"{place}.{'.'.join(path)}"
        if path[0] == "method" and len(path) == 2:
            if path[1] not in METHOD_KEYS:
                self._add(where, unknown_name_error("option", path[1], METHOD_KEYS))
        elif path[0] not in KEYS:
            dotted = "struck_by.mass", "struck_by.velocity", *(f"method.{k}" for k in METHOD_KEYS)
            self._add(where, unknown_name_error("parameter", ".".join(path), [*KEYS, *dotted]))
            return None
        elif path[0] == "with_scatter" and path[-1] != "radii" and self._has_scattered_radii():
            self._add(where, "has no effect, because with_scatter has the radii of the beads: give "
                      "it a seed instead")  # fmt: skip
            return None
        exponent = stiffness_exponent(path, self.inlined or self.document.get("chain"), entries)
        return self._try(where, Axis, path, entries[path], exponent)

    def _has_scattered_radii(self) -> bool:
        chain = self.document.get("chain")
        given = chain.get("with_scatter") if isinstance(chain, Mapping) else None
        listed = given if isinstance(given, list) else [given or {}]
        return any("radii" in each for each in listed)

    def _names(self, settings: Mapping[str, Any], key: str) -> tuple[str, ...]:
        usual, known = SETTINGS[key].default, SETTINGS[key].choices
        default = () if usual is None else (str(usual),)
        given = settings.get(key, default)
        listed = [given] if isinstance(given, str) else given
        if not isinstance(listed, list | tuple) or (default and not listed):
            self._add(f"sweep.{key}", f"must be a list of names, got {short_repr(given)}")
            return default
        names = []
        for place, entry in enumerate(listed, start=1):
            name = variable_name(entry) if isinstance(entry, str) and key != "methods" else entry
            if name in known or (key == "keep" and isinstance(name, str) and placed(name)):
                names.append(name)
                continue
            if key == "methods":
                self._add(f"sweep.methods[{place}]", unknown_name_error("method", entry, known))
            else:
                self._add(f"sweep.{key}[{place}]", unknown_quantity(entry, known))
        if len(set(names)) < len(names):
            self._add(f"sweep.{key}", f"has one name twice: {', '.join(names)}")
        return tuple(names) or default

    def _at(self, given: Any) -> str | tuple[int, ...]:
        if given in SETTINGS["at"].choices:
            return str(given)
        if not isinstance(given, list | tuple) or not given:
            self._add(
                "sweep.at", f"must be 'every', 'last' or a list of beads, got {short_repr(given)}"
            )
            return "every"
        beads = [self._try("sweep.at", whole_number, "bead", bead, least=1) for bead in given]
        found = tuple(bead for bead in beads if bead is not None)
        if sorted(set(found)) != list(found):
            self._add("sweep.at", f"numbers of beads must increase, got {short_repr(given)}")
        return found

    def _options(self, axes: Sequence[Axis], methods: Sequence[str]) -> Mapping[str, Any]:
        given = self._table("method")
        used = {axis.path[1] for axis in axes if axis.path[0] == "method"} | given.keys()
        accepted = {name for method in methods for name in OPTIONS_OF.get(method, ())}
        for name in sorted(used):
            if name not in METHOD_KEYS:
                self._add(f"method.{name}", unknown_name_error("option", name, METHOD_KEYS))
            elif name not in accepted:
                fit = [method for method, names in OPTIONS_OF.items() if name in names]
                self._add(f"method.{name}", f"no method accepts it: add {' or '.join(fit)}")
        for name, value in given.items():
            self._try(f"method.{name}", check_option, name, value, methods)
        for axis in axes:
            where = f"axes.{axis.long_name}"
            for value in axis.values if axis.path[0] == "method" else ():
                self._try(where, check_option, axis.path[1], value, methods)
        return given

    def _table(self, name: str) -> Mapping[str, Any]:
        """A table with values of JSON types."""
        return self._try(name, to_json_types, self._mapping(name)) or {}

    def _mapping(self, name: str) -> Mapping[Any, Any]:
        entry = self.document.get(name, {})
        if not isinstance(entry, Mapping):
            self._add(name, f"must be a table, got {short_repr(entry)}")
            return {}
        return entry

    def _try(self, place: str, function: Any, *arguments: Any, **more: Any) -> Any:
        try:
            return function(*arguments, **more)
        except InputError as error:
            self._add(place, error)
            return None

    def _add(self, place: str, problem: InputError | str) -> None:
        self.problems.append(f"{place}: {problem}" if place else str(problem))

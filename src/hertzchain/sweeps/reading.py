"""Read what a sweep shall do from a TOML file or a mapping; all that is wrong in one error.

::

    title = "momentum over taper and length"

    [chain]                       # as in a chain file
    taper = "forward-exponential"
    rate = 0.05
    beads = 60

    [axes]                        # what varies: every combination
    rate = {linspace = [0.01, 0.1, 19]}
    beads = [20, 40, 60]

    [sweep]
    methods = ["propagate", "local-rate"]
    keep = ["momentum"]           # quantities of a pulse, or of a wall
    at = "last"                   # or "every" bead, or a list of beads
    errors = ["velocity"]         # of the other methods against the first

    [method]
    rtol = 1e-8
"""

from __future__ import annotations

import json
import os
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from hertzchain.arguments import file_path, shown_path
from hertzchain.chain.chain import Chain
from hertzchain.checks import whole_number
from hertzchain.errors import InputError, shown, unknown_name
from hertzchain.store.chain_files import chain_as_toml, chain_from
from hertzchain.store.chain_schema import KEYS, check_document, without_units
from hertzchain.store.csv_tables import csv_rows
from hertzchain.store.toml_files import read_toml
from hertzchain.sweeps.axes import Axis, flattened
from hertzchain.sweeps.methods import OPTIONS as OPTIONS_OF
from hertzchain.sweeps.methods import check_option
from hertzchain.sweeps.plain import plain_json
from hertzchain.sweeps.specification import WALL_QUANTITIES, Specification
from hertzchain.sweeps.specification_schema import OPTIONS, SETTINGS, TABLES

# Errors that are told at once.
TOLD: Final = 20


def read_specification(given: Any) -> Specification:
    """A specification from a TOML file, a mapping with the same tables, or JSON text.

    Parameters
    ----------
    given : path-like, mapping or Specification
        Where it is, or what it says.  ``chain`` may be a `Chain`, values may be arrays.

    Returns
    -------
    Specification

    Raises
    ------
    InputError
        If anything in it cannot be used: all errors, each with its path.

    Examples
    --------
    >>> beads = [20, 40, 80]
    >>> read_specification({"chain": {"taper": "uniform"}, "axes": {"beads": beads}}).at
    'every'
    """
    if isinstance(given, Specification):
        return given
    if isinstance(given, Mapping):
        return _Reader(given, Path()).specification()
    if not isinstance(given, str | os.PathLike):
        raise InputError(f"a sweep takes a TOML file or a mapping, got {shown(given)}")
    document = read_toml("specification", given, "give the path of a TOML file")
    return _Reader(document, Path(given).parent, f"{shown_path(given)}: ").specification()


def specification_from_json(text: str) -> Specification:
    """The specification that `as_json` wrote.

    Parameters
    ----------
    text : str
        JSON text.

    Returns
    -------
    Specification

    Examples
    --------
    >>> spec = read_specification({"chain": {"taper": "uniform"}, "axes": {"beads": [20]}})
    >>> specification_from_json(spec.as_json()).as_json() == spec.as_json()
    True
    """
    return read_specification(json.loads(text))


class _Reader:
    """Reads a document and gathers what is wrong with it."""

    def __init__(self, document: Mapping[str, Any], folder: Path, heading: str = "") -> None:
        self.document, self.folder, self.heading = document, folder, heading
        self.problems: list[str] = []

    def specification(self) -> Specification:
        for key in self.document:
            if key not in TABLES:
                self._add("", unknown_name("table or key", key, TABLES))
        settings = self._table("sweep")
        for key in settings:
            if key not in SETTINGS:
                self._add("sweep", unknown_name("key", key, SETTINGS))
        chain, materials = self._chain()
        axes, combine = self._axes(settings)
        methods = self._names(settings, "methods")
        keep = self._names(settings, "keep")
        errors = self._names(settings, "errors")
        reference = settings.get("reference", methods[0] if methods else "")
        if reference not in methods:
            self._add("sweep.reference", unknown_name("reference", reference, methods))
        if errors and len(methods) == 1:
            self._add("sweep.errors", f"there is only one method, {methods[0]}: add others")
        if "simulate" not in methods and set(keep) & set(WALL_QUANTITIES):
            self._add("sweep.keep", "what a wall felt needs the method 'simulate'")
        title = self.document.get("title", "")
        if not isinstance(title, str):
            self._add("title", f"must be text, got {shown(title)}")
        title = self._try("title", plain_json, title)
        batch = settings.get("batch")
        if batch is not None:
            least, most = (
                int(bound) for bound in (SETTINGS["batch"].least, SETTINGS["batch"].most)
            )
            batch = self._try("sweep.batch", whole_number, "batch", batch, least=least, most=most)
        at = self._at(settings.get("at", SETTINGS["at"].default))
        options = self._options(axes, methods)
        raise_all(self.problems, self.heading)
        return Specification(
            title, chain, materials, axes, combine, methods, keep, at, errors, reference, batch,
            options,
        )  # fmt: skip

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
            # What computes may be another machine: nothing but the specification goes there.
            document = {"chain": self._table("chain"), "materials": materials}
            found = self._try("chain", chain_from, document, self.folder)
            return self._inlined(found) if found is not None else ({}, materials)
        plain = self._try("chain", plain_json, given)
        if plain is not None:
            # What is missing may come from an axis.
            problems = check_document({"chain": plain, "materials": materials}, complete=False)
            self.problems += problems
        return (without_units(plain) if not self.problems else {}), materials

    def _inlined(self, chain: Chain) -> tuple[Mapping[str, Any], Mapping[str, Any]]:
        document = self._try("chain", _as_document, chain) or {}
        return document.get("chain", {}), document.get("materials", {})

    def _axes(self, settings: Mapping[str, Any]) -> tuple[tuple[Axis, ...], str]:
        combine = settings.get("combine", SETTINGS["combine"].default)
        if combine not in SETTINGS["combine"].choices:
            known = SETTINGS["combine"].choices
            self._add("sweep.combine", unknown_name("combination", combine, known))
        points = self.document.get("points")
        entries: dict[tuple[str, ...], Any] = {}
        if points is not None:
            if "axes" in self.document or "combine" in settings:
                self._add("points", "there are also axes or combine: leave them or points out")
            entries, combine = self._columns(points), "zip"
        else:
            found_axes = list(flattened(self._mapping("axes")))
            entries = dict(found_axes)
            if not entries:
                self._add("axes", "nothing varies: give parameters and their values")
            self._check_paths([path for path, _ in found_axes])
        place = "points" if points is not None else "axes"
        found = [self._axis(place, path, entry) for path, entry in entries.items()]
        axes = tuple(axis for axis in found if axis is not None)
        lengths = {axis.long_name: len(axis) for axis in axes}
        if combine == "zip" and len(set(lengths.values())) > 1:
            told = ", ".join(f"{name} has {length}" for name, length in lengths.items())
            self._add("axes", f"zip needs axes of one length, but {told} values")
        if combine == "product":
            for axis in axes:
                if (value := axis.twice()) is not None:
                    self._add(f"axes.{axis.long_name}", f"has the value {value!r} twice")
        return axes, combine

    def _axis(self, place: str, path: tuple[str, ...], entry: Any) -> Axis | None:
        where = f"{place}.{'.'.join(path)}"
        if path[0] == "method" and len(path) == 2:
            if path[1] not in OPTIONS:
                self._add(where, unknown_name("option", path[1], OPTIONS))
        elif path[0] not in KEYS:
            known = (*KEYS, *(f"method.{name}" for name in OPTIONS))
            self._add(where, unknown_name("parameter", ".".join(path), known))
            return None
        return self._try(where, Axis, path, entry)

    def _columns(self, points: Any) -> dict[tuple[str, ...], list[Any]]:
        """Rows of explicit points as lists by parameter."""
        if isinstance(points, str):
            return self._try("points", _columns_of_csv, self.folder, points) or {}
        if not isinstance(points, list | tuple) or not points:
            told = f"must be tables [[points]], or the name of a CSV file, got {shown(points)}"
            self._add("points", told)
            return {}
        for place, row in enumerate(points, start=1):
            if not isinstance(row, Mapping) or not row:
                self._add(f"points[{place}]", f"must be a table of parameters, got {shown(row)}")
                return {}
        rows = [dict(flattened(row)) for row in points]
        columns: dict[tuple[str, ...], list[Any]] = {path: [] for path in rows[0]}
        for place, row in enumerate(rows, start=1):
            if row.keys() != columns.keys():
                names = [".".join(path) for path in columns]
                self._add(f"points[{place}]", f"must give {', '.join(names)}, as the first does")
                return {}
            for path, value in row.items():
                columns[path].append(value)
        return columns

    def _names(self, settings: Mapping[str, Any], key: str) -> tuple[str, ...]:
        usual, known = SETTINGS[key].default, SETTINGS[key].choices
        default = () if usual is None else (str(usual),)
        given = settings.get(key, default)
        listed = [given] if isinstance(given, str) else given
        if not isinstance(listed, list | tuple) or (default and not listed):
            self._add(f"sweep.{key}", f"must be a list of names, got {shown(given)}")
            return default
        for place, name in enumerate(listed, start=1):
            if name not in known:
                what = {"methods": "method"}.get(key, "quantity")
                self._add(f"sweep.{key}[{place}]", unknown_name(what, name, known))
        names = tuple(name for name in listed if name in known)
        if len(set(names)) < len(names):
            self._add(f"sweep.{key}", f"names one of them twice: {', '.join(names)}")
        return names or default

    def _at(self, given: Any) -> str | tuple[int, ...]:
        if given in SETTINGS["at"].choices:
            return str(given)
        if not isinstance(given, list | tuple) or not given:
            self._add("sweep.at", f"must be 'every', 'last' or a list of beads, got {shown(given)}")
            return "every"
        beads = [self._try("sweep.at", whole_number, "bead", bead, least=1) for bead in given]
        found = tuple(bead for bead in beads if bead is not None)
        if sorted(set(found)) != list(found):
            self._add("sweep.at", f"beads must increase, got {shown(given)}")
        return found

    def _options(self, axes: Sequence[Axis], methods: Sequence[str]) -> Mapping[str, Any]:
        given = self._table("method")
        used = {axis.path[1] for axis in axes if axis.path[0] == "method"} | given.keys()
        heard = {name for method in methods for name in OPTIONS_OF.get(method, ())}
        for name in sorted(used):
            if name not in OPTIONS:
                self._add(f"method.{name}", unknown_name("option", name, OPTIONS))
            elif name not in heard:
                fit = [method for method, names in OPTIONS_OF.items() if name in names]
                self._add(f"method.{name}", f"no method takes it: add {' or '.join(fit)}")
        for name, value in given.items():
            self._try(f"method.{name}", check_option, name, value, methods)
        for axis in axes:
            if axis.path[0] == "method":
                for value in axis.values:
                    where = f"axes.{axis.long_name}"
                    self._try(where, check_option, axis.path[1], value, methods)
        return given

    def _table(self, name: str) -> Mapping[str, Any]:
        """A table of plain values."""
        return self._try(name, plain_json, self._mapping(name)) or {}

    def _mapping(self, name: str) -> Mapping[Any, Any]:
        entry = self.document.get(name, {})
        if not isinstance(entry, Mapping):
            self._add(name, f"must be a table, got {shown(entry)}")
            return {}
        return entry

    def _check_paths(self, paths: Sequence[tuple[str, ...]]) -> None:
        """An axis replaces what is below its path, and with it what another axis has set there."""
        for place, path in enumerate(paths):
            for earlier in paths[:place]:
                if earlier[: len(path)] == path:
                    said = f"would undo axes.{'.'.join(earlier)}: leave one out, or put it first"
                    self._add(f"axes.{'.'.join(path)}", said)

    def _try(self, place: str, function: Any, *arguments: Any, **more: Any) -> Any:
        try:
            return function(*arguments, **more)
        except InputError as error:
            self._add(place, error)
            return None

    def _add(self, place: str, problem: InputError | str) -> None:
        self.problems.append(f"{place}: {problem}" if place else str(problem))


def raise_all(problems: Sequence[str], heading: str = "") -> None:
    """Raise one error that lists all that is wrong; nothing if nothing is.

    Parameters
    ----------
    problems : sequence of str
        What is wrong, each with its path.
    heading : str
        What it is about.

    Raises
    ------
    InputError
        If there are problems.

    Examples
    --------
    >>> raise_all([])
    """
    if len(problems) == 1:
        raise InputError(heading + problems[0])
    if problems:
        lines = [f"{heading}{len(problems)} errors:", *problems[:TOLD]]
        if len(problems) > TOLD:
            lines.append(f"and {len(problems) - TOLD} more")
        raise InputError("\n  ".join(lines))


def _as_document(chain: Chain) -> Any:
    return plain_json(tomllib.loads(chain_as_toml(chain)), "chain")


def _columns_of_csv(folder: Path, name: str) -> dict[tuple[str, ...], list[Any]]:
    """Columns of a CSV file by parameter: of numbers if all cells are, otherwise of text."""
    file = file_path("points", folder / name)
    try:
        rows = csv_rows(file)
        if len(rows) < 2:
            raise InputError("needs a header of parameters, and a row for each point")
        header, *body = rows
        for column in header:
            if header.count(column) > 1:
                raise InputError(f"column {column!r} is there twice: leave one")
        for place, row in enumerate(body, start=1):
            if len(row) != len(header):
                raise InputError(f"row {place} has {len(row)} cells, the header has {len(header)}")
            if "" in row:
                raise InputError(f"row {place} has no {header[row.index('')]}")
    except InputError as error:
        raise InputError(f"{os.fspath(file)!r}: {error}") from None
    columns = zip(*body, strict=True)
    return {tuple(key.split(".")): _cells(cells)
            for key, cells in zip(header, columns, strict=True)}  # fmt: skip


def _cells(cells: Sequence[str]) -> list[Any]:
    for kind in (int, float):
        try:
            return [kind(cell) for cell in cells]
        except ValueError:
            continue
    return list(cells)

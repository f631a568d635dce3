"""Design files: a chain file with a table ``[design]``.

::

    [chain]                        # as in a chain file
    radii = 5e-3
    materials = "steel-304"
    beads = 12
    right_wall = {material = "steel-304"}

    [design]
    minimise = "wall_force.peak"   # or maximise, or match = {velocity = [...]}
    budget = "60 s"                # also method, seed, points and until

    [[design.vary]]                # radii, masses, gaps, balls or order
    balls = "bearing-balls"        # or a CSV file
    materials = ["steel-304", "ptfe"]
    optional = true

    [design.subject_to]
    length = "<= 60 mm"

    [design.scatter]
    radius = 0.01
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any, Final

from ..chain.chain import Chain
from ..errors import (
    InputError,
    errors_at,
    raise_all,
    short_repr,
    similar_names,
    unknown_name_error,
)
from ..store.chain_files import chain_from
from ..store.chain_schema import with_usual_names
from ..store.schema_checks import check_document, unknown_keys
from ..store.toml_files import read_toml
from ..validation.keywords import checked_arguments
from ..validation.numbers import whole_number
from ..validation.objects import file_path, shown_path
from . import vary as variables
from .balls import SHIPPED
from .measures import unknown_quantities
from .objective import objectives_from
from .problem import Design, Variable
from .requirements import requirements_from
from .scatter import Scatter, scatter_from
from .search_budget import budget_from

PROBLEM: Final = (
    "minimise",
    "maximise",
    "match",
    "vary",
    "subject_to",
    "scatter",
    "until",
    "model",
)
TABLES: Final = ("chain", "materials", "fit", "design")
OPTIONS: Final = ("budget", "method", "seed", "points")
SIZES: Final = ("radii", "diameters", "masses", "gaps")
KINDS: Final = (*SIZES, "balls", "order")


@checked_arguments("load_design")
def load_design(path: str | os.PathLike[str]) -> tuple[Design, dict[str, Any]]:
    """Read a design file: a chain file with a table ``[design]``, as of ``hertzchain design``.

    Parameters
    ----------
    path : path-like
        The TOML file.  Other files that it names are relative to its folder.

    Returns
    -------
    problem : Design
        The chain, the objective, the variables and the constraints.
    options : dict
        Those of the keys ``budget``, ``method``, ``seed`` and ``points`` that the file has, which
        are arguments of `design`.

    Raises
    ------
    InputError
        If the file cannot be read, has no tables ``[chain]``, ``[design]`` or ``[[design.vary]]``,
        or if a key is unknown or a value out of range.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from pathlib import Path
    >>> import tempfile
    >>> text = '''
    ... [chain]
    ... diameters = "10 mm"
    ... materials = "steel-304"
    ... beads = 5
    ... [design]
    ... maximise = "velocity@last"
    ... budget = 200
    ... [[design.vary]]
    ... diameters = ["5 mm", "15 mm"]
    ... beads = "2:"
    ... '''
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "problem.toml"
    ...     _ = file.write_text(text)
    ...     problem, options = hc.load_design(file)
    >>> options
    {'budget': 200}
    >>> hc.design(problem, **options).met
    True
    """
    return read_design(path)


def read_design(
    path: str | os.PathLike[str], change: Callable[[Chain], Chain] | None = None
) -> tuple[Design, dict[str, Any]]:
    """Read the problem of a design file, with a change of its chain, and the options."""
    file = file_path("design file", path)
    document = read_toml("design file", path, "give the path of a TOML file")
    table = document.pop("design", None)
    with errors_at(shown_path(path)):
        if not isinstance(table, Mapping):
            raise InputError("it has no table [design] with the objective")
        entries = table.get("vary", [])
        if isinstance(entries, Mapping):
            entries = [entries]
        if unknown := [*_unknown_names(document, table, entries)]:
            raise_all([*unknown, *_invalid_limits(document, table, file.parent)])
        if "chain" not in document:
            raise InputError("it has no table [chain]")
        if not entries:
            raise InputError(
                "it has no table [[design.vary]] with what may vary, such as diameters = ['5 mm', "
                "'20 mm'] or balls = 'bearing-balls'"
            )
        given = {key: table[key] for key in PROBLEM if key in table}
        chain, given["vary"] = _values(document, table, entries, file.parent, change)
        problem = Design(chain, **given)
    return problem, {key: table[key] for key in OPTIONS if key in table}


def _values(
    document: Mapping[str, Any], table: Mapping[str, Any], entries: Sequence[Any], folder: Path,
    change: Callable[[Chain], Chain] | None,
) -> tuple[Chain, list[Variable]]:  # fmt: skip
    """The chain and the variables; all invalid values of the file are reported together."""
    found, errors = dict[str, Any](), list[InputError]()

    def attempt(name: str, function: Callable[..., Any], *arguments: Any, **more: Any) -> None:
        try:
            found[name] = function(*arguments, **more)
        except InputError as error:
            errors.append(error)

    attempt("chain", chain_from, document, folder)
    for i, entry in enumerate(entries):
        attempt(f"vary {i}", _variable, entry, folder)
    if "budget" in table:
        attempt("budget", budget_from, table["budget"])
    if "seed" in table:
        attempt("seed", whole_number, "seed", table["seed"], least=0)
    attempt("scatter", scatter_from, table.get("scatter"))
    if "chain" in found:
        if change is not None:
            found["chain"] = change(found["chain"])
        chain = found["chain"]
        goals = (table.get(key) for key in ("minimise", "maximise", "match"))
        attempt("goal", objectives_from, chain, *goals)
        limits = table.get("subject_to", {})
        parts = [{name: limits[name]} for name in limits] if isinstance(limits, Mapping) else []
        for each in parts or [limits]:
            attempt("limit", requirements_from, each, chain)
    if len(errors) == 1:
        raise errors[0]
    raise_all([*map(str, errors)])
    return found["chain"], [found[f"vary {i}"] for i in range(len(entries))]


def _invalid_limits(
    document: Mapping[str, Any], table: Mapping[str, Any], folder: Path
) -> Iterator[str]:
    """Describe invalid values of limits with known names, if the chain is known."""
    limits = table.get("subject_to", {})
    try:
        chain = chain_from(document, folder)
    except InputError:
        return
    for name in limits if isinstance(limits, Mapping) else ():
        if [*unknown_quantities([name])]:
            continue
        try:
            requirements_from({name: limits[name]}, chain)
        except InputError as error:
            yield str(error)


def _unknown_names(
    document: Mapping[str, Any], table: Mapping[str, Any], entries: Any
) -> Iterator[str]:
    """Describe unknown keys and quantities of all tables, and the other mistakes in [chain]."""
    for name in document:
        if name not in TABLES:
            yield str(unknown_name_error("table of a design file", name, TABLES))
    known: tuple[str, ...] = (*PROBLEM, *OPTIONS)
    yield from unknown_keys([key for key in table if key not in known], "[design]", known)
    goals = (table.get(key) for key in ("minimise", "maximise", "subject_to"))
    quantities = [
        name for each in goals for name in ([each] if isinstance(each, str) else each or ())
        if not (isinstance(each, Mapping) and isinstance(each[name], Mapping))
    ]  # fmt: skip
    yield from unknown_quantities(quantities)
    for entry in entries:
        if isinstance(entry, Mapping) and len(kinds := _kinds(entry)) == 1:
            known = variables_of(*kinds)
            names = [key for key in entry if key not in (*kinds, *known, *PROBLEM, *OPTIONS)]
            yield from unknown_keys(names, f"{kinds[0]} in [[design.vary]]", known)
    if isinstance(scatter := table.get("scatter"), Mapping):
        known = tuple(item.name for item in fields(Scatter))
        yield from unknown_keys([key for key in scatter if key not in known], "[design.scatter]",
                                known)  # fmt: skip
    if "chain" in document:
        chain = {key: value for key, value in document.items() if key in TABLES}
        yield from check_document(with_usual_names(chain))


def _kinds(entry: Mapping[str, Any]) -> list[str]:
    """Kinds of variables among the keys of a table, which should be one."""
    # Diameters of balls are a choice among those of the catalogue.
    return [key for key in KINDS if key in entry and not (key == "diameters" and "balls" in entry)]


def _variable(entry: Any, folder: Path) -> Variable:
    """A variable from its table, whose kind is one of its keys."""
    if not isinstance(entry, Mapping):
        raise InputError(f"[[design.vary]] must be a table, got {short_repr(entry)}")
    kinds = _kinds(entry)
    if len(kinds) != 1:
        keys = ", ".join(map(repr, entry)) or "no key"
        raise InputError(f"each table [[design.vary]] has one of {', '.join(KINDS)}, got {keys}")
    (kind,), rest = kinds, {key: entry[key] for key in entry if key != kinds[0]}
    for key in rest:
        if key in (*PROBLEM, *OPTIONS):
            raise InputError(
                f"{key} is a key of [design], not of [[design.vary]]: write it above all tables "
                "[[design.vary]]"
            )
    if kind in SIZES:
        return _sizes(kind, entry[kind], rest)
    if kind == "order":
        if entry[kind] is not True:
            raise InputError(
                f"order must be true, got {short_repr(entry[kind])}; state the beads that may "
                'change places in the same table, such as beads = "2:"'
            )
        return variables.order(**rest)
    if not isinstance(optional := rest.get("optional", False), bool):
        raise InputError(f"optional must be true or false, got {short_repr(optional)}")
    return variables.balls(_catalogue(entry[kind], folder), **rest)


def _catalogue(name: Any, folder: Path) -> str | Path:
    """The catalogue of hertzchain, or the path of a file."""
    if not isinstance(name, str):
        raise InputError(f"balls must be {SHIPPED!r} or a file, got {short_repr(name)}")
    if name == SHIPPED:
        return SHIPPED
    file = folder / name
    if not file.exists() and similar_names(name, [SHIPPED]):
        raise InputError(
            f"there is no catalogue of balls {shown_path(file)!r}; did you mean {SHIPPED!r}?"
        )
    return file


def variables_of(kind: str) -> tuple[str, ...]:
    """Keys of a table of one kind."""
    import inspect

    names = inspect.signature(getattr(variables, kind)).parameters
    return tuple(name for name in names if name not in ("low", "high", "catalogue"))


def _sizes(kind: str, limits: Any, rest: dict[str, Any]) -> Variable:
    if not isinstance(limits, list) or len(limits) != 2:
        raise InputError(
            f"{kind} in [[design.vary]] must be the smallest and the largest value, such as "
            f"[0.5, 1.0], got {short_repr(limits)}"
        )
    function: Any = getattr(variables, kind)
    return function(*limits, **rest)

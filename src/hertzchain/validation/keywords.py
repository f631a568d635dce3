"""Report unknown and missing arguments of functions, methods and classes as `InputError`."""

from __future__ import annotations

import dataclasses
import difflib
import functools
import inspect
import re
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any, Final, ParamSpec, TypeVar

from ..errors import NEAR, InputError, short_repr

# Other words for arguments, which are not similar to their names.
SYNONYMS: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        "speed": ("velocity", "velocities"), "v": ("velocity",), "p": ("exponent",),
        "n": ("beads",), "number": ("beads",), "wall": ("right_wall",),
        "q": ("rate",), "s": ("rate",),
        "losses": ("loss",), "damping": ("loss",), "preload": ("precompression",),
        "material": ("name",), "materials": ("name",), "rho": ("density",),
        "chains": ("samples",),
    }
)  # fmt: skip
# Arguments of another function or class, by function and name.
ELSEWHERE: Final[Mapping[tuple[str, str], str]] = MappingProxyType(
    {
        ("distribution", "chains"): "scatter=Scatter(..., samples=100)",
        ("distribution", "samples"): "scatter=Scatter(..., samples=100)",
        ("distribution", "radius"): "scatter=Scatter(radius=0.01)",
        ("distribution", "relative"): "scatter=Scatter(radius=0.01)",
        ("distribution", "grade"): "scatter=Scatter(grade=100)",
        ("distribution", "beads"): 'scatter=Scatter(..., beads="2:")',
        ("distribution", "gaps"): 'scatter=Scatter(gaps="5 um")',
        ("distribution", "speed"): "scatter=Scatter(speed=0.02)",
        ("distribution", "young"): "scatter=Scatter(young=0.05)",
        ("distribution", "yield_strength"): "scatter=Scatter(yield_strength=0.1)",
        ("Scatter", "relative"): "radius=0.01",
        ("Scatter", "scatter"): "radius=0.01",
        ("Scatter", "diameter"): "radius=0.01, which is also the scatter of the diameter",
        ("struck_by", "flat"): 'radius="flat"',
        ("Chain.tapered", "diameter"): 'first_diameter="10 mm"',
        ("Chain.tapered", "diameters"): "first_diameter and last_diameter",
        ("Chain.tapered", "radius"): 'first="5 mm"',
        ("Chain.tapered", "radii"): "first and last",
        ("with_scatter", "scatter"): "relative=0.01",
        ("with_scatter", "radius"): "relative=0.01",
        ("disorder", "relative"): "scatter=0.01",
        ("disorder", "radius"): "scatter=0.01",
        ("disorder", "beads"): 'distribution with Scatter(radius=0.01, beads="2:"): in the '
        "disorder law, all beads scatter",
    }
)
# Features of a chain, which functions of a chain do not have as arguments, and their fields.
OF_CHAINS: Final[Mapping[str, str]] = MappingProxyType(
    {"wall": "right_wall"}
    | {name: name for name in ("right_wall", "left_wall", "gravity", "precompression", "loss",
                               "drive")}
)  # fmt: skip
MATERIALS: Final = frozenset(("material", "materials"))
# Other names of fields of a chain, accepted by builders, chain files and sweeps.
FIELD_ALIASES: Final[Mapping[str, str]] = MappingProxyType(
    {"material": "materials", "diameter": "diameters"}
)
# Of a function with more arguments, only the required ones are listed if one of them is missing.
MANY: Final = 8
EMPTY: Final = inspect.Parameter.empty
# Arguments that are fractions.
FRACTIONS: Final = ("relative",)
_TWICE: Final = re.compile(r"multiple values for argument '(\w+)'")
P = ParamSpec("P")
R = TypeVar("R")


def checked_arguments(
    label: str, more: Iterable[str] = (), aliases: Mapping[str, str] = MappingProxyType({})
) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Raise `InputError` for unknown and missing arguments; ``more`` are names of ``**fields``.

    ``aliases`` are other names of arguments.
    """
    others = tuple(more)

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        @functools.wraps(function)
        def checked(*given: P.args, **keywords: P.kwargs) -> R:
            if not aliases.keys().isdisjoint(keywords):
                known = _arguments(function, others)
                _rename(keywords, {each: name for each, name in aliases.items() if name in known})
            if others:
                check_keywords(label, keywords, _arguments(function, others))
            try:
                return function(*given, **keywords)
            except TypeError:
                _check_call(label, function, others, given, keywords)
                raise

        return checked

    return decorate


def checked_methods(cls: type[R]) -> type[R]:
    """Raise `InputError` for unknown and missing arguments of the public methods of a class."""
    for name, method in list(vars(cls).items()):
        if inspect.isfunction(method) and not name.startswith("_"):
            checked = _checked_method(name, method)
            # Help shows these names also if the function is one of another module.
            checked.__name__, checked.__qualname__ = name, f"{cls.__name__}.{name}"
            setattr(cls, name, checked)
    return cls


def _checked_method(name: str, method: Callable[..., R]) -> Callable[..., R]:
    @functools.wraps(method)
    def checked(self: Any, *given: Any, **keywords: Any) -> R:
        try:
            return method(self, *given, **keywords)
        except TypeError:
            _check_call(f"{type(self).__name__}.{name}", method, (), (self, *given), keywords)
            raise

    return checked


def _rename(given: dict[str, Any], aliases: Mapping[str, str]) -> None:
    """Replace other names of arguments by their usual names."""
    for other in aliases.keys() & given.keys():
        name, value = aliases[other], given.pop(other)
        if given.get(name) is None:
            given[name] = value
        elif value is not None:
            raise InputError(f"{name} and {other} are the same: give one of them")


@functools.cache
def _arguments(function: Callable[..., Any], others: tuple[str, ...]) -> list[str]:
    """Names of the arguments of a function, and other names that it accepts."""
    named = [name for name, each in inspect.signature(function).parameters.items()
             if each.kind in (each.POSITIONAL_OR_KEYWORD, each.KEYWORD_ONLY)
             and name not in ("self", "cls")]  # fmt: skip
    return list(dict.fromkeys((*named, *others)))


def _check_call(
    label: str,
    function: Callable[..., Any],
    others: tuple[str, ...],
    given: tuple[Any, ...],
    keywords: Mapping[str, Any],
) -> None:
    """Raise `InputError` if the arguments do not fit a function, which has raised a `TypeError`.

    A check before each call would take longer than some of the functions.
    """
    known = _arguments(function, others)
    check_keywords(label, keywords, known)
    try:
        inspect.signature(function).bind(*given, **keywords)
    except TypeError as error:
        reason = str(error).replace("a required argument: ", "the argument ")
        if found := _TWICE.fullmatch(reason):
            raise InputError(_given_twice(label, function, found[1], given, keywords)) from None
        verb, takes = "takes", ", ".join(known) or "no arguments"
        if reason.startswith("missing") and len(known) > MANY:
            verb, takes = "requires only", ", ".join(_required(function))
        hint = _by_keyword(function, given, keywords) if reason.startswith("too many") else ""
        raise InputError(f"{label}: {reason}; {hint}it {verb} {takes}") from None


def _required(function: Callable[..., Any]) -> list[str]:
    """Names of the arguments without a default."""
    parameters = inspect.signature(function).parameters
    return [name for name in _arguments(function, ()) if parameters[name].default is EMPTY]


def _by_keyword(
    function: Callable[..., Any], given: tuple[Any, ...], keywords: Mapping[str, Any]
) -> str:
    """How to give values that are beyond the positional arguments, or an empty text."""
    parameters = inspect.signature(function).parameters.values()
    places = [each for each in parameters
              if each.kind in (each.POSITIONAL_ONLY, each.POSITIONAL_OR_KEYWORD)]  # fmt: skip
    free = [each for each in parameters
            if each.kind == each.KEYWORD_ONLY and each.name not in keywords]  # fmt: skip
    values = given[len(places) :]
    required = [each for each in free if each.default is each.empty]
    # Values belong to required arguments, in their order; that of optional ones is not known.
    if len(values) <= len(required):
        pairs = zip(required, values, strict=False)
        return f"write {', '.join(f'{each.name}={short_repr(value)}' for each, value in pairs)}; "
    if not free:
        return ""
    if len(values) == len(free) == 1:
        return f"write {free[0].name}={short_repr(values[0])}; "
    if len(free) == 1:
        return f"{free[0].name} must be given by keyword, as {free[0].name}=...; "
    example = (required or free)[0].name
    return f"give others by keyword, such as {example}={_as_example(example, values[0])}; "


def _as_example(name: str, value: Any) -> str:
    """A value as that of an argument; numbers from 1 on are percentages where it is a fraction."""
    percent = name in FRACTIONS and isinstance(value, int | float) and value >= 1
    return f"'{value:g}%'" if percent else short_repr(value)


def _given_twice(
    label: str,
    function: Callable[..., Any],
    name: str,
    given: tuple[Any, ...],
    keywords: Mapping[str, Any],
) -> str:
    """Sentence about an argument that is given by position and by keyword."""
    parameters = inspect.signature(function).parameters
    position = [*parameters].index(name)
    value = short_repr(given[position])
    left = [each.name for each in parameters.values()
            if each.kind == each.KEYWORD_ONLY and each.name not in keywords]  # fmt: skip
    other = next(iter(left), "")
    before = {"self", "cls"}.isdisjoint(parameters)
    place = ("first", "second", "third")[min(position - (not before), 2)]
    simple = other and isinstance(given[position], int | float | str)
    example = "; give it once"
    if simple:
        example = f"; give others by keyword, such as {other}={_as_example(other, given[position])}"
    return (
        f"{label}: the {place} argument is {name}, which is given twice, as {value} and as "
        f"{name}={short_repr(keywords[name])}{example}"
    )


def checked_fields(cls: type[R]) -> type[R]:
    """Raise `InputError` for unknown and missing arguments of a class."""
    constructor: Callable[..., None] = cls.__init__

    @functools.wraps(constructor)
    def checked(self: R, *given: Any, **keywords: Any) -> None:
        try:
            constructor(self, *given, **keywords)
        except TypeError:
            _check_call(cls.__name__, constructor, (), (self, *given), keywords)
            raise

    cls.__init__ = checked  # type: ignore[assignment]
    return cls


def show_fields(cls: type[Any], method: str) -> None:
    """Give a method of ``**changes`` a signature with all fields, for help and completion."""
    parameters = [inspect.Parameter("self", inspect.Parameter.POSITIONAL_OR_KEYWORD)]
    parameters += [
        inspect.Parameter(each.name, inspect.Parameter.KEYWORD_ONLY, default=...,
                          annotation=each.type)
        for each in dataclasses.fields(cls) if each.init
    ]  # fmt: skip
    function = getattr(cls, method)
    returned = inspect.signature(function).return_annotation
    function.__signature__ = inspect.Signature(parameters, return_annotation=returned)


def check_keywords(label: str, given: Iterable[str], known: Iterable[str]) -> None:
    """Raise one error for all names that are not known, with the most similar ones."""
    names = list(known)
    unknown = [name for name in given if name not in names]
    if not unknown:
        return
    others = [ELSEWHERE[label, name] for name in unknown if (label, name) in ELSEWHERE]
    if "chain" in names:
        others += [f"chain.replace({OF_CHAINS[name]}=...)" for name in unknown if name in OF_CHAINS]
    meant = [_meant(name, names) for name in unknown]
    said = " and no argument ".join(map(repr, unknown))
    found = ", ".join(each for each in meant if each)
    hint = f"did you mean {found}?" if found else f"it takes {', '.join(names) or 'no arguments'}"
    hint = f"use {' and '.join(dict.fromkeys(others))}" if others else hint
    if label.startswith("Chain.") and not found and MATERIALS & set(unknown):
        hint += "; Chain.from_materials and Chain.tapered make chains of materials"
    # The `TypeError` of Python says the same.
    raise InputError(f"{label} has no argument {said}; {hint}") from None


def _meant(name: str, known: list[str]) -> str:
    """The known name that an unknown one probably means, or an empty text."""
    near: list[Any] = difflib.get_close_matches(name.lower(), known, n=1, cutoff=NEAR)
    near += [word for word in SYNONYMS.get(name.lower(), ()) if word in known]
    if not near:
        return ""
    half = ", half the diameter" if (name, near[0]) == ("diameter", "radius") else ""
    return f"{near[0]!r}{half}"

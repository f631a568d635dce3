"""Exceptions and warnings.

========================  ====================================================
`InputError`              the input cannot be used; the message states the
                          problem, the value, what is allowed and what to try
                          (the command line exits with code 2)
`SimulationError`         the input is valid, but the run could not finish (exit
                          code 1)
`StoreError`              the input is valid, but the disk is full or a worker
                          process has died (exit code 1)
`ModelRangeWarning`       a theory was evaluated outside its range of validity
`IncompleteWarning`       the run ended before the motion that determines a result
`InputWarning`            the input is valid, but probably a mistake
`DamageWarning`           corrupted files were skipped, as requested
========================  ====================================================
"""

from __future__ import annotations

import difflib
import functools
import numbers
import re
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Final, TypeVar

from .recorded_warnings import is_taken

Value = TypeVar("Value")
# Least similarity of two names, as measured by difflib, for one to be suggested instead of the
# other: "mas" and "masses" are similar enough, "iron" and "bronze" are not.
NEAR: Final = 0.65
# Words that users try, and names that they mean.
OTHER_WORDS: Final = {
    "speed": "velocity", "impulse": "momentum",
    "peak force": "wall_force.peak", "wall force": "wall_force.peak",
    "striker.mass": "struck_by.mass", "striker.velocity": "struck_by.velocity",
    "restitution": "loss.coefficient",
}  # fmt: skip
# Largest number of errors listed in one message.
MAX_LISTED: Final = 20


class ShortTraceback(Exception):
    """An exception whose traceback in IPython has the lines of the user only."""

    def _render_traceback_(self) -> list[str]:
        # IPython calls this method.
        from .short_tracebacks import short_traceback

        return short_traceback(self)


class InputError(ShortTraceback, ValueError):
    """A chain, option or file cannot be used."""


class UnavailableError(InputError, AttributeError):
    """A property that an object does not have: `hasattr` returns False."""


class SimulationError(ShortTraceback, RuntimeError):
    """A run ended without the requested results."""


class StoreError(ShortTraceback, RuntimeError):
    """Results could not be written completely; results written earlier remain valid."""


class ModelRangeWarning(UserWarning):
    """A theory was evaluated outside its range of validity."""


class IncompleteWarning(UserWarning):
    """A result is incomplete: the run ended too early, or points of a sweep failed."""


class InputWarning(UserWarning):
    """The input is valid, but probably a mistake."""


class DamageWarning(UserWarning):
    """Corrupted files of a store or a streamed run were skipped, as requested."""


def unavailable_without(get: Callable[[Any], Value]) -> Callable[[Any], Value]:
    """Raise `UnavailableError` instead of `InputError` in the getter of a property."""

    @functools.wraps(get)
    def checked(self: Any) -> Value:
        try:
            return get(self)
        except InputError as error:
            raise UnavailableError(str(error)) from None

    return checked


def warn_user(message: str, category: type[Warning]) -> None:
    """Warn at the line that called this package."""
    level, frame = 1, sys._getframe()
    while frame.f_back and frame.f_globals.get("__name__", "").partition(".")[0] == "hertzchain":
        level, frame = level + 1, frame.f_back
    if not is_taken(category(message)):
        warnings.warn(message, category, stacklevel=level)


@contextmanager
def errors_at(place: str) -> Iterator[None]:
    """Begin the messages of `InputError` with a place, such as the name of a file.

    Errors of a derived class keep their type and attributes.
    """
    try:
        yield
    except InputError as error:
        if type(error) is InputError:
            raise InputError(f"{place}: {error}") from None
        error.args = (f"{place}: {error}", *error.args[1:])
        raise


def raise_all(problems: Sequence[str], heading: str = "") -> None:
    """Raise one error that lists all problems, if there are any."""
    if len(problems) == 1:
        raise InputError(heading + problems[0])
    if problems:
        lines = [f"{heading}{len(problems)} errors:", *problems[:MAX_LISTED]]
        if len(problems) > MAX_LISTED:
            lines.append(f"and {len(problems) - MAX_LISTED} more")
        raise InputError("\n  ".join(lines))


def short_repr(value: object) -> str:
    """Representation of a value for a message: one short line."""
    try:
        # Quantities are shown by their text, which includes the unit.
        listed = hasattr(value, "tolist") and not hasattr(value, "magnitude")
        text = repr(value.tolist()) if listed else repr(value)  # type: ignore[attr-defined]
        if hasattr(value, "magnitude"):
            text = str(value)
    # If the representation fails, or is nested too deeply, the message must still appear.
    except Exception:  # noqa: BLE001
        text = f"an object of type {type(value).__name__}"
    text = " ".join(text.split())
    return text if len(text) <= 60 else text[:40].rstrip() + "..."


def unknown_name_error(
    what: str, name: object, known: Iterable[str], *, meant: str = "", more: str = ""
) -> InputError:  # fmt: skip
    """Error for an unknown name, with those that it may mean, all known names, and more to do.

    By default, the most similar names may be meant.
    """
    choices = list(known)
    near = meant or similar_names(name, choices)
    hint = f" (did you mean {near}?)" if near else ""
    names = ", ".join(choices)
    return InputError(f"unknown {what} {short_repr(name)}{hint}: choose from {names}{more}")


def similar_names(name: object, choices: Iterable[str]) -> str:
    """Those of the known names that an unknown one may mean, such as ``'radii' or 'radius'``."""
    return alternatives(names_meant(name, choices))


def names_meant(name: object, choices: Iterable[str]) -> list[str]:
    """The same as a list."""
    lower = {choice.lower(): choice for choice in choices}
    asked = name.lower() if isinstance(name, str) else ""
    if (meant := OTHER_WORDS.get(asked)) in lower:
        return [lower[meant]]
    if asked.endswith("@wall"):
        asked = next((each for each in lower if each.startswith("wall") and "peak" in each), asked)
    near = difflib.get_close_matches(asked, lower, n=1, cutoff=NEAR)
    containing = [choice for choice in lower if asked in choice] if len(asked) > 2 else []
    # A part of names, such as "steel" or "plastic", means them, those that begin with it first.
    if not near or (containing and asked not in lower):
        near = sorted(containing, key=lambda choice: not choice.startswith(asked))
    if not near:
        near = [choice for choice in lower if _is_near(asked, choice.partition("-")[0])]
    if not near:
        near = [choice for choice in lower if _abbreviates(asked, choice)]
    return [lower[each] for each in near[:3]]


def alternatives(names: Iterable[str]) -> str:
    """Names that may be meant, such as ``'steel-52100', 'steel-304' or 'steel-316'``."""
    *others, last = [repr(name) for name in names] or [""]
    return f"{', '.join(others)} or {last}" if others else last


def _is_near(asked: str, word: str) -> bool:
    """Whether a misspelled word such as "steal" means the first word of a name, "steel-304"."""
    return difflib.SequenceMatcher(None, word, asked).ratio() > NEAR


def _abbreviates(asked: str, choice: str) -> bool:
    """Whether each part of a name such as "fwd-exp" has letters of that of "forward-exponential".

    They are in this order, from the first one on.
    """
    parts, words = re.split("[-_ ]", asked), choice.split("-")
    if not 1 < len(parts) == len(words):
        return False
    return all(
        part and part[0] == word[0] and all(letter in letters for letter in part)
        for part, word in zip(parts, words, strict=True)
        if (letters := iter(word))
    )


def real_number(what: str, value: object) -> float:
    """Convert a real number to float; booleans and text are rejected."""
    if getattr(value, "ndim", None) == 0 and hasattr(value, "item"):
        value = value.item()  # an array of shape (), such as the result of `max`
    if isinstance(value, numbers.Real) and not isinstance(value, bool):
        try:
            return float(value)
        except OverflowError:
            raise InputError(f"{what} is too large: at most 1.8e308") from None
    raise InputError(f"{what} must be a number, got {short_repr(value)}")

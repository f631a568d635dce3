"""What can go wrong, by whose doing.

========================  ====================================================
`InputError`              the request cannot be met: what, which value, what is
                          allowed, what to try (the command line exits with 2)
`SimulationError`         the request was sound but the run could not finish (exit
                          code 1)
`StoreError`              the request was sound but the disk is full, or a worker
                          has ended (exit code 1)
`ModelRangeWarning`       a number was computed outside a theory's stated range
`IncompleteWarning`       a result is of a motion that had not ended
`InputWarning`            the request is possible, but unlikely to be meant
`DamageWarning`           damaged files were left out, as the caller asked
========================  ====================================================
"""

from __future__ import annotations

import difflib
import numbers
from collections.abc import Iterable
from typing import Final

# How alike two names must be for one to be meant by the other, unless it is a part of it: "mas"
# and "masses" are, "iron" and "bronze" are not.
NEAR: Final = 0.65


class InputError(ValueError):
    """A chain, option or file that cannot be used; raised once, at the border."""


class SimulationError(RuntimeError):
    """A run that ended without the numbers it was asked for."""


class StoreError(RuntimeError):
    """Results that could not be written to their end; what was written before stays good."""


class ModelRangeWarning(UserWarning):
    """A theory was evaluated outside the range in which it is known to hold."""


class IncompleteWarning(UserWarning):
    """A result is incomplete: the run ended before the motion that decides it."""


class InputWarning(UserWarning):
    """What was asked for is possible, but looks like a slip."""


class DamageWarning(UserWarning):
    """Damaged files of a store or a streamed run were left out, as the caller asked."""


def shown(value: object) -> str:
    """A value as an error shows it: in one short line.

    Parameters
    ----------
    value : object
        What was given.

    Returns
    -------
    str

    Examples
    --------
    >>> shown(list(range(99)))
    '[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 1...'
    """
    try:
        # A quantity has a list of its numbers only if it has several; its text has the unit.
        listed = hasattr(value, "tolist") and not hasattr(value, "magnitude")
        text = repr(value.tolist()) if listed else repr(value)  # type: ignore[attr-defined]
        if hasattr(value, "magnitude"):
            text = str(value)
    # An object whose representation fails, or is nested too deeply, must not hide the error.
    except Exception:  # noqa: BLE001
        text = f"an object of type {type(value).__name__}"
    text = " ".join(text.split())
    return text if len(text) <= 60 else text[:40].rstrip() + "..."


def unknown_name(what: str, name: object, known: Iterable[str]) -> InputError:
    """Error for a misspelt name, which says what exists and what is nearest.

    Parameters
    ----------
    what : str
        What kind of name it is.
    name : object
        The name given.
    known : iterable of str
        The names that exist.

    Returns
    -------
    InputError
        To be raised by the caller.

    Examples
    --------
    >>> print(unknown_name("colour", "gren", ["red", "green"]))
    unknown colour 'gren': choose from red, green; did you mean 'green'?
    """
    choices = list(known)
    lower = {choice.lower(): choice for choice in choices}
    asked = name.lower() if isinstance(name, str) else ""
    near = difflib.get_close_matches(asked, lower, n=1, cutoff=NEAR)
    # Part of several names, such as "steel", means any of these.
    parts = [name for name in lower if asked in name] if len(asked) > 2 else []
    near = parts if len(parts) > 1 and asked not in lower else near or parts
    hint = f"; did you mean {' or '.join(repr(lower[each]) for each in near[:3])}?" if near else ""
    return InputError(f"unknown {what} {shown(name)}: choose from {', '.join(choices)}{hint}")


def real_number(what: str, value: object) -> float:
    """A number as given, as a float; not a truth value, text or anything else.

    Parameters
    ----------
    what : str
        What the number is, for the error.
    value : object
        What was given.

    Returns
    -------
    float

    Raises
    ------
    InputError
        If it is not a real number, or too large to be a float.

    Examples
    --------
    >>> real_number("rate", 1)
    1.0
    """
    if getattr(value, "ndim", None) == 0 and hasattr(value, "item"):
        value = value.item()  # an array of one number, such as the largest of others
    if isinstance(value, numbers.Real) and not isinstance(value, bool):
        try:
            return float(value)
        except OverflowError:
            raise InputError(f"{what} is too large: at most 1.8e308") from None
    raise InputError(f"{what} must be a number, got {shown(value)}")

"""Numbers as people give them: lists per bead, single values, quantities with a unit.

A quantity of `pint` (anything with ``to`` and ``magnitude``) is converted here, at the
border, to the plain float in SI that everything else works with.
"""

from __future__ import annotations

import math
import numbers
import operator
import os
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from hertzchain.contacts import Array
from hertzchain.errors import InputError, real_number, shown

# What an index of NumPy can be.
LARGEST: Final = 2**63 - 1


def magnitude(what: str, value: Any, unit: str | None) -> Any:
    """The plain number or numbers of a quantity with a unit; anything else as it is.

    Parameters
    ----------
    what : str
        What the value is, for the error.
    value : object
        A quantity of pint, or a sequence of them, or anything else.
    unit : str or None
        Unit to convert to, in pint's spelling; `None` where quantities have no place.

    Returns
    -------
    object

    Raises
    ------
    InputError
        If the quantity has another dimension, or stands where only scaled numbers may.

    Examples
    --------
    >>> magnitude("gap", 0.1, "m")
    0.1
    """
    if isinstance(value, list | tuple) and any(hasattr(item, "magnitude") for item in value):
        return [magnitude(what, item, unit) for item in value]
    if not (hasattr(value, "magnitude") and hasattr(value, "to")):
        return value
    if unit is None:
        raise InputError(
            f"{what} has a unit ({value}), but the chain is in scaled variables: give plain "
            "numbers, or units='SI'"
        )
    try:
        return value.to(unit).magnitude
    # pint's own errors derive from different classes; whatever it says is the reason.
    except Exception as error:  # noqa: BLE001
        raise InputError(f"{what} must be convertible to {unit}: {error}") from None


def number(
    what: str,
    value: Any,
    *,
    unit: str | None = None,
    above: float = -math.inf,
    least: float = -math.inf,
    below: float = math.inf,
    most: float = math.inf,
    hint: str = "",
) -> float:
    """One finite number within its bounds.

    Parameters
    ----------
    what : str
        What the number is.
    value : float or quantity
        What was given.
    unit : str, optional
        SI unit, if quantities are welcome.
    above, least : float
        Lower bound, excluded or included.
    below, most : float
        Upper bound, excluded or included.
    hint : str
        What to try instead.

    Returns
    -------
    float

    Raises
    ------
    InputError
        If it is no number, not finite or out of its bounds.

    Examples
    --------
    >>> number("ratio", 0.5, above=0.0, most=1.0)
    0.5
    """
    given = real_number(what, magnitude(what, value, unit))
    if above < given < below and least <= given <= most and math.isfinite(given):
        return given
    bounds = [
        f"{text} {bound:g}"
        for text, bound in (("above", above), ("at least", least), ("below", below),
                            ("at most", most))
        if math.isfinite(bound)
    ]  # fmt: skip
    if not (bounds and math.isfinite(given)):
        bounds.append("finite")
    allowed = " and ".join(bounds)
    raise InputError(f"{what} must be {allowed}, got {given:g}{'; ' + hint if hint else ''}")


def whole_number(what: str, value: object, *, least: int, most: int | None = None) -> int:
    """One whole number within its bounds.

    Parameters
    ----------
    what : str
        What the number is.
    value : int
        What was given.
    least, most : int
        Bounds, included; without an upper one, what 63 bits can say.

    Returns
    -------
    int

    Raises
    ------
    InputError
        If it is not whole, or out of its bounds.

    Examples
    --------
    >>> whole_number("cells", 3, least=1)
    3
    """
    try:
        count = least - 1 if isinstance(value, bool) else operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        count = least - 1
    if most is None and count > LARGEST:
        raise InputError(f"{what} is too large: whole numbers have at most 63 bits")
    if count < least or (most is not None and count > most):
        bounds = f"of at least {least}" if most is None else f"from {least} to {most}"
        raise InputError(f"{what} must be a whole number {bounds}, got {shown(value)}")
    return count


def column(
    what: str,
    given: ArrayLike | Any,
    length: int,
    place: str,
    *,
    unit: str | None = None,
    least: float | None = None,
    above: float | None = None,
) -> Array:
    """A read-only array of finite numbers, one for each bead or contact.

    Parameters
    ----------
    what : str
        What they are, in the singular.
    given : array_like
        The numbers; one alone stands for all.
    length : int
        How many there must be.
    place : str
        ``"bead"`` or ``"contact"``: what is counted.
    unit : str, optional
        SI unit, if quantities are welcome.
    least, above : float, optional
        Lower bound, included or excluded.

    Returns
    -------
    ndarray, shape (length,)

    Raises
    ------
    InputError
        If they are no numbers, too few or many, not finite or below the bound.

    Examples
    --------
    >>> column("gap", 0.5, 2, "contact", least=0.0)
    array([0.5, 0.5])
    """
    values = real_numbers(what, magnitude(what, given, unit), place)
    if values.ndim == 0:
        values = np.full(length, values)
    if values.shape != (length,):
        raise InputError(
            f"there must be {length} numbers for the {what}, one for each {place}, "
            f"got {values.size if values.ndim == 1 else f'shape {values.shape}'}"
        )
    checked = values.copy()
    good = np.isfinite(checked)
    allowed = "finite"
    if least is not None:
        good &= checked >= least
        allowed = f"finite and at least {least:g}"
    if above is not None:
        good &= checked > above
        allowed = f"finite and above {above:g}"
    if not good.all():
        k = int(np.argmin(good))
        raise InputError(f"{what} of {place} {k + 1} is {checked[k]:g}: it must be {allowed}")
    checked.setflags(write=False)
    return checked


def real_numbers(what: str, given: ArrayLike | Any, place: str = "entry") -> Array:
    """Real numbers in an array of any shape; no truth values, text or anything else.

    Parameters
    ----------
    what : str
        What they are, in the singular.
    given : array_like
        The numbers.
    place : str
        What they are counted by.

    Returns
    -------
    ndarray

    Raises
    ------
    InputError
        If they are no numbers, or no array; the first of a list that is none is named.

    Examples
    --------
    >>> real_numbers("radius", [1, 0.5], "bead")
    array([1. , 0.5])
    """
    try:
        values = np.asarray(given)
    except (ValueError, TypeError):
        raise InputError(f"{what} must be a list of numbers, got {shown(given)}") from None
    listed = isinstance(given, Sequence) and not isinstance(given, str)
    # Among numbers, NumPy takes truth values for 0 and 1.
    if listed or values.dtype.kind not in "iuf":
        for k, value in enumerate(values.tolist() if values.ndim else []):
            item = given[k] if listed else value  # type: ignore[index]
            if isinstance(item, numbers.Real) and not isinstance(item, bool | np.bool_):
                continue
            if isinstance(item, Sequence | np.ndarray) and not isinstance(item, str):
                continue  # a shape, which is for the caller to judge
            raise InputError(f"{what} of {place} {k + 1} is {shown(item)}: it must be a number")
    try:
        if values.dtype.kind in "iufO" and values.size + values.ndim:
            return values.astype(float)
    except OverflowError:
        raise InputError(f"{what} is too large: at most 1.8e308") from None
    except (TypeError, ValueError):
        pass
    raise InputError(f"{what} must be a list of numbers, got {shown(given)}")


def worker_count(what: str, given: int | None) -> int:
    """So many workers, or one for each processor that this process may use.

    Parameters
    ----------
    what : str
        What they are.
    given : int or None
        How many; `None` leaves it to the machine.

    Returns
    -------
    int

    Raises
    ------
    InputError
        If it is not a whole number, or none.

    Examples
    --------
    >>> worker_count("threads", 2), worker_count("threads", None) >= 1
    (2, True)
    """
    if given is not None:
        return whole_number(what, given, least=1)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1

"""Numbers as people give them: lists per bead, single values, quantities with a unit.

Text with a unit (``"5 mm"``) and quantities of `pint` (anything with ``to`` and ``magnitude``) are
converted here to the plain floats in SI that everything else works with.  Every public argument
that is a number comes through `number`, `whole_number`, `column` or `real_numbers`, so that a unit
is never stripped: it is converted where a dimension is meant, and refused elsewhere.
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
from hertzchain.units import converted, quantity

# What an index of NumPy can be.
LARGEST: Final = 2**63 - 1
# In place of a unit: a variable of a scaled chain, which has none.
SCALED: Final = "scaled"
# Dimensions of an array, at most.
MAX_DEPTH: Final = 32


def has_unit(value: Any) -> bool:
    """Whether a value, or one of a list, carries a unit: text such as "5 mm", or a quantity.

    Parameters
    ----------
    value : object
        What was given.

    Returns
    -------
    bool

    Examples
    --------
    >>> has_unit("5 mm"), has_unit([0.1, "2 um"]), has_unit(0.1)
    (True, True, False)
    """
    if isinstance(value, str):
        return quantity(value) is not None
    if isinstance(value, list | tuple):
        return any(has_unit(item) for item in value if not isinstance(item, float | int))
    if isinstance(value, np.ndarray) and value.dtype.kind in "UTO":
        return has_unit(value.tolist())
    return _is_quantity(value)


def magnitude(what: str, value: Any, unit: str | None, depth: int = 0) -> Any:
    """The plain number or numbers of what carries a unit; anything else as it is.

    Parameters
    ----------
    what : str
        What the value is, for the error.
    value : object
        Text such as ``"5 mm"``, a quantity of pint, a sequence of them, or anything else.
    unit : str or None
        Unit of SI to convert to; `SCALED` in a scaled chain, `None` for what has no dimension.
    depth : int
        Depth of the lists that it stands in.

    Returns
    -------
    object

    Raises
    ------
    InputError
        If the unit has another dimension, or there can be none; or if numbers are masked.

    Examples
    --------
    >>> magnitude("gap", 0.1, "m"), magnitude("gap", "2 um", "m")
    (0.1, 2e-06)
    """
    if type(value) in (float, int):
        return value
    if isinstance(value, str):
        found = quantity(value)
        if found is None:
            return value
        return converted(what, *found, _unit_for(what, value, unit))
    if isinstance(value, np.ndarray) and value.dtype.kind in "UTO":
        value = value.tolist()
    if isinstance(value, list | tuple):
        if depth > MAX_DEPTH or all(type(item) in (float, int) for item in value):
            return value
        return [magnitude(what, item, unit, depth + 1) for item in value]
    if not _is_quantity(value):
        _refuse_masked(what, value)
        return value
    inner = getattr(value, "data", None)
    if not hasattr(value, "magnitude") and hasattr(inner, "magnitude"):
        return magnitude(what, inner, unit, depth)
    if not (hasattr(value, "magnitude") and hasattr(value, "to")):
        raise InputError(
            f"{what} carries a unit of another package than pint ({shown(value)}): give plain "
            "numbers in SI, or a quantity of pint"
        )
    try:
        plain = value.to("" if unit in (None, SCALED) else unit).magnitude
    # pint's own errors derive from different classes; whatever it says is the reason.
    except Exception as error:  # noqa: BLE001
        _unit_for(what, value, unit)
        raise InputError(f"{what} must be convertible to {unit}: {error}") from None
    _refuse_masked(what, plain)
    return plain


def _is_quantity(value: Any) -> bool:
    """Whether it carries a unit: of pint, in an array of xarray, or of another package."""
    if hasattr(value, "magnitude") or hasattr(getattr(value, "data", None), "magnitude"):
        return True
    return isinstance(value, np.ndarray) and (hasattr(value, "unit") or hasattr(value, "units"))


def _unit_for(what: str, value: Any, unit: str | None) -> str:
    """The unit to convert to, if a quantity can be meant at all."""
    if unit == SCALED:
        raise InputError(
            f"{what} has a unit ({shown(value)}), but the chain is in scaled variables: give "
            "plain numbers, or make a chain in SI units"
        )
    if unit is None:
        raise InputError(f"{what} has a unit ({shown(value)}), but it must be a plain number")
    return unit


def _refuse_masked(what: str, value: Any) -> None:
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        raise InputError(
            f"{what} has masked entries, which are no numbers: leave them out (`compressed()`) or "
            "fill them (`filled(value)`)"
        )


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
        Unit of SI, if the number may have one; `SCALED` in a scaled chain.
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
    _refuse_masked(what, value)
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
        Unit of SI, if the numbers may have one; `SCALED` in a scaled chain.
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
    values = real_numbers(what, given, place, unit=unit)
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


def real_numbers(
    what: str, given: ArrayLike | Any, place: str = "entry", *, unit: str | None = None
) -> Array:
    """Real numbers in an array of any shape; no truth values, text or anything else.

    Parameters
    ----------
    what : str
        What they are, in the singular.
    given : array_like
        The numbers.
    place : str
        What they are counted by.
    unit : str, optional
        Unit of SI, if the numbers may have one; `SCALED` in a scaled chain.

    Returns
    -------
    ndarray

    Raises
    ------
    InputError
        If they are no numbers, or no array; the first of a list that is none is named.  Or if
        they have a unit that does not belong there.

    Examples
    --------
    >>> real_numbers("radius", [1, 0.5], "bead")
    array([1. , 0.5])
    """
    given = magnitude(what, given, unit)
    try:
        values = np.asarray(given)
    except (ValueError, TypeError):
        raise InputError(f"{what} must be a list of numbers, got {shown(given)}") from None
    listed = isinstance(given, Sequence) and not isinstance(given, str)
    # Among numbers, NumPy takes truth values for 0 and 1.
    if listed or values.dtype.kind not in "iuf":
        for k, value in enumerate(values.tolist() if values.ndim else []):
            item = given[k] if listed else value
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

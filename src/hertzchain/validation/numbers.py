"""Check numbers and arrays and convert units to SI.

Text with a unit (``"5 mm"``) and quantities of `pint` (anything with ``to`` and ``magnitude``) are
converted to floats in SI; all other modules work with these.  Every numeric public argument passes
through `number`, `whole_number`, `per_bead_array`, `bounded_numbers` or `real_numbers`.  A unit is
therefore never dropped silently: it is converted if the argument has a dimension, and rejected
otherwise.
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

from ..collision import Array
from ..errors import InputError, real_number, short_repr
from ..units import PERCENT, comma_advice, converted, quantity

# Largest index of a NumPy array.
MAX_INDEX: Final = 2**63 - 1
# Takes the place of the unit for a variable of a scaled chain, which must have none.
SCALED: Final = "scaled"
# Takes the place of the unit for numbers without a dimension that may be percentages, "5%".
FRACTION: Final = ""
# Names of arguments with one value for each bead or contact.
PLURALS: Final = {"gap": "gaps", "mass": "masses", "velocity": "velocities"}
# Largest number of dimensions of an array.
MAX_DEPTH: Final = 32


def has_unit(value: Any) -> bool:
    """Whether a value, or an item of a list, has a unit: text such as "5 mm", or a quantity."""
    if isinstance(value, str):
        found = quantity(value)
        return found is not None and found[1] != PERCENT
    if isinstance(value, list | tuple):
        return any(has_unit(item) for item in value if not isinstance(item, float | int))
    if isinstance(value, np.ndarray) and value.dtype.kind in "UTO":
        return has_unit(value.tolist())
    return _is_quantity(value)


def is_word(value: Any) -> bool:
    """Whether a value is text other than a number with or without a unit, or a decimal comma."""
    if not isinstance(value, str) or quantity(value) is not None or comma_advice(value):
        return False
    try:
        float(value)
    except ValueError:
        return True
    return False


def plain_magnitude(what: str, value: Any, unit: str | None, depth: int = 0) -> Any:
    """Convert a value with a unit to plain numbers; return any other value unchanged."""
    if type(value) in (float, int) or (type(value) is np.ndarray and value.dtype.kind in "iuf"):
        return value
    if isinstance(value, str):
        found = quantity(value)
        if found is None:
            _reject_bare_number(what, value, unit)
            if unit == FRACTION:
                raise InputError(
                    f"{what} must be a number or a percentage such as '5%', got "
                    f"{short_repr(value)}{comma_advice(value)}"
                )
            return value
        if found[1] == PERCENT and unit in (None, SCALED):
            plain = converted(what, *found, FRACTION)
            raise InputError(f"{what} must not be a percentage, got {value!r}; write {plain:g}")
        return converted(what, *found, _unit_for(what, value, unit))
    if isinstance(value, np.ndarray) and value.dtype.kind in "UTO":
        value = value.tolist()
    if isinstance(value, list | tuple):
        if depth > MAX_DEPTH or all(type(item) in (float, int) for item in value):
            return value
        return [plain_magnitude(what, item, unit, depth + 1) for item in value]
    if not _is_quantity(value):
        _reject_masked(what, value)
        return value
    inner = getattr(value, "data", None)
    if not hasattr(value, "magnitude") and hasattr(inner, "magnitude"):
        return plain_magnitude(what, inner, unit, depth)
    if not (hasattr(value, "magnitude") and hasattr(value, "to")):
        raise InputError(
            f"{what} has a unit of a package other than pint ({short_repr(value)}); give plain "
            "numbers in SI or a pint quantity"
        )
    try:
        plain = value.to("" if unit in (None, SCALED) else unit).magnitude
    # The exceptions of pint have no common base class; the message quotes them.
    except Exception as error:  # noqa: BLE001
        needed = _unit_for(what, value, unit) or "a plain number"
        raise InputError(f"{what} must be convertible to {needed}: {error}") from None
    _reject_masked(what, plain)
    return plain


def _reject_bare_number(what: str, text: str, unit: str | None) -> None:
    """Reject text that is a number without the unit that text must have."""
    try:
        given = float(text)
    except ValueError:
        return
    if unit == FRACTION and 1.0 <= given < math.inf:
        raise InputError(
            f"{what} {text!r} is text; give '{text.strip()}%' for a percentage, or a number "
            "without quotes"
        )
    if unit in (None, FRACTION, SCALED):
        raise InputError(f"{what} {text!r} is text; give the number {text.strip()} without quotes")
    raise InputError(
        f"{what} is {text!r}, without a unit; write '{text.strip()} {_usual(unit)}' or another "
        "unit, or a number without quotes in SI units"
    )


def _usual(unit: str | None) -> str:
    """Unit of an example; sizes of beads are usually given in millimetres."""
    return "mm" if unit == "m" else str(unit).replace("**", "^")


def _is_quantity(value: Any) -> bool:
    """Whether a value has a unit: of pint, within an xarray array, or of another package."""
    if hasattr(value, "magnitude") or hasattr(getattr(value, "data", None), "magnitude"):
        return True
    return isinstance(value, np.ndarray) and (hasattr(value, "unit") or hasattr(value, "units"))


def _unit_for(what: str, value: Any, unit: str | None) -> str:
    """The unit to convert to; raises an error if the argument cannot have a unit."""
    if unit == SCALED:
        raise InputError(
            f"{what} has a unit ({short_repr(value)}), but the chain is in scaled variables; give "
            "plain numbers or build a chain in SI units"
        )
    if unit is None:
        raise InputError(f"{what} has a unit ({short_repr(value)}), but it must be a plain number")
    return unit


def _reject_masked(what: str, value: Any) -> None:
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        raise InputError(
            f"{what} has masked entries; remove them (`compressed()`) or replace them "
            "(`filled(value)`)"
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
    """Check that a value is a finite number within its bounds."""
    plain = plain_magnitude(what, value, unit)
    if isinstance(plain, str):
        no_unit = unit in (None, "", SCALED)
        with_unit = "" if no_unit else f", or text with a unit such as '5 {_usual(unit)}'"
        advice = comma_advice(value, si="" if unit in (None, SCALED) else unit)
        raise InputError(f"{what} must be a number{with_unit}, got {short_repr(value)}{advice}")
    given = plain if type(plain) is float else real_number(what, plain)
    if above < given < below and least <= given <= most and math.isfinite(given):
        return given
    percent = isinstance(value, str) and value.rstrip().endswith("%")
    bounds = [
        f"{text} {100.0 * bound:g}%" if percent else f"{text} {bound:g}"
        for text, bound in (("above", above), ("at least", least), ("below", below),
                            ("at most", most))
        if math.isfinite(bound)
    ]  # fmt: skip
    if not (bounds and math.isfinite(given)):
        bounds.append("finite")
    allowed = " and ".join(bounds)
    typed = _as_typed(value, given)
    raise InputError(f"{what} must be {allowed}, got {typed}{'; ' + hint if hint else ''}")


def _as_typed(value: Any, given: float) -> str:
    """A number for a message; text is shown as it was typed."""
    return repr(value) if isinstance(value, str) else f"{given:g}"


def contact_number(value: object, beads: int, what: str = "contact") -> int:
    """Check the number of a contact of a chain, walls included."""
    return whole_number(
        what, value, least=0, most=beads, meaning=f", where 0 and {beads} are walls"
    )


def whole_number(
    what: str, value: object, *, least: int, most: int | None = None, meaning: str = ""
) -> int:
    """Check that a value is a whole number within its bounds, whose meaning can be stated."""
    _reject_masked(what, value)
    try:
        count = least - 1 if isinstance(value, bool) else operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        count = least - 1
    if most is None and count > MAX_INDEX:
        raise InputError(f"{what} is too large; whole numbers have at most 63 bits")
    if count < least or (most is not None and count > most):
        bounds = f"of at least {least}" if most is None else f"from {least} to {most}{meaning}"
        near = isinstance(value, float) and least <= value <= (MAX_INDEX if most is None else most)
        hint = whole_hint(value) if near else ""
        raise InputError(f"{what} must be a whole number {bounds}, got {short_repr(value)}{hint}")
    return count


def whole_hint(value: object) -> str:
    """How to write a float that is whole, which Python and NumPy do not accept as a count."""
    whole = isinstance(value, float) and value.is_integer()
    return f"; write {value:.0f}" if whole else ""


def per_bead_array(
    what: str,
    given: ArrayLike | Any,
    length: int,
    place: str,
    *,
    unit: str | None = None,
    least: float | None = None,
    above: float | None = None,
    counted: str = "",
) -> Array:
    """Check values per bead or contact and return them as a read-only array.

    ``counted`` states in words which places count.
    """
    values = real_numbers(what, given, place, unit=unit)
    if values.ndim == 0:
        values = np.full(length, values)
    if values.shape != (length,):
        raise InputError(
            f"there must be {length} numbers for the {PLURALS.get(what, what)}, one for each "
            f"{place}{counted}, "
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
        typed = given if isinstance(given, str) else None
        typed = given[k] if isinstance(given, list | tuple) else typed
        raise InputError(
            f"{what} of {place} {k + 1} is {_as_typed(typed, checked[k])}: it must be {allowed}"
        )
    checked.setflags(write=False)
    return checked


def real_numbers(
    what: str, given: ArrayLike | Any, place: str = "entry", *, unit: str | None = None
) -> Array:
    """Convert real numbers to an array of any shape; booleans and text are rejected."""
    given = plain_magnitude(what, given, unit)
    try:
        values = np.asarray(given)
    except (ValueError, TypeError):
        raise InputError(f"{what} must be a list of numbers, got {short_repr(given)}") from None
    # NumPy converts None to NaN.
    if values.dtype.kind == "O" and values.ndim == 0 and not isinstance(given, numbers.Real):
        raise InputError(f"{what} must be a number or a list of numbers, got {short_repr(given)}")
    listed = isinstance(given, Sequence) and not isinstance(given, str)
    # NumPy converts booleans in a list of numbers to 0 and 1.
    if listed or values.dtype.kind not in "iuf":
        for k, value in enumerate(values.tolist() if values.ndim else []):
            item = given[k] if listed else value
            if isinstance(item, numbers.Real) and not isinstance(item, bool | np.bool_):
                continue
            if isinstance(item, Sequence | np.ndarray) and not isinstance(item, str):
                continue  # callers check the shape
            raise InputError(
                f"{what} of {place} {k + 1} is {short_repr(item)}: it must be a number"
                f"{comma_advice(item)}"
            )
    try:
        if values.dtype.kind in "iufO" and values.size + values.ndim:
            return values.astype(float)
    except OverflowError:
        raise InputError(f"{what} is too large: at most 1.8e308") from None
    except (TypeError, ValueError):
        pass
    raise InputError(
        f"{what} must be a list of numbers, got {short_repr(given)}{comma_advice(given)}"
    )


def bounded_numbers(
    what: str,
    given: ArrayLike | Any,
    *,
    unit: str | None = None,
    above: float = -math.inf,
    least: float = -math.inf,
    most: float = math.inf,
) -> Array:
    """Convert finite real numbers within their bounds to an array of any shape."""
    values = real_numbers(what, given, unit=unit)
    good = np.isfinite(values) & (values > above) & (values >= least) & (values <= most)
    if not good.all():
        bounds = (("above", above), ("at least", least), ("at most", most))
        limits = [f" and {text} {bound:g}" for text, bound in bounds if math.isfinite(bound)]
        worst = float(values.flat[int(np.argmin(good))])
        raise InputError(f"{what} must be finite{''.join(limits)}, got {worst:g}")
    return values


def worker_count(what: str, given: int | None) -> int:
    """Check a number of workers; the default is one per processor of this process."""
    if given is not None:
        return whole_number(what, given, least=1)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1

"""Values of parameters with errors and units, as text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..chain.description import unit_of_stiffness
from ..collision import HERTZ_EXPONENT
from ..representation import IN_VOLTS, usual_unit, with_error
from ..traces.headers import GAIN_UNITS
from ..traces.traces import Traces
from .parameters import Parameter, kind_and_value

# Values and errors of times, lengths and moduli are shown in these units.
SHOWN: Final[Mapping[str, tuple[float, str]]] = {
    "s": (1e6, "us"),
    "m": (1e6, "um"),
    "Pa": (1e-9, "GPa"),
}
# Exponents of contacts, by the units of stiffness that have usual multiples.
STIFFNESS: Final[Mapping[str, float]] = {"N/m": 1.0, "N/m^1.5": HERTZ_EXPONENT}
# Values at a bound, in the unit shown, that are zero.
NEARLY_ZERO: Final = 1e-6
# Ratio from which values are compared by their ratio instead of a difference in percent, and the
# smallest that has a meaning.
FACTOR, NO_AGREEMENT = 2.0, 1e-6


def shown_value(
    parameter: Parameter,
    traces: Traces,
    value: float,
    sigma: float,
    *,
    at_bound: bool,
    digits: int = 2,
) -> str:
    """Value, error and unit of a parameter; ``digits`` are those of a value without an error."""
    unit = unit_of_parameter(parameter, traces)
    if 0.0 < sigma < np.inf and not at_bound:
        return shown_with_error(value, sigma, unit)
    factor, unit = factor_and_unit(value, unit)
    # A value near its bound 0 is zero, and one without an error has no meaning.
    if at_bound and abs(factor * value) < NEARLY_ZERO:
        return "0 (at its bound)"
    if not at_bound:
        shown = float(f"{factor * value:.{digits}g}")
        return f"{shown:g} {unit}".rstrip() + " (not determined)"
    return f"{factor * value:.5g} {unit}".rstrip() + " (at its bound)"


def shown_with_error(value: float, sigma: float, unit: str) -> str:
    """Value and error with their unit; times in us, lengths in um, moduli in GPa, small V in mV."""
    factor, unit = factor_and_unit(max(abs(value), sigma), unit)
    return f"{with_error(factor * value, factor * sigma)} {unit}".rstrip()


def factor_and_unit(value: float, unit: str) -> tuple[float, str]:
    """Factor and unit in which a value of a parameter is shown."""
    if unit in STIFFNESS:
        return unit_of_stiffness(value, STIFFNESS[unit])
    return usual_unit(value, unit) if unit in IN_VOLTS else SHOWN.get(unit, (1.0, unit))


def unit_of_parameter(parameter: Parameter, traces: Traces) -> str:
    """Unit of a parameter; gains and offsets have that of their signals, if it is one."""
    name = parameter.name
    signals = [signal for _, signal in traces if not name.item or signal.name == name.item]
    if name.key == "gain":
        units = {GAIN_UNITS[each.place.quantity] for each in signals if not each.calibrated}
    else:
        units = {each.unit for each in signals} if name.key == "offset" else set()
    return units.pop() if len(units) == 1 else parameter.kind.unit


def shown_size(
    parameter: Parameter, traces: Traces, chains: Sequence[Chain], value: float, sigma: float
) -> str:
    """Diameter or mass of a ball in usual units, and its difference from the nominal one.

    It is empty for other parameters.
    """
    key = parameter.name.key.removeprefix("struck_by.")
    if key not in ("radius", "mass") or not 0.0 < sigma < np.inf:
        return ""
    _, nominal = kind_and_value(parameter.name, traces, chains)
    percent = with_error(100.0 * (value / nominal - 1.0), 100.0 * sigma / nominal)
    sign = "" if percent.startswith("-") else "+"
    what, factor, unit = ("diameter ", 2e3, "mm") if key == "radius" else ("", 1e3, "g")
    return (
        f": {what}{with_error(factor * value, factor * sigma)} {unit}, {sign}{percent}% "
        f"from {factor * nominal:.6g} {unit}"
    )


def shown_difference(ratio: float) -> str:
    """Relative difference of a value from another one; beyond a factor of 2, their ratio."""
    if ratio < 0.0:
        return "opposite sign"
    return f"{ratio - 1.0:+z.1%}" if 1.0 / FACTOR < ratio < FACTOR else _times(ratio)


def _times(ratio: float) -> str:
    """A ratio in words, unless it only states that one of two signals vanishes."""
    if not NO_AGREEMENT < ratio < 1.0 / NO_AGREEMENT:
        return "no agreement"
    return shown_ratio(ratio)


def shown_ratio(ratio: float) -> str:
    """A ratio as a factor, such as ``1010 times``."""
    return f"{ratio:.3g} times" if ratio < 999.0 else f"{ratio:.0f} times"


def shown_part(ratio: float) -> str:
    """A ratio in percent; beyond a factor of 2, as a factor."""
    return f"{ratio:.1%}" if ratio < FACTOR else _times(ratio)

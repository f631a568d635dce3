"""Values of parameters with errors and units, as text."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from .parameters import Parameter
from .traces import Traces

# Values and errors of times and lengths are shown in these units.
SHOWN: Final[Mapping[str, tuple[float, str]]] = {"s": (1e6, "us"), "m": (1e6, "um")}


def shown_value(
    parameter: Parameter, traces: Traces, value: float, sigma: float, *, at_bound: bool
) -> str:
    """Value, error and unit of a parameter."""
    factor, unit = SHOWN.get(unit := _unit(parameter, traces), (1.0, unit))
    if at_bound:
        error = "(at its bound)"
    elif 0.0 < sigma < np.inf:
        error = f"+- {factor * sigma:.2g}"
    else:
        error = "(not determined)"
    return " ".join(filter(None, (_rounded(factor * value, factor * sigma), error, unit)))


def _unit(parameter: Parameter, traces: Traces) -> str:
    """Unit of a parameter; gains and offsets have that of their signals, if it is one."""
    name = parameter.name
    signals = [signal for _, signal in traces if not name.item or signal.name == name.item]
    if name.key == "gain" and not all(signal.calibrated for signal in signals):
        return "V/N"
    units = {signal.unit for signal in signals}
    if name.key == "offset" and len(units) == 1:
        return units.pop()
    return parameter.kind.unit


def _rounded(value: float, error: float) -> str:
    """A value with two digits beyond the first of its error."""
    if not np.isfinite(error) or error <= 0.0 or value == 0.0:
        return f"{value:.5g}"
    digits = int(np.floor(np.log10(abs(value))) - np.floor(np.log10(error))) + 2
    return f"{value:.{min(max(digits, 3), 12)}g}"

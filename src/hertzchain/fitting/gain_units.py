"""Gains of sensors in text with a unit, such as ``10 mV/N``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from ..errors import InputError, short_repr
from ..traces.headers import GAIN_UNITS, UNITS
from ..traces.traces import Traces
from ..units import PERCENT, quantity, volts_per

EXAMPLES: Final = {"force": "V/N or mV/N", "velocity": "V s/m or mV s/m"}


def gains_in_si(what: str, given: Any, sensor: str, traces: Traces) -> Any:
    """Numbers in V/N or V s/m for text with a unit; other values are returned as they are.

    ``given`` is the gain of a sensor, all of them without a name, or a list of gains.
    """
    if isinstance(given, Sequence) and not isinstance(given, str):
        return [_gain(what, each, sensor, traces) for each in given]
    return _gain(what, given, sensor, traces)


def _gain(what: str, given: Any, sensor: str, traces: Traces) -> Any:
    if not isinstance(given, str) or not _has_unit(given):
        return given
    signals = [signal for _, signal in traces if not sensor or signal.name == sensor]
    known = next((signal for signal in signals if signal.calibrated), None)
    if known is not None:
        raise InputError(
            f"{what} must be a plain number, because {known.name} is in {known.unit}, got "
            f"{given!r}; if its signal is in V, name it '{known.name} [V]'"
        )
    kinds = {signal.place.quantity for signal in signals}
    values = {volts_per(given, UNITS[kind]) for kind in kinds}
    if len(values) != 1 or None in values:
        units = " and ".join(EXAMPLES[kind] for kind in GAIN_UNITS if kind in kinds)
        raise InputError(f"{what} must have a unit such as {units}, got {short_repr(given)}")
    return values.pop()


def _has_unit(text: str) -> bool:
    """Whether text is a number with a unit other than %."""
    found = quantity(text.replace("(", "").replace(")", ""))
    return found is not None and found[1] != PERCENT

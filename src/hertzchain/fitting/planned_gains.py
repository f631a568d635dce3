"""Planned sensors whose noise is given in N or m/s, and whose gains have a unit such as mV/N."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from ..errors import InputError
from ..representation import shown_signal
from ..traces.headers import UNITS
from ..traces.signals import Signal
from ..traces.traces import Traces
from ..units import volts_per
from ..validation.objects import check_list
from .names import Name, parse_name
from .settings import Settings

# Advice on a noise in N of a sensor whose signal is given in V.
CONVERTED: Final = (
    "; a gain with a unit, such as a prior of 20 mV/N, converts a noise in N if the sensor is "
    "named without [V]"
)


def recorded_in_volts(traces: Traces, settings: Settings) -> tuple[Traces, tuple[str, ...]]:
    """Traces in V for sensors whose free gain is in V per unit, and sentences on their noise.

    Such a sensor records volts, so its noise in N or m/s is that of the signal over the gain.
    """
    (shot,) = traces.shots
    signals, notes = [], []
    for signal in shot.signals:
        gain = _gain(signal, settings) if signal.calibrated else None
        if gain is None:
            signals.append(signal)
            continue
        noise = gain * signal.noise
        signals.append(replace(signal, unit="V", noise=noise))
        notes.append(
            f"{signal.name} is recorded in V, because its gain is in V: a noise of "
            f"{shown_signal(signal.noise, signal.unit)} is one of {shown_signal(noise, 'V')}"
        )
    return Traces((replace(shot, signals=tuple(signals)),)), tuple(notes)


def _gain(signal: Signal, settings: Settings) -> float | None:
    """Size of the gain in V per unit, if it is given with a unit, and free."""
    free = None if settings.free is None else check_list("free", settings.free, "names")
    if free is not None and not any(_is_gain_of(each, signal) for each in free):
        return None
    for text, given in {**_means(settings.priors), **settings.start}.items():
        if isinstance(given, str) and _is_gain_of(text, signal):
            gain = volts_per(given, UNITS[signal.place.quantity])
            if gain:
                return abs(gain)
    return None


def _means(priors: Mapping[str, Any]) -> dict[str, Any]:
    """Values of priors without their standard deviations."""
    return {
        text: given[0]
        for text, given in priors.items()
        if isinstance(given, Sequence) and not isinstance(given, str) and len(given)
    }


def _is_gain_of(text: Any, signal: Signal) -> bool:
    """Whether text names the gain of a sensor, alone or with those of others."""
    try:
        name: Name = parse_name(text)
    except InputError:
        return False  # reported with the free parameters
    return name.key == "gain" and name.item in ("", "*", signal.name)

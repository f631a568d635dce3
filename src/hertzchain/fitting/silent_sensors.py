"""Sensors whose data contain no pulse, and the parameters that these data cannot determine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from ..representation import listed
from ..traces.traces import Traces
from .arrival_notes import has_pulse
from .parameters import Parameter

# Parameters that only the pulse of a sensor determines.
OF_PULSES: Final = ("gain", "delay")
# A gain below this number of standard errors is that of a signal without a pulse.
LEAST: Final = 5.0


def silent_sensors(traces: Traces) -> list[str]:
    """Sensors without a pulse above their noise in a shot."""
    return [*dict.fromkeys(signal.name for _, signal in traces if not has_pulse(signal))]


def undetermined(
    parameters: Sequence[Parameter], traces: Traces, values: Mapping[str, float],
    errors: Mapping[str, float],
) -> tuple[str, ...]:  # fmt: skip
    """Gains and delays of single sensors whose data contain no pulse.

    A pulse that no sample shows clearly can still determine a gain.
    """
    found = []
    for each in parameters:
        own = [
            signal
            for shot, signal in traces
            if signal.name == each.name.item and each.name.shot in ("", str(shot + 1))
        ]
        if each.name.key not in OF_PULSES or not own or any(map(has_pulse, own)):
            continue
        name = str(each)
        clear = np.isfinite(errors[name]) and abs(values[name]) > LEAST * errors[name]
        if each.prior is None and not (each.name.key == "gain" and clear):
            found.append(name)
    return tuple(found)


def silent_clause(traces: Traces, names: Sequence[str]) -> str:
    """A sentence on sensors without a pulse, and on the parameters that need it; may be empty."""
    silent = silent_sensors(traces)
    if not silent:
        return ""
    if not names:
        # Many samples together, or a prior, determine what no sample shows.
        return f". No single sample of {listed(silent)} clearly exceeds its noise"
    text = f". The data of {listed(silent)} have no pulse above their noise"
    return f"{text}, so {listed([*names])} {'is' if len(names) == 1 else 'are'} not determined"

"""AC and DC coupling: whether the signal of a sensor contains the static force.

A piezoelectric sensor, or a channel with AC coupling, shows 0 before the pulse even in a
precompressed chain.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ..chain.chain import Chain
from ..errors import InputError
from ..representation import listed
from .amplitudes import CERTAIN, error_of_level
from .places import Place
from .signals import Signal
from .traces import Traces, mapped

# Ratio of the signal of a sensor in a shot to the force.
Gain = Callable[[int, Signal], float]


def resolved_coupling(traces: Traces, chains: Sequence[Chain], gain: Gain) -> Traces:
    """Traces in which sensors with a static force have a coupling: by default, as their level.

    Sensors whose level is too uncertain are like the others of their shot if these all have DC
    coupling, and have AC coupling otherwise.
    """
    shown: dict[int, set[str]] = {}

    def of_level(shot: int, signal: Signal) -> Signal:
        if signal.coupling:
            return signal
        static = static_force(signal.place, chains[shot])
        if not static:
            return signal
        found = _shown_coupling(signal, gain(shot, signal) * static)
        shown.setdefault(shot, set()).add(found)
        return replace(signal, coupling=found)

    def of_others(shot: int, signal: Signal) -> Signal:
        if signal.coupling or not static_force(signal.place, chains[shot]):
            return signal
        return replace(signal, coupling="DC" if shown[shot] - {""} == {"DC"} else "AC")

    return mapped(mapped(traces, of_level), of_others)


def _shown_coupling(signal: Signal, expected: float) -> str:
    """The coupling whose level is nearer to that before the pulse; empty if neither is clear."""
    if not np.isfinite(signal.level):
        return "DC"
    if not _can_be_seen(signal, expected):
        return ""
    return "AC" if abs(signal.level) < 0.5 * abs(expected) else "DC"


def _can_be_seen(signal: Signal, expected: float) -> bool:
    """Whether a level before the pulse exceeds its error; false for one that is not known."""
    return len(signal.quiet_values) > 0 and abs(expected) > CERTAIN * error_of_level(signal)


def static_force(place: Place, chain: Chain) -> float:
    """Static force at a sensor [N]; 0 for a velocity."""
    forces = chain.static_state.forces
    if place.quantity != "force" or not forces.any():
        return 0.0
    try:
        bead = place.bead(chain)
    except InputError:
        return 0.0  # The model reports sensors that the chain does not have.
    if place.body in ("left", "right"):
        return float(forces[0 if place.body == "left" else -1])
    return float(0.5 * (forces[bead - 1] + forces[bead]))


def coupling_notes(traces: Traces, chains: Sequence[Chain], gain: Gain) -> tuple[str, ...]:
    """Notes on sensors whose signal does not contain the static force."""
    found: dict[str, float] = {}
    hidden: dict[str, None] = {}
    for index, signal in traces:
        static = static_force(signal.place, chains[index])
        if signal.coupling == "AC" and abs(static) > 0.0:
            found.setdefault(signal.name, static)
            if not _can_be_seen(signal, gain(index, signal) * static):
                hidden.setdefault(signal.name)
    if not found:
        return ()
    forces = dict.fromkeys(f"{each:.3g}" for each in found.values())
    unclear = f"; the level of {listed([*hidden])} is too uncertain to show it" if hidden else ""
    return (
        f"AC coupling of {', '.join(found)}: the signal does not contain the static force of "
        f'{listed([*forces])} N{unclear}; if it does, set coupling = "DC"',
    )

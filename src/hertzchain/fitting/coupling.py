"""AC and DC coupling: whether the signal of a sensor contains the static force.

A piezoelectric sensor, or a channel with AC coupling, shows 0 before the pulse even in a
precompressed chain.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..errors import InputError
from ..representation import listed
from .places import Place
from .signals import Signal
from .traces import Traces, with_couplings

# A static force matters if it exceeds this multiple of the noise.
NOTICED: Final = 5.0
# A voltage before the pulse below this fraction of the range of the signal shows no static force.
NO_LEVEL: Final = 0.02


def resolved_coupling(traces: Traces, chains: Sequence[Chain]) -> Traces:
    """Traces in which all sensors have a coupling: by default, that which their level shows."""

    def choose(shot: int, signal: Signal) -> str:
        if signal.coupling:
            return signal.coupling
        return "AC" if _shows_no_static_force(signal, chains[shot]) else "DC"

    return with_couplings(traces, choose)


def _shows_no_static_force(signal: Signal, chain: Chain) -> bool:
    """Whether the level before the pulse is nearer to zero than to the static force."""
    static = static_force(signal.place, chain)
    if static == 0.0 or not np.isfinite(signal.level):
        return False
    if not signal.calibrated:
        seen = signal.values[np.isfinite(signal.values)]
        return abs(signal.level) < max(NO_LEVEL * float(np.ptp(seen)), signal.sigma)
    return abs(static) > NOTICED * signal.sigma and abs(signal.level) < 0.5 * abs(static)


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


def coupling_notes(traces: Traces, chains: Sequence[Chain]) -> tuple[str, ...]:
    """Notes on sensors whose signal does not contain the static force."""
    found: dict[str, float] = {}
    for index, signal in traces:
        static = static_force(signal.place, chains[index])
        if signal.coupling == "AC" and abs(static) > 0.0:
            found.setdefault(signal.name, static)
    if not found:
        return ()
    forces = dict.fromkeys(f"{each:.3g}" for each in found.values())
    return (
        f"AC coupling of {', '.join(found)}: the signal is 0 before the pulse and does not contain "
        f'the static force of {listed([*forces])} N; if it does, set coupling = "DC"',
    )

"""Tapered chains: power laws in chains of growing beads, and energy of hard spheres."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Final, Literal

import numpy as np

from ..chain.chain import Chain
from ..propagation.propagate import propagate
from ..pulse.pulse import Pulse
from ..theory.bca import bca
from ..theory.hard_sphere import hard_sphere_energy_ratio
from .case import Case, shared

HARBOLA = "Harbola et al., PRE 80, 031303 (2009)"
Method = Literal["BCA", "propagate"]
BEADS: Final[dict[Method, int]] = {"BCA": 30_000, "propagate": 3000}


def cases() -> Iterator[Case]:
    """Power laws over the last two thirds of backward linear tapers with S = 0.9."""
    exponents = {"velocity": -1.5, "residence": 1.3, "arrival": 2.3}
    methods: dict[Method, float] = {"BCA": 1e-4, "propagate": 2e-3}
    for method, tolerance in methods.items():
        for quantity, exponent in exponents.items():
            yield Case(
                "tapers", f"{quantity} ~ k^x, backward-linear, {method}", exponent, tolerance,
                f"{HARBOLA}; for large k, here up to {BEADS[method]}",
                partial(_power, method, quantity), "recalled",
            )  # fmt: skip
    ratio = 0.95**3
    energy = (4.0 * ratio / (1.0 + ratio) ** 2) ** 19
    yield Case(
        "tapers", "energy through 20 hard spheres, q = 0.05", energy, 1e-12,
        "two-body collisions: Doney, Sen, PRE 72, 041304 (2005)",
        lambda: hard_sphere_energy_ratio(Chain.from_radii(0.95 ** np.arange(20))),
    )  # fmt: skip


@shared
def _growing(method: Method) -> Pulse:
    chain = Chain.tapered("backward-linear", 0.9, beads=BEADS[method])
    return bca(chain) if method == "BCA" else propagate(chain)


def _power(method: Method, quantity: str) -> float:
    """Slope of ln(quantity) as a function of ln k."""
    beads = np.arange(BEADS[method] // 3, BEADS[method] - 20)
    values = getattr(_growing(method), quantity)[beads - 1]
    return float(np.polyfit(np.log(beads), np.log(values), 1)[0])

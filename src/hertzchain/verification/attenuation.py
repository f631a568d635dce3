"""Attenuation of the wave in equal beads by small losses, in closed form and in simulations."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Final

from ..chain.chain import Chain
from ..chain.laws import Loss
from ..chain.laws.dashpot import Dashpot
from ..chain.laws.restitution import Restitution
from ..chain.laws.unloading_ratio import UnloadingRatio
from ..chain.laws.velocity_power import VelocityPower
from ..chain.laws.viscoelastic import Viscoelastic
from ..chain.laws.walton_braun import WaltonBraun
from ..simulation.simulate import simulate
from ..theory.attenuation import first_order
from ..theory.solitary_wave import solitary_wave
from .case import Case, shared

# Law of a small number x (zeta, w, 1 - K1/K2, A or gamma), and coefficient of -d ln v/dk for
# p = 3/2 and 2.
LAWS: Final[dict[str, tuple[Callable[[float], Loss], float, float]]] = {
    "Restitution": (
        lambda x: Restitution(math.exp(-math.pi * x / math.sqrt(1.0 - x * x))),
        0.7013581944, 1.0439164429,
    ),
    "UnloadingRatio": (UnloadingRatio, 0.1911102755, 0.2250865131),
    "WaltonBraun": (lambda x: WaltonBraun(1.0 - x), 0.1911102755, 0.2250865131),
    "Viscoelastic": (Viscoelastic, 0.6262739552, 1.0786181163),
    "Dashpot": (Dashpot, 0.4803381761, 0.7179053434),
    "VelocityPower, 1.81": (
        lambda x: VelocityPower(x, 1.81), 0.3297389122, 0.5531975846,
    ),
}  # fmt: skip
# Loss of the weakest simulation, and contact at which the decay is read.
LOSS, CONTACT = 2e-4, 40


def cases() -> Iterator[Case]:
    """Coefficients of the decay per bead, from the formula and from simulations."""
    for name, (_, *expected) in LAWS.items():
        for p, value in zip((1.5, 2.0), expected, strict=True):
            yield Case(
                "attenuation", f"{name}, p = {p:g}", value, 2e-10,
                "integrals over the iterated wave", partial(_closed_form, name, p), "computed",
            )  # fmt: skip
            yield Case(
                "attenuation", f"{name}, p = {p:g}, simulated", value, 5e-6 * value,
                "integrals over the iterated wave", partial(_simulated, name, p), "computed",
            )  # fmt: skip


def _closed_form(name: str, p: float) -> float:
    loss = 1e-3
    chain = Chain.uniform(2, exponent=p).replace(loss=LAWS[name][0](loss))
    return float(first_order(chain, 1.0)) / _variable(name, loss, p, 1.0)


def _simulated(name: str, p: float) -> float:
    """Coefficient at zero loss, extrapolated from three losses."""
    found = []
    for factor in (1.0, 2.0, 4.0):
        growth, v = _growth(p, LAWS[name][0](factor * LOSS))
        decay = _growth(p, None)[0] - growth
        found.append(decay / _variable(name, factor * LOSS, p, v))
    return (8.0 * found[0] - 6.0 * found[1] + found[2]) / 3.0


def _variable(name: str, loss: float, p: float, v: float) -> float:
    """The number that the coefficient multiplies: zeta, w, A V, gamma/(m V), gamma v^.81/(m V)."""
    speed = solitary_wave(p).speed_constant * v ** ((p - 1.0) / (p + 1.0))
    factors = {
        "Viscoelastic": speed,
        "Dashpot": 1.0 / speed,
        "VelocityPower, 1.81": v**0.81 / speed,
    }
    return loss * factors.get(name, 1.0)


@shared
def _growth(p: float, loss: Loss | None) -> tuple[float, float]:
    """Change of ln v at a contact, and the velocity there."""
    pulse = simulate(Chain.uniform(60, exponent=p).replace(loss=loss), times=0).pulse()
    before, after = (float(x) for x in pulse.velocity[CONTACT - 1 : CONTACT + 1])
    return math.log(after / before), math.sqrt(before * after)

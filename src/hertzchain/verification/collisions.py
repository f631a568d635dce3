"""Collisions of two beads: duration, and restitution of each loss law."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

from ..chain.chain import Chain
from ..chain.laws import Loss
from ..chain.laws.elastic_plastic import ElasticPlastic
from ..chain.laws.restitution import Restitution
from ..chain.laws.unloading_ratio import UnloadingRatio
from ..chain.laws.viscoelastic import Viscoelastic
from ..chain.laws.walton_braun import WaltonBraun
from ..simulation.simulate import simulate
from .case import TWO_INTEGRATIONS, Case

TSUJI = "Tsuji et al., Powder Technol. 71, 239 (1992)"
SERIES = "Schwager, Poeschel, PRE 57, 650 (1998)"
PADE = "Mueller, Poeschel, PRE 84, 021302 (2011)"
THORNTON = "Thornton, J. Appl. Mech. 64, 383 (1997)"
# Overlap at which the elastic-plastic beads yield, in scaled variables.
YIELD_OVERLAP = 0.2


def cases() -> list[Case]:
    """Cases of this topic."""
    return [*_any_speed(), *_viscoelastic(), *_elastic_plastic()]


def _any_speed() -> Iterator[Case]:
    """Loss laws whose restitution is known at any speed."""
    yield Case(
        "restitution", "duration of a collision, in overlap/speed", 2.943275184, 1e-9, "Hertz",
        _duration,
    )  # fmt: skip
    for e in (0.3, 0.5, 0.7, 0.9):
        for speed in (0.1, 10.0):
            yield Case(
                "restitution", f"Hertz damping, e = {e:g}, at speed {speed:g}", e, 1e-8, TSUJI,
                partial(_restitution, Restitution(e), speed),
            )  # fmt: skip
    for p in (2.0, 3.0):
        for pulls in (True, False):
            name = f"Hertz damping, e = 0.7, p = {p:g}{'' if pulls else ', no attraction'}"
            yield Case(
                "restitution", name, 0.7, 1e-8, "damped oscillator in d^((p + 1)/2)",
                partial(_restitution, Restitution(0.7, attractive=pulls), 0.3, p),
            )  # fmt: skip
    for p in (1.5, 2.0):
        yield Case(
            "restitution", f"unloading ratio w = 0.19, p = {p:g}", 0.9, 1e-8, "e = sqrt(1 - w)",
            partial(_restitution, UnloadingRatio(0.19), 1.0, p),
        )  # fmt: skip
        yield Case(
            "restitution", f"Walton-Braun K1/K2 = 0.49, p = {p:g}", 0.7, 1e-8, "e = sqrt(K1/K2)",
            partial(_restitution, WaltonBraun(0.49), 1.0, p),
        )  # fmt: skip


def _viscoelastic() -> Iterator[Case]:
    r"""Law of Kuwabara and Kono, as a function of :math:`B = \frac32 A (k/\mu)^{2/5} v^{1/5}`."""
    for b in (0.01, 0.015, 0.05, 0.1):
        yield Case(
            "viscoelastic restitution", f"attractive, B = {b:g}, to second order", _series(b),
            0.53 * b**3, f"{SERIES}; next term 0.523 B^3", partial(_kuwabara, b, True),
        )  # fmt: skip
    for b, e in ((0.1, 0.892147587291), (0.2, 0.797550062040)):
        yield Case(
            "viscoelastic restitution", f"attractive, B = {b:g}", e, 1e-9, TWO_INTEGRATIONS,
            partial(_kuwabara, b, True), "computed",
        )  # fmt: skip
    for b, error in ((0.01, 1e-7), (0.1, 5e-5)):
        yield Case(
            "viscoelastic restitution", f"no attraction, B = {b:g}, Pade [1/4]", _pade(b), error,
            f"{PADE}; with a known error of {error:.0e}", partial(_kuwabara, b, False),
            "recalled",
        )  # fmt: skip
    known = {0.1: 0.892858875507, 0.5: 0.595251501135, 1.0: 0.393930603230, 2.0: 0.211646054604}
    for b, e in known.items():
        yield Case(
            "viscoelastic restitution", f"no attraction, B = {b:g}", e, 1e-9, TWO_INTEGRATIONS,
            partial(_kuwabara, b, False), "computed",
        )  # fmt: skip


def _elastic_plastic() -> Iterator[Case]:
    """Spheres with a yield point, as a function of the speed."""
    # Two beads of unit mass and stiffness yield at mu v_y^2/2 = 2/5 d_y^(5/2), mu = 1/2.
    yields_at = math.sqrt(1.6 * YIELD_OVERLAP**2.5)
    for ratio in (0.5, 2.0, 10.0, 100.0):
        yield Case(
            "elastic-plastic restitution", f"at {ratio:g} times the yield speed", _thornton(ratio),
            1e-11, THORNTON, partial(_restitution, ElasticPlastic(yield_overlap=YIELD_OVERLAP),
                                    ratio * yields_at),
        )  # fmt: skip


def _thornton(ratio: float) -> float:
    """Restitution at a ratio of the speed to the yield speed."""
    u = 1.0 / max(ratio, 1.0)
    first = math.sqrt(1.2 * math.sqrt(3.0) * (1.0 - u**2 / 6.0))
    return first * (u / (u + 2.0 * math.sqrt(1.2 - 0.2 * u**2))) ** 0.25


def _duration() -> float:
    pulse = simulate(Chain.uniform(2), times=0).pulse()
    assert pulse.arrival is not None
    assert pulse.peak_overlap is not None
    return float(2.0 * pulse.arrival[1] / pulse.peak_overlap[0])


def _restitution(law: Loss, speed: float, exponent: float = 1.5) -> float:
    chain = Chain.uniform(2, exponent=exponent).replace(loss=law, velocities=[speed, 0.0])
    until = 50.0 * speed ** (-(exponent - 1.0) / (exponent + 1.0))
    left, right = simulate(chain, until=until, times=0).state.velocities
    return float((right - left) / speed)


def _kuwabara(b: float, pulls: bool) -> float:
    """Restitution of two beads of unit mass, stiffness and speed: B = 3/2 A 2^(2/5)."""
    return _restitution(Viscoelastic(b / 1.5 * 0.5**0.4, attractive=pulls), 1.0)


def _series(b: float) -> float:
    """Restitution to second order, 1 - C1 B + (3/5) (C1 B)^2."""
    gamma = math.gamma
    c1 = math.sqrt(math.pi) * gamma(0.6) / (2.0**0.2 * 5.0**0.4 * gamma(2.1))
    return 1.0 - c1 * b + 0.6 * (c1 * b) ** 2


def _pade(b: float) -> float:
    x = math.sqrt(b)
    above = 1.0 + 0.501086 * x
    return above / (above + 1.15345 * x**2 + 0.577977 * x**3 + 0.532178 * x**4)

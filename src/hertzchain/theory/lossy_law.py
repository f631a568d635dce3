r"""The local-rate law with loss: the effect of two laws of loss on the pulse of a taper.

A loss of strength x changes the growth of the velocity at contact k by :math:`x f(s_k, x)`, after a
start and with a memory of previous rates.  `Restitution` and `UnloadingRatio` have no scale of
their own: x is a number that is the same at all contacts.  `tools/loss_tables.py` determines the
functions from simulated pulses.

The momentum that the pulse loses forms a tail behind it.  The tail decays less than the pulse,
and can overtake it; from there on, the law does not apply.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..chain.feature_support import require_supported
from ..chain.laws.base import Loss
from ..chain.laws.restitution import Restitution
from ..chain.laws.unloading_ratio import UnloadingRatio
from ..collision import HERTZ_EXPONENT, Array
from ..errors import InputError, ModelRangeWarning, warn_user
from ..pulse.pulse import Pulse
from .loss_table import RATES, LossTable, inputs, loss_tables

# Momentum of the wave of equal beads in units of m v, first contact at which a tail can form,
# power of the radius with which a long wave decays, and relative velocity of a tail that overtakes.
MOMENTUM, TAIL_START, TAIL_POWER, OVERTAKEN = 1.67, 6, 0.91, 0.3
DOUBTFUL: Final = 0.01
# Contacts on each side that determine a slow rate.
REACH: Final = 8
# Distance from the tables up to which a rate has the loss term of the nearest one.
MARGIN: Final = 0.02
STEPS: Final = np.arange(1.0, REACH + 1.0)
# Limits of the laws, within those of the tables.
MIN_RESTITUTION, MAX_RATIO = 0.9, 0.1
# Laws of the tables: class, whether the force may pull, and largest strength.
LAWS: Final[dict[str, tuple[type[Loss], bool, float]]] = {
    "restitution": (Restitution, True, 0.036),
    "restitution without pull": (Restitution, False, 0.036),
    "unloading ratio": (UnloadingRatio, False, 0.105),
}


def lossy_pulse(chain: Chain, method: str, theory: Callable[[Chain], Pulse]) -> Pulse:
    """The pulse of a scaled chain with loss, from that without loss by a theory of tapers."""
    require_supported(chain, method, supported=("loss",), alternative="use simulate")
    law = chain.contact_losses[1]
    table = _table(chain, law, method)
    pulse = theory(chain.replace(loss=None))
    assert pulse.peak_overlap is not None
    assert pulse.residence is not None
    assert pulse.velocity_error is not None
    rates = slow_rates(np.diff(np.log(chain.radii)))
    _check_rates(chain, rates, method)
    log_velocity = np.log(pulse.velocity)
    x = strength(law)
    effect = table.effect(rates, x)
    decay = np.concatenate(([0.0], np.cumsum(effect[0])))
    parts, relative = error_parts(rates, x, log_velocity + decay)
    _check_tail(chain, law, relative, method)
    error = np.concatenate(([0.0], table.error @ parts))
    if not error.max() <= DOUBTFUL:
        _warn_doubtful(chain, law, error)
    p = chain.exponents
    residence = pulse.residence * np.exp(effect[2] - (p - 1) / (p + 1) * decay[:-1])
    return dataclasses.replace(
        pulse,
        chain=chain,
        velocity=pulse.velocity * np.exp(decay),
        peak_overlap=pulse.peak_overlap * np.exp(effect[1] + 2 / (p + 1) * decay[:-1]),
        residence=residence,
        arrival=np.concatenate(([0.0], np.cumsum(residence))),
        velocity_error=pulse.velocity_error + error,
    )


def _table(chain: Chain, law: Loss, method: str) -> LossTable:
    """The table of a law, after checking that there is one."""
    if chain.exponents != HERTZ_EXPONENT:
        raise InputError(
            f"losses are tabulated for the exponent 3/2 only, got {chain.exponents:g}; use simulate"
        )
    names = [
        name
        for name, (kind, attractive, _) in LAWS.items()
        if type(law) is kind and getattr(law, "attractive", attractive) == attractive
    ]
    if not names:
        raise InputError(
            f"{method} has no tables for {law}, only for Restitution and UnloadingRatio; use "
            f"simulate (chain: {chain.description})"
        )
    if isinstance(law, Restitution) and law.coefficient < MIN_RESTITUTION:
        raise InputError(
            f"{method} requires a restitution coefficient of at least {MIN_RESTITUTION:g}, got "
            f"{law.coefficient:g}; use simulate"
        )
    if isinstance(law, UnloadingRatio) and law.ratio > MAX_RATIO:
        raise InputError(
            f"{method} requires an unloading ratio of at most {MAX_RATIO:g}, got {law.ratio:g}; "
            "use simulate"
        )
    return loss_tables()[names[0]]


def _check_rates(chain: Chain, rates: Array, method: str) -> None:
    """Raise an error for rates far outside the tables."""
    low, high = RATES
    beyond = np.flatnonzero(~((rates >= low - MARGIN) & (rates <= high + MARGIN)))
    if beyond.size:
        k = int(beyond[0])
        raise InputError(
            f"{method} with a loss requires rates ln(R_k+1/R_k) from {low:g} to {high:g}, but that "
            f"of bead {k + 1} is {rates[k]:.3g} (chain: {chain.description}); use simulate"
        )


def _check_tail(chain: Chain, law: Loss, relative: Array, method: str) -> None:
    """Raise an error if the tail overtakes the pulse."""
    overtaken = np.flatnonzero(relative >= OVERTAKEN)
    if overtaken.size:
        bead = int(overtaken[0]) + 2
        raise InputError(
            f"with {law}, the tail behind the pulse overtakes it near bead {bead}, from where "
            f"{method} does not apply (chain: {chain.description}); use simulate, or fewer beads"
        )


def _warn_doubtful(chain: Chain, law: Loss, error: Array) -> None:
    """Issue a warning that states where the estimated error is large."""
    bead = int(np.argmax(~(error <= DOUBTFUL))) + 1
    warn_user(
        f"the effect of {law} on this chain ({chain.description}) has an estimated error above "
        f"{DOUBTFUL:.0%} from bead {bead} on, of {error.max():.1%} at most; use simulate",
        ModelRangeWarning,
    )


def slow_rates(rates: Array) -> Array:
    """Slow part of the rates, a local cubic polynomial.

    The loss term hardly depends on fast changes of the rate, as by scatter.
    """
    padded = np.concatenate((
        rates[0] + STEPS[::-1] * (rates[0] - rates[1]),
        rates,
        rates[-1] + STEPS * (rates[-1] - rates[-2]),
    ))  # fmt: skip
    return np.convolve(padded, _cubic_weights(), "valid")


@functools.cache
def _cubic_weights() -> Array:
    """Weights of neighbouring rates in the value of the local cubic polynomial."""
    offsets = np.arange(-REACH, REACH + 1.0)
    bell = (1.0 - (offsets / (REACH + 1.0)) ** 2) ** 2
    powers = np.vander(offsets, 4, increasing=True)
    fit = np.linalg.solve(powers.T @ (bell[:, np.newaxis] * powers), powers.T * bell)
    return np.asarray(fit[0])


def strength(law: Loss) -> float:
    """Strength of a loss: the damping ratio, or the ratio w of unloading."""
    if isinstance(law, Restitution):
        return law.damping_ratio
    assert isinstance(law, UnloadingRatio)
    return law.ratio


def error_parts(rates: Array, x: float, log_velocity: Array) -> tuple[Array, Array]:
    """Parts of the estimated error behind each contact, and relative velocities of the tail."""
    change = inputs(rates)[1]
    low, high = RATES
    outside = np.maximum(rates - high, 0.0) + np.maximum(low - rates, 0.0)
    relative, old = tail(rates, log_velocity)
    terms = [np.ones(len(rates)), change**2, change**2, old**3, outside]
    parts = x * np.cumsum(terms, axis=1)
    parts[1] = np.sqrt(x * parts[1])
    return parts, relative


def tail(rates: Array, log_velocity: Array) -> tuple[Array, Array]:
    r"""Velocity of the tail relative to that of the pulse, at each contact; and its old part.

    The pulse leaves :math:`-d(1.67\,m v)/dk` of its momentum in each bead.  The tail that this
    forms travels as a long wave, whose amplitude changes as :math:`R^{-0.91}`.
    """
    growth = np.diff(log_velocity)
    left = MOMENTUM * np.maximum(-3.0 * rates - growth, 0.0)
    left[:TAIL_START] = 0.0
    left[-1] = left[-2]
    factors = np.exp(-TAIL_POWER * rates - growth)
    found = left.copy()
    for k in range(TAIL_START, len(rates) - 1):
        found[k] = max(found[k - 1] * factors[k], left[k])
    found[-1] = found[-2]
    return found, found - left

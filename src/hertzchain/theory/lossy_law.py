r"""The local-rate law with loss: the effect of three laws of loss on the pulse of a taper.

A loss of strength x changes the growth of the velocity at contact k by :math:`x_k f(s_k, x_k)`,
after a start and with a memory of previous rates.  `Restitution` and `UnloadingRatio` have no scale
of their own: x is the same at all contacts.  The strength of `Viscoelastic` depends on the time
scale of the pulse, and thus on its velocity.  `tools/loss_tables.py` determines the functions from
simulated pulses.

The momentum that the pulse loses forms a tail behind it.  The tail decays less than the pulse,
and can overtake it; from there on, the law does not apply.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..chain.feature_support import require_supported
from ..chain.laws.base import Loss
from ..collision import HERTZ_EXPONENT, Array
from ..errors import InputError, ModelRangeWarning, warn_user
from ..pulse.pulse import Pulse
from .loss_table import RATES, LossTable, inputs, loss_tables
from .short_chains import left_by_impact
from .tabulated_losses import LAWS, TabulatedLoss, tabulated_loss

# Momentum of the wave of equal beads in units of m v, first contact at which a tail can form,
# power of the radius with which a long wave decays, and relative velocity of a tail that overtakes.
MOMENTUM, TAIL_START, TAIL_POWER, OVERTAKEN = 1.67, 6, 0.91, 0.3
DOUBTFUL: Final = 0.01
# Error of the effect of the impact at the free end of a short chain, per attenuation of ln v.
OF_SHORT: Final = 120.0
# Memories of the changes of the rate in the estimated error.
SHORT_MEMORY, LONG_MEMORY = 2, 3
# Contacts on each side that determine a slow rate.
REACH: Final = 8
# Distance from the tables up to which a rate has the loss term of the nearest one.
MARGIN: Final = 0.02
STEPS: Final = np.arange(1.0, REACH + 1.0)


def lossy_pulse(
    chain: Chain, method: str, theory: Callable[[Chain], Pulse], warns_above: float
) -> Pulse:
    """The pulse of a scaled chain with loss, from that without loss by a theory of tapers.

    The theory has warned if its own estimated velocity error is larger than ``warns_above``.
    """
    require_supported(chain, method, supported=("loss",), alternative="use simulate")
    law = chain.contact_losses[1]
    name = _checked_name(chain, law, method)
    tabulated, table = LAWS[name], loss_tables()[name]
    pulse = theory(chain.replace(loss=None))
    assert pulse.peak_overlap is not None
    assert pulse.residence is not None
    assert pulse.velocity_error is not None
    rates = slow_rates(np.diff(np.log(chain.radii)))
    _check_rates(chain, rates, method)
    log_velocity = np.log(pulse.velocity)
    x, effect = effect_along(
        table, tabulated, tabulated.coefficients(law, chain), rates, log_velocity
    )
    tabulated.check_strength(x, chain, method)
    decay = np.concatenate(([0.0], np.cumsum(effect[0])))
    parts, relative = error_parts(rates, x, table.largest, log_velocity + decay)
    _check_tail(chain, tabulated.label(law), relative, method)
    error = np.concatenate(([0.0], table.error @ parts))
    left = np.abs(left_by_impact(np.diff(np.log(chain.radii))))
    error += OF_SHORT * left * abs(effect[0].mean())
    total = pulse.velocity_error + error
    if pulse.velocity_error.max() <= warns_above and total.max() > DOUBTFUL:
        _warn_doubtful(chain, tabulated.label(law), method, total)
    p = chain.exponents
    residence = pulse.residence * np.exp(effect[2] - (p - 1) / (p + 1) * decay[:-1])
    return dataclasses.replace(
        pulse,
        chain=chain,
        velocity=pulse.velocity * np.exp(decay),
        peak_overlap=pulse.peak_overlap * np.exp(effect[1] + 2 / (p + 1) * decay[:-1]),
        residence=residence,
        arrival=np.concatenate(([0.0], np.cumsum(residence))),
        velocity_error=total,
    )


def _checked_name(chain: Chain, law: Loss, method: str) -> str:
    """Name of the tables of a law, after checking that there are some."""
    if chain.exponents != HERTZ_EXPONENT:
        raise InputError(
            f"losses are tabulated for the exponent 3/2 only, got {chain.exponents:g}; use simulate"
        )
    return tabulated_loss(law, method)


def effect_along(
    table: LossTable,
    tabulated: TabulatedLoss,
    coefficients: Array,
    rates: Array,
    log_velocity: Array,
) -> tuple[Array, Array]:
    """Strengths of the loss and changes of the three components, at all contacts.

    The logarithms of velocities are those without loss.
    """
    series = table.series(rates)
    x = coefficients
    if tabulated.power:
        x = _march(series[0], table.largest, coefficients, tabulated.power, log_velocity)
    return x, table.effect(series, x)


def _march(
    series: Array, largest: float, coefficients: Array, power: float, log_velocity: Array
) -> Array:
    """Strengths that depend on the velocity, from contact to contact."""
    decay, found = 0.0, np.empty(len(coefficients))
    for k, row in enumerate(series.tolist()):
        x = float(coefficients[k]) * math.exp(power * (float(log_velocity[k]) + decay))
        found[k] = x
        # Clenshaw's recurrence.
        u = 2.0 * min(x / largest, 1.0) - 1.0
        one, two = 0.0, 0.0
        for c in row[:0:-1]:
            one, two = c + 2.0 * u * one - two, one
        decay += x * (row[0] + u * one - two)
    return found


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


def _check_tail(chain: Chain, law: str, relative: Array, method: str) -> None:
    """Raise an error if the tail overtakes the pulse."""
    overtaken = np.flatnonzero(relative >= OVERTAKEN)
    if overtaken.size:
        bead = int(overtaken[0]) + 2
        raise InputError(
            f"with {law}, the tail behind the pulse overtakes it near bead {bead}, from where "
            f"{method} does not apply (chain: {chain.description}); use simulate, or fewer beads"
        )


def _warn_doubtful(chain: Chain, law: str, method: str, error: Array) -> None:
    """Issue a warning that states where the estimated error is large."""
    bead = int(np.argmax(error > DOUBTFUL)) + 1
    warn_user(
        f"with {law}, {method} has an estimated velocity error above {DOUBTFUL:.0%} from bead "
        f"{bead} on, of {error.max():.1%} at most (chain: {chain.description}); use simulate",
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


def error_parts(rates: Array, x: Array, largest: float, log_velocity: Array) -> tuple[Array, Array]:
    """Parts of the estimated error behind each contact, and relative velocities of the tail."""
    found, y = inputs(rates), x / largest
    short, long = found[SHORT_MEMORY], found[LONG_MEMORY]
    low, high = RATES
    outside = np.maximum(rates - high, 0.0) + np.maximum(low - rates, 0.0)
    relative, old = tail(rates, log_velocity)
    roots = np.cumsum(np.square([x, x * short, x * y**2 * long]), axis=1)
    sums = np.cumsum([x * y * long**2, y * (old / OVERTAKEN) ** 8, x * outside], axis=1)
    return np.concatenate((np.sqrt(roots), sums)), relative


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

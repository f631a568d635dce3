r"""Attenuation of the solitary wave of equal beads by a small loss.

While the lossless wave passes, one contact per bead dissipates an energy D, which is an integral
over the profile of the wave.  A wave of energy :math:`E = E_1 m v^2` therefore decays as
:math:`d\ln v/dk = -D/2E`, exactly in the limit of a small loss, for any law of loss.  The term of
second order comes from simulations.
"""

from __future__ import annotations

import dataclasses
import functools
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from ..chain.chain import Chain
from ..chain.contact_groups import ContactGroup
from ..chain.feature_support import require_supported
from ..chain.hertz_warnings import warn_outside_hertz
from ..chain.laws import Loss
from ..chain.laws.elastic_plastic import ElasticPlastic
from ..chain.laws.velocity_power import VelocityPower
from ..collision import Array
from ..errors import InputError, ModelRangeWarning, warn_user
from ..kernels.law_kinds import DAMPED, YIELDING
from ..validation.keywords import checked_arguments
from ..validation.numbers import bounded_numbers
from .solitary_wave import MAX_SCALE, SolitaryWave, solitary_wave

SUPPORTED: Final = (
    "SI units", "masses", "stiffness", "strikers", "velocities", "gaps", "left wall",
    "right wall", "drive", "loss", "mixed losses", "mixed exponents",
)  # fmt: skip
# Estimated error above which a warning states it.
MAX_ERROR: Final = 0.01
# Coefficients c of the decay x - c x^2 of simulated waves, where x is that of the first order, at
# these exponents p, as `tools/attenuation_error.py` prints them.
EXPONENTS: Final = 1.5, 2.0, 3.0
SECOND_ORDER: Final = {
    "restitution": (8.45, 3.28, 1.34), "viscoelastic": (8.42, 3.23, 1.39),
    "dashpot": (8.75, 3.76, 1.94), "walton-braun": (-3.77, -2.35, -1.73),
    "unloading-ratio": (0.91, -0.79, -1.37),
}  # fmt: skip
# The same of `VelocityPower`, as start and slope of a linear function of alpha.
OF_VELOCITY_POWER: Final = (3.2, 1.50, 0.82), (5.55, 2.26, 1.12)
# First-order decay x at which the error of the corrected decay is 1%, and the power of x with which
# it grows, for p = 3/2.
RANGES: Final = {
    "restitution": (0.0256, 3.3), "viscoelastic": (0.022, 3.4), "dashpot": (0.037, 3.3),
    "walton-braun": (0.036, 2.5), "unloading-ratio": (0.0236, 4.2), "velocity-power": (0.026, 2.6),
}  # fmt: skip
# Contacts that yield: delay of the decay in beads, and coefficient of the square of the decay, as
# `fitted_coefficients` of the same tool determines them; the same two numbers of the error, where
# overlap / yield overlap - 1 takes the place of the decay; and the relative change of the velocity
# by which the derivative of the decay is determined.
DELAY, OF_SQUARE, RANGE_OF_YIELD, STEP = 0.230, 113.4, (1.0, 3.5), 1e-4
# Velocity of the wave over that of an impact by an equal bead, and the largest overlap / yield
# overlap of this wave without loss for which it remains the first one over 75 beads.
OF_IMPACT, MAX_YIELD = 0.6816, 7.0
# Range of custom laws, whose second order is not known.
FIRST_ORDER_RANGE: Final = 0.001, 1.0
# Number whose powers do not overflow; decays of such losses have no meaning.
HUGE: Final = 1e9
# Relative difference of equal beads, from rounding.
ROUNDING: Final = 1e-9
# Points of an integral over half the wave, which is then exact to 1e-12.
POINTS: Final = 400


@checked_arguments("attenuation")
def attenuation(chain: Chain, velocity: ArrayLike) -> Array:
    r"""Decay per bead of the wave in equal beads with any law of loss, if the loss is small.

    .. math::

        -\frac{d\ln v}{dk} = \frac{x}{1 + cx + (cx)^2}, \qquad x = \frac{D}{2E}, \qquad
        D = \int_{-\infty}^{\infty} F_{\mathrm{loss}}\, d'\, dt
            + \int_0^{d_m} F_{\mathrm{load}}\, dd - U(d_m)

    with the energy E of the lossless solitary wave, the overlap d(t) of a contact as this wave
    passes, its maximum :math:`d_m`, the damping force :math:`F_{\mathrm{loss}}`, the force
    :math:`F_{\mathrm{load}}` of the first loading, and the energy U that unloading returns.  The
    first order x is exact; the coefficient c of the second order was measured in simulations.
    Neither is in the paper.  The decay by `ElasticPlastic` is :math:`x\,(1 + 0.230\, dx/d\ln v +
    113.4\, x^2)`, with both numbers fitted to simulations.

    Parameters
    ----------
    chain : Chain
        A chain whose beads, after any strikers, are equal, with equal contacts and one law of
        loss (`Chain.loss`).  Its number of beads, walls and impact have no effect on the
        result.
    velocity : array_like
        Peak velocity v of a bead in the wave, > 0 [scaled, or m/s].  An impact of velocity 1 by an
        equal bead creates a wave with v = 0.6816 (p = 3/2) within about 15 beads; at bead 8, its
        velocity still falls by 0.14% per bead without any loss.

    Returns
    -------
    ndarray
        Decay of ln v per bead, of the shape of ``velocity``; 0 without loss.

    Raises
    ------
    InputError
        If the beads or contacts are not equal, there is precompression or gravity, or a velocity
        is not positive or not 1e-60 to 1e60.

    Warns
    -----
    ModelRangeWarning
        If the estimated error of the decay exceeds 1%, the largest wave in a chain of materials
        exceeds the limits of Hertz's law, or contacts yield so much in the impact of the chain that
        later waves overtake the first one.

    Notes
    -----
    For p = 3/2, c is 8.45 (`Restitution`), 8.42 (`Viscoelastic`), 8.75 (`Dashpot`), 3.2 + 5.55
    alpha (`VelocityPower`), -3.77 (`WaltonBraun`) and 0.91 (`UnloadingRatio`); it depends on
    p.  In simulations, the error reaches 1% where x is 0.022 (`Viscoelastic`) to 0.037
    (`Dashpot`) per bead.  Custom laws have no c: the result is x, and warnings begin at 0.001
    per bead.

    With `ElasticPlastic`, the decay depends only on the overlap over that at yield.  From bead 20
    on, decays above 0.0005 agree with simulations within 0.2% up to a ratio of 2, where x = 0.033
    and warnings begin.  Nearer the impact, the wave is still changing and decays faster.  If this
    ratio exceeds 7 in the wave that the impact of the chain would create without loss, later waves
    overtake the first one, whose decay then has no closed form.

    Examples
    --------
    In steel balls with the restitution 0.99 of a drop test, the pulse loses 0.22% per bead;
    `bca` would predict 0.5%:

    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(100).replace(loss=hc.Restitution(0.99))
    >>> round(float(hc.attenuation(chain, velocity=0.6816)), 6)
    0.002201
    """
    group = _equal_contacts(chain)
    v = bounded_numbers("velocity of a wave", velocity, unit=chain._unit("m/s"), above=0.0)
    if not ((v >= 1.0 / MAX_SCALE) & (v <= MAX_SCALE)).all():
        raise InputError(
            f"velocities of waves must be {1.0 / MAX_SCALE:g} to {MAX_SCALE:g}, so that no power "
            f"overflows; got {v.min():g} to {v.max():g}"
        )
    x, overlaps = _first_order(chain, group, v)
    p = group.contacts.exponent
    if overlaps.size:
        warn_outside_hertz(chain, np.full(chain.beads - 1, overlaps.max()))
        _warn_about_error(chain, group, float(x.max()), float(overlaps.max()))
    if isinstance(group.law, ElasticPlastic):
        higher, lower = (_first_order(chain, group, v * (1.0 + h))[0] for h in (STEP, -STEP))
        return np.asarray(x * (1.0 + DELAY * (higher - lower) / (2.0 * STEP) + OF_SQUARE * x**2))
    y = np.clip(second_order(group.law, p) * x, -HUGE, HUGE)
    return np.asarray(x / (1.0 + y + y * y))


def first_order(chain: Chain, velocity: ArrayLike) -> Array:
    """Decay per bead D/2E in the limit of a small loss."""
    return _first_order(chain, _equal_contacts(chain), np.asarray(velocity, float))[0]


def second_order(law: Loss, exponent: float) -> float:
    """Coefficient c of the second order in the decay; 0 if it is not known."""
    c = np.asarray(SECOND_ORDER.get(law.name, (0.0, 0.0, 0.0)))
    if isinstance(law, VelocityPower):
        start, slope = np.array(OF_VELOCITY_POWER)
        c = start + slope * law.alpha
    # A parabola in 1/(p - 1) through the three exponents, accurate to 2% between them.
    s = 1.0 / (np.array(EXPONENTS) - 1.0)
    return float(np.polyval(np.polyfit(s, c, 2), 1.0 / (exponent - 1.0)))


def estimated_error(law: Loss, exponent: float, decay: float) -> float:
    """Relative error of `attenuation` where the first order has this decay.

    Of contacts that yield, ``decay`` is overlap / yield overlap - 1.
    """
    if isinstance(law, ElasticPlastic):
        limit, power = RANGE_OF_YIELD
        return float(MAX_ERROR * min(max(decay, 0.0) / limit, HUGE) ** power)
    limit, power = RANGES.get(law.name, FIRST_ORDER_RANGE)
    # Below p = 3/2, c grows fast and is not accurately known.
    limit *= min(1.0, (2.0 * (exponent - 1.0)) ** 3)
    return float(MAX_ERROR * min(decay / limit, HUGE) ** power)


def _warn_about_error(chain: Chain, group: ContactGroup, decay: float, overlap: float) -> None:
    law, contacts = group.law, group.contacts
    amount = decay
    if isinstance(law, ElasticPlastic):
        amount = overlap / float(law.strength(contacts)[0]) - 1.0
        _warn_about_impact(chain, group)
    error = estimated_error(law, contacts.exponent, amount)
    if error <= MAX_ERROR:
        return
    size = f"about {error:.1%}" if error < 0.3 else "more than 30%"
    warn_user(
        f"the decay by {law} is {decay:.2g} per bead to first order in the loss: the estimated "
        f"error of attenuation is {size}; use simulate",
        ModelRangeWarning,
    )


def _warn_about_impact(chain: Chain, group: ContactGroup) -> None:
    """Warn if later waves overtake the first one of contacts that yield."""
    p, speed = group.contacts.exponent, float(np.ptp(chain.velocities))
    if not 1.0 / MAX_SCALE <= speed <= MAX_SCALE:
        return
    first = np.array([OF_IMPACT * speed])
    overlaps = _overlaps(group, solitary_wave(p), float(chain.masses[chain.strikers]), first)
    ratio = float(overlaps[0] / group.law.strength(group.contacts)[0])
    if ratio > MAX_YIELD:
        warn_user(
            f"the first wave of this impact would have {ratio:.2g} times the overlap at yield; "
            f"beyond {MAX_YIELD:g}, later waves overtake it, and attenuation does not describe its "
            "decay: use simulate",
            ModelRangeWarning,
        )


def _first_order(chain: Chain, group: ContactGroup, v: Array) -> tuple[Array, Array]:
    """Decays per bead in the limit of a small loss, and largest overlaps."""
    mass, speeds = float(chain.masses[chain.strikers]), v.reshape(-1)
    wave = solitary_wave(group.contacts.exponent)
    overlaps = _overlaps(group, wave, mass, speeds)
    lost = _dissipated(group, wave, mass, speeds, overlaps)
    decay = lost / (2.0 * wave.energy_constant * mass * speeds**2)
    return np.asarray(decay.reshape(v.shape)), overlaps


def _overlaps(group: ContactGroup, wave: SolitaryWave, mass: float, v: Array) -> Array:
    """Largest overlaps in waves of peak velocities v."""
    p, k = group.contacts.exponent, float(group.contacts.stiffness[0])
    force = wave.force_constant * k ** (1 / (p + 1)) * (mass * v**2) ** (p / (p + 1))
    return np.asarray((force / k) ** (1 / p))


def _dissipated(
    group: ContactGroup, wave: SolitaryWave, mass: float, v: Array, largest: Array
) -> Array:
    """Energies that one contact dissipates as waves of peak velocities v pass."""
    law, contacts = group.law, group.contacts
    p, k = contacts.exponent, float(contacts.stiffness[0])
    row, strength = law.row(p), law.strength(contacts)
    speed = wave.speed_constant * (k / mass) ** (1 / (p + 1)) * v ** ((p - 1) / (p + 1))
    if row.kind == DAMPED:
        a, b = row.overlap_power, row.speed_power
        shape = damping_integral(p, a, b)
        return np.asarray(strength[0] * largest**a * v ** (b + 1) * shape / speed)
    first = np.minimum(largest, strength[0]) if row.kind == YIELDING else largest
    loading = k * first ** (p + 1) / (p + 1)
    # Beyond yield, the force is a linear function of the overlap.
    steps, weights = np.polynomial.legendre.leggauss(2)
    for step, weight in zip(0.5 * (1.0 + steps), 0.5 * weights, strict=True):
        at = first + step * (largest - first)
        loading = loading + weight * (largest - first) * law.loading_force(at, contacts)
    reached = law.loading_force(largest, contacts)
    lost = loading - law.stored_energy(largest, reached, contacts)
    return np.asarray(np.where(lost > 0.0, lost, 0.0))


@functools.lru_cache(maxsize=64)
def damping_integral(exponent: float, overlap_power: float, speed_power: float) -> float:
    r"""Integral of :math:`f^a |w(\xi+\frac12) - w(\xi-\frac12)|^{b+1}` over the wave.

    The overlap f and the velocity w are one at their crests.
    """
    wave = solitary_wave(exponent)
    # The integrand is smooth at the crest only for integer b, but always as a function of u.
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    u, power = 0.5 * (1.0 + nodes), 4
    xi = wave.overlap.half_length * u**power
    approach = np.abs(wave.velocity(xi - 0.5) - wave.velocity(xi + 0.5))
    values = wave.overlap(xi) ** overlap_power * approach ** (speed_power + 1.0)
    slope = power * wave.overlap.half_length * u ** (power - 1)
    return float(np.sum(weights * slope * values))


def _equal_contacts(chain: Chain) -> ContactGroup:
    """One of the equal contacts of a chain of equal beads."""
    require_supported(chain, "attenuation", supported=SUPPORTED, alternative="use simulate")
    first = chain.strikers
    if chain.beads - first < 2:
        raise InputError("attenuation requires at least two beads after the strikers, got 1")
    inner = np.arange(first + 1, chain.beads)
    equal = {"beads": chain.masses[first:], "contacts": chain.stiffness[first:]}
    for name, values in equal.items():
        if np.ptp(values) > ROUNDING * values[0]:
            raise InputError(
                f"attenuation requires equal {name} after the strikers, but the chain "
                f"({chain.description}) has different ones; use simulate"
            )
    for group in chain.contact_groups:
        which = np.flatnonzero(np.isin(group.index, inner))
        if len(which) == len(inner):
            return dataclasses.replace(group, contacts=group.contacts.only(which[:1]))
    raise InputError(
        "attenuation requires one law of loss and one exponent for all contacts of two beads, but "
        f"the chain ({chain.description}) has several; use simulate"
    )

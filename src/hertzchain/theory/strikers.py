r"""Strikers of any mass, contact and velocity, for theories of chains struck by one of their beads.

Beyond about 40 beads, the pulse of another striker differs from that of the bead that would
continue the taper by one factor :math:`A(\mu, \kappa, s)`: a function of the striker's mass and of
the stiffness of its contact, both relative to that bead's, and of the rate at the impact.
`tools/striker_tables.py` determines this factor and those of the first beads.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..chain.feature_support import require_supported
from ..collision import HERTZ_EXPONENT, Array, hertz_stiffness
from ..errors import InputError, ModelRangeWarning, warn_user
from ..pulse.pulse import Pulse
from .short_chains import left_by_impact
from .striker_table import striker_table
from .table_weights import spline_weights

# Features of chains with another striker.
FEATURES: Final = ("masses", "stiffness", "velocities", "strikers")
# Nodes of the table: masses and contacts of the striker, rates, and contacts after the impact.
LOG_MASSES: Final = tuple(0.5 * math.log(2.0) * n for n in range(-5, 8))
LOG_STIFFNESS: Final = tuple(0.5 * math.log(2.0) * n for n in range(-2, 3))
RATES: Final = (-0.12, -0.09, -0.06, -0.04, -0.025, -0.015, -0.007, 0.0,
                0.007, 0.015, 0.025, 0.04, 0.06, 0.09, 0.15)  # fmt: skip
CONTACTS: Final = 40
# Weights of the rates after the impact, per bead, for light and heavy strikers.  Between the two
# logarithms of the mass the weight changes smoothly, so that the law is continuous.
MEMORY: Final = (0.5, 0.72)
LIGHT, HEAVIER = -0.5 * math.log(2.0), 0.5 * math.log(2.0)
REMEMBERED: Final = 12
# Error of the last bead's velocity behind a heavy striker: at most this factor times the square of
# the logarithm of its mass, which decays with the number of beads.
HEAVY, FORGETTING = 0.035, 0.25
# Error of the table between its nodes, and estimated error from which a warning is issued.
TABLE_ERROR, DOUBTFUL = 2e-4, 0.01
# Relative difference of masses that agree, from conversion of units.
ROUNDING: Final = 1e-9


@dataclass(frozen=True)
class Striker:
    """A striker, relative to the bead that would continue the taper.

    Attributes
    ----------
    mass, stiffness : float
        Its mass and the stiffness of its contact, over those of that bead.
    velocity : float
        Its velocity [scaled].
    chain : Chain
        The chain struck by that bead at velocity 1, in its scaled variables.
    units : tuple of float
        Units of length and time of this chain [scaled variables of the chain with the striker].
    """

    mass: float
    stiffness: float
    velocity: float
    chain: Chain
    units: tuple[float, float]


def struck_pulse(chain: Chain, method: str, theory: Callable[[Chain], Pulse]) -> Pulse:
    """The pulse of a scaled chain with any striker, by a theory of chains of spheres."""
    striker = striker_of(chain, method)
    return _struck(chain, striker, theory(striker.chain))


def other_method(features: Sequence[str]) -> str:
    """Advice for a chain with features that theories of tapers do not support."""
    by_both = {*features} <= {"masses", "stiffness", "SI units", "cap"}
    return "use propagate or simulate" if by_both else "use simulate"


def striker_of(chain: Chain, method: str) -> Striker:
    """The striker of a scaled chain; `InputError` if the other beads are not like spheres."""
    require_supported(chain, method, supported=FEATURES, alternative=other_method)
    if chain.beads < 3:
        raise InputError(
            f"{method} requires at least 3 beads, strikers included, got {chain.description}; use "
            "propagate"
        )
    m, k, radii = chain.masses, chain.stiffness, chain.radii
    alike = np.allclose(m[1:], radii[1:] ** 3, rtol=ROUNDING, atol=0.0) and np.allclose(
        k[1:], hertz_stiffness(radii[1:-1], radii[2:]), rtol=ROUNDING, atol=0.0
    )
    if not alike or chain.strikers > 1 or chain.velocities[1:].any():
        # Name the features as for a theory without strikers.
        require_supported(chain, method, alternative=other_method)
    if not chain.velocities[0] > 0.0:
        raise InputError(
            f"{method} needs a striker that moves forwards, but its velocity is "
            f"{chain.velocities[0]:g} (chain: {chain.description})"
        )
    rate = math.log(radii[2] / radii[1])
    first = float(radii[1]) * math.exp(-rate)
    clean = Chain.from_radii(np.concatenate(([first], radii[1:])), exponent=chain.exponents)
    velocity, p = float(chain.velocities[0]), float(chain.exponents)
    # Its units of mass and stiffness are those of spheres of this radius.
    length = (first**2.5 * velocity**2) ** (1.0 / (p + 1.0))
    return Striker(
        mass=float(m[0]) / first**3,
        stiffness=float(k[0] / (math.sqrt(first) * clean.stiffness[0])),
        velocity=velocity,
        chain=clean,
        units=(length, length / velocity),
    )


def _struck(chain: Chain, striker: Striker, pulse: Pulse) -> Pulse:
    """The pulse of a striker from that of the bead that would continue the taper."""
    if chain.exponents != HERTZ_EXPONENT:
        raise InputError(
            f"strikers other than a bead are tabulated for the exponent 1.5 only, got "
            f"{chain.exponents:g}; use propagate"
        )
    effect, error = striker_effect(striker)
    length, time = striker.units
    assert pulse.peak_overlap is not None
    assert pulse.residence is not None
    velocity = pulse.velocity * striker.velocity
    velocity[1:] *= np.exp(effect[0])
    overlap, residence = (
        unit * values * np.exp(change)
        for unit, values, change in zip(
            (length, time), (pulse.peak_overlap, pulse.residence), effect[1:], strict=True
        )
    )
    errors = pulse.velocity_error
    if errors is not None:
        errors = np.hypot(errors, error) + _errors_at_the_end(striker)
        errors[0] = 0.0
    return dataclasses.replace(
        pulse, chain=chain, velocity=velocity, peak_overlap=overlap, residence=residence,
        arrival=np.concatenate(([0.0], np.cumsum(residence))), velocity_error=errors,
    )  # fmt: skip


def _errors_at_the_end(striker: Striker) -> Array:
    """Errors of the velocities, as the effects of striker and free end of a short chain overlap."""
    rates, heavy = np.diff(np.log(striker.chain.radii)), max(math.log(striker.mass), 0.0)
    errors = np.abs(left_by_impact(rates)) * (striker.mass != 1.0)
    errors[-1] += HEAVY * heavy**2 * math.exp(-FORGETTING * len(errors))
    if errors[-1] > DOUBTFUL:
        warn_user(
            f"the chain is so short that, with this striker, the velocity of the last bead has an "
            f"estimated error of {errors[-1]:.1%}; use propagate",
            ModelRangeWarning,
        )
    return errors


def striker_effect(striker: Striker) -> tuple[Array, float]:
    """Changes of ln v, ln d and ln T by the striker, per contact, and error of the first one."""
    at = math.log(striker.mass), math.log(striker.stiffness)
    nodes = LOG_MASSES, LOG_STIFFNESS
    names = "mass of the striker", "stiffness of its contact"
    for x, allowed, name in zip(at, nodes, names, strict=True):
        if not allowed[0] - ROUNDING <= x <= allowed[-1] + ROUNDING:
            raise InputError(
                f"the {name} must be {math.exp(allowed[0]):g} to {math.exp(allowed[-1]):g} times "
                f"that of the bead that would continue the taper, got {math.exp(x):.4g}; use "
                "propagate"
            )
    rates = np.diff(np.log(striker.chain.radii))
    weights = _memory(at[0]) ** np.arange(min(REMEMBERED, len(rates)))
    mean = float(weights @ rates[: len(weights)] / weights.sum())
    if not RATES[0] <= mean <= RATES[-1]:
        warn_user(
            f"the effect of the striker is tabulated for rates from {RATES[0]:g} to {RATES[-1]:g},"
            f" but that of the first beads is {mean:.3g}; use propagate",
            ModelRangeWarning,
        )
    first = float(np.clip(rates[0], RATES[0], RATES[-1]))
    found = _interpolated(*at, float(np.clip(mean, RATES[0], RATES[-1])))
    other = _interpolated(*at, first)
    error = float(np.abs(found[0] - other[0]).max()) + TABLE_ERROR * min(
        1.0, abs(at[0]) + abs(at[1])
    )
    if error > DOUBTFUL:
        warn_user(
            f"the rates of the first beads change so fast that the effect of the striker has an "
            f"estimated error of {error:.1%}; use propagate",
            ModelRangeWarning,
        )
    contacts = len(rates)
    return found[:, np.minimum(np.arange(contacts), CONTACTS - 1)], error


def _memory(log_mass: float) -> float:
    """Weight of a rate relative to that of the bead behind."""
    x = float(np.clip((log_mass - LIGHT) / (HEAVIER - LIGHT), 0.0, 1.0))
    return MEMORY[0] + (MEMORY[1] - MEMORY[0]) * x * x * (3.0 - 2.0 * x)


def _interpolated(log_mass: float, log_stiffness: float, rate: float) -> Array:
    """Effect of a striker on an exponential chain, shape (3, contacts)."""
    values = striker_table()["effect"]
    for nodes, x in ((RATES, rate), (LOG_MASSES, log_mass), (LOG_STIFFNESS, log_stiffness)):
        values = np.tensordot(spline_weights(nodes, x), values, axes=1)
    return np.asarray(values)

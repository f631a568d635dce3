r"""The local-rate law for chains of smooth parts, joined by steps in the radius and odd beads.

The pulse is scattered where the radius jumps.  Behind the jump it settles to that of the next part
within about 20 beads, multiplied by a factor that depends only on the jump and on the rates on
both sides.  The law describes the parts; a table from simulated pulses describes the jumps.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..collision import HERTZ_EXPONENT, Array
from ..errors import InputError, ModelRangeWarning, warn_user
from ..pulse.chain_units import for_any_units
from ..pulse.pulse import Pulse
from ..validation.keywords import checked_arguments
from .local_rate import smooth_pulse
from .step_table import AFTER, BEFORE, LOG_RATIOS, RATES, jump_effect
from .strikers import other_method

METHOD: Final = "the piecewise local-rate law"
# A rate that is farther than this outside those of the neighbouring contacts is a jump.
MIN_JUMP: Final = 0.03
# Fewest contacts between two jumps, and contacts on each side that determine the rates of a jump.
MIN_DISTANCE, NEIGHBOURS = 8, 25
# Weights of these rates, per contact; those after a step to smaller beads decrease more slowly.
SHORT, LONG, MORE = 0.55, 0.6, 0.3
# Weights of a longer mean, which estimates the error, and estimate from which a warning is issued.
LONGER, DOUBTFUL = 0.85, 0.01
# Largest errors of the transmitted velocity in checks with one jump.
JUMP_ERROR: Final = 0.005
TOLERANCE: Final = 1e-9


@dataclass(frozen=True)
class Jump:
    """A step in the radius at a contact, from 0, or an odd bead ahead of it."""

    contact: int
    log_ratio: float
    odd: bool
    before: float
    after: float
    # The rate after it, over a longer distance.
    later: float

    def effect(self) -> Array:
        """Changes of ln v and ln d, and ratios of T, shape (3, contacts)."""
        kind = "odd" if self.odd else "step"
        return jump_effect(kind, (self.before, self.after), self.log_ratio)

    def error(self) -> float:
        """Estimated error of the transmitted velocity: the change by a change of the rates."""
        later = min(max(self.later, RATES[0]), RATES[-1])
        other = dataclasses.replace(self, after=later).effect()
        return JUMP_ERROR + abs(float(other[0, -1] - self.effect()[0, -1]))


@checked_arguments("piecewise_local_rate")
@for_any_units(METHOD, alternative=other_method)
def piecewise_local_rate(chain: Chain) -> Pulse:
    r"""Leading pulse of smooth parts joined by steps in the radius or single odd beads.

    .. math:: \ln v_k = \ln v_k^{\mathrm{smooth}} + \sum_i T_i(k - k_i;\, s_i, s_i', \ln f_i)

    The chain without its jumps is evaluated by `local_rate`.  Each jump at contact :math:`k_i`, by
    the factor :math:`f_i`, adds a tabulated term that depends on the rates
    :math:`\ln(R_{k+1}/R_k)` before and after it, and is constant 34 contacts ahead.  The law is
    not in the paper; it is derived in the explanation "Steps and odd beads".

    Parameters
    ----------
    chain : Chain
        Spheres of one material; with jumps, only Hertz contacts (exponent 1.5).  A jump is a rate
        that is more than 0.03 outside those of the four neighbouring contacts, by a factor of 0.46
        to 2.2 of the radius; two opposite jumps are an odd bead.  The rates at jumps must be from
        -0.06 to 0.06, and there must be eight contacts before each jump and after it, to the next
        one or the end.

    Returns
    -------
    Pulse
        As of `local_rate`.  Beyond a jump, ``velocity_error`` includes at least 0.5% for it.

    Raises
    ------
    InputError
        If a jump is too large or too close to another or to an end, if a chain with jumps has
        another exponent than 1.5, or for a chain that `local_rate` does not support.

    Warns
    -----
    ModelRangeWarning
        As `local_rate`, for the chain without its jumps; or if rates next to a jump change so fast
        that the estimated error of the transmitted velocity exceeds 1%.

    Examples
    --------
    Twice the radius from bead 41 on; the quasi-particle formula gives 2/(1 + 8) = 0.22:

    >>> import hertzchain as hc
    >>> chain = hc.Chain.from_radii([1.0] * 40 + [2.0] * 60)
    >>> pulse = hc.piecewise_local_rate(chain)
    >>> round(float(pulse.velocity[89] / pulse.velocity[29]), 4)
    0.2439
    """
    rates = np.diff(np.log(chain.radii))
    jumps = find_jumps(rates)
    _check_distances(jumps, len(rates))
    sizes = np.zeros(chain.beads)
    for jump in jumps:
        ahead = slice(jump.contact + 1, jump.contact + 2 if jump.odd else None)
        sizes[ahead] += jump.log_ratio
    if not jumps:
        pulse = smooth_pulse(chain, "piecewise_local_rate")
        return dataclasses.replace(pulse, method=METHOD.removeprefix("the "))
    if chain.exponents != HERTZ_EXPONENT:
        raise InputError(
            f"{METHOD} has the effects of jumps for Hertz contacts (exponent 1.5) only, got "
            f"{chain.exponents:g}; use propagate"
        )
    radii = chain.radii * np.exp(-sizes)
    smooth = Chain(radii, chain.exponents)
    smooth._set("_described_as", f"{chain.description}, without its jumps")
    return _joined(chain, smooth_pulse(smooth, "piecewise_local_rate"), jumps, sizes)


def find_jumps(rates: Array) -> list[Jump]:
    """Jumps of a chain, with the rates on both sides of each."""
    flagged = [k for k in range(len(rates)) if _outside(rates, k) > MIN_JUMP]
    found: list[Jump] = []
    for k in flagged:
        if found and found[-1].odd and k == found[-1].contact + 1:
            continue
        odd = k + 1 in flagged and rates[k] * rates[k + 1] < 0.0
        if k == 0 or k + odd == len(rates) - 1:
            raise InputError(
                f"the jump of the radius at contact {k + 1} is at an end of the chain; there must "
                f"be {MIN_DISTANCE} contacts before and after it; use propagate"
            )
        before = _weighted(rates[:k][::-1], SHORT)
        ahead = rates[k + odd + 1 :]
        after = _weighted(ahead, SHORT)
        mean = 0.5 * (before + after)
        size = rates[k] - mean
        if odd:
            size = 0.5 * (size + after - rates[k + 1])
        elif size < 0.0:
            # Behind a step to smaller beads, the pulse settles slowly.
            after = _weighted(ahead, LONG - MORE * size)
            size = rates[k] - 0.5 * (before + after)
        found.append(Jump(k, float(size), odd, before, after, _weighted(ahead, LONGER)))
    return found


def _weighted(rates: Array, memory: float) -> float:
    """Mean of rates with geometrically decreasing weights."""
    weights = memory ** np.arange(min(len(rates), NEIGHBOURS))
    return float(weights @ rates[: len(weights)] / weights.sum())


def _outside(rates: Array, k: int) -> float:
    """How far a rate is outside those of its neighbours, the closest one on each side excepted."""
    near = [rates[j] for j in (k - 3, k - 2, k + 2, k + 3) if 0 <= j < len(rates)]
    return float(max(rates[k] - max(near), min(near) - rates[k])) if near else 0.0


def _check_distances(jumps: list[Jump], contacts: int) -> None:
    limits = [-1, *(jump.contact for jump in jumps), contacts]
    for before, here in itertools.pairwise(limits):
        if here - before <= MIN_DISTANCE and len(limits) > 2:
            place = f"contact {here + 1}" if here < contacts else "the end"
            raise InputError(
                f"there must be {MIN_DISTANCE} contacts before and after each jump of the radius, "
                f"but there are {here - before - 1} before {place}; use propagate"
            )
    for jump in jumps:
        if abs(jump.log_ratio) > LOG_RATIOS[-1] + TOLERANCE:
            raise InputError(
                f"the radius jumps by a factor of {math.exp(jump.log_ratio):.3g} at contact "
                f"{jump.contact + 1}; the table is from {math.exp(LOG_RATIOS[0]):.3g} to "
                f"{math.exp(LOG_RATIOS[-1]):.3g}; use propagate"
            )
        for rate in (jump.before, jump.after):
            if not RATES[0] <= rate <= RATES[-1]:
                raise InputError(
                    f"the rates at a jump must be from {RATES[0]:g} to {RATES[-1]:g}, but "
                    f"{rate:.3g} is next to contact {jump.contact + 1}; use propagate"
                )


def _joined(chain: Chain, smooth: Pulse, jumps: list[Jump], sizes: Array) -> Pulse:
    """Apply the effects of jumps to the pulse of the smooth chain."""
    assert smooth.peak_overlap is not None
    assert smooth.residence is not None
    contacts = chain.beads - 1
    growth, overlap, time = np.zeros(contacts), sizes[:-1].copy(), np.exp(sizes[:-1])
    error = np.zeros(chain.beads)
    for jump in jumps:
        for contact, effect in _placed(jump, contacts):
            growth[contact] += effect[0]
            overlap[contact] += effect[1]
            time[contact] *= effect[2]
        doubt = jump.error()
        error[max(jump.contact - 1, 1) :] += doubt**2
        if doubt > DOUBTFUL:
            warn_user(
                f"the rates next to the jump of the radius at contact {jump.contact + 1} change so "
                f"fast that the transmitted velocity has an estimated error of {doubt:.1%}; use "
                "propagate",
                ModelRangeWarning,
            )
    residence = smooth.residence * time
    velocity = smooth.velocity.copy()
    velocity[1:] *= np.exp(growth)
    errors = smooth.velocity_error
    return Pulse(
        chain=chain,
        method="piecewise local-rate law",
        velocity=velocity,
        arrival=np.concatenate(([0.0], np.cumsum(residence))),
        peak_overlap=smooth.peak_overlap * np.exp(overlap),
        residence=residence,
        velocity_error=None if errors is None else np.sqrt(errors**2 + error),
        notes=smooth.notes,
    )


def _placed(jump: Jump, contacts: int) -> Iterator[tuple[int, Array]]:
    """Contacts on which a jump has an effect, and its effect there."""
    effect = jump.effect()
    for contact in range(max(jump.contact + 1 - BEFORE, 0), contacts):
        column = contact - jump.contact - 1 + BEFORE
        yield contact, effect[:, min(column, BEFORE + AFTER - 1)]

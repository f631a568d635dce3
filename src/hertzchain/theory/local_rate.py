r"""The local-rate law: the leading pulse of tapers, accurate to a fraction of 1%.

An exponential chain, with constant rate :math:`s = \ln(R_{k+1}/R_k)`, looks the same from every
bead.  After a few beads, the velocity therefore changes by a factor :math:`e^{\sigma(s)}` per
bead that depends only on s.  In any other chain the rates are divided into a slow and a fast part.
For the slow rates, the pulse is close to that of the local rate, with a memory of the rates at the
previous few beads, up to second order.  The response to the fast part and to the free end is taken
from the simulation.  The functions of the rate are tabulated in
`hertzchain.theory.universal_functions`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..chain.decorations import decoration_of
from ..chain.hertz_warnings import warn_outside_hertz
from ..collision import HERTZ_EXPONENT, Array
from ..errors import InputError, ModelRangeWarning, warn_user
from ..pulse.chain_units import for_any_units, scaled_chain, unit_of
from ..pulse.notes import beads_in_words
from ..pulse.pulse import Pulse, assemble_pulse
from ..pulse.quantities import QUANTITIES
from ..validation.keywords import checked_arguments
from ..validation.numbers import whole_number
from ..validation.objects import check_choice
from .alternating_masses import alternates
from .decoration import small_beads
from .growth_errors import add_accumulated, add_lost_maxima, covered
from .lossy_law import lossy_pulse
from .strikers import FEATURES as STRIKERS
from .strikers import other_method, struck_pulse
from .universal_functions import (
    MIN_BEADS,
    UniversalFunctions,
    powers,
    universal_functions,
)

# Quantities that have a gradient.
DIFFERENTIABLE: Final = ("velocity", "momentum", "energy", "arrival", "residence", "peak_force")
METHOD: Final = "the local-rate law"
# Estimated velocity error above which a chain is outside the law's range.  Because an estimate does
# not cover every error, this is half of the error of 1% that must not remain without a warning.
DOUBTFUL: Final = 0.005
# Largest estimate: if it is larger, the error can be of any size, and is unknown.
MAX_ESTIMATE: Final = 1.0
# Part of the contacts at which masses alternate from which on a chain is not one of single steps.
MOSTLY: Final = 0.5
# Largest ratio of small beads, and rate of the large ones, in decorated tapers whose velocities
# were compared with those of tapers without small beads.
DECORATED_RATIO, DECORATED_RATE = 0.5, 0.052


@checked_arguments("local_rate")
@for_any_units(METHOD, supported=(*STRIKERS, "loss"), alternative=other_method)
def local_rate(chain: Chain) -> Pulse:
    r"""Leading pulse of a chain of any taper by the local-rate law.

    .. math::

        v_k = \exp\sum_{j<k} \rho_j, \qquad
        z_k = \zeta_k + \Delta z_k, \qquad
        \zeta_k = z^*(q_k) + \sum_i L_i(q_k)\, y_i + \sum_{i\le j} M_{ij}(q_k)\, y_i y_j

    The state of contact k is :math:`z_k = (\rho_k, \varphi_k, \tau_k)`, where
    :math:`\rho_k = \ln(v_{k+1}/v_k)` is the growth of the velocity.  The other two components are
    the logarithms of the peak force and the residence time, made dimensionless with the bead's
    mass and velocity and the contact stiffness.  On an exponential chain of rate s the state is
    :math:`z^*(s)`.  The rates are divided into a slow part q, a local cubic polynomial, and the
    rest e.  The inputs y are the deviation :math:`\zeta_{k-1} - z^*(q_{k-1})` of the previous
    contact and the differences between the slow rates :math:`q_{k-2} \dots q_{k+2}`, and
    :math:`\Delta z` is the response to e, up to second order or, if the rates alternate, for finite
    amplitudes, and to the free end.  The law is not in the paper; it is derived in the explanation
    "The local-rate law".

    Parameters
    ----------
    chain : Chain
        A chain of at least nine beads, struck by its first bead or by another body
        (`Chain.struck_by`).  The ratio of neighbouring radii may be from 0.85 to 3.  Radii may also
        scatter from bead to bead by up to 0.3%, or alternate by up to 3%, without a warning (0.05%
        and 0.2% for exponents other than 3/2 and 2; less in steep tapers).  Beyond these limits,
        the estimate is several times too large: if radii scatter by 1%, or alternate by 10%, the
        error is usually less than 0.1%, but a warning is issued. Chains struck by their first bead
        may lose energy by `Restitution` from 0.9, `UnloadingRatio` up to 0.1, or `Viscoelastic` up
        to :math:`A (k/m)^{2/5} v^{1/5} = 0.06` at any bead. The exponent of the contact force may
        be from 1.25 to 3; below 1.6, the smallest ratio is larger, 0.95 for the exponent 1.25.

    Returns
    -------
    Pulse
        Velocity with its estimated relative error, arrival time, residence time and peak
        overlap; momentum, energy and force are derived from them.  The estimate is NaN where the
        error is unknown: beyond a contact whose rate is outside the tables, where the estimate
        would exceed 100%, and where beads of forward tapers may lose their first maximum: at the
        last ones if rates are below -0.1235, and beyond a rate below -0.161; for exponents below
        1.85, except 3/2, at rates closer to 0.

    Raises
    ------
    InputError
        If there are fewer beads, or no tables for the exponent; if a loss is too strong, or the
        tail behind the pulse overtakes it.

    Warns
    -----
    ModelRangeWarning
        If a rate is outside the tables, or the estimated velocity error exceeds 0.5% (1% with a
        loss).

    Notes
    -----
    All columns include the effect of a loss, which is derived in "Losses in the local-rate law".
    The estimated error exceeds 96% or more of the errors in each class of random chains for the
    exponent 3/2; it is not an upper bound.  Errors within one chain are correlated: in a taper
    of constant rate, most beads may exceed the estimate, by up to four times.  Beyond 100 contacts,
    or from the first one for exponents other than 3/2 and 2, it contains errors that accumulate
    along the chain.  Where a warning is issued, use
    `propagate`, or `simulate` with a loss.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.tapered("backward-linear", 0.5, beads=100)
    >>> comparison = hc.local_rate(chain).compare(hc.propagate(chain))
    >>> comparison.worst("velocity") < 1e-3
    True
    """
    if "loss" in chain.features:
        return lossy_pulse(chain, METHOD, local_rate, DOUBTFUL)
    if chain.features:
        return struck_pulse(chain, METHOD, local_rate)
    return smooth_pulse(chain)


def smooth_pulse(chain: Chain, theory: str = "local_rate", advice: str = "") -> Pulse:
    """The pulse of a scaled chain of spheres, for a theory that is named in warnings."""
    from ..kernels import local_rate_pulse as kernel

    functions, of = _checked_functions(chain), powers(chain.exponents)
    by_bead, by_contact = np.empty((3, chain.beads)), np.empty((2, chain.beads - 1))
    wanted = of["residence"], of["peak_overlap"]
    error, sound = kernel.pulse(
        chain.radii, functions.arrays, functions.error, *wanted, by_bead, by_contact
    )
    error = _with_accumulated(error, chain.radii, by_bead[1, 1:], functions)
    notes: dict[str, str] = {}
    if not error <= DOUBTFUL:
        _warn_outside(chain, functions, chain.beads, theory, advice)
        by_bead[1] = _known(by_bead[1], np.diff(np.log(chain.radii)), functions)
        notes = _notes(by_bead[1])
    by_bead.setflags(write=False)
    by_contact.setflags(write=False)
    # The checks of a pulse take longer than the law.
    build = assemble_pulse if sound else Pulse
    return build(
        chain=chain,
        method="local-rate law",
        velocity=by_bead[0],
        arrival=by_bead[2],
        peak_overlap=by_contact[1],
        residence=by_contact[0],
        velocity_error=by_bead[1],
        notes=notes,
    )


def _with_accumulated(
    largest: float, radii: Array, errors: Array, functions: UniversalFunctions
) -> float:
    """Largest of the estimated errors, with those that accumulate and of lost maxima."""
    from ..kernels import local_rate_pulse as kernel

    contacts = len(errors)
    if contacts <= covered(functions.exponent) or not np.isfinite(largest):
        return largest
    rates = kernel.logarithms(radii)[1]
    slow, _ = kernel.divide(rates, len(rates))
    add_accumulated(errors, slow[:contacts], functions)
    add_lost_maxima(errors, slow[: len(rates)], functions.exponent)
    return float(errors.max())


def _known(errors: Array, rates: Array, functions: UniversalFunctions) -> Array:
    """Estimated errors of all beads, or of all but the first; NaN where they are unknown."""
    low, high = functions.range
    outside = np.logical_or.accumulate(~((rates >= low) & (rates <= high)))
    unknown = ~(errors <= MAX_ESTIMATE)
    unknown[-len(outside) :] |= outside
    return np.where(unknown, np.nan, errors)


def _notes(errors: Array) -> dict[str, str]:
    """A note that states where the estimated error is unknown."""
    unknown = np.isnan(errors)
    if not unknown.any():
        return {}
    return {"velocity_error": f"unknown (NaN) {beads_in_words(unknown)}"}


def velocity_errors(radii: Array, exponent: float) -> Array | None:
    """Estimated errors of the velocities by the formula, also where the result is meaningless.

    This is much faster than `local_rate`.  The result is `None` if a rate is outside the tables.
    """
    from ..kernels import local_rate_pulse as kernel

    functions, of, beads = universal_functions(exponent), powers(exponent), len(radii)
    by_bead, by_contact = np.empty((3, beads)), np.empty((2, beads - 1))
    wanted = of["residence"], of["peak_overlap"]
    # The kernel is compiled for the radii of chains, which cannot be changed.
    radii = radii.view()
    radii.setflags(write=False)
    largest, _ = kernel.pulse(
        radii, functions.arrays, functions.error, *wanted, by_bead, by_contact
    )
    if not np.isfinite(largest):
        return None
    _with_accumulated(largest, radii, by_bead[1, 1:], functions)
    return by_bead[1]


@checked_arguments("local_rate_gradient")
def local_rate_gradient(
    chain: Chain, quantity: str = "velocity", *, bead: int
) -> tuple[float, Array]:
    r"""Value of the local-rate law at one bead, and its logarithmic derivatives by all radii.

    .. math:: Q_k, \qquad \frac{\partial \ln Q_k}{\partial \ln R_j}, \quad j = 1..N

    The derivatives of the law are computed by the adjoint method, to rounding errors.  They
    differ from those of the simulated pulse by up to 0.6% of the largest one in tapers with rates
    above -0.03, also if radii scatter by 0.3%, and by up to 2% in steeper forward tapers; see
    `gradient` for derivatives of the simulation.  They depend only on the chain up to seven beads
    ahead of the bead, or up to bead 11.  The units are kept fixed when :math:`R_1` is
    varied: the impact velocity is 1 and masses are :math:`R^3`.

    Parameters
    ----------
    chain : Chain
        As for `local_rate`, struck by its first bead and without losses.
    quantity : str
        ``"velocity"``, ``"momentum"``, ``"energy"``, ``"arrival"`` or ``"residence"`` of the
        bead, or ``"peak_force"`` on the next bead.
    bead : int
        Bead k, from 1 to N; up to N - 1 for residence time and force, from 2 for the arrival.

    Returns
    -------
    value : float
        :math:`Q_k` [scaled, or SI], equal to that of `local_rate`.
    gradient : ndarray, shape (N,)
        Logarithmic derivatives, in percent per 1%, as of ``gradient(...).relative("radii")``.

    Raises
    ------
    InputError
        In the cases listed for `local_rate`, or if the quantity is unknown or the bead is out
        of range.

    Warns
    -----
    ModelRangeWarning
        In the cases listed for `local_rate`, for the chain up to the bead.

    Examples
    --------
    If all radii are multiplied by a factor, the momentum of the last bead grows like the masses:

    >>> import hertzchain as hc
    >>> chain = hc.Chain.tapered("forward-linear", 0.01, beads=50)
    >>> momentum, gradient = hc.local_rate_gradient(chain, "momentum", bead=50)
    >>> round(float(gradient.sum()), 9)
    3.0
    """
    from ..kernels import local_rate_pulse as kernel

    check_choice("quantity", quantity, DIFFERENTIABLE)
    scaled = scaled_chain(chain, "local_rate_gradient", alternative="use gradient")
    functions = _checked_functions(scaled)
    first = 2 if quantity == "arrival" else 1
    last = QUANTITIES[quantity].count(chain.beads)
    bead = whole_number("bead", bead, least=first, most=last)
    found = np.empty(chain.beads)
    of = "residence" if quantity == "arrival" else quantity
    # The arrival time is the sum of all previous residence times.
    begin, end = (0, bead - 1) if quantity == "arrival" else (bead - 1, bead)
    followed = end if QUANTITIES[of].per == "contact" else bead - 1
    value, error = kernel.gradient(
        scaled.radii,
        functions.arrays,
        functions.error,
        powers(chain.exponents)[of],
        begin,
        end,
        followed,
        found,
    )
    # The largest error of the kernel, with those that accumulate up to the last contact.
    error = _with_accumulated(error, scaled.radii, np.full(followed, error), functions)
    if not error <= DOUBTFUL:
        _warn_outside(scaled, functions, followed + 1)
    if chain.units == "SI" and chain.materials is not None:
        warn_outside_hertz(chain, method="local-rate law")
    value *= (0.5 if quantity == "energy" else 1.0) * unit_of(chain, quantity)
    return value, found


@dataclass(frozen=True, eq=False)
class Solution:
    r"""Rates and states of all contacts, and the terms of the error estimate.

    Attributes
    ----------
    rates : ndarray, shape (N - 1,)
        Rates :math:`s_k` of the contacts.
    slow : ndarray, shape (N - 1,)
        Slow rates :math:`q_k`.
    states : ndarray, shape (N - 1, 3)
        States :math:`z_k`.
    error_parts : ndarray, shape (N - 1, 16)
        Terms of the estimated error of the logarithm of velocity, see
        `hertzchain.kernels.error_terms.write_parts`.
    lost : int
        First contact, from 0, whose state has begun to diverge; the number of contacts if there
        is none.
    """

    rates: Array
    slow: Array
    states: Array
    error_parts: Array
    lost: int

    @property
    def log_velocity(self) -> Array:
        """Logarithms of the velocities, shape (N,)."""
        return np.concatenate(([0.0], np.cumsum(self.states[:, 0])))

    def error(self, functions: UniversalFunctions) -> Array:
        """Estimated relative errors of the velocities, shape (N - 1,); NaN if unknown."""
        from ..kernels.local_rate_pulse import estimated_error

        constants, lost = functions.error, self.lost
        each = range(len(self.rates))
        errors = np.array([estimated_error(k, self.error_parts, constants, lost) for k in each])
        slow = self.slow[: len(errors)]
        add_accumulated(errors, slow, functions)
        add_lost_maxima(errors, slow, functions.exponent)
        return _known(errors, self.rates, functions)


def solve(chain: Chain, functions: UniversalFunctions) -> Solution:
    """Evaluate the law along a chain."""
    from ..kernels import error_terms
    from ..kernels import local_rate_pulse as kernel

    _, rates = kernel.logarithms(chain.radii)
    contacts = len(rates)
    slow, fast = kernel.divide(rates, contacts)
    states, parts = np.empty((contacts, 3)), np.empty((contacts, error_terms.PARTS))
    # These are needed only for the gradient.
    deviations, slopes = np.empty((contacts, 3)), np.empty((contacts, 3, 2))
    lost, _, _ = kernel.evaluate(
        rates, slow, fast, functions.arrays, states, deviations, slopes, parts
    )
    return Solution(rates, slow, states, parts, lost)


def _checked_functions(chain: Chain) -> UniversalFunctions:
    if chain.beads < MIN_BEADS:
        raise InputError(
            f"the local-rate law requires at least {MIN_BEADS} beads, got {chain.beads}; use "
            "propagate"
        )
    return universal_functions(chain.exponents)


def _warn_outside(
    chain: Chain, functions: UniversalFunctions, bead: int, theory: str = "local_rate",
    advice: str = "",
) -> None:  # fmt: skip
    """Issue a warning that states why the chain up to a bead is outside the law's range."""
    solution, (low, high) = solve(chain, functions), functions.range
    rates = solution.rates[: bead - 1]
    outside = ~((rates >= low) & (rates <= high))
    if outside.any():
        k = int(np.argmax(outside))
        reason = (
            f"the rate ln(R_{k + 2}/R_{k + 1}) = {_unlike(rates[k], low, high)} is outside {low:g} "
            f"to {high:g}, and the error from bead {k + 2} on is unknown"
        )
    else:
        error = solution.error(functions)
        reason = _reason(error[: bead - 1], "the end" if bead == chain.beads else f"bead {bead}")
    advice = advice or f"use propagate{_other_theory(chain, theory)}"
    warn_user(
        f"{theory} may be inaccurate for this chain ({chain.description}): {reason}; {advice}",
        ModelRangeWarning,
    )


def _reason(errors: Array, last: str) -> str:
    """Where estimated errors of the beads from 2 on are too large, and where they are unknown."""
    reasons, known = [], np.isfinite(errors)
    above = known & (errors > DOUBTFUL)
    if above.any():
        k = int(np.argmax(above))
        at_end = f" and is {errors[-1]:.1%} at {last}" if known[-1] else ""
        reasons.append(
            f"the estimated velocity error exceeds {DOUBTFUL:.1%} first at bead {k + 2}{at_end}"
        )
    if not known.all():
        unknown = np.append(False, ~known)
        reasons.append(f"the velocity error is unknown {beads_in_words(unknown)}")
    return ", and ".join(reasons)


def _is_known_decoration(chain: Chain) -> bool:
    """Whether a decorated taper is one for which simulations were compared with the plain one."""
    found = decoration_of(chain.radii)
    if found is None or found.between > 1 or found.ratio > DECORATED_RATIO:
        return False
    return bool(np.abs(np.diff(np.log(found.large))).max() < DECORATED_RATE)


def _other_theory(chain: Chain, theory: str) -> str:
    """Another theory for chains that are not smooth, if there is one."""
    if small_beads(chain.radii).any():
        words = ", or effective_chain for the times of large beads (its velocities are too large)"
        if _is_known_decoration(chain):
            # The BCA exceeds velocities by half; those of the plain taper differ by 3.5% at most.
            words += f"; {theory} of the large beads alone gives their velocities within 4%"
        return words
    if chain.exponents != HERTZ_EXPONENT or theory != "local_rate":
        return ""
    if alternates(chain.masses).mean() > MOSTLY:
        return ""
    return ", or piecewise_local_rate for steps and odd beads"


def _unlike(rate: float, *limits: float) -> str:
    """A rate with so many digits that it differs from the limits."""
    texts = (f"{rate:.{digits}g}" for digits in range(3, 17))
    return next((each for each in texts if float(each) not in limits), repr(float(rate)))

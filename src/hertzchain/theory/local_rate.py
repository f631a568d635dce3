r"""The local-rate law: the leading pulse of any taper, right to a fraction of a per cent.

An exponential chain, of one rate :math:`s = \ln(R_{k+1}/R_k)`, looks the same from every bead,
so that after a few beads the velocity changes by one factor :math:`e^{\sigma(s)}` a bead, which
depends on s alone.  In any other chain the pulse is close to that of the local rate and
remembers, for a few beads, the rates that it came through; the law adds the response to their
differences, to second degree, and the start at the strike and at the free end likewise.  The
functions of the rate it needs are in the tables of `hertzchain.theory.universal`.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Final, Literal, get_args

import numpy as np

from hertzchain.chain.chain import Chain
from hertzchain.chain.coverage import require
from hertzchain.checks import whole_number
from hertzchain.contacts import Array
from hertzchain.errors import InputError, ModelRangeWarning, unknown_name
from hertzchain.pulse.pulse import Pulse
from hertzchain.pulse.quantities import PER_CONTACT
from hertzchain.theory.universal import (
    FEWEST_BEADS,
    UniversalFunctions,
    log_scales,
    universal_functions,
)

Quantity = Literal["velocity", "momentum", "energy", "arrival", "residence", "peak_force"]
DIFFERENTIABLE: Final[tuple[Quantity, ...]] = get_args(Quantity)
# What they are powers of: of the bead's mass and of its velocity.
POWERS: Final = {"velocity": (0, 1), "momentum": (1, 1), "energy": (1, 2)}
# An estimated error of velocity beyond which a chain is said to be outside the law's range.
DOUBTFUL: Final = 0.02


def local_rate(chain: Chain) -> Pulse:
    r"""Leading pulse of a chain of any taper by the local-rate law.

    .. math::

        v_k = \exp\sum_{j<k} \rho_j, \qquad
        z_k = z^*(s_k) + \sum_i c_i(s_k)\, x_i + \sum_{i\le j} c_{ij}(s_k)\, x_i x_j

    where the state :math:`z_k = (\rho_k, \varphi_k, \tau_k)` is the growth of velocity,
    :math:`\rho_k = \ln(v_{k+1}/v_k)`, and the peak force and the residence time of contact k
    in units of the bead's mass, velocity and stiffness; :math:`z^*(s)` is the state on an
    exponential chain of rate s, and x holds the deviation of the state before from its
    :math:`z^*` and the differences of the rates :math:`s_{k-2} \dots s_{k+2}`
    (not in the paper; derived in the explanation "A law for any taper").

    Parameters
    ----------
    chain : Chain
        A chain of at least nine beads, of which neighbours may differ in radius by factors
        from 0.85 to 3, changing from bead to bead.  Best where the factor changes slowly.

    Returns
    -------
    Pulse
        Velocity with its estimated relative error, arrival, residence, peak overlaps
        (momentum, energy and force follow).

    Raises
    ------
    InputError
        For a chain of fewer beads, or an exponent that there are no tables for.

    Warns
    -----
    ModelRangeWarning
        If a rate lies outside the tables, or the estimated error of a velocity exceeds 2 %.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.tapered("backward-linear", 0.5, beads=100)
    >>> comparison = hc.local_rate(chain).compare(hc.propagate(chain))
    >>> comparison.worst("velocity") < 1e-3
    True
    """
    solution = solve(chain, _checked_functions(chain))
    log_force, log_time = (
        scale + solution.states[:, column]
        for column, scale in enumerate(log_scales(chain, solution.log_velocity), start=1)
    )
    residence = np.exp(log_time)
    error = solution.estimated_error
    _warn_outside(solution, error)
    return Pulse(
        chain=chain,
        method="local-rate law",
        velocity=np.exp(solution.log_velocity),
        arrival=np.concatenate(([0.0], np.cumsum(residence))),
        peak_overlap=(np.exp(log_force) / chain.stiffness) ** (1.0 / chain.exponent),
        residence=residence,
        velocity_error=error,
    )


def local_rate_gradient(
    chain: Chain, quantity: Quantity = "velocity", *, bead: int
) -> tuple[float, Array]:
    r"""Value of the local-rate law at one bead, and its derivatives to the radii of all beads.

    .. math:: Q_k, \qquad \frac{\partial \ln Q_k}{\partial \ln R_j}, \quad j = 1..N

    The derivatives are exact for the law, by its adjoint, and all cost together about as much
    as the law.  The units stay when :math:`R_1` is varied: the strike has velocity 1 and masses
    are :math:`R^3`.

    Parameters
    ----------
    chain : Chain
        As for `local_rate`.
    quantity : str
        ``"velocity"``, ``"momentum"``, ``"energy"`` or ``"arrival"`` of a bead,
        ``"residence"`` on it or ``"peak_force"`` on the next one.
    bead : int
        Bead k, from 1; for residence and force up to N - 1, for the arrival from 2.

    Returns
    -------
    value : float
        :math:`Q_k` [scaled], the same as that of `local_rate`.
    gradient : ndarray, shape (N,)

    Raises
    ------
    InputError
        As `local_rate`, and for an unknown quantity or a bead outside its range.

    Warns
    -----
    ModelRangeWarning
        As `local_rate`.

    Examples
    --------
    With all beads larger by a factor, the last one's momentum grows as the masses.

    >>> import hertzchain as hc
    >>> chain = hc.Chain.tapered("forward-linear", 0.01, beads=50)
    >>> momentum, gradient = local_rate_gradient(chain, "momentum", bead=50)
    >>> round(float(gradient.sum()), 9)
    3.0
    """
    if quantity not in DIFFERENTIABLE:
        raise unknown_name("quantity", quantity, DIFFERENTIABLE)
    first = 2 if quantity == "arrival" else 1
    last = chain.beads - 1 if quantity in PER_CONTACT else chain.beads
    bead = whole_number("bead", bead, least=first, most=last)
    solution = solve(chain, _checked_functions(chain))
    _warn_outside(solution, solution.estimated_error)
    seeds = _Seeds(solution)
    k = bead - 1
    if quantity in ("arrival", "residence"):
        contacts = slice(k) if quantity == "arrival" else slice(k, bead)
        log_time = (
            solution.states[contacts, 2] + log_scales(chain, solution.log_velocity)[1][contacts]
        )
        time = np.exp(log_time)
        seeds.residence(contacts, time / time.sum())
        return float(time.sum()), seeds.pulled_back()
    if quantity == "peak_force":
        seeds.peak_force(k)
        log_unit = log_scales(chain, solution.log_velocity)[0][k]
        return float(np.exp(solution.states[k, 1] + log_unit)), seeds.pulled_back()
    mass, velocity = POWERS[quantity]
    seeds.log_mass[k] = mass
    seeds.log_velocity[k] = velocity
    value = np.exp(velocity * solution.states[:k, 0].sum()) * chain.radii[k] ** (3 * mass)
    return float(0.5 * value if quantity == "energy" else value), seeds.pulled_back()


@dataclass(frozen=True, eq=False)
class Solution:
    r"""The states of all contacts by the law and what they came from.

    Attributes
    ----------
    chain : Chain
        The chain.
    functions : UniversalFunctions
        The universal functions used.
    rates : ndarray, shape (N - 1,)
        Rates :math:`s_k` of the contacts.
    states : ndarray, shape (N - 1, 3)
        States :math:`z_k`.
    slopes : ndarray, shape (N - 1, 3, 2)
        Derivatives of the states to the contact's own rate, and of their anchors.
    inputs : ndarray, shape (N - 1, 7)
        Deviations :math:`x_k`.
    error_parts : ndarray, shape (N - 1, 4)
        What the estimated error is made of: one; :math:`(\sum_j |x_j|^2)^{1/2}` over the
        contacts after the strike, and over all others; and, of the others,
        :math:`[\sum_j (|x_j| q_j)^2]^{1/2}` with the size :math:`q_j` of the growth's terms of
        second degree, in proportion to the third degree, which is left out.
    lost : int
        First contact, from 0, whose state ran away and was set back; their number if none.
    """

    chain: Chain
    functions: UniversalFunctions
    rates: Array
    states: Array
    slopes: Array
    inputs: Array
    error_parts: Array
    lost: int

    @property
    def log_velocity(self) -> Array:
        """Logarithms of the velocities, shape (N,)."""
        return np.concatenate(([0.0], np.cumsum(self.states[:, 0])))

    @property
    def estimated_error(self) -> Array:
        """Estimated relative error of the velocities, shape (N,)."""
        error = self.error_parts @ self.functions.error
        # From where a state has run away nothing is known.
        error[self.lost :] += 1.0
        return np.concatenate(([0.0], error))


def solve(chain: Chain, functions: UniversalFunctions) -> Solution:
    """Follow the law along a chain.

    Parameters
    ----------
    chain : Chain
        The chain, of at least nine beads.
    functions : UniversalFunctions
        Those of its exponent.

    Returns
    -------
    Solution

    Examples
    --------
    >>> import hertzchain as hc
    >>> solution = solve(hc.Chain.uniform(40), universal_functions(1.5))
    >>> float(np.exp(solution.log_velocity[30]).round(3))
    0.682
    """
    from hertzchain.kernels import local_rate as kernel

    log_radii = np.log(chain.radii)
    rates = log_radii[1:] - log_radii[:-1]
    states, slopes = np.empty((len(rates), 3)), np.empty((len(rates), 3, 2))
    inputs, parts = np.empty((len(rates), kernel.INPUTS)), np.empty((len(rates), 4))
    f = functions
    lost = kernel.forward(
        rates, f.nodes, f.anchors, f.knots, f.response, states, slopes, inputs, parts
    )
    return Solution(chain, functions, rates, states, slopes, inputs, parts, lost)


class _Seeds:
    """Derivatives of one number to everything it is made from, and so to the radii."""

    def __init__(self, solution: Solution) -> None:
        self.solution = solution
        beads = solution.chain.beads
        self.states = np.zeros_like(solution.states)
        self.log_velocity, self.log_mass = np.zeros(beads), np.zeros(beads)
        self.log_stiffness = np.zeros(beads - 1)

    def residence(self, contact: slice, weight: Array) -> None:
        """Add the weighted logarithm of residence times; see `log_scales` for the exponents."""
        p = self.solution.chain.exponent
        self.states[contact, 2] += weight
        self.log_mass[contact] += weight / (p + 1.0)
        self.log_stiffness[contact] -= weight / (p + 1.0)
        self.log_velocity[contact] -= weight * (p - 1.0) / (p + 1.0)

    def peak_force(self, contact: int) -> None:
        """Add the logarithm of a peak force."""
        p = self.solution.chain.exponent
        self.states[contact, 1] += 1.0
        self.log_stiffness[contact] += 1.0 / (p + 1.0)
        self.log_mass[contact] += p / (p + 1.0)
        self.log_velocity[contact] += 2.0 * p / (p + 1.0)

    def pulled_back(self) -> Array:
        """Derivatives to the logarithms of all radii, shape (N,)."""
        from hertzchain.kernels.local_rate import backward

        solution = self.solution
        # A velocity is made of the growth at all contacts before.
        self.states[:, 0] += np.cumsum(self.log_velocity[:0:-1])[::-1]
        to_rates = np.zeros(len(solution.rates))
        f = solution.functions
        backward(
            solution.rates,
            f.knots,
            f.response,
            solution.slopes,
            solution.inputs,
            self.states,
            to_rates,
        )
        found = 3.0 * self.log_mass
        found[1:] += to_rates
        found[:-1] -= to_rates
        if self.log_stiffness.any():
            radii = solution.chain.radii
            half = 0.5 * self.log_stiffness / (radii[:-1] + radii[1:])
            found[1:] += half * radii[:-1]
            found[:-1] += half * radii[1:]
        return found


def _checked_functions(chain: Chain) -> UniversalFunctions:
    require(chain, "the local-rate law", instead="use simulate")
    if chain.beads < FEWEST_BEADS:
        raise InputError(
            f"the local-rate law needs at least {FEWEST_BEADS} beads, got {chain.beads}: "
            "strike and free end must not meet; use propagate"
        )
    return universal_functions(chain.exponent)


def _warn_outside(solution: Solution, error: Array) -> None:
    low, high = solution.functions.range
    outside = (solution.rates < low) | (solution.rates > high)
    if outside.any():
        k = int(np.argmax(outside))
        reason = (
            f"rate ln(R_{k + 2}/R_{k + 1}) = {solution.rates[k]:.3g} is outside {low:g} to {high:g}"
        )
    elif error[-1] > DOUBTFUL:
        k = int(np.argmax(error > DOUBTFUL))
        reason = (
            f"the radii change too unevenly: from bead {k + 1} on its velocities may be off by "
            f"more than {DOUBTFUL:.0%}, at the end by {error[-1]:.1%}"
        )
    else:
        return
    warnings.warn(
        f"outside the range of the local-rate law, {solution.chain.description}: {reason}; "
        "use propagate",
        ModelRangeWarning,
        stacklevel=3,
    )

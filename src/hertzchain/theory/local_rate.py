r"""The local-rate law: the leading pulse of smooth tapers, right to a fraction of a per cent.

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

from hertzchain.arguments import one_of
from hertzchain.chain.chain import Chain
from hertzchain.chain.coverage import require
from hertzchain.checks import whole_number
from hertzchain.contacts import Array
from hertzchain.errors import InputError, ModelRangeWarning
from hertzchain.pulse.pulse import Pulse
from hertzchain.pulse.quantities import PER_CONTACT
from hertzchain.theory.universal import (
    FEWEST_BEADS,
    UniversalFunctions,
    powers,
    universal_functions,
)

Quantity = Literal["velocity", "momentum", "energy", "arrival", "residence", "peak_force"]
DIFFERENTIABLE: Final[tuple[Quantity, ...]] = get_args(Quantity)
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
        from 0.85 to 3.  The factor must change slowly: where radii alternate or scatter from
        bead to bead, however little, the law is wrong and its estimate too small (see Notes).

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

    Notes
    -----
    The estimated error is a measure of smoothness, found on ramps, and no bound.  A hundred
    spheres of radii 1 and 0.99 in turn are off by 7.7 %, with an estimate of 0.7 % and no
    warning; with a scatter of 0.3 % a velocity is off by some 0.5 %, which the estimate covers at
    a fifth to a third of the beads.  The last three beads are off by more than the others.  There,
    use `propagate`.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.tapered("backward-linear", 0.5, beads=100)
    >>> comparison = hc.local_rate(chain).compare(hc.propagate(chain))
    >>> comparison.worst("velocity") < 1e-3
    True
    """
    from hertzchain.kernels import local_rate as kernel

    functions, of = _checked_functions(chain), powers(chain.exponent)
    by_bead, by_contact = np.empty((3, chain.beads)), np.empty((2, chain.beads - 1))
    wanted = of["residence"], of["peak_overlap"]
    error = kernel.pulse(
        chain.radii, *functions.tables, functions.error, *wanted, by_bead, by_contact
    )
    if not error <= DOUBTFUL:
        _warn_outside(chain, functions, chain.beads)
    velocity, velocity_error, arrival = by_bead
    residence, peak_overlap = by_contact
    return Pulse(
        chain=chain,
        method="local-rate law",
        velocity=velocity,
        arrival=arrival,
        peak_overlap=peak_overlap,
        residence=residence,
        velocity_error=velocity_error,
    )


def local_rate_gradient(
    chain: Chain, quantity: Quantity = "velocity", *, bead: int
) -> tuple[float, Array]:
    r"""Value of the local-rate law at one bead, and its derivatives to the radii of all beads.

    .. math:: Q_k, \qquad \frac{\partial \ln Q_k}{\partial \ln R_j}, \quad j = 1..N

    The derivatives are exact for the law, by its adjoint, and all together cost little more
    than the value.  They are derivatives of the law, not of the chain: in the middle those of a
    velocity differ from an integration's by some 3 %, those of the last bead's by half.  Only the
    chain up to the bead, and two beads ahead, has a part in them.  The
    units stay when :math:`R_1` is varied: the strike has velocity 1 and masses are
    :math:`R^3`.

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
        As `local_rate`, for the chain up to the bead.

    Examples
    --------
    With all beads larger by a factor, the last one's momentum grows as the masses.

    >>> import hertzchain as hc
    >>> chain = hc.Chain.tapered("forward-linear", 0.01, beads=50)
    >>> momentum, gradient = local_rate_gradient(chain, "momentum", bead=50)
    >>> round(float(gradient.sum()), 9)
    3.0
    """
    from hertzchain.kernels import local_rate as kernel

    one_of("quantity", quantity, DIFFERENTIABLE)
    functions = _checked_functions(chain)
    first = 2 if quantity == "arrival" else 1
    last = chain.beads - 1 if quantity in PER_CONTACT else chain.beads
    bead = whole_number("bead", bead, least=first, most=last)
    found = np.empty(chain.beads)
    of = "residence" if quantity == "arrival" else quantity
    # The arrival is the sum of all residence times before.
    begin, end = (0, bead - 1) if quantity == "arrival" else (bead - 1, bead)
    followed = end if of in PER_CONTACT else bead - 1
    value, error = kernel.gradient(
        chain.radii,
        *functions.tables,
        functions.error,
        powers(chain.exponent)[of],
        begin,
        end,
        followed,
        found,
    )
    if not error <= DOUBTFUL:
        _warn_outside(chain, functions, followed + 1)
    return 0.5 * value if quantity == "energy" else value, found


@dataclass(frozen=True, eq=False)
class Solution:
    r"""The states of all contacts by the law and what they came from.

    Attributes
    ----------
    rates : ndarray, shape (N - 1,)
        Rates :math:`s_k` of the contacts.
    states : ndarray, shape (N - 1, 3)
        States :math:`z_k`.
    error_parts : ndarray, shape (N - 1, 4)
        What the estimated error is made of: one; :math:`(\sum_j |x_j|^2)^{1/2}` over the
        contacts after the strike, and over all others; and, of the others,
        :math:`[\sum_j (|x_j| q_j)^2]^{1/2}` with the size :math:`q_j` of the growth's terms of
        second degree, in proportion to the third degree, which is left out.
    lost : int
        First contact, from 0, whose state ran away and was set back; their number if none.
    """

    rates: Array
    states: Array
    error_parts: Array
    lost: int

    @property
    def log_velocity(self) -> Array:
        """Logarithms of the velocities, shape (N,)."""
        return np.concatenate(([0.0], np.cumsum(self.states[:, 0])))


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

    _, rates = kernel.logarithms(chain.radii)
    contacts = len(rates)
    states, parts = np.empty((contacts, 3)), np.empty((contacts, 4))
    # What only the gradient needs.
    slopes, to_inputs = np.empty((contacts, 3, 2)), np.empty((contacts, 3, kernel.FORM))
    lost = kernel.forward(rates, contacts, *functions.tables, states, slopes, to_inputs, parts)
    return Solution(rates, states, parts, lost)


def _checked_functions(chain: Chain) -> UniversalFunctions:
    require(chain, "the local-rate law", instead="use simulate")
    if chain.beads < FEWEST_BEADS:
        raise InputError(
            f"the local-rate law needs at least {FEWEST_BEADS} beads, got {chain.beads}: "
            "strike and free end must not meet; use propagate"
        )
    return universal_functions(chain.exponent)


def _warn_outside(chain: Chain, functions: UniversalFunctions, bead: int) -> None:
    """Say what is wrong with the chain up to a bead."""
    solution, (low, high) = solve(chain, functions), functions.range
    rates = solution.rates[: bead - 1]
    outside = ~((rates >= low) & (rates <= high))
    if outside.any():
        k = int(np.argmax(outside))
        reason = f"rate ln(R_{k + 2}/R_{k + 1}) = {rates[k]:.3g} is outside {low:g} to {high:g}"
    else:
        error = solution.error_parts @ functions.error
        error[solution.lost :] += 1.0
        k = int(np.argmax(~(error <= DOUBTFUL)))
        place = "the end" if bead == chain.beads else f"bead {bead}"
        reason = (
            f"the radii change too unevenly: from bead {k + 2} on its velocities may be off by "
            f"more than {DOUBTFUL:.0%}, at {place} by {error[bead - 2]:.1%}"
        )
    warnings.warn(
        f"outside the range of the local-rate law, {chain.description}: {reason}; use propagate",
        ModelRangeWarning,
        stacklevel=3,
    )

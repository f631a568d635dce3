r"""The binary collision approximation (BCA): one contact acts at a time.

Bead k collides with bead k + 1 at rest, transfers momentum as in an isolated elastic
collision, and is then left behind.  Secs. 2 to 4 of the paper.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..chain.chain import Chain
from ..chain.tapers import check_taper, exponential_rate, rate_symbol
from ..collision import (
    Array,
    collision_cascade,
    collision_overlap,
    compression_time,
    reduced_mass,
)
from ..pulse.chain_units import for_any_units
from ..pulse.pulse import Pulse
from ..validation.keywords import checked_arguments
from ..validation.numbers import FRACTION, number
from .alternating_masses import warn_if_alternating
from .decoration import warn_if_decorated


def _alternative(features: Sequence[str]) -> str:
    if {*features} <= {"SI units", "loss"}:
        return "use simulate, or bca(chain.replace(loss=None), restitution=e)"
    return "use simulate"


@checked_arguments("bca")
@for_any_units("the BCA", supported=("masses", "stiffness"), alternative=_alternative)
def bca(chain: Chain, *, restitution: float = 1.0) -> Pulse:
    r"""Leading pulse of any chain by the binary collision approximation.

    .. math::

        v_k = \prod_{j=1}^{k-1} \frac{1 + e}{1 + m_{j+1}/m_j},
        \qquad t_k = \sum_{j=1}^{k-1} T_j

    For e = 1 the velocities are Eq. (5) of the paper (the exact product, not its asymptotic
    form).  The residence time :math:`T_j` of the pulse on bead j is
    `hertzchain.collision.compression_time`.

    For e < 1, all loss of a collision is assumed to occur during unloading, as if the
    unloading force were :math:`e^2` times the loading force at the same overlap.  Loading
    is then elastic; arrival times and overlaps follow from the elastic formulas at
    the reduced velocities.

    A chain with a loss law loses less.  In a binary collision of equal beads, the contact stores
    half of the energy; in the pulse, which extends over several beads, it stores at most 38%,
    and it is compressed more gradually.  At the same e, `simulate` gives 0.29 to 0.85 times this
    theory's decay rate per bead, depending on the law (see the table in the explanation "Closed
    forms").  A coefficient measured in a drop test therefore overestimates the loss, in the
    exponent, by a factor of 1.2 to 3.4.  For small losses in equal beads, `attenuation` is exact.

    Parameters
    ----------
    chain : Chain
        Any chain whose beads change little from one to the next; for small beads
        between large ones, see `effective_chain`.
    restitution : float
        Coefficient of restitution e of every collision, 0 < e <= 1.  Below 1 the decay is
        overestimated (see above).

    Returns
    -------
    Pulse
        Velocity, arrival time, largest overlap and residence time; momentum, energy and
        force are derived from them.

    Raises
    ------
    InputError
        If a velocity underflows, or the restitution is out of range.

    Warns
    -----
    ModelRangeWarning
        If there are small beads between large ones (see `effective_chain`), or if the masses
        alternate, as in dimers, so much that this reduces the velocity by a factor of more than
        2.5.

    Notes
    -----
    The theory does not estimate its error (``velocity_error`` is `None`).  `scoreboard` measures
    it: velocities are too large by about 50% in most tapers, and by 150% or more in strong forward
    ones; arrival times are accurate to 3% in nearly all chains, and to 9% in steep backward
    tapers.  Where masses alternate, velocities are too small by a factor that grows along the
    chain, because the pulse of the simulation spreads over several beads and responds to the mean
    of their masses.  The warning compares the loss
    :math:`\sum_k\ln\cosh\tfrac12 d_k`, with :math:`d_k = \ln(m_{k+1}/m_k)`, with that of the means
    :math:`\tfrac14 d_{k-1} + \tfrac12 d_k + \tfrac14 d_{k+1}`.

    Examples
    --------
    The BCA does not account for the spreading of the pulse: in a uniform chain the velocity
    stays 1, while the simulation gives 0.6816.

    >>> import hertzchain as hc
    >>> pulse = hc.bca(hc.Chain.uniform(50))
    >>> float(pulse.velocity[49]), round(float(pulse.residence[0]), 6)
    (1.0, 1.219419)
    """
    m, e = chain.masses, number("restitution", restitution, unit=FRACTION, above=0.0, most=1.0)
    velocity = collision_cascade(m, e)
    reduced, speed = reduced_mass(m[:-1], m[1:]), velocity[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        time = compression_time(reduced, chain.stiffness, speed, chain.exponents)
        overlap = collision_overlap(reduced, chain.stiffness, speed, chain.exponents)
    pulse = Pulse(
        chain=chain,
        method="BCA" if e == 1.0 else f"BCA, e = {e:g}",
        velocity=velocity,
        arrival=np.concatenate(([0.0], np.cumsum(time))),
        peak_overlap=overlap,
        residence=time,
        restitution=e,
    )
    if not warn_if_decorated(chain, "the BCA"):
        warn_if_alternating(chain, "the BCA")
    return pulse


@checked_arguments("bca_velocity_closed_form")
def bca_velocity_closed_form(taper: str, rate: float, beads: int) -> Array:
    r"""Closed form of the product of the BCA, for the four tapers of the paper.

    For exponential tapers, Eqs. (12) and (14), with :math:`q \to -q` for a forward taper,

    .. math:: v_k = A^{1-k}, \qquad A = \tfrac12 [1 + (1-q)^{-3}] .

    With restitution e, each velocity is multiplied by :math:`[(1+e)/2]^{k-1}`.

    For linear tapers (derived here, not in the paper), with :math:`a = 1/S` and
    :math:`g(x) = \Gamma(x)\,|\Gamma(x + i\sqrt3/2)|^2`, which follows from
    :math:`m_k + m_{k+1} \propto (x^2+\tfrac34)\,x`,

    .. math::

        v_k^{bl} = \left[\frac{\Gamma(a+k-1)}{\Gamma(a)}\right]^3
                   \frac{g(a+\frac12)}{g(a+k-\frac12)},
        \qquad
        v_k^{fl} = \left[\frac{\Gamma(a+1)}{\Gamma(a-k+2)}\right]^3
                   \frac{g(a-k+\frac32)}{g(a+\frac12)} .

    Parameters
    ----------
    taper : str
        Name of the taper.
    rate : float
        Tapering parameter S or q.
    beads : int
        Number of beads N.

    Returns
    -------
    ndarray, shape (N,)
        Velocities [scaled].

    Raises
    ------
    InputError
        If the taper is unknown, or the rate is impossible for this number of beads.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.theory.bca_velocity_closed_form("backward-linear", 1.0, 3).round(6)
    array([1.      , 0.222222, 0.101587])
    """
    k = np.arange(1, Chain.tapered(taper, rate, beads=beads).beads + 1)
    if rate == 0.0:
        return np.ones(beads)
    if rate_symbol(taper) == "q":
        return np.asarray(np.exp((k - 1) * exponential_rates(taper, rate)["velocity"]))
    from scipy.special import loggamma

    a = 1.0 / rate
    if taper == "backward-linear":
        log_mass_part = 3.0 * (loggamma(a + k - 1) - loggamma(a))
        return np.asarray(np.exp(log_mass_part + _log_g(np.array(a + 0.5)) - _log_g(a + k - 0.5)))
    log_mass_part = 3.0 * (loggamma(a + 1.0) - loggamma(a - k + 2.0))
    return np.asarray(np.exp(log_mass_part + _log_g(a - k + 1.5) - _log_g(np.array(a + 0.5))))


@checked_arguments("exponential_rates")
def exponential_rates(taper: str, rate: float) -> dict[str, float]:
    r"""Rates per bead of velocity, momentum and energy of an exponential taper.

    .. math::

        \frac{d\ln v}{dk} = -\ln \tfrac12\left[1 + (1-q)^{-3}\right], \quad
        \mathcal P = -\ln\left(1 - \tfrac32 q + \tfrac32 q^2 - \tfrac12 q^3\right), \quad
        \mathcal E = -2 \ln \tfrac12\left[(1-q)^{3/2} + (1-q)^{-3/2}\right]

    These are Eqs. (12), (16) and (18) for a backward taper, and with :math:`q \to -q`
    Eqs. (26) and (27) for a forward one.

    Parameters
    ----------
    taper : str
        ``"backward-exponential"`` or ``"forward-exponential"``.
    rate : float
        Tapering parameter q.

    Returns
    -------
    dict
        ``velocity``, ``momentum`` and ``energy``: change of the logarithm per bead.

    Raises
    ------
    InputError
        If the taper is linear and has no constant rate.

    Examples
    --------
    First entries of tables 1 and 2 of the paper:

    >>> import hertzchain as hc
    >>> rates = hc.theory.exponential_rates("backward-exponential", 0.01)
    >>> round(rates["momentum"], 5), round(rates["energy"], 5)
    (0.01496, -0.00023)
    """
    q = exponential_rate(taper, rate)
    return {
        "velocity": float(-np.log(0.5 * (1.0 + (1.0 - q) ** -3))),
        "momentum": float(-np.log(1.0 - 1.5 * q + 1.5 * q**2 - 0.5 * q**3)),
        "energy": float(-2.0 * np.log(0.5 * ((1.0 - q) ** 1.5 + (1.0 - q) ** -1.5))),
    }


@checked_arguments("backward_linear_prefactor")
def backward_linear_prefactor(rate: float) -> float:
    r"""Prefactor of the asymptotic law of backward linear tapers.

    .. math:: v_k \to a_{bl}^u k^{-3/2}, \qquad
              a_{bl}^u = \frac{g(a + \frac12)}{\Gamma(a)^3}, \quad a = 1/S

    This is the constant of Eq. (28), whose value the paper does not state; g is defined in
    `bca_velocity_closed_form`.

    Parameters
    ----------
    rate : float
        Tapering parameter S > 0.

    Raises
    ------
    InputError
        If S is not positive.

    Examples
    --------
    >>> import hertzchain as hc
    >>> round(hc.theory.backward_linear_prefactor(0.1), 6)
    28.262858
    """
    from scipy.special import loggamma

    a = 1.0 / check_taper("backward-linear", rate)
    return float(np.exp(_log_g(np.array(a + 0.5)) - 3.0 * loggamma(a)))


@checked_arguments("forward_linear_momentum_slope")
def forward_linear_momentum_slope(rate: float) -> float:
    r"""Slope of the linear decay of momentum in a forward linear taper.

    .. math:: \frac{dP}{dk} = -\frac32\, S\,(1+S)^2

    This is Eq. (24) and the column "Binary" of table 3.  It differs slightly from the initial
    slope of the exact product of the BCA, :math:`P_2 - P_1 = -\frac32 S (1+S)^{1/2} + \dots`,
    because Eq. (22) omits a factor :math:`(1+S)^{-3/2}`, without which :math:`v_1 \neq 1`.

    Parameters
    ----------
    rate : float
        Tapering parameter, 0 < S < 1.

    Raises
    ------
    InputError
        If S is out of range.

    Examples
    --------
    >>> import hertzchain as hc
    >>> round(hc.theory.forward_linear_momentum_slope(0.01), 4)
    -0.0153
    """
    check_taper("forward-linear", rate)
    return -1.5 * rate * (1.0 + rate) ** 2


def _log_g(x: Array) -> Array:
    from scipy.special import loggamma

    return np.asarray(loggamma(x) + 2.0 * loggamma(x + 0.5j * np.sqrt(3.0)).real)

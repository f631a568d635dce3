r"""The independent-collision theory: hard spheres that collide one pair at a time.

What the literature on tapered chains held its simulations against before there was a
binary collision approximation: S. Sen, F. S. Manciu and M. Manciu, Physica A 299, 551
(2001); R. Doney and S. Sen, Phys. Rev. E 72, 041304 (2005),
doi:10.1103/PhysRevE.72.041304.  Its velocities are those of the BCA with restitution;
collisions take no time, so that it has no residence times, overlaps or forces.
"""

from __future__ import annotations

import math

import numpy as np

from hertzchain.chain.chain import Chain
from hertzchain.chain.coverage import require
from hertzchain.checks import number
from hertzchain.contacts import collision_cascade
from hertzchain.errors import InputError
from hertzchain.pulse.pulse import Pulse
from hertzchain.theory.decoration import warn_if_decorated


def hard_sphere(chain: Chain, *, restitution: float = 1.0) -> Pulse:
    r"""Leading pulse of hard spheres that collide one pair after the other.

    .. math:: v_k = \prod_{j=1}^{k-1} \frac{1 + e}{1 + m_{j+1}/m_j}

    Parameters
    ----------
    chain : Chain
        Any chain; the exponent of its contacts plays no part.
    restitution : float
        Coefficient of restitution e of every collision, 0 < e <= 1; see
        `restitution_from_unloading`.

    Returns
    -------
    Pulse
        Velocity, momentum and energy.  The elastic loss per bead is that of the BCA:
        too small, above all in forward tapers.  The loss by restitution is too large: 1.2 to
        3.4 times, in the exponent, that of a chain with a law of loss of the same e (`bca`).

    Raises
    ------
    InputError
        If the restitution is out of its range, or a velocity underflows.

    Warns
    -----
    ModelRangeWarning
        If there are small beads between large ones, as `effective_chain` finds them.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.hard_sphere(hc.Chain.uniform(4), restitution=0.9).velocity.round(6)
    array([1.      , 0.95    , 0.9025  , 0.857375])
    """
    require(chain, "the hard-sphere theory", covers=("masses", "stiffness", "gaps"))
    e = number("restitution", restitution, above=0.0, most=1.0)
    velocity = collision_cascade(chain.masses, e)
    method = "hard sphere" if e == 1.0 else f"hard sphere, e = {e:g}"
    pulse = Pulse(chain=chain, method=method, velocity=velocity, restitution=e)
    warn_if_decorated(chain, "the hard-sphere theory")
    return pulse


def hard_sphere_energy_ratio(chain: Chain, *, restitution: float = 1.0) -> float:
    r"""Kinetic energy of the last bead over that of the striker.

    .. math::

        \frac{K_N}{K_1} = \prod_{k=1}^{N-1}
        \frac{(1+e)^2\, m_k m_{k+1}}{(m_k + m_{k+1})^2}

    For given end masses it is largest if the masses in between are geometric.  With e < 1 it
    exaggerates the loss in a chain, as `hard_sphere` does.

    Parameters
    ----------
    chain : Chain
        Any chain, decorated ones included.
    restitution : float
        Coefficient of restitution e, 0 < e <= 1.

    Returns
    -------
    float
        At most 1; 0 if it underflows.

    Raises
    ------
    InputError
        If the restitution is out of its range.

    Examples
    --------
    Twenty spheres, each 5 per cent smaller than the one before:

    >>> import hertzchain as hc
    >>> ratio = hard_sphere_energy_ratio(hc.Chain.from_radii(0.95 ** np.arange(20)))
    >>> round(ratio, 6)
    0.893718
    """
    covered = ("SI units", "masses", "stiffness", "gaps")
    require(chain, "the hard-sphere theory", covers=covered)
    m, e = chain.masses, number("restitution", restitution, above=0.0, most=1.0)
    mass_ratio = m[1:] / m[:-1]
    return float(np.prod((1.0 + e) ** 2 * mass_ratio / (1.0 + mass_ratio) ** 2))


def exponential_energy_ratio(q: float, beads: int, *, restitution: float = 1.0) -> float:
    r"""`hard_sphere_energy_ratio` of spheres with :math:`R_{k+1} = (1-q) R_k`, in closed form.

    .. math::

        \frac{K_N}{K_1} =
        \left\{\frac{(1+e)^2 (1-q)^3}{[1 + (1-q)^3]^2}\right\}^{N-1}

    This is the convention of the literature on tapered chains.  The paper's forward
    exponential taper is :math:`R_{k+1} = R_k/(1+q)`; the same chain run from its other
    end has the same ratio.  With e < 1 the loss is exaggerated, as by `hard_sphere`.

    Parameters
    ----------
    q : float
        Tapering parameter, 0 <= q < 1.
    beads : int
        Number of beads N, at least 2.
    restitution : float
        Coefficient of restitution e, 0 < e <= 1.

    Returns
    -------
    float

    Raises
    ------
    InputError
        If one of the three is out of its range.

    Examples
    --------
    >>> round(exponential_energy_ratio(0.05, 20), 6)
    0.893718
    """
    e = number("restitution", restitution, above=0.0, most=1.0)
    if not 0.0 <= q < 1.0:
        raise InputError(f"q must be at least 0 and below 1, got {q:g}; try 0.05")
    if beads < 2:
        raise InputError(f"beads must be at least 2, got {beads}")
    mass_ratio = (1.0 - q) ** 3
    return float(((1.0 + e) ** 2 * mass_ratio / (1.0 + mass_ratio) ** 2) ** (beads - 1))


def restitution_from_unloading(loss: float) -> float:
    r"""Coefficient of restitution of contacts that unload more softly than they load.

    .. math:: e = \sqrt{1 - w}

    If the unloading force is 1 - w times the loading force at the same overlap, the
    contact returns the fraction 1 - w of the energy it took, whatever its law and the
    speed.  The literature on tapered chains gives its losses by this w.  It is the coefficient
    of two beads alone; in a chain a pulse loses less per bead (`bca`).

    Parameters
    ----------
    loss : float
        The fraction w, 0 <= w < 1.

    Returns
    -------
    float
        Coefficient e.

    Raises
    ------
    InputError
        If w is out of its range.

    Examples
    --------
    >>> round(restitution_from_unloading(0.19), 12)
    0.9
    """
    if not 0.0 <= loss < 1.0:
        raise InputError(f"loss w of unloading must be at least 0 and below 1, got {loss:g}")
    return math.sqrt(1.0 - loss)

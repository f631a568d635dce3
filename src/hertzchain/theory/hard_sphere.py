r"""The independent-collision theory: hard spheres that collide one pair at a time.

The literature on tapered chains compared simulations with this theory before the binary
collision approximation was introduced: S. Sen, F. S. Manciu and M. Manciu, Physica A 299,
551 (2001); R. Doney and S. Sen, Phys. Rev. E 72, 041304 (2005),
doi:10.1103/PhysRevE.72.041304.  Its velocities are those of the BCA with restitution.
Collisions are instantaneous; residence times, overlaps and forces are not defined.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..chain.feature_support import require_supported
from ..collision import collision_cascade
from ..pulse.chain_units import for_any_units
from ..pulse.pulse import Pulse
from ..validation.keywords import checked_arguments
from ..validation.numbers import FRACTION, number, whole_number
from .alternating_masses import warn_if_alternating
from .decoration import warn_if_decorated

THEORY: Final = "the hard-sphere theory"


@checked_arguments("hard_sphere")
@for_any_units(THEORY, supported=("masses", "stiffness", "gaps"))
def hard_sphere(chain: Chain, *, restitution: float = 1.0) -> Pulse:
    r"""Leading pulse of hard spheres that collide one pair after the other.

    .. math:: v_k = \prod_{j=1}^{k-1} \frac{1 + e}{1 + m_{j+1}/m_j}

    Parameters
    ----------
    chain : Chain
        Any chain; the result does not depend on the exponent of its contacts.
    restitution : float
        Coefficient of restitution e of every collision, 0 < e <= 1; see
        `restitution_from_unloading`.

    Returns
    -------
    Pulse
        Velocity, momentum and energy.  The elastic loss per bead is that of the BCA; it is
        too small, especially in forward tapers.  The loss due to restitution is too large:
        in the exponent, it is 1.2 to 3.4 times that of a chain with a loss law of the same e
        (see `bca`); for small losses in equal beads, `attenuation` is exact.

    Raises
    ------
    InputError
        If the restitution is out of range, or a velocity underflows.

    Warns
    -----
    ModelRangeWarning
        If there are small beads between large ones (see `effective_chain`), or if masses grow and
        fall from bead to bead (see `bca`).

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.hard_sphere(hc.Chain.uniform(4), restitution=0.9).velocity.round(6)
    array([1.      , 0.95    , 0.9025  , 0.857375])
    """
    e = number("restitution", restitution, unit=FRACTION, above=0.0, most=1.0)
    velocity = collision_cascade(chain.masses, e)
    method = "hard sphere" if e == 1.0 else f"hard sphere, e = {e:g}"
    pulse = Pulse(chain=chain, method=method, velocity=velocity, restitution=e)
    if not warn_if_decorated(chain, THEORY):
        warn_if_alternating(chain, THEORY)
    return pulse


@checked_arguments("hard_sphere_energy_ratio")
def hard_sphere_energy_ratio(chain: Chain, *, restitution: float = 1.0) -> float:
    r"""Ratio of the kinetic energy of the last bead to that of the first.

    .. math::

        \frac{E_N}{E_1} = \prod_{k=1}^{N-1}
        \frac{(1+e)^2\, m_k m_{k+1}}{(m_k + m_{k+1})^2}

    For given first and last mass, it is largest if the masses form a geometric sequence.
    With e < 1 it overestimates the loss, like `hard_sphere`.

    Parameters
    ----------
    chain : Chain
        Any chain, including decorated ones.
    restitution : float
        Coefficient of restitution e, 0 < e <= 1.

    Returns
    -------
    float
        Energy ratio, at most 1; 0 if it underflows.

    Raises
    ------
    InputError
        If the restitution is out of range.

    Examples
    --------
    Twenty spheres, each 5% smaller than the previous one:

    >>> import hertzchain as hc
    >>> import numpy as np
    >>> ratio = hc.theory.hard_sphere_energy_ratio(hc.Chain.from_radii(0.95 ** np.arange(20)))
    >>> round(ratio, 6)
    0.893718
    """
    covered = ("SI units", "masses", "stiffness", "gaps")
    require_supported(chain, THEORY, supported=covered)
    m, e = chain.masses, number("restitution", restitution, unit=FRACTION, above=0.0, most=1.0)
    mass_ratio = m[1:] / m[:-1]
    return float(np.prod((1.0 + e) ** 2 * mass_ratio / (1.0 + mass_ratio) ** 2))


@checked_arguments("exponential_energy_ratio")
def exponential_energy_ratio(q: float, beads: int, *, restitution: float = 1.0) -> float:
    r"""Closed form of `hard_sphere_energy_ratio` for spheres with :math:`R_{k+1} = (1-q) R_k`.

    .. math::

        \frac{E_N}{E_1} =
        \left\{\frac{(1+e)^2 (1-q)^3}{[1 + (1-q)^3]^2}\right\}^{N-1}

    This definition of q is that of the literature on tapered chains; the paper's forward
    exponential taper is :math:`R_{k+1} = R_k/(1+q)`.  The ratio is the same if the chain is
    struck at its other end.  With e < 1 the loss is overestimated, as by `hard_sphere`.

    Parameters
    ----------
    q : float
        Tapering parameter, 0 <= q < 1.
    beads : int
        Number of beads N, at least 2.
    restitution : float
        Coefficient of restitution e, 0 < e <= 1.

    Raises
    ------
    InputError
        If an argument is out of range.

    Examples
    --------
    >>> import hertzchain as hc
    >>> round(hc.theory.exponential_energy_ratio(0.05, 20), 6)
    0.893718
    """
    e = number("restitution", restitution, unit=FRACTION, above=0.0, most=1.0)
    q = number("q", q, unit=FRACTION, least=0.0, below=1.0, hint="try 0.05")
    beads = whole_number("beads", beads, least=2)
    mass_ratio = (1.0 - q) ** 3
    return float(((1.0 + e) ** 2 * mass_ratio / (1.0 + mass_ratio) ** 2) ** (beads - 1))


@checked_arguments("restitution_from_unloading")
def restitution_from_unloading(loss: float) -> float:
    r"""Coefficient of restitution of contacts with a reduced unloading force.

    .. math:: e = \sqrt{1 - w}

    If the unloading force is 1 - w times the loading force at the same overlap, the
    contact returns the fraction 1 - w of the stored energy, for any force law and speed.
    The literature on tapered chains specifies losses by w.  This coefficient holds for an
    isolated collision of two beads; in a chain, a pulse loses less per bead (see `bca`).

    Parameters
    ----------
    loss : float
        Fraction w by which the unloading force is reduced, 0 <= w < 1.

    Returns
    -------
    float
        Coefficient of restitution e.

    Raises
    ------
    InputError
        If w is out of range.

    Examples
    --------
    >>> import hertzchain as hc
    >>> round(hc.theory.restitution_from_unloading(0.19), 12)
    0.9
    """
    return math.sqrt(1.0 - number("loss w of unloading", loss, unit=FRACTION, least=0.0, below=1.0))

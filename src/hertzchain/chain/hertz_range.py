r"""Whether a chain in SI units stays where Hertz' law holds.

Hertz' contacts are small beside the beads, elastic, and slow beside sound.  Each of the
three is a ratio that must be small, with a limit below which nobody need worry:

=====================  ==============================================  ========
ratio                  of                                              limit
=====================  ==============================================  ========
overlap over radius    :math:`d/R = (a/R)^2`, a the contact's radius   0.01
pressure over yield    :math:`p_0/(1.60\,Y)`, first yield below the    1
                       surface (von Mises, nu = 0.3)
speed over sound       closing speed over :math:`\sqrt{E/\rho}`        0.01
=====================  ==============================================  ========

K. L. Johnson, *Contact Mechanics*, Cambridge 1985, Secs. 4.2, 6.1 and 11.4,
doi:10.1017/CBO9781139171731.
"""

from __future__ import annotations

import itertools
import math
import warnings
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from hertzchain.chain.chain import Chain
from hertzchain.chain.coverage import check_chain
from hertzchain.chain.materials import Material
from hertzchain.chain.walls import Wall
from hertzchain.checks import column, real_numbers
from hertzchain.contacts import Array, collision_overlap, reduced_mass
from hertzchain.errors import InputError, ModelRangeWarning

LARGEST_OVERLAP_RATIO: Final = 0.01
LARGEST_SPEED_RATIO: Final = 0.01
# Largest pressure of a contact over the yield strength when its softer body first yields.
FIRST_YIELD: Final = 1.60


@dataclass(frozen=True, eq=False)
class HertzRange:
    """How far a chain's contacts are from the limits of Hertz' law.

    Contacts are counted with the walls, from 0 (left wall) to N (right wall).

    Attributes
    ----------
    overlap_ratio : ndarray, shape (N + 1,)
        Overlap over the effective radius of each contact.
    yield_ratio : ndarray, shape (N + 1,)
        Largest pressure over that of first yield; 0 where no yield strength is known.
    speed_ratio : float
        Fastest closing speed of neighbours at time 0 over the slower of their sound speeds.

    Examples
    --------
    >>> import hertzchain as hc
    >>> print(hertz_range(hc.Chain.from_materials(5e-3, "steel-52100", beads=20)))
    overlap / radius  0.0041 at contact 1 (limit 0.01)
    pressure / yield  1.4 at contact 1 (limit 1)
    speed / sound  0.0002 (limit 0.01)
    """

    overlap_ratio: Array
    yield_ratio: Array
    speed_ratio: float

    @property
    def complaints(self) -> tuple[str, ...]:
        """A sentence for each limit that is exceeded."""
        found = []
        at = int(np.argmax(self.overlap_ratio))
        if self.overlap_ratio[at] > LARGEST_OVERLAP_RATIO:
            found.append(
                f"{_place(at, self)} is pressed in by {self.overlap_ratio[at]:.2g} of its radius, "
                f"more than the {LARGEST_OVERLAP_RATIO:g} up to which Hertz' law is safe"
            )
        at = int(np.argmax(self.yield_ratio))
        if self.yield_ratio[at] > 1.0:
            others = np.count_nonzero(self.yield_ratio > 1.0) - 1
            besides = f" ({others} more exceed it)" if others else ""
            found.append(
                f"the pressure in {_place(at, self)} reaches {self.yield_ratio[at]:.3g} times that "
                f"of first yield{besides}: expect dents, and less force than Hertz' law gives; no "
                "law of loss here has a yield point: reduce the velocity, or use Restitution with "
                "a coefficient measured at this speed"
            )
        if self.speed_ratio > LARGEST_SPEED_RATIO:
            found.append(
                f"beads meet with {self.speed_ratio:.2g} of the speed of sound in them, more than "
                f"the {LARGEST_SPEED_RATIO:g} up to which contacts are static"
            )
        return tuple(found)

    def __str__(self) -> str:
        overlap, pressure = int(np.argmax(self.overlap_ratio)), int(np.argmax(self.yield_ratio))
        return "\n".join(
            (
                f"overlap / radius  {self.overlap_ratio[overlap]:.2g} at contact {overlap} "
                f"(limit {LARGEST_OVERLAP_RATIO:g})",
                f"pressure / yield  {self.yield_ratio[pressure]:.3g} at contact {pressure} "
                "(limit 1)",
                f"speed / sound  {self.speed_ratio:.2g} (limit {LARGEST_SPEED_RATIO:g})",
            )
        )


def hertz_range(chain: Chain, overlaps: ArrayLike | None = None) -> HertzRange:
    """Hold a chain against the limits of Hertz' law.

    Parameters
    ----------
    chain : Chain
        A chain in SI units, of materials.
    overlaps : array_like, optional
        Largest overlap of each contact [m], of length N - 1, or N + 1 with the walls.  If not
        given: as if each pair of beads that approach each other at time 0 collided alone.

    Returns
    -------
    HertzRange

    Raises
    ------
    InputError
        If the chain is not of materials, or there are too few or many overlaps.

    Examples
    --------
    Balls of hardened steel first yield when they meet with some 0.4 m/s, of annealed
    stainless steel with a few mm/s; the pressure goes as the speed to the power 2/5:

    >>> import hertzchain as hc
    >>> for name, speed in (("steel-52100", 0.43), ("steel-304", 0.0015)):
    ...     chain = hc.Chain.from_materials(5e-3, name, beads=2, velocity=speed)
    ...     print(name, hertz_range(chain).yield_ratio.max().round(2))
    steel-52100 1.0
    steel-304 1.0
    """
    check_chain("hertz_range", chain)
    if chain.units != "SI" or chain.materials is None:
        raise InputError(
            "the limits of Hertz' law need materials: make the chain by Chain.from_materials, "
            f"got {chain.description}"
        )
    d = _collisions(chain) if overlaps is None else _with_walls(chain, overlaps)
    bodies = [_wall_material(chain, chain.left_wall, 0), *chain.materials]
    bodies.append(_wall_material(chain, chain.right_wall, -1))
    pairs = list(itertools.pairwise(bodies))
    modulus = 1.0 / np.array([one.compliance + other.compliance for one, other in pairs])
    curvature = np.concatenate(([0.0], 1.0 / chain.radii, [0.0]))
    radius = 1.0 / (curvature[:-1] + curvature[1:])
    strength = np.array(
        [min(one.yield_strength or math.inf, other.yield_strength or math.inf)
         for one, other in pairs]
    )  # fmt: skip
    # Johnson, Eqs. (4.23) and (4.24): a^2 = R d and p_0 = 2 E* d/(pi a).
    pressure = 2.0 / math.pi * modulus * np.sqrt(d / radius)
    sound = np.array([each.sound_speed for each in chain.materials])
    closing = np.maximum(-np.diff(chain.velocities), 0.0)
    return HertzRange(
        overlap_ratio=d / radius,
        yield_ratio=pressure / (FIRST_YIELD * strength),
        speed_ratio=float(np.max(closing / np.minimum(sound[:-1], sound[1:]))),
    )


def warn_outside_hertz(chain: Chain, overlaps: ArrayLike) -> None:
    """Warn of each limit of Hertz' law that a chain in SI units has exceeded.

    Parameters
    ----------
    chain : Chain
        Any chain; one without materials has no limits to exceed.
    overlaps : array_like
        Largest overlap of each contact, as of `hertz_range`.

    Examples
    --------
    >>> import hertzchain as hc
    >>> warn_outside_hertz(hc.Chain.uniform(3), [0.1, 0.1])
    """
    if chain.units == "SI" and chain.materials is not None:
        for complaint in hertz_range(chain, overlaps).complaints:
            warnings.warn(complaint, ModelRangeWarning, stacklevel=3)


def _collisions(chain: Chain) -> Array:
    reduced = reduced_mass(chain.masses[:-1], chain.masses[1:])
    closing = np.maximum(-np.diff(chain.velocities), 0.0)
    alone = collision_overlap(reduced, chain.stiffness, closing, chain.exponent)
    return _with_walls(chain, alone)


def _with_walls(chain: Chain, overlaps: ArrayLike) -> Array:
    values = real_numbers("overlap", overlaps, "contact")
    if values.size == chain.beads - 1:
        values = np.pad(values.reshape(-1), 1)
    return column("overlap", values, chain.beads + 1, "contact", least=0.0)


def _wall_material(chain: Chain, wall: Wall | None, bead: int) -> Material:
    """Of the wall, or the bead's own if none is named."""
    assert chain.materials is not None
    named = None if wall is None else wall.material
    return chain.materials[bead] if named is None else named


def _place(contact: int, found: HertzRange) -> str:
    last = len(found.overlap_ratio) - 1
    return {0: "the left wall's contact", last: "the right wall's contact"}.get(
        contact, f"contact {contact}"
    )

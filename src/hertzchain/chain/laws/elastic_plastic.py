"""Elastic-plastic spheres, which yield above a certain contact pressure."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from ...collision import HERTZ_EXPONENT, Array
from ...errors import InputError
from ...kernels.law_kinds import YIELDING, LawRow
from ...validation.keywords import checked_fields
from ..materials import FIRST_YIELD
from .base import ContactArrays, ContactsAtRest, Loss, parameter

# Steps of Newton's method; up to 6 except near the point of yield, where it has a double root.
MAX_STEPS: Final = 60
# Relative rounding error of a force.
ROUNDING: Final = 1e-13


@checked_fields
@dataclass(frozen=True)
class ElasticPlastic(Loss, name="elastic-plastic"):
    r"""Spheres that yield: Hertz contacts up to a pressure, plastic beyond.

    With the overlap :math:`d_y` and force :math:`F_y = k\,d_y^{3/2}` at which the largest pressure
    in the contact reaches the yield pressure :math:`p_y`, the first loading is

    .. math::

        F = k\,d^{3/2} \ (d \le d_y), \qquad
        F = F_y + \pi p_y R\,(d - d_y) \ (d > d_y), \qquad
        d_y = R \left(\frac{\pi p_y}{2 E^*}\right)^2 ,

    where R is the effective radius and :math:`E^*` the effective modulus that the stiffness
    :math:`k = \frac43 E^* \sqrt{R}` implies.  Below the largest overlap so far,
    :math:`d_m` with force :math:`F_m`, the contact unloads and reloads as a Hertz contact of the
    larger radius :math:`R_p`, and opens at the dent :math:`d_p`, which `hertzchain.Run` has as
    ``dents``:

    .. math::

        F = \tfrac43 E^* \sqrt{R_p}\,(d - d_p)_+^{3/2}, \qquad
        R_p = \frac{4 E^*}{3 F_m} \left(\frac{2 F_m + F_y}{2 \pi p_y}\right)^{3/2}
            = R\,\frac{k\,d_m^{3/2}}{F_m} , \qquad
        d_p = d_m - \frac{F_m}{k \sqrt{d_m}} .

    A collision with the speed v has the restitution (1 up to the yield speed :math:`v_y`)

    .. math::

        e^2 = \frac{6\sqrt3}{5} \left(1 - \frac{u^2}{6}\right)
              \left[\frac{u}{u + 2\sqrt{6/5 - u^2/5}}\right]^{1/2}, \qquad
        u = \frac{v_y}{v}, \qquad \tfrac12 \mu v_y^2 = \tfrac25 F_y d_y .

    C. Thornton, J. Appl. Mech. 64, 383 (1997), doi:10.1115/1.2787319.  As the law of
    a chain, or of pairs of materials, it does not apply to pads between beads (exponent 1), nor to
    walls of another exponent than 3/2 without a law of their own: these stay elastic.  Other
    exponents are rejected.

    Attributes
    ----------
    yield_pressure : float or None
        Largest pressure in a contact, :math:`p_y` > 0 [Pa], in chains in SI units.  If omitted,
        1.60 times the yield strength of the softer material, the pressure of first yield
        (K. L. Johnson, *Contact Mechanics*, Cambridge 1985, Sec. 6.1); the pressure of fully
        plastic contacts is up to 2.8 times the yield strength.  Contacts of two materials without
        a known yield strength, such as rubber on rubber, then stay elastic; at least one contact
        must have a known one.
    yield_overlap : float or None
        Instead, the overlap :math:`d_y` > 0 at which a contact yields [scaled, or m].
    factor : float or None
        Instead, the yield pressure over the yield strength of the softer material, > 0, usually
        1.6 to 2.8; it applies to contacts of all materials.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.from_materials(5e-3, "steel-316", beads=2, velocity=0.1)
    >>> after = hc.simulate(chain.replace(loss=hc.ElasticPlastic()), until=1e-3).velocities[-1]
    >>> round(float(after[1] - after[0]) / 0.1, 3)
    0.415

    At the pressure of fully plastic contacts, the same balls lose less:

    >>> law = hc.ElasticPlastic(factor=2.8)
    >>> round(law.restitution(0.1, chain=chain), 3)
    0.585

    A measured restitution determines the factor, or `yield_pressure` if no yield strength is
    known, or `yield_overlap` in a scaled chain:

    >>> round(hc.ElasticPlastic.from_restitution(0.585, speed=0.1, chain=chain).factor, 2)
    2.8
    """

    yields = True
    leaves_dents = True
    yield_pressure: float | None = parameter(
        "yield pressure", "largest pressure in a contact", "pressure", default=None,
        above=0.0,
    )  # fmt: skip
    yield_overlap: float | None = parameter(
        "yield overlap", "overlap at which a contact yields", "length", default=None, above=0.0
    )
    factor: float | None = parameter(
        "factor", "yield pressure over the yield strength of the softer material", default=None,
        above=0.0,
    )  # fmt: skip

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.yield_pressure is not None and self.yield_overlap is not None:
            raise InputError(
                "ElasticPlastic has a yield_pressure or a yield_overlap, not both: the overlap "
                "at yield follows from the pressure"
            )
        if self.factor is not None and not self.needs_yield_strength:
            other = "yield_overlap" if self.yield_pressure is None else "yield_pressure"
            raise InputError(
                f"ElasticPlastic has a factor or a {other}, not both: the factor of the yield "
                "strength determines the pressure and the overlap at yield"
            )

    @property
    def needs_yield_strength(self) -> bool:
        return self.yield_pressure is None and self.yield_overlap is None

    def row(self, exponent: float) -> LawRow:
        if exponent != HERTZ_EXPONENT:
            raise InputError(
                f"ElasticPlastic is a law of spheres (exponent 1.5), but a contact has p = "
                f"{exponent:g}: use WaltonBraun, or loss=Elastic() for this contact"
            )
        return LawRow(YIELDING)

    def _check_without_chain(self) -> None:
        if self.yield_overlap is None:
            raise InputError(
                "the restitution of ElasticPlastic depends on the overlap at yield, which follows "
                "from materials and radii: give chain=..., or use "
                "ElasticPlastic(yield_overlap=...).restitution(speed, ...)"
            )

    def strength(self, contacts: ContactArrays) -> Array:
        """Overlaps at yield."""
        if self.yield_overlap is not None:
            return np.full(len(contacts.stiffness), self.yield_overlap)
        if contacts.radius is None:
            raise InputError(
                "ElasticPlastic in a scaled chain needs a yield_overlap, because scaled chains "
                "have no pressures; alternatively, use a chain in SI units"
            )
        if np.isinf(contacts.radius[contacts.stiffness > 0.0]).any():
            raise InputError(
                "ElasticPlastic() follows from the radii of spheres, but two flat faces touch: "
                "give a yield_overlap"
            )
        pressure = self._pressures(contacts)
        modulus = 0.75 * contacts.stiffness / np.sqrt(contacts.radius)
        with np.errstate(divide="ignore"):
            first = contacts.radius * (0.5 * math.pi * pressure / modulus) ** 2
        return np.where(modulus > 0.0, first, 0.0)

    def _pressures(self, contacts: ContactArrays) -> Array:
        if self.yield_pressure is not None:
            return np.full(len(contacts.stiffness), self.yield_pressure)
        strength = contacts.yield_strength
        if strength is None or not np.isfinite(strength[contacts.stiffness > 0.0]).all():
            raise InputError(
                "ElasticPlastic() uses the yield strength of the materials, which is not known "
                "for this contact: give ElasticPlastic(yield_pressure=...)"
            )
        return (FIRST_YIELD if self.factor is None else self.factor) * strength

    def resolved(self, contacts: ContactArrays) -> list[Loss]:
        if self.yield_overlap is not None:
            return super().resolved(contacts)
        there = (contacts.stiffness > 0.0).tolist()
        return [
            ElasticPlastic(yield_overlap=first) if real else self
            for first, real in zip(self.strength(contacts).tolist(), there, strict=True)
        ]

    def loading_force(self, overlap: Array, contacts: ContactArrays) -> Array:
        return _loading(np.maximum(overlap, 0.0), contacts.stiffness, self.strength(contacts))

    def loading_overlap(self, force: Array, contacts: ContactArrays) -> Array:
        k, first = contacts.stiffness, self.strength(contacts)
        with np.errstate(divide="ignore", invalid="ignore"):
            plastic = force / (1.5 * k * np.sqrt(first)) + first / 3.0
        return np.where(plastic > first, plastic, super().loading_overlap(force, contacts))

    def stored_energy(self, overlap: Array, force: Array, contacts: ContactArrays) -> Array:
        """Stored energy, from the unloading curve that passes through overlap and force."""
        k, first = contacts.stiffness, self.strength(contacts)
        width = np.maximum(overlap, 0.0)
        elastic = (width <= first) & (force >= (1.0 - ROUNDING) * _loading(width, k, first))
        dented = (force > 0.0) & ~elastic
        if dented.any():
            d, k, first = (np.broadcast_to(each, width.shape)[dented] for each in (width, k, first))
            furthest = _furthest(d, force[dented], k, first)
            width[dented] = d - furthest + _loading(furthest, k, first) / (k * np.sqrt(furthest))
        return 0.4 * force * width

    def largest_overlap(self, energy: Array, contacts: ContactArrays) -> Array:
        """Overlaps from which unloading returns the energies; loading requires more energy."""
        first = self.strength(contacts)
        elastic = super().largest_overlap(energy, contacts)

        def step(r: Array) -> Array:
            return (1.5 * r**4 - root * r - 0.5) / (6.0 * r**3 - root)

        # With m = r^4 d_y, the energy 2/5 F_m^2 / (k m^(1/2)) is 2/5 k d_y^(5/2) (3 r^4 - 1)^2 /
        # (4 r^2).
        with np.errstate(divide="ignore", invalid="ignore"):
            root = (elastic / first) ** 1.25
            most = first * _descended(step, ((root + 0.5) / 1.5) ** (1.0 / 3.0)) ** 4
        return np.where(elastic > first, most, elastic)

    def dent(self, largest: Array, contacts: ContactArrays) -> Array:
        first = self.strength(contacts)
        with np.errstate(divide="ignore", invalid="ignore"):
            s = np.sqrt(largest / first)
            # d_p = d_m - F_m/(k d_m^(1/2)) in units of the point of yield, without cancellation.
            found = first * (s - 1.0) ** 2 * (s + 0.5) / s
        return np.where((largest > first) & (contacts.stiffness > 0.0), found, 0.0)

    def yield_ratio(self, largest: Array, contacts: ContactArrays) -> Array:
        first = self.strength(contacts)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.minimum(np.sqrt(largest / first), 1.0)
        return np.where(contacts.stiffness > 0.0, ratio, math.nan)

    def damper(self, contacts: ContactsAtRest) -> Array:
        if np.any(contacts.overlap > self.strength(contacts)):
            raise InputError(
                "contacts under ElasticPlastic that are compressed beyond yield close along "
                "one curve and open along a steeper one; no motion is small enough to be "
                "linear: use simulate, loss=None or less precompression"
            )
        return super().damper(contacts)

    def _yield_speed(self, contacts: ContactArrays) -> Array:
        """Speeds of collisions at which contacts first yield."""
        first = self.strength(contacts)
        energy = 0.4 * contacts.stiffness * first**2.5
        return np.asarray(np.sqrt(2.0 * energy / contacts.reduced_mass))

    def _restitution(self, speed: float, contacts: ContactArrays) -> float:
        self.row(contacts.exponent)
        return restitution_beyond_yield(float(self._yield_speed(contacts)[0]) / speed)

    @staticmethod
    def _overlap_at_yield(restitution: float, speed: float, contacts: ContactArrays) -> float:
        """Overlap at yield for which a collision beyond yield has this restitution, below 1."""
        from scipy.optimize import brentq

        # The restitution grows with the yield speed, from 0 to 1, approximately as its fourth root.
        u = brentq(
            lambda u: restitution_beyond_yield(u) - restitution, (0.5 * restitution) ** 4, 1.0,
            xtol=1e-300, rtol=1e-14,
        )  # fmt: skip
        mass, k = float(contacts.reduced_mass[0]), float(contacts.stiffness[0])
        return float((1.25 * mass * (u * speed) ** 2 / k) ** 0.4)


def restitution_beyond_yield(u: float) -> float:
    """Restitution of a collision with ``1/u`` times the speed at first yield."""
    if u >= 1.0:
        return 1.0
    root = 2.0 * math.sqrt(1.2 - 0.2 * u * u)
    return math.sqrt(1.2 * math.sqrt(3.0) * (1.0 - u * u / 6.0) * math.sqrt(u / (u + root)))


def _loading(overlap: Array, k: Array, first: Array) -> Array:
    """Force of the first loading; ``first`` is the overlap at yield."""
    plastic = k * np.sqrt(first) * (1.5 * overlap - 0.5 * first)
    return np.asarray(np.where(overlap > first, plastic, k * overlap * np.sqrt(overlap)))


def _furthest(overlap: Array, force: Array, k: Array, first: Array) -> Array:
    """Largest overlap of the unloading curve that passes through overlap and force."""
    d, f = overlap / first, (force / (k * first * np.sqrt(first))) ** (2.0 / 3.0)

    def step(s: Array) -> Array:
        peak = 1.5 * s * s - 0.5
        root = f * np.cbrt(peak)
        return (peak - s**3 + d * s - root) / (3.0 * s - 3.0 * s * s + d - root * s / peak)

    # In units of the point of yield and with m = s^2, the force at d falls with m from F_m on, and
    # is 0 at the latest at 2 d + 9/4.
    return np.asarray(first * _descended(step, np.sqrt(2.0 * d + 2.25)) ** 2)


def _descended(step: Callable[[Array], Array], above: Array) -> Array:
    """Roots of functions without a turning point between a root and ``above``, by Newton's method.

    The values then decrease monotonically until their changes are rounding errors.
    """
    for _ in range(MAX_STEPS):
        below = above - step(above)
        if not (below < above).any():
            break
        above = np.where(below < above, below, above)
    return above

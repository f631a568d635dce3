"""Methods of `hertzchain.Chain` that modify its beads: decorations, defects, random sizes."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final, TypeVar

import numpy as np

from ..collision import Array
from ..errors import InputError, short_repr
from ..validation.keywords import checked_arguments
from ..validation.numbers import FRACTION, number, whole_number
from .fields import ChainFields
from .input_checks import checked_beads
from .laws import Loss
from .materials import Material, MaterialLike
from .materials import material as material_named
from .places import places_from

C = TypeVar("C", bound=ChainFields)

# Largest standard deviation of the logarithm of the radius.
MAX_SCATTER: Final = 0.3

# Variation of ball lot diameter V_DwL by grade [m], from ISO 3290-1:2014 for steel balls: the
# difference between the mean diameters of the largest and the smallest ball of a lot.
BALL_GRADES: Final = MappingProxyType(
    {
        3: 0.13e-6, 5: 0.25e-6, 10: 0.5e-6, 16: 0.8e-6, 20: 1e-6, 24: 1.2e-6, 28: 1.4e-6,
        40: 2e-6, 60: 3e-6, 100: 5e-6, 200: 10e-6,
    }
)  # fmt: skip
# Features that are set separately for each bead or contact.
PER_BEAD_FEATURES: Final = ("masses", "stiffness", "gaps", "velocities", "strikers")


@checked_arguments("decorated")
def decorated(
    self: C,
    ratio: float | None = None,
    *,
    radius: float | None = None,
    between: int = 1,
    material: MaterialLike | None = None,
) -> C:
    """Return the chain with small beads inserted between its beads.

    Parameters
    ----------
    ratio : float, optional
        Radius of the small beads over the geometric mean of their two large neighbours.
    radius : float, optional
        Radius of all small beads, instead of a ratio [scaled, or m].
    between : int
        Number of small beads between two large ones.
    material : str or Material, optional
        Material of the small beads, in a chain with materials.  The default is that of the
        large bead behind.

    Raises
    ------
    InputError
        If the small beads are not smaller than the large ones, or if masses, gaps or velocities
        of this chain are set per bead.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.Chain.uniform(3).decorated(0.3).radii
    array([1. , 0.3, 1. , 0.3, 1. ])
    >>> hc.Chain.tapered("forward-linear", 0.25, beads=3).decorated(radius=0.2, between=2).beads
    7
    """
    if radius is not None:
        radius = number("radius of the small beads", radius, unit=self._unit("m"), above=0.0)
    row = _insert_radii(self.radii, ratio=ratio, radius=radius, between=between)
    kinds = None
    if self.materials is not None:
        cells = [
            (one,) + (one if material is None else material_named(material),) * between
            for one in self.materials
        ]
        kinds = tuple(itertools.chain.from_iterable(cells))[: len(row)]
    elif material is not None:
        raise InputError("material requires a chain with materials; use Chain.from_materials")
    return _with_beads(self, "decorated", row, kinds)


@checked_arguments("with_defects")
def with_defects(self: C, radii: Mapping[int, float], *, material: MaterialLike | None = None) -> C:
    """Return the chain with a few beads of another size or material.

    Parameters
    ----------
    radii : mapping of int to float
        Radius [scaled, or m] by bead number, counted from 1.
    material : str or Material, optional
        Material of these beads, in a chain with materials.

    Raises
    ------
    InputError
        If a bead does not exist, a radius is not positive, or masses, gaps or velocities of this
        chain are set per bead.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.Chain.uniform(5).with_defects({3: 0.5}).radii
    array([1. , 1. , 0.5, 1. , 1. ])
    """
    row = self.radii.copy()
    kinds = None if self.materials is None else list(self.materials)
    if kinds is None and material is not None:
        raise InputError("material requires a chain with materials; use Chain.from_materials")
    if not isinstance(radii, Mapping):
        raise InputError(
            f"defects must be radii by bead number, such as {{3: 0.5}}, got {short_repr(radii)}"
        )
    for bead, radius in radii.items():
        bead = whole_number("number of a defect's bead", bead, least=1, most=self.beads)
        row[bead - 1] = number(f"radius of bead {bead}", radius, unit=self._unit("m"), above=0.0)
        if kinds is not None and material is not None:
            kinds[bead - 1] = material_named(material)
    return _with_beads(self, "with_defects", row, None if kinds is None else tuple(kinds))


@checked_arguments("with_scatter", aliases={"rng": "seed"})
def with_scatter(
    self: C,
    seed: np.random.Generator | int,
    *,
    relative: float | None = None,
    grade: int | None = None,
    beads: Any = None,
) -> C:
    """Return the chain with random deviations of the radii, like those of real balls.

    Strikers keep their sizes.  Without strikers, bead 1 often is the projectile, whose size
    changes the impact itself: ``beads="2:"`` keeps it.

    In scaled variables the radii are divided by that of bead 1, the unit of length.  Velocities
    are those of a lot, but times, forces and momenta are in units of each chain's own first bead;
    for their spread, use a chain in SI units.  After strikers, the first bead is the unit and
    keeps its size.

    Parameters
    ----------
    seed : int or numpy.random.Generator
        Seed of the random numbers, or their generator; ``rng`` is accepted, too.
    relative : float, optional
        Standard deviation of the logarithm of the radius, up to 0.3, such as 0.01 or ``"1%"``.
    grade : int, optional
        Grade of ISO 3290-1 (3 to 200), instead of a relative deviation, for chains in SI
        units.  Diameters are distributed uniformly over the variation that the grade allows
        within a lot, 5 um for grade 100.
    beads : str or list of int, optional
        Beads that deviate, such as ``"2:"`` or ``[3, 4]``; by default all but the strikers.  The
        deviation of a bead does not depend on this choice.

    Raises
    ------
    InputError
        If not exactly one of ``relative`` and ``grade`` is given, the grade does not exist, or
        masses, gaps or velocities of this chain are set per bead.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.Chain.uniform(4).with_scatter(1, relative=0.1).radii.round(3)
    array([1.   , 1.049, 0.998, 0.848])
    >>> hc.Chain.uniform(4).with_scatter(1, relative=0.1, beads="3:").radii.round(3)
    array([1.   , 1.   , 1.034, 0.878])
    """
    if grade is not None and self.units != "SI":
        raise InputError(
            "ball grades are tolerances in micrometres; use Chain.from_materials, or relative"
        )
    if not isinstance(seed, np.random.Generator):
        seed = whole_number("seed of a scatter", seed, least=0)
    chance = np.random.default_rng(seed)
    row = _scatter(self.radii, chance, relative=relative, grade=grade)
    deviate: Any = range(self.strikers, self.beads)
    if beads is not None:
        deviate = places_from(beads, self.beads, "bead")
    kept = np.delete(np.arange(self.beads), deviate)
    row[kept] = self.radii[kept]
    if self.strikers:
        return _scattered_after_strikers(self, row)
    return _with_beads(self, "with_scatter", row, self.materials)


def with_one_loss(chain: C, loss: Loss | None) -> C:
    """The chain with one law of loss, or none, for all contacts, those with walls included."""
    changes: dict[str, Any] = {"loss": loss}
    for end in ("left_wall", "right_wall"):
        if (wall := getattr(chain, end)) is not None:
            changes[end] = dataclasses.replace(wall, loss=None)
    return chain.replace(**changes)


def _scattered_after_strikers(chain: C, radii: Array) -> C:
    """Replace the radii of a chain with strikers, whose other features stay."""
    own = [name for name in ("masses", "stiffness") if name in chain.given]
    if own:
        raise InputError(
            f"a scatter of radii changes the {' and '.join(own)}, which the strikers or the chain "
            "give; call with_scatter first, then struck_by"
        )
    if chain.units == "scaled":
        radii[chain.strikers] = 1.0
    return chain.replace(radii=radii)


def relative_scatter(
    what: str, value: object, *, above: float = -math.inf, least: float = -math.inf
) -> float:
    """Check a standard deviation of the logarithm of the radius."""
    return number(what, value, unit=FRACTION, above=above, least=least, most=MAX_SCATTER)


def _with_beads(chain: C, method: str, radii: Array, materials: tuple[Material, ...] | None) -> C:
    """Replace the beads of a chain, unless a feature is set per bead."""
    own = [name for name in chain.features if name in PER_BEAD_FEATURES]
    own += ["exponents"] if isinstance(chain.exponent, np.ndarray) else []
    own += ["losses"] if isinstance(chain.loss, tuple) else []
    if own:
        names = " and ".join(own)
        raise InputError(
            f"{method} replaces the beads of this chain, but its {names} belong to the present "
            f"ones; call {method} first, then set {names}"
        )
    changes: dict[str, Any] = {"radii": radii, "materials": materials}
    if chain.units == "scaled":
        with np.errstate(over="ignore", under="ignore"):
            changes["radii"] = radii / radii[0]
    changes["velocities"] = changes["gaps"] = None
    if "velocities" in chain.given:
        changes["velocities"] = np.zeros(len(radii))
        changes["velocities"][0] = chain.velocities[0]
    return chain.replace(**changes)


def _insert_radii(
    radii: Array, *, ratio: float | None, radius: float | None, between: int
) -> Array:
    """Insert small radii between the given ones."""
    if (ratio is None) == (radius is None):
        raise InputError("give either the ratio of the small beads to their neighbours or a radius")
    between = whole_number("between", between, least=1)
    checked_beads(len(radii) + between * (len(radii) - 1))
    left, right = radii[:-1], radii[1:]
    if ratio is not None:
        part = number("ratio of small to large beads", ratio, unit=FRACTION, above=0.0)
        small = part * np.sqrt(left * right)
    else:
        small = np.full(len(left), radius)
    too_large = np.flatnonzero(small >= np.minimum(left, right))
    if len(too_large):
        k = int(too_large[0])
        raise InputError(
            f"the small beads between large beads {k + 1} and {k + 2} have a radius of "
            f"{small[k]:g}, not below that of the smaller large bead, {min(left[k], right[k]):g}; "
            "use a smaller radius, or Chain.from_radii for arbitrary radii"
        )
    large = np.arange(len(radii)) * (between + 1)
    row = np.empty(large[-1] + 1)
    row[large] = radii
    row[np.delete(np.arange(len(row)), large)] = np.repeat(small, between)
    return row


def _scatter(
    radii: Array, rng: np.random.Generator, *, relative: float | None, grade: int | None
) -> Array:
    """Add random deviations to radii."""
    if (relative is None) == (grade is None):
        raise InputError("give either a relative scatter or a ball grade")
    if relative is not None:
        spread = relative_scatter("relative scatter", relative, least=0.0)
        return deviating_radii(radii, rng.standard_normal(len(radii)), spread, None)
    if type(grade) is not int or grade not in BALL_GRADES:
        known = ", ".join(map(str, BALL_GRADES))
        raise InputError(f"ISO 3290-1 has no ball grade {short_repr(grade)}; choose from {known}")
    if 0.25 * BALL_GRADES[grade] >= radii.min():
        raise InputError(
            f"a radius of {radii.min():g} m is too small for the deviations of grade {grade}"
        )
    return deviating_radii(radii, rng.uniform(-1.0, 1.0, len(radii)), None, grade)


def deviating_radii(radii: Array, draws: Array, relative: float | None, grade: int | None) -> Array:
    """Radii with normal deviations of the logarithm, or those of a grade, from -1 to 1."""
    if relative is not None:
        return np.asarray(radii * np.exp(relative * draws))
    assert grade is not None
    # The grade limits the variation of diameters, which is four times the largest deviation.
    return np.asarray(radii + 0.25 * BALL_GRADES[grade] * draws)

"""Methods of `hertzchain.Chain` that modify its beads: decorations, defects, random sizes."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator, Mapping
from typing import Any, Final, NoReturn, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..collision import Array
from ..errors import InputError, short_repr
from ..validation.keywords import checked_arguments
from ..validation.numbers import FRACTION, number, per_bead_array, whole_number
from .description import length_in_words
from .fields import ChainFields
from .input_checks import checked_beads
from .laws import Loss
from .materials import Material, MaterialLike
from .materials import material as material_named
from .random_radii import (
    check_grade,
    check_scatter,
    random_draws,
    relative_scatter,
    scattered,
    with_deviations,
)

C = TypeVar("C", bound=ChainFields)

# Features that are set separately for each bead or contact.
PER_BEAD_FEATURES: Final = ("masses", "stiffness", "gaps", "velocities", "strikers", "cap")


@checked_arguments("decorated")
def decorated(
    self: C,
    ratio: float | None = None,
    *,
    radius: float | None = None,
    diameter: float | None = None,
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
    diameter : float, optional
        Their diameter, instead of the radius, such as ``"8 mm"``.
    between : int
        Number of small beads between two large ones.
    material : str or Material, optional
        Material of the small beads, in a chain with materials.  The default is that of the
        large bead behind.

    Raises
    ------
    InputError
        If there are several of ``ratio``, ``radius`` and ``diameter`` or none, if the small beads
        are not smaller than the large ones, or if masses, stiffness, gaps, velocities, exponents
        or losses are set per bead or contact, or there are strikers or a cap: modify the beads
        first.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.Chain.uniform(3).decorated(0.3).radii
    array([1. , 0.3, 1. , 0.3, 1. ])
    >>> hc.Chain.tapered("forward-linear", 0.25, beads=3).decorated(radius=0.2, between=2).beads
    7
    >>> balls = hc.Chain.from_materials(diameters="20 mm", materials="brass", beads=3)
    >>> balls.decorated(diameter="8 mm")
    Chain(5 brass beads, diameters 20 mm and 8 mm in turn, impact at 1 m/s)
    """
    row = _decorated_radii(self, ratio=ratio, radius=radius, diameter=diameter, between=between)
    kinds = None
    if self.materials is not None:
        cells = [
            (one,) + (one if material is None else material_named(material),) * between
            for one in self.materials
        ]
        kinds = tuple(itertools.chain.from_iterable(cells))[: len(row)]
    elif material is not None:
        raise InputError("material requires a chain with materials; use Chain.from_materials")
    return _with_beads(self, row, kinds)


@checked_arguments("with_defects")
def with_defects(
    self: C,
    radii: Mapping[int, float] | None = None,
    *,
    diameters: Mapping[int, float] | None = None,
    material: MaterialLike | None = None,
) -> C:
    """Return the chain with a few beads of another size or material.

    Masses and contacts of these beads follow from their new sizes; all other fields of the chain
    are kept.  A scaled chain keeps its units, also if bead 1 has another radius.

    Parameters
    ----------
    radii : mapping of int to float, optional
        Radius [scaled, or m] by bead number, counted from 1; strikers count.  The first argument
        contains radii also if the chain was built from diameters: ``{3: "4 mm"}`` is a bead of 8 mm
        diameter.
    diameters : mapping of int to float, optional
        Diameters, instead of radii, such as ``diameters={3: "8 mm"}``.
    material : str or Material, optional
        Material of these beads, in a chain with materials.

    Raises
    ------
    InputError
        If there are both radii and diameters or neither, a bead does not exist, a size is not
        positive, or the masses or the stiffness of the chain, or the mass of one of these beads,
        are given and do not follow from the radii.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.Chain.uniform(5).with_defects({3: 0.5}).radii
    array([1. , 1. , 0.5, 1. , 1. ])
    >>> balls = hc.Chain.from_materials(diameters="10 mm", materials="brass", beads=20)
    >>> balls.with_defects(diameters={8: "8 mm"})
    Chain(20 brass beads, diameter 10 mm, except bead 8 (8 mm), impact at 1 m/s)
    """
    row = self.radii.copy()
    kinds = None if self.materials is None else list(self.materials)
    if kinds is None and material is not None:
        raise InputError("material requires a chain with materials; use Chain.from_materials")
    follows = self._follows("masses")
    for bead, radius in _radii_of_defects(self, radii, diameters):
        _require_followed(self, follows, bead)
        row[bead - 1] = radius
        if kinds is not None and material is not None:
            kinds[bead - 1] = material_named(material)
    return self.replace(radii=row, materials=None if kinds is None else tuple(kinds))


def _require_followed(chain: ChainFields, follows: NDArray[np.bool_], bead: int) -> None:
    """Raise `InputError` if the mass or the contacts of a bead would not follow from its radius."""
    if own := sorted({"masses", "stiffness"} & chain.given):
        names = " and ".join(own)
        raise InputError(
            f"with_defects changes radii, but the {names} of this chain are given and would not "
            f"follow: call with_defects first, then set {names}, or omit them with "
            f"replace({', '.join(f'{name}=None' for name in own)}); the mass of a single body is "
            "that of a striker (struck_by) or a cap (with_cap)"
        )
    if not follows[bead - 1]:
        body = "striker" if bead <= chain.strikers else "cap"
        raise InputError(
            f"the mass of bead {bead}, a {body}, is given and would not follow from its radius: "
            "choose another bead"
        )


def _radii_of_defects(
    chain: ChainFields, radii: object, diameters: object
) -> Iterator[tuple[int, float]]:
    """Number and radius of each defect, from radii or diameters."""
    example = "diameters={8: '8 mm'}" if chain.units == "SI" else "{3: 0.5}"
    if (radii is None) == (diameters is None):
        both = "both were given" if radii is not None else "neither was given"
        raise InputError(
            f"with_defects needs radii or diameters by bead number, such as {example}: {both}"
        )
    what, given, part = (
        ("radius", radii, 1.0) if diameters is None else ("diameter", diameters, 0.5)
    )
    if not isinstance(given, Mapping):
        words = "radii" if diameters is None else "diameters"
        raise InputError(
            f"defects must be {words} by bead number, such as {example}, got {short_repr(given)}"
        )
    for bead, size in given.items():
        bead = whole_number("number of a defect's bead", bead, least=1, most=chain.beads)
        found = number(f"{what} of bead {bead}", size, unit=chain._unit("m"), above=0.0)
        yield bead, part * found


@checked_arguments("with_scatter", aliases={"rng": "seed"})
def with_scatter(
    self: C,
    seed: np.random.Generator | int | None = None,
    *,
    relative: float | None = None,
    grade: int | None = None,
    gaps: float | str | None = None,
    beads: Any = None,
    radii: ArrayLike | None = None,
) -> C:
    r"""Return the chain with random diameters and radii, and random gaps, like real balls.

    The radius of bead k is :math:`R_k e^{\sigma z_k}` with a standard normal :math:`z_k`, or, for
    a grade, uniformly distributed within its tolerance.  A scaled chain stays in the units of the
    chain without deviations, so its first radius is no longer 1: all results of random chains
    have the same units.

    Random gaps are half-normal: the gap of contact k grows by :math:`s |z'_k|`, with a standard
    normal :math:`z'_k`.  Their mean is 0.80 s, and 95% of them are smaller than 1.96 s.

    Strikers and caps keep their sizes.  If the chain has no strikers, bead 1 is the projectile,
    whose size changes the impact itself; ``beads="2:"`` keeps it.

    The chain remembers the scatter (``chain.scatter``) for its description, in titles and files,
    until its radii are changed.

    Parameters
    ----------
    seed : int or numpy.random.Generator
        Seed of the random numbers, or their generator; ``rng`` is accepted, too.
    relative : float, optional
        Standard deviation of the logarithm of the radius, and hence of the diameter, up to 0.3,
        such as 0.01 or ``"1%"``; if it is small, that of the diameter relative to its nominal
        value.
    grade : int, optional
        Grade of ISO 3290-1 (3 to 200), instead of a relative deviation, for chains in SI
        units.  Diameters are distributed uniformly over the variation of ball lot diameter of
        the grade, centred at the nominal diameter: 0.5 um for grade 10, 5 um for grade 100.
        The deviation that all balls of a lot have in common is not included.
    gaps : float or str, optional
        The scale s of random gaps between neighbouring beads that both deviate [scaled, or m], such
        as ``"5 um"``; alone, or in addition to deviations of the radii.  A wall has its own gap.
    beads : str or list of int, optional
        Beads that deviate, such as ``"2:"`` or ``[3, 4]``; by default all but strikers and
        caps.  The deviation of a bead does not depend on this choice.
    radii : array_like, shape (N,), optional
        Radii of all beads [scaled, or m] instead of a seed: measured ones, or those of a chain
        file.

    Raises
    ------
    InputError
        If not exactly one of ``relative`` and ``grade`` is given, or only gaps, and one of ``seed``
        and ``radii``, the grade does not exist, the chain has given masses or stiffness, which do
        not follow from its radii, or it is precompressed and would have gaps.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(4).with_scatter(1, relative=0.1)
    >>> chain
    Chain(uniform, 10% scatter, 4 beads)
    >>> chain.radii.round(3)
    array([1.035, 1.086, 1.034, 0.878])
    >>> hc.Chain.uniform(4).with_scatter(1, relative=0.1, beads="3:").radii.round(3)
    array([1.   , 1.   , 1.034, 0.878])

    Balls of 10 mm with gaps of some micrometres:

    >>> balls = hc.Chain.from_materials("5 mm", "brass", beads=4)
    >>> (1e6 * balls.with_scatter(1, gaps="5 um").gaps).round(2)
    array([4.53, 2.23, 2.68])
    """
    if isinstance(seed, str | float | np.floating) and relative is None and grade is None:
        raise InputError(
            "the first argument of with_scatter is the seed of the random numbers, a whole number, "
            f"got {short_repr(seed)}; give the scatter by keyword, relative={short_repr(seed)}"
        )
    if (relative is None) == (grade is None) and (relative is not None or gaps is None):
        raise InputError(
            "give either relative, such as 0.01, or grade, such as 100, or only gaps, such as "
            "'5 um'"
        )
    if relative is not None:
        relative = relative_scatter("relative scatter", relative, chain=self, least=0.0)
    elif grade is not None:
        check_grade(grade)
    size = check_scatter(self, relative, grade, gaps, beads)
    if radii is not None:
        if seed is not None or beads is not None or gaps is not None:
            raise InputError(
                "radii with a scatter are those of all beads: omit seed, beads and gaps"
            )
        unit = self._unit("m")
        given = per_bead_array("radius", radii, self.beads, "bead", unit=unit, above=0.0)
        return scattered(self, given, relative, grade)
    if seed is None:
        raise InputError("with_scatter needs a seed of the random numbers, or radii")
    if not isinstance(seed, np.random.Generator):
        seed = whole_number("seed of a scatter", seed, least=0)
    draws = random_draws(np.random.default_rng(seed), (1, self.beads), grade, gaps)
    return with_deviations(self, draws, relative, grade, size, beads)[0]


def with_one_loss(chain: C, loss: Loss | None) -> C:
    """The chain with one law of loss, or none, for all contacts, those with walls included."""
    changes: dict[str, Any] = {"loss": loss}
    for end in ("left_wall", "right_wall"):
        if (wall := getattr(chain, end)) is not None:
            changes[end] = dataclasses.replace(wall, loss=None)
    return chain.replace(**changes)


def _with_beads(chain: C, radii: Array, materials: tuple[Material, ...] | None) -> C:
    """Replace the beads of a decorated chain, unless a feature is set per bead."""
    own = [name for name in chain.features if name in PER_BEAD_FEATURES]
    own += ["exponents"] if isinstance(chain.exponent, np.ndarray) else []
    own += ["losses"] if isinstance(chain.loss, tuple) else []
    if own:
        names = " and ".join(own)
        raise InputError(
            f"decorated replaces the beads of this chain, but its {names} belong to the present "
            f"ones; call decorated first, then set {names}"
        )
    changes: dict[str, Any] = {"radii": radii, "materials": materials}
    changes["velocities"] = changes["gaps"] = None
    if "velocities" in chain.given:
        changes["velocities"] = np.zeros(len(radii))
        changes["velocities"][0] = chain.velocities[0]
    return chain.replace(**changes)


def _decorated_radii(
    chain: ChainFields,
    *,
    ratio: float | None,
    radius: float | None,
    diameter: float | None,
    between: int,
) -> Array:
    """Radii of a chain with small beads inserted, whose size is checked."""
    if sum(each is not None for each in (ratio, radius, diameter)) != 1:
        raise InputError(
            "give one of these: the ratio of the small beads to their neighbours, a radius or a "
            "diameter"
        )
    between = whole_number("between", between, least=1)
    radii = chain.radii
    checked_beads(len(radii) + between * (len(radii) - 1))
    left, right = radii[:-1], radii[1:]
    if ratio is not None:
        part = number("ratio of small to large beads", ratio, unit=FRACTION, above=0.0)
        small = part * np.sqrt(left * right)
    else:
        small = np.full(len(left), _small_radius(chain, radius, diameter))
    too_large = np.flatnonzero(small >= np.minimum(left, right))
    if len(too_large):
        k = int(too_large[0])
        _reject_large(chain, k, float(small[k]), radius, diameter)
    large = np.arange(len(radii)) * (between + 1)
    row = np.empty(large[-1] + 1)
    row[large] = radii
    row[np.delete(np.arange(len(row)), large)] = np.repeat(small, between)
    return row


def _small_radius(chain: ChainFields, radius: object, diameter: object) -> float:
    """Radius of all small beads, from a radius or a diameter."""
    what, size, part = ("radius", radius, 1.0) if diameter is None else ("diameter", diameter, 0.5)
    return part * number(f"{what} of the small beads", size, unit=chain._unit("m"), above=0.0)


def _reject_large(
    chain: ChainFields, k: int, small: float, radius: object, diameter: object
) -> NoReturn:
    """Reject small beads that are not smaller than their neighbours, in the words of the input."""
    name, given, times = (
        ("radius", radius, 1.0) if diameter is None else ("diameter", diameter, 2.0)
    )
    sizes = times * small, times * float(min(chain.radii[k : k + 2]))
    words = length_in_words if chain.units == "SI" else "{:g}".format
    found, limit = map(words, sizes)
    advice = f"use a smaller {name}, or Chain.from_radii for arbitrary radii"
    if chain.units == "SI" and isinstance(given, float | int) and 1e-3 * given < sizes[1]:
        advice = f"if millimetres are meant, write '{given:g} mm'"
    raise InputError(
        f"the small beads between large beads {k + 1} and {k + 2} have a {name} of {found}, not "
        f"below that of the smaller large bead, {limit}; {advice}"
    )

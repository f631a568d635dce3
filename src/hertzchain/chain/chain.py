"""The chain of beads that is struck: its description and its checks.

A plain chain is the paper's: in scaled variables (Sec. 2; radii in units of the first
bead's, masses of the first bead's mass, velocities of the strike's), touching, at rest,
struck at bead 1, with free ends and no losses.  Whatever else a bench has is a field
with a plain default.  Bead ``k = 1..N`` counts from the struck end; contact ``k`` joins
beads ``k`` and ``k + 1``.  Arrays start at 0: ``chain.radii[0]`` is bead 1.
"""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, Final, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from hertzchain.arguments import listed, one_of
from hertzchain.chain import patterns
from hertzchain.chain import strikers as striking
from hertzchain.chain.bodies import masses_of, stiffness_of, wall_stiffness_of
from hertzchain.chain.drives import Drive
from hertzchain.chain.features import description_of, features_of
from hertzchain.chain.holding import HeldBy, check_holding
from hertzchain.chain.losses import Loss
from hertzchain.chain.materials import (
    Material,
    MaterialLike,
    material,
)
from hertzchain.chain.sizes import checked_beads, checked_exponent, positive_radii, scaled_radii
from hertzchain.chain.tapers import TAPERS as TAPERS
from hertzchain.chain.tapers import Taper as Taper
from hertzchain.chain.tapers import check_taper as check_taper
from hertzchain.chain.tapers import rate_symbol as rate_symbol
from hertzchain.chain.tapers import tapered_radii
from hertzchain.chain.walls import Wall
from hertzchain.checks import SCALED, column, magnitude, number, real_numbers, whole_number
from hertzchain.contacts import HERTZ_EXPONENT, Array
from hertzchain.errors import InputError, InputWarning, unknown_name
from hertzchain.frozen import Frozen

Units = Literal["scaled", "SI"]
UNITS: Final[tuple[Units, ...]] = get_args(Units)

# Radii above it [m] are taken for millimetres, with a warning.
LARGE_RADIUS: Final = 1.0

# Default of a field that follows from the others unless given.
FROM_OTHERS: Final[Any] = None
DERIVED: Final = ("masses", "stiffness", "velocities", "gaps")


@dataclass(frozen=True, eq=False)
class Chain(Frozen):
    r"""A row of beads, and what is done to it; plainly, the first is struck with velocity one.

    Make one with a builder: `Chain.tapered`, `Chain.uniform` or `Chain.from_radii` for
    the scaled variables of the paper, `Chain.from_materials` in SI units; `Chain.replace`
    changes fields.  The equation of motion of a plain chain, Eq. (4) of the paper, is

    .. math::

        m_k \ddot x_k = r_{k-1}(x_{k-1}-x_k)_+^{p} - r_k (x_k-x_{k+1})_+^{p},
        \qquad v_1(0) = m_1 = R_1 = 1 .

    Attributes
    ----------
    radii : ndarray, shape (N,)
        Radii :math:`R_k` [scaled, or m]; scaled, the first after the strikers is 1.
    exponent : float
        Exponent p of the contact force, > 1; 3/2 for spheres (Hertz).
    taper : str or None
        Name of the taper, if the chain was built from one.
    rate : float or None
        Tapering parameter, S of a linear or q of an exponential taper.
    masses : ndarray, shape (N,)
        Masses :math:`m_k` > 0 [scaled, or kg]; if not given, :math:`R_k^3` (Eq. (3) of
        the paper), or what the materials weigh.
    stiffness : ndarray, shape (N - 1,)
        Stiffness :math:`r_k` > 0 of each contact [scaled, or N/m^p]; if not given,
        Hertz': below Eq. (4) of the paper, or from the materials.
    units : str
        ``"scaled"`` or ``"SI"``: m, kg, s, N.  `hertzchain.Scales` converts.
    materials : tuple of Material, length N, or None
        Of each bead, where known.
    velocities : ndarray, shape (N,)
        Velocities at time 0, positive towards bead N [scaled, or m/s]; if not given, 1
        for bead 1 (or the strikers) and 0 for the others, or 0 for all if there is a drive.
    gaps : ndarray, shape (N - 1,)
        Distance >= 0 of neighbouring beads at time 0 [scaled, or m]; 0 if not given.
    strikers : int
        How many beads at the front are strikers: they fly in and belong to no static
        equilibrium.  See `Chain.struck_by`.
    precompression : float
        Static force >= 0 on every contact behind the strikers [scaled, or N]; with gravity,
        on the contact that bears least.
    held_by : str
        What holds the precompressed chain: ``"walls"`` at both ends, which stay where they
        are, or ``"force"``: a constant force at each end that has no wall.
    gravity : float
        Component of the acceleration of gravity along the chain, positive towards bead N
        [scaled, or m/s^2].  A chain that stands on a wall without gaps is in equilibrium at
        time 0; else it falls.
    left_wall, right_wall : Wall or None
        Wall behind bead 1, and in front of bead N; `None` is a free end.
    drive : SineBurst, Step, Table or None
        Force on bead 1, or displacement of the left wall, in the course of time.
    loss : Restitution, Viscoelastic, ... or None
        One of the laws of `hertzchain.chain.losses`, for all contacts and walls.

    Raises
    ------
    InputError
        If a field is out of its range or contradicts another.

    Warns
    -----
    InputWarning
        If radii in SI units look like millimetres.

    Examples
    --------
    >>> chain = Chain.tapered("backward-exponential", 0.05, beads=100)
    >>> chain
    Chain(backward-exponential, q = 0.05, 100 beads)
    >>> chain.radii[:3].round(4)
    array([1.    , 1.0526, 1.108 ])
    >>> chain.replace(right_wall=Wall(), gravity=0.01)
    Chain(backward-exponential, q = 0.05, 100 beads, gravity, right wall)
    """

    radii: Array
    exponent: float = HERTZ_EXPONENT
    taper: Taper | None = None
    rate: float | None = None
    _: KW_ONLY
    masses: Array = FROM_OTHERS
    stiffness: Array = FROM_OTHERS
    units: Units = "scaled"
    materials: tuple[Material, ...] | None = None
    velocities: Array = FROM_OTHERS
    gaps: Array = FROM_OTHERS
    strikers: int = 0
    precompression: float = 0.0
    held_by: HeldBy = "walls"
    gravity: float = 0.0
    left_wall: Wall | None = None
    right_wall: Wall | None = None
    drive: Drive | None = None
    loss: Loss | None = None
    # Names of the derived fields that were given.
    given: frozenset[str] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        given = frozenset(name for name in DERIVED if getattr(self, name) is not None)
        self._set("given", given)
        self._set("exponent", checked_exponent(self.exponent))
        one_of("units", self.units, UNITS)
        self._check_radii()
        self._check_taper()
        self._check_bodies()
        self._check_start()
        check_holding(self)

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)

    def _check_radii(self) -> None:
        radii = magnitude("radius", self.radii, self._unit("m"))
        checked = scaled_radii if self.units == "scaled" else positive_radii
        self._set("radii", _read_only(checked(radii)))
        strikers = whole_number("strikers", self.strikers, least=0, most=self.beads - 1)
        self._set("strikers", strikers)
        if self.units == "scaled" and self.radii[strikers] != 1.0:
            which = "after the strikers " if strikers else ""
            raise InputError(
                f"the first {which}of a scaled chain's radii must be 1, got "
                f"{self.radii[strikers]:g}; Chain.from_radii takes radii in any unit"
            )
        if self.units == "SI" and self.radii.max() > LARGE_RADIUS:
            k = int(np.argmax(self.radii))
            warnings.warn(
                f"bead {k + 1} has a radius of {self.radii[k]:g} m: radii are in metres; divide "
                "by 1000 if these are millimetres",
                InputWarning,
                stacklevel=4,
            )

    def _check_taper(self) -> None:
        if (self.taper is None) != (self.rate is None):
            raise InputError("a chain has a taper and a rate or neither; use Chain.tapered")
        if self.taper is None or self.rate is None:
            return
        check_taper(self.taper, self.rate, self.beads)
        if not np.array_equal(self.radii, tapered_radii(self.taper, self.rate, self.beads)):
            raise InputError(
                f"these radii are not those of a {self.taper} taper; use Chain.tapered"
            )

    def _check_bodies(self) -> None:
        """Masses and contact stiffness, given or from radii and materials."""
        count, unit = self.beads, f"N/m**{self.exponent}"
        if self.materials is not None:
            self._set("materials", _checked_materials(self.materials, count))
        for name, what, length, place, si, derived in (
            ("masses", "mass", count, "bead", "kg", masses_of),
            ("stiffness", "stiffness", count - 1, "contact", unit, stiffness_of),
        ):
            if name not in self.given:
                self._set(name, _derived(what, place, derived(self)))
            elif (values := getattr(self, name)) is not None:
                checked = column(what, values, length, place, unit=self._unit(si), above=0.0)
                self._set(name, checked)

    def _check_start(self) -> None:
        """Velocities, gaps and static forces at time 0."""
        if "velocities" in self.given:
            values = column("velocity", self.velocities, self.beads, "bead", unit=self._unit("m/s"))
        else:
            values = np.zeros(self.beads)
            if self.drive is None:
                values[: max(1, self.strikers)] = 1.0
        self._set("velocities", _read_only(values))
        gaps = np.zeros(self.beads - 1)
        if "gaps" in self.given:
            unit = self._unit("m")
            gaps = column("gap", self.gaps, self.beads - 1, "contact", unit=unit, least=0.0)
        self._set("gaps", _read_only(gaps))
        gravity = number("gravity", self.gravity, unit=self._unit("m/s**2"))
        self._set("gravity", gravity)
        force = number("precompression", self.precompression, unit=self._unit("N"), least=0.0,
                       hint="beads do not pull")  # fmt: skip
        self._set("precompression", force)

    def _unit(self, unit: str) -> str:
        """The unit in which numbers of this chain are kept, for `hertzchain.checks`."""
        return unit if self.units == "SI" else SCALED

    @classmethod
    def tapered(
        cls, taper: str, rate: float, *, beads: int, exponent: float = HERTZ_EXPONENT
    ) -> Chain:
        r"""A chain whose radii grow (backward) or shrink (forward) along it.

        ====================  ============================  =====================
        taper                 radius of bead k              in the paper
        ====================  ============================  =====================
        backward-linear       :math:`1 + S(k-1)`            Eq. (6)
        backward-exponential  :math:`(1-q)^{-(k-1)}`        Eq. (7)
        forward-linear        :math:`1 - S(k-1)`            Eq. (19), N < 1 + 1/S
        forward-exponential   :math:`(1+q)^{-(k-1)}`        Eq. (21)
        ====================  ============================  =====================

        Parameters
        ----------
        taper : str
            One of the four names above.
        rate : float
            Tapering parameter: S > 0 of a linear, 0 < q < 1 of an exponential taper.
        beads : int
            Number of beads N, at least 2.
        exponent : float
            Exponent p of the contact force, > 1.

        Returns
        -------
        Chain

        Raises
        ------
        InputError
            For an unknown taper, a rate or number of beads out of range, or radii
            that overflow.

        Examples
        --------
        >>> Chain.tapered("forward-linear", 0.25, beads=4).radii
        array([1.  , 0.75, 0.5 , 0.25])
        """
        count = checked_beads(beads)
        checked = check_taper(taper, rate, count)
        return cls(tapered_radii(taper, checked, count), exponent, taper, checked)  # type: ignore[arg-type]

    @classmethod
    def uniform(cls, beads: int, *, exponent: float = HERTZ_EXPONENT) -> Chain:
        """A chain of equal beads, on which a strike becomes a solitary wave.

        Parameters
        ----------
        beads : int
            Number of beads N, at least 2.
        exponent : float
            Exponent p of the contact force, > 1.

        Returns
        -------
        Chain

        Raises
        ------
        InputError
            If there are fewer than two beads or more than fit in memory.

        Examples
        --------
        >>> Chain.uniform(20)
        Chain(uniform, 20 beads)
        """
        return cls(np.ones(checked_beads(beads)), exponent)

    @classmethod
    def from_radii(cls, radii: ArrayLike, *, exponent: float = HERTZ_EXPONENT) -> Chain:
        """A chain of spheres of one material with any positive radii.

        Parameters
        ----------
        radii : array_like, shape (N,)
            Radii of the beads, struck bead first, in any one unit: the chain
            keeps them in units of the first.
        exponent : float
            Exponent p of the contact force, > 1.

        Returns
        -------
        Chain

        Raises
        ------
        InputError
            If a radius is not a positive finite number, or fewer than two are given.

        Examples
        --------
        >>> Chain.from_radii([5.0, 2.5, 5.0]).masses
        array([1.   , 0.125, 1.   ])
        """
        given = positive_radii(magnitude("radius", radii, "m"))
        with np.errstate(over="ignore", under="ignore"):
            return cls(given / given[0], exponent)

    @classmethod
    def from_materials(
        cls,
        radii: ArrayLike,
        materials: MaterialLike | Sequence[MaterialLike],
        *,
        beads: int | None = None,
        velocity: float | None = None,
        **fields: Any,
    ) -> Chain:
        r"""A chain of real beads in SI units, from their radii and materials.

        Contacts are Hertz', between unlike spheres too:
        `hertzchain.chain.materials.sphere_stiffness`.

        Parameters
        ----------
        radii : array_like
            Radius of each bead [m], struck bead first; or one for all.
        materials : str, Material or sequence of them
            A material or its name in the catalogue, for all beads or for each.
        beads : int, optional
            Number of beads, if there is one radius for all.
        velocity : float
            Velocity of bead 1 at time 0 [m/s]; 1 if not given, or 0 if there is a drive.
        **fields
            Other fields of `Chain`.

        Returns
        -------
        Chain

        Raises
        ------
        InputError
            For an unknown material, lists of unlike lengths, or a field out of its range.

        Examples
        --------
        >>> chain = Chain.from_materials(5e-3, "steel-52100", beads=20)
        >>> chain
        Chain(SI, steel-52100, R = 5 mm, 20 beads)
        >>> round(float(chain.masses[0]), 9), float(chain.stiffness[0]).__round__(-3)
        (0.004073598, 7435897000.0)
        """
        given = real_numbers("radius", radii, "bead", unit="m")
        if given.ndim == 0:
            if beads is None:
                raise InputError("one radius for all beads needs their number: give beads")
            given = np.full(checked_beads(beads), given)
        elif beads is not None and checked_beads(beads) != len(given):
            raise InputError(f"beads = {beads}, but there are {len(given)} radii: leave beads out")
        count = len(given)
        one = isinstance(materials, str | Material)
        named = [materials] * count if one else listed("materials", materials, "names")
        kinds = tuple(map(material, named))
        if velocity is not None:
            fields["velocities"] = np.zeros(count)
            fields["velocities"][:1] = number("velocity", velocity, unit="m/s")
        return cls(given, units="SI", materials=kinds, **fields)

    @classmethod
    def periodic(
        cls,
        cell: ArrayLike,
        *,
        cells: int,
        materials: MaterialLike | Sequence[MaterialLike] | None = None,
        **fields: Any,
    ) -> Chain:
        """A chain that repeats a cell of beads: a dimer, a trimer, any k-mer.

        Parameters
        ----------
        cell : array_like
            Radii of the beads of one cell, in any one unit; in m if there are materials.
        cells : int
            How often it is repeated.
        materials : str, Material or sequence of them, optional
            Material of all beads, or of each bead of the cell: makes a chain in SI units.
        **fields
            Arguments of `from_materials`, or of `from_radii`.

        Returns
        -------
        Chain

        Raises
        ------
        InputError
            If a radius is not positive, or a material unknown.

        Examples
        --------
        >>> Chain.periodic([5.0, 2.5, 2.5], cells=2).radii
        array([1. , 0.5, 0.5, 1. , 0.5, 0.5])
        >>> Chain.periodic([9.5e-3, 9.5e-3], cells=20, materials=["steel-316", "ptfe"])
        Chain(SI, steel-316 and ptfe, R = 9.5 mm, 40 beads)
        """
        cells = whole_number("cells", cells, least=1)
        one = real_numbers("radius", cell, "bead", unit="m")
        checked_beads(cells * one.size)
        radii = np.tile(np.atleast_1d(one), cells)
        if materials is None:
            return cls.from_radii(radii, **fields)
        if not isinstance(materials, str | Material):
            materials = listed("materials of the cell", materials, "names") * cells
        return cls.from_materials(radii, materials, **fields)

    @classmethod
    def dimer(cls, mass_ratio: float, *, beads: int, exponent: float = HERTZ_EXPONENT) -> Chain:
        """Heavy and light beads in turn, with all contacts equal.

        The mass ratio is then the only parameter: at 1, 0.3428, 0.1548, 0.0901, ... solitary
        waves pass (K. R. Jayaprakash, Y. Starosvetsky, A. F. Vakakis, Phys. Rev. E 83, 036606,
        2011, doi:10.1103/PhysRevE.83.036606).  Alternating spheres of one material, whose
        contacts are all equal too, are ``Chain.periodic([1, r], cells=...)``: a factor common
        to all contacts only changes the time.

        Parameters
        ----------
        mass_ratio : float
            Mass of the light beads over that of the heavy, > 0; the first bead is heavy.
        beads : int
            Number of beads.
        exponent : float
            Exponent p of the contact force, > 1.

        Returns
        -------
        Chain

        Raises
        ------
        InputError
            If the ratio is not positive, or there are too few or many beads.

        Examples
        --------
        >>> Chain.dimer(0.125, beads=4).masses
        array([1.   , 0.125, 1.   , 0.125])
        """
        count = checked_beads(beads)
        ratio = number("mass ratio of a dimer", mass_ratio, above=0.0)
        masses = np.where(np.arange(count) % 2, ratio, 1.0)
        return cls(np.cbrt(masses), exponent, masses=masses, stiffness=np.ones(count - 1))

    def replace(self, **changes: Any) -> Chain:
        """The same chain with some fields changed; what follows from them follows anew.

        Parameters
        ----------
        **changes
            Fields of `Chain` and their new values.

        Returns
        -------
        Chain

        Raises
        ------
        InputError
            For a field that does not exist, is out of its range or contradicts another.

        Examples
        --------
        >>> Chain.uniform(20).replace(right_wall=Wall.rigid())
        Chain(uniform, 20 beads, right wall)
        """
        fields = [item.name for item in dataclasses.fields(self) if item.init]
        for name in changes:
            if name not in fields:
                raise unknown_name("field of a chain", name, fields)
        kept = {
            name: getattr(self, name)
            for name in fields
            if name not in DERIVED or name in self.given
        }
        if "radii" in changes:
            kept |= {"taper": None, "rate": None}
        return Chain(**(kept | changes))

    # Verbs that make another chain of this one, an idea a file.
    decorated = patterns.decorated
    with_defects = patterns.with_defects
    with_scatter = patterns.with_scatter
    struck_by = striking.struck_by

    @property
    def beads(self) -> int:
        """Number of beads N."""
        return len(self.radii)

    @property
    def wall_stiffness(self) -> tuple[float, float]:
        r"""Stiffness of the contacts with left and right wall [scaled, or N/m^p]; 0 if free.

        Scaled, a flat wall of the bead's own material has :math:`\sqrt{2R}`, a rigid one
        twice as much.
        """
        left = wall_stiffness_of(self, self.left_wall, 0)
        return left, wall_stiffness_of(self, self.right_wall, self.beads - 1)

    @property
    def centre_distances(self) -> Array:
        """Distances between the centres of neighbours at first, shape (N - 1,) [R_1, or m].

        With the gaps in SI units; in scaled ones these are in units of the overlaps, and
        beside a radius nothing.
        """
        touching = self.radii[:-1] + self.radii[1:]
        return touching + self.gaps if self.units == "SI" else touching

    @property
    def features(self) -> tuple[str, ...]:
        """What the chain has beyond the paper's: names such as ``"gaps"``, ``"right wall"``."""
        return features_of(self)

    @property
    def description(self) -> str:
        """The chain in a few words, as it heads tables and figures."""
        return description_of(self)

    def __repr__(self) -> str:
        return f"Chain({self.description})"


def _checked_materials(given: Sequence[MaterialLike], beads: int) -> tuple[Material, ...]:
    kinds = tuple(map(material, listed("materials", given, "names")))
    if len(kinds) != beads:
        raise InputError(f"there must be {beads} materials, one for each bead, got {len(kinds)}")
    return kinds


def _derived(what: str, place: str, values: Array) -> Array:
    """What follows from radii and materials, unless it is no number any more."""
    good = (values > 0.0) & np.isfinite(values)
    if not good.all():
        k = int(np.argmin(good))
        raise InputError(
            f"{what} of {place} {k + 1} would be {values[k]:g} from its radius and material: look "
            "at their units, and take a wall, not a bead, for what does not give"
        )
    return _read_only(values)


def _read_only(values: Array) -> Array:
    values.setflags(write=False)
    return values

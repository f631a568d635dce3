"""The chain of beads: its builders, and the methods that return a modified chain.

The default chain is that of the paper: scaled variables (Sec. 2; in units of the radius and mass
of the first bead and of the velocity of the impact), touching beads at rest, an impact on bead 1,
free ends and no losses.  Other features (walls, gaps, losses, drives, ...) are optional fields.
Bead ``k = 1..N`` counts from the struck end; contact ``k`` joins beads ``k`` and ``k + 1``.  Arrays
start at 0: ``chain.radii[0]`` is bead 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..collision import HERTZ_EXPONENT
from ..errors import InputError
from ..validation.keywords import FIELD_ALIASES, checked_arguments, checked_fields
from ..validation.numbers import plain_magnitude, real_numbers, whole_number
from ..validation.objects import check_list
from . import builder_arguments as builder
from . import contact_shapes, modifications, pieces, strikers
from .fields import ChainFields
from .input_checks import checked_beads, checked_radii
from .materials import Material, MaterialLike, material
from .static_state import StaticState, static_state
from .taper_sizes import Sizes, taper_of_sizes
from .tapers import PARAMETERS


@checked_fields
@dataclass(frozen=True, eq=False, repr=False)
class Chain(ChainFields):
    r"""Beads, contacts, ends and initial velocities of a chain.

    By default bead 1 has velocity 1 and all others are at rest.  A precompressed chain in SI
    units is at rest unless you give its velocities.  Beads have numbers from 1, arrays start at 0:
    :doc:`/reference/numbering`.

    Use a builder: `Chain.tapered`, `Chain.uniform` or `Chain.from_radii` for the scaled
    variables of the paper, `Chain.from_materials` for SI units; `Chain.replace` changes fields.
    The equation of motion of the default chain, Eq. (4) of the paper, is

    .. math::

        m_k \ddot x_k = r_{k-1}(x_{k-1}-x_k)_+^{p} - r_k (x_k-x_{k+1})_+^{p},
        \qquad v_1(0) = m_1 = R_1 = 1 .

    Chains are equal (``==``) if all fields are equal and the same ones were given.

    Attributes
    ----------
    radii : ndarray, shape (N,)
        Radii :math:`R_k` [scaled, or m].  The builders of scaled chains use the first radius as
        the unit; it differs from 1 if beads deviate from those of such a chain.
    exponent : float, array_like of shape (N - 1,), or mapping
        Exponent p of the contact force, > 1; 3/2 for spheres (Hertz).  One value for all
        contacts and walls, one per contact of two beads, or one per pair of materials, such as
        ``{("steel-316", "ptfe"): 1.5, ...}``.
    taper : str or None
        Name of the taper, if the chain was created from one.
    taper_parameters : tuple of pairs
        Name and value of each parameter of the taper, such as ``(("rate", 0.05),)``.
    masses : ndarray, shape (N,)
        Masses :math:`m_k` > 0 [scaled, or kg]; if not given, :math:`R_k^3` (Eq. (3) of
        the paper), or computed from the densities.
    stiffness : ndarray, shape (N - 1,)
        Stiffness :math:`r_k` > 0 of each contact [scaled, or N/m^p]; if not given,
        that of Hertz: below Eq. (4) of the paper, or from the materials.
    units : str
        ``"scaled"`` or ``"SI"`` (m, kg, s, N).  `hertzchain.Scales` converts.
    materials : tuple of Material, length N, or None
        Material of each bead, if known.
    velocities : ndarray, shape (N,)
        Velocities at time 0, positive towards bead N [scaled, or m/s]; if not given, 1
        for bead 1 (or the strikers) and 0 for the others, or 0 for all if there is a drive or,
        in SI units, precompression.
    gaps : ndarray, shape (N - 1,)
        Distance >= 0 between neighbouring beads at time 0 [scaled, or m]; 0 if not given.
    strikers : int
        Number of beads at the front that are strikers, which arrive in free flight and are not
        part of the static equilibrium.  See `Chain.struck_by`.
    precompression : float
        Static force >= 0 on every contact after the strikers [scaled, or N]; with gravity, on
        the contact with the smallest force.
    held_by : str
        Support of a precompressed chain: ``"walls"`` at both ends, which do not move, or
        ``"force"``, a constant force at each end without a wall.
    gravity : float
        Component of the acceleration of gravity along the chain, positive towards bead N
        [scaled, or m/s^2].  A chain that rests on a wall without gaps is in equilibrium at
        time 0; otherwise it falls.
    left_wall, right_wall : Wall or None
        Walls behind bead 1 and ahead of bead N; `None` is a free end.
    drive : SineBurst, StepDrive, TableDrive or None
        Force on bead 1, or displacement of the left wall, as a function of time.
    loss : Restitution, Viscoelastic, ..., list of length N - 1, mapping or None
        Law of `hertzchain.chain.laws`: one for all contacts and walls, one per contact of two
        beads, or one per pair of materials.

    Raises
    ------
    InputError
        If a field is out of range or contradicts another.

    Warns
    -----
    InputWarning
        If radii in SI units look like millimetres.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.tapered("backward-exponential", 0.05, beads=100)
    >>> chain
    Chain(backward-exponential, q = 0.05, 100 beads)
    >>> chain.radii[:3].round(4)
    array([1.    , 1.0526, 1.108 ])
    >>> chain.replace(right_wall=hc.Wall(), gravity=0.01)
    Chain(backward-exponential, q = 0.05, 100 beads, gravity, right wall)
    """

    @classmethod
    @checked_arguments("Chain.tapered", (*PARAMETERS, *builder.TAPER_FIELDS), FIELD_ALIASES)
    def tapered(
        cls,
        taper: str | None = None,
        rate: float | None = None,
        *,
        beads: int,
        first: float | str | None = None,
        last: float | str | None = None,
        first_diameter: float | str | None = None,
        last_diameter: float | str | None = None,
        ratio: float | None = None,
        length: float | str | None = None,
        materials: MaterialLike | Sequence[MaterialLike] | None = None,
        velocity: float | str | None = None,
        exponent: float = HERTZ_EXPONENT,
        **others: Any,
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

        A taper is given either by its name and rate or by sizes: the first bead and one of
        ``last``, ``ratio`` and ``length``, which determine direction and rate.

        Parameters
        ----------
        taper : str, optional
            A name in `TAPERS`; with sizes ``"exponential"`` (the default) or ``"linear"``.
        rate : float, optional
            Tapering parameter: S > 0 of a linear, 0 < q < 1 of an exponential taper.
        beads : int
            Number of beads N, at least 2.
        first, last : float or str, optional
            Radii of the first and last bead [m; without a material in any one unit, and the first
            is 1 by default].
        first_diameter, last_diameter : float or str, optional
            Their diameters, instead of their radii.
        ratio : float, optional
            Radius of the last bead over that of the first.
        length : float or str, optional
            Length of the touching beads, the sum of their diameters [as ``first``].
        materials : str, Material or sequence of them, optional
            Material of all beads, or of each; the chain is then in SI units, and ``first`` is
            required.  In all builders, ``material`` is another name of this argument.
        velocity : float or str, optional
            Velocity of bead 1 at time 0 [m/s], in a chain of a material; 1 if not given.
        exponent : float
            Exponent p of the contact force, > 1.
        **others
            Fields of `Chain`, such as ``right_wall``; parameters of a taper with more than a rate.

        Raises
        ------
        InputError
            For an unknown taper, parameter or material, a rate, size or number of beads out of
            range, sizes that contradict each other, or radii that overflow.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.Chain.tapered("forward-linear", 0.25, beads=4).radii
        array([1.  , 0.75, 0.5 , 0.25])
        >>> hc.Chain.tapered(ratio=0.25, beads=40)
        Chain(forward-exponential, q = 0.0361853, 40 beads)
        >>> hc.Chain.tapered(first="10 mm", last="2.5 mm", beads=40, material="steel-52100")
        Chain(40 steel-52100 beads, diameters 20 mm to 5 mm, impact at 1 m/s)
        """
        count = checked_beads(beads)
        fields = {name: others.pop(name) for name in builder.TAPER_FIELDS if name in others}
        sizes = Sizes(first, last, first_diameter, last_diameter, ratio, length)
        kind, values, radii, unit = taper_of_sizes(
            taper, rate, others, count, sizes, si=materials is not None
        )
        fields["exponent"] = exponent
        if materials is not None:
            return cls.from_materials(unit * radii, materials, velocity=velocity, **fields)
        if velocity is not None:
            raise InputError(
                "velocity requires materials: the velocity of the impact is 1 in scaled variables"
            )
        return cls(radii, taper=kind, taper_parameters=tuple(values.items()), **fields)

    @classmethod
    @checked_arguments("Chain.uniform", builder.OTHER_FIELDS)
    def uniform(cls, beads: int, **fields: Any) -> Chain:
        """A chain of equal beads, in which an impact becomes a solitary wave.

        Parameters
        ----------
        beads : int
            Number of beads N, at least 2.
        **fields
            Fields of `Chain`, such as ``exponent`` and ``right_wall``.

        Raises
        ------
        InputError
            If there are fewer than two beads or more than fit in memory, or a field is wrong.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.Chain.uniform(20)
        Chain(uniform, 20 beads)
        """
        return cls(np.ones(checked_beads(beads)), **fields)

    @classmethod
    @checked_arguments("Chain.from_radii", builder.OTHER_FIELDS)
    def from_radii(cls, radii: ArrayLike, **fields: Any) -> Chain:
        """A chain of spheres of one material with arbitrary radii.

        Parameters
        ----------
        radii : array_like, shape (N,)
            Radii of the beads, struck bead first, in one arbitrary unit.  The chain stores
            them in units of the first radius.
        **fields
            Fields of `Chain`, such as ``exponent`` and ``right_wall``.

        Raises
        ------
        InputError
            If a radius is not positive and finite, fewer than two are given, or a field is wrong.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.Chain.from_radii([5.0, 2.5, 5.0]).masses
        array([1.   , 0.125, 1.   ])
        """
        given = checked_radii(plain_magnitude("radius", radii, "m"))
        with np.errstate(over="ignore", under="ignore"):
            return cls(given / given[0], **fields)

    @classmethod
    @checked_arguments("Chain.from_materials", builder.OTHER_FIELDS, FIELD_ALIASES)
    def from_materials(
        cls,
        radii: ArrayLike | None = None,
        materials: MaterialLike | Sequence[MaterialLike] | None = None,
        *,
        diameters: ArrayLike | None = None,
        beads: int | None = None,
        velocity: float | str | None = None,
        **fields: Any,
    ) -> Chain:
        r"""A chain in SI units, from radii or diameters and materials.

        All contacts are Hertz contacts, also those of different materials:
        `hertzchain.chain.materials.sphere_stiffness`.

        Parameters
        ----------
        radii : array_like
            Radius of each bead [m], struck bead first; or one for all.
        materials : str, Material or sequence of them
            A material or its name in the catalogue, for all beads or for each.
        diameters : array_like, optional
            Diameters [m], instead of radii.
        beads : int, optional
            Number of beads, if there is one radius and one material for all.
        velocity : float
            Velocity of bead 1 at time 0 [m/s]; 1 if not given, or 0 if there is a drive or
            precompression.
        **fields
            Other fields of `Chain`.

        Raises
        ------
        InputError
            For an unknown material, lists of different lengths, or a field out of range.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.Chain.from_materials(5e-3, "steel-52100", beads=20)
        Chain(20 steel-52100 beads, diameter 10 mm, impact at 1 m/s)
        >>> hc.Chain.from_materials(diameters="10 mm", materials="steel-52100", beads=20)
        Chain(20 steel-52100 beads, diameter 10 mm, impact at 1 m/s)
        """
        if materials is None or (radii is None) == (diameters is None):
            raise InputError(
                "Chain.from_materials needs materials and either radii or diameters, such as "
                "Chain.from_materials(diameters='10 mm', materials='steel-52100', beads=20)"
            )
        one = isinstance(materials, str | Material)
        named = [materials] if one else check_list("materials", materials, "names")
        given = builder.radii_of_beads(radii, diameters, beads, None if one else len(named))
        kinds = tuple(map(material, named)) * (len(given) if one else 1)
        if velocity is not None:
            fields["velocities"] = builder.velocities(len(given), velocity, fields)
        return cls(given, units="SI", materials=kinds, **fields)

    @classmethod
    @checked_arguments("Chain.periodic", ("velocity", *builder.OTHER_FIELDS), FIELD_ALIASES)
    def periodic(
        cls,
        cell: ArrayLike,
        *,
        cells: int,
        materials: MaterialLike | Sequence[MaterialLike] | None = None,
        **fields: Any,
    ) -> Chain:
        """A chain that repeats a cell of beads, such as a dimer or trimer.

        Parameters
        ----------
        cell : array_like
            Radii of the beads of one cell, in one arbitrary unit; in m with materials.
        cells : int
            Number of repetitions.
        materials : str, Material or sequence of them, optional
            Material of all beads, or of each bead of the cell.  The chain is then in SI units.
        **fields
            Arguments of `from_materials`, or of `from_radii`.

        Raises
        ------
        InputError
            If a radius is not positive, or a material unknown.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.Chain.periodic([5.0, 2.5, 2.5], cells=2).radii
        array([1. , 0.5, 0.5, 1. , 0.5, 0.5])
        >>> hc.Chain.periodic([9.5e-3, 9.5e-3], cells=20, materials=["steel-316", "ptfe"])
        Chain(40 beads of steel-316 and ptfe, diameter 19 mm, impact at 1 m/s)
        """
        cells = whole_number("cells", cells, least=1)
        one = real_numbers("radius", cell, "bead", unit="m")
        checked_beads(cells * one.size)
        radii = np.tile(np.atleast_1d(one), cells)
        if materials is None:
            return cls.from_radii(radii, **fields)
        materials = builder.repeated_materials(materials, one.size, len(radii))
        return cls.from_materials(radii, materials, **fields)

    @classmethod
    @checked_arguments("Chain.dimer", ("velocity", *builder.OTHER_FIELDS), FIELD_ALIASES)
    def dimer(
        cls,
        mass_ratio: float | None = None,
        *,
        beads: int,
        radii: ArrayLike | None = None,
        diameters: ArrayLike | None = None,
        materials: MaterialLike | Sequence[MaterialLike] | None = None,
        **fields: Any,
    ) -> Chain:
        """Alternating beads of two kinds: with a mass ratio and equal contacts, or with two sizes.

        With equal contacts, the mass ratio is the only parameter: at 1, 0.3428, 0.1548, 0.0901, ...
        there are solitary waves (K. R. Jayaprakash, Y. Starosvetsky, A. F. Vakakis, Phys. Rev. E
        83, 036606, 2011, doi:10.1103/PhysRevE.83.036606).  The contacts of alternating spheres of
        one material are equal, too; their common factor only changes the unit of time.

        Parameters
        ----------
        mass_ratio : float, optional
            Mass of the light beads over that of the heavy, > 0; the first bead is heavy.
        beads : int
            Number of beads.
        radii, diameters : array_like, optional
            Two radii or diameters, or one for both, instead of the mass ratio [m with materials].
        materials : str, Material or sequence of two, optional
            Material of both kinds of beads, or of each.  The chain is then in SI units.
        **fields
            Other fields, such as ``exponent`` or, with materials, ``velocity``.

        Raises
        ------
        InputError
            If a value is out of range, or there is not exactly one of the ratio and the sizes.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.Chain.dimer(0.125, beads=4).masses
        array([1.   , 0.125, 1.   , 0.125])
        >>> hc.Chain.dimer(diameters=["10 mm", "6 mm"], materials=["steel-316", "ptfe"], beads=21)
        Chain(21 beads of steel-316 and ptfe, diameters 10 mm and 6 mm in turn, impact at 1 m/s)
        """
        count = checked_beads(beads)
        if mass_ratio is None or radii is not None or diameters is not None:
            sizes = np.resize(builder.two_sizes(mass_ratio, radii, diameters), count)
            if materials is None:
                return cls.from_radii(sizes, **fields)
            kinds = builder.repeated_materials(materials, 2, count)
            return cls.from_materials(sizes, kinds, **fields)
        masses = builder.dimer_masses(mass_ratio, count, materials, fields)
        return cls(np.cbrt(masses), masses=masses, stiffness=np.ones(count - 1), **fields)

    @cached_property
    def static_state(self) -> StaticState:
        """Positions and forces before the impact; see `hertzchain.equilibrium`."""
        return static_state(self)

    # Methods that return a modified chain, in separate files.
    __add__ = pieces.joined
    __getitem__ = pieces.part
    __iter__ = None  # a slice of a chain is a chain, but a bead is not
    reversed = pieces.reversed_beads
    decorated = modifications.decorated
    with_defects = modifications.with_defects
    with_scatter = modifications.with_scatter
    struck_by = strikers.struck_by
    with_contacts = contact_shapes.with_contacts

    def _repr_html_(self) -> str:
        from ..notebook.chains import chain_html

        return chain_html(self)

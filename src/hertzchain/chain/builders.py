"""Builders of `hertzchain.Chain`: tapers, equal beads, given radii, materials, repeated cells."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from ..collision import HERTZ_EXPONENT
from ..errors import InputError
from ..validation.keywords import FIELD_ALIASES, checked_arguments
from ..validation.numbers import plain_magnitude, whole_number
from ..validation.objects import check_list
from . import builder_arguments as builder
from .fields import ChainFields
from .input_checks import checked_beads, checked_radii
from .materials import Material, MaterialLike, material
from .taper_sizes import Sizes, taper_of_sizes
from .tapers import PARAMETERS


class ChainBuilders(ChainFields):
    """Class methods of `hertzchain.Chain` that create a chain."""

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
    ) -> Self:
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
            Tapering parameter: S > 0 of a linear, 0 < q < 1 of an exponential taper; 0 for
            equal beads, a chain without a taper.
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
            Exponent p of the contact force, > 1.  The stiffness remains proportional to the square
            root of the effective radius, as for spheres, also with the exponent 2 of cones.
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
        Chain(40 steel-52100 beads, diameters 20 mm to 5 mm, exponential taper, impact at 1 m/s)
        """
        count = checked_beads(beads, least=2)
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
    def uniform(cls, beads: int, **fields: Any) -> Self:
        """A chain of equal beads, in which an impact becomes a solitary wave.

        Parameters
        ----------
        beads : int
            Number of beads N; a single bead can be struck by a striker.
        **fields
            Fields of `Chain`, such as ``exponent`` and ``right_wall``.

        Raises
        ------
        InputError
            If there is no bead or more than fit in memory, or a field is wrong.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.Chain.uniform(20)
        Chain(uniform, 20 beads)
        """
        return cls(np.ones(checked_beads(beads)), **fields)

    @classmethod
    @checked_arguments("Chain.from_radii", builder.OTHER_FIELDS)
    def from_radii(cls, radii: ArrayLike, **fields: Any) -> Self:
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
            If a radius is not positive and finite, none is given, or a field is wrong.

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
    ) -> Self:
        r"""A chain in SI units, from radii or diameters and materials.

        All contacts are Hertz contacts, also those of different materials:
        `hertzchain.chain.materials.sphere_stiffness`.

        Parameters
        ----------
        radii : array_like
            Radius of each bead [m], not its diameter, struck bead first; or one for all.
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
        if radii is not None and diameters is not None:
            raise InputError("Chain.from_materials has both radii and diameters: omit one")
        if materials is None or (radii is None and diameters is None):
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
        cell: ArrayLike | None = None,
        *,
        cells: int,
        diameters: ArrayLike | None = None,
        materials: MaterialLike | Sequence[MaterialLike] | None = None,
        **fields: Any,
    ) -> Self:
        """A chain that repeats a cell of beads, such as a dimer or trimer.

        Parameters
        ----------
        cell : array_like
            Radii of the beads of one cell, in one arbitrary unit; in m with materials.
        cells : int
            Number of repetitions.
        diameters : array_like, optional
            Diameters of the beads of one cell, instead of their radii.
        materials : str, Material or sequence of them, optional
            Material of all beads, or of each bead of the cell.  The chain is then in SI units.
        **fields
            Arguments of `from_materials`, or of `from_radii`.

        Raises
        ------
        InputError
            If a size is not positive, a material is unknown, or there is not exactly one of
            ``cell`` and ``diameters``.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.Chain.periodic([5.0, 2.5, 2.5], cells=2).radii
        array([1. , 0.5, 0.5, 1. , 0.5, 0.5])
        >>> hc.Chain.periodic(diameters=["19 mm"] * 2, cells=20, materials=["steel-316", "ptfe"])
        Chain(40 beads of steel-316 and ptfe, diameter 19 mm, impact at 1 m/s)
        """
        cells = whole_number("cells", cells, least=1)
        radii = builder.repeated_sizes(cell, diameters, cells)
        if materials is None:
            return cls.from_radii(radii, **fields)
        materials = builder.repeated_materials(materials, len(radii) // cells, len(radii))
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
    ) -> Self:
        """Alternating beads of two kinds: with a mass ratio and equal contacts, or with two sizes.

        With equal contacts, the mass ratio is the only parameter: at 1, 0.3428, 0.1548, 0.0901, ...
        there are solitary waves (K. R. Jayaprakash, Y. Starosvetsky, A. F. Vakakis, Phys. Rev. E
        83, 036606, 2011, doi:10.1103/PhysRevE.83.036606).  The contacts of alternating spheres of
        one material are equal, too; their common factor only changes the unit of time.

        Parameters
        ----------
        mass_ratio : float, optional
            Mass of the light beads over that of the heavy ones, > 0; the first bead is heavy.
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
        count = checked_beads(beads, least=2)
        if mass_ratio is None or radii is not None or diameters is not None:
            sizes = np.resize(builder.two_sizes(mass_ratio, radii, diameters), count)
            if materials is None:
                return cls.from_radii(sizes, **fields)
            kinds = builder.repeated_materials(materials, 2, count)
            return cls.from_materials(sizes, kinds, **fields)
        masses = builder.dimer_masses(mass_ratio, count, materials, fields)
        return cls(np.cbrt(masses), masses=masses, stiffness=np.ones(count - 1), **fields)

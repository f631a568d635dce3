"""The chain of beads, and its methods that return a modified chain.

The default chain is that of the paper: scaled variables (Sec. 2; in units of the radius and mass
of the first bead and of the velocity of the impact), touching beads at rest, an impact on bead 1,
free ends and no losses.  Other features (walls, gaps, losses, drives, ...) are optional fields.
Bead ``k = 1..N`` counts from the struck end; contact ``k`` joins beads ``k`` and ``k + 1``.  Arrays
start at 0: ``chain.radii[0]`` is bead 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..collision import Array
from ..errors import InputError
from ..frozen import name_replace
from ..representation import short
from ..validation.keywords import checked_fields, checked_methods
from ..validation.numbers import real_numbers
from . import contact_shapes, modifications, pieces, strikers, with_cap
from .builders import ChainBuilders
from .chain_words import chain_description
from .contact_groups import loading_forces
from .description import impact_in_words
from .static_state import StaticState, static_state

if TYPE_CHECKING:
    import pandas as pd


@name_replace
@checked_methods
@checked_fields
@dataclass(frozen=True, eq=False, repr=False)
class Chain(ChainBuilders):
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
        Exponent p of the contact force, > 1; 3/2 for spheres (Hertz).  A stiffness that is not
        given remains proportional to the square root of the effective radius.  One value for all
        contacts and walls, one per contact of two beads, or one per pair of materials, such as
        ``{("steel-316", "ptfe"): 1.5, "others": 1.4}``; ``"others"`` are all pairs not listed.
        Listed exponents of single contacts with a given stiffness can be 1, that of a linear
        spring, such as a pad; a wall next to it then has that of the nearest other contact.
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
    striker_properties : tuple of StrikerProperties
        Mass, face and contact of each striker, where they do not follow from its radius; empty if
        all do.  See `Chain.struck_by`.
    cap : Cap or None
        Mass and contact of the last bead, if it is a flat cap.  See `Chain.with_cap`.
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
        beads, or one per pair of materials, as for ``exponent``.

    scatter : ScatteredRadii or None
        Scatter of the radii and the radii without it, if the chain was created by `with_scatter`;
        it only affects the description.

    Raises
    ------
    InputError
        If a field is out of range or contradicts another.

    Warns
    -----
    InputWarning
        If radii in SI units look like millimetres, or other plain numbers are probably in another
        unit than that of SI.

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

    @property
    def description(self) -> str:
        """Short description of the chain, for titles of tables and figures."""
        return self.__dict__.get("_described_as") or chain_description(self)

    def __repr__(self) -> str:
        return short("Chain", self.description + impact_in_words(self.velocities, self.units))

    @cached_property
    def static_state(self) -> StaticState:
        """Positions and forces before the impact; see `hertzchain.equilibrium`."""
        return static_state(self)

    def loading_force(self, overlaps: ArrayLike) -> Array:
        """Forces of the contacts of two beads, at overlaps that are reached for the first time.

        Parameters
        ----------
        overlaps : array_like, shape (N - 1,)
            Overlaps; a negative one has no force [scaled, or m].

        Returns
        -------
        ndarray, shape (N - 1,)
            Elastic forces, and those beyond yield; without damping [scaled, or N].

        Raises
        ------
        InputError
            If there are too few or many overlaps.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.Chain.uniform(3).loading_force([4.0, -1.0])
        array([8., 0.])
        """
        values = real_numbers("overlap", overlaps, "contact", unit=self._unit("m"))
        if values.shape != (self.beads - 1,):
            raise InputError(
                f"there must be {self.beads - 1} overlaps, one for each contact of two beads, got "
                f"shape {values.shape}"
            )
        return loading_forces(self.contact_groups, np.pad(values, 1))[1:-1]

    @property
    def _free_cap(self) -> bool:
        """Whether the cap has no wall behind it, such as an instrument behind the row."""
        return self.cap is not None and self.right_wall is None

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per bead, strikers and a cap included.

        Returns
        -------
        pandas.DataFrame
            Indexed by ``bead`` = 1..N; columns ``name`` (such as ``ball 3``) if there are
            strikers or a cap, ``material`` if the chain has materials, ``radius``, ``diameter``,
            ``mass``, ``position`` of the centre from the left end of the first bead, ``gap`` to the
            next bead or the right wall (NaN at a free end) and initial ``velocity``.  A flat
            striker and a cap have no radius (NaN) and the thickness that figures show.  Gaps of
            scaled chains are in units of overlaps and are not included in positions.
            ``attrs["units"]`` has the units ("1": scaled).

        Examples
        --------
        >>> import hertzchain as hc
        >>> row = hc.Chain.from_materials(diameters=["10 mm", "8 mm"], materials="steel-52100")
        >>> table = row.to_dataframe()
        >>> table.position.round(6).to_dict(), table.attrs["units"]["position"]
        ({1: 0.005, 2: 0.014}, 'm')
        """
        from .bead_table import bead_table

        return bead_table(self)

    # Methods that return a modified chain, in separate files.
    __add__ = pieces.joined
    __getitem__ = pieces.part
    __iter__ = None  # a slice of a chain is a chain, but a bead is not
    reversed = pieces.reversed_beads
    decorated = modifications.decorated
    with_defects = modifications.with_defects
    with_scatter = modifications.with_scatter
    struck_by = strikers.struck_by
    with_cap = with_cap.with_cap
    with_contacts = contact_shapes.with_contacts

    def _repr_html_(self) -> str:
        from ..notebook.chains import chain_html

        return chain_html(self)

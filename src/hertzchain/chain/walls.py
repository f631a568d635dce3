"""Walls at the ends of a chain: flat, elastic or rigid, touching or at a distance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hertzchain.chain.materials import RIGID, Material, MaterialLike, material
from hertzchain.chain.parts import Part
from hertzchain.checks import number
from hertzchain.errors import InputError

if TYPE_CHECKING:
    from hertzchain.chain.scales import Scales


@dataclass(frozen=True)
class Wall(Part):
    r"""A flat wall; its contact with the last bead beside it is one like all others.

    ``Wall()`` is of the bead's own material, ``Wall.of("brass")`` of another and
    ``Wall.rigid()`` does not give at all; ``Wall(stiffness=...)`` says outright how stiff
    the contact is.  Against a flat wall a sphere of radius R has the Hertz stiffness
    :math:`\frac43 E^*\sqrt{R}`: :math:`\sqrt2` times that of two such spheres if all are of
    one material, :math:`2\sqrt2` times if the wall is rigid.

    Attributes
    ----------
    stiffness : float or None
        Stiffness k > 0 of the contact of wall and bead [scaled, or N/m^p], if given; with a
        unit only where p = 3/2.
    material : Material or None
        Material of the wall; the bead's own if `None`.
    gap : float
        Distance between wall and bead at the beginning, >= 0 [scaled, or m].

    Examples
    --------
    >>> Wall(gap=0.1)
    Wall(own material, gap = 0.1)
    >>> Wall.of("steel-52100")
    Wall(steel-52100)
    """

    stiffness: float | None = None
    material: Material | None = None
    gap: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.stiffness is not None:
            if self.material is not None:
                raise InputError(
                    "a wall has a stiffness or a material, not both: the material decides how "
                    "stiff its contact is"
                )
            k = number("stiffness of a wall", self.stiffness, unit="N/m**1.5", above=0.0,
                       hint="Wall.rigid() does not give")  # fmt: skip
            object.__setattr__(self, "stiffness", k)
        elif self.material is not None:
            object.__setattr__(self, "material", material(self.material))
        gap = number("gap to a wall", self.gap, unit="m", least=0.0)
        object.__setattr__(self, "gap", gap)

    @classmethod
    def of(cls, name: MaterialLike, *, gap: float = 0.0) -> Wall:
        """A wall of a material.

        Parameters
        ----------
        name : str or Material
            A material or its name in the catalogue.
        gap : float
            Distance to the bead at the beginning [scaled, or m].

        Returns
        -------
        Wall

        Raises
        ------
        InputError
            For an unknown material or a negative gap.

        Examples
        --------
        >>> Wall.of("steel-52100").material.poisson
        0.3
        """
        return cls(material=material(name), gap=gap)

    @classmethod
    def rigid(cls, *, gap: float = 0.0) -> Wall:
        """A wall that does not give: twice as stiff as one of the bead's material.

        Parameters
        ----------
        gap : float
            Distance to the bead at the beginning [scaled, or m].

        Returns
        -------
        Wall

        Raises
        ------
        InputError
            For a negative gap.

        Examples
        --------
        >>> Wall.rigid()
        Wall(rigid)
        """
        return cls(material=RIGID, gap=gap)

    def factors(self, scales: Scales) -> Mapping[str, float]:
        """Units of the fields that have one.

        Parameters
        ----------
        scales : Scales
            The units.

        Returns
        -------
        dict

        Examples
        --------
        >>> import hertzchain as hc
        >>> Wall(stiffness=1.0).factors(hc.Scales(1.0, 1.0, velocity=1.0, length=4.0))
        {'stiffness': 0.03125, 'gap': 4.0}
        """
        return {"stiffness": scales.stiffness, "gap": scales.length}

    def __repr__(self) -> str:
        what = "own material"
        if self.stiffness is not None:
            what = f"stiffness = {self.stiffness:g}"
        elif self.material is not None:
            what = self.material.name
        return f"Wall({what}{f', gap = {self.gap:g}' if self.gap else ''})"

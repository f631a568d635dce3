"""Walls at the ends of a chain: flat, elastic or rigid, touching or at a distance."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..errors import InputError, short_repr
from ..validation.numbers import number
from .input_checks import checked_exponent
from .laws import Loss
from .materials import RIGID, Material, MaterialLike, material
from .parts import Part
from .scales import scale


def _stiffness_unit(wall: Wall) -> str:
    return "stiffness" if wall.exponent is None else f"force/length^{wall.exponent}"


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
    exponent : float or None
        Exponent p of the contact of wall and bead; the chain's if `None`.
    loss : Restitution, Viscoelastic, ... or None
        Law of loss of this contact; the chain's if `None`, none at all with ``Elastic()``.

    Where exponents or losses of a chain differ, the chain's are those of the contact next to the
    wall or, if given by pairs of materials, those of the wall's material on the bead's.

    Examples
    --------
    >>> Wall(gap=0.1)
    Wall(own material, gap = 0.1)
    >>> Wall.of("steel-52100")
    Wall(steel-52100)
    """

    stiffness: float | None = field(default=None, metadata=scale(_stiffness_unit))
    material: Material | None = None
    gap: float = field(default=0.0, metadata=scale("length"))
    exponent: float | None = None
    loss: Loss | None = None

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
        if self.exponent is not None:
            object.__setattr__(self, "exponent", checked_exponent(self.exponent))
        if self.loss is not None and not isinstance(self.loss, Loss):
            raise InputError(
                f"loss of a wall must be a law of hertzchain.chain.laws or None, got "
                f"{short_repr(self.loss)}; Elastic() has no loss"
            )

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

    def __repr__(self) -> str:
        what = "own material"
        if self.stiffness is not None:
            what = f"stiffness = {self.stiffness:g}"
        elif self.material is not None:
            what = self.material.name
        parts = [what, f"gap = {self.gap:g}" if self.gap else ""]
        parts += [f"p = {self.exponent:g}" if self.exponent is not None else ""]
        parts += [f"loss = {self.loss}" if self.loss is not None else ""]
        return f"Wall({', '.join(filter(None, parts))})"

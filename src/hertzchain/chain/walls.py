"""Walls at the ends of a chain: flat, elastic or rigid, touching or at a distance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from ..collision import HERTZ_EXPONENT
from ..errors import InputError, short_repr
from ..units import has_dimension, quantity
from ..validation.keywords import checked_arguments, checked_fields
from ..validation.numbers import is_word, number
from .description import length_in_words, stiffness_in_words
from .input_checks import GAP_HINT, MAX_GAP, checked_wall_exponent
from .laws import Loss
from .materials import RIGID, Material, MaterialLike, material
from .parts import Part
from .scales import scale

# Stiffness of a linear contact without a unit from which it is also shown in that of SI units.
LARGE: Final = 1e3


def material_of_wall(wall: Wall | None, bead: Material) -> Material:
    """Material of a wall; by default, and at a free end, that of the bead next to it."""
    return bead if wall is None or wall.material is None else wall.material


def materials_with_walls(
    materials: Sequence[Material], walls: tuple[Wall | None, Wall | None]
) -> list[Material]:
    """Materials of left wall, beads and right wall."""
    left, right = walls
    return [
        material_of_wall(left, materials[0]), *materials, material_of_wall(right, materials[-1])
    ]  # fmt: skip


def _stiffness_unit(wall: Wall) -> str:
    return "stiffness" if wall.exponent is None else f"force/length^{wall.exponent}"


@checked_fields
@dataclass(frozen=True)
class Wall(Part):
    r"""A flat wall; its contact with the bead next to it is like all other contacts.

    ``Wall()`` has the material of the bead, ``Wall.of("brass")`` another one, and
    ``Wall.rigid()`` cannot be deformed; ``Wall(stiffness=...)`` sets the stiffness of the
    contact.  On a flat wall a sphere of radius R has the Hertz stiffness
    :math:`\frac43 E^*\sqrt{R}`: :math:`\sqrt2` times that of two such spheres if all have
    one material, :math:`2\sqrt2` times if the wall is rigid.  If exponents or losses of a chain
    differ, those of the contact next to the wall are used or, by pairs of materials, those for the
    materials of wall and bead.

    Attributes
    ----------
    stiffness : float or None
        Stiffness k > 0 of the contact of wall and bead [scaled, or N/m^p]; a unit is allowed
        only if p is 3/2 or 1.  By default, it follows from the material.
    material : Material or None
        Material of the wall; that of the bead if `None`.  If a stiffness is given, the material
        determines only the limits of Hertz's law under the force of the contact (`hertz_range`),
        first yield, and laws by pairs of materials.
    gap : float
        Distance between wall and bead at time 0, >= 0 [scaled, or m].
    exponent : float or None
        Exponent p of the contact of wall and bead, >= 1; that of the chain if `None`.  A linear
        spring, such as a pad or a load cell, has 1, as does a stiffness with a unit such as N/m.
    loss : Restitution, Viscoelastic, ... or None
        Law of loss of this contact; that of the chain if `None`, no loss with ``Elastic()``.  A
        spring whose loss is not that of the balls, such as a load cell, needs its own, except
        under `ElasticPlastic`, a law of spheres, under which springs stay elastic.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.Wall(gap=0.1)
    Wall(own material, gap = 0.1)
    >>> hc.Wall.of("steel-52100", gap="10 um")
    Wall(steel-52100, gap = 10 um)
    >>> hc.Wall("2 kN/mm")
    Wall(stiffness = 2 kN/mm, p = 1)
    """

    stiffness: float | None = field(default=None, metadata=scale(_stiffness_unit))
    material: Material | None = None
    gap: float = field(default=0.0, metadata=scale("length"))
    exponent: float | None = None
    loss: Loss | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if isinstance(self.stiffness, Material) or is_word(self.stiffness):
            name = getattr(self.stiffness, "name", self.stiffness)
            raise InputError(
                f"the first argument of Wall is its stiffness, a number, got {name!r}; a wall of a "
                f"material is Wall.of({name!r})"
            )
        if self.exponent is None and isinstance(self.stiffness, str):
            parts = quantity(self.stiffness)
            if parts is not None and has_dimension(parts[1], "N/m"):
                object.__setattr__(self, "exponent", 1.0)
        if self.exponent is not None:
            object.__setattr__(self, "exponent", checked_wall_exponent(self.exponent))
        if self.stiffness is not None:
            unit = "N/m" if self.exponent == 1.0 else "N/m**1.5"
            k = number("stiffness of a wall", self.stiffness, unit=unit, above=0.0,
                       hint="for a rigid wall, use Wall.rigid()")  # fmt: skip
            object.__setattr__(self, "stiffness", k)
        if self.material is not None:
            object.__setattr__(self, "material", material(self.material))
        gap = number("gap to a wall", self.gap, unit="m", least=0.0, most=MAX_GAP,
                     hint=GAP_HINT)  # fmt: skip
        object.__setattr__(self, "gap", gap)
        if self.loss is not None and not isinstance(self.loss, Loss):
            raise InputError(
                f"loss of a wall must be a law, such as Restitution(0.95), or None, got "
                f"{short_repr(self.loss)}; Elastic() has no loss"
            )

    def _repr_html_(self) -> str:
        from ..notebook.chains import wall_html

        return wall_html(self)

    @classmethod
    @checked_arguments("Wall.of")
    def of(cls, name: MaterialLike, *, gap: float = 0.0) -> Wall:
        """A wall of a given material.

        Parameters
        ----------
        name : str or Material
            A material or its name in the catalogue.
        gap : float
            Distance to the bead at time 0 [scaled, or m].

        Raises
        ------
        InputError
            For an unknown material or a negative gap.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.Wall.of("steel-52100").material.poisson
        0.3
        """
        return cls(material=material(name), gap=gap)

    @classmethod
    @checked_arguments("Wall.rigid")
    def rigid(cls, *, gap: float = 0.0) -> Wall:
        """A rigid wall: its contact is twice as stiff as that of a wall of the bead's material.

        Parameters
        ----------
        gap : float
            Distance to the bead at time 0 [scaled, or m].

        Raises
        ------
        InputError
            For a negative gap.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.Wall.rigid()
        Wall(rigid)
        """
        return cls(material=RIGID, gap=gap)

    def __repr__(self) -> str:
        kind = "own material" if self.stiffness is None else ""
        if self.material is not None:
            kind = self.material.name
        stiffness = "" if self.stiffness is None else f"stiffness = {self._stiffness_in_words()}"
        real = "gap" in self.with_units or self.material not in (None, RIGID)
        gap = length_in_words(self.gap) if real else f"{self.gap:g}"
        parts = [kind, stiffness, f"gap = {gap}" if self.gap else ""]
        parts += [f"p = {self.exponent:g}" if self.exponent is not None else ""]
        parts += [f"loss = {self.loss}" if self.loss is not None else ""]
        return f"Wall({', '.join(filter(None, parts))})"

    def _stiffness_in_words(self) -> str:
        """The given stiffness, in the unit of its contact if it was given with a unit."""
        if self.stiffness is None or "stiffness" not in self.with_units:
            if self.stiffness is None:
                return ""
            # A wall is independent of its chain; in scaled variables, stiffnesses are small.
            meant = self.exponent == 1.0 and self.stiffness >= LARGE
            in_si = f" (in SI units {stiffness_in_words(self.stiffness, 1.0)})" if meant else ""
            return f"{self.stiffness:g}{in_si}"
        return stiffness_in_words(self.stiffness, 1.0 if self.exponent == 1.0 else HERTZ_EXPONENT)

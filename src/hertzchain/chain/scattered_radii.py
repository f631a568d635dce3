"""Scatter of the radii of a chain, for its description and its chain file."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import Self

import numpy as np

from ..collision import Array
from ..errors import InputError, short_repr
from ..frozen import Frozen
from .scales import scale


@dataclass(frozen=True, eq=False)
class ScatteredRadii(Frozen):
    """How the radii of a chain deviate, and the beads without deviations; has no effect on motion.

    Attributes
    ----------
    radii : ndarray, shape (N,)
        Radii without deviations [scaled, or m].
    relative : float or None
        Standard deviation of the logarithm of the radius.
    grade : int or None
        Grade of ISO 3290-1, instead of a relative deviation.
    taper : str or None
        Name of the taper of the beads without deviations.
    taper_parameters : tuple of pairs
        Its parameters.
    """

    radii: Array = field(metadata=scale("radius"))
    relative: float | None = None
    grade: int | None = None
    taper: str | None = None
    taper_parameters: tuple[tuple[str, float], ...] = ()

    def __post_init__(self) -> None:
        self.radii.setflags(write=False)

    def words(self, radii: Array, balls: slice) -> str:
        """Such as ``10% scatter``, ``grade 100`` or ``1% scatter of 3 beads``."""
        # The radius of a cap is not a size.
        deviates = (radii != self.radii)[: balls.stop]
        deviating = int(np.count_nonzero(deviates))
        if deviating == 0:
            return ""
        size = scatter_in_words(self.relative, self.grade)
        # The bead that is struck often keeps its size.
        if deviating >= len(deviates[balls]) - 1:
            return size
        return f"{size} of {deviating} bead{'s' * (deviating > 1)}"

    def with_radii(self, radii: Array) -> Self:
        """The same scatter of other beads, which do not form a taper."""
        return dataclasses.replace(self, radii=radii, taper=None, taper_parameters=())

    def behind(self, strikers: int, radius: float, struck: Array) -> Self:
        """The same scatter behind strikers, in front of beads with the radii ``struck``."""
        if radius == struck[0]:  # a striker of this size is described by that without deviation
            radius = float(self.radii[-len(struck)])
        return self.with_radii(np.concatenate((np.full(strikers, radius), self.radii)))

    def like(self, other: Self) -> bool:
        """Whether the deviations have the same size."""
        return (self.relative, self.grade) == (other.relative, other.grade)


def scatter_in_words(relative: float | None, grade: int | None) -> str:
    """Such as ``10% scatter`` or ``grade 100``."""
    return f"grade {grade}" if relative is None else f"{100.0 * relative:.4g}% scatter"


def check_scatter_of(scatter: object, beads: int) -> None:
    """Raise `InputError` unless it is the scatter of this number of beads, or `None`."""
    if scatter is None:
        return
    if not isinstance(scatter, ScatteredRadii) or len(scatter.radii) != beads:
        raise InputError(
            f"scatter must be that of a chain of {beads} beads, or None, got "
            f"{short_repr(scatter)}; use Chain.with_scatter"
        )

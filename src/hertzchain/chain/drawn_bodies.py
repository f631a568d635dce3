"""Sizes and positions of the bodies of a chain in figures: spheres, and plates with a flat face."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from ..collision import Array

if TYPE_CHECKING:
    from .fields import ChainFields

# Half of the width of a plate, in radii of the first ball behind the strikers.
PLATE: Final = 0.25


def flat_bodies(chain: ChainFields) -> Array:
    """Whether each body is drawn as a plate: a flat striker or a cap."""
    return np.isinf(chain.face_radii)


def half_widths(chain: ChainFields) -> Array:
    """Half of the extent of each body along the chain: its radius, unless its face is flat."""
    return np.where(flat_bodies(chain), PLATE * chain.radii[chain.strikers], chain.radii)


def half_heights(chain: ChainFields) -> Array:
    """Half of the extent of each body across the chain; that of the first ball for plates."""
    return np.where(flat_bodies(chain), chain.radii[chain.strikers], chain.radii)


def body_centres(chain: ChainFields) -> Array:
    """Positions of the centres of the bodies, from the left end of the first one.

    Scaled gaps are in units of the overlaps, which are negligible compared with a radius.
    """
    widths = half_widths(chain)
    apart = widths[:-1] + widths[1:] + (0.0 if chain.scaled else chain.gaps)
    return np.asarray(widths[0] + np.concatenate(([0.0], np.cumsum(apart))))


def pad_contacts(chain: ChainFields) -> list[int]:
    """Contacts from 0 to N that are linear springs: pads and load cells, drawn as layers."""
    springs = (chain.contact_stiffness > 0.0) & (chain.contact_exponents == 1.0)
    return [int(k) for k in np.flatnonzero(springs)]


def contact_places(chain: ChainFields) -> Array:
    """Positions of contacts 0 to N, those of walls at their faces."""
    centres, widths = body_centres(chain), half_widths(chain)
    middle = 0.5 * (centres[:-1] + widths[:-1] + centres[1:] - widths[1:])
    left, right = (
        0.0 if wall is None or chain.scaled else wall.gap
        for wall in (chain.left_wall, chain.right_wall)
    )
    return np.concatenate(([-left], middle, [centres[-1] + widths[-1] + right]))


def known_radii(chain: ChainFields) -> Array:
    """Radii of the spheres, without bodies that are drawn as plates."""
    return chain.radii[~flat_bodies(chain)]

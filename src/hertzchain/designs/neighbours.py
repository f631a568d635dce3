"""Neighbouring balls of a design whose sizes differ so much that such a row is hard to build."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..chain.chain import Chain
from .ball_space import BallSpace
from .size_space import SizeSpace

# Ratio of neighbouring diameters above which a note names it.
MAX_RATIO: Final = 4.0


def notes_on_neighbours(chain: Chain, space: SizeSpace | BallSpace) -> list[str]:
    """A note on the largest ratio of neighbouring diameters of balls that were chosen."""
    if not isinstance(space, BallSpace) or space.order:
        return []
    balls = np.arange(chain.beads)[chain._balls]
    # A ball that was chosen, and its neighbour; strikers and caps have other faces.
    pairs = [k for k in balls[:-1] if k + 1 >= space.places[0]]
    ratios = [max(chain.radii[k] / chain.radii[k + 1], chain.radii[k + 1] / chain.radii[k])
              for k in pairs]  # fmt: skip
    if not ratios or not max(ratios) > MAX_RATIO:
        return []
    at = int(np.argmax(ratios))
    k, count = int(pairs[at]), int(np.sum(np.array(ratios) > MAX_RATIO))
    sizes = [_size(chain, i) for i in (k, k + 1)]
    more = f", and {count - 1} more neighbours differ by more than {MAX_RATIO:g}" * (count > 1)
    return [
        f"neighbouring balls of {sizes[0]} and {sizes[1]} (beads {k + 1} and {k + 2}) differ by a "
        f"factor of {ratios[at]:.2g}{more}: such rows are hard to align, and forces off the axis "
        "are not part of the model; limit the sizes with diameters, such as diameters = "
        "['5 mm', '8 mm', '10 mm']"
    ]


def _size(chain: Chain, place: int) -> str:
    """Such as ``5 mm``."""
    factor, unit = (2e3, " mm") if chain.units == "SI" else (2.0, "")
    return f"{factor * chain.radii[place]:.4g}{unit}"

"""Draw a chain to scale."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.patches import Circle

from ..chain.chain import Chain
from ..chain.feature_support import require_chain
from ..collision import Array
from .style import figure_style, get_axes, literal, set_title


def plot_chain(chain: Chain, *, ax: Axes | None = None) -> Axes:
    """Draw a chain to scale: beads, gaps and walls.

    Parameters
    ----------
    chain : Chain
        Any chain.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into.  By default, a new figure is created.

    Examples
    --------
    >>> import hertzchain as hc
    >>> axes = plot_chain(hc.Chain.tapered("forward-linear", 0.05, beads=15))
    >>> len(axes.collections)
    1
    """
    require_chain("plot_chain", chain)
    factor, unit = (1e3, "mm") if chain.units == "SI" else (1.0, "$R_1$")
    radii = factor * chain.radii
    centres = bead_centres(chain) * factor
    with figure_style():
        axes = get_axes(ax, figsize=(7.0, 1.6))
        circles = [Circle((x, 0.0), r) for x, r in zip(centres, radii, strict=True)]
        face = _face_colours(chain)
        axes.add_collection(
            PatchCollection(circles, facecolor=face, edgecolor="black", linewidth=0.4)
        )
        low, high = centres[0] - radii[0], centres[-1] + radii[-1]
        tall = 1.15 * radii.max()
        draw_walls(chain, factor, tall, axes)
        axes.set_aspect("equal")
        axes.set_xlim(low - 0.7 * radii.max(), high + 0.7 * radii.max())
        axes.set_ylim(-tall, tall)
        axes.set_xlabel(f"position [{unit}]")
        axes.set_yticks([])
        axes.spines["left"].set_visible(False)  # it would look like a wall
        set_title(axes, literal(chain.description))
    return axes


def draw_walls(chain: Chain, factor: float, tall: float, axes: Axes) -> None:
    """Draw the walls of a chain; their thickness is half the radius of the largest bead."""
    low, high = factor * np.array([0.0, bead_centres(chain)[-1] + chain.radii[-1]])
    thick = 0.5 * factor * chain.radii.max()
    for wall, at, side in ((chain.left_wall, low, -1.0), (chain.right_wall, high, 1.0)):
        if wall is not None:
            # Gaps have units of displacement: in scaled variables they are much smaller than beads.
            edge = at + side * (factor * wall.gap if chain.units == "SI" else 0.0)
            axes.fill_betweenx([-tall, tall], edge, edge + side * thick, facecolor="#BBBBBB",
                               hatch="///", edgecolor="black", linewidth=0.0, zorder=0)  # fmt: skip


def bead_centres(chain: Chain) -> Array:
    """Positions of the centres of the beads; bead 1 is at its radius."""
    apart = np.cumsum(chain.centre_distances)
    return np.asarray(chain.radii[0] + np.concatenate(([0.0], apart)))


def _face_colours(chain: Chain) -> list[str]:
    """A colour for each material, light enough for black edges."""
    kinds = chain.materials or (None,)
    tints = ("#DDE6EE", "#F0D9C0", "#D3E8DC", "#F3DDE9", "#E8E8E8", "#FBEFC9")
    tint = {kind: tints[i % len(tints)] for i, kind in enumerate(dict.fromkeys(kinds))}
    return [tint[kind] for kind in kinds]

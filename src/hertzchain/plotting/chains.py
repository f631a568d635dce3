"""Draw a chain to scale."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from typing import Any, Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.patches import Circle, Patch, Rectangle
from matplotlib.transforms import AffineDeltaTransform

from ..chain.chain import Chain
from ..chain.drawn_bodies import (
    body_centres,
    contact_places,
    flat_bodies,
    half_heights,
    half_widths,
    pad_contacts,
)
from ..chain.feature_support import require_chain
from ..collision import Array
from ..validation.keywords import checked_arguments
from .colours import COLOURS, grey
from .legends import figure_of
from .style import figure_style, get_axes, literal, set_title
from .titles import chain_title, printed_name
from .widths import NARROW, figure_size, journal_width

# Colours of the materials of the package, and those from which other materials receive one.
MATERIALS: Final = {
    "steel-52100": "#8DB1D6", "steel-304": "#D6E2EE", "steel-316": "#5E8DBB", "brass": "#EBCB6B",
    "bronze": "#CFA15A", "aluminium": "#D9DDE0", "titanium": "#B5B0C8",
    "tungsten-carbide": "#808890", "silicon-nitride": "#9DB8A6", "alumina": "#F4F1E8",
    "glass": "#BFE6E2", "ptfe": "#F2B48C", "nylon": "#F3DDE9", "polycarbonate": "#D8C0E8",
    "acrylic": "#E6F0B8", "rubber": "#6E6660",
}  # fmt: skip
OTHERS: Final = ("#D3E8DC", "#F7C6C6", "#C9D66B", "#E0A8D0", "#8FD0B0", "#FBEFC9")
UNKNOWN: Final = "#DDE6EE"
# Thickness of the layer of a pad, in radii of the largest bead.
PAD: Final = 0.22
PAD_COLOUR: Final = "#555555"
# Heights [inches] of a figure of a chain: of the labels of the x axis, of a title or a legend, and
# the largest one of the beads.
LABELS, TITLE, MAX_HEIGHT = 0.55, 0.3, 2.5


@checked_arguments("plot_chain")
def plot_chain(chain: Chain, *, ax: Axes | None = None) -> Axes:
    """Draw a chain to scale: beads, gaps and walls; an arrow marks strikers.

    A flat striker and a cap are plates, and pads and load cells dark layers, which are not to scale
    because their sizes are not known.
    Each material has the same colour in every figure; a legend names them if there are several.

    Parameters
    ----------
    chain : Chain
        Any chain.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into.  By default, a new figure is created.

    Examples
    --------
    >>> import hertzchain as hc
    >>> axes = hc.plot_chain(hc.Chain.tapered("forward-linear", 0.05, beads=15))
    >>> len(axes.collections)
    1
    """
    require_chain("plot_chain", chain, beads=1)
    factor, unit = _unit_of_length(chain)
    length, largest = factor * length_of(chain), factor * half_heights(chain).max()
    with figure_style():
        tall = 1.15 * largest
        axes = get_axes(ax) if ax is not None else _own_axes(chain, length / largest)
        draw_beads(chain, factor, axes)
        draw_walls(chain, factor, tall, axes)
        draw_pads(chain, factor, axes)
        axes.set_aspect("equal")
        axes.set_xlim(-0.8 * largest, length + 0.8 * largest)
        axes.set_ylim(-tall, tall)
        mark_strikers(chain, factor, axes)
        axes.set_xlabel(f"position [{unit}]")
        axes.set_yticks([])
        axes.spines["left"].set_visible(False)  # it would look like a wall
        set_title(axes, chain_title(chain))
        if ax is None and figure_of(axes).get_figwidth() < NARROW:
            material_legend([chain], axes, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3)
        else:
            material_legend([chain], axes, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return axes


def _own_axes(chain: Chain, length: float) -> Axes:
    """Axes of a new figure for a chain whose length is in radii of its largest bead."""
    width, _ = figure_size(7.0, 1.0)
    beads = min(MAX_HEIGHT, 0.9 * width * (2.3 + 0.5 * bool(chain.strikers)) / (length + 1.4))
    several = len({*material_names(chain)}) > 1
    title = TITLE if journal_width.get() is None or (several and width < NARROW) else 0.0
    axes: Axes = plt.subplots(figsize=(width, LABELS + beads + title))[1]
    return axes


def _unit_of_length(chain: Chain) -> tuple[float, str]:
    """Factor of radii in figures, and its unit."""
    if chain.units == "SI":
        return 1e3, "mm"
    return 1.0, "$R_1$" if chain.radii[chain.strikers] == 1.0 else "scaled"


def mark_strikers(chain: Chain, factor: float, axes: Axes) -> None:
    """Mark strikers by an arrow above them, of their length, with more room at the top."""
    if not chain.strikers:
        return
    largest, last = factor * half_heights(chain).max(), chain.strikers - 1
    begin, end = 0.0, factor * (body_centres(chain) + half_widths(chain))[last]
    height = 1.3 * largest
    axes.annotate("", (end, height), (begin, height),
                  arrowprops={"arrowstyle": "-|>", "color": COLOURS[2], "shrinkA": 0.0,
                              "shrinkB": 0.0})  # fmt: skip
    word = "striker" if chain.strikers == 1 else f"{chain.strikers} strikers"
    # On the line of the arrow, a word is above the beads in small panels, too.
    axes.annotate(word, (end, height), (3.0, 0.0), textcoords="offset points", color=COLOURS[2],
                  va="bottom", fontsize=8)  # fmt: skip
    axes.set_ylim(top=max(axes.get_ylim()[1], height + 0.35 * largest))


def draw_walls(chain: Chain, factor: float, tall: float, axes: Axes) -> None:
    """Draw the walls of a chain; their thickness is half the radius of the largest bead.

    Those with a pad or a load cell are behind its layer.
    """
    largest, layers = factor * half_heights(chain).max(), pad_contacts(chain)
    thick = 0.5 * largest
    for wall, contact, at, side in (
        (chain.left_wall, 0, 0.0, -1.0),
        (chain.right_wall, chain.beads, factor * length_of(chain), 1.0),
    ):
        if wall is not None:
            # Gaps have units of displacement: in scaled variables they are much smaller than beads.
            gap = factor * wall.gap if chain.units == "SI" else 0.0
            edge = at + side * (gap + PAD * largest * (contact in layers))
            axes.fill_betweenx([-tall, tall], edge, edge + side * thick, facecolor="#BBBBBB",
                               hatch="///", edgecolor="black", linewidth=0.0, zorder=0)  # fmt: skip


def draw_pads(chain: Chain, factor: float, axes: Axes) -> None:
    """Draw layers at contacts that are linear springs, such as pads."""
    largest, places = factor * half_heights(chain).max(), factor * contact_places(chain)
    thick, tall = PAD * largest, 0.8 * largest
    for k in pad_contacts(chain):
        # A layer at a wall covers neither the wall nor the bead, or the cap, before it.
        shift = {0: -thick, chain.beads: 0.0}.get(k, -0.5 * thick)
        axes.add_patch(Rectangle((places[k] + shift, -tall), thick, 2.0 * tall,
                                 facecolor=PAD_COLOUR, linewidth=0.0, zorder=3))  # fmt: skip


def length_of(chain: Chain) -> float:
    """Length of the touching beads of a chain; its left end is drawn at 0."""
    return float(body_centres(chain)[-1] + half_widths(chain)[-1])


def material_colour(name: str | None) -> str:
    """Colour of a material, the same in every figure and light enough for black edges."""
    if name is None:
        return UNKNOWN
    return MATERIALS.get(name) or OTHERS[zlib.crc32(name.encode()) % len(OTHERS)]


def material_names(chain: Chain) -> list[str | None]:
    """Name of the material of each bead."""
    if chain.materials is None:
        return [None] * chain.beads
    return [material.name for material in chain.materials]


def body_shapes(chain: Chain, factor: float) -> list[Patch]:
    """Shapes of all bodies with their centres at the origin: circles, and plates if flat."""
    widths, heights = factor * half_widths(chain), factor * half_heights(chain)
    return [
        Rectangle((-width, -height), 2.0 * width, 2.0 * height)
        if flat
        else Circle((0.0, 0.0), width)
        for flat, width, height in zip(flat_bodies(chain), widths, heights, strict=True)
    ]


def body_collection(
    chain: Chain, factor: float, centres: Array, axes: Axes, **style: Any
) -> PatchCollection:
    """Add the bodies to axes, as one collection with the centres as its offsets, shape (N, 2)."""
    found = PatchCollection(
        body_shapes(chain, factor), transform=AffineDeltaTransform(axes.transData),  # type: ignore[arg-type]
        offsets=centres, offset_transform=axes.transData, edgecolor="black", linewidth=0.4,
        **style,
    )  # fmt: skip
    # The limits of the axes do not follow from shapes with offsets.
    axes.add_collection(found, autolim=False)
    return found


def draw_beads(chain: Chain, factor: float, axes: Axes, *, height: float = 0.0) -> None:
    """Draw the beads in the colours of their materials, with the left end at 0."""
    centres = factor * body_centres(chain)
    faces = [material_colour(name) for name in material_names(chain)]
    places = np.column_stack([centres, np.full(chain.beads, height)])
    body_collection(chain, factor, places, axes, facecolor=faces)
    corners = np.column_stack([half_widths(chain), half_heights(chain)]) * factor
    axes.update_datalim(np.concatenate([places - corners, places + corners]))


def material_legend(chains: Sequence[Chain], axes: Axes, **options: Any) -> None:
    """Add a legend of the materials, if there is more than one."""
    names = dict.fromkeys(name for chain in chains for name in material_names(chain))
    if len(names) > 1:
        handles = [
            Patch(facecolor=material_colour(name), edgecolor="black", linewidth=0.4,
                  label=literal(printed_name(name or "no material")))
            for name in names
        ]  # fmt: skip
        axes.legend(handles=handles, handlelength=1.0, **options)


def scale_bar(chain: Chain, axes: Axes) -> None:
    """Draw a bar with its length below the chain, for axes that are switched off."""
    factor, unit = _unit_of_length(chain)
    largest = factor * half_heights(chain).max()
    power = 10.0 ** np.floor(np.log10(2.0 * largest))
    length = power * max(step for step in (1.0, 2.0, 5.0) if step * power <= 2.0 * largest)
    begin, height = 0.0, -1.35 * largest
    axes.plot([begin, begin + length], [height] * 2, color=grey(axes), linewidth=2.0,
              solid_capstyle="butt")  # fmt: skip
    axes.annotate(f"{length:g} {unit}", (begin + length, height), xytext=(4, 0),
                  textcoords="offset points", va="center", fontsize=8)  # fmt: skip
    axes.set_ylim(bottom=1.4 * height)

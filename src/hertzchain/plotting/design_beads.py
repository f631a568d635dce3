"""Plot the beads of a design, to scale and with their diameters."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.font_manager import FontProperties
from matplotlib.patches import Rectangle

from ..chain.chain import Chain
from ..chain.description import sizes_in_words
from ..chain.drawn_bodies import body_centres, flat_bodies, half_heights, known_radii
from ..collision import Array
from ..designs.comparison import DESIGN, same_as, shown_chains
from ..designs.limits_if_yielding import violated_if_fully_plastic
from ..designs.verified import AT_FULLY_PLASTIC, Verified, violated
from .chains import draw_beads, length_of, material_legend
from .colours import grey
from .legends import POINTS_PER_INCH, figure_of
from .style import figure_style, get_axes

if TYPE_CHECKING:
    from ..designs.result import DesignResult

# Largest number of rows of diameters below beads, and the distance of upright ones in several rows,
# relative to the size of the font.
MAX_ROWS, ROOM = 3, 1.3
# Width of a character, relative to the size of the font, and the longest line of a name.
CHARACTER, MAX_NAME = 0.6, 14
# Distance of lines of text, relative to the size of the font.
LINE: Final = 1.2
# Statement on a row whose overlaps exceed 0.1 of its radii.
NOT_PREDICTED: Final = "forces not predicted"
# Thickness of a pad in front of a wall, in radii of the largest bead.
PAD, PAD_COLOUR = 0.25, "#F2D7A6"
# Distance of both rows of beads, in radii of the largest one.
DISTANCE: Final = 2.4


def plot_beads(result: DesignResult, *, ax: Axes | None = None) -> Axes:
    """Plot the beads of the design, below those of the best chain without a search."""
    with figure_style():
        axes = get_axes(ax, figsize=(7.0, 2.2))
        found = shown_chains(result)
        factor, unit = (1e3, " [mm]") if result.chain.units == "SI" else (1.0, "")
        height = -DISTANCE * factor * max(half_heights(each.chain).max() for each in found.values())
        names = []
        for row, (name, each) in enumerate(found.items()):
            chain = each.chain
            draw_beads(chain, factor, axes, height=row * height)
            if chain.right_wall is not None:
                end = factor * length_of(chain)
                largest = factor * half_heights(chain).max()
                if chain.right_wall.exponent == 1.0:
                    # The thickness of a pad is not known.
                    axes.add_patch(Rectangle((end, row * height - largest), PAD * largest,
                                             2.0 * largest, facecolor=PAD_COLOUR,
                                             edgecolor="black", linewidth=0.6))  # fmt: skip
                    end += PAD * largest
                axes.plot([end] * 2, [row * height - largest, row * height + largest],
                          color=grey(axes), linewidth=3.0)  # fmt: skip
            words = f"{name} = {same}" if name == DESIGN and (same := same_as(result)) else name
            lines = [*textwrap.wrap(words, MAX_NAME), *violations(result, each)]
            names.append((row * height, lines + [NOT_PREDICTED] * each.not_a_prediction))
        axes.set_aspect("equal")
        axes.autoscale_view()
        axes.margins(x=0.01)
        _write_names(names, axes, factor * half_heights(chain).max())
        if result.chain.units == "SI":
            _write_diameters(
                result.chain, axes, row * height - half_heights(result.chain).max() * factor
            )
        axes.set_yticks([])
        axes.spines["left"].set_visible(False)  # it would look like a wall
        axes.set_xlabel(f"position{unit}")
        # Above the axes, which are low if the chain is long.
        material_legend([each.chain for each in found.values()], axes, fontsize=8,
                        loc="lower center", bbox_to_anchor=(0.5, 1.0), borderaxespad=0.2,
                        ncols=3)  # fmt: skip
    return axes


def height_of_beads(result: DesignResult, width: float) -> float:
    """Height [inch] of the rows of beads in axes of a width [inch]."""
    chains = [each.chain for each in shown_chains(result).values()]
    largest = max(float(half_heights(chain).max()) for chain in chains)
    length = max(length_of(chain) for chain in chains)
    return width * (DISTANCE * (len(chains) - 1) + 2.0) * largest / length


def violations(
    result: DesignResult, found: Verified, *, at_fully_plastic: bool = False
) -> list[str]:
    """Statement that a chain violates constraints, or one at 2.8 Y; empty if it does not."""
    if names := violated(result.problem, found.values):
        return [f"violates {names[0] if len(names) == 1 else f'{len(names)} constraints'}"]
    harder, broken = found.fully_plastic, violated_if_fully_plastic(result.problem, found)
    if harder is None or not broken or not at_fully_plastic:
        return []
    value = broken[0].shown(harder.values[str(broken[0].measure)])
    return [f"violates {broken[0].measure}", f"{AT_FULLY_PLASTIC}: {value}"]


def _write_names(names: list[tuple[float, list[str]]], axes: Axes, half: float) -> None:
    """Write lines beside rows of beads; half the height of the last row is given.

    A tall name of the last row ends with its beads, above the label of the diameters.
    """
    for i, (at, lines) in enumerate(names):
        small = 1.0 if len(lines) == 1 else 0.8
        tall = LINE * small * len(lines) * _size(axes) > 2.0 * half and i == len(names) - 1
        axes.text(-0.01, at - half * tall, " \n".join(lines) + " ", ha="right",
                  va="bottom" if tall else "center", fontsize=small * rcParams["font.size"],
                  transform=axes.get_yaxis_transform())  # fmt: skip


def _size(axes: Axes) -> float:
    """Size of the font in units of the axes; their layout may change, but hardly their width."""
    low, high = axes.get_xlim()
    points = POINTS_PER_INCH * figure_of(axes).get_figwidth() * axes.get_position().width
    size = FontProperties(size=rcParams["font.size"]).get_size_in_points()
    return float(size * (high - low) / points)


def _write_diameters(chain: Chain, axes: Axes, height: float) -> None:
    """Write the diameters [mm] below the beads, or their range if there is no room.

    They are upright if the beads are narrow, and in several rows if one has no room.
    """
    low, high = axes.get_xlim()
    # In points, and in units of the axes.
    size = 0.8 * float(FontProperties(size=rcParams["font.size"]).get_size_in_points())
    letter = 0.8 * _size(axes)
    texts = ["flat" if flat else f"{2e3 * radius:.4g}"
             for flat, radius in zip(flat_bodies(chain), chain.radii, strict=True)]  # fmt: skip
    centres = 1e3 * body_centres(chain)
    rows = _rows(centres / letter)
    label = "diameter [mm]"
    if rows == 0:
        texts, centres, rows = (
            [sizes_in_words(known_radii(chain))],
            np.array([0.5 * (low + high)]),
            1,
        )
        label = "diameters"
    lengths = CHARACTER * np.array([len(text) for text in texts])
    apart = np.diff(centres) / letter
    crowded = (apart < 0.5 * (lengths[1:] + lengths[:-1]) + 0.5 * CHARACTER).any()
    upright = rows > 1 or bool(crowded)
    tall = lengths.max() + CHARACTER if upright else 1.0
    for i, (text, centre) in enumerate(zip(texts, centres, strict=True)):
        below = height - (0.3 + i % rows * tall) * letter
        axes.text(centre, below, text, fontsize=size, ha="center", va="top",
                  rotation=90.0 * upright)  # fmt: skip
    axes.text(-0.01, height - 0.3 * letter, f"{label} ", fontsize=size, ha="right",
              va="top", transform=axes.get_yaxis_transform())  # fmt: skip
    axes.set_ylim(bottom=height - letter * (0.6 + rows * tall))


def _rows(centres: Array) -> int:
    """Number of rows of upright texts at places in units of their size; 0 if there are too many."""
    for rows in range(1, MAX_ROWS + 1):
        if (centres[rows:] - centres[:-rows]).min(initial=np.inf) >= (ROOM if rows > 1 else 1.0):
            return rows
    return 0

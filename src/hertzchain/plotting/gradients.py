"""Plot on which beads a quantity depends."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from ..designs.measures import parse_measure
from ..errors import InputError
from .style import COLOURS, figure_style, get_axes, set_title

if TYPE_CHECKING:
    from ..sensitivity.gradient import Gradient

NOUNS: Final = {"radii": "the radius", "masses": "the mass", "velocities": "the velocity",
                "young": "Young's modulus"}  # fmt: skip


def plot_gradient(found: Gradient, name: str = "radii", *, ax: Axes | None = None) -> Axes:
    """Plot by how many percent a quantity changes if a parameter of each bead grows by 1%."""
    relative = found.relative(name)
    if relative.ndim != 1:
        raise InputError(f"{name} has one value only, which is not plotted; use relative({name!r})")
    with figure_style():
        axes = get_axes(ax)
        axes.bar(np.arange(1, 1 + len(relative)), relative, color=COLOURS[1])
        axes.axhline(0.0, color="black", linewidth=0.8)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set_xlabel("contact $k$" if name in ("stiffness", "gaps") else "bead $k$")
        axes.set_ylabel("relative change [%]")
        set_title(axes, f"{_label(found.quantity)}: change per 1% of {NOUNS.get(name, name)}")
    return axes


def _label(quantity: str) -> str:
    """A quantity in words, or its name if only gradients have it, as ``final.position@3``."""
    try:
        return parse_measure(quantity).label
    except InputError:
        return quantity

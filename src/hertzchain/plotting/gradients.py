"""Plot on which beads a quantity depends."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.axes import Axes

from ..chain.bead_names import bead_label
from ..chain.chain import Chain
from ..collision import Array
from ..designs.measures import label_in, parse_measure
from ..designs.sensitivity import GAP_STEP
from ..errors import InputError
from .colours import COLOURS, grey
from .legends import place_legend
from .shared_axes import label_below
from .style import BeadLocator, figure_style, get_axes, set_title, with_micro
from .titles import chain_title

if TYPE_CHECKING:
    from ..derivatives.result import Gradient

NOUNS: Final = {"radii": "the radius", "masses": "the mass", "velocities": "the velocity",
                "young": "Young's modulus",
                "yield_strength": "the yield strength", "gaps": "the gap"}  # fmt: skip
# Sum of the changes for +1% and -1%, relative to their difference, below which one suffices.
MIRRORED: Final = 0.05


def plot_gradient(
    found: Gradient, name: str = "radii", *, changes: tuple[Array, ...] | None = None,
    ax: Axes | None = None,
) -> Axes:  # fmt: skip
    """Plot by how many percent a quantity changes if a parameter of each bead grows by 1%.

    ``changes`` are simulated relative changes for +1% and -1%, or for larger gaps, which replace
    the derivatives.
    """
    relative = found.relative(name)
    if relative.ndim != 1:
        raise InputError(f"{name} has one value only, which is not plotted; use relative({name!r})")
    with figure_style():
        axes, noun = get_axes(ax), noun_of(name, found._chain)
        joints = name in ("stiffness", "gaps")
        shaded = False if found._chain is None or joints else shade_other_bodies(axes, found._chain)
        if changes is None:
            axes.bar(np.arange(1, 1 + len(relative)), relative, color=COLOURS[1])
            axes.axhline(0.0, color=grey(axes), linewidth=0.8)
            axes.set_xlim(0.3, len(relative) + 0.7)
            axis = f"change [%] per 1% of {noun}"
        else:
            both = bars_of_changes(axes, *changes)
            step = "1%" if name != "gaps" else with_micro(GAP_STEP[_units(found)][1])
            axis = f"change [%] if {noun} {'changes' if both else 'grows'} by {step}"
        axes.xaxis.set_major_locator(BeadLocator())
        label_below(axes, "contact $k$" if joints else "bead $k$")
        axes.set_ylabel(f"{_label(found)}:\n{axis}")
        if found._chain is not None:
            set_title(axes, chain_title(found._chain))
        if shaded:
            place_legend(axes)
            legend = axes.get_legend()
            assert legend is not None
            # A shaded range may be below it.
            legend.set_frame_on(True)
            legend.get_frame().set(facecolor=axes.get_facecolor(), edgecolor="none", alpha=1.0)
    return axes


def shade_other_bodies(axes: Axes, chain: Chain) -> bool:
    """Shade strikers and a cap, with an entry in the legend; whether there are any."""
    spans = {}
    if count := chain.strikers:
        spans["striker" if count == 1 else f"{count} strikers"] = (0.5, count + 0.5)
    if chain.cap is not None:
        spans["cap"] = (chain.beads - 0.5, chain.beads + 0.5)
    for i, span in enumerate(spans.values()):
        axes.axvspan(*span, color=grey(axes, 0.9), linewidth=0.0,
                     label=None if i else " and ".join(spans))  # fmt: skip
    return bool(spans)


def bars_of_changes(axes: Axes, larger: Array, smaller: Array | None = None) -> bool:
    """Draw relative changes for +1% and -1% in percent; the first suffice if they are mirrored.

    Returns whether both are drawn.
    """
    larger, smaller = 100.0 * larger, 100.0 * (-larger if smaller is None else smaller)
    beads = np.arange(1, len(larger) + 1)
    axes.axhline(0.0, color=grey(axes), linewidth=0.8)
    axes.set_xlim(0.3, len(larger) + 0.7)
    # Changes of incomplete peaks are not known.
    sums, spans = (np.nanmax(np.abs(each), initial=0.0) for each in (larger + smaller,
                                                                     larger - smaller))  # fmt: skip
    if sums < MIRRORED * spans:
        axes.bar(beads, larger, 0.7, color=COLOURS[3])
        return False
    for shift, values, colour, label in (
        (-0.2, larger, COLOURS[3], "+1%"), (0.2, smaller, COLOURS[1], "\N{MINUS SIGN}1%"),
    ):  # fmt: skip
        axes.bar(beads + shift, values, 0.4, color=colour, label=label)
    place_legend(axes)
    return True


def noun_of(name: str, chain: Chain | None) -> str:
    """A parameter in words; sizes of chains in SI units are shown as diameters."""
    if name == "radii" and chain is not None and chain.units == "SI":
        return "the diameter"
    return NOUNS.get(name, name)


def _units(found: Gradient) -> str:
    return "SI" if found._chain is None else found._chain.units


def _label(found: Gradient) -> str:
    """A quantity in words, or its name if only gradients have it, as ``final.position@3``."""
    try:
        measure = parse_measure(found.quantity)
    except InputError:
        return found.quantity
    if measure.bead and found._chain is not None:
        measure = replace(measure, name=bead_label(found._chain, measure.bead))
    return measure.label if found._chain is None else label_in(found._chain, measure)

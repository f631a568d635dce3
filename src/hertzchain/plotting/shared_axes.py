"""Labels of axes that several quantities or several panels share."""

from __future__ import annotations

from typing import Any, Final

from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, ScalarFormatter

from ..chain.chain import Chain
from ..pulse.quantities import COLUMN_QUANTITIES
from ..representation import usual_unit
from .curve_notes import CurveNotes
from .log_labels import PLAIN
from .style import label_log_axis, signed, with_micro

# Units that have prefixes, and the largest value for which zeros would widen a small panel.
PREFIXED: Final = ("J", "s", "N", "m", "m/s", "N s", "V")
SMALL: Final = 5e-3
# Volts below 1 V are shown in mV, as on most digitisers.
SMALL_OF: Final = {"V": 1.0}

# Quantity, chain and label of the curves of pulses; no label if a user has given it.
_curves: Final = CurveNotes[tuple[str, Chain, str | None]]()


def note_curve(line: Line2D, quantity: str, chain: Chain, label: str | None) -> None:
    """Remember the quantity of a curve, for curves of others in the same axes."""
    _curves.add(line, (quantity, chain, label))


def colour_of_chain(axes: Axes, chain: Chain) -> Any:
    """Colour of the first curve of a chain."""
    return next(line.get_color() for line, (_, own, _) in _curves.of(axes).items() if own is chain)


def label_quantities(axes: Axes) -> None:
    """Label axes with the quantity of their curves; with several, the curves name theirs, too."""
    curves = _curves.of(axes)
    rows = {quantity: COLUMN_QUANTITIES[quantity] for quantity, *_ in curves.values()}
    damped = any(chain._damped for _, chain, _ in curves.values())
    labels = {
        (quantity, chain.units): rows[quantity].label_in(chain.units, damped=damped)
        for quantity, chain, _ in curves.values()
    }
    places = dict.fromkeys(row.per for row in rows.values())
    label_below(axes, f"{' or '.join(places)} $k$")
    if len(labels) == 1:
        axes.set_ylabel(next(iter(labels.values())))
        return
    # The legend has their names.
    axes.set_ylabel(", ".join(each[max(each.find("$"), 0) :] for each in labels.values()))
    several = len({label for *_, label in curves.values()}) > 1
    for line, (quantity, chain, label) in curves.items():
        if label is not None:
            words = f"{label}, " if several else ""
            line.set_label(f"{words}{labels[quantity, chain.units].partition(' [')[0]}")


def use_prefix(axes: Axes, largest: float | None = None) -> None:
    """Show small values of an axis with a prefix of their unit, such as 0.2 mJ.

    The prefix suits the largest value, by default that of the limits.
    """
    log, label = axes.get_yscale() == "log", axes.get_ylabel()
    largest = max(map(abs, axes.get_ylim())) if largest is None else largest
    without_prefix(axes)
    name, _, unit = label.rpartition(" [")
    own = unit.rstrip("]")
    if not name or own not in PREFIXED or not 0.0 < largest < SMALL_OF.get(own, SMALL):
        if log:
            label_log_axis(axes.yaxis)
        else:
            use_power_of_ten(axes.yaxis)
        return
    factor, shown = prefixed(largest, own)
    if log:
        label_log_axis(axes.yaxis, factor)
    else:
        axes.yaxis.set_major_formatter(
            FuncFormatter(lambda value, _: signed(factor * value, "z.6g"))
        )
    axes.set_ylabel(f"{name} [{shown}]")


def prefixed(largest: float, unit: str) -> tuple[float, str]:
    """Factor and unit with the prefix that suits the largest value, such as 1e3 and mJ."""
    # Units other than those of times and lengths have all prefixes, as that of momentum.
    factor, shown = usual_unit(largest, unit if unit in ("s", "m") else "N s")
    return factor, with_micro(shown.replace("N s", unit))


def use_power_of_ten(axis: Axis) -> None:
    """Write the factor of an axis with large or small numbers as a power of ten, not as 1e7."""
    largest = max(map(abs, axis.get_view_interval()))
    formatter = axis.get_major_formatter()
    if isinstance(formatter, ScalarFormatter) and not PLAIN[0] <= largest < PLAIN[1]:
        formatter.set_useMathText(True)


def without_prefix(axes: Axes) -> None:
    """Show values without the factor of a prefix, before the label gets another unit."""
    if isinstance(axes.yaxis.get_major_formatter(), FuncFormatter):
        axes.yaxis.set_major_formatter(ScalarFormatter())


def same_prefix(axes: Axes, other: Axes) -> None:
    """Show values with the prefix of other axes, whose label states the unit."""
    formatter = other.yaxis.get_major_formatter()
    if isinstance(formatter, FuncFormatter):
        axes.yaxis.set_major_formatter(FuncFormatter(formatter.func))


def label_below(axes: Axes, label: str) -> None:
    """Label the x axis, unless a panel below shares it and has its numbers."""
    axes.set_xlabel("" if numbers_are_below(axes) else label)


def numbers_are_below(axes: Axes) -> bool:
    """Whether axes share their x axis, and only another panel has its numbers."""
    shared = len(axes.get_shared_x_axes().get_siblings(axes)) > 1
    return shared and not axes.xaxis.get_tick_params().get("labelbottom", True)

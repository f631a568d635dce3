"""Bands of the spread of pulses, and limits that make them visible."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, Literal, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.text import Annotation

from ..collision import Array
from ..pulse.pulse import Pulse
from ..pulse.quantities import COLUMN_QUANTITIES
from .style import show_three_ticks, signed

# Opacity of the band of a spread.
BAND: Final = 0.25
# Part of the range of all values that those of the inner beads must be below for other limits.
MUCH_SMALLER: Final = 0.5
# Margin of the limits, relative to their difference, with room for values beyond them.
MARGIN: Final = 0.1
# Distance [points] of a text from the first bead.
DISTANCE: Final = 4.0
# Sides at which texts in the thirds of the axes are aligned.
Side: TypeAlias = Literal["left", "center", "right"]
SIDES: Final[tuple[Side, ...]] = ("left", "center", "right")
# Mark of texts that state values beyond the limits.
BEYOND: Final = "hertzchain-beyond"


def spread_of(pulse: Pulse, quantity: str) -> Array | None:
    """Standard deviation of the logarithm of a quantity over random chains, if known."""
    name = f"{quantity}_spread"
    return pulse.column(name) if name in COLUMN_QUANTITIES else None


def draw_spread(axes: Axes, pulse: Pulse, quantity: str, colour: str, *, free: bool) -> None:
    """A band of one standard deviation, and a bar of this height at a free end."""
    band = _band(pulse, quantity)
    if band is None:
        return
    _draw_band(axes, *band, colour, free=free)


def draw_spread_of_difference(
    axes: Axes, pulse: Pulse, quantity: str, difference: Array, colour: str, *, free: bool
) -> None:
    """The same around relative differences of a pulse from another one, in percent."""
    spread = spread_of(pulse, quantity)
    if spread is None:
        return
    ratio, factor = 1.0 + 0.01 * difference, np.exp(spread[: len(difference)])
    low, high = 100.0 * (ratio / factor - 1.0), 100.0 * (ratio * factor - 1.0)
    _draw_band(axes, low, high, colour, free=free)


def draw_own_spread(axes: Axes, pulse: Pulse, quantity: str, colour: str, *, free: bool) -> None:
    """The band around the values of the pulse itself, in percent, in a panel of its own."""
    values = pulse._predicted(quantity)
    axes.axhline(0.0, color=colour, linewidth=0.7)
    difference = np.zeros(len(values))
    draw_spread_of_difference(axes, pulse, quantity, difference, colour, free=free)
    axes.set_ylabel("spread [%]")
    show_three_ticks(axes)


def _draw_band(axes: Axes, low: Array, high: Array, colour: str, *, free: bool) -> None:
    bead, end = np.arange(1, len(low) + 1), len(low) - free
    axes.fill_between(bead[:end], low[:end], high[:end], color=colour, alpha=BAND, linewidth=0.0)
    if free:
        axes.vlines(bead[-1], low[-1], high[-1], color=colour, alpha=BAND, linewidth=3.0)


def show_band(axes: Axes, pulses: Sequence[Pulse], quantity: str, *, keep: bool) -> None:
    """Limits from the inner beads if those of beads 1 and N make the band of a spread thin.

    Limits that are fixed or to ``keep`` remain; beads beyond fixed ones are named, too.
    """
    if not axes.get_autoscaley_on():
        _name_beyond(axes, pulses, quantity)
        return
    if keep:
        return
    bands = [_band(pulse, quantity) for pulse in pulses]
    if not any(band is not None for band in bands):
        return
    values = [pulse._predicted(quantity) for pulse in pulses]
    lows, highs = zip(
        *(each if band is None else band for each, band in
          zip([(each, each) for each in values], bands, strict=True)),
        strict=True,
    )  # fmt: skip
    low, high = _range(lows, highs, inner=True)
    least, most = _range(lows, highs, inner=False)
    if not 0.0 < high - low < MUCH_SMALLER * (most - least):
        return
    margin = MARGIN * (high - low)
    # Curves that are drawn later may change these limits.
    axes.set_ylim(low - margin, high + margin, auto=True)
    _name_beyond(axes, pulses, quantity)


def remove_values_beyond(axes: Axes) -> None:
    """Remove the texts about values beyond the limits, whose limits further curves change."""
    for text in [each for each in axes.texts if each.get_gid() == BEYOND]:
        if axes.get_autoscaley_on():
            text.remove()


def _band(pulse: Pulse, quantity: str) -> tuple[Array, Array] | None:
    spread = spread_of(pulse, quantity)
    if spread is None:
        return None
    values = pulse._predicted(quantity)
    return values * np.exp(-spread), values * np.exp(spread)


def _range(lows: Sequence[Array], highs: Sequence[Array], *, inner: bool) -> tuple[float, float]:
    """Least and largest value, of all beads or without the first and the last."""
    part = slice(1, -1) if inner else slice(None)
    below, above = (np.concatenate([each[part] for each in side]) for side in (lows, highs))
    if not (below.size and np.isfinite(below).any()):
        return 0.0, 0.0
    return float(np.nanmin(below)), float(np.nanmax(above))


def _name_beyond(axes: Axes, pulses: Sequence[Pulse], quantity: str) -> None:
    """Name the beads beyond the limits, also after later curves or users change these."""
    shown = _beyond(axes, pulses, quantity)

    def renew(_: Axes) -> None:
        for text in shown:
            if text in axes.texts:
                text.remove()
        shown[:] = _beyond(axes, pulses, quantity)

    axes.callbacks.connect("ylim_changed", renew)


def _beyond(axes: Axes, pulses: Sequence[Pulse], quantity: str) -> list[Annotation]:
    """Write the beads and values beyond the limits at the edges of the axes, with arrows."""
    written: list[Annotation] = []
    first, last = axes.get_xlim()
    low, high = sorted(axes.get_ylim())
    for limit, sign in ((high, 1.0), (low, -1.0)):
        texts: dict[Side, dict[str, int]] = {}
        for pulse in pulses:
            values = pulse._predicted(quantity)
            beyond = np.flatnonzero(sign * values > sign * limit)
            for part in np.split(beyond, np.flatnonzero(np.diff(beyond) > 1) + 1):
                if part.size:
                    furthest = part[np.argmax(sign * values[part])]
                    bead = int(pulse.bead[furthest])
                    where = int(3.0 * (bead - first) / (last - first))
                    words = _beyond_in_words(quantity, pulse.bead[part], values[furthest], sign)
                    texts.setdefault(SIDES[min(max(where, 0), 2)], {})[words] = bead
        for side, found in texts.items():
            text = axes.annotate(
                "\n".join(found),
                (next(iter(found.values())), sign > 0.0),
                (DISTANCE if side == "left" else 0.0, 0.0),
                xycoords=axes.get_xaxis_transform(),
                textcoords="offset points",
                ha=side,
                va="top" if sign > 0.0 else "bottom",
                fontsize="small",
                gid=BEYOND,
            )
            written.append(text)
    return written


def _beyond_in_words(quantity: str, beads: Array, value: float, sign: float) -> str:
    """Such as ``bead 1: 1.2 ↑``, or ``beads 3 to 9: up to 1.5 ↑``."""
    place, shown = COLUMN_QUANTITIES[quantity].per, signed(value, ".3g")
    arrow, most = ("↑", "up to") if sign > 0.0 else ("↓", "down to")
    if len(beads) == 1:
        return f"{place} {beads[0]:g}: {shown} {arrow}"
    return f"{place}s {beads[0]:g} to {beads[-1]:g}: {most} {shown} {arrow}"

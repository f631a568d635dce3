"""Figures of forces that are almost constant: the change from the static force."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import AutoLocator, FuncFormatter, MaxNLocator

from ..chain.chain import Chain
from ..collision import Array
from .force_lines import force_lines
from .shared_axes import SMALL, prefixed, without_prefix
from .style import signed

# Largest change, relative to the static force, of which the axis shows only the change.
SMALL_CHANGE: Final = 0.01
# Part of the change up to which static forces are the same.
SAME: Final = 0.01
MINUS: Final = "\N{MINUS SIGN}"


class _LocatorFrom(MaxNLocator):
    """Ticks at round differences from a value."""

    def __init__(self, value: float) -> None:
        super().__init__("auto", steps=[1, 2, 2.5, 5, 10])
        self._value = value

    def tick_values(self, vmin: float, vmax: float) -> Any:
        """Ticks between two numbers."""
        ticks = super().tick_values(vmin - self._value, vmax - self._value)
        return self._value + np.asarray(ticks)


def static_forces(chain: Chain) -> Array:
    """Static forces of contacts 0 to N; 0 at ends that are held by a force without a wall."""
    forces = np.array(chain.static_state.forces)
    if chain.left_wall is None:
        forces[0] = 0.0
    if chain.right_wall is None:
        forces[-1] = 0.0
    return forces


def static_force(chain: Chain, number: int) -> float:
    """Static force in a sensor in a bead, or on a wall: number 0 or N + 1."""
    forces = static_forces(chain)
    return float(forces[max(number - 1, 0) : number + 1].mean())


def force_label(chain: Chain) -> str:
    """Label of an axis of forces."""
    return "force [N]" if chain.units == "SI" else "force $F$"


def show_changes(axes: Axes, chain: Chain) -> None:
    """Show the change from the static force if this is much larger in all forces in the axes."""
    without_prefix(axes)
    if isinstance(axes.yaxis.get_major_locator(), _LocatorFrom):
        axes.yaxis.set_major_locator(AutoLocator())
    axes.set_ylabel(force_label(chain))
    lines = force_lines(axes)
    forces = [np.asarray(line.get_ydata(), dtype=float) for line in lines]
    if (found := small_change(forces, [line.static for line in lines])) is None:
        return
    static, change = found
    factor, label = change_label(static, change, chain)
    axes.yaxis.set_major_locator(_LocatorFrom(static))
    axes.yaxis.set_major_formatter(
        FuncFormatter(lambda value, _: signed(factor * (value - static), "z.6g"))
    )
    axes.set_ylabel(label)


def small_change(forces: Sequence[Array], resting: Sequence[float]) -> tuple[float, float] | None:
    """A static force and the largest change, if all forces differ little from one static force."""
    static = resting[0]
    if not min(resting) > 0.0:
        return None
    changes = zip(forces, resting, strict=True)
    change = max(float(np.abs(force - own).max()) for force, own in changes)
    same = max(abs(own - static) for own in resting) <= SAME * change
    return (static, change) if same and 0.0 < change < SMALL_CHANGE * static else None


def change_label(static: float, change: float, chain: Chain) -> tuple[float, str]:
    """Factor and label of a change of force."""
    text = f"force {MINUS} static force of {static:.4g}"
    if chain.units == "SI":
        factor, unit = prefixed(change, "N") if change < SMALL else (1.0, "N")
        return factor, f"{text} N [{unit}]"
    if change >= SMALL:
        return 1.0, text
    power = math.floor(math.log10(change))
    return 10.0**-power, f"({text}) / $10^{{{power}}}$"

"""HTML representation of a gradient: relative derivatives by beads, and the largest ones."""

from __future__ import annotations

import numpy as np

from ..collision import Array
from ..derivatives.result import Gradient
from ..representation import measure
from .drawing import COLOURS, Curve, chart, legend, note, numbers, page, sentence, table


def gradient_html(found: Gradient) -> str:
    """Change of the quantity in % if a parameter of a bead or contact grows by 1%."""
    known = np.isfinite(found.value) and found.value != 0.0
    curves: list[Curve] = []
    for name, values in found.gradient.items():
        relative = found.relative(name) if known and values.ndim == 1 else np.zeros(1)
        if len(relative) > 1 and relative.any():
            place, colour = np.arange(1.0, len(relative) + 1.0), COLOURS[len(curves) % len(COLOURS)]
            curves.append(Curve(place, relative, name, colour))
    parts = []
    if curves:
        parts.append(legend((curve.label, curve.colour) for curve in curves))
        parts.append(chart(curves, "bead or contact k", "change per 1% [%]", whole=True))
    units = "scaled" if found.unit in ("", "1") else "SI"
    value = measure(found.value, found.unit, units) if np.isfinite(found.value) else "none"
    shown = {"value": value}
    if np.isfinite(found.error):
        shown["relative error"] = f"{found.error:.1g}"
    parts.append(numbers(shown))
    rows = [
        [
            *_row(values, found.units[name], name),
            *_row(found.relative(name) if known else None, "%"),
        ]
        for name, values in found.gradient.items()
    ]
    parts.append(table(("parameter", "largest derivative", "at", "largest % per 1%", "at"), rows))
    parts += [note(sentence(each)) for each in found._remarks if each != "complete"]
    return page("Gradient", found.quantity, *parts)


def _row(values: Array | None, unit: str, *name: str) -> list[str]:
    """The largest value, and its bead or contact."""
    if values is None or not np.isfinite(values).any():
        return [*name, "none", ""]
    flat = np.atleast_1d(values).ravel()
    k = int(np.nanargmax(np.abs(flat)))
    space = "" if unit in ("", "%") else " "
    return [*name, f"{flat[k]:.4g}{space}{unit}", f"{k + 1}" if values.ndim == 1 else ""]

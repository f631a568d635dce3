"""HTML representations of pulses and comparisons: curves and key numbers."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..pulse.comparison import BEFORE_END, DRAWN, Comparison
from ..pulse.free_end import ends_free
from ..pulse.pulse import Pulse
from ..representation import percent
from .drawing import (
    COLOURS,
    Curve,
    Mark,
    axis_unit,
    chart,
    engineering,
    legend,
    note,
    numbers,
    page,
    sentence,
    table,
)

# Ratio of the largest and smallest velocity from which the axis is logarithmic.
LOG_RANGE: Final = 30.0
# Sentence below the figure of spreads, and the height [px] of this figure.
SPREAD: Final = "Spread: one standard deviation over random chains."
SPREAD_HEIGHT: Final = 120
# Errors below this fraction of the largest are not drawn.
MIN_SHOWN: Final = 1e-4


def pulse_html(pulse: Pulse) -> str:
    """Velocity along the chain, and the numbers of the last bead."""
    units, beads = pulse.chain.units, pulse.chain.beads
    factor, unit = axis_unit(pulse.velocity, "m/s", units)
    known = pulse.velocity[np.isfinite(pulse.velocity) & (pulse.velocity > 0.0)]
    log = bool(len(known)) and float(known.max()) > LOG_RANGE * float(known.min())
    # The last bead at a free end is not part of the curve.
    end = len(pulse.velocity) - ends_free(pulse, "velocity")
    marks = [Mark(float(beads), factor * pulse.velocity[-1], "")] if end < beads else []
    curves = [Curve(pulse.bead[:end].astype(float), factor * pulse.velocity[:end], "mean")]
    figure = chart(curves, "bead k", f"velocity{unit}", log=log, whole=True, marks=marks)
    last = "last bead (free end)" if marks else "last bead"
    found = {last: f"{beads}", "velocity": engineering(pulse.velocity[-1], "m/s", units)}
    if pulse.velocity_spread is not None:
        figure += _spreads(pulse, free=bool(marks))
        found["velocity"] += f" +- {percent(pulse.velocity_spread[-1])}"
    found["momentum"] = engineering(pulse.momentum[-1], "N s", units)
    found["energy"] = engineering(pulse.energy[-1], "J", units)
    if pulse.arrival is not None:
        found["arrival"] = engineering(pulse.arrival[-1], "s", units)
    if pulse.peak_force is not None and np.isfinite(pulse.peak_force).any():
        k = int(np.nanargmax(pulse.peak_force))
        force = engineering(pulse.peak_force[k], "N", units)
        found["largest force"] = f"{force} (contact {k + 1})"
    notes = [note(sentence(text.rstrip("."))) for text in pulse._all_notes()]
    return page("Pulse", f"by {pulse.method}: {pulse.chain.description}", figure, numbers(found),
                *notes)  # fmt: skip


def _spreads(pulse: Pulse, *, free: bool) -> str:
    """Relative standard deviations along the chain: bands around the curves would be thin."""
    curves: list[Curve] = []
    marks: list[Mark] = []
    for name in ("velocity", "arrival", "peak_force"):
        spread = pulse.column(f"{name}_spread")
        if spread is None:
            continue
        shown, place = 100.0 * spread, np.arange(1.0, len(spread) + 1.0)
        end = len(spread) - (free and ends_free(pulse, name))
        colour = COLOURS[len(curves)]
        curves.append(Curve(place[:end], shown[:end], name.replace("_", " "), colour))
        marks += [Mark(place[-1], float(each), "", colour) for each in shown[end:]]
    return legend((each.label, each.colour) for each in curves) + chart(
        curves, "bead or contact k", "spread [%]", marks=marks, whole=True, height=SPREAD_HEIGHT
    ) + note(SPREAD)  # fmt: skip


def comparison_html(comparison: Comparison) -> str:
    """Relative errors along the chain, and their largest and typical values."""
    rows: list[tuple[str, ...]] = []
    curves: list[Curve] = []
    marks: list[Mark] = []
    for name in comparison.quantities:
        errors = np.abs(comparison.errors(name)[1:])
        if np.isnan(errors).all():
            continue
        rows.append((
            name, f"{100.0 * comparison.worst(name):.3g}%", f"{comparison.worst_bead(name)}",
            f"{100.0 * comparison.rms(name):.3g}%",
        ))  # fmt: skip
        if name in DRAWN and (errors > 0.0).any():
            colour = COLOURS[len(curves)]
            places = np.arange(2.0, len(errors) + 2.0)
            seen = np.where(errors >= MIN_SHOWN * np.nanmax(errors), 100.0 * errors, np.nan)
            # No line joins the last bead of a free end, which moves unlike the others.
            pair = (comparison.pulse, comparison.reference)
            end = len(seen) - any(ends_free(each, name) for each in pair)
            curves.append(Curve(places[:end], seen[:end], name, colour))
            last = zip(places[end:], seen[end:], strict=True)
            marks += [Mark(float(k), float(error), "", colour) for k, error in last
                      if np.isfinite(error)]  # fmt: skip
    parts = []
    if curves:
        parts.append(legend((curve.label.replace("_", " "), curve.colour) for curve in curves))
        parts.append(
            chart(curves, "bead or contact k", "|error| [%]", marks=marks, log=True, whole=True)
        )
    parts.append(table(("quantity", "largest error", "at k", "rms error"), rows, numeric=True))
    ours, theirs = comparison.pulse, comparison.reference
    about = f"of {ours.method} with {theirs.method}: {ours.chain.description}"
    relative = f"Errors of {ours.method} relative to {theirs.method}, of beads and contacts k >= 2."
    if before := comparison._errors_before_end:
        relative += f" {BEFORE_END.capitalize()}: {before}."
    return page("Comparison", about, *parts, note(relative))

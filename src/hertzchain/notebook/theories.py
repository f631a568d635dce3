"""HTML representations of the solitary wave, of calibrations and of effective chains."""

from __future__ import annotations

import numpy as np

from ..calibration import Calibration, error_text
from ..evaluation.scoreboard import Scoreboard
from ..evaluation.scoreboard_rows import CAPTION, scoreboard_rows, scoreboard_title
from ..theory.effective_chain import EffectiveChain
from ..theory.solitary_wave import SolitaryWave
from .drawing import (
    COLOURS,
    Curve,
    axis_unit,
    chart,
    engineering,
    legend,
    note,
    numbers,
    page,
    table,
)

# Distance from the crest in figures [beads].
DISTANCE = 4.0


def solitary_wave_html(wave: SolitaryWave) -> str:
    """Profiles of velocity and force around the crest, and the constants."""
    at = np.linspace(-DISTANCE, DISTANCE, 161)
    curves = [
        Curve(at, profile(at), name, colour)
        for name, profile, colour in (
            ("velocity of a bead", wave.velocity, COLOURS[0]),
            ("force of a contact", wave.force, COLOURS[1]),
        )
    ]
    shown = {
        "exponent p": f"{wave.exponent:g}",
        "speed C": f"{wave.speed_constant:.10f}",
        "momentum P1": f"{wave.momentum_constant:.10f}",
        "energy E1": f"{wave.energy_constant:.10f}",
        "force F1": f"{wave.force_constant:.10f}",
        "kinetic part": f"{wave.kinetic_fraction:.4f}",
    }
    return page(
        "SolitaryWave", f"in equal beads, p = {wave.exponent:g}",
        legend((curve.label, curve.colour) for curve in curves),
        chart(curves, "distance from the crest [beads]", "value / crest value"), numbers(shown),
    )  # fmt: skip


def scoreboard_html(board: Scoreboard) -> str:
    """Largest errors of the velocity from bead 10 on, by family of chains."""
    about = scoreboard_title(board, "velocity", 10, "worst")
    rows = [(label, *map(str.strip, cells)) for label, cells in scoreboard_rows(board)]
    return page("Scoreboard", about, table(("", *board.theories), rows, numeric=True),
                note(CAPTION))  # fmt: skip


def calibration_html(found: Calibration) -> str:
    """Errors of the corrected velocity, and the constants with those of the paper."""
    first, last = found.window
    bead, size = np.arange(float(first), last + 1.0), 100.0 * np.abs(found.residuals)
    curves = [
        Curve(bead, size.max(axis=0), "largest of all rates", COLOURS[0]),
        Curve(bead, np.median(size, axis=0), "median", COLOURS[1]),
    ]
    rows = [
        (name, f"{value:.5g}", error_text(found.standard_errors[name]), f"{found.printed[name]:g}")
        for name, value in found.constants.items()
    ]
    shown = {
        "largest error": f"{found.worst_error:.2%}",
        "rms error": f"{found.rms_error:.2%}",
        "rates": f"{len(found.rates)}",
        "beads": f"{first} to {last} of {found.beads}",
    }
    return page(
        "Calibration", f"modified BCA, {found.taper}",
        legend((curve.label, curve.colour) for curve in curves),
        chart(curves, "bead k", "error of the velocity [%]", whole=True), numbers(shown),
        table(("constant", "value", "standard error", "in the paper"), rows, numeric=True),
        note("The printed constants include misprints, which hertzchain reproduce lists."),
    )  # fmt: skip


def effective_chain_html(found: EffectiveChain) -> str:
    """Masses of the large beads, and the ranges of masses and stiffness."""
    units, places = found.units, found.large_beads.astype(float)
    factor, unit = axis_unit(found.masses, "kg", units)
    figure = chart([Curve(places, factor * found.masses)], "bead k", f"effective mass{unit}",
                   whole=True)  # fmt: skip
    own = " N/m^p" if units == "SI" else ""
    stiffness = _range([f"{each:.4g}{own}" for each in np.sort(found.stiffness)[[0, -1]]])
    masses = [engineering(each, "kg", units) for each in np.sort(found.masses)[[0, -1]]]
    shown = {
        "large beads": f"{len(found.masses)} of {found.large_beads[-1]}",
        "effective masses": _range(masses),
        "effective stiffness": stiffness,
        "exponent p": f"{found.exponent:g}",
        "velocity of bead 1": engineering(found.velocity, "m/s", units),
    }
    return page("EffectiveChain", "large beads of a decorated chain", figure, numbers(shown))


def _range(ends: list[str]) -> str:
    return " to ".join(dict.fromkeys(ends))

"""HTML representations of the solitary wave and of calibrations."""

from __future__ import annotations

import numpy as np

from ..calibration import Calibration
from ..theory.solitary_wave import SolitaryWave
from .drawing import COLOURS, Curve, chart, legend, note, numbers, page, table

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
        chart(curves, "distance from the crest [beads]", "part of the crest"), numbers(shown),
    )  # fmt: skip


def calibration_html(found: Calibration) -> str:
    """Errors of the corrected velocity, and the constants with those of the paper."""
    first, last = found.window
    bead, size = np.arange(float(first), last + 1.0), 100.0 * np.abs(found.residuals)
    curves = [
        Curve(bead, size.max(axis=0), "largest of all rates", COLOURS[0]),
        Curve(bead, np.median(size, axis=0), "median", COLOURS[1]),
    ]
    rows = [
        (name, f"{value:.5g}", f"{found.standard_errors[name]:.2g}", f"{found.printed[name]:g}")
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

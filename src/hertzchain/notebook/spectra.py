"""HTML representation of a spectrum: frequencies of the modes and edges of the bands."""

from __future__ import annotations

from contextlib import suppress
from typing import Final

import numpy as np

from ..errors import InputError
from ..theory.spectrum import Spectrum
from .drawing import Curve, axis_unit, chart, engineering, note, numbers, page

# Bands beyond which their edges are not listed.
MAX_BANDS: Final = 6


def spectrum_html(spectrum: Spectrum) -> str:
    """Frequency of each mode, and the numbers of the bands and of the decay."""
    units, found = spectrum.chain.units, spectrum.frequencies
    factor, hertz = axis_unit(found, "Hz", units)
    count = np.arange(1.0, len(found) + 1.0)
    figure = chart([Curve(count, factor * found)], "mode", f"frequency{hertz}", whole=True)
    values = {
        "modes": f"{len(found)}",
        "lowest": engineering(found[0], "Hz", units),
        "highest": engineering(found[-1], "Hz", units),
    }
    ringing = spectrum.decay_rates[spectrum.decay_rates > 0.0]
    if len(ringing):
        values["slowest decay in"] = engineering(1.0 / ringing.min(), "s", units)
    with suppress(InputError):
        values["sound speed"] = engineering(spectrum.sound_speed, "m/s", units)
    parts = [figure, numbers(values)]
    with suppress(InputError):
        edges = spectrum.band_edges()
        bands = ", ".join(
            " to ".join(engineering(edge, "Hz", units) for edge in band) for band in edges
        )
        if len(edges) <= MAX_BANDS:
            parts.append(note(f"Bands of an infinite chain with the same cell: {bands}."))
    return page("Spectrum", spectrum.chain.description, *parts)

"""HTML representation of a spectrum: frequencies of the modes and edges of the bands."""

from __future__ import annotations

from contextlib import suppress
from typing import Final

import numpy as np

from ..collision import Array
from ..errors import InputError
from ..theory.spectrum import Spectrum
from .drawing import Curve, axis_unit, chart, engineering, note, numbers, page

# Overlap of a line with a gap, relative to the highest frequency, that is rounding.
NARROW: Final = 1e-6
# Bands beyond which their edges are not listed.
MAX_BANDS: Final = 6


def spectrum_html(spectrum: Spectrum) -> str:
    """Frequency of each mode, and the numbers of the bands and of the decay."""
    units, found = spectrum.chain.units, spectrum.frequencies
    factor, hertz = axis_unit(found, "Hz", units)
    count, shown = _split(found, *_gaps(spectrum))
    figure = chart([Curve(count, factor * shown)], "mode", f"frequency{hertz}", whole=True)
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
    if len(spectrum.localised):
        values["localised modes"] = f"{len(spectrum.localised)}"
    parts = [figure, numbers(values)]
    if len(spectrum.localised):
        parts.append(note("plot_modes() shows the shapes of the localised modes."))
    with suppress(InputError):
        edges = spectrum.band_edges()
        bands = ", ".join(
            " to ".join(engineering(edge, "Hz", units) for edge in band) for band in edges
        )
        if len(edges) <= MAX_BANDS:
            parts.append(note(f"Bands of an infinite chain with the same cell: {bands}."))
        gaps = spectrum.gaps()[:-1]
        if 0 < len(gaps) <= MAX_BANDS:
            between = ", ".join(
                " to ".join(engineering(edge, "Hz", units) for edge in gap) for gap in gaps
            )
            parts.append(note(f"Gaps without waves: {between}; and above the highest band."))
    return page("Spectrum", spectrum.chain.description, *parts)


def _gaps(spectrum: Spectrum) -> tuple[Array, Array]:
    """Lower and upper ends of the gaps between bands."""
    try:
        low, high = spectrum.gaps()[:-1].T
    except InputError:
        return np.zeros(0), np.zeros(0)
    return low, high


def _split(found: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """Numbers of modes and frequencies, with NaN where a line would cross a gap."""
    count = np.arange(1.0, len(found) + 1.0)
    crossed = np.zeros(len(found) - 1, bool)
    for begin, end in zip(low, high, strict=True):
        inside = np.minimum(found[1:], end) - np.maximum(found[:-1], begin)
        crossed |= inside > NARROW * found[-1]
    places = np.flatnonzero(crossed) + 1
    return np.insert(count, places, count[places] - 0.5), np.insert(found, places, np.nan)

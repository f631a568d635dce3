"""Plot displacements of the beads in modes of a spectrum."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from matplotlib.axes import Axes

from ..collision import Array
from ..errors import InputError
from ..theory.spectrum import Spectrum
from ..validation.numbers import whole_number
from ..validation.objects import check_list
from .colours import curve_colour, free_numbers, grey, number_of_curves
from .legends import place_legend
from .shared_axes import label_below
from .shared_spectra import label_spectra, note_spectrum
from .style import MARKERS, BeadLocator, figure_style, get_axes

# Modes that are shown by default: without localised ones, and at most.
USUAL, MOST = 3, 5
# Beads up to which each has a symbol, and number of symbols in longer chains.
EVERY_BEAD: Final = 100


def plot_modes(
    spectrum: Spectrum, modes: int | Sequence[int] | None = None, *, ax: Axes | None = None
) -> Axes:
    """Plot the shapes of modes, as described in `Spectrum.plot_modes`."""
    chosen = _chosen(spectrum, modes)
    beads = np.arange(1, spectrum.chain.beads + 1)
    with figure_style():
        axes = get_axes(ax)
        present = number_of_curves(axes)
        if not present:
            axes.axhline(0.0, color=grey(axes, 0.6), linewidth=0.7)
        for i, mode in zip(free_numbers(axes, present, len(chosen)), chosen, strict=True):
            (line,) = axes.plot(
                beads, _shape(spectrum, mode), color=curve_colour(axes, i), linewidth=0.9,
                marker=MARKERS[i % len(MARKERS)], markersize=3.5,
                markerfacecolor="none", markevery=-(-len(beads) // EVERY_BEAD),
            )  # fmt: skip
            note_spectrum(line, spectrum.chain, _name(spectrum, mode))
        label_below(axes, "bead $k$")
        axes.xaxis.set_major_locator(BeadLocator())
        axes.set_ylabel(r"displacement $x_k\,/\,\max|x|$")
        label_spectra(axes, *_bands(spectrum), every_word=True)
        place_legend(axes, own=ax is None)
    return axes


def _chosen(spectrum: Spectrum, modes: int | Sequence[int] | None) -> list[int]:
    """Indices of the modes with these numbers, by default of localised ones or the first."""
    count = len(spectrum.frequencies)
    if modes is None:
        local = (spectrum.localised[:MOST] - 1).tolist()
        return local or list(range(min(USUAL, count)))
    given = [modes] if isinstance(modes, int) else check_list("modes", modes, "numbers of modes")
    if not given:
        raise InputError("modes must contain at least one number, such as [1, 2]")
    numbers = [whole_number("a mode", each, least=1, most=count) for each in given]
    return [number - 1 for number in dict.fromkeys(numbers)]


def _shape(spectrum: Spectrum, mode: int) -> Array:
    """Displacements relative to the largest, when that of the bead with most energy is real."""
    shape = np.asarray(spectrum.modes[:, mode])
    return np.asarray(shape.real / np.abs(shape).max())


def _name(spectrum: Spectrum, mode: int) -> str:
    """Such as ``localised mode 41, 15.09 kHz, around bead 21``."""
    frequency = spectrum.frequencies[mode]
    local = mode + 1 in spectrum.localised
    words = f"{'localised ' if local else ''}mode {mode + 1}"
    place = f", around bead {spectrum._bead_of_mode(mode + 1)}" if local else ""
    if frequency == 0.0 and spectrum.decay_rates[mode] > 0.0:
        return f"{words}, overdamped{place}"
    if spectrum.chain.units == "SI":
        return f"{words}, {1e-3 * frequency:.4g} kHz{place}"
    return f"{words}, $f$ = {frequency:.4g}{place}"


def _bands(spectrum: Spectrum) -> list[str]:
    """Bands of the host for the title, if modes are outside of one or two of them."""
    if not spectrum.localised.size or len(edges := spectrum.host_edges) > 2:
        return []
    factor, unit = (1e-3, " kHz") if spectrum.chain.units == "SI" else (1.0, "")
    ranges = [f"{factor * low:.4g} to {factor * high:.4g}" for low, high in edges]
    return [f"band{'s' * (len(edges) > 1)} of the host: {' and '.join(ranges)}{unit}"]

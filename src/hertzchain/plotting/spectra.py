"""Plot spectra: band structure, modes and transfer functions."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import ArrayLike

from ..chain.chain import Chain
from ..chain.drives import Driven
from ..collision import Array
from ..errors import InputError
from ..theory.dispersion import spring_modes
from ..theory.response import WallName
from ..theory.spectrum import ROOM, Spectrum
from ..validation.numbers import real_numbers
from ..validation.objects import check_choice
from .colours import COLOURS, curve_colour, grey
from .legends import place_legend
from .shared_spectra import label_spectra, note_spectrum, words_of_spectra
from .style import BeadLocator, figure_style, get_axes, set_title
from .titles import chain_title

KINDS: Final = ("bands", "modes")
# Phases of a curve.
PHASES: Final = 201
# Range of the amplitudes that are drawn.
DECADES: Final = 8.0
# Without loss, peaks leave the frame at this multiple of the largest running median, which
# contains no peak that is narrower than half of this number of frequencies.
PEAK: Final = 30.0
RUNNING: Final = 9
# Label of the frequencies in a band gap or above all bands.
NO_WAVES: Final = "no plane waves"
# Relative distance from an infinite resonance at which the curve has a further point.
NEAR: Final = 1e-9


# Gaps that transfer functions in the same axes have in common, and the ranges that show them.
_shaded: Final[weakref.WeakKeyDictionary[Axes, tuple[Array | None, list[Patch]]]] = (
    weakref.WeakKeyDictionary()
)


def plot_spectrum(
    spectrum: Spectrum,
    kind: str | None = None,
    *,
    cell: int | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Plot the bands or the modes of a spectrum, as described in `Spectrum.plot`."""
    kind = check_choice("kind of plot", kind, KINDS) if kind is not None else None
    edges = _edges(spectrum, cell, required=kind == "bands" or cell is not None)
    factor, label = frequency_axis(spectrum.chain)
    with figure_style():
        axes = get_axes(ax)
        if edges is not None and kind != "modes":
            _draw_bands(axes, spectrum, cell, factor)
            top = edges.max()
        else:
            number = np.arange(1, len(spectrum.frequencies) + 1)
            axes.plot(number, factor * spectrum.frequencies, "o", markersize=3.0,
                      markerfacecolor="none", color=COLOURS[1], clip_on=False)  # fmt: skip
            axes.set_xlabel("mode")
            axes.xaxis.set_major_locator(BeadLocator())
            top = spectrum.frequencies.max()
            if (local := spectrum.localised).size:
                axes.plot(local, factor * spectrum.frequencies[local - 1], "o", markersize=5.0,
                          color=COLOURS[2], clip_on=False, label="localised mode")  # fmt: skip
        axes.set_ylim(0.0, factor * ROOM * top)
        gaps = _host_gaps(spectrum) if edges is None else spectrum.gaps(cell=cell)
        _shade(axes, axes.axhspan, gaps, factor, ROOM * top)
        axes.set_ylabel(label)
        set_title(axes, chain_title(spectrum.chain))
        if gaps is not None:
            place_legend(axes, own=ax is None)
    return axes


def plot_transfer(
    spectrum: Spectrum,
    contact: int,
    *,
    drive: Driven = "force",
    at: int | WallName = 1,
    frequencies: ArrayLike | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Plot the amplitude of a contact force, as described in `Spectrum.plot_transfer`."""
    if frequencies is None:
        shown = spectrum._usual_frequencies
    else:
        shown = real_numbers("frequency", frequencies).reshape(-1)
        if len(shown) < 2 or not (np.diff(shown) > 0.0).all():
            raise InputError("frequencies of a plot must be at least two increasing numbers")
    size = np.abs(spectrum.transfer_force(shown, contact, drive=drive, at=at))
    factor, label = frequency_axis(spectrum.chain)
    with figure_style():
        axes = get_axes(ax)
        # Curves that the axes already have keep their colours and remain visible.
        drawn, present = len(axes.lines), axes.get_ylim()
        limits_of_others = axes.get_xlim() if drawn else (np.inf, -np.inf)
        colour = curve_colour(axes, 1 + drawn)
        axes.semilogy(factor * shown, size, color=colour, linewidth=0.9)
        if limits := _amplitudes(size, lossless=not spectrum.contacts.dampers.any()):
            low, high = (limits, present) if drawn else (limits, limits)
            axes.set_ylim(min(low[0], high[0]), max(low[1], high[1]))
        left, right = limits_of_others
        axes.set_xlim(min(left, factor * shown[0]), max(right, factor * shown[-1]))
        gaps = None if _edges(spectrum, None, required=False) is None else spectrum.gaps()
        _shade_common_gaps(axes, gaps, factor, max(right / factor, shown[-1]))
        if not spectrum.contacts.dampers.any():
            poles = _resonances(spectrum, drive, at)
            near = (1.0 - NEAR) * poles[(poles > shown[0]) & (poles < shown[-1])]
            peaks = np.abs(spectrum.transfer_force(near, contact, drive=drive, at=at))
            where = np.searchsorted(shown, near)
            shown, size = np.insert(shown, where, near), np.insert(size, where, peaks)
            axes.lines[-1].set_data(factor * shown, size)
        axes.set_xlabel(label)
        place = f"the {at}" if isinstance(at, str) else f"bead {at}"
        driven = f"{drive} {'on' if drive == 'force' else 'of'} {place}"
        note_spectrum(axes.lines[-1], spectrum.chain, f"contact {contact}", driven)
        axes.set_ylabel(_amplitude_label(axes, spectrum.chain))
        shared = all(driven in words for words in words_of_spectra(axes))
        label_spectra(axes, *([driven] if shared else []))
        if axes.get_legend_handles_labels()[1]:
            place_legend(axes, own=ax is None)
    return axes


def _amplitude_label(axes: Axes, chain: Chain) -> str:
    """Label of the transfer functions in axes, with the contact and the drive that they share."""
    words = words_of_spectra(axes)
    contacts, drives = (list(dict.fromkeys(each)) for each in zip(*words, strict=True))
    kinds = list(dict.fromkeys(each.partition(" ")[0] for each in drives))
    force = f"force in {contacts[0]}" if len(contacts) == 1 else "contact force"
    drive = drives[0] if len(drives) == 1 else " or ".join(kinds)
    unit = {("displacement",): " [N/m]", ("force",): ""}.get(tuple(kinds), " [1 or N/m]")
    return f"{force}\nper {drive}{unit if chain.units == 'SI' else ''}"


def _resonances(spectrum: Spectrum, drive: Driven, at: int | WallName) -> Array:
    """Frequencies above 0 at which the motion is infinite without loss."""
    if drive == "force" or isinstance(at, str):
        return spectrum.frequencies[spectrum.frequencies > 0.0]
    # A bead whose displacement is given is a wall for the beads on both sides.
    contacts, found = spectrum.contacts, []
    for side in (slice(0, at - 1), slice(at, None)):
        masses = contacts.masses[side]
        springs = contacts.springs[side.start :][: len(masses) + 1]
        if len(masses):
            found.append(spring_modes(masses, springs[1:-1], (springs[0], springs[-1]))[0])
    return np.sort(np.concatenate(found)) / (2.0 * np.pi)


def _amplitudes(size: Array, *, lossless: bool) -> tuple[float, float] | None:
    """Limits of the amplitudes; without loss, those of resonances depend on the grid."""
    known = size[np.isfinite(size) & (size > 0.0)]
    if not len(known):
        return None
    top = 3.0 * known.max()
    if lossless:
        padded = np.pad(known, RUNNING // 2, "edge")
        typical = np.median(sliding_window_view(padded, RUNNING), axis=1).max()
        top = min(top, PEAK * typical)
    return max(known.min(), 10.0**-DECADES * top), top


def frequency_axis(chain: Chain) -> tuple[float, str]:
    """Factor and label of a frequency axis: kilohertz for a chain in SI units."""
    return (1e-3, "frequency [kHz]") if chain.units == "SI" else (1.0, "frequency $f$")


def _shade(
    axes: Axes, span: Callable[..., Any], gaps: Array | None, factor: float, end: float
) -> None:
    """Shade the frequency ranges without plane waves, up to an end."""
    if gaps is None:
        return
    # A second spectrum in these axes has the same entry of the legend.
    label = "" if NO_WAVES in axes.get_legend_handles_labels()[1] else NO_WAVES
    for low, high in np.minimum(gaps, end):
        if high > low:
            span(factor * low, factor * high, color=grey(axes, 0.9), linewidth=0.0, label=label)
            label = ""


def _shade_common_gaps(axes: Axes, gaps: Array | None, factor: float, end: float) -> None:
    """Shade the frequencies at which no chain in these axes that repeats transmits waves."""
    present, shaded = _shaded.get(axes, (None, []))
    if gaps is None:
        gaps = present
    elif present is not None:
        both = [(max(a, c), min(b, d)) for a, b in present for c, d in gaps]
        gaps = np.array([each for each in both if each[0] < each[1]]).reshape(-1, 2)
    for patch in shaded:
        patch.remove()
    before = len(axes.patches)
    _shade(axes, axes.axvspan, gaps, factor, end)
    _shaded[axes] = gaps, axes.patches[before:]


def _edges(spectrum: Spectrum, cell: int | None, *, required: bool) -> Array | None:
    """Edges of the bands, or nothing if the chain does not repeat and bands are not required."""
    try:
        return spectrum.band_edges(cell=cell)
    except InputError:
        if required:
            raise
        return None


def _host_gaps(spectrum: Spectrum) -> Array | None:
    """Ranges without plane waves in the periodic host of a chain with a few other beads."""
    try:
        edges = spectrum.host_edges
    except InputError:
        return None
    return np.column_stack((edges[:, 1], np.append(edges[1:, 0], np.inf)))


def _draw_bands(axes: Axes, spectrum: Spectrum, cell: int | None, factor: float) -> None:
    """Bands over the phase, and modes as ticks at the right axis."""
    phase = np.linspace(0.0, np.pi, PHASES)
    bands = factor * spectrum.bands(phase, cell=cell)
    axes.plot(phase / np.pi, bands, color=COLOURS[1])
    axes.lines[-1].set_label("infinite chain")
    modes = factor * spectrum.frequencies
    axes.plot(np.ones(len(modes)), modes, "_", color=COLOURS[2], markersize=9.0, clip_on=False,
              label="modes of the chain")  # fmt: skip
    axes.set_xlim(0.0, 1.0)
    axes.set_xlabel(r"phase per cell $q/\pi$")

"""Notes of a pulse: reasons for missing values by the name of the quantity, and warnings."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..collision import Array
from ..errors import InputError, short_repr
from ..validation.objects import check_choice, text
from .quantities import QUANTITIES

# Name of the note with the warnings of a theory about the chain.
WARNING: Final = "warning"
# Mass of a bead, relative to the smaller one of its neighbours, below which it bounces between them
# so that first maxima need not be the largest ones of the pulse.
LIGHT: Final = 0.65
# Mass of a bead over that of the bead behind from which later maxima may be larger, and number of
# such contacts behind a bead.  In simulated exponential tapers of 6 to 60 beads, they were larger
# for rates of 0.11 to 0.25 and smaller for rates up to 0.1.
STEEP, STEEP_CONTACTS = 0.74, 4
OF_FIRST_MAXIMA: Final = ("velocity", "momentum", "energy")
OUT_OF_ORDER: Final = (
    "residence: negative where the pulse arrives at the next bead before it arrives at this one"
)


def checked_notes(notes: Mapping[str, str]) -> dict[str, str]:
    """A copy of the notes of a pulse."""
    if not isinstance(notes, Mapping):
        raise InputError(
            f"notes of a pulse must be a mapping from quantities to text, got {short_repr(notes)}"
        )
    for name, note in notes.items():
        check_choice("quantity of a note", name, (*QUANTITIES, WARNING))
        text(f"note on {name}", note)
    return dict(notes)


def notes_in_words(notes: Mapping[str, str], quantities: Iterable[str] = QUANTITIES) -> list[str]:
    """Each note once, after the names of its quantities."""
    about: dict[str, list[str]] = {}
    for name in quantities:
        if name in notes:
            about.setdefault(notes[name], []).append(name)
    return [f"{', '.join(names)}: {note}" for note, names in about.items()]


def bouncing_notes(masses: Array) -> dict[str, str]:
    """Notes on first maxima where light beads bounce, or masses fall steeply; none elsewhere."""
    light = np.zeros(len(masses), bool)
    light[1:-1] = masses[1:-1] < LIGHT * np.minimum(masses[:-2], masses[2:])
    if not light.any():
        return _steep_notes(masses)
    text = (
        f"light beads bounce between heavier ones ({beads_in_words(light)}), so that the first "
        "maximum, here and at their neighbours, may be smaller than a later one of the same pulse"
    )
    return dict.fromkeys(OF_FIRST_MAXIMA, text)


def _steep_notes(masses: Array) -> dict[str, str]:
    """Notes on first maxima in steep forward tapers, where beads behind a bead hit it again."""
    steep = np.append(False, masses[1:] < STEEP * masses[:-1])
    recent = np.convolve(steep, np.ones(STEEP_CONTACTS, int))[: len(masses)]
    flags = recent == STEEP_CONTACTS
    # Nothing is ahead of the last bead.
    flags[-1] = False
    if not flags.any():
        return {}
    text = (
        f"masses fall by more than {1.0 - STEEP:.0%} from bead to bead (steep forward taper), "
        f"so that the first maximum may be smaller than a later one ({beads_in_words(flags)})"
    )
    return dict.fromkeys(OF_FIRST_MAXIMA, text)


def beads_in_words(flags: NDArray[np.bool_]) -> str:
    """The beads with a flag: ``at bead 3``, ``at beads 3 to 5`` or ``from bead 3 on``."""
    beads = np.flatnonzero(flags) + 1
    first, last = int(beads[0]), int(beads[-1])
    if len(beads) <= last - first:
        return f"at {len(beads)} beads from {first} to {last}"
    if last == len(flags) and len(beads) > 1:
        return f"from bead {first} on"
    return f"at bead {first}" if first == last else f"at beads {first} to {last}"


def out_of_order(residence: Array | None) -> bool:
    """Whether the pulse arrives at a bead before it arrives at the one behind."""
    return residence is not None and bool((residence < 0.0).any())

"""Notes of a pulse: reasons for missing values, by the name of the quantity."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from ..errors import InputError, short_repr
from ..validation.objects import check_choice, text
from .quantities import QUANTITIES


def checked_notes(notes: Mapping[str, str]) -> dict[str, str]:
    """A copy of the notes of a pulse."""
    if not isinstance(notes, Mapping):
        raise InputError(
            f"notes of a pulse must be a mapping from quantities to text, got {short_repr(notes)}"
        )
    for name, note in notes.items():
        check_choice("quantity of a note", name, QUANTITIES)
        text(f"note on {name}", note)
    return dict(notes)


def notes_in_words(notes: Mapping[str, str], quantities: Iterable[str] = QUANTITIES) -> list[str]:
    """Each note once, after the names of its quantities."""
    about: dict[str, list[str]] = {}
    for name in quantities:
        if name in notes:
            about.setdefault(notes[name], []).append(name)
    return [f"{', '.join(names)}: {note}" for note, names in about.items()]

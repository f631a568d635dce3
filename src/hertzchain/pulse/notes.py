"""Notes of a pulse: where values are missing and why, by the name of the quantity."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from hertzchain.arguments import one_of, text
from hertzchain.errors import InputError, shown
from hertzchain.pulse.quantities import QUANTITIES


def checked_notes(notes: Mapping[str, str]) -> dict[str, str]:
    """A copy of the notes of a pulse.

    Parameters
    ----------
    notes : mapping of str to str
        What was given.

    Returns
    -------
    dict of str to str

    Raises
    ------
    InputError
        If they are no mapping from quantities to text.

    Examples
    --------
    >>> checked_notes({"arrival": "bead 9: not reached"})
    {'arrival': 'bead 9: not reached'}
    """
    if not isinstance(notes, Mapping):
        raise InputError(
            f"notes of a pulse must be a mapping from quantities to text, got {shown(notes)}"
        )
    for name, note in notes.items():
        one_of("quantity of a note", name, QUANTITIES)
        text(f"note on {name}", note)
    return dict(notes)


def notes_in_words(notes: Mapping[str, str], quantities: Iterable[str] = QUANTITIES) -> list[str]:
    """Each note once, after the quantities that it is about.

    Parameters
    ----------
    notes : mapping of str to str
        The notes of a pulse.
    quantities : iterable of str
        Notes on others are left out.

    Returns
    -------
    list of str

    Examples
    --------
    >>> notes_in_words(dict.fromkeys(("arrival", "peak_time"), "bead 9: not reached"))
    ['peak_time, arrival: bead 9: not reached']
    """
    about: dict[str, list[str]] = {}
    for name in quantities:
        if name in notes:
            about.setdefault(notes[name], []).append(name)
    return [f"{', '.join(names)}: {note}" for note, names in about.items()]

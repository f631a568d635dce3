"""The option `--reflection` of the command `simulate`: coefficients as text and as plain data."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import click

if TYPE_CHECKING:
    from ..chain.chain import Chain
    from ..simulation.run import Run

Contacts: TypeAlias = tuple[int, int | str]
COEFFICIENTS: Final = (
    "reflected_energy", "transmitted_energy", "reflected_momentum", "transmitted_momentum",
    "reflected_force", "transmitted_force", "kept_energy", "kept_momentum", "entered_energy",
    "unexplained_energy",
)  # fmt: skip

# Parts of the value of the option, as in its help.
PARTS: Final = ("BEFORE", "AFTER")


class TwoContacts(click.ParamType):  # type: ignore[type-arg]
    """Two contacts, such as 50:75, 50-75 or 45:wall."""

    name = "contacts"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> Contacts:
        """Convert the text of the option."""
        found = re.fullmatch(r"(\d+) *[:-] *(\d+|(?:(?:left|right) )?wall)", str(value).strip())
        if found is None:
            self.fail(f"{value!r} is not two contacts, such as 50:75 or 45:wall", param, ctx)
        return int(found[1]), int(found[2]) if found[2].isdigit() else found[2]


reflection_option = click.option(
    "--reflection",
    type=TwoContacts(),
    metavar="BEFORE:AFTER",
    help="Print the fractions of the energy and the momentum of the first wave that are reflected "
    "and transmitted between these two contacts, such as 50:75; AFTER can be 'wall'.  Give "
    "--until so late that the reflected wave has passed BEFORE.",
)


def check_reflection(contacts: Contacts | None, chains: Iterable[Chain]) -> None:
    """Raise `InputError` before a run if a chain does not have the contacts."""
    from ..simulation.contact_pairs import separate_contacts

    if contacts is None:
        return
    before, after = contacts
    for chain in chains:
        separate_contacts(chain, before, after, PARTS, " in --reflection")


def reflection_in_words(run: Run, contacts: Contacts) -> str:
    """The coefficients of a run, those of each direction on a line."""
    about, kept, reflected, transmitted, momentum = run.reflection(*contacts)._words
    return (f"reflection: {about}, {kept}:\n    {reflected};\n"
            f"    {transmitted}; {momentum}")  # fmt: skip


def reflection_as_dict(run: Run, contacts: Contacts) -> dict[str, Any]:
    """The coefficients of a run as plain data."""
    from ..validation.json_types import finite

    found = run.reflection(*contacts)
    document: dict[str, Any] = finite(
        {
            **{name: getattr(found, name) for name in ("before", "after", "until", "disturbed")},
            **{name: getattr(found, name) for name in COEFFICIENTS},
        }
    )
    return document

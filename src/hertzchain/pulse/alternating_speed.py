"""The speed of a pulse where it alternates from contact to contact."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..representation import measure

# Smallest relative change between neighbouring contacts from which on a speed alternates.
ALTERNATING: Final = 0.02
# Contacts on each side over which it must alternate.
REACH: Final = 2


def alternates_at(speed: Array | None, contact: int) -> bool:
    """Whether the speed rises and falls from contact to contact near one of them, from 1."""
    if speed is None or not REACH < contact < len(speed) - REACH:
        return False
    near = speed[contact - 1 - REACH : contact + REACH]
    changes = np.diff(near)
    turns = bool((changes[1:] * changes[:-1] < 0.0).all())
    return turns and bool((np.abs(changes) > ALTERNATING * np.abs(near[1:])).all())


def over_two_contacts(chain: Chain, residence: Array, contact: int) -> str:
    """Mean speed over a contact, from 1, and the next one, with its unit."""
    both = slice(contact - 1, contact + 1)
    mean = float(chain.centre_distances[both].sum() / residence[both].sum())
    return f"{measure(mean, 'm/s', chain.units)} over contacts {contact} and {contact + 1}"

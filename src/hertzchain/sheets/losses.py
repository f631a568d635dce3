"""The laws of loss of a row in words, for the page of the teacher."""

from __future__ import annotations

from itertools import groupby

from ..chain.bead_names import is_load_cell
from ..chain.chain import Chain
from ..chain.laws.base import Loss
from ..chain.laws.elastic import Elastic
from ..chain.laws.given_numbers import law_with_value
from ..representation import listed


def losses_in_words(chain: Chain) -> str:
    """Such as ``viscoelastic 0.5 µs; load cell elastic``; empty without a loss."""
    if chain.lossless:
        return ""
    laws = [_law(each) for each in chain.contact_losses]
    inner = laws[1:-1]
    end = "load cell" if is_load_cell(chain) else "wall"
    walls = [("left wall", chain.left_wall, laws[0]), (end, chain.right_wall, laws[-1])]
    between = [inner[0]] if len(set(inner)) == 1 else _by_contacts(inner)
    others = [f"{name} {law}" for name, wall, law in walls if wall and [law] != between]
    return "; ".join([*between, *others])


def inherits_loss(chain: Chain) -> bool:
    """Whether the contact with a load cell has the law of loss of the row."""
    wall = chain.right_wall
    lossy = not isinstance(chain.contact_losses[-1], Elastic)
    return wall is not None and wall.loss is None and is_load_cell(chain) and lossy


def _by_contacts(laws: list[str]) -> list[str]:
    """Each law with its contacts, such as ``elastic in contacts 1 to 4 and 6``."""
    found = []
    for law in dict.fromkeys(laws):
        own = [k for k, each in enumerate(laws, 1) if each == law]
        ranges = [
            [k for _, k in part] for _, part in groupby(enumerate(own), lambda p: p[1] - p[0])
        ]
        words = [f"{k[0]} to {k[-1]}" if len(k) > 1 else f"{k[0]}" for k in ranges]
        found.append(f"{law} in contact{'s' * (len(own) > 1)} {listed(words)}")
    return found


def _law(law: Loss) -> str:
    """Such as ``restitution 0.95``, ``viscoelastic 0.5 µs`` or ``elastic``."""
    if isinstance(law, Elastic):
        return law.name
    return law_with_value(law, "SI").replace(" us", " µs")

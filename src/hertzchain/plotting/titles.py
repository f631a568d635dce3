"""Titles of figures: the beads of a chain in words."""

from __future__ import annotations

import numpy as np

from ..chain.chain import Chain
from ..chain.description import beads_of, sizes_in_words
from ..collision import HERTZ_EXPONENT
from .style import literal


def chain_title(chain: Chain) -> str:
    """Such as ``20 steel balls, 20 mm to 8 mm``; strikers are named, not counted."""
    count, first = chain.beads, chain.strikers
    title, *_ = chain.description.partition(f"{count} beads")
    title += f"{count} beads"
    if chain.units == "SI":
        strikers = {0: "", 1: " and a striker"}.get(first, f" and {first} strikers")
        balls = beads_of(count - first, "balls", _materials(chain) or ["SI"])
        title = f"{balls}{strikers}, {sizes_in_words(chain.radii[first:])}"
    elif chain.taper is None and np.all(chain.radii == 1.0):
        title = f"{count} equal beads"
    p = chain.exponents
    law = f", p = {p:g}" if isinstance(p, float) and p != HERTZ_EXPONENT else ""
    return literal(title + law)


def _materials(chain: Chain) -> list[str]:
    """Names of materials without their grades, unless two of them differ only by the grade."""
    names = list(dict.fromkeys(each.name for each in (chain.materials or ())[chain.strikers :]))
    parts = [name.partition("-") for name in names]
    short = [
        base if any(map(str.isdigit, grade)) else name
        for name, (base, _, grade) in zip(names, parts, strict=True)
    ]
    names = short if len(set(short)) == len(short) else names
    return ["PTFE" if name == "ptfe" else name for name in names]

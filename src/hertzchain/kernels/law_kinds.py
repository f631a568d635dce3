"""Kinds of contact law, which select the compiled force of a contact.

This module does not import numba, so that `hertzchain.chain` can import it.
"""

from __future__ import annotations

from typing import NamedTuple

# The branches of `hertzchain.kernels.contact_law.contact_force`.
ELASTIC, DAMPED, UNLOADING, PLASTIC, YIELDING = range(5)
# Kinds for which there are vectorised loops over all contacts of a chain.
VECTORISED = frozenset({ELASTIC, DAMPED, UNLOADING, PLASTIC})


class LawRow(NamedTuple):
    """Numbers of a law that are the same for all of its contacts."""

    kind: int
    # DAMPED: k d^p + damping d^overlap_power |d'|^speed_power sgn d'.
    overlap_power: float = 0.0
    speed_power: float = 1.0
    # Part of the energy that is returned: 1 - w of UNLOADING, e^2 of PLASTIC.
    kept: float = 1.0
    attractive: bool = True

"""What a chain has beyond the paper's, and how it is called in tables and figures."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hertzchain.chain.tapers import rate_symbol
from hertzchain.contacts import HERTZ_EXPONENT

if TYPE_CHECKING:
    from hertzchain.chain.chain import Chain


def features_of(chain: Chain) -> tuple[str, ...]:
    """What the chain has beyond the paper's.

    Parameters
    ----------
    chain : Chain
        Any chain.

    Returns
    -------
    tuple of str
        Names such as ``"gaps"``, ``"right wall"``; empty for the paper's chains.

    Examples
    --------
    >>> import hertzchain as hc
    >>> features_of(hc.Chain.uniform(20).replace(gravity=0.01, right_wall=hc.Wall()))
    ('gravity', 'right wall')
    """
    present = {
        "SI units": chain.units == "SI",
        "masses": "masses" in chain.given,
        "stiffness": "stiffness" in chain.given,
        "strikers": chain.strikers > 0,
        "velocities": "velocities" in chain.given and not _only_struck(chain),
        "gaps": "gaps" in chain.given and bool(chain.gaps.any()),
        "precompression": chain.precompression > 0.0,
        "gravity": chain.gravity != 0.0,
        "left wall": chain.left_wall is not None,
        "right wall": chain.right_wall is not None,
        "drive": chain.drive is not None,
        "loss": chain.loss is not None,
    }
    return tuple(name for name, there in present.items() if there)


def description_of(chain: Chain) -> str:
    """The chain in a few words, as it heads tables and figures.

    Parameters
    ----------
    chain : Chain
        Any chain.

    Returns
    -------
    str

    Examples
    --------
    >>> import hertzchain as hc
    >>> description_of(hc.Chain.tapered("forward-linear", 0.01, beads=30))
    'forward-linear, S = 0.01, 30 beads'
    """
    kind = "free radii"
    if chain.taper is not None:
        kind = f"{chain.taper}, {rate_symbol(chain.taper)} = {chain.rate:g}"
    elif chain.units == "SI":
        kind = f"SI, {_composition(chain)}"
    elif np.all(chain.radii == 1.0):
        kind = "uniform"
    law = "" if chain.exponent == HERTZ_EXPONENT else f", p = {chain.exponent:g}"
    rest = "".join(f", {name}" for name in chain.features if name != "SI units")
    return f"{kind}, {chain.beads} beads{law}{rest}"


def _only_struck(chain: Chain) -> bool:
    """Whether bead 1 alone moves, with velocity one or, in SI units, any."""
    first = float(chain.velocities[0])
    sound = first == 1.0 if chain.units == "scaled" else first >= 0.0
    return sound and not chain.velocities[1:].any()


def _composition(chain: Chain) -> str:
    names = dict.fromkeys(each.name for each in chain.materials or ())
    kinds = " and ".join(names) if len(names) < 3 else f"{len(names)} materials"
    low, high = 1e3 * chain.radii.min(), 1e3 * chain.radii.max()
    sizes = f"R = {low:g} mm" if low == high else f"R = {low:g} .. {high:g} mm"
    return f"{kinds}, {sizes}" if kinds else sizes

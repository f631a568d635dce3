"""Check that a method supports all features of a chain."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import TypeAlias

from ..errors import InputError, short_repr
from ..representation import listed
from .chain import Chain

# Advice for a chain that a method does not support, perhaps depending on the features.
Alternative: TypeAlias = str | Callable[[Sequence[str]], str]
# Features that are named with an article in messages.
COUNTABLE = ("left wall", "right wall", "drive", "loss", "cap")


def require_chain(method: str, chain: object, *, beads: int = 2) -> None:
    """Raise an error for anything but a chain, or for one of fewer beads."""
    if isinstance(chain, Chain):
        if chain.beads < beads:
            raise InputError(
                f"{method} requires at least {beads} beads, got {chain.description}; "
                f"{_more_beads(chain)}"
            )
        return
    if isinstance(chain, str | os.PathLike):
        raise InputError(
            f"{method} requires a Chain, got {short_repr(chain)}; "
            f"hc.load_chain({os.fspath(chain)!r}) reads one from a file"
        )
    if isinstance(held := getattr(chain, "chain", None), Chain):
        # A run that is passed to hertz_range is meant to give its overlaps.
        overlaps = method == "hertz_range" and hasattr(chain, "largest_overlaps")
        use = "run.chain, run.largest_overlaps" if overlaps else "result.chain"
        raise InputError(
            f"{method} requires a Chain, got a {type(chain).__name__} of one "
            f"({held.description}); "
            # Theories are named in words.
            + (f"use {method}({use})" if method.isidentifier() else f"pass {use} instead")
        )
    # Objects that resemble a chain have advice of their own.
    advice = getattr(chain, "_instead_of_chain", "Chain.from_radii builds one from radii")
    raise InputError(f"{method} requires a Chain, got {short_repr(chain)}; {advice}")


def _more_beads(chain: Chain) -> str:
    """Advice for a single bead, which has no contact with another one."""
    if chain.left_wall is None and chain.right_wall is None:
        return "add a striker, such as chain.struck_by(), or more beads"
    return (
        "for one ball that hits the right wall, simulate two beads with a gap between them, give a "
        "velocity only to bead 2, which hits the wall, and give until"
    )


def require_supported(
    chain: Chain,
    method: str,
    *,
    supported: Sequence[str] = (),
    alternative: Alternative = "",
) -> None:
    """Raise an error for a chain with a feature that a method does not support."""
    require_chain(method, chain)
    if not chain.features:
        return
    # Strikers imply their velocities.
    moving = chain.velocities[chain.strikers :].any()
    implied = ["velocities"] if "strikers" in chain.features and not moving else []
    others = [name for name in chain.features if name not in (*supported, *implied)]
    if others:
        advice = alternative if isinstance(alternative, str) else alternative(others)
        one = len(others) == 1
        if set(others) <= {"left wall", "right wall"}:
            # Theories are compared with the same chain at a free end.
            without = ", ".join(f"{name.replace(' ', '_')}=None" for name in others)
            advice = (
                f"{advice}, or omit the wall{'' if one else 's'}"
                if advice
                else "omit it"
                if one
                else "omit them"
            )
            advice += f": chain.replace({without})"
        advice = advice or f"remove {'it' if one else 'them'} from the chain"
        if others == ["SI units"]:
            advice = "use Scales.of(chain).to_scaled(chain)"
        # Chains of materials are converted into scaled ones with masses and stiffness.
        derived = {"masses", "stiffness"} & set(others)
        if derived and len({material.name for material in chain.materials or ()}) > 1:
            others = ["several materials", *(name for name in others if name not in derived)]
        names = [f"a {name}" if name in COUNTABLE else name for name in others]
        raise InputError(
            f"{method} does not support {listed(names, 'or')}; {advice} "
            f"(chain: {chain.description})"
        )


def require_same_units(method: str, chains: Sequence[object]) -> None:
    """Raise an error for a list in which only some of the chains are in SI units."""
    in_si = sum(isinstance(each, Chain) and each.units == "SI" for each in chains)
    if 0 < in_si < len(chains):
        raise InputError(
            f"{in_si} of {len(chains)} chains are in SI units and the others are scaled: call "
            f"{method} separately for each kind, so that a table has one set of units"
        )


def require_struck(method: str, chain: Chain) -> None:
    """Raise an error for a chain whose first bead does not move forwards."""
    velocity = chain.velocities[0]
    if not velocity > 0.0:
        raise InputError(
            f"{method} needs a chain whose first bead is struck, but this one "
            f"{'moves backwards' if velocity < 0.0 else 'is at rest'} ({chain.description}): "
            "give it a velocity > 0"
        )

"""Check that a method supports all features of a chain."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import TypeAlias

from ..errors import InputError, short_repr
from .chain import Chain

# Advice for a chain that a method does not support, perhaps depending on the features.
Alternative: TypeAlias = str | Callable[[Sequence[str]], str]
# Features that are named with an article in messages.
COUNTABLE = ("left wall", "right wall", "drive", "loss")


def require_chain(method: str, chain: object) -> None:
    """Raise an error for anything but a chain."""
    if isinstance(chain, Chain):
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
            f"({held.description}); use {method}({use})"
        )
    raise InputError(
        f"{method} requires a Chain, got {short_repr(chain)}; "
        "Chain.from_radii builds one from radii"
    )


def require_supported(
    chain: Chain,
    method: str,
    *,
    supported: Sequence[str] = (),
    alternative: Alternative = "",
    description: str = "",
) -> None:
    """Raise an error for a chain with a feature that a method does not support."""
    require_chain(method, chain)
    others = [name for name in chain.features if name not in supported]
    if others:
        advice = alternative if isinstance(alternative, str) else alternative(others)
        advice = advice or "remove them from the chain"
        if others == ["SI units"]:
            advice = "use Scales.of(chain).to_scaled(chain)"
        raise InputError(
            f"{method} does not support {_listed(others)}; {advice} "
            f"(chain: {description or chain.description})"
        )


def _listed(features: Sequence[str]) -> str:
    *first, last = [f"a {name}" if name in COUNTABLE else name for name in features]
    return f"{', '.join(first)} or {last}" if first else last

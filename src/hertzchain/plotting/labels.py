"""Labels of curves that state what distinguishes them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from ..chain.chain import Chain
from ..chain.yield_pressure import YIELD_STATED, assumes_pressure
from .differences import loss_in_words


def distinguish(descriptions: Sequence[Sequence[str]]) -> tuple[list[str], str]:
    """Labels with the parts of each description that differ, and a title with the common parts.

    If nothing differs, the labels are the first parts of the descriptions.
    """
    first = descriptions[0]
    common = [part for part in first if all(part in other for other in descriptions)]
    labels = [", ".join(p for p in parts if p not in common) for parts in descriptions]
    if len(descriptions) == 1 or not any(labels):
        return [parts[0] for parts in descriptions], ", ".join(first[1:])
    return [label.removeprefix("and ") or first[0] for label in labels], ", ".join(common)


def numbered(labels: Sequence[str]) -> list[str]:
    """Labels with numbers in parentheses for those that several curves would share."""
    counts, seen = Counter(labels), Counter[str]()
    found = []
    for label in labels:
        seen[label] += 1
        found.append(f"{label} ({seen[label]})" if counts[label] > 1 else label)
    return found


def with_assumed_yield(title: str, chains: Sequence[Chain]) -> str:
    """A title, with the yield pressure that any of the chains assumes."""
    assumed = YIELD_STATED if any(map(assumes_pressure, chains)) else ""
    return ", ".join(filter(None, (title, assumed)))


def with_losses(chains: Mapping[str, Chain]) -> dict[str, str]:
    """Labels of named chains: their names, with the losses if these differ."""
    losses = {name: loss_in_words(chain) for name, chain in chains.items()}
    differ = len(set(losses.values())) > 1
    return {name: f"{name} ({loss})" if differ else name for name, loss in losses.items()}

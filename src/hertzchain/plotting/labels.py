"""Labels of curves that state what distinguishes them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..chain.chain import Chain


def distinguish(descriptions: Sequence[Sequence[str]]) -> tuple[list[str], str]:
    """Labels with the parts of each description that differ, and a title with the common parts.

    If nothing differs, the labels are the first parts of the descriptions.
    """
    first = descriptions[0]
    common = [part for part in first if all(part in other for other in descriptions)]
    labels = [", ".join(p for p in parts if p not in common) for parts in descriptions]
    if len(descriptions) == 1 or not any(labels):
        return [parts[0] for parts in descriptions], ", ".join(first[1:])
    return [label or first[0] for label in labels], ", ".join(common)


def with_losses(chains: Mapping[str, Chain]) -> dict[str, str]:
    """Labels of named chains: their names, with the losses if these differ."""
    losses = {name: _losses_in_words(chain) for name, chain in chains.items()}
    differ = len(set(losses.values())) > 1
    return {name: f"{name} ({loss})" if differ else name for name, loss in losses.items()}


def _losses_in_words(chain: Chain) -> str:
    """Such as ``no loss``, ``restitution, coefficient = 0.9`` or ``mixed losses``."""
    if chain.lossless:
        return "no loss"
    first, *others = dict.fromkeys(chain.contact_losses)
    if others:
        return "mixed losses"
    values = {name: getattr(first, name) for name in first.parameters()}
    shown = [f"{name} = {value:g}" for name, value in values.items()
             if value is not None and not isinstance(value, bool)]  # fmt: skip
    return ", ".join((first.name, *shown))

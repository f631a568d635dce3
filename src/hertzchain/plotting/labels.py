"""Labels of curves that state what distinguishes them."""

from __future__ import annotations

from collections.abc import Sequence


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

"""Numbers of a law, for words about it."""

from __future__ import annotations

from .base import Loss


def given_numbers(law: Loss) -> dict[str, tuple[float, str]]:
    """Numbers that a law has and their units in SI chains, by their names in messages."""
    return {
        about.called: (value, (law._unit(name) or "") if about.dimension else "")
        for name, about in law.parameters().items()
        if not about.boolean and (value := getattr(law, name)) is not None
    }

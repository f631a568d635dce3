"""Completion of names in the shell: materials, walls, laws, tapers, grades and quantities."""

from __future__ import annotations

from collections.abc import Iterable

from click import Context, Parameter


def _beginning(names: Iterable[str], typed: str) -> list[str]:
    return [name for name in names if name.startswith(typed)]


def complete_materials(_: Context, __: Parameter, incomplete: str) -> list[str]:
    """Names of the catalogue that begin with the typed text, also after other names."""
    from ..chain.materials import catalogue

    before, comma, last = incomplete.rpartition(",")
    return [f"{before}{comma}{name}" for name in _beginning(catalogue(), last.lstrip())]


def complete_walls(_: Context, __: Parameter, incomplete: str) -> list[str]:
    """Names of walls that begin with the typed text."""
    from ..chain.materials import catalogue

    return _beginning(("same", "rigid", "none", *catalogue()), incomplete)


def complete_losses(_: Context, __: Parameter, incomplete: str) -> list[str]:
    """Names of laws that begin with the typed text, with ``=`` if they have parameters."""
    from ..chain.laws.base import LAWS

    return _beginning((f"{name}=" if law.parameters() else name for name, law in LAWS.items()),
                      incomplete)  # fmt: skip


def complete_tapers(_: Context, __: Parameter, incomplete: str) -> list[str]:
    """Names of tapers that begin with the typed text."""
    from ..chain.taper_sizes import SHAPES
    from ..chain.tapers import TAPERS

    return _beginning(("uniform", *TAPERS, *SHAPES), incomplete)


def complete_grades(_: Context, __: Parameter, incomplete: str) -> list[str]:
    """Grades of balls that begin with the typed text, with a G if it has one."""
    from ..chain.random_radii import BALL_GRADES

    letter = incomplete[:1] if incomplete[:1] in ("G", "g") else ""
    return _beginning((f"{letter}{grade}" for grade in BALL_GRADES), incomplete)


def complete_measures(_: Context, __: Parameter, incomplete: str) -> list[str]:
    """Quantities that begin with the typed text; those of a bead with the last one."""
    from ..designs.measures import AT_BEAD, NAMES

    return _beginning((f"{name}@last" if name in AT_BEAD else name for name in NAMES), incomplete)

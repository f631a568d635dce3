"""An `InputError` for results that are indexed like a mapping, with the attribute to use."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..errors import InputError, short_repr, similar_names


class NoEntries:
    """Base class of results whose values are attributes."""

    if not TYPE_CHECKING:
        # Without this, Python would iterate over entries 0, 1, 2 and so on.
        __iter__ = None

        def __getitem__(self, name: object) -> object:
            raise InputError(
                f"a {type(self).__name__} has no entries, got [{short_repr(name)}]; "
                f"{self._instead_of_entry(name)}"
            )

    def _instead_of_entry(self, name: object) -> str:
        """Advice on the attribute to use."""
        names = [each for each in dir(self) if not each.startswith("_")]
        near = similar_names(name, names).replace("'", "")
        return (
            f"use the attribute or method {near}" if near else "use its attributes, which dir lists"
        )

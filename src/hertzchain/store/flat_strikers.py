"""Strikers with a flat face in chain files."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..errors import InputError


def with_flat_radius(striker: Any) -> Any:
    """Strikers with ``radius = "flat"`` instead of ``flat = true``, as on the command line."""
    if isinstance(striker, list):
        return [with_flat_radius(each) for each in striker]
    if not isinstance(striker, Mapping) or not isinstance(striker.get("flat"), bool):
        return striker
    found = {name: value for name, value in striker.items() if name != "flat"}
    if not striker["flat"]:
        return found
    for name in ("radius", "diameter"):
        if name in found:
            raise InputError(f"struck_by has flat = true and {name}: omit one of them")
    return {**found, "radius": "flat"}

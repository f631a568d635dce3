"""The table of the effects of strikers, which `tools/striker_tables.py` writes."""

from __future__ import annotations

import functools
from importlib import resources

import numpy as np

from ..collision import Array


@functools.cache
def striker_table() -> dict[str, Array]:
    """Arrays of the table: ``effect`` on the leading pulse, ``train`` of later waves."""
    path = resources.files("hertzchain.theory") / "striker_table.npz"
    with path.open("rb") as file, np.load(file) as stored:
        return {name: np.asarray(stored[name], dtype=float) for name in stored.files}

"""Read the files of the tables of theories, which scripts in `tools` write."""

from __future__ import annotations

from importlib import resources

import numpy as np

from ..collision import Array


def stored_arrays(name: str) -> dict[str, Array]:
    """Arrays of a file next to this module, as floats."""
    path = resources.files("hertzchain.theory") / name
    with path.open("rb") as file, np.load(file) as stored:
        return {key: np.asarray(stored[key], dtype=float) for key in stored.files}

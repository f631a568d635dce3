"""The table of the effects of strikers, which `tools/striker_tables.py` writes."""

from __future__ import annotations

import functools

from ..collision import Array
from .table_files import stored_arrays


@functools.cache
def striker_table() -> dict[str, Array]:
    """Arrays of the table: ``effect`` on the leading pulse, ``train`` of later waves."""
    return stored_arrays("striker_table.npz")

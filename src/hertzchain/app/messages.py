"""Binary messages to the page: a JSON header, then arrays."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from ..collision import Array
from ..validation.json_types import finite

VERSION: Final = 1
# The page need not copy arrays that begin at multiples of this number of bytes.
ALIGNMENT: Final = 8
MAX_INT16: Final = 32767


@dataclass(frozen=True)
class Part:
    """A message: length of the header and version (4 bytes each), the header, and the arrays."""

    header: Mapping[str, Any]
    arrays: Mapping[str, np.ndarray[Any, Any]] = field(default_factory=dict)

    def pack(self) -> bytes:
        """The message, preceded by its length in 4 bytes."""
        chunks, table, offset = [], [], 0
        for name, values in self.arrays.items():
            raw = np.ascontiguousarray(values).tobytes()
            padded = raw + b"\0" * (-len(raw) % ALIGNMENT)
            table.append([name, values.dtype.str[1:], list(values.shape), offset])
            chunks.append(padded)
            offset += len(padded)
        header = json.dumps(finite({**self.header, "arrays": table}), allow_nan=False).encode()
        header += b" " * (-(len(header) + 8) % ALIGNMENT)
        body = b"".join((struct.pack("<II", len(header), VERSION), header, *chunks))
        return struct.pack("<I", len(body)) + body


def columns_as_int16(name: str, values: Array) -> dict[str, np.ndarray[Any, Any]]:
    """Columns as 16-bit multiples of 1/32767 of the largest value of each.

    The error is 1.6e-5 of that value, and the message is four times shorter.
    """
    largest = np.max(np.abs(values), axis=0, initial=0.0)
    scale = np.divide(MAX_INT16, largest, out=np.zeros_like(largest), where=largest > 0.0)
    return {name: np.rint(values * scale).astype(np.int16), f"{name}.scale": largest}

"""SHA-256 digests of arrays, JSON documents and files, from which damage is recognised."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..collision import Array


def array_digest(arrays: Mapping[str, Array], about: str = "") -> str:
    """Digest of named arrays and of a text about them."""
    found = hashlib.sha256(about.encode())
    for name in sorted(arrays):
        values = np.ascontiguousarray(arrays[name])
        found.update(f"\0{name} {values.dtype.str} {values.shape}\0".encode())
        found.update(values.tobytes())
    return found.hexdigest()


def document_digest(document: Mapping[str, Any]) -> str:
    """Digest of a document of JSON types, regardless of the order of its keys."""
    return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()


def file_digest(file: Path) -> str:
    """Digest of the content of a file."""
    with file.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()

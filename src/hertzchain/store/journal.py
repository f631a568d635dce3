"""A journal of computed numbers, from which an interrupted search is repeated up to its end.

Each line is a checksum, a key, the time used so far and the numbers.  A line that was not written
completely, because the process was killed, is dropped with all that follow it.
"""

from __future__ import annotations

import base64
import os
import zlib
from collections import deque
from pathlib import Path
from typing import Final

import numpy as np

from ..collision import Array
from ..errors import InputError
from .writing import cannot_write

FORMAT: Final = "hertzchain journal 1"


class Journal:
    """Records in the order in which they were computed; without a path, nothing is stored."""

    def __init__(self, path: Path | None, header: str) -> None:
        self.path = path
        self.known: deque[tuple[str, float, Array]] = deque()
        self.seconds = 0.0
        self._stream = None
        if path is None:
            return
        first = f"{FORMAT} {header}\n"
        length = self._read(path, first) if path.exists() else 0
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._stream = path.open("r+b" if path.exists() else "w+b")
            self._stream.truncate(length)
            self._stream.seek(length)
            if length == 0:
                self._write(first)
        except OSError as error:
            raise cannot_write(path, error) from None

    def _read(self, path: Path, first: str) -> int:
        """Read all complete records; return the length of the valid part of the file."""
        try:
            content = path.read_bytes()
        except OSError as error:
            raise InputError(f"cannot read {os.fspath(path)!r} ({error.strerror})") from None
        lines = content.split(b"\n")
        if len(lines) > 1 and lines[0] + b"\n" != first.encode():
            raise InputError(
                f"{os.fspath(path)!r} belongs to another version of hertzchain; remove it, or name "
                "another folder (--store FOLDER on the command line, store in Python)"
            )
        if len(lines) < 2:
            return 0
        length = len(first)
        for line in lines[1:-1]:
            record = _record(line)
            if record is None:
                break
            self.known.append(record)
            length += len(line) + 1
        return length

    def take(self, key: str) -> Array | None:
        """The next record, if there is one, which must have this key."""
        if not self.known:
            return None
        found, seconds, values = self.known.popleft()
        if found != key:
            raise InputError(
                f"{os.fspath(self.path or '')!r} does not repeat the same search, perhaps because "
                "a library or the computer has changed; delete it, or name another folder "
                "(--store FOLDER on the command line, store in Python)"
            )
        self.seconds = seconds
        return values

    def add(self, key: str, seconds: float, values: Array) -> None:
        """Append a record."""
        self.seconds = seconds
        if self._stream is None:
            return
        shape = "x".join(map(str, values.shape)) or "-"
        packed = base64.b64encode(np.ascontiguousarray(values, "<f8").tobytes()).decode()
        body = f"{key} {seconds!r} {shape} {packed}"
        self._write(f"{zlib.crc32(body.encode()):08x} {body}\n")

    def _write(self, text: str) -> None:
        assert self._stream is not None
        assert self.path is not None
        try:
            self._stream.write(text.encode())
            self._stream.flush()
        except OSError as error:
            raise cannot_write(self.path, error) from None

    def remove(self) -> None:
        """Close the file and remove it, because the search gave no result."""
        self.close()
        if self.path is not None:
            self.path.unlink(missing_ok=True)

    def close(self) -> None:
        """Close the file."""
        if self._stream is not None:
            self._stream.close()


def _record(line: bytes) -> tuple[str, float, Array] | None:
    """Key, time and numbers of a line; `None` if it is incomplete."""
    checksum, _, body = line.partition(b" ")
    if checksum != f"{zlib.crc32(body):08x}".encode():
        return None
    key, seconds, shape, packed = body.decode().split(" ")
    values = np.frombuffer(base64.b64decode(packed), "<f8")
    sizes = [] if shape == "-" else [int(part) for part in shape.split("x")]
    return key, float(seconds), values.reshape(sizes).astype(float)

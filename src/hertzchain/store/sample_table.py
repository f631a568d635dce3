"""Header and samples of a measured file, from which traces and drives are read."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from ..collision import Array
from ..errors import InputError
from ..representation import counted
from .sample_rows import Rows, sample_rows
from .scope_files import header_and_samples, sample

# Parts of a number with a decimal comma, and its exponent.
_INTEGER: Final = re.compile(r"[+-]?\d+(e[+-]?\d+)?", re.IGNORECASE)


@dataclass(frozen=True)
class SampleTable:
    """Header and rows of samples of a file, with the number of the line of each row."""

    header: list[str]
    body: Rows
    lines: list[int]

    def check_rows(self) -> None:
        """Check that all rows have as many cells as the header."""
        for number, row in zip(self.lines, self.body, strict=True):
            if len(row) != len(self.header):
                advice = "complete or remove the line"
                several = len(self.header) < len(row) <= 2 * len(self.header)
                if several and all(map(_INTEGER.fullmatch, row)):
                    advice = "if numbers have decimal commas, separate the columns by semicolons"
                raise InputError(
                    f"line {number} has {counted(len(row), 'cell')}, but the header has "
                    f"{len(self.header)}; {advice}"
                )

    def numbers(self, index: int, name: str) -> Array:
        """Samples of a column: NaN where they are missing, infinite beyond the range."""
        try:
            return np.array([sample(row[index]) for row in self.body])
        except ValueError:
            pass
        for number, row in zip(self.lines, self.body, strict=True):
            try:
                sample(row[index])
            except ValueError:
                raise InputError(
                    f"column {name!r} is {row[index]!r} in line {number}: it must be a number, or "
                    "empty if the sample is missing"
                ) from None
        raise AssertionError


def read_samples(file: Path, example: str) -> SampleTable:
    """Header and samples of a file; ``example`` is a header for messages."""
    rows, lines = sample_rows(file)
    if not rows:
        raise InputError(f"the file has no header; write {example}")
    header, body = header_and_samples(rows, lines)
    if not body:
        raise InputError(
            "the file has a header but no samples; write one row per time below the header"
        )
    return SampleTable(header, body, lines[-len(body) :])

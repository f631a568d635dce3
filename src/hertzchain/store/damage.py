"""The error for a damaged file."""

from __future__ import annotations

import os
from pathlib import Path

from ..errors import InputError


class DamagedFileError(InputError):
    """A file of a store or of a streamed run is missing or was changed after it was written.

    Attributes
    ----------
    file : pathlib.Path
        The file.
    how : str
        Description of the damage.
    place : pathlib.Path
        The store or folder to which it belongs.
    advice : str
        Advice to the user.
    """

    def __init__(self, file: Path, how: str, place: Path, advice: str) -> None:
        inside = file.relative_to(place) if file.is_relative_to(place) else file
        super().__init__(f"{os.fspath(place)!r} is damaged: {inside} {how}; {advice}")
        self.file, self.how, self.place, self.advice = file, how, place, advice

    def among(self, batches: int) -> DamagedFileError:
        """The same error, with the number of damaged batches."""
        if batches < 2:
            return self
        more = "1 more batch" if batches == 2 else f"{batches - 1} more batches"
        how = f"{self.how}, and files of {more} are damaged"
        return DamagedFileError(self.file, how, self.place, self.advice)

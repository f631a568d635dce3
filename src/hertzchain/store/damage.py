"""The error for a file that is not as it was written."""

from __future__ import annotations

import os
from pathlib import Path

from hertzchain.errors import InputError


class DamagedFileError(InputError):
    """A file of a store or of a streamed run that is not as it was written.

    Attributes
    ----------
    file : pathlib.Path
        The file.
    how : str
        What is wrong with it.
    place : pathlib.Path
        The store or folder to which it belongs.
    advice : str
        What to do about it.
    """

    def __init__(self, file: Path, how: str, place: Path, advice: str) -> None:
        inside = file.relative_to(place) if file.is_relative_to(place) else file
        super().__init__(f"{os.fspath(place)!r} is damaged: {inside} {how}; {advice}")
        self.file, self.how, self.place, self.advice = file, how, place, advice

    def among(self, batches: int) -> DamagedFileError:
        """The same error, saying in how many batches files are damaged.

        Parameters
        ----------
        batches : int
            How many there are.

        Returns
        -------
        DamagedFileError

        Examples
        --------
        >>> error = DamagedFileError(Path("s/a"), "is missing", Path("s"), "sweep again")
        >>> print(error.among(3))
        's' is damaged: a is missing, and files of 2 more batches are damaged; sweep again
        """
        if batches < 2:
            return self
        more = "1 more batch" if batches == 2 else f"{batches - 1} more batches"
        how = f"{self.how}, and files of {more} are damaged"
        return DamagedFileError(self.file, how, self.place, self.advice)

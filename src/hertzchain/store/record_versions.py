"""Versions of the records in stored runs and states, and the check of those of a file."""

from __future__ import annotations

from typing import Final

from .. import __version__
from ..errors import InputError, InputWarning, warn_user

# Increased whenever an array of a run or state gets another meaning, type or shape.
RECORDS_VERSION: Final = 1


def check_records(what: str, found: object, version: object, advice: str) -> None:
    """Reject records of another version, and warn if another version of hertzchain wrote them."""
    # Text in files of states, a NumPy number in netCDF files.
    if str(found) != str(RECORDS_VERSION):
        raise InputError(
            f"{what} was written by hertzchain {version} with version {found} of the records, but "
            f"hertzchain {__version__} reads version {RECORDS_VERSION}; {advice}"
        )
    if version != __version__:
        warn_user(
            f"{what} was written by hertzchain {version}, this is {__version__}: the stored values "
            "are unchanged, but results computed from them, and a run that is resumed from its "
            "state, may differ from those of that version",
            InputWarning,
        )

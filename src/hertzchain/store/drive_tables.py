"""Drives of chain files: numbers of the file itself, or a measured signal in another file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from ..chain.drives import Drive, SineBurst, StepDrive, TableDrive
from ..errors import InputError
from .chain_schema import SIGNAL_KEYS
from .drive_files import load_drive

DRIVES: Final[Mapping[str, type[Drive]]] = {
    "sine-burst": SineBurst,
    "step": StepDrive,
    "table": TableDrive,
}


def drive_from(entry: dict[str, Any], folder: Path) -> Drive:
    """The drive of a chain file in a folder."""
    kind = entry.pop("kind")
    if "file" in entry:
        if own := [key for key in entry if key != "file" and key not in SIGNAL_KEYS]:
            raise InputError(
                f"[chain.drive] has file and also {', '.join(own)}: omit "
                f"{'it' if len(own) == 1 else 'them'}, because the file and its gain state this"
            )
        return load_drive(folder / entry.pop("file"), **entry)
    if own := [key for key in entry if key in SIGNAL_KEYS]:
        raise InputError(
            f"[chain.drive] has {', '.join(own)}, but no file: these keys describe the signal "
            "of a file"
        )
    for key in ("times", "values") if kind == "table" else ():
        if key not in entry:
            raise InputError(f"[chain.drive] has no {key}; a table has times and values or a file")
    return DRIVES[kind](**entry)

"""The manifest of a streamed run: a list of the parts in its folder, each with a digest.

The manifest is replaced as a whole before a part is written, to announce it, and again when the
state after the part is stored.  Each existing part is therefore listed, even if the process was
killed, and an unlisted part is a foreign file.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Final

from .. import __version__
from ..collision import Array
from ..errors import InputError
from .damage import DamagedFileError
from .digests import document_digest
from .writing import write_bytes

SCHEMA: Final = "hertzchain stream 3"
MANIFEST_FILE: Final = "manifest.json"
RESTORE: Final = "restore it from a copy, or stream again into another folder"
SKIP: Final = f"skip_damaged=True reads the other parts; to read all parts, {RESTORE}"


@dataclass(frozen=True)
class Part:
    """One file of a streamed run.

    Attributes
    ----------
    file : str
        Name of the file.
    sha256 : str
        Digest of its content.
    times : int
        Number of saved times.
    first, last : float
        The first and the last of them [scaled, or s].
    """

    file: str
    sha256: str
    times: int
    first: float
    last: float

    @classmethod
    def of(cls, number: int, content: bytes, times: Array) -> Part:
        """The part with this number and content."""
        digest = hashlib.sha256(content).hexdigest()
        return cls(part_name(number), digest, len(times), float(times[0]), float(times[-1]))

    def content(self, folder: Path) -> bytes:
        """Read the file and compare it with its digest."""
        file = folder / self.file
        try:
            content = file.read_bytes()
        except FileNotFoundError:
            raise DamagedFileError(file, "is missing", folder, SKIP) from None
        except OSError as error:
            how = f"cannot be read ({error.strerror})"
            raise DamagedFileError(file, how, folder, SKIP) from None
        if hashlib.sha256(content).hexdigest() != self.sha256:
            raise DamagedFileError(file, "is not as it was written", folder, SKIP)
        return content


@dataclass(frozen=True)
class Manifest:
    """List of the files in the folder of a streamed run.

    Attributes
    ----------
    chain : str
        Fingerprint of the chain.
    rtol : float
        Tolerated error of a step.
    chain_file : str
        The chain as a chain file; empty if it has none.
    method : str
        ``"adaptive"``, or the method of fixed steps.
    step : float
        Fixed step [scaled, or s]; 0 for the adaptive method.
    parts : tuple of Part
        Existing files, in order of time.
    announced : Part, optional
        The next file, which may or may not exist.
    """

    chain: str
    rtol: float
    chain_file: str = ""
    method: str = "adaptive"
    step: float = 0.0
    parts: tuple[Part, ...] = ()
    announced: Part | None = None

    @property
    def options(self) -> dict[str, Any]:
        """Options of `simulate` with which the run continues."""
        if self.step > 0.0:
            return {"method": self.method, "step": self.step}
        return {"rtol": self.rtol}

    def present(self, folder: Path) -> tuple[Part, ...]:
        """The parts, including the announced one if its file exists."""
        if self.announced is not None and (folder / self.announced.file).exists():
            return (*self.parts, self.announced)
        return self.parts

    def announcing(self, part: Part) -> Manifest:
        """The manifest that announces a part that is about to be written."""
        return replace(self, announced=part)

    def written(self) -> Manifest:
        """The manifest after the announced part was written."""
        more = () if self.announced is None else (self.announced,)
        return replace(self, parts=(*self.parts, *more), announced=None)

    def without_last(self) -> Manifest:
        """The manifest with the last part announced again; its file may then be removed."""
        return replace(self, parts=self.parts[:-1], announced=self.parts[-1])

    def save(self, folder: Path) -> None:
        """Replace the manifest of a folder."""
        document: dict[str, Any] = {"schema": SCHEMA, "hertzchain_version": __version__}
        document |= asdict(self)
        document["sha256"] = document_digest(document)
        write_bytes(folder / MANIFEST_FILE, json.dumps(document, indent=1).encode())


def part_name(number: int) -> str:
    """Name of the file of a part."""
    return f"part-{number:06d}.nc"


def load_manifest(folder: Path) -> Manifest:
    """Read the manifest of a folder, and check that its parts are consecutive."""
    file = folder / MANIFEST_FILE
    try:
        document = json.loads(file.read_bytes())
        digest = document.pop("sha256")
        whole = digest == document_digest(document)
    except FileNotFoundError:
        raise InputError(
            f"{os.fspath(folder)!r} has no {MANIFEST_FILE}: it is not a run of stream, or the "
            f"file was lost; in that case, {RESTORE}"
        ) from None
    except OSError as error:
        how = f"cannot be read ({error.strerror})"
        raise DamagedFileError(file, how, folder, RESTORE) from None
    except (ValueError, TypeError, LookupError, AttributeError, RecursionError):
        whole = False
    if not whole:
        raise DamagedFileError(file, "is not as it was written", folder, RESTORE)
    if document["schema"] != SCHEMA:
        raise InputError(
            f"{os.fspath(folder)!r} has the layout {document['schema']!r} of another version of "
            f"hertzchain, but this version reads {SCHEMA!r}; use the other version"
        )
    return _manifest_from(file, document)


def _manifest_from(file: Path, document: Mapping[str, Any]) -> Manifest:
    parts = tuple(Part(**part) for part in document["parts"])
    announced = None if document["announced"] is None else Part(**document["announced"])
    all_parts = parts if announced is None else (*parts, announced)
    for number, part in enumerate(all_parts, start=1):
        behind = number == 1 or all_parts[number - 2].last < part.first
        if part.file != part_name(number) or not behind:
            how = f"lists {part.file} as part {number}, from t = {part.first:g} on: parts overlap"
            raise DamagedFileError(file, how, file.parent, RESTORE)
    return Manifest(
        document["chain"], document["rtol"], document["chain_file"], document["method"],
        document["step"], parts, announced,
    )  # fmt: skip

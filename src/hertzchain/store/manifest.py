"""The manifest of a streamed run: which parts its folder must hold, each with a digest.

It is replaced as a whole before a part is written, which it then announces, and again when the
state that follows the part is stored: so each part that is there is listed, whenever the writer
was killed, and a part that is not listed is somebody else's file.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Final

from hertzchain import __version__
from hertzchain.contacts import Array
from hertzchain.errors import InputError
from hertzchain.store.damage import DamagedFileError
from hertzchain.store.writing import write_bytes

SCHEMA: Final = "hertzchain stream 1"
MANIFEST_FILE: Final = "manifest.json"
RESTORE: Final = "restore it from a copy, or stream again into another folder"
SKIP: Final = f"skip_damaged=True reads the other parts; to have all of them, {RESTORE}"


@dataclass(frozen=True)
class Part:
    """One file of a streamed run.

    Attributes
    ----------
    file : str
        Its name.
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
        """The part with this number and content.

        Parameters
        ----------
        number : int
            Its number, from 1.
        content : bytes
            Content of the file.
        times : ndarray
            Saved times in it.

        Returns
        -------
        Part

        Examples
        --------
        >>> import numpy as np
        >>> Part.of(1, b"", np.array([0.0, 2.0])).file
        'part-000001.nc'
        """
        digest = hashlib.sha256(content).hexdigest()
        return cls(part_name(number), digest, len(times), float(times[0]), float(times[-1]))

    def content(self, folder: Path) -> bytes:
        """Content of the file, if it is as it was written.

        Parameters
        ----------
        folder : pathlib.Path
            Where it is.

        Returns
        -------
        bytes

        Raises
        ------
        InputError
            If the file is missing or altered.

        Examples
        --------
        >>> import tempfile
        >>> import numpy as np
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     _ = (Path(folder) / "part-000001.nc").write_bytes(b"abc")
        ...     Part.of(1, b"abc", np.array([0.0])).content(Path(folder))
        b'abc'
        """
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
    """What the folder of a streamed run must hold.

    Attributes
    ----------
    chain : str
        Fingerprint of the chain.
    rtol : float
        Tolerated error of a step.
    parts : tuple of Part
        Files that are there, in order of time.
    announced : Part, optional
        The next file: it may be there or not.
    """

    chain: str
    rtol: float
    parts: tuple[Part, ...] = ()
    announced: Part | None = None

    def present(self, folder: Path) -> tuple[Part, ...]:
        """The parts, with the announced one if its file is there.

        Parameters
        ----------
        folder : pathlib.Path
            Where they are.

        Returns
        -------
        tuple of Part

        Examples
        --------
        >>> Manifest("", 1e-13).present(Path("run"))
        ()
        """
        if self.announced is not None and (folder / self.announced.file).exists():
            return (*self.parts, self.announced)
        return self.parts

    def announcing(self, part: Part) -> Manifest:
        """With a part that is about to be written.

        Parameters
        ----------
        part : Part
            The part.

        Returns
        -------
        Manifest

        Examples
        --------
        >>> import numpy as np
        >>> Manifest("", 1e-13).announcing(Part.of(1, b"", np.array([0.0]))).parts
        ()
        """
        return replace(self, announced=part)

    def written(self) -> Manifest:
        """With the announced part among those that are there.

        Returns
        -------
        Manifest

        Examples
        --------
        >>> import numpy as np
        >>> manifest = Manifest("", 1e-13).announcing(Part.of(1, b"", np.array([0.0])))
        >>> len(manifest.written().parts)
        1
        """
        more = () if self.announced is None else (self.announced,)
        return replace(self, parts=(*self.parts, *more), announced=None)

    def without_last(self) -> Manifest:
        """With the last part announced again, so that its file may be removed.

        Returns
        -------
        Manifest

        Examples
        --------
        >>> import numpy as np
        >>> manifest = Manifest("", 1e-13).announcing(Part.of(1, b"", np.array([0.0]))).written()
        >>> manifest.without_last().parts
        ()
        """
        return replace(self, parts=self.parts[:-1], announced=self.parts[-1])

    def save(self, folder: Path) -> None:
        """Replace the manifest of a folder.

        Parameters
        ----------
        folder : pathlib.Path
            Where it is.

        Raises
        ------
        InputError, StoreError
            If it cannot be written.

        Examples
        --------
        >>> import tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     Manifest("", 1e-13).save(Path(folder))
        ...     load_manifest(Path(folder)).parts
        ()
        """
        document: dict[str, Any] = {"schema": SCHEMA, "hertzchain_version": __version__}
        document |= asdict(self)
        document["sha256"] = _digest(document)
        write_bytes(folder / MANIFEST_FILE, json.dumps(document, indent=1).encode())


def part_name(number: int) -> str:
    """Name of a file.

    Parameters
    ----------
    number : int
        Its number, from 1.

    Returns
    -------
    str

    Examples
    --------
    >>> part_name(12)
    'part-000012.nc'
    """
    return f"part-{number:06d}.nc"


def load_manifest(folder: Path) -> Manifest:
    """Read the manifest of a folder, and check that its parts follow each other.

    Parameters
    ----------
    folder : pathlib.Path
        Folder of a streamed run.

    Returns
    -------
    Manifest

    Raises
    ------
    InputError
        If there is none, or it is not as it was written.

    Examples
    --------
    See `Manifest.save`.
    """
    file = folder / MANIFEST_FILE
    try:
        document = json.loads(file.read_bytes())
        digest = document.pop("sha256")
        whole = digest == _digest(document)
    except FileNotFoundError:
        raise InputError(
            f"{os.fspath(folder)!r} holds no {MANIFEST_FILE}: it is no run of stream, or {RESTORE}"
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
            f"hertzchain, and this version reads {SCHEMA!r}: use the other version"
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
    return Manifest(document["chain"], document["rtol"], parts, announced)


def _digest(document: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()

"""The folder of a report: which of its files hertzchain wrote and may therefore replace."""

from __future__ import annotations

import contextlib
import json
import os
import re
import shutil
import tempfile
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from ..errors import InputError
from ..representation import listed
from ..store.digests import file_digest
from ..store.file_lock import lock
from ..store.writing import cannot_write, replace_file

PAGES: Final = ("report.html", "verdict.json", "summary.md")
WRITING: Final = ".writing-"
# Names given by `tempfile`.
LEFT_BEHIND: Final = re.compile(rf"{re.escape(WRITING)}[a-z0-9_]{{8}}")
OUR_FIGURE: Final = re.compile(r"(figure\d+|errata|scoreboard)\.(svg|png|csv)")
MANIFEST: Final = ".hertzchain.json"
HINT: Final = "choose another folder with --out"


@dataclass(frozen=True)
class Manifest:
    """Parts of the report in a folder, and the SHA-256 digests of files that were written to it."""

    parts: tuple[str, ...] = ()
    # A process that is killed while it moves files leaves old and new ones; both are listed.
    files: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def write(self, beside: Path, out: Path) -> None:
        """Write the manifest of a folder completely or not at all."""
        content = {"schema_version": 1, "parts": self.parts, "files": dict(self.files)}
        replace_file(beside / MANIFEST, out / MANIFEST, json.dumps(content, indent=1).encode())


def read_manifest(out: Path) -> Manifest:
    """Manifest of a folder; it is empty in a new folder."""
    try:
        content = json.loads((out / MANIFEST).read_bytes())
        files = {str(name): tuple(digests) for name, digests in content["files"].items()}
        return Manifest(tuple(content["parts"]), files)
    except FileNotFoundError:
        return Manifest()
    except (ValueError, TypeError, KeyError, AttributeError):
        raise InputError(
            f"{os.fspath(out / MANIFEST)!r} is damaged, so it is unknown which files of the "
            f"folder may be replaced; {HINT}"
        ) from None


def files_of(parts: Collection[str]) -> list[str]:
    """Files of a report, by their path in its folder."""
    names = list(PAGES)
    for part in sorted(parts):
        endings = ("svg", "png") if part == "errata" else ("svg", "png", "csv")
        names += [
            f"figures/{part}.{ending}"
            for ending in endings
            if OUR_FIGURE.fullmatch(f"{part}.{ending}")
        ]
    return names


@contextlib.contextmanager
def reserved(out: Path, parts: Collection[str] = ()) -> Iterator[None]:
    """Lock a folder, check that these parts can be written to it, and remove temporary files."""
    try:
        _check_origin(out)
        out.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=out):
            pass
    except OSError as error:
        raise cannot_write(out, error, HINT) from None
    with lock(out / ".lock", out):
        check_replaceable(out, files_of(parts), read_manifest(out))
        for left in out.glob(f"{WRITING}*"):
            if _is_left_behind(left):
                shutil.rmtree(left, ignore_errors=True)
        yield


def _check_origin(out: Path) -> None:
    """Raise an error for a folder with files that was not written by hertzchain."""
    if not out.exists() or (out / MANIFEST).exists():
        return
    others = [path for path in out.iterdir() if path.name != ".lock" and not _is_left_behind(path)]
    if others:
        raise InputError(
            f"{os.fspath(out)!r} contains {min(path.name for path in others)!r} and was not "
            "written by `hertzchain reproduce`; choose a new or empty folder with --out"
        )


def check_replaceable(out: Path, names: Iterable[str], manifest: Manifest) -> None:
    """Raise an error if one of these files is not as hertzchain wrote it."""
    for place in (out / "figures", *(out / name for name in names)):
        if not os.path.lexists(place):
            continue
        name = place.relative_to(out).as_posix()
        ours = (
            place.is_dir()
            if name == "figures"
            else place.is_file() and file_digest(place) in manifest.files.get(name, ())
        )
        if not ours:
            raise InputError(
                f"{os.fspath(place)!r} was not written by hertzchain or has been changed since, "
                "and would be replaced; rename it, or choose another folder with --out"
            )


def move_report(fresh: Path, out: Path, parts: Collection[str]) -> None:
    """Move the files of a new report to its folder; all other files there are kept."""
    old = read_manifest(out)
    new = {name: file_digest(fresh / name) for name in files_of(parts)}
    check_replaceable(out, new, old)
    both = {name: (*old.files.get(name, ()), written) for name, written in new.items()}
    Manifest(old.parts, {**old.files, **both}).write(fresh, out)
    (out / "figures").mkdir(exist_ok=True)
    for name in new:
        (fresh / name).replace(out / name)
    files = {**old.files, **{name: (written,) for name, written in new.items()}}
    Manifest(tuple(parts), files).write(fresh, out)


def earlier_figures(out: Path, parts: Collection[str]) -> list[str]:
    """Parts whose figures are in a folder, and are not replaced by a report of these parts."""
    paths = [out / name for name in read_manifest(out).files if name.startswith("figures/")]
    kept = {path.stem for path in paths if path.exists() and path.stem not in parts}
    return sorted(kept, key=lambda part: (len(part), part))


def replaced_report(out: Path, parts: Collection[str]) -> str:
    """Sentence on an earlier report with further parts, which a report of these parts replaces."""
    lost = [part for part in read_manifest(out).parts if part not in parts]
    if not lost:
        return ""
    shown = listed(lost) if len(lost) <= 5 else f"{len(lost)} other parts"
    kept = (
        f"; its figures are kept in {os.fspath(out / 'figures')}"
        if earlier_figures(out, parts)
        else ""
    )
    return f"The report replaces an earlier one that also contained {shown}{kept}."


def _is_left_behind(folder: Path) -> bool:
    """Whether a folder is the temporary folder of a process that was killed."""
    if folder.is_symlink() or not LEFT_BEHIND.fullmatch(folder.name):
        return False
    files = [path for path in folder.rglob("*") if not path.is_dir()]
    pages = [folder / name for name in (*PAGES, MANIFEST)]
    figures = folder / "figures"
    return all(
        file in pages or (file.parent == figures and OUR_FIGURE.fullmatch(file.name))
        for file in files
    )

"""Columns of files that are read as sensors, chosen by name of the column or of the file."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Final, TypeAlias

from ..errors import InputError, errors_at, unknown_name_error
from ..store.csv_tables import split_header
from ..validation.objects import check_list, shown_path, text
from .headers import without_unit
from .places import place_named

# Column, as it is written, and place of each sensor to read, by the key of the column.
Sensors: TypeAlias = dict[str, tuple[str, str]] | None
PathLike: TypeAlias = str | os.PathLike[str]
# Columns that are not sensors.
OTHERS: Final = ("time", "shot")
CHANNELS: Final = "give channels=True (on the command line: --channels)"


def key_of(header: str) -> str:
    """Name of a column without its unit and spelling: that of its place, if it names one."""
    name, _ = split_header(header) or (" ".join(header.lower().split()), None)
    try:
        return place_named(name).name
    except InputError:
        return name


def wanted_columns(
    sensors: object, paths: Sequence[PathLike], headers: Sequence[list[str]], *, channels: bool
) -> list[Sensors]:
    """Sensors to read from each file; `None` for all of its columns.

    ``channels`` states whether several files are channels of one shot.
    """
    if channels:
        _check_files(paths)
    if sensors is None:
        own: list[Sensors] = [None] * len(paths)
    else:
        own = _own_columns(_pairs(sensors), paths, headers, channels=channels)
    if channels:
        _check_shared(own, paths, headers)
    return own


def _pairs(sensors: object) -> list[tuple[str, str]]:
    """Column or file, as it is written, and place of each sensor."""
    if isinstance(sensors, Mapping):
        pairs = [
            (text("column of a sensor", column), text("place of a sensor", place))
            for column, place in sensors.items()
        ]
    else:
        names = [text("sensor", each) for each in check_list("sensors", sensors, "'ball 6'")]
        pairs = [(name, name) for name in names]
    known: dict[str, str] = {}
    for written, place in pairs:
        name = key_of(place)
        if written == known.get(name):
            raise InputError(f"sensor {written!r} is given twice; give it once")
        if name in known and name != "time":
            raise InputError(
                f"{name} is given for {known[name]!r} and for {written!r}; give each sensor its "
                "own place"
            )
        known[name] = written
    return pairs


def _own_columns(
    pairs: Sequence[tuple[str, str]],
    paths: Sequence[PathLike],
    headers: Sequence[list[str]],
    *,
    channels: bool,
) -> list[Sensors]:
    """Sensors of each file: those of columns in any file, and those that name the file."""
    present = {key_of(full) for header in headers for full in header}
    general: list[tuple[str, str]] = []
    named: list[list[tuple[str, str, str]]] = [[] for _ in paths]
    for written, place in pairs:
        where = None if key_of(written) in present else _file_and_column(written, paths)
        if where is None:
            general.append((written, place))
            continue
        if len(paths) > 1 and not channels:
            raise InputError(
                f"sensor {written!r} is that of one file; if the files are channels of one shot, "
                f"{CHANNELS}"
            )
        at, column = where
        named[at].append((written, column, "" if place == written else place))
    if channels:
        _check_channels(general, headers)
    else:
        _check_shots(general, headers)
    times_only = _names_times_only(pairs)
    own: list[Sensors] = []
    for path, header, theirs in zip(paths, headers, named, strict=True):
        with errors_at(shown_path(path)):
            keys = {key_of(full) for full in header}
            common = [each for each in general if not channels or key_of(each[0]) in keys]
            found = _of_file(common, theirs, header, path)
            own.append(found)
            if channels and not times_only and _names_times_only(found.values()):
                raise InputError(
                    "no sensor of this file is given; leave out the file, or give load_traces "
                    f"sensors={{{_short_name(path, paths)!r}: 'wall'}}"
                )
    return own


def _names_times_only(pairs: Iterable[tuple[str, str]]) -> bool:
    """Whether no sensor is chosen, so that all columns are read."""
    return all(key_of(place) == "time" for _, place in pairs)


def _of_file(
    common: Sequence[tuple[str, str]],
    named: Sequence[tuple[str, str, str]],
    header: list[str],
    path: PathLike,
) -> dict[str, tuple[str, str]]:
    """Sensors of one file by the keys of their columns."""
    times = [key_of(column) for column, place in common if key_of(place) == "time"]
    times += [key_of(column) for _, column, place in named if column and key_of(place) == "time"]
    given = [(column, column, place) for column, place in common]
    for written, column, place in named:
        found = column or _only_signal(header, times, path)
        given.append((written, found, place or found))
    own: dict[str, tuple[str, str]] = {}
    spelled: dict[str, str] = {}
    for written, column, place in given:
        key = key_of(column)
        if key in own:
            raise InputError(
                f"column {without_unit(column)!r} is given twice, as {spelled[key]!r} and as "
                f"{written!r}; keep one"
            )
        own[key], spelled[key] = (column, place), written
    return own


def _only_signal(header: list[str], times: Sequence[str], path: PathLike) -> str:
    """The column of a file that is neither times nor shots."""
    columns = [full for full in header if key_of(full) not in (*OTHERS, *times)]
    if len(columns) == 1 or (columns and "time" not in {*map(key_of, header)} and not times):
        return columns[-1]  # A missing column of times is reported later.
    if not columns:
        raise InputError("the file has no column of samples; add one, such as 'ball 6 [N]'")
    names = [without_unit(each) for each in columns]
    raise InputError(
        f"the file has {len(columns)} columns of samples, {', '.join(names)}; name one, as in "
        f"'{Path(path).name}:{names[0]}'"
    )


def _file_and_column(written: str, paths: Sequence[PathLike]) -> tuple[int, str] | None:
    """Index of the file that is named, and the name of its column, which may be empty."""
    ends = (at for at in range(len(written), 0, -1) if written[at : at + 1] in ("", ":"))
    for end in ends:
        name = written[:end].strip()
        same = [at for at, path in enumerate(paths) if Path(path) == Path(name)]
        same = same or [at for at, path in enumerate(paths) if Path(path).name == name]
        if len(same) > 1:
            raise InputError(
                f"{len(same)} files are called {name!r}; write the path, such as "
                f"{os.fspath(paths[same[0]])!r}"
            )
        if same:
            return same[0], written[end + 1 :].strip()
    name = written.partition(":")[0].strip()
    if Path(name).suffix and Path(name).suffix.lower() in {
        Path(each).suffix.lower() for each in paths
    }:
        raise unknown_name_error("file of a sensor", name, [Path(each).name for each in paths])
    return None


def _short_name(path: PathLike, paths: Sequence[PathLike]) -> str:
    """The name of a file, or its path if another one has this name."""
    name = Path(path).name
    return name if [Path(each).name for each in paths].count(name) == 1 else os.fspath(path)


def _check_files(paths: Sequence[PathLike]) -> None:
    known: list[Path] = []
    for each in map(Path, paths):
        if each in known:
            raise InputError(f"{shown_path(each)} is given twice; give the file of a channel once")
        known.append(each)


def _check_channels(general: Sequence[tuple[str, str]], headers: Sequence[list[str]]) -> None:
    """Check that each column is in one of several files."""
    present = {key_of(full): without_unit(full) for header in headers for full in header}
    for written, _ in general:
        if key_of(written) not in present:
            others = ", ".join(own for key, own in present.items() if key not in OTHERS)
            raise InputError(f"there is no column {written!r}; the files have {others}")


def _check_shots(general: Sequence[tuple[str, str]], headers: Sequence[list[str]]) -> None:
    """Reject files that seem to be channels of one shot: one of them lacks a sensor of another."""
    names = [{key_of(full) for full in header} for header in headers]
    for written, _ in general:
        key = key_of(written)
        if any(key in own for own in names) and not all(key in own for own in names):
            raise InputError(
                f"column {written!r} is not in all files; if they are channels of one shot, "
                f"{CHANNELS}"
            )


def _check_shared(
    own: Sequence[Sensors], paths: Sequence[PathLike], headers: Sequence[list[str]]
) -> None:
    """Reject a column that would be read from two channels as the same sensor."""
    known: dict[tuple[str, str], PathLike] = {}
    for path, header, sensors in zip(paths, headers, own, strict=True):
        for full in header:
            key = key_of(full)
            given = (sensors or {}).get(key)
            place = key if given is None else key_of(given[1])
            every = sensors is None or _names_times_only(sensors.values())
            if key in OTHERS or place == "time" or (given is None and not every):
                continue
            if (key, place) in known:
                first, second = (_short_name(each, paths) for each in (known[key, place], path))
                raise InputError(
                    f"column {without_unit(full)!r} is in {first} and in {second}; give each file "
                    f"its own place, as in sensors={{{first!r}: 'wall', {second!r}: 'ball 6'}}"
                )
            known[key, place] = path

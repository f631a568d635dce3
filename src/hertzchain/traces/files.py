"""Read traces from CSV files."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from ..collision import Array
from ..errors import InputError, errors_at
from ..store.csv_tables import split_header
from ..store.sample_table import SampleTable, read_samples
from ..store.scope_files import WORDS
from ..units import UNITS, converted
from ..validation.keywords import checked_arguments
from ..validation.objects import check_bool, file_path, shown_path
from .headers import check_header, header_of, other_unit_error, without_unit
from .noise import check_names_of_noise
from .places import Place
from .shots import check_times, make_shot
from .signals import Shot
from .traces import Traces, merged, with_coupling
from .wanted_columns import Sensors, key_of, wanted_columns

# Samples of a sensor that all increase are times if there are at least as many.
MANY: Final = 10


@checked_arguments("load_traces")
def load_traces(
    *paths: str | os.PathLike[str],
    sensors: Sequence[str] | Mapping[str, str] | None = None,
    channels: bool = False,
    noise: float | Mapping[str, float] | None = None,
    coupling: str | Mapping[str, str] | None = None,
) -> Traces:
    r"""Read measured traces from CSV files, those of oscilloscopes included.

    The header of a file is, for example, ``time [us], ball 6 [N], ball 11 [mV], wall [N],
    ball 3 velocity [m/s]``.  Balls are counted without the strikers (``bead 7`` counts them), and
    a force in a ball, or in a ``cap``, is the mean of the forces on its two sides.  Units may also
    be in parentheses, as in ``Time (s)``, or in a row of their own below the names, as in
    ``second,Volt``, and the times may be called ``t``.  Lines above the header, such as the
    settings of an oscilloscope, are not read, except ``Horizontal Units`` and ``Vertical Units``.
    Columns may also be separated by semicolons, tabs or spaces, and numbers may have decimal
    commas.
    Sampling may be uneven.  Empty cells are missing samples; those with an infinity sign are beyond
    the range of the digitiser.  So are those with 9.9E37 or -9.9E37, and 9.91E37 is a missing
    sample, which are the conventions of SCPI instruments.  Saturated samples are recognised and not
    used.  A column ``shot`` with whole numbers divides a file into shots.

    Parameters
    ----------
    *paths : path-like
        Files, one per shot or channel, or with several shots if they have a column ``shot``.
    sensors : sequence of str or mapping, optional
        Names of the sensors to read, such as ``["ball 6", "wall"]``; by default all.  A mapping
        from names of columns to places reads files with other names, such as
        ``{"Force": "wall", "CH2": "ball 6 [V]"}``; the place has a unit if the file has none.
        ``{"X": "time [s]"}`` names the column of the times.  If the columns of several files have
        the same name, name the files: ``{"ch1.csv": "wall", "ch2.csv": "ball 6"}``, or
        ``"ch1.csv:Volt"`` if a file has several columns of samples.
    channels : bool
        Whether the files have different sensors in the same shots, such as one file for each
        channel of an oscilloscope, instead of different shots.
    noise : float or mapping, optional
        Standard deviation of the noise of all sensors, or by name, in N, m/s or V or with a
        unit, such as ``"3 mV"``; the name ``"*"`` has all others.  By default it is estimated for
        each sensor from the samples before its own pulse arrives.
    coupling : {"AC", "DC"} or mapping, optional
        Whether the signals of all sensors, or by name, contain the static force of a precompressed
        chain (``"DC"``) or not (``"AC"``, also for piezoelectric sensors).  By default, this is
        decided by their mean before the pulse.

    Returns
    -------
    Traces

    Raises
    ------
    InputError
        If a file is missing or unreadable, has no column of times, an unknown name or a wrong
        unit, times that do not increase, no samples before the pulse, or a sensor that is
        saturated during most of its pulse.  The message names the file.

    Examples
    --------
    >>> import hertzchain as hc, tempfile
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "data.csv"
    ...     _ = file.write_text("time [us],wall [N]\n0,0.0\n1,4.0\n2,0.5\n")
    ...     hc.load_traces(file, noise=0.1)
    Traces(1 shot, wall: 3 samples, every 1 us; noise 0.1 N)

    A file of an oscilloscope, with settings above the header, and without places and units:

    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "scope.csv"
    ...     _ = file.write_text("Model,X1\nTIME,CH1,CH2\n0,0.0,1\n1e-6,4.0,1\n2e-6,0.5,1\n")
    ...     places = {"TIME": "time [s]", "CH1": "wall [V]"}
    ...     hc.load_traces(file, sensors=places, noise=0.1)
    Traces(1 shot, wall: 3 samples, every 1 us; noise 100 mV)
    """
    if not paths:
        raise InputError("give load_traces at least one file, such as 'data.csv'")
    channels = check_bool("channels", channels) and len(paths) > 1
    tables = [_table(path, sensors) for path in paths]
    headers = [table.header for table in tables]
    wanted = wanted_columns(sensors, paths, headers, channels=channels)
    found: Traces | None = None
    for path, table, own in zip(paths, tables, wanted, strict=True):
        with errors_at(shown_path(path)):
            source = (os.path.realpath(path),)
            shots = (replace(shot, files=source) for shot in _shots(table, own, noise))
            part = Traces(tuple(shots))
            if found is not None:
                part = merged(found, part, "channels") if channels else found + part
        found = part
    assert found is not None
    check_names_of_noise(noise, found.names)
    return with_coupling(found, coupling)


def _table(
    path: str | os.PathLike[str], sensors: Sequence[str] | Mapping[str, str] | None
) -> SampleTable:
    """Header and samples of a file."""
    file = file_path("file of traces", path)
    if file.suffix.lower() == ".toml":
        raise InputError(
            f"{shown_path(path)} is a chain file, where a CSV file of traces is required; give "
            "the traces first and the chain file last, as in data.csv chain.toml"
        )
    with errors_at(shown_path(path)):
        table = read_samples(file, "time [us], ball 6 [N], ...")
        check_header(table.header, sensors)
        return table


def _shots(
    table: SampleTable, wanted: Sensors, noise: float | Mapping[str, float] | None
) -> list[Shot]:
    header = table.header
    table.check_rows()
    header, wanted = _with_times(header, wanted)
    time, shot, columns = _columns(header, wanted)
    unit = _unit_of_times(header[time])
    factor = converted("column 'time'", 1.0, unit, "s")
    times = table.numbers(time, header[time])
    samples = {
        key: own * table.numbers(index, header[index]) for key, (index, own) in columns.items()
    }
    labels = np.ones(len(times)) if shot is None else table.numbers(shot, "shot")
    lines = np.array(table.lines)
    if not np.isfinite(labels).all():
        raise InputError(f"line {lines[np.argmin(np.isfinite(labels))]} has no shot")
    if len(parts := np.flatnonzero(labels != np.round(labels))):
        raise InputError(
            f"the shot of line {lines[parts[0]]} is {labels[parts[0]]:g}, but shots have whole "
            "numbers, such as 1 and 2"
        )
    shots = []
    for label in np.unique(labels):
        own = labels == label
        _check_exchange(times[own], {each.name: v[own] for (each, _), v in samples.items()})
        check_times(times[own], unit, lines[own])
        shots.append(make_shot(factor * times[own], {k: v[own] for k, v in samples.items()}, noise))
    return shots


def _check_exchange(times: Array, samples: Mapping[str, Array]) -> None:
    """Reject times that do not increase if the samples of a sensor do, as times would."""
    if len(times) < MANY or np.all(np.diff(times) > 0.0):
        return
    for name, values in samples.items():
        if np.all(np.diff(values) > 0.0):
            raise InputError(
                f"the times do not increase, but all samples of {name} do: the headers of these "
                "two columns may be exchanged"
            )


def _with_times(header: list[str], wanted: Sensors) -> tuple[list[str], Sensors]:
    """The header with the column that is given as that of the times, and the other sensors."""
    if wanted is None:
        return header, None
    place = {key: place for key, (_, place) in wanted.items() if key_of(place) == "time"}
    others = {key: each for key, each in wanted.items() if key not in place}
    header = [_with_unit_of(full, place.get(key_of(full))) for full in header]
    return header, others or None


def _with_unit_of(header: str, time: str | None) -> str:
    if time is None:
        return header
    given, own = ((split_header(each) or ("", None))[1] for each in (time, header))
    if given and own and _differ(given, own):
        raise other_unit_error(header, own, time, "times are")
    unit = given or own
    return f"time [{unit}]" if unit else "time"


def _differ(unit: str, other: str) -> bool:
    """Whether two units of time differ, which may be spelled as words or in other letters."""
    one, two = (WORDS.get(each.lower(), each) for each in (unit, other))
    if not {one, two} <= {*UNITS["time"]}:
        return False
    return converted("time", 1.0, one, "s") != converted("time", 1.0, two, "s")


def _columns(
    header: list[str], wanted: Sensors
) -> tuple[int, int | None, dict[tuple[Place, str], tuple[int, float]]]:
    """Column of the times, of the shots if there is one, and of each sensor with its factor."""
    names = [key_of(full) for full in header]
    if names.count("time") != 1:
        raise InputError(
            f"there must be one column of times, such as 'time [us]' or 'Time (s)', among "
            f"{', '.join(header)}{_other_name_of_times(header, wanted)}"
        )
    columns: dict[tuple[Place, str], tuple[int, float]] = {}
    signals = {
        name: without_unit(full)
        for name, full in zip(names, header, strict=True)
        if name not in ("time", "shot")
    }
    for name, (written, _) in (wanted or {}).items():
        if name not in signals:
            raise InputError(
                f"there is no column {written!r}; the file has {', '.join(signals.values())}"
            )
    for index, (name, full) in enumerate(zip(names, header, strict=True)):
        if name not in signals or (wanted is not None and name not in wanted):
            continue
        place, unit, factor = header_of(full, None if wanted is None else wanted[name][1])
        if place.name in [known.name for known, _ in columns]:
            raise InputError(f"there are two columns of {place.name!r}; keep one")
        columns[place, unit] = index, factor
    return names.index("time"), names.index("shot") if "shot" in names else None, columns


def _other_name_of_times(header: list[str], wanted: Sensors) -> str:
    """How to give the first column without a unit that has no place as that of the times."""
    others = {"time", "shot", *(wanted or ())}
    for full in header:
        name = key_of(full)
        if full and name not in others and not (split_header(full) or ("", ""))[1]:
            given = f"{{{full!r}: 'time [ms]'}}"
            return f"; if it is {full!r}, give load_traces sensors={given}, with its unit"
    return ""


def _unit_of_times(header: str) -> str:
    _, unit = split_header(header) or (header, None)
    if not unit:
        raise InputError(
            f"column {header!r} has no unit; write {header} [us], or give load_traces "
            f"sensors={{{header!r}: 'time [s]'}}"
        )
    return unit

"""Read measured drives from CSV files, with the gain and the offset of their signal."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from typing import Final

import numpy as np

from ..chain.drives import Driven, TableDrive
from ..collision import Array
from ..errors import InputError, InputWarning, errors_at, short_repr, warn_user
from ..representation import measure
from ..units import UNITS, VOLTS, converted, has_dimension, quantity, volts_per
from ..validation.keywords import checked_arguments
from ..validation.numbers import SCALED, number
from ..validation.objects import file_path, shown_path, text
from .csv_tables import split_header
from .sample_table import SampleTable, read_samples

# SI unit of each quantity that a column may have; velocities are integrated.
QUANTITIES: Final = {"force": "N", "displacement": "m", "velocity": "m/s"}
_NUMBER: Final = re.compile(
    r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([A-Za-z\u00b5].*?)\s*"
)
# Unit of a signal at the end, as in N/V.
_PER_VOLT: Final = re.compile(r"(.+?)\s*/\s*([um\u00b5]?V)")
# Part of the largest value that a signal may have before the simulation begins.
BEGUN: Final = 0.05
# Times are the same if they differ by less than this part of the least step between samples.
SAME_TIME: Final = 1e-6
# A force has an offset if its first samples, before it exceeds this part of the largest one, are at
# least so many, larger than this part of it, and this many times larger than their scatter.
FIRST_SAMPLES, LEAST_OFFSET, TIMES_SCATTER = 5, 2e-3, 4.0
# Part of the largest value that a force may have from its end on.
LATER: Final = 0.2
_GAINS: Final = "'50 N/V' or '20 mV/N' for a force, '0.1 mm/V' for a displacement"


@dataclass(frozen=True)
class _Column:
    """The column of a signal: its header, name, unit, and index in the file."""

    header: str
    name: str
    unit: str
    index: int


@checked_arguments("load_drive")
def load_drive(
    path: str | os.PathLike[str],
    *,
    column: str | None = None,
    gain: str | None = None,
    offset: str | None = None,
    baseline: float | str | None = None,
    start: float | str | None = None,
    end: float | str | None = None,
) -> TableDrive:
    r"""Read a drive from a CSV file with columns such as ``time [us]`` and ``force [N]``.

    The file may be that of an oscilloscope, as for `hertzchain.load_traces`.  The signal s of a
    sensor in volts gives the value :math:`(s - s_0)/g`, where the gain g is in V/N, like the gains
    of sensors in a fit, or the value :math:`g(s - s_0)`, where g is in N/V.

    Parameters
    ----------
    path : path-like
        The file.  The second column may be ``displacement [um]``, of the left wall, or
        ``velocity [mm/s]``, which is integrated from the displacement 0 at time 0.
    column : str, optional
        Name of the column of the signal, such as ``"Volt"``, or ``"CH2 [V]"`` if the file states
        no unit; required if there are several.
    gain : str, optional
        Gain of a signal in volts, such as ``"50 N/V"``, ``"20 mV/N"``, ``"0.1 mm/V"`` or
        ``"5 mm/s/V"``; its unit states whether the drive is a force or a displacement.
    offset : str, optional
        Signal without force or displacement, such as ``"12 mV"``, which is subtracted first.
    baseline : float or str, optional
        Time [s] until which there is only the offset, such as ``"20 us"``: the mean of the signal
        until then is subtracted, instead of ``offset``.
    start : float or str, optional
        Time [s] in the file at which the simulation begins, such as ``"-40 us"`` if the record was
        triggered by the force itself; by default 0.
    end : float or str, optional
        Time [s] in the file at which a force ends, such as ``"150 us"``.  Without it, the drive
        keeps its last value, which is that of the noise at the end of most records.

    Raises
    ------
    InputError
        If the file is missing or unreadable, a column is unknown, missing or duplicated, a sample
        is missing or beyond the range, the gain is missing or has another unit, or times do not
        increase.  The message names the file.

    Warns
    -----
    InputWarning
        If the signal exceeds 5% of its largest value before the simulation begins, or 20% from
        ``end`` on; if a force has an offset before the blow, or pulls more than it pushes.

    Examples
    --------
    >>> import hertzchain as hc
    >>> import tempfile
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "hammer.csv"
    ...     _ = file.write_text("time [us],force [N]\n0,0\n10,80\n30,0\n")
    ...     hc.load_drive(file)
    TableDrive(3 times, 0 to 3e-05, of='force')

    A signal in volts, with a sensitivity of 20 mV/N and an offset:

    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "scope.csv"
    ...     _ = file.write_text("Time (us),Volt (V)\n0,0.1\n10,1.7\n30,0.1\n")
    ...     hc.load_drive(file, gain="20 mV/N", offset="100 mV").values.round(9)
    array([ 0., 80.,  0.])
    """
    file = file_path("table of a drive", path)
    with errors_at(shown_path(path)):
        table = read_samples(file, "time [us], force [N]")
        table.check_rows()
        time, unit_of_times = _times(table)
        signal = _signal(table, time, column)
        of, factor = _quantity(signal, unit_of_times, gain)
        times, values = (
            _samples(table, index, table.header[index]) for index in (time, signal.index)
        )
        if unit_of_times:
            times = times * converted("column 'time'", 1.0, unit_of_times, "s")
        values = factor * (values - _offset(signal, times, values, offset, baseline))
        unit = "s" if unit_of_times else SCALED
        begin = 0.0 if start is None else number("start", start, unit=unit)
        if end is not None:
            times, values = _ended(of, times, values, number("end", end, unit=unit, above=begin))
        _check_begin(of, times, values, begin, unit)
        if of == "force":
            _check_force(times, values, "SI" if unit_of_times else "scaled")
        times = times - begin
        if of == "velocity":
            return TableDrive(times, _integrated(times, values), "displacement")
        driven: Driven = "force" if of == "force" else "displacement"
        return TableDrive(times, values, driven)


def _check_force(times: Array, values: Array, units: str) -> None:
    """Warn about a force that pulls more than it pushes, or does not begin at 0."""
    if -values.min() > values.max():
        warn_user(
            f"the force reaches {measure(float(values.min()), 'N', units)}, but only "
            f"{measure(float(values.max()), 'N', units)} towards the chain: check its sign, such "
            "as that of gain",
            InputWarning,
        )
    largest = float(np.abs(values).max())
    first = values[: int(np.argmax(np.abs(values) > BEGUN * largest))]
    if len(first) < FIRST_SAMPLES:
        return
    offset = float(first.mean())
    if abs(offset) > max(LEAST_OFFSET * largest, TIMES_SCATTER * float(first.std())):
        until = measure(float(times[len(first) - 1]), "s", units)
        warn_user(
            f"before the blow, the force is {measure(offset, 'N', units, 2)}: subtract it with "
            f"offset, or with baseline, such as '{until}'",
            InputWarning,
        )


def _ended(of: str, times: Array, values: Array, end: float) -> tuple[Array, Array]:
    """Samples of a force that is 0 from a time on."""
    if of != "force":
        raise InputError(f"end is the end of a force, but the drive is a {of}; omit it")
    if end <= times[0]:
        raise InputError(f"end must be later than the first sample, at {times[0]:g} s, got {end:g}")
    # A sample at the end that rounding moves before it would repeat its time.
    own = times < end - SAME_TIME * float(np.diff(times).min(initial=np.inf))
    later, largest = (float(np.abs(each).max(initial=0.0)) for each in (values[~own], values))
    if later > LATER * largest:
        warn_user(
            f"from end, {measure(end, 's')} of the file, the signal still reaches "
            f"{later / largest:.0%} of its largest value, which is not part of the drive: give a "
            "later end if the force lasts longer, or if there is a second blow",
            InputWarning,
        )
    return np.append(times[own], end), np.append(values[own], 0.0)


def _check_begin(of: str, times: Array, values: Array, begin: float, unit: str) -> None:
    """Warn about a signal that has begun before the simulation, and reject a force that is over."""
    before, later = (
        float(np.abs(values[own]).max(initial=0.0)) for own in (times < begin, times >= begin)
    )
    largest, units = max(before, later), "SI" if unit == "s" else "scaled"
    where = f"the simulation begins, at {measure(begin, 's', units)} of the file"
    advice = f"give start, such as '{measure(float(times[0]), 's', units)}', where the file begins"
    if of == "force" and later < BEGUN * largest:
        raise InputError(f"the force is over before {where}; {advice}")
    if before > BEGUN * largest:
        warn_user(
            f"before {where}, the signal reaches {before / largest:.0%} of its largest value; "
            f"{advice}",
            InputWarning,
        )


def _times(table: SampleTable) -> tuple[int, str]:
    """Index and unit of the column of times; the unit is empty if there is none."""
    names = [_name_and_unit(header)[0] for header in table.header]
    if names.count("time") != 1:
        raise InputError(
            "a drive requires one column of times, such as 'time [us]' or 'Time (s)', and that of "
            f"its signal, got {', '.join(table.header)}"
        )
    return names.index("time"), _name_and_unit(table.header[names.index("time")])[1]


def _signal(table: SampleTable, time: int, column: str | None) -> _Column:
    """The column that is named, or the only one."""
    columns = [
        _Column(header, *_name_and_unit(header), index)
        for index, header in enumerate(table.header)
        if index != time
    ]
    if column is None:
        if len(columns) != 1:
            given = f"; choose one, as in column = '{columns[0].header}'" if columns else ""
            raise InputError(
                "a drive requires a column time and either force or displacement, got "
                f"{', '.join(table.header)}{given}"
            )
        return columns[0]
    name, unit = _name_and_unit(text("column of a drive", column))
    found = [each for each in columns if each.name == name]
    if len(found) != 1:
        others = ", ".join(each.header for each in columns) or "only times"
        many = f"{len(found)} columns {column!r}" if found else f"no column {column!r}"
        raise InputError(f"the file has {many}; choose one of {others}")
    own = found[0]
    if unit and own.unit and unit != own.unit:
        raise InputError(
            f"column {own.header!r} has the unit {own.unit}, but is given as {column!r}; leave out "
            "the unit, or correct the header"
        )
    return _Column(own.header, own.name, own.unit or unit, own.index)


def _name_and_unit(header: str) -> tuple[str, str]:
    name, unit = split_header(header) or (" ".join(header.lower().split()), None)
    return name, unit or ""


def _quantity(signal: _Column, unit_of_times: str, gain: str | None) -> tuple[str, float]:
    """Quantity of the signal, and its value per unit of the column."""
    if signal.unit in VOLTS:
        if gain is None:
            raise InputError(
                f"column {signal.header!r} is in {signal.unit}; give the gain of the sensor, such "
                f"as {_GAINS}"
            )
        quantity_of, per_volt = _gain(gain)
        return quantity_of, VOLTS[signal.unit] * per_volt
    if gain is not None and (signal.unit or signal.name in QUANTITIES):
        unit = f"has the unit {signal.unit}" if signal.unit else "is in scaled variables"
        raise InputError(
            f"column {signal.header!r} {unit}, but gain = {gain!r} is for signals in V; omit it"
        )
    if not signal.unit and (unit_of_times or signal.name not in QUANTITIES):
        unit = QUANTITIES.get(signal.name, "V")
        raise InputError(
            f"column {signal.header!r} has no unit; write {signal.header} [{unit}], in the file or "
            f"as column = '{signal.header} [{unit}]'"
        )
    if signal.unit and not unit_of_times:
        raise InputError(
            f"column 'time' has no unit, but {signal.header!r} has one; write time "
            f"[{UNITS['time'][0]}]"
        )
    if not signal.unit:
        return signal.name, 1.0
    of = signal.name if signal.name in QUANTITIES else _quantity_of(signal.unit)
    if of is None:
        raise InputError(
            f"column {signal.header!r} must have a unit of force, displacement or velocity, or V "
            "with a gain"
        )
    return of, converted(f"column {signal.name!r}", 1.0, signal.unit, QUANTITIES[of])


def _quantity_of(unit: str) -> str | None:
    return next((name for name, si in QUANTITIES.items() if has_dimension(unit, si)), None)


def _gain(gain: object) -> tuple[str, float]:
    """Quantity and its value per volt of a gain such as ``50 N/V`` or ``20 mV/N``."""
    found = _NUMBER.fullmatch(gain) if isinstance(gain, str) else None
    if found is None:
        raise InputError(f"gain must be text with a unit, such as {_GAINS}; got {short_repr(gain)}")
    value, unit = float(found[1]), found[2]
    if value == 0.0:
        raise InputError(f"gain must not be 0, got {gain!r}")
    if per := _PER_VOLT.fullmatch(unit):
        of = _quantity_of(per[1])
        if of is not None:
            return of, value * converted("gain", 1.0, per[1], QUANTITIES[of]) / VOLTS[per[2]]
    for of, si in QUANTITIES.items():
        if volts := volts_per(found[0], si):
            return of, 1.0 / volts
    raise InputError(f"gain must have a unit such as {_GAINS}; got {short_repr(gain)}")


def _offset(
    signal: _Column, times: Array, values: Array, offset: str | None, baseline: float | str | None
) -> float:
    """Offset of a signal, in the unit of its column."""
    if baseline is None:
        return 0.0 if offset is None else _given_offset(signal, offset)
    if offset is not None:
        raise InputError("give either offset or baseline, not both")
    unit = "s" if signal.unit else SCALED
    end = number("baseline", baseline, unit=unit)
    before = values[times <= end]
    if not len(before):
        begin = measure(float(times[0]), "s", "SI" if signal.unit else "scaled")
        raise InputError(
            f"there is no sample until baseline = {baseline!r}, because the file begins at {begin}"
        )
    return float(before.mean())


def _given_offset(signal: _Column, offset: object) -> float:
    if not signal.unit:
        raise InputError(
            f"column {signal.header!r} has no unit, so offset cannot be given; subtract it in the "
            "file, or give baseline"
        )
    found = quantity(offset) if isinstance(offset, str) else None
    if found is None:
        raise InputError(
            f"offset must be text with the unit of the signal, such as '0.1 {signal.unit}', got "
            f"{short_repr(offset)}"
        )
    if signal.unit not in VOLTS:
        si = QUANTITIES[str(_quantity_of(signal.unit))]
        return converted("offset", *found, si) / converted("offset", 1.0, signal.unit, si)
    if found[1] not in VOLTS:
        raise InputError(f"offset must have the unit of the signal, V or mV, got {offset!r}")
    return float(found[0]) * VOLTS[found[1]] / VOLTS[signal.unit]


def _samples(table: SampleTable, index: int, header: str) -> Array:
    """Numbers of a column, none of which may be missing."""
    values = table.numbers(index, header)
    wrong = np.flatnonzero(~np.isfinite(values))
    if len(wrong):
        row = int(wrong[0])
        what = "missing" if np.isnan(values[row]) else "beyond the range of the digitiser"
        raise InputError(
            f"the sample of column {header!r} in line {table.lines[row]} is {what}; a drive "
            "requires all samples"
        )
    return values


def _integrated(times: Array, velocities: Array) -> Array:
    """Displacement by the trapezoidal rule, 0 at time 0."""
    if len(times) < 2 or np.any(np.diff(times) <= 0.0):
        return velocities  # `TableDrive` rejects the times.
    steps = 0.5 * np.diff(times) * (velocities[1:] + velocities[:-1])
    moved = np.concatenate(([0.0], np.cumsum(steps)))
    return moved - np.interp(0.0, times, moved)

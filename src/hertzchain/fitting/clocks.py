"""Time offsets that are known: given, or those of a drive in the same file as the traces."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from ..representation import listed, measure
from ..traces.signals import GIVEN, Clock
from ..traces.traces import Traces
from ..validation.numbers import number
from ..validation.objects import check_list
from .advice import advice_to_free
from .model import Model
from .names import TIME_OFFSET, Name, is_time_offset, parse_name
from .parameters import expanded
from .settings import Settings

KEY: Final = TIME_OFFSET


def with_clocks(traces: Traces, settings: Settings) -> tuple[Traces, Settings]:
    """Traces with the time offsets that are fixed, and settings that start from the others.

    The start of a time offset that is not free is its fixed value.
    """
    free = _free_offsets(traces, settings)
    start, fixed = dict(settings.start), dict[Name, float]()
    for text in [each for each in start if is_time_offset(each)]:
        names = expanded(parse_name(text), traces)
        if not free & {*names}:
            value = number(f"start of {text}", start.pop(text), unit="s")
            fixed |= dict.fromkeys(names, value)
    shots = []
    for index, shot in enumerate(traces.shots, start=1):
        own = [Name(KEY, shot=str(index)), Name(KEY)]
        if used := [name for name in own if name in free]:
            if shot.clock is not None:
                start.setdefault(str(used[0]), shot.time_offset)
            shots.append(replace(shot, clock=None))
        else:
            known = [Clock(fixed[name]) for name in own if name in fixed]
            shots.append(replace(shot, clock=known[0] if known else shot.clock))
    return Traces(tuple(shots)), replace(settings, start=start)


def _free_offsets(traces: Traces, settings: Settings) -> set[Name]:
    """Time offsets that are free; by default, those that are not known."""
    if settings.free is None:
        unknown = {k for k, each in enumerate(traces.shots, start=1) if each.clock is None}
        every = {Name(KEY, shot=str(k)) for k in unknown}
        return every | {Name(KEY)} if len(unknown) == len(traces.shots) else every
    given = check_list("free", settings.free, "names")
    named = [each for each in given if is_time_offset(str(each))]
    return {name for text in named for name in expanded(parse_name(text), traces)}


def fixed_offsets(model: Model) -> list[Name]:
    """Time offsets that are not free: the common one, or those of some shots."""
    count = len(model.chains)
    free = {name for name in model.names if name.key == KEY}
    if Name(KEY) in free:
        return []
    own = [Name(KEY, shot=str(k)) for k in range(1, count + 1)]
    return [Name(KEY)] if count == 1 and not free else [each for each in own if each not in free]


def clock_notes(traces: Traces) -> list[str]:
    """Notes on the time offsets that are fixed because they are known, one for each value."""
    found: dict[Clock, list[int]] = {}
    for index, shot in enumerate(traces.shots, start=1):
        if shot.clock is not None:
            found.setdefault(shot.clock, []).append(index)
    every = len(found) == 1 and len(next(iter(found.values()))) == len(traces.shots)
    notes = []
    for clock, shots in found.items():
        where = "" if every else f" of shot {listed([*map(str, shots)])}"
        why = "as given"
        if clock.reason != GIVEN:
            why = f"{clock.reason}; {advice_to_free([Name(KEY)], traces)} to fit it"
        notes.append(f"{KEY}{where} is fixed at {measure(clock.time_offset, 's')}, {why}")
    return notes

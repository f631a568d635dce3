"""Advice to free parameters, also if levels before the pulse are not those of the model."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..representation import listed
from ..traces.amplitudes import CERTAIN, error_of_level, level_of_model
from ..traces.traces import Traces
from .names import Name
from .parameters import expanded

if TYPE_CHECKING:
    from .result import FitResult


def advice_to_free(names: Sequence[Name], traces: Traces) -> str:
    """The advice to add parameters, with a wildcard if it denotes exactly these."""
    items, shots = {each.item for each in names}, {each.shot for each in names}
    short = Name(
        names[0].key,
        items.pop() if len(items) == 1 else "*",
        shots.pop() if len(shots) == 1 else "*",
    )
    shown = [short] if set(expanded(short, traces)) == set(names) else names
    return f"add {listed([repr(str(each)) for each in shown])} to the free parameters"


def level_advice(result: FitResult) -> tuple[str, ...]:
    """Notes on sensors whose mean before the pulse is not that of the model."""
    found: dict[str, list[tuple[Name, str]]] = {}
    flat = itertools.chain.from_iterable(result.predicted)
    several = len(result.traces.shots) > 1
    for (shot, signal), model in zip(result.traces, flat, strict=True):
        name = Name("offset", signal.name, str(shot + 1) if several else "")
        expected = level_of_model(signal, model)
        if not np.isfinite(expected) or {name, replace(name, shot="")} & {*result.model.names}:
            continue
        error = error_of_level(signal)
        if abs(signal.level - expected) > CERTAIN * error:
            # The foot of the simulated pulse is not zero, but cannot be measured.
            shown = expected if abs(expected) > error else 0.0
            found.setdefault(signal.name, []).append((name, (
                f"before the pulse{f' of shot {name.shot}' if several else ''}, {signal.name} is "
                f"at {signal.level:.3g} {signal.unit}, the model at {shown:.3g} {signal.unit}"
            )))  # fmt: skip
    return tuple(
        f"{notes[0][1]}: check its zero, or "
        f"{advice_to_free([name for name, _ in notes], result.traces)}"
        for notes in found.values()
    )

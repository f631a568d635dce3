"""Advice to free parameters, to check zeros of sensors, and to consider further causes."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from ..representation import listed, shown_signal
from ..traces.amplitudes import CERTAIN, error_of_level, level_differs, level_of_model
from ..traces.traces import Traces
from .names import ENDS, Name, to_free
from .parameters import expanded
from .sensor_effects import groups_of_effects

if TYPE_CHECKING:
    from .result import FitResult

# Causes that other functions test.
DEFECTS: Final = "gaps, odd balls and a ball of another material (scan_defects)"
LAWS: Final = "other loss laws (compare_losses)"


def advice_to_free(names: Sequence[Name], traces: Traces) -> str:
    """The advice to add parameters, with a wildcard if it denotes exactly these."""
    items, shots = {each.item for each in names}, {each.shot for each in names}
    short = Name(
        names[0].key,
        items.pop() if len(items) == 1 else "*",
        shots.pop() if len(shots) == 1 else "*",
    )
    shown = [short] if set(expanded(short, traces)) == set(names) else names
    return to_free(shown)


def unequal_levels(result: FitResult) -> dict[str, list[tuple[Name, str]]]:
    """Offsets that sensors need whose mean before the pulse is not that of the model, and notes."""
    found: dict[str, list[tuple[Name, str]]] = {}
    flat = itertools.chain.from_iterable(result.predicted)
    at_rest = itertools.chain.from_iterable(result.at_rest)
    several = len(result.traces.shots) > 1
    for (shot, signal), model, rest in zip(result.traces, flat, at_rest, strict=True):
        name = Name("offset", signal.name, str(shot + 1) if several else "")
        expected = level_of_model(signal, model)
        if not np.isfinite(expected) or {name, replace(name, shot="")} & {*result.model.names}:
            continue
        error = error_of_level(signal)
        if level_differs(signal, expected, rest, CERTAIN * error):
            # The foot of the simulated pulse is not zero, but cannot be measured.
            shown = expected if abs(expected) > error else 0.0
            found.setdefault(signal.name, []).append((name, (
                f"before the pulse{f' of shot {name.shot}' if several else ''}, {signal.name} is "
                f"at {shown_signal(signal.level, signal.unit)}, the model at "
                f"{shown_signal(shown, signal.unit)}"
            )))  # fmt: skip
    return found


def level_advice(result: FitResult) -> tuple[str, ...]:
    """Advice on sensors whose mean before the pulse is not that of the model."""
    return tuple(
        f"{notes[0][1]}: check its zero, or "
        f"{advice_to_free([name for name, _ in notes], result.traces)}"
        for notes in unequal_levels(result).values()
    )


def considered(result: FitResult, tested: Collection[str] = ()) -> str:
    """Advice to consider the causes that no fit tests, without those that were tested otherwise."""
    chain, free = result.chain, {name.key for name in result.model.names}
    walls = [end for end in ENDS if getattr(chain, end) is not None]
    bodies = ["striker"] * (chain.strikers > 0) + ["balls"] + ["wall"] * bool(walls)
    causes = [cause for cause in (DEFECTS, LAWS) if cause not in tested]
    if not result.converged:
        of_chain = [each.name for each in result.model.parameters if each.of_chain]
        lossy = [name for name in of_chain if "loss." in name.key]
        example = next(iter(lossy or of_chain or result.model.names))
        causes.insert(0, f"another start (start={{'{example}': ...}})")
    if any(f"{end}.exponent" not in free for end in walls):
        causes.append("the exponent of the wall")
    first = "".join(f"{cause}, " for cause in causes) + "and " * bool(causes)
    return f"Consider {first}the sizes and materials of {listed(bodies)}"


def nothing_explains(result: FitResult, tried: Iterable[str], levels: Collection[str] = ()) -> str:
    """Advice if no cause explains the residuals; ``tried`` has those of other fits in words.

    ``levels`` has the advice on zeros, which does not explain all of them.
    """
    causes = dict.fromkeys((
        *["effects of the sensors"] * any(groups_of_effects(result)),
        "other readings of the columns and times", *filter(None, tried),
    ))  # fmt: skip
    first = "even with separate offsets, " if levels else ""
    return (
        f"{first}none of the effects tested explains the residuals ({', '.join(causes)}). "
        f"{considered(result)}"
    )

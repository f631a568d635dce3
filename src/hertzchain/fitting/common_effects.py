"""Common offsets and gains of all sensors that differ between them, as causes of residuals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Final

from .causes import Cause, Refit, try_further
from .names import Name
from .result import FitResult

KEYS: Final = ("offset", "gain")


def separate_effects(result: FitResult, _: Mapping[str, float], refit: Refit) -> Iterator[Cause]:
    """Fits in which a common offset or gain has another value for each sensor."""
    for key in KEYS:
        free = [each for each in result.model.names if each.key == key]
        if free != [Name(key)] or len(result.traces.names) == 1:
            continue
        # The common parameter becomes that of the first sensor.
        own = [Name(key, item) for item in result.traces.names[1:]]
        cause = try_further(result, own, refit, neutral=result.values[key])
        if cause is not None:
            yield replace(cause, advice=f"free '{key}[*]' instead of '{key}'")

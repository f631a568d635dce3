"""Text of the result of a fit: summary, verdict and warnings."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..representation import counted, folded, listed
from .arrival_notes import silent_notes
from .clocks import clock_notes
from .goodness import NO_ERRORS
from .held_by_priors import prior_notes
from .silent_sensors import silent_clause
from .summary_width import summary_width

if TYPE_CHECKING:
    from .result import FitResult

# The chi-squared per sample of a sensor is named if it exceeds that of the others by this factor,
# and by this number of standard deviations of its scatter.
LARGER, CLEARLY = 1.5, 3.0


def summary_of(result: FitResult, width: int | None) -> str:
    """Values with errors, the verdict and all notes; without values that have no meaning."""
    sensors = counted(len(result.traces.names), "sensor")
    shots = len(result.traces.shots)
    within = f" in {shots} shots" if shots > 1 else ""
    parameters = counted(len(result.names), "parameter")
    lines = [f"{parameters} from {result.goodness.samples} samples of {sensors}{within}"]
    longest = max(map(len, result.names))
    if not result.meaningless:
        lines += [f"  {name:<{longest}}  {row}" for name, row in result.rows()]
        lines += ["  " + "  ".join(result.restitution.row)] if result.restitution else []
    lines.append(result.verdict)
    if len(result.traces.names) > 1 and not result.meaningless:
        lines.append(f"chi2 per sample: {_by_sensor(result)}")
    lines += [*result.warnings, *([result._loss_note] if result._loss_note else [])]
    return folded("\n".join(lines), summary_width(width))


def verdict_of(result: FitResult) -> str:
    """Whether the model describes the data and agrees with the priors."""
    good = result.goodness
    if good.only_noise:
        return f"{good}{good.verdict}"
    if result._implausible:
        return f"{good}, but {result._implausible}, so the fit is meaningless"
    if result.misread:
        return f"{good}: columns or times are read wrongly, so the fit is meaningless"
    if not result.converged:
        return f"{good}: the fit has {result.reason}{NO_ERRORS}"
    text = f"{good}{good.verdict}{silent_clause(result.traces, result.undetermined)}"
    if not result.prior_conflict or result.meaningless or result.explained:
        return text
    return f"{text}. {'However' if result.describes else 'In addition'}, {result.prior_conflict}"


def warnings_of(result: FitResult) -> tuple[str, ...]:
    """Weak directions, effects of sensors or other causes, and notes, one sentence each."""
    if result.meaningless:
        silent = [note for shot in result.traces.shots for note in silent_notes(shot)]
        own = (*clock_notes(result.traces), *result.traces.notes())
        return (*result.advice, *own, *dict.fromkeys(silent))
    weak = [str(each) for each in result.weak]
    if not result.goodness.accepted:
        # Errors have no meaning then, so advice to reduce them would mislead.
        return (*result.advice, *weak, *result.notes)
    weak += prior_notes(result.held, result.weak)
    effects = sorted(result.effects, key=lambda each: (-each.present, -each.improvement))
    # Data without noise are not of sensors.
    real = not result.goodness.noiseless
    found = [each.note for each in effects if each.note and (real or each.present)]
    # Effects can be mistaken for each other, so only the strongest is reported.
    if result.advice:
        found = list(result.advice)
    elif effects and effects[0].present:
        found = found[:1]
    constants = [each.note for each in result.constants if each.note]
    return (*weak, *found, *constants, *result.notes)


def _by_sensor(result: FitResult) -> str:
    """Chi-squared per sample of each sensor, and the sensors of which it is clearly larger."""
    ratios = result.chi2_per_sample
    text = ", ".join(f"{name} {value:.3g}" for name, value in ratios.items())
    if not result.goodness.accepted:
        return text
    larger = clearly_larger(ratios, result.goodness.independent)
    if not larger:
        return text
    them = "its gain, zero and noise" if len(larger) == 1 else "their gains, zeros and noise"
    return f"{text}. That of {listed(larger)} is clearly larger: check {them}"


def clearly_larger(ratios: Mapping[str, float], independent: Mapping[str, float]) -> list[str]:
    """Sensors whose chi-squared per sample exceeds that of the others, and 1, clearly."""
    found = []
    for name, value in ratios.items():
        usual = float(np.median([each for other, each in ratios.items() if other != name]))
        scatter = math.sqrt(2.0 / max(independent.get(name, 1.0), 1.0))
        if value > LARGER * max(usual, 1.0) and math.log(value / usual) > CLEARLY * scatter:
            found.append(name)
    return found

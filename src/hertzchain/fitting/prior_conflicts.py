"""Priors from which a fit deviates by more than their errors allow, and bounds that it reaches."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from ..collision import Array
from ..representation import listed
from ..traces.headers import GAIN_UNITS
from ..traces.traces import Traces
from .misread_columns import POLARITY
from .names import Name
from .parameters import Parameter
from .sensor_comparison import SensorComparison
from .shown_values import shown_value, shown_with_error

# A parameter contradicts its prior beyond this number of standard deviations; several contradict
# theirs together if the sum of squares is less probable than the same deviation of one.  Both tests
# are conservative: a fit follows its priors, so that the variance of a deviation from a prior s is
# 1 - (error/s)^2 and not 1.  If this is small, so is a deviation, and errors of a nonlinear fit or
# of its noise would cause false alarms if one was divided by the other.
CONTRADICTS: Final = 3.0
# Up to this number of standard deviations, a gain of a comparison agrees with its prior.
AGREES: Final = 1.0
# Larger numbers of standard deviations are not stated, because they have no meaning.
MANY: Final = 100.0
# Largest relative difference of a ratio from a power of ten that a wrong unit would cause.
NEAR_POWER: Final = 0.2
# Units that make values too small and too large by a thousand.
UNITS: Final = ("mV instead of V", "V instead of mV")
OF_CHAIN: Final = "the diameters, masses and materials of the chain, the calibration of the sensors"
ADVICE: Final = f"check {OF_CHAIN}, and the prior itself"
# A comparison finds gains for the loss and the impact of the file, which a fit usually frees.
COMPARED: Final = f"check the velocity of the impact, the loss, {OF_CHAIN}, and the prior itself"


def bound_notes(names: Sequence[str]) -> list[str]:
    """A note on each parameter that is at its bound."""
    return [f"{name} is at its bound and has no error" for name in names]


def contradicted(deviations: Mapping[str, float]) -> tuple[str, ...]:
    """Parameters that contradict their priors, alone or all together.

    ``deviations`` from the priors are in standard deviations.
    """
    far = tuple(name for name, each in deviations.items() if abs(each) > CONTRADICTS)
    return far or (tuple(deviations) if _improbable([*deviations.values()]) else ())


def _improbable(deviations: Sequence[float]) -> bool:
    from scipy.stats import chi2, norm

    count, squares = len(deviations), float(np.sum(np.square(deviations)))
    return bool(count and chi2.sf(squares, count) < 2.0 * norm.sf(CONTRADICTS))


def conflict(deviations: Mapping[str, float]) -> str:
    """The contradicted priors in a clause; empty without any."""
    names = contradicted(deviations)
    far = {name: abs(deviations[name]) for name in names if abs(deviations[name]) > CONTRADICTS}
    if far:
        return listed([f"{name} is {_counted(size)} from its prior" for name, size in far.items()])
    if not names:
        return ""
    squares = sum(each**2 for each in deviations.values())
    return (
        f"the priors of {listed(names)} together contradict the data (chi2 {squares:.1f} for "
        f"{len(names)} priors)"
    )


def _counted(size: float) -> str:
    if size > MANY:
        return f"more than {MANY:.0f} standard deviations"
    return f"{size:.{1 if size < 9.95 else 0}f} standard deviations"


def deviations_from_priors(
    parameters: Sequence[Parameter], values: Mapping[Name, float]
) -> dict[str, float]:
    """Values minus those of their priors, in standard deviations of the priors, by name."""
    return {
        str(each): (values[each.name] - each.prior[0]) / each.prior[1]
        for each in parameters if each.prior is not None
    }  # fmt: skip


def conflict_notes(
    parameters: Sequence[Parameter], traces: Traces, values: Mapping[Name, float], sigmas: Array
) -> tuple[str, ...]:
    """Notes on contradicted priors, with values and advice."""
    deviations = deviations_from_priors(parameters, values)
    found = []
    for each, sigma in zip(parameters, sigmas.tolist(), strict=True):
        size = abs(deviations.get(str(each), 0.0))
        if each.prior is not None and size > CONTRADICTS:
            pairs = (values[each.name], sigma), each.prior
            value, prior = (shown_value(each, traces, *pair, at_bound=False) for pair in pairs)
            advice = _wrong_unit(each.name, values[each.name] / each.prior[0]) or ADVICE
            note = f"{each} = {value} is {_counted(size)} from its prior, {prior}"
            found.append((note, advice))
    clause = conflict(deviations)
    return _advised_once(found) or ((f"{clause}: {ADVICE}",) if clause else ())


def _advised_once(notes: Sequence[tuple[str, str]], general: str = ADVICE) -> tuple[str, ...]:
    """Notes with their advice; the general one follows the last of several."""
    several = sum(advice == general for _, advice in notes) > 1
    own = [(note, "" if several and advice == general else advice) for note, advice in notes]
    common = (general.replace("the prior itself", "the priors themselves"),) * several
    return (*(f"{note}: {advice}" if advice else note for note, advice in own), *common)


def gain_notes(
    sensors: Sequence[SensorComparison], priors: Mapping[str, tuple[float, float]]
) -> tuple[str, ...]:
    """Notes on gains that a comparison has found and whose priors are known."""
    found = []
    for each in sensors:
        if each.unit != "V" or each.name not in priors:
            continue
        sensor, gain, unit = each.name, each.scale, GAIN_UNITS[each.quantity]
        mean, sigma = priors[sensor]
        size = abs(gain - mean) / sigma
        relation = "agrees with" if size <= AGREES else f"differs by {_counted(size)} from"
        note = (
            f"the gain of {sensor}, {each.scaling}, {relation} its prior in [fit], "
            f"{shown_with_error(mean, sigma, unit)}"
        )
        advice = ""
        if gain * mean < 0.0:
            advice = POLARITY
        elif size > CONTRADICTS:
            advice = _wrong_unit(Name("gain", sensor), gain / mean) or COMPARED
        found.append((note, advice))
    return _advised_once(found, COMPARED)


def _wrong_unit(name: Name, ratio: float) -> str:
    """Advice on a gain whose ratio to its prior is a power of ten; empty for others."""
    if name.key != "gain" or not ratio > 0.0 or not math.isfinite(ratio):
        return ""
    power = round(math.log10(ratio))
    if power == 0 or abs(ratio / 10.0**power - 1.0) > NEAR_POWER:
        return ""
    factor = f"{10.0 ** abs(power):,.0f} times too {'large' if power > 0 else 'small'}"
    column = f"the column of {name.item}" if name.item else "the columns"
    if power % 3:
        cause = "a probe or an amplifier has another factor, or the unit of the column is wrong"
    else:
        cause = f"the unit in its header is wrong, such as {UNITS[power > 0]}"
    return f"probably the values in {column} are {factor}, because {cause}"

"""Starts of a fit: time offsets and stiffness by cross-correlation, and further starts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Final

import numpy as np

from ..collision import Array
from ..traces.amplitudes import first_sign, level_of, ratio_of_amplitudes
from ..traces.signals import Signal
from .model import Model
from .names import Name
from .parameters import Parameter
from .sensors import sampled

# Factors of time that are tried if the stiffness is free, and points of the even grid.
STRETCHES: Final = tuple(np.exp(np.linspace(-0.3, 0.3, 25)).tolist())
POINTS: Final = 2048
# Factors of the losses from which a few steps are tried, if a fit is poor.
SCAN: Final = (0.1, 0.2, 0.35, 0.5, 0.7, 1.4, 2.5, 5.0)
# Factors of the losses and masses, and changes of the exponent, in further starts.
LOSS_FACTORS: Final = (1.0, 0.2, 4.0, 1.0, 1.0, 0.05)
MASSES: Final = ("mass", "struck_by.mass")
MASS_FACTORS: Final = (1.0, 1.05, 0.95, 1.0, 1.0, 1.1)
EXPONENT_SHIFTS: Final = (0.0, 0.0, 0.0, 0.08, -0.08, 0.0)


def aligned(model: Model, values: dict[Name, float]) -> dict[Name, float]:
    """Choose time offsets and a stiffness for which the data and the model agree best.

    Parameters with a prior are not changed.
    """
    found = dict(values)
    known = {each.name for each in model.parameters if each.prior is not None}
    offsets = [name for name in model.names if name.key == "time_offset" and name not in known]
    stiffness = Name("stiffness")
    stretch = stiffness in found and stiffness not in known and not model.chains[0].drive
    if not offsets and not stretch:
        return found
    scores = np.zeros(len(STRETCHES) if stretch else 1)
    factors = STRETCHES if stretch else (1.0,)
    best: list[list[float]] = []
    for shot in range(len(model.chains)):
        score, lags = _correlations(model, values, shot, factors)
        scores += score
        best.append(lags)
    choice = int(np.argmax(scores))
    for name in offsets:
        shot = int(name.shot or 1) - 1
        found[name] = best[shot][choice]
    if stretch:
        p = float(model.chains[0].contact_exponents[1])
        found[stiffness] = values[stiffness] * factors[choice] ** -(p + 1.0)
    return found


def _correlations(
    model: Model, values: dict[Name, float], shot: int, factors: tuple[float, ...]
) -> tuple[Array, list[float]]:
    """Explained part of chi-squared, and the best time offset, for each factor of time."""
    from scipy.signal import correlate

    data = model.traces.shots[shot]
    span = float(data.times[-1] - data.times[0])
    step = span / (POINTS - 1)
    grid = step * np.arange(POINTS)
    spacing, columns = _shapes(model, values, shot, span * max(factors))
    scores, offsets = [], []
    for factor in factors:
        total = np.zeros(2 * POINTS - 1)
        for signal, column in zip(data.signals, columns, strict=True):
            ok = signal.valid
            seen = np.interp(
                data.times[0] + grid, data.times[ok], signal.values[ok] - level_of(signal)
            )
            sign = math.copysign(1.0, model.gain(shot, signal, values))
            shape = sign * sampled(column, factor * spacing, grid)
            size = float(shape @ shape)
            if size > 0.0:
                product = np.maximum(correlate(seen, shape), 0.0)
                weight = (ok.sum() / POINTS) / signal.sigma**2
                total += weight * product**2 / size
        best = int(np.argmax(total))
        scores.append(float(total[best]))
        offsets.append(float(data.times[0]) + step * (best - (POINTS - 1)))
    return np.array(scores), offsets


def _shapes(
    model: Model, values: dict[Name, float], shot: int, duration: float
) -> tuple[float, list[Array]]:
    """Changes of the simulated signals of a shot since the impact, without the sensor model."""
    run = model.simulator.signals(model.chain(shot, values), duration)
    signals = model.traces.shots[shot].signals
    found = [model.simulator.column(run, signal) for signal in signals]
    return run.spacing, [column - column[0] for column in found]


def with_gains(
    model: Model, values: dict[Name, float], start: Mapping[str, float]
) -> dict[Name, float]:
    """Values in which gains of sensors without calibration are ratios of measured to simulated.

    Gains with a prior or a given start are not changed.
    """
    found = dict(values)
    for each in model.parameters:
        if each.name.key != "gain" or each.prior is not None or str(each.name) in start:
            continue
        for index, signal in model.traces:
            of_shot = each.name.shot in ("", str(index + 1))
            if of_shot and each.name.item in ("", signal.name) and not signal.calibrated:
                found[each.name] = _ratio(model, values, index, signal)
                break
    return found


def _ratio(model: Model, values: dict[Name, float], shot: int, signal: Signal) -> float:
    """Ratio of the largest values of a signal and of its simulation, from their first levels."""
    times = model.traces.shots[shot].times
    _, columns = _shapes(model, values, shot, float(times[-1] - times[0]))
    own = columns[[each.name for each in model.traces.shots[shot].signals].index(signal.name)]
    seen = (signal.values - level_of(signal))[signal.valid]
    if not own.any():
        return first_sign(seen)
    return ratio_of_amplitudes(seen, own)


def further_starts(
    model: Model, values: dict[Name, float], count: int
) -> Iterator[dict[Name, float]]:
    """Values with smaller and larger losses, masses and exponents, clipped to their bounds."""
    varied = ("exponent", *MASSES)
    if not any("loss." in name.key or name.key in varied for name in model.names):
        return
    changes = zip(LOSS_FACTORS, MASS_FACTORS, EXPONENT_SHIFTS, strict=True)
    for factor, mass, shift in list(changes)[1:count]:
        out = with_other_losses(model, values, factor)
        for each in model.parameters:
            if each.name.key in MASSES:
                value = out[each.name] * mass
            elif each.name.key == "exponent":
                value = out[each.name] + shift
            else:
                continue
            out[each.name] = min(max(value, each.kind.lower), each.kind.upper)
        yield out


def scaled_losses(model: Model) -> list[Parameter]:
    """Free parameters of losses that are proportional to the loss, or to what is left of 1."""
    return [
        each for each in model.parameters
        if "loss." in each.name.key and not each.name.key.endswith("alpha")
    ]  # fmt: skip


def with_other_losses(
    model: Model, values: Mapping[Name, float], factor: float
) -> dict[Name, float]:
    """Values whose losses are larger by a factor, clipped to their bounds."""
    out = dict(values)
    for each in scaled_losses(model):
        share = each.kind.scale == "1" and each.kind.upper <= 1.0
        high = each.name.key.endswith("coefficient") or (share and each.start > 0.5)
        value = out[each.name]
        value = 1.0 - (1.0 - value) * factor if high else value * factor
        out[each.name] = min(max(value, each.kind.lower), each.kind.upper)
    return out

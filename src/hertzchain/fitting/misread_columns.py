"""Columns of traces whose sign, unit or place may be wrong, from amplitudes and arrivals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from ..collision import Array
from ..representation import listed
from ..traces.amplitudes import ARRIVED, SAME_TIME, from_level, ratio_of_amplitudes
from ..traces.signals import Signal
from ..traces.traces import Traces, mapped
from .model import Model

# Ratios of amplitudes that suggest another prefix of a unit, and their tolerance (a factor).
PREFIXES: Final = (1e-6, 1e-3, 1e3, 1e6)
TOLERANCE: Final = 3.0
# Factors of probes and amplifiers, and their tolerance; a factor below GROSS is not gross.
PROBES: Final = (0.01, 0.1, 10.0, 100.0)
OF_PROBE, GROSS = 1.5, 3.0
# Advice for signals of the opposite sign.
POLARITY: Final = "check the polarity of the sensor and of its amplifier"


@dataclass(frozen=True)
class Misread:
    """Traces in which columns are read differently, and the advice to check that."""

    what: str
    advice: str
    traces: Traces
    # Whether this changes all columns or all times.
    whole: bool = False
    # Whether amplitudes are wrong by so much that other causes mean nothing before.
    gross: bool = False
    # Whether a prefix of the unit explains the amplitudes of all columns that are read differently.
    unit: bool = False
    # Whether columns of one quantity and unit are in another order.
    order: bool = False


def prefix_of(ratio: float) -> float | None:
    """Prefix of a unit whose omission explains a ratio of either sign, if there is one."""
    near = (each for each in PREFIXES if 1.0 / TOLERANCE < abs(ratio) / each < TOLERANCE)
    return next(near, None)


def misread_columns(model: Model) -> Iterator[Misread]:
    """Traces with signs, units or an order that agree better with the nominal chain."""
    start = {each.name: each.start for each in model.parameters}
    predicted = model.predict_shot(0, start)
    signals = model.traces.shots[0].signals
    ratios = {
        signal.name: ratio_of_amplitudes(from_level(signal), own - own[0])
        for signal, own in zip(signals, predicted, strict=True)
        if np.ptp(own) > 0.0
    }
    yield from _signs(model.traces, ratios)
    # A prior of a gain is a calibration, too.
    gains = {each.name.item for each in model.parameters
             if each.name.key == "gain" and each.prior is not None}  # fmt: skip
    yield from _amplitudes(model.traces, {
        signal.name: ratios[signal.name]
        for signal in signals
        if signal.name in ratios and (signal.calibrated or {signal.name, ""} & gains)
    })  # fmt: skip
    yield from _order(model, predicted)


def _signs(traces: Traces, ratios: Mapping[str, float]) -> Iterator[Misread]:
    turned = [name for name, ratio in ratios.items() if ratio < 0.0]
    if turned:
        yield Misread(
            f"the opposite sign of {listed(turned)}",
            POLARITY,
            _scaled(traces, dict.fromkeys(turned, -1.0)),
        )


def _amplitudes(traces: Traces, ratios: Mapping[str, float]) -> Iterator[Misread]:
    """Traces in which the amplitudes of single sensors, or of all, are as those of the model.

    A common factor near 1 of the other sensors is that of the velocity or of the losses.
    """
    near = [abs(ratio) for ratio in ratios.values() if 1.0 / GROSS < abs(ratio) < GROSS]
    usual = float(np.median(near)) if near else 1.0
    wrong = {
        name: factor
        for name, ratio in ratios.items()
        if not 1.0 / GROSS < (factor := usual_factor(abs(ratio) / usual)) < GROSS
    }
    if not wrong:
        return
    by_factor: dict[float, list[str]] = {}
    for name, factor in wrong.items():
        by_factor.setdefault(factor, []).append(name)
    yield Misread(
        listed([
            f"the values of {listed(names)} multiplied by {float(f'{1.0 / factor:.2g}'):g}"
            for factor, names in by_factor.items()
        ]),
        listed([*dict.fromkeys(
            advice_on_amplitude(factor, len(names)) for factor, names in by_factor.items()
        )]),
        _scaled(traces, {name: 1.0 / factor for name, factor in wrong.items()}),
        whole=len(wrong) == len(traces.names) and all(map(prefix_of, wrong.values())),
        gross=True, unit=all(map(prefix_of, wrong.values())),
    )  # fmt: skip


def usual_factor(ratio: float) -> float:
    """The power of ten by which amplitudes are usually wrong, or the ratio with two digits."""
    if prefix := prefix_of(ratio):
        return prefix
    near = (each for each in PROBES if 1.0 / OF_PROBE < ratio / each < OF_PROBE)
    return next(near, float(f"{ratio:.2g}"))


def advice_on_amplitude(factor: float, count: int = 1) -> str:
    """Advice on columns whose amplitudes are wrong by a factor."""
    column = "this column" if count == 1 else "these columns"
    if factor in PREFIXES:
        return f"check the unit in the header of {column}"
    if factor in PROBES:
        return (
            f"check the attenuation of the probe (x1, x10, x100), the gain of the amplifier and "
            f"the unit in the header of {column}"
        )
    return f"check the gain and the range of the sensor of {column}"


def _order(model: Model, predicted: list[Array]) -> Iterator[Misread]:
    """Columns of one quantity and unit in the order in which the pulse should arrive."""
    signals = model.traces.shots[0].signals
    expected = [_arrival(own - own[0]) for own in predicted]
    seen = [_arrival(from_level(signal)) for signal in signals]
    places: dict[str, str] = {}
    for kind in dict.fromkeys((each.place.quantity, each.unit) for each in signals):
        same = [i for i, each in enumerate(signals) if (each.place.quantity, each.unit) == kind]
        by_model = sorted(same, key=lambda i: expected[i])
        by_data = sorted(same, key=lambda i: seen[i])
        for k, (wanted, found) in enumerate(zip(by_model, by_data, strict=True)):
            if wanted != found and abs(seen[by_data[k]] - seen[wanted]) >= SAME_TIME:
                places[signals[wanted].name] = signals[found].name
    if places and set(places) == set(places.values()):
        how = "exchanged" if len(places) == 2 else "in the order in which the pulse arrives"
        yield Misread(
            f"the columns of {listed(list(places))} {how}",
            "check the names of these columns",
            _exchanged(model.traces, places),
            order=True,
        )


def _arrival(values: Array) -> int:
    return int(np.argmax(np.abs(values) > ARRIVED * np.abs(values).max()))


def inversion_notes(gains: Mapping[str, float]) -> tuple[str, ...]:
    """A note on each sensor without calibration whose gain is negative."""
    return tuple(
        f"{name} is inverted: its gain is negative" for name, gain in gains.items() if gain < 0.0
    )


def _scaled(traces: Traces, factors: Mapping[str, float]) -> Traces:
    def scaled(_: int, signal: Signal) -> Signal:
        factor = factors.get(signal.name, 1.0)
        return replace(
            signal, values=factor * signal.values, noise=abs(factor) * signal.noise,
            step=abs(factor) * signal.step, level=factor * signal.level,
        )  # fmt: skip

    return mapped(traces, scaled)


def _exchanged(traces: Traces, columns: Mapping[str, str]) -> Traces:
    """Traces in which places get the samples of other columns."""

    def exchanged(shot: int, signal: Signal) -> Signal:
        known = {each.name: each for each in traces.shots[shot].signals}
        return replace(known.get(columns.get(signal.name, ""), signal), place=signal.place)

    return mapped(traces, exchanged)

"""Remarks on the samples of measured traces."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from ..representation import counted, listed, measure, shown_signal
from .missing_rows import gap_notes, gaps_between
from .noise import ACCURACY

if TYPE_CHECKING:
    from .signals import Shot, Signal

# Sampling is uneven if the relative difference of time steps exceeds this value.
EVEN: Final = 1e-3
# A spike differs from both neighbours by more than this multiple of the noise.
FAR_IN_NOISE: Final = 10.0


def trace_notes(shots: Sequence[Shot]) -> tuple[str, ...]:
    """Remarks on missing rows, on missing, saturated and rounded samples and on uneven sampling.

    Spikes, which are bad samples, come first.
    """
    found = _repeated_notes(shots)
    found += [note for index, shot in enumerate(shots, 1) for note in spike_notes(shot, index)]
    for index, shot in enumerate(shots, start=1):
        steps = np.diff(shot.times)
        if gaps := gaps_between(shot.times):
            found += gap_notes(gaps, index)
        elif np.ptp(steps) > EVEN * steps.max():
            low, high = 1e6 * steps.min(), 1e6 * steps.max()
            found.append(
                f"shot {index} is sampled unevenly, every {low:.3g} to {high:.3g} us; "
                "nothing is resampled"
            )
        found += [*_coarse_notes(shot, index), *_noiseless_notes(shot, index)]
        for signal in shot.signals:
            found += _unused_notes(signal, "missing", _missing(signal), index)
            flat = int((~signal.valid & np.isfinite(signal.values)).sum())
            found += _unused_notes(signal, "saturated", flat, index)
    return tuple(found)


def missing_sample_notes(shot: Shot) -> list[str]:
    """Notes on the number of missing samples of each signal of a single shot."""
    return [
        note for each in shot.signals for note in _unused_notes(each, "missing", _missing(each))
    ]


def _missing(signal: Signal) -> int:
    """Number of missing samples, without spikes."""
    return int(np.isnan(signal.values).sum()) - len(signal.spikes)


def _unused_notes(signal: Signal, what: str, count: int, number: int | None = None) -> list[str]:
    """A note on samples that are not used, with the number of the shot if there may be several."""
    if not count:
        return []
    shot = "" if number is None else f" in shot {number}"
    verb = "is" if count == 1 else "are"
    return [f"{counted(count, 'sample')} of {signal.name}{shot} {verb} {what} and not used"]


def _repeated_notes(shots: Sequence[Shot]) -> list[str]:
    """Notes on shots with the samples of an earlier one."""
    found = []
    for (i, one), (j, two) in itertools.combinations(enumerate(shots, 1), 2):
        columns = [{each.name: each.values for each in shot.signals} for shot in (one, two)]
        if columns[0].keys() == columns[1].keys() and all(
            np.array_equal(values, columns[1][name], equal_nan=True)
            for name, values in columns[0].items()
        ):
            found.append(
                f"shots {i} and {j} have the same samples: remove one, because errors would be too "
                "small"
            )
    return found


def spike_notes(shot: Shot, number: int | None = None) -> list[str]:
    """Notes on spikes, with the number of the shot if there may be several."""
    found = []
    for signal in shot.signals:
        if not signal.spikes:
            continue
        times = [measure(float(shot.times[i]), "s") for i in signal.spikes]
        shown = [f"{i + 1} (at {time})" for i, time in zip(signal.spikes, times, strict=True)]
        what, verb, are = ("sample", "differs", "is")
        if len(shown) > 1:
            what, verb, are = ("samples", "differ", "are")
        where = signal.name if number is None else f"{signal.name} in shot {number}"
        found.append(
            f"{what} {listed(shown)} of {where} {verb} from both neighbours by more than "
            f"{FAR_IN_NOISE:.0f} times the noise and {are} not used"
        )
    return found


def _coarse_notes(shot: Shot, number: int) -> list[str]:
    """Notes on signals that are rounded to steps much larger than their noise."""
    steps: dict[str, list[str]] = {}
    for signal in shot.signals:
        if signal.coarse:
            steps.setdefault(shown_signal(signal.step, signal.unit), []).append(signal.name)
    return [
        f"the samples of {', '.join(names)} in shot {number} are rounded to steps of {step}, more "
        "than three times their noise: rounding errors are then correlated, and equal successive "
        "samples count less"
        for step, names in steps.items()
    ]


def _noiseless_notes(shot: Shot, number: int) -> list[str]:
    """A note on signals without noise, such as simulated ones."""
    names = [signal.name for signal in shot.signals if signal.noiseless]
    if not names:
        return []
    return [
        f"{', '.join(names)} in shot {number} {'has' if len(names) == 1 else 'have'} almost no "
        f"noise before the pulse, as simulated signals have; {ACCURACY:g} of the largest sample, "
        "the accuracy of simulations, is used as noise; if the data are measured, give noise"
    ]

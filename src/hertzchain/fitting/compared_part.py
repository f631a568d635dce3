"""The part of a record that a run covers, and pulses that the record does not contain."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..collision import Array
from ..errors import InputError
from ..representation import listed, measure
from ..traces.amplitudes import ARRIVED
from ..traces.signals import Shot
from .arrival_notes import FOOT
from .crossings import reached


def check_reached(
    shot: Shot, moments: Array, columns: Sequence[Array], grid: Array, time_offset: float,
    otherwise: str = "",
) -> None:  # fmt: skip
    """Raise `InputError` if the record ends before the simulated pulse arrives at a sensor.

    If the time offset has no meaning, ``otherwise`` is the message instead.
    """
    begin = float(shot.times[-1] - moments[-1])
    missed, least = dict[str, float](), np.inf
    for signal, column in zip(shot.signals, columns, strict=True):
        own = np.abs(column - column[0])
        inside = (moments >= 0.0) & (moments <= float(grid[-1]))
        values = np.interp(moments[inside], grid, own)
        part = float(values.max(initial=0.0) / (own.max() or 1.0))
        least = min(least, part)
        if part < FOOT:
            missed[signal.name] = begin + reached(grid, own, ARRIVED * float(own.max()))
    if least > 0.0:
        return
    if otherwise:
        raise InputError(otherwise)
    advice = "record for longer, or omit the columns of these sensors"
    if len(missed) == 1:
        advice = "record for longer, or omit the column of this sensor"
    if shot.clock is not None:
        advice = "give an earlier time_offset, or record for longer"
    raise InputError(
        f"the record ends at {_shown(float(shot.times[-1]))}, before the simulated pulse reaches "
        f"{listed([*missed])} (at {listed([*dict.fromkeys(map(_shown, missed.values()))])}, with "
        f"time_offset = {_shown(time_offset)}); {advice}"
    )


def _shown(time: float) -> str:
    return measure(time, "s", digits=4)


def covered_part(moments: Array, duration: float, time_offset: float) -> NDArray[np.bool_]:
    """Mask of the samples up to the end of the run."""
    inside = moments <= duration
    if not inside.any():
        raise InputError(
            f"with time_offset = {_shown(time_offset)}, the run ends before the first sample of "
            "the traces; give another one, or simulate for longer"
        )
    if moments[-1] <= 0.0:
        raise InputError(
            f"with time_offset = {_shown(time_offset)}, the run begins after the last sample of "
            "the traces; give an earlier one"
        )
    return inside

r"""The sensor model: gain, offset, delay, first-order lag, high-pass and crosstalk.

The recorded signal of sensor i is

.. math::
    x_i(t) &= g_i\,(h * l * s_i)(t - t_0 - d_i) + o_i \\
    y_i(t) &= x_i(t) + c\,[x_{i-1}(t) + x_{i+1}(t)]

with the force or velocity s, the lag l: :math:`\tau_l \dot u + u = s`, the high-pass h:
:math:`\dot u + r u = \dot s` (of a charge amplifier with time constant 1/r), and the crosstalk c
from the neighbouring columns in the same unit.  The high-pass acts on the change of a signal since
the impact; a static force, such as that of a precompressed chain, is not filtered.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ..collision import Array
from .chain_parameters import Kind

SENSOR_KINDS: Final[Mapping[str, Kind]] = {
    "gain": Kind(step=1e-3, factor=True, signed=True),
    "offset": Kind(step=1e-3),
    "delay": Kind("s", typical=1e-6, step=1e-2),
    "lag": Kind("s", lower=0.0, typical=1e-6, step=1e-2),
    "highpass": Kind("1/s", lower=0.0, typical=100.0, step=1e-2),
    "crosstalk": Kind(lower=-0.5, upper=0.5, typical=0.01, step=1e-2),
}
COMMON_ONLY: Final = ("crosstalk",)


@dataclass(frozen=True)
class Sensor:
    """Constants of one sensor; the default is an ideal one."""

    gain: float = 1.0
    offset: float = 0.0
    delay: float = 0.0
    lag: float = 0.0
    highpass: float = 0.0


def filtered(signal: Array, spacing: float, sensor: Sensor) -> Array:
    """A signal on an even grid after lag and high-pass, from the steady state before it."""
    if sensor.lag > 0.0:
        signal = _lagging(signal, spacing / sensor.lag)
    if sensor.highpass > 0.0:
        signal = signal - _lagging(signal - signal[0], spacing * sensor.highpass)
    return signal


def _lagging(signal: Array, ratio: float) -> Array:
    """First-order lag, exact for a signal that is linear between the times of the grid."""
    from scipy.signal import lfilter

    left = -math.expm1(-ratio) / ratio
    decay = math.exp(-ratio)
    start = np.array([left * signal[0]])
    rest: Array = lfilter([1.0 - left, left - decay], [1.0, -decay], signal[1:], zi=start)[0]
    return np.concatenate((signal[:1], rest))


def sampled(signal: Array, spacing: float, times: Array) -> Array:
    """A signal at any times by cubic interpolation; before time 0, its first value."""
    from scipy.interpolate import make_interp_spline

    grid = spacing * np.arange(len(signal))
    inside = times > 0.0
    out = np.full(len(times), signal[0])
    last = min(len(signal), int(max(times.max(), 0.0) / spacing) + 8)
    spline = make_interp_spline(grid[:last], signal[:last], k=3)
    out[inside] = spline(times[inside])
    return out


def with_crosstalk(signals: Sequence[Array], units: Sequence[str], share: float) -> list[Array]:
    """Add a fraction of the neighbouring columns in the same unit to each signal."""
    if share == 0.0:
        return list(signals)
    out = []
    for i, signal in enumerate(signals):
        near = [j for j in (i - 1, i + 1) if 0 <= j < len(signals) and units[j] == units[i]]
        out.append(signal + share * sum((signals[j] for j in near), np.zeros(len(signal))))
    return out

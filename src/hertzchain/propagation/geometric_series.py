r"""Continue the pulse of a long uniform or exponential chain by geometric series.

If the masses and the stiffness of a chain grow by constant factors :math:`\mu` and :math:`\kappa`
from bead to bead, the pulse converges to a solution that is the same at each bead except for its
units.  The velocity grows by a factor :math:`\rho` per bead, the overlap :math:`d` like
:math:`(m v^2/k)^{1/(p+1)}` and times :math:`T` like :math:`d/v`,

.. math::

    \frac{d_{k+1}}{d_k} = \left(\frac{\mu \rho^2}{\kappa}\right)^{1/(p+1)}, \qquad
    \frac{T_{k+1}}{T_k} = \frac{1}{\rho} \frac{d_{k+1}}{d_k} .

Therefore a chain of only the first `HEAD` beads is integrated.  Its last beads, near the free end,
give the last beads of the long chain, in other units.  In equal beads :math:`\rho` is exactly 1,
because momentum and energy are conserved.  If the columns of the short chain are not geometric
series, or :math:`\rho` is too uncertain for the length of the chain, the series are not used.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from ..collision import Array
from .batch import ARRIVAL, COLUMNS, PEAK_OVERLAP, PEAK_TIME, RESIDENCE, VELOCITY, Batch, Indices

# Number of beads that are integrated; last bead that the free end does not influence; number of
# beads on which the columns must be geometric series.
HEAD, SETTLED, REPEATED = 240, 200, 60
# Tolerance of the integration if none below it is requested, and largest relative deviation from a
# geometric series.  At smaller tolerances, the integration takes five times as long.
RTOL, REPEATING = 1e-9, 1e-9
# Largest deviation of the logarithms of masses or stiffness from a geometric series.
EQUAL: Final = 1e-11

Follow = Callable[[Batch], Array]


def continue_series(batch: Batch, index: int, rtol: float, follow: Follow) -> Array | None:
    """Columns of a chain of a batch; None if they are not geometric series.

    ``follow`` integrates a batch of one chain to `RTOL` or the smaller ``rtol``.
    """
    beads = int(batch.beads[index])
    begin = int(batch.first[index])
    masses, stiffness = batch.masses[begin : begin + beads], batch.stiffness[begin:][: beads - 1]
    growth = _factor(masses), _factor(stiffness)
    p = float(batch.chain_exponents[index])
    if growth[0] is None or growth[1] is None or not np.isfinite(p):
        return None
    head = follow(_head(batch, begin))
    middle = slice(SETTLED - REPEATED, SETTLED)
    steps = np.diff(np.log(head[VELOCITY, middle]))
    uniform = growth == (0.0, 0.0)
    rate = 0.0 if uniform else float(steps.mean())
    halves = steps[: REPEATED // 2].mean() - steps[REPEATED // 2 :].mean()
    uncertain = 0.0 if uniform else abs(float(halves)) * (beads - HEAD)
    if not uncertain < rtol:
        return None
    overlap = (growth[0] + 2.0 * rate - growth[1]) / (p + 1.0)
    logs = np.array([rate, overlap - rate, overlap - rate, overlap, overlap - rate])
    # The delay of the maximum after the arrival is a geometric series, the times are not.
    head[PEAK_TIME] -= head[ARRIVAL]
    repeated = [VELOCITY, PEAK_TIME, PEAK_OVERLAP, RESIDENCE]
    levels = head[repeated, middle] * np.exp(-logs[repeated, None] * np.arange(REPEATED))
    spread = np.ptp(levels, axis=1) / np.abs(levels).mean(axis=1)
    if not (spread < REPEATING).all():
        return None
    return _continued(head, beads, logs)


def _factor(values: Array) -> float | None:
    """Logarithm of the factor from each value to the next, None if it is not always the same."""
    if values[0] == values[-1] and np.all(values == values[0]):
        return 0.0
    logs = np.log(values)
    mean = float(logs[-1] - logs[0]) / (len(values) - 1)
    off = np.abs(logs - (logs[0] + mean * np.arange(len(values)))).max()
    return mean if off < EQUAL else None


def _head(batch: Batch, begin: int) -> Batch:
    """The first beads as a chain with a free end."""
    end = begin + HEAD
    stiffness = batch.stiffness[begin:end].copy()
    stiffness[-1] = 0.0
    beads: Indices = np.array([HEAD])
    return Batch(
        batch.masses[begin:end], stiffness, batch.exponents[begin:end], np.zeros(1, np.int64), beads
    )


def _continued(head: Array, beads: int, logs: Array) -> Array:
    """Columns of the long chain, from the logarithms of their factors per bead."""
    columns = np.empty((COLUMNS, beads))
    columns[:, :SETTLED] = head[:, :SETTLED]
    middle, end = slice(SETTLED, beads - (HEAD - SETTLED)), slice(beads - (HEAD - SETTLED), beads)
    series = np.exp(logs[:, None] * np.arange(1, beads - HEAD + 1)) if logs.any() else 1.0
    columns[:, middle] = head[:, SETTLED - 1 : SETTLED] * series
    columns[:, end] = head[:, SETTLED:] * np.exp(logs[:, None] * (beads - HEAD))
    after = columns[RESIDENCE, SETTLED - 1 : -1]
    columns[ARRIVAL, SETTLED:] = columns[ARRIVAL, SETTLED - 1] + np.cumsum(after)
    columns[PEAK_TIME] += columns[ARRIVAL]
    return columns

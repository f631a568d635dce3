"""Width of the leading pulse where it passes a bead."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..chain.bead_names import bead_number
from ..errors import InputWarning, SimulationError, warn_user
from ..validation.numbers import whole_number
from .run_pulse import pulse_of, residence_of
from .trajectory import Trajectory
from .velocity_peaks import VelocityPeaks, peaks_from, velocity_peaks_of
from .wave_samples import advised_times, are_few

# Estimated relative error of a width above which there is a warning.  From every second saved time,
# the error is 16 times as large; less if there are very few.
LARGE, DECREASE = 5e-4, 10.0
# Saved times during the passage of a pulse with which the error is about 1e-5 or less.
ENOUGH: Final = 12.0


def pulse_width_of(self: Trajectory, bead: int | str) -> float:
    r"""Width of the leading pulse where it passes a bead, in beads.

    .. math:: w_k = \frac{\Delta t_k}{T_k}

    with the full width at half maximum :math:`\Delta t_k` of the bead's velocity in time,
    ``run.velocity_peaks(bead).widths[0]``, and the residence time :math:`T_k`, in which the
    pulse advances by one bead.  The width of the solitary wave of equal beads is 1.57914
    (p = 3/2).

    Parameters
    ----------
    bead : int or str
        Number k of the bead, 2 to N - 1, or a name such as ``"ball 11"``, as for `Run.sensor`.

    Returns
    -------
    float
        Width from the saved times [beads], with a cubic between two of them.

    Raises
    ------
    InputError
        If there is no such bead, or fewer than two times were saved.
    SimulationError
        If the pulse had not passed the bead when the run stopped, or the velocity does not
        fall to half of its maximum on both sides among the saved times.

    Warns
    -----
    InputWarning
        If the estimated error of the width, from every second saved time, exceeds 0.05%.

    Examples
    --------
    >>> import hertzchain as hc
    >>> run = hc.simulate(hc.Chain.uniform(60), times=2000)
    >>> round(run.pulse_width(40), 3)
    1.579
    """
    number = bead_number(self.chain, bead)
    k = whole_number("bead", number, least=2, most=self.chain.beads - 1)
    if self._peaks[0, k - 1] == 0.0 or np.any(self._crossings[0, k - 2 : k] == 0.0):
        raise SimulationError(
            f"no width of the pulse at bead {k}: {self.message}; simulate for longer"
        )
    residence = residence_of(self.chain, self._crossings)[k - 1]
    if np.isnan(residence):
        notes = pulse_of(self.chain, self._peaks, self._crossings, tails=False).notes
        raise SimulationError(
            f"no width of the pulse at bead {k}: it has no residence time ({notes['residence']})"
        )
    width = _leading_width(self, k, velocity_peaks_of(self, k)) / residence
    if not np.isfinite(width):
        few = f"{_advice(self, k)}, or " * are_few(self, (k - 1, k), ENOUGH)
        raise SimulationError(
            f"no width of the pulse at bead {k}: among the {len(self.times)} saved times its "
            f"velocity does not fall to half of its maximum on both sides; {few}"
            "simulate for longer (until)"
        )
    _check_resolution(self, k, width * residence)
    return float(width)


def _leading_width(run: Trajectory, k: int, peaks: VelocityPeaks) -> float:
    """Width in time of the peak of the leading pulse; NaN if there is none."""
    if not len(peaks):
        return np.nan
    leading = int(np.argmin(np.abs(peaks.times - run._peaks[0, k - 1])))
    return float(peaks.widths[leading])


def _check_resolution(run: Trajectory, k: int, width: float) -> None:
    """Warn if the width from every second time shows that there are too few saved times."""
    few = [_leading_width(run, k, peaks_from(run, k, slice(i, None, 2))) for i in (0, 1)]
    change = max(abs(each / width - 1.0) for each in few)
    error = np.inf if np.isnan(change) else change / DECREASE
    if error > LARGE:
        known = f"of about {100.0 * error:.1g}%" if np.isfinite(error) else "of unknown size"
        samples = width * len(run.times) / float(run.times[-1] - run.times[0])
        warn_user(
            f"the width of the pulse at bead {k} has an error {known}, because only "
            f"{samples:.2g} times were saved while it passes; "
            f"{_advice(run, k)}",
            InputWarning,
        )


def _advice(run: Trajectory, k: int) -> str:
    """Advice on the number of saved times for the pulse at a bead."""
    return advised_times(run, (k - 1, k), ENOUGH)

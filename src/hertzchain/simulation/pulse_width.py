"""Width of the leading pulse where it passes a bead."""

from __future__ import annotations

import numpy as np

from ..chain.bead_names import bead_number
from ..errors import SimulationError
from ..validation.numbers import whole_number
from .run_pulse import residence_of
from .trajectory import Trajectory
from .velocity_peaks import velocity_peaks_of


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
        Width from the saved times [beads].

    Raises
    ------
    InputError
        If there is no such bead, or fewer than two times were saved.
    SimulationError
        If the pulse had not passed the bead when the run stopped, or the velocity does not
        fall to half of its maximum on both sides among the saved times.

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
        raise SimulationError(
            f"no width of the pulse at bead {k}: it is one of several beads that move from the "
            "start, on which a pulse has no residence time"
        )
    peaks = velocity_peaks_of(self, k)
    width = np.nan
    if len(peaks):
        leading = int(np.argmin(np.abs(peaks.times - self._peaks[0, k - 1])))
        width = peaks.widths[leading] / residence
    if not np.isfinite(width):
        raise SimulationError(
            f"no width of the pulse at bead {k}: among the {len(self.times)} saved times its "
            "velocity does not fall to half of its maximum on both sides; save more times, or "
            "simulate for longer (until)"
        )
    return float(width)

"""The time up to which a run is predictable, and the estimated error of its velocities."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..frozen import Compared
from ..representation import measure, short


@dataclass(frozen=True, eq=False)
class Horizon(Compared):
    """Estimated error of a run's velocities, and the time up to which it is small.

    Attributes
    ----------
    chain : Chain
        The chain.
    times : ndarray, shape (T,)
        Saved times of the run [scaled, or s].
    error : ndarray, shape (T,)
        Estimated error of the velocities up to each time, relative to the largest velocity.
    within : float
        Bound of the error.
    rtol, shadow_rtol : float
        Tolerances of the run and of its shadow; NaN for fixed steps.
    step, shadow_step : float
        Fixed steps of the run and of its shadow [scaled, or s]; NaN for the adaptive method.

    Examples
    --------
    >>> import hertzchain as hc
    >>> horizon = hc.simulate(hc.Chain.uniform(20), until=40.0).horizon()
    >>> horizon.time, bool(horizon.error[-1] < 1e-6)
    (inf, True)
    """

    chain: Chain
    times: Array
    error: Array
    within: float
    rtol: float
    shadow_rtol: float
    step: float = np.nan
    shadow_step: float = np.nan

    @property
    def time(self) -> float:
        """First saved time at which the error exceeds ``within``; infinite if it never does."""
        beyond = np.flatnonzero(self.error > self.within)
        return float(self.times[beyond[0]]) if len(beyond) else np.inf

    @property
    def message(self) -> str:
        """Short description of the result."""
        last = self.time if np.isfinite(self.time) else float(self.times[-1])
        time = measure(last, "s", self.chain.units)
        part = f"{100.0 * self.within:g}%"
        if np.isfinite(self.time):
            return f"velocities predictable within {part} until t = {time}"
        return f"velocities predictable within {part} at all saved times, up to t = {time}"

    def _repr_html_(self) -> str:
        from ..notebook.runs import horizon_html

        return horizon_html(self)

    def __repr__(self) -> str:
        compared = f"from rtol {self.rtol:g} against {self.shadow_rtol:g}"
        if np.isnan(self.rtol):
            step, shadow = (
                measure(each, "s", self.chain.units, 3) for each in (self.step, self.shadow_step)
            )
            compared = f"from steps of {step} against {shadow}"
        error = f"estimated error {self.error[-1]:.1e} at the end, {compared}"
        return short("Horizon", "", self.message, error)

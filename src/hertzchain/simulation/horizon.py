r"""How far a run can be predicted: a second integration with another tolerance.

Chains between walls are chaotic: rounding and step errors grow exponentially, although energy
and momentum are conserved to many digits.  The shadow of a run is the same chain integrated with
ten times its tolerance.  The estimated relative error of the velocities is

.. math:: \varepsilon(t) = 10\,\max_{t'\le t}\,
   \frac{\max_k |v_k(t') - \tilde v_k(t')|}{\max_{k,t} |v_k|}

with the velocities :math:`\tilde v_k` of the shadow, and the horizon is the first saved time at
which it exceeds a bound.  The factor 10 is empirical.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from hertzchain.arguments import callback
from hertzchain.chain.chain import Chain
from hertzchain.checks import number
from hertzchain.contacts import Array
from hertzchain.errors import InputError, ModelRangeWarning, SimulationError
from hertzchain.simulation.simulate import LARGEST_RTOL, simulate
from hertzchain.simulation.state import first_state

if TYPE_CHECKING:
    from hertzchain.simulation.run import Run

SAFETY: Final = 10.0
# Tolerance of the shadow, in parts of the run's.
LOOSER: Final = 10.0
# A shadow may take so many times the steps of its run, and at least so many.
STEPS: Final = 100
LEAST_STEP_LIMIT: Final = 10_000_000


@dataclass(frozen=True, eq=False)
class Horizon:
    """Estimated error of a run's velocities, and the time up to which it is small.

    Attributes
    ----------
    chain : Chain
        The chain.
    times : ndarray, shape (T,)
        Saved times of the run [scaled, or s].
    error : ndarray, shape (T,)
        Estimated error of the velocities up to each time, in parts of the largest velocity.
    within : float
        Bound of the error.
    rtol, shadow_rtol : float
        Tolerances of the run and of its shadow.

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

    @property
    def time(self) -> float:
        """First saved time at which the error exceeds ``within``; infinite if it never does."""
        beyond = np.flatnonzero(self.error > self.within)
        return float(self.times[beyond[0]]) if len(beyond) else np.inf

    @property
    def message(self) -> str:
        """The result in a few words."""
        unit = " s" if self.chain.units == "SI" else ""
        part = f"{100.0 * self.within:g}%"
        if np.isfinite(self.time):
            return f"velocities predictable within {part} until t = {self.time:.4g}{unit}"
        return (
            f"velocities predictable within {part} at all saved times, up to t = "
            f"{self.times[-1]:.4g}{unit}"
        )

    def __repr__(self) -> str:
        return (
            f"Horizon({self.message}; estimated error {self.error[-1]:.1e} at the end, from rtol "
            f"{self.rtol:g} against {self.shadow_rtol:g})"
        )


def horizon_of(
    run: Run, within: float = 0.01, progress: Callable[[int, int], None] | None = None
) -> Horizon:
    """Integrate a run's chain again and compare; see `hertzchain.Run.horizon`.

    Parameters
    ----------
    run : Run
        A run with saved times, from the beginning or resumed.
    within : float
        Bound of the error.
    progress : callable, optional
        Called as ``progress(beads_passed, beads)`` a few times a second.

    Returns
    -------
    Horizon

    Examples
    --------
    >>> import hertzchain as hc
    >>> horizon_of(hc.simulate(hc.Chain.uniform(9), until=20.0)).shadow_rtol
    1e-12
    """
    within = number("within", within, above=0.0, below=1.0)
    callback("progress", progress)
    if run.known_horizon is not None:
        return replace(run.known_horizon, within=within)
    if not np.any(run.times > 0.0):
        raise InputError("the run has no saved times to compare: give simulate times of at least 2")
    # Energy and momentum at the beginning; equal but for rounding where units were converted.
    if not np.allclose(run.state.start, first_state(run.chain).start, rtol=1e-9, atol=0.0):
        raise InputError(
            "the run does not begin as its chain is described (its state was reversed): only runs "
            "from the beginning, or resumed ones, have a horizon"
        )
    shadow_rtol = LOOSER * run.rtol
    if shadow_rtol > LARGEST_RTOL:
        shadow_rtol = run.rtol / LOOSER
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ModelRangeWarning)  # the run itself has warned
        shadow = simulate(
            run.chain, times=run.times, rtol=shadow_rtol, check=False, progress=progress,
            max_steps=max(STEPS * run.steps, LEAST_STEP_LIMIT),
        )  # fmt: skip
    if not shadow.success:
        raise SimulationError(
            f"no horizon: the second integration, with rtol = {shadow_rtol:g}, failed; "
            f"{shadow.message}"
        )
    largest = max(float(np.abs(run.velocities).max()), np.finfo(float).tiny)
    error = np.abs(run.velocities - shadow.velocities).max(axis=1) / largest
    return Horizon(
        chain=run.chain, times=run.times, error=SAFETY * np.maximum.accumulate(error),
        within=within, rtol=run.rtol, shadow_rtol=shadow_rtol,
    )  # fmt: skip

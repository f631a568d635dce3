r"""Estimate how long a run is predictable, by a second integration with other steps.

Chains between walls are chaotic: rounding and step errors grow exponentially, although energy
and momentum are conserved to many digits.  The shadow of a run is the same chain integrated with
ten times its tolerance or, if its steps are fixed, with half their length.  The estimated relative
error of the velocities is

.. math:: \varepsilon(t) = 10\,\max_{t'\le t}\,
   \frac{\max_k |v_k(t') - \tilde v_k(t')|}{\max_{k,t} |v_k|}

with the velocities :math:`\tilde v_k` of the shadow, and the horizon is the first saved time at
which it exceeds a bound.  The factor 10 is empirical.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

import numpy as np

from ..errors import InputError, ModelRangeWarning, SimulationError
from ..recorded_warnings import ignore_warnings
from ..validation.numbers import FRACTION, number
from ..validation.objects import Progress, callback
from .horizon import Horizon
from .run import Run
from .simulate import MAX_RTOL, simulate
from .state import first_state

SAFETY: Final = 10.0
# Ratio of the tolerances of the shadow and of the run.
LOOSER: Final = 10.0
# Step limit of a shadow: multiple of the steps of its run, and its minimum.
STEPS: Final = 100
MIN_STEP_LIMIT: Final = 10_000_000


def horizon_of(run: Run, within: float = 0.01, progress: Progress | None = None) -> Horizon:
    """Integrate a run's chain again and compare; see `hertzchain.Run.horizon`."""
    within = number("within", within, unit=FRACTION, above=0.0, below=1.0)
    callback("progress", progress)
    if run.known_horizon is not None:
        return replace(run.known_horizon, within=within)
    if not np.any(run.times > 0.0):
        raise InputError("the run has no saved times to compare: give simulate times of at least 2")
    # Energy and momentum at the beginning; equal except for rounding if units were converted.
    if not np.allclose(run.state.start, first_state(run.chain).start, rtol=1e-9, atol=0.0):
        raise InputError(
            "the run does not begin as its chain is described (its state was reversed): only runs "
            "from the beginning, or resumed ones, have a horizon"
        )
    options, setting = _shadow_options(run)
    with ignore_warnings(ModelRangeWarning):  # The run has already issued it.
        shadow = simulate(
            run.chain, times=run.times, check=False, progress=progress,
            max_steps=max(STEPS * run.steps, MIN_STEP_LIMIT), **options,
        )  # fmt: skip
    if not shadow.success:
        raise SimulationError(
            f"no horizon: the second integration, with {setting}, failed; {shadow.message}"
        )
    largest = max(float(np.abs(run.velocities).max()), np.finfo(float).tiny)
    error = np.abs(run.velocities - shadow.velocities).max(axis=1) / largest
    return Horizon(
        chain=run.chain, times=run.times, error=SAFETY * np.maximum.accumulate(error),
        within=within, rtol=run.rtol, shadow_rtol=options.get("rtol", np.nan),
        step=_step_of(run), shadow_step=options.get("step", np.nan),
    )  # fmt: skip


def _step_of(run: Run) -> float:
    """Length of fixed steps; NaN for the adaptive method."""
    from ..kernels.state_layout import STEP

    return float(run.state.arrays["clock"][STEP]) if np.isnan(run.rtol) else np.nan


def _shadow_options(run: Run) -> tuple[dict[str, Any], str]:
    """Options of the second integration, and their description."""
    if np.isnan(run.rtol):
        step = 0.5 * _step_of(run)
        return {"method": run.method, "step": step}, f"steps of {step:.3g}"
    rtol = LOOSER * run.rtol
    if rtol > MAX_RTOL:
        rtol = run.rtol / LOOSER
    return {"rtol": rtol}, f"rtol = {rtol:g}"

"""Repeat a run with saved times that resolve the force on its last body."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from ..collision import Array
from ..errors import InputError, SimulationError
from .saved_times import check_memory_for
from .simulate import default_step_limit, simulate
from .state import State, first_state

if TYPE_CHECKING:
    from .run import Run

# The force is resolved if the velocity of the last body changes between two saved times by at most
# this part of the sum of its changes; the largest force then has an error of about its square.
RESOLVED: Final = 1.0 / 400.0
# Evenly spaced times of a first repetition, and their largest number with all beads.
EVEN_TIMES, MAX_STATES = 4000, 4_000_000
MIN_TIMES: Final = 400
# Parts into which an interval is divided by the next repetition, and their largest number.
PARTS: Final = 40
REPETITIONS: Final = 4
# Repetitions with more times around the largest force, in chains with losses.
AROUND: Final = 2
# Difference of the velocities at the ends of the same motion, over the largest.
SAME: Final = 1e-6


def resolved(run: Run) -> Run:
    """The run, or its repetition with times at which the last body changes its velocity.

    Between two saved times the impulse on this body is the change of its momentum, so that no pulse
    is missed between them.
    """
    run = fine = _from_the_chain(run)
    for _ in range(REPETITIONS):
        times = _more_times(fine, run)
        if times is None:
            break
        fine = _again(run, times)
    if run.chain.lossless:
        return fine
    # The force of a contact that yields is largest at a corner, and that of a dashpot at a jump.
    for _ in range(AROUND):
        fine = _again(run, _around_largest(fine))
    return fine


def _more_times(fine: Run, run: Run) -> Array | None:
    """Times of the next repetition; `None` if those of a run resolve the force."""
    first, last = _start_of(run).time, run.end_time
    times = fine.times
    if len(times) < MIN_TIMES or times[0] > first or times[-1] < last:
        number = int(np.clip(MAX_STATES // run.chain.beads, MIN_TIMES, EVEN_TIMES))
        return np.linspace(first, last, number)
    changes = np.abs(np.diff(fine.velocities[:, -1]))
    coarse = np.flatnonzero(changes > RESOLVED * changes.sum())
    if not len(coarse):
        return None
    inside = np.arange(1, PARTS) / PARTS
    added = times[coarse, np.newaxis] + np.outer(np.diff(times)[coarse], inside)
    found: Array = np.union1d(times, added)
    check_memory_for(run.chain, found.size)
    return found


def _around_largest(fine: Run) -> Array:
    """The times of a run, and more of them on both sides of the largest force on the last body."""
    times = fine.times
    i = int(np.argmax(fine.sensor(fine.chain.beads)))
    low, high = times[max(i - 2, 0)], times[min(i + 2, len(times) - 1)]
    return np.union1d(times, np.linspace(low, high, 4 * PARTS))


def _start_of(run: Run) -> State:
    """The state from which a run began; that of its chain if none was given."""
    given: State | None = run.__dict__.get("_start")
    return first_state(run.chain) if given is None else given


def _from_the_chain(run: Run) -> Run:
    """The run itself or, if it was resumed, the uninterrupted one, if the latter ends alike."""
    if not _start_of(run).time > 0.0:
        return run
    try:
        return _repeated(run, np.array([0.0, run.end_time]), None)
    except (InputError, SimulationError):
        return run


def _again(run: Run, times: Array) -> Run:
    """The same run with other saved times."""
    return _repeated(run, times, run.__dict__.get("_start"))


def _repeated(run: Run, times: Array, start: State | None) -> Run:
    """The same run with other saved times, from a state or from the chain."""
    from ..kernels.state_layout import STEP

    options: dict[str, Any] = {"rtol": run.rtol}
    if np.isnan(run.rtol):
        step = float(run.state.arrays["clock"][STEP])
        options = {"method": run.method, "step": step}
    else:
        options["max_steps"] = max(default_step_limit(run.chain.beads), 2 * run.steps)
    again = simulate(run.chain, times=times, start=start, **options)
    if start is None and not _same_end(run, again):
        raise SimulationError("the run began with dents or from another state that is not known")
    return again


def _same_end(run: Run, again: Run) -> bool:
    """Whether the last known velocities of both runs are the same, except for rounding."""
    if run.state.time == again.state.time:
        one, two = run.state.velocities, again.state.velocities
    else:
        saved = len(run.times) > 0 and run.times[-1] == run.end_time
        one = run.velocities[-1] if saved else run.state.velocities
        two = again.velocities[-1]
    return bool(np.abs(one - two).max() <= SAME * np.abs(two).max())

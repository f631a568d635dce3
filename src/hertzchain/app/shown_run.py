"""The run that the page shows, which is at least as long as that of `hertzchain simulate`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, Final

from ..chain.chain import Chain
from ..errors import InputError, SimulationError
from ..pulse.pulse import Pulse
from ..recorded_warnings import record_warnings
from ..simulation.body_force import body_force
from ..simulation.run import Run
from ..simulation.simulate import simulate
from .force_curves import contact_durations
from .requests import Request
from .shown_times import saved_times

# Number of times that a run is continued to twice its time if nothing has reached the wall.
MAX_CONTINUATIONS: Final = 4
# The run that is shown lasts at least until this multiple of the time of the peak on the wall
# or on the cap.
END_AFTER_PEAK: Final = 1.05


def motion(
    chain: Chain, exact: Pulse | None, request: Request, progress: Callable[..., None]
) -> tuple[Run, Run, list[Warning]]:
    """The run that is shown, and the same run continued until the peak on the wall is complete.

    If the peak becomes complete, the run that is shown is as long as that of `simulate` without
    ``until``; otherwise it includes the largest force.  The same applies to the force on a cap
    behind the row.  Drafts are not continued.  The warnings are those of the longest run: earlier
    ones state smaller overlaps.
    """
    options: dict[str, Any] = {"rtol": request.rtol, "check": False, "progress": progress}
    with record_warnings():
        end = request.run_until
        times = saved_times(chain, exact, request.frames, request.clock, progress, end)
    with record_warnings() as warned:
        run = simulate(chain, times=times, **options)
    if request.draft or not run.success:
        return run, run, warned
    if chain._free_cap:
        return _to_the_end_on_the_cap(run, exact, request, options, warned)
    if chain.right_wall is None or run._wall_force("right").complete_since is not None:
        return run, run, warned
    try:
        with record_warnings() as of_whole:
            whole = _to_the_wall(simulate(chain, start=run.state, times=0, **options), options)
    except (InputError, SimulationError):
        # Nothing ends this run, for example because its drive does not end, or it takes too long.
        return run, run, warned
    wall = whole._wall_force("right")
    later = END_AFTER_PEAK * wall.largest_so_far_time
    # The impact need not have ended, as on a soft wall that is still loaded after its peak.
    if wall.complete:
        later = max(later, whole.end_time, request.run_until)
    if later > times[-1]:
        peak = wall.largest_so_far_time
        lasting = contact_durations(chain, whole.largest_overlaps)[-1]
        with record_warnings(), suppress(SimulationError):  # The longer run may take too long.
            times = saved_times(
                chain, exact, request.frames, request.clock, progress, later, peak, lasting
            )
            run = simulate(chain, times=times, **options)
    return run, whole, of_whole


def _to_the_end_on_the_cap(
    run: Run, exact: Pulse | None, request: Request, options: dict[str, Any], warned: list[Warning]
) -> tuple[Run, Run, list[Warning]]:
    """The run that is shown and that of `simulate` without ``until``, as `motion` returns them."""
    chain = run.chain
    try:
        with record_warnings() as of_whole:
            whole = simulate(chain, times=0, **options)
    except (InputError, SimulationError):
        return run, run, warned
    found = body_force(whole)
    if not whole.success or found is None or whole.end_time <= run.end_time:
        return run, run, warned
    later = whole.end_time if found.complete else END_AFTER_PEAK * found.time
    if later > run.end_time:
        with record_warnings(), suppress(SimulationError):  # The longer run may take too long.
            times = saved_times(
                chain, exact, request.frames, request.clock, options["progress"], later
            )
            run = simulate(chain, times=times, **options)
    return run, whole, of_whole


def _to_the_wall(run: Run, options: Mapping[str, Any]) -> Run:
    """Continue a run that has reached its longest time before any bead has reached the wall."""
    for _ in range(MAX_CONTINUATIONS):
        if run.status != "transit limit" or run._wall_force("right").largest_so_far > 0.0:
            break
        later = simulate(run.chain, start=run.state, until=2.0 * run.end_time, times=0, **options)
        if later._wall_force("right").largest_so_far > 0.0:
            return later
        run = later
    return run

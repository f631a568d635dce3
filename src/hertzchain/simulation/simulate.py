"""Integrate the equation of motion of a chain, for all beads.

`simulate` returns the trajectories as a `Run`.  `hertzchain.propagate` is faster if only the
leading pulse is needed.
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from ..chain.chain import Chain
from ..chain.drives import TableDrive
from ..chain.feature_support import require_chain
from ..chain.hertz_warnings import warn_outside_hertz
from ..chain.loss_range import warn_outside_losses
from ..collision import Array
from ..errors import InputError, SimulationError
from ..representation import counted, measure
from ..validation.keywords import checked_arguments
from ..validation.numbers import number, whole_number
from ..validation.objects import Progress, callback, check_bool
from .checked_state import check_start
from .fixed_steps import FixedLoop, FixedSteps, fixed_steps
from .frames import Frames
from .kernel_input import kernel_chain
from .run import Run
from .run_end import NATURAL_ENDS, RunEnd, Status
from .run_message import NOT_STRUCK
from .slow_run import slow_run_notice
from .state import State, contacts_of, first_state
from .time_scales import check_clock, check_length, fall_height

DEFAULT_RTOL: Final = 1e-13
MIN_RTOL, MAX_RTOL = 1e-14, 1e-6
# Default step limit per bead, and its minimum, for short chains with a light bead that bounces.
STEPS_PER_BEAD: Final = 2_000
MIN_STEP_LIMIT: Final = 1_000_000
# Work of one call of the compiled loop, in bead-steps.  A call takes a fraction of a second, after
# which progress is reported and interrupts are handled.
BEAD_STEPS_PER_CALL: Final = 1_000_000
# Smaller accelerations have lost digits, and the steps would shrink indefinitely.
MIN_ACCELERATION: Final = 1e-290
# Default step limit of fixed steps.
MAX_FIXED_STEPS: Final = 10**12


@checked_arguments("simulate")
def simulate(
    chain: Chain,
    *,
    until: float | str | None = None,
    times: int | ArrayLike = 400,
    start: State | None = None,
    rtol: float = DEFAULT_RTOL,
    method: str = "adaptive",
    step: float | None = None,
    drift: float | None = None,
    max_steps: int | None = None,
    check: bool = True,
    progress: Progress | None = None,
) -> Run:
    r"""Integrate the equation of motion of all beads of a chain.

    .. math:: m_k \ddot x_k = F_{k-1} - F_k + X_k

    This is Eq. (4) of the paper with the contact forces of the loss law (`hertzchain.chain.laws`),
    including those of the walls, and the sum :math:`X_k` of the external forces on bead k: its
    weight, the drive, and the force that holds an end of the chain.  Steps are adaptive.  The
    method is RKN8(6), of order 8, if forces depend on positions and time only; otherwise DOP853, of
    order 8, or, if damping is very strong, the implicit Radau IIA of order 9.  The error of a step
    is measured, bead by bead, relative to the speeds within three beads.  If a force jumps or
    depends on history, the time of the change is located and the step ends there.

    Parameters
    ----------
    chain : Chain
        The chain.
    until : float or str, optional
        Stop time [scaled, or s; also with a unit, ``"2 ms"``]; by default the last of the given
        ``times``.  If ``times`` is a number, a chain with a right wall runs until the largest force
        on the wall is complete and the impact has ended (see `hertzchain.simulation.wall_watch`),
        at most for ten transits of the pulse, 20 if the left end is free, or, for soft walls and
        heavy strikers, for the first transit and twice the time in which all beads, as one body,
        would rebound from the row.  Any other chain runs until the pulse has left, that is, until
        every bead has passed its first velocity maximum; with a cap behind the row, it continues
        until no larger force on the cap can follow (`hertzchain.simulation.body_bound`), at most
        for 50 times as long, and with gravity or precompression, for which there is no such proof,
        not at all.  If the chain falls from rest, transits are counted from the end of the fall.
        Required for a drive without an end.
    times : int or array_like
        Times at which to save the state: increasing numbers >= 0, or the number of evenly spaced
        times.  If ``until`` is given, exactly this number of times is saved, otherwise at most
        this number and at least half of it.
    start : State, optional
        State to resume from, such as ``run.state``; times continue those of the earlier run.  By
        default, the chain starts at time 0.
    rtol : float
        Relative tolerance per step of the adaptive method, 1e-14 .. 1e-6.
    method : str
        ``"adaptive"``, or ``"symplectic"`` for long runs of elastic chains without a drive: fixed
        steps of a splitting method, ``"verlet"`` or ``"forward-4"``, which can also be chosen.
        Single velocities are less accurate.
    step : float, optional
        Step of the symplectic method [scaled, or s]; by default it follows from ``drift``.
    drift : float, optional
        Largest energy drift of a symplectic run, 1e-11 .. 1e-2; by default 1e-5.  Drift and
        length determine method (velocity Verlet, or a forward method of order 4) and step; a run
        that exceeds the drift is repeated with shorter steps.  ``run.energy_drift`` is the drift
        found.
    max_steps : int, optional
        Step limit; by default 2000 per bead, and at least a million (10^12 with fixed steps).
    check : bool
        Whether to raise an error if the run fails; otherwise check ``run.status``.
    progress : callable, optional
        Called as ``progress(beads_passed, beads)`` a few times per second; strikers are not
        counted.  By default, a run that takes longer than five seconds writes a line to standard
        error every five seconds, if that is a terminal or a notebook.

    Raises
    ------
    InputError
        For an option out of its range, a state of another chain, a chain that requires
        ``until``, or trajectories that do not fit in memory.
    SimulationError
        If the run fails and ``check`` is true.

    Warns
    -----
    ModelRangeWarning
        If a chain of materials has left the range of Hertz's law (`hertz_range`), or a
        relaxation time exceeds the duration of the contacts.

    Notes
    -----
    Without walls, the computing time of equal beads grows with their number, because only beads
    near the pulse are integrated.  With a wall it grows faster than the square of the number,
    because the run continues, with all beads in motion, until no larger force on the wall can
    follow: seconds for 2000 equal beads, more than a minute for 5000.  A value of ``until``
    shortly after the pulse arrives at the wall avoids this.

    Examples
    --------
    >>> import hertzchain as hc
    >>> run = hc.simulate(hc.Chain.tapered("forward-linear", 0.01, beads=60))
    >>> run.energy_drift < 1e-10
    True

    Follow the progress of a long run:

    >>> def show(passed, beads):
    ...     print(f"{passed} of {beads} beads")
    >>> run = hc.simulate(hc.Chain.uniform(5), progress=show)
    2 of 5 beads
    4 of 5 beads
    5 of 5 beads
    """
    require_chain("simulate", chain)
    callback("progress", progress)
    check = check_bool("check", check)
    rtol = checked_rtol(rtol)
    if until is not None:
        until = number("until", until, unit=chain._unit("s"), above=0.0)
        check_length(chain, until)
    fixed = fixed_steps(chain, method, step, drift, until)
    usual = default_step_limit(chain.beads) if fixed is None else MAX_FIXED_STEPS
    limit = usual if max_steps is None else whole_number("max_steps", max_steps, least=1)
    check_clock(chain)
    if start is None:
        start = first_state(chain)
    else:
        check_start(chain, start)
    _check_end(chain, until, times, start.time)
    warn_outside_losses(chain)
    frames = Frames(chain, start.time, until, times)
    if until is None and not isinstance(times, int | np.integer):
        until = float(frames.times[-1])
    run = _integrate(chain, start, until, frames, rtol, limit, progress, fixed)
    while fixed is not None and not fixed.given and fixed.exceeded(run.energy_drift):
        fixed = fixed.shorter(run.energy_drift / fixed.drift)
        frames = Frames(chain, start.time, until, times)
        run = _integrate(chain, start, until, frames, rtol, limit, progress, fixed)
    # `body_force` may repeat the run.
    run.__dict__["_start"] = start
    if check and not run.success:
        raise SimulationError(run.message)
    if fixed is not None:
        fixed.warn(run.energy_drift)
    if chain.materials is not None:
        warn_outside_hertz(chain, run.largest_overlaps, _before_the_end(run), method="simulation")
    return run


def _before_the_end(run: Run) -> str:
    """That overlaps may still grow if a run ends before the pulse; empty otherwise."""
    beads = run.chain.beads - run.chain.strikers
    if run.status in NATURAL_ENDS or run.beads_passed >= beads:
        return ""
    return (
        f"this is the largest value so far: the run ends when the pulse has passed "
        f"{run.beads_passed} of {counted(beads, 'bead')}, and a larger one may follow"
    )


def simulate_to_peak(
    chain: Chain, *, rtol: float, max_steps: int | None, progress: Progress
) -> Run:  # fmt: skip
    """A run without saved times that ends when no larger force on the right wall can follow."""
    check_clock(chain)
    _check_end(chain, None, 0, 0.0)
    start = first_state(chain)
    frames = Frames(chain, start.time, None, 0)
    limit = max_steps or default_step_limit(chain.beads)
    run = _integrate(chain, start, None, frames, rtol, limit, progress, None, at_peak=True)
    if not run.success:
        raise SimulationError(run.message)
    return run


def checked_rtol(rtol: float) -> float:
    """Check the tolerance per step, 1e-14 .. 1e-6."""
    return number("rtol", rtol, least=MIN_RTOL, most=MAX_RTOL)


def default_step_limit(beads: int) -> int:
    """Largest number of steps of a run, unless another one is given."""
    return max(STEPS_PER_BEAD * beads, MIN_STEP_LIMIT)


class _Integration:
    """A state during a run, the compiled loop that advances it, and its scratch arrays."""

    def __init__(
        self, chain: Chain, start: State, frames: Frames, rtol: float, fixed: FixedSteps | None
    ) -> None:
        from ..kernels import full_chain, state_layout

        self.kernel: Any = full_chain
        self.state = start.copy()
        arrays = self.state.arrays
        self.clock, self.counts = arrays["clock"], arrays["counts"]
        self.counts[state_layout.FRAMES] = 0
        self.equation = kernel_chain(chain)
        self.is_default = len(arrays["y"]) == 2 * chain.beads
        self.contacts = contacts_of(arrays, self.equation)
        frames.allocate(len(arrays["y"]), 0 if self.is_default else chain.beads + 1)
        self.frames, self.rtol, self.fixed = frames, rtol, fixed
        self.loop = None if fixed is None else FixedLoop(chain, fixed)
        if fixed is not None:
            # Fixed steps are taken for all beads.
            self.counts[[state_layout.LOW, state_layout.HIGH]] = 0, chain.beads
            self.clock[[state_layout.STEP, state_layout.IDLE_UNTIL]] = fixed.step, np.inf
        self.accelerations = np.zeros(chain.beads)
        self.scratch = (
            np.zeros(full_chain.ROWS * len(arrays["y"])), np.empty((2, chain.beads + 1)),
            np.zeros((3, chain.beads), np.bool_),
        )  # fmt: skip

    def advance(self, end: tuple[float, bool], steps: int, pause: bool) -> int:
        """Take at most this number of steps; return a code for the reason to stop."""
        arrays, frames = self.state.arrays, self.frames
        if self.loop is not None:
            return self.loop.advance(self, end, steps, BEAD_STEPS_PER_CALL, pause)
        code: int = self.kernel.advance(
            arrays["y"], self.clock, self.counts, self.equation, self.contacts,
            arrays["flights"], *end, self.rtol, steps, BEAD_STEPS_PER_CALL, pause, frames.times,
            frames.spacing is not None, frames.states, frames.forces, arrays["peaks"],
            arrays["crossings"], arrays["walls"], self.accelerations, *self.scratch,
        )  # fmt: skip
        return code

    @property
    def forces(self) -> Array:
        """Forces in the contacts, including the walls; empty for a default chain."""
        return np.empty(0) if self.contacts is None else np.asarray(self.contacts.last_force)

    @property
    def method(self) -> str:
        """Name of the method of the steps."""
        if self.fixed:
            return self.fixed.name
        if self.contacts is None or self.contacts.on_positions:
            return "RKN8(6)"
        return "Radau IIA" if self.contacts.implicit is not None else "DOP853"

    @property
    def drifts(self) -> bool:
        """Whether energy has drifted more than accepted; shorter steps are then needed."""
        return self.fixed is not None and self.fixed.exceeded(self.energy_drift)

    @property
    def energy_drift(self) -> float:
        """Largest error of the energy balance so far, relative to the largest energy."""
        from ..kernels import state_layout

        # At rest under static forces, the energy stored in contacts sets the rounding.
        largest = self.clock[state_layout.ENERGY_UNIT]
        unit = max(largest, abs(self.clock[state_layout.INITIAL_ENERGY]))
        return _part(self.clock[state_layout.ENERGY_DRIFT], unit)

    @property
    def underflows(self) -> bool:
        """Whether accelerations have become too small for full precision."""
        from ..kernels import state_layout

        arrived, velocity = self.state.arrays["peaks"][:, self.counts[state_layout.PEAKS]]
        # The velocity of the last bead that the pulse has reached shows whether it has vanished.
        vanished = abs(velocity) < MIN_ACCELERATION * arrived
        return bool(vanished or 0.0 < np.max(np.abs(self.accelerations)) < MIN_ACCELERATION)


def _integrate(
    chain: Chain,
    start: State,
    until: float | None,
    frames: Frames,
    rtol: float,
    max_steps: int,
    progress: Progress | None,
    fixed: FixedSteps | None,
    *,
    at_peak: bool = False,
) -> Run:
    from ..kernels import state_layout

    progress = progress or slow_run_notice()
    integration = _Integration(chain, start, frames, rtol, fixed)
    kernel, counts = integration.kernel, integration.counts
    end = RunEnd(chain, integration.state.arrays, until, fixed=fixed is not None, at_peak=at_peak)
    first = int(counts[state_layout.STEPS])
    status: Status | None = None
    # A longer run resumes bit for bit from the state before the last, shortened step.
    before_end: State | None = None
    while status is None:
        goal = end.goal() if before_end is None else (end.until, False)
        steps = min(end.steps, max_steps - int(counts[state_layout.STEPS]) + first)
        code = integration.advance(goal, steps, before_end is None)
        passed = 1 + int(min(counts[state_layout.PEAKS], counts[state_layout.CROSSINGS]))
        progress(max(0, passed - chain.strikers), chain.beads - chain.strikers)
        status = end.after(code, kernel, integration.forces)
        if code == kernel.FRAMES_FULL:
            counts[state_layout.FRAMES] = frames.thin_out(int(counts[state_layout.FRAMES]))
        elif code == kernel.LAST_STEP and goal[0] == until:
            before_end = integration.state.copy()
        elif integration.drifts:
            status = "unstable steps"
        elif code == kernel.RUNNING and counts[state_layout.STEPS] - first >= max_steps:
            status = "step limit"
        slow = code in (kernel.RUNNING, kernel.STEP_TOO_SMALL, kernel.PULSE_LOST)
        if slow and integration.underflows:
            status = "underflow"
    state = before_end or integration.state.copy()
    return _run(integration, state, status, end.assess(integration.forces))


def _run(
    integration: _Integration, state: State, status: Status, walls: tuple[Array, Array]
) -> Run:
    from ..kernels import forces, state_layout

    clock, counts = integration.clock, integration.counts
    arrays, frames, beads = integration.state.arrays, integration.frames, state.chain.beads
    filled = int(counts[state_layout.FRAMES])
    saved = frames.states[:filled]
    accumulators, now = saved[:, 2 * beads :], arrays["y"][2 * beads :]
    if integration.is_default:
        accumulators, now = np.zeros((filled, forces.ACCUMULATORS)), np.zeros(forces.ACCUMULATORS)
    return Run(
        chain=state.chain,
        times=frames.times[:filled],
        positions=saved[:, :beads] + state.chain.static_state.positions,
        velocities=saved[:, beads : 2 * beads],
        status=status,
        end_time=float(clock[state_layout.TIME]),
        energy_drift=integration.energy_drift,
        momentum_drift=_part(clock[state_layout.MOMENTUM_DRIFT], clock[state_layout.MOMENTUM_UNIT]),
        steps=int(counts[state_layout.STEPS]),
        evaluations=int(counts[state_layout.EVALUATIONS]),
        rtol=integration.rtol if integration.fixed is None else math.nan,
        method=integration.method,
        state=state,
        _forces=None if integration.is_default else frames.forces[:filled],
        _accumulators=accumulators,
        _peaks=arrays["peaks"],
        _crossings=arrays["crossings"],
        _walls=arrays["walls"],
        _impulses=now[[forces.LEFT_IMPULSE, forces.RIGHT_IMPULSE]],
        _completion=arrays["completion"],
        _approaches=walls[0],
        _complete=walls[1],
    )


def _part(drift: float, unit: float) -> float:
    """A drift relative to its unit; 0 if nothing ever moved."""
    return float(drift / unit) if unit > 0.0 else 0.0


def _check_end(chain: Chain, until: float | None, times: int | ArrayLike, begin: float) -> None:
    """Raise `InputError` if ``until`` has passed, or is missing where nothing else ends the run."""
    if until is not None and until <= begin:
        start, end = (measure(each, "s", chain.units, digits=6) for each in (begin, until))
        raise InputError(f"the run starts at t = {start} and cannot stop at until = {end}")
    if until is not None or not isinstance(times, int | np.integer):
        return
    if chain.drive is None and chain.velocities[0] < 0.0 and not chain.velocities[1:].any():
        speed = measure(chain.velocities[0], "m/s", chain.units)
        raise InputError(
            f"bead 1 moves away from the chain (velocity {speed}), so there is no impact; give a "
            "positive velocity, or until"
        )
    if chain.drive is None and not (chain.velocities[0] > 0.0 or fall_height(chain) > 0.0):
        raise InputError(f"{NOT_STRUCK}, or until")
    if chain.drive is not None and chain.right_wall is None:
        raise InputError(
            "this chain is driven and its right end is free, so nothing ends the run; give "
            "until or a right_wall"
        )
    if chain.drive is not None and not np.isfinite(chain.drive.end):
        table = isinstance(chain.drive, TableDrive)
        ending = ", or let its table end with 0 (end=... of load_drive)" if table else ""
        raise InputError(
            f"the drive of this chain does not end, so the run would not end; give until{ending}"
        )
    pushes = chain.static_state.body_forces
    if chain.right_wall is None and pushes.sum() > 1e-9 * np.abs(pushes).sum():
        raise InputError(
            "gravity accelerates this chain towards its free right end, so the last bead never "
            "passes a velocity maximum; give until or a right_wall"
        )

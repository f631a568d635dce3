"""Integrate a chain's equation of motion: every bead, every contact.

`simulate` keeps the trajectories as a `Run`; `hertzchain.propagate` is for those who
want the leading pulse alone.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from hertzchain.arguments import callback, instance, truth
from hertzchain.chain.chain import Chain
from hertzchain.chain.coverage import check_chain
from hertzchain.chain.equilibrium import equilibrium
from hertzchain.chain.hertz_range import warn_outside_hertz
from hertzchain.checks import number, real_numbers, whole_number
from hertzchain.contacts import Array
from hertzchain.errors import InputError, SimulationError, shown
from hertzchain.simulation._run_end import RunEnd, Status
from hertzchain.simulation.checked_state import check_state
from hertzchain.simulation.equations import equation_of, transit_times
from hertzchain.simulation.run import Run
from hertzchain.simulation.state import State, contacts_of, first_state, same_motion

Progress = Callable[[int, int], None]

DEFAULT_RTOL: Final = 1e-13
LEAST_RTOL, LARGEST_RTOL = 1e-14, 1e-6
# Default step limit: for long chains, and for short ones with a light bead that rattles.
STEPS_PER_BEAD: Final = 2_000
LEAST_STEP_LIMIT: Final = 1_000_000
# Work of one call of the compiled loop, in bead-steps: a fraction of a second, after
# which progress is told and an interrupt is heard.
BEAD_STEPS_PER_CALL: Final = 1_000_000
# Below this, accelerations have lost digits and the steps would shrink without end.
SMALLEST_ACCELERATION: Final = 1e-290
# Steps are parts of the time of a contact, and must be numbers too.
SHORTEST_CONTACT: Final = 1e-280


def simulate(
    chain: Chain,
    *,
    until: float | None = None,
    times: int | ArrayLike = 400,
    start: State | None = None,
    rtol: float = DEFAULT_RTOL,
    max_steps: int | None = None,
    check: bool = True,
    progress: Progress | None = None,
) -> Run:
    r"""Integrate the equation of motion of a chain, Eq. (4) of the paper and beyond.

    .. math:: m_k \ddot x_k = F_{k-1} - F_k + X_k

    with the contact forces of the chain's law (`hertzchain.chain.losses`), those of its walls, and
    :math:`X_k` its weight, drive and whatever holds its ends.  The method is the Runge-Kutta
    pair DOP853 (order 8, adaptive), applied to every bead; the error of a step is
    measured, bead by bead, against the speeds within three beads.  Where a law's force
    jumps or remembers, the moment is located and the step ends there.

    Parameters
    ----------
    chain : Chain
        The chain.
    until : float, optional
        Time to stop at [scaled, or s].  By default the last of the given ``times``.  If they are
        a number, a chain with a right wall runs until the largest force on the wall is complete
        (see `hertzchain.simulation.wall_bound`), which takes 1.5 to 10 transits of the pulse, and
        at most ten; any other runs until the pulse has left: until every bead has passed its
        first velocity maximum.  A drive without an end needs it.
    times : int or array_like
        Times at which to save the state: increasing numbers >= 0, or
        a number of evenly spaced ones (exactly so many if ``until`` is given, else
        at most so many and at least half of them).
    start : State, optional
        State to go on from, such as ``run.state``; times are then those of the run that
        it is from.  By default the chain at time 0.
    rtol : float
        Tolerated error of a step, 1e-14 .. 1e-6.
    max_steps : int, optional
        Step limit; by default 2000 per bead, and at least a million.
    check : bool
        Raise if the run fails; otherwise look at ``run.status``.
    progress : callable, optional
        Called as ``progress(beads_passed, beads)`` a few times a second.

    Returns
    -------
    Run

    Raises
    ------
    InputError
        For an option out of its range, a state of another chain, a chain that needs ``until``,
        or trajectories that do not fit in memory.
    SimulationError
        If the run fails and ``check`` is true.

    Warns
    -----
    ModelRangeWarning
        If a chain of materials has left the range of Hertz' law; see
        `hertzchain.chain.hertz_range`.

    Examples
    --------
    >>> import hertzchain as hc
    >>> run = hc.simulate(hc.Chain.tapered("forward-linear", 0.01, beads=60))
    >>> run.energy_drift < 1e-10
    True
    """
    check_chain("simulate", chain)
    callback("progress", progress)
    check = truth("check", check)
    rtol = checked_rtol(rtol)
    if until is not None:
        until = number("until", until, unit=chain._unit("s"), above=0.0)
    usual = max(STEPS_PER_BEAD * chain.beads, LEAST_STEP_LIMIT)
    limit = usual if max_steps is None else whole_number("max_steps", max_steps, least=1)
    _check_clock(chain)
    if start is None:
        start = first_state(chain)
    instance("start", start, State, "run.state is one")
    if not same_motion(chain, start.chain):
        raise InputError(
            f"the state to start from is one of another chain ({start.chain.description}): "
            "give simulate the chain that it is from"
        )
    check_state(start)
    _check_end(chain, until, times, start.time)
    frames = _Frames(chain, start.time, until, times)
    if until is None and not isinstance(times, int | np.integer):
        until = float(frames.times[-1])
    run = _integrate(chain, start, until, frames, rtol, limit, progress)
    if check and not run.success:
        raise SimulationError(run.message)
    warn_outside_hertz(chain, run.largest_overlaps)
    return run


def checked_rtol(rtol: float) -> float:
    """A tolerance of a step, 1e-14 .. 1e-6.

    Parameters
    ----------
    rtol : float
        What was given.

    Returns
    -------
    float

    Raises
    ------
    InputError
        If it is out of this range.

    Examples
    --------
    >>> checked_rtol(1e-13)
    1e-13
    """
    return number("rtol", rtol, least=LEAST_RTOL, most=LARGEST_RTOL)


class _Frames:
    """Times to save at, and what is saved.

    Where the end is not known, the grid starts too fine; whenever it is full, every second
    time is dropped and the spacing doubled, so that memory stays what was asked for.
    """

    def __init__(
        self, chain: Chain, begin: float, until: float | None, times: int | ArrayLike
    ) -> None:
        self.spacing: float | None = None
        self.begin = begin
        if not isinstance(times, int | np.integer) or isinstance(times, bool):
            self.times = _checked_times(chain, times, begin, until)
        elif (count := whole_number("times", times, least=0)) == 1:
            raise InputError("times must be 0 or at least 2 when it is a number, got 1")
        else:
            _check_memory(chain, count)
            if until is None and count > 0:
                self.spacing = 0.5 * float(transit_times(chain).sum()) / count
                self.times = begin + self.spacing * np.arange(count)
            else:
                self.times = np.linspace(begin, until or 0.0, count)
        self.states, self.forces = np.empty((0, 0)), np.empty((0, 0))

    def allocate(self, length: int, contacts: int) -> None:
        """Room for states of so many components and forces of so many contacts."""
        self.states = np.empty((len(self.times), length))
        self.forces = np.empty((len(self.times), contacts))

    def thin_out(self, filled: int) -> int:
        """Make room for later times; returns how many of the filled ones are kept."""
        assert self.spacing is not None
        kept = (filled + 1) // 2
        for saved in (self.states, self.forces):
            saved[:kept] = saved[:filled:2].copy()
        self.spacing *= 2.0
        self.times = self.begin + self.spacing * np.arange(len(self.times))
        return kept


class _Integration:
    """A state on its way, the compiled loop that moves it, and the loop's scratch."""

    def __init__(self, chain: Chain, start: State, frames: _Frames, rtol: float) -> None:
        from hertzchain.kernels import full_chain, records

        self.kernel: Any = full_chain
        self.state = start.copy()
        arrays = self.state.arrays
        self.clock, self.counts = arrays["clock"], arrays["counts"]
        self.counts[records.FRAMES] = 0
        self.equation = equation_of(chain)
        self.plain = len(arrays["y"]) == 2 * chain.beads
        self.contacts = contacts_of(arrays, self.equation)
        frames.allocate(len(arrays["y"]), 0 if self.plain else chain.beads + 1)
        self.frames, self.rtol = frames, rtol
        length = len(arrays["y"])
        self.accelerations = np.zeros(chain.beads)
        self.scratch = (
            np.zeros(full_chain.ROWS * length),
            np.empty((2, chain.beads + 1)),
            np.zeros((2, chain.beads), np.bool_),
        )

    def advance(self, end: tuple[float, bool], steps: int, pause: bool) -> int:
        """Take up to so many steps; returns why it stopped."""
        arrays, frames = self.state.arrays, self.frames
        code: int = self.kernel.advance(
            arrays["y"], self.clock, self.counts, self.equation, self.contacts, *end,
            self.rtol, steps, pause, frames.times, frames.spacing is not None, frames.states,
            frames.forces, arrays["peaks"], arrays["crossings"], arrays["walls"],
            self.accelerations, *self.scratch,
        )  # fmt: skip
        return code

    @property
    def forces(self) -> Array:
        """Forces in the contacts, counted with the walls; nothing of a plain chain."""
        return np.empty(0) if self.contacts is None else np.asarray(self.contacts.last_force)

    @property
    def underflows(self) -> bool:
        """Whether accelerations have become too small to have all their digits."""
        from hertzchain.kernels import records

        arrived, velocity = self.state.arrays["peaks"][:, self.counts[records.PEAKS]]
        # What has become nothing is judged by the last bead that the pulse has reached.
        vanished = abs(velocity) < SMALLEST_ACCELERATION * arrived
        return bool(vanished or 0.0 < np.max(np.abs(self.accelerations)) < SMALLEST_ACCELERATION)


def _integrate(
    chain: Chain,
    start: State,
    until: float | None,
    frames: _Frames,
    rtol: float,
    max_steps: int,
    progress: Progress | None,
) -> Run:
    from hertzchain.kernels import records

    going = _Integration(chain, start, frames, rtol)
    kernel, counts = going.kernel, going.counts
    end = RunEnd(chain, going.state.arrays, going.equation, until)
    budget = max(20, BEAD_STEPS_PER_CALL // chain.beads)
    first = int(counts[records.STEPS])
    status: Status | None = None
    # The state before the step that the end cuts short: a longer run would go on from it.
    before_end: State | None = None
    while status is None:
        goal = end.goal() if before_end is None else (end.until, False)
        steps = min(budget, end.steps, max_steps - int(counts[records.STEPS]) + first)
        code = going.advance(goal, steps, before_end is None)
        if progress is not None:
            progress(1 + int(min(counts[records.PEAKS], counts[records.CROSSINGS])), chain.beads)
        status = end.after(code, kernel, going.forces)
        if code == kernel.FRAMES_FULL:
            counts[records.FRAMES] = frames.thin_out(int(counts[records.FRAMES]))
        elif code == kernel.LAST_STEP and goal[0] == until:
            before_end = going.state.copy()
        elif code == kernel.RUNNING and counts[records.STEPS] - first >= max_steps:
            status = "step limit"
        if code in (kernel.RUNNING, kernel.STEP_TOO_SMALL, kernel.PULSE_LOST) and going.underflows:
            status = "underflow"
    return _run(going, before_end or going.state.copy(), status, end.assess(going.forces))


def _run(going: _Integration, state: State, status: Status, walls: tuple[Array, Array]) -> Run:
    from hertzchain.kernels import forces, records

    clock, counts = going.clock, going.counts
    arrays, frames, beads = going.state.arrays, going.frames, state.chain.beads
    filled = int(counts[records.FRAMES])
    saved = frames.states[:filled]
    ledger, now = saved[:, 2 * beads :], arrays["y"][2 * beads :]
    if going.plain:
        ledger, now = np.zeros((filled, forces.LEDGER)), np.zeros(forces.LEDGER)
    return Run(
        chain=state.chain,
        times=frames.times[:filled],
        positions=saved[:, :beads] + equilibrium(state.chain).positions,
        velocities=saved[:, beads : 2 * beads],
        status=status,
        end_time=float(clock[records.TIME]),
        energy_drift=_part(clock[records.ENERGY_DRIFT], clock[records.ENERGY_UNIT]),
        momentum_drift=_part(clock[records.MOMENTUM_DRIFT], clock[records.MOMENTUM_UNIT]),
        steps=int(counts[records.STEPS]),
        evaluations=int(counts[records.EVALUATIONS]),
        rtol=going.rtol,
        state=state,
        _forces=None if going.plain else frames.forces[:filled],
        _ledger=ledger,
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


def _check_clock(chain: Chain) -> None:
    """Refuse a motion that is too fast for any clock."""
    times = transit_times(chain)
    k = int(np.argmin(times))
    if times[k] < SHORTEST_CONTACT:
        raise InputError(
            f"a pulse would pass contact {k + 1} in {times[k]:g}{' s' * (chain.units == 'SI')}, "
            "too short a time to represent: look at the units of masses, stiffness and velocities"
        )


def _check_end(chain: Chain, until: float | None, times: int | ArrayLike, begin: float) -> None:
    """Refuse an end that has passed, or none where nothing ends the run."""
    if until is not None and until <= begin:
        raise InputError(f"the run starts at time {begin:g} and cannot stop at until = {until:g}")
    if until is not None or not isinstance(times, int | np.integer):
        return
    if chain.drive is None and not chain.velocities[0] > 0.0:
        raise InputError(
            "bead 1 of this chain is not struck, so that no pulse ends the run: give until"
        )
    if chain.drive is not None and chain.right_wall is None:
        raise InputError(
            "this chain is driven and its right end is free, so that nothing ends the run: give "
            "until, or a right_wall"
        )
    if chain.drive is not None and not np.isfinite(chain.drive.end):
        raise InputError(
            "the drive of this chain does not end, and so neither does the run: give until"
        )
    pushes = equilibrium(chain).body_forces
    if chain.right_wall is None and pushes.sum() > 1e-9 * np.abs(pushes).sum():
        raise InputError(
            "gravity accelerates this chain towards its right end, which is free, so that the "
            "last bead never passes a maximum of velocity: give until, or a right_wall"
        )


def _checked_times(chain: Chain, times: ArrayLike, begin: float, until: float | None) -> Array:
    one = isinstance(times, str | bool | float | None)
    if (
        one
        or (values := real_numbers("time", times, unit=chain._unit("s"))).ndim != 1
        or not values.size
    ):
        raise InputError(
            f"times must be a whole number or a list of increasing numbers, got {shown(times)}"
        )
    _check_memory(chain, values.size)
    good = np.isfinite(values) & (np.diff(values, prepend=-np.inf) > 0.0) & (values >= 0.0)
    if not good.all():
        bad = int(np.argmin(good))
        raise InputError(
            f"times to save at must be finite, increasing and not negative, but time {bad + 1} "
            f"of them is {values[bad]:g}"
        )
    if values[0] < begin:
        raise InputError(
            f"the run goes on from time {begin:g}: the first time to save at, {values[0]:g}, has "
            "passed"
        )
    if until is not None and values[-1] > until:
        raise InputError(
            f"the last time to save at is {values[-1]:g}, but the run stops at until = {until:g}"
        )
    return values


def _check_memory(chain: Chain, frames: int) -> None:
    """Refuse more saved times than fit in memory."""
    # Positions and velocities, 8 bytes each, and once more while they are put together.
    needed = frames * chain.beads * 2 * 8 * 2
    if needed < 2**28:
        return
    import psutil

    free = psutil.virtual_memory().available
    if needed > free:
        raise InputError(
            f"{frames} saved times of {chain.beads} beads need {needed / 2**30:.1f} GiB, "
            f"and {free / 2**30:.1f} GiB are free: save fewer times"
        )

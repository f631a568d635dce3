"""Integrate a chain's equation of motion: every bead, every contact.

`simulate` keeps the trajectories as a `Run`; `hertzchain.propagate` is for those who
want the leading pulse alone.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np
from numpy.typing import ArrayLike

from hertzchain import __version__
from hertzchain.chain import Chain, require
from hertzchain.contacts import Array, compression_time, reduced_mass
from hertzchain.errors import InputError, SimulationError, real_number
from hertzchain.pulse import Pulse

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

Status = Literal[
    "pulse left", "time reached", "step limit", "step too small", "underflow", "pulse lost"
]
Progress = Callable[[int, int], None]

DEFAULT_RTOL: Final = 1e-13
# Default step limit: for long chains, and for short ones with a light bead that rattles.
STEPS_PER_BEAD: Final = 2_000
LEAST_STEP_LIMIT: Final = 1_000_000
# Work of one call of the compiled loop, in bead-steps: a fraction of a second, after
# which progress is told and an interrupt is heard.
BEAD_STEPS_PER_CALL: Final = 1_000_000
# Below this, accelerations have lost digits and the steps would shrink without end.
SMALLEST_ACCELERATION: Final = 1e-290


@dataclass(frozen=True, eq=False)
class Run:
    r"""A whole trajectory of a chain.

    Attributes
    ----------
    chain : Chain
        The chain that was struck.
    times : ndarray, shape (T,)
        Saved times [scaled].
    positions : ndarray, shape (T, N)
        Displacements :math:`x_k` of the beads from where they touched [scaled].
    velocities : ndarray, shape (T, N)
        Velocities [scaled].
    status : str
        ``"pulse left"`` or ``"time reached"``; ``"step limit"``, ``"step too small"``,
        ``"underflow"`` and ``"pulse lost"`` are failures that `simulate` raises unless
        told not to.
    end_time : float
        Time at which the integration stopped [scaled].
    energy_drift : float
        Largest relative change of the total energy over all steps.
    momentum_drift : float
        Largest change of the total momentum over all steps, relative to the
        sum of the beads' absolute momenta.
    steps, evaluations : int
        Accepted steps, and evaluations of the force on the whole chain.
    rtol : float
        Tolerance of a step.

    Examples
    --------
    >>> import hertzchain as hc
    >>> run = hc.simulate(hc.Chain.uniform(20), until=10.0, times=101)
    >>> run.velocities.shape, run.status
    ((101, 20), 'time reached')
    """

    chain: Chain
    times: Array
    positions: Array
    velocities: Array
    status: Status
    end_time: float
    energy_drift: float
    momentum_drift: float
    steps: int
    evaluations: int
    rtol: float
    _peaks: Array
    _crossings: Array

    @property
    def success(self) -> bool:
        """Whether the run reached what it was asked to reach."""
        return self.status in ("pulse left", "time reached")

    @property
    def message(self) -> str:
        """The status in a sentence."""
        passed = f"the pulse had passed {self._beads_passed} of {self.chain.beads} beads"
        at = f"at t = {self.end_time:g}, after {self.steps} steps"
        return {
            "pulse left": f"the pulse left the chain {at}",
            "time reached": f"stopped as asked {at}; {passed}",
            "step limit": (
                f"stopped by the step limit {at}; {passed}; raise max_steps, or use fewer "
                "beads or a weaker taper if the time hardly moves"
            ),
            "underflow": (
                f"the motion became too small to represent {at}; {passed}; "
                "use fewer beads or a weaker taper"
            ),
            "pulse lost": (
                f"the pulse was lost {at}: {passed}, and nothing more happens; beads far "
                "heavier than their neighbours hardly move"
            ),
            "step too small": (
                f"the steps became too short for the clock {at}; {passed}; "
                "use fewer beads or a weaker taper"
            ),
        }[self.status]

    @property
    def _beads_passed(self) -> int:
        """Beads of which peak and both contacts are recorded; the striker counts."""
        return 1 + int(np.count_nonzero((self._peaks[0, 1:] > 0) & (self._crossings[0] > 0)))

    @property
    def _residence(self) -> Array:
        """Times between successive crossings; by difference where they came out of order."""
        times, _, since_last = self._crossings
        between = np.diff(times, prepend=0.0)
        return np.where(since_last > 0.0, since_last, between)

    def pulse(self) -> Pulse:
        """The leading pulse: first velocity maxima, arrivals and largest overlaps.

        Returns
        -------
        Pulse
            Found between the steps while integrating, not among the saved times.

        Raises
        ------
        SimulationError
            If the run stopped before the pulse had passed every bead.

        Examples
        --------
        >>> import hertzchain as hc
        >>> float(hc.simulate(hc.Chain.uniform(30)).pulse().velocity[1].round(9))
        0.751471736
        """
        if self._beads_passed < self.chain.beads:
            raise SimulationError(f"no pulse of all beads: {self.message}; simulate for longer")
        return Pulse(
            chain=self.chain,
            method="simulation",
            velocity=self._peaks[1],
            peak_time=self._peaks[0],
            arrival=np.concatenate(([0.0], self._crossings[0])),
            peak_overlap=self._crossings[1],
            residence=self._residence,
        )

    def to_xarray(self) -> xr.Dataset:
        """Labelled dataset with coordinates ``time`` and ``bead`` = 1..N.

        Returns
        -------
        xarray.Dataset
            ``position`` and ``velocity``, both (time, bead), ``radius`` and ``mass``.

        Examples
        --------
        >>> import hertzchain as hc
        >>> run = hc.simulate(hc.Chain.uniform(9), until=2.0, times=5)
        >>> dict(run.to_xarray().sizes)
        {'time': 5, 'bead': 9}
        """
        import xarray as xr

        def labelled(values: Array, name: str, *dims: str) -> tuple[object, ...]:
            return dims, values, {"units": "1", "long_name": name}

        return xr.Dataset(
            {
                "position": labelled(self.positions, "displacement of the bead", "time", "bead"),
                "velocity": labelled(self.velocities, "velocity of the bead", "time", "bead"),
                "radius": labelled(self.chain.radii, "radius", "bead"),
                "mass": labelled(self.chain.masses, "mass", "bead"),
            },
            coords={
                "time": ("time", self.times, {"units": "1", "long_name": "time"}),
                "bead": np.arange(1, self.chain.beads + 1),
            },
            attrs={
                "hertzchain_version": __version__,
                "chain": self.chain.description,
                "taper": self.chain.taper or "",
                "rate": self.chain.rate or 0.0,
                "exponent": self.chain.exponent,
                "status": self.status,
                "energy_drift": self.energy_drift,
                "momentum_drift": self.momentum_drift,
                "rtol": self.rtol,
            },
        )

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draw the velocity of every bead over time, as a map.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw into; a new figure's if not given.

        Returns
        -------
        matplotlib.axes.Axes

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.simulate(hc.Chain.uniform(9)).plot().get_ylabel()
        'bead $k$'
        """
        from hertzchain.plotting import plot_run

        return plot_run(self, ax=ax)

    def __repr__(self) -> str:
        return f"Run({self.chain.description}: {self.message})"


def simulate(
    chain: Chain,
    *,
    until: float | None = None,
    times: int | ArrayLike = 400,
    rtol: float = DEFAULT_RTOL,
    max_steps: int | None = None,
    check: bool = True,
    progress: Progress | None = None,
) -> Run:
    r"""Integrate the equation of motion of a struck chain, Eq. (4) of the paper.

    The method is the Runge-Kutta pair DOP853 (order 8, adaptive), applied to every
    bead; the error of a step is measured, bead by bead, against the speeds within
    three beads.

    Parameters
    ----------
    chain : Chain
        The chain; bead 1 moves with velocity 1 at time 0, the others are at rest.
    until : float, optional
        Time to stop at [scaled].  By default the last of the given ``times`` or, if
        they are a number, when the pulse has left: when every bead has passed its
        first velocity maximum.
    times : int or array_like
        Times at which to save positions and velocities: increasing numbers >= 0, or
        a number of evenly spaced ones (exactly so many if ``until`` is given, else
        at most so many and at least half of them).
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
        For an option out of its range, or trajectories that do not fit in memory.
    SimulationError
        If the run fails and ``check`` is true.

    Examples
    --------
    >>> import hertzchain as hc
    >>> run = hc.simulate(hc.Chain.tapered("forward-linear", 0.01, beads=60))
    >>> run.energy_drift < 1e-10
    True
    """
    require(chain, "simulate", covers=("masses", "stiffness"))
    rtol = _checked_number("rtol", rtol, 1e-14, 1e-6)
    if until is not None:
        until = _checked_number("until", until, 0.0, np.inf)
    usual = max(STEPS_PER_BEAD * chain.beads, LEAST_STEP_LIMIT)
    limit = usual if max_steps is None else _checked_limit(max_steps)
    frames = _Frames(chain, until, times)
    if until is None and not isinstance(times, int | np.integer):
        until = float(frames.times[-1])
    run = _integrate(chain, until, frames, rtol, limit, progress)
    if check and not run.success:
        raise SimulationError(run.message)
    return run


class _Frames:
    """Times to save at, and the states saved.

    Where the end is not known, the grid starts too fine; whenever it is full, every second
    time is dropped and the spacing doubled, so that memory stays what was asked for.
    """

    def __init__(self, chain: Chain, until: float | None, times: int | ArrayLike) -> None:
        self.spacing: float | None = None
        if not isinstance(times, int | np.integer) or isinstance(times, bool):
            self.times = _checked_times(chain, times, until)
        elif times < 0 or times == 1:
            raise InputError(f"times must be 0 or at least 2 when it is a number, got {times}")
        else:
            count = _fitting_count(chain, int(times))
            if until is None and count > 0:
                self.spacing = 0.5 * float(_transit_times(chain).sum()) / count
                self.times = self.spacing * np.arange(count)
            else:
                self.times = np.linspace(0.0, until or 0.0, count)
        self.states = np.empty((len(self.times), 2 * chain.beads))

    def thin_out(self, filled: int) -> int:
        """Make room for later times; returns how many of the filled ones are kept."""
        assert self.spacing is not None
        kept = (filled + 1) // 2
        self.states[:kept] = self.states[:filled:2].copy()
        self.spacing *= 2.0
        self.times = self.spacing * np.arange(len(self.times))
        return kept


class _State:
    """The arrays of a run that the compiled loop works on."""

    def __init__(self, chain: Chain) -> None:
        from hertzchain.kernels import dop853
        from hertzchain.kernels import full_chain as kernel

        beads = chain.beads
        self.y = np.zeros(2 * beads)
        self.y[beads] = 1.0
        self.clock = np.zeros(kernel.CLOCK_SIZE)
        self.counts = np.zeros(kernel.COUNTS_SIZE, np.int64)
        self.setup = kernel.Plain(1.0 / chain.masses, chain.stiffness, chain.exponent)
        self.contacts = None
        self.peaks, self.crossings = np.zeros((2, beads)), np.zeros((3, beads - 1))
        self.peaks[1, 0] = 1.0
        self.stages = np.zeros((dop853.STAGES, 2 * beads))
        self.walls = np.zeros((kernel.WALL_ROWS, 2))
        self.scratch = (np.empty((6, 2 * beads)), np.zeros((2, beads), np.bool_))
        kernel.start(self.y, self.clock, self.counts, self.setup, self.contacts, 1e-4 * _transit_times(chain)[0])

    @property
    def underflows(self) -> bool:
        """Whether accelerations have become too small to have all their digits."""
        beads = len(self.y) // 2
        return bool(0.0 < np.max(np.abs(self.stages[0, beads:])) < SMALLEST_ACCELERATION)


def _integrate(
    chain: Chain,
    until: float | None,
    frames: _Frames,
    rtol: float,
    max_steps: int,
    progress: Progress | None,
) -> Run:
    from hertzchain.kernels import full_chain as kernel

    state = _State(chain)
    counts = state.counts
    end = (np.inf if until is None else until, until is None)
    budget = max(20, BEAD_STEPS_PER_CALL // chain.beads)
    code = kernel.RUNNING
    status: Status | None = None
    while code in (kernel.RUNNING, kernel.FRAMES_FULL) and status is None:
        code = kernel.advance(
            state.y, state.clock, counts, state.setup, state.contacts, *end, rtol,
            min(budget, max_steps - int(counts[kernel.STEPS])), False,
            frames.times, frames.spacing is not None, frames.states, np.empty((len(frames.times), 0)),
            state.peaks, state.crossings, state.walls, state.stages, *state.scratch,
        )  # fmt: skip
        if progress is not None:
            progress(1 + int(min(counts[kernel.PEAKS], counts[kernel.CROSSINGS])), chain.beads)
        if code == kernel.FRAMES_FULL:
            counts[kernel.FRAMES] = frames.thin_out(int(counts[kernel.FRAMES]))
        elif code == kernel.RUNNING and counts[kernel.STEPS] >= max_steps:
            status = "step limit"
        if code in (kernel.RUNNING, kernel.STEP_TOO_SMALL) and state.underflows:
            status = "underflow"

    endings: dict[int, Status] = {
        kernel.PULSE_LEFT: "pulse left",
        kernel.TIME_REACHED: "time reached",
        kernel.STEP_TOO_SMALL: "step too small",
        kernel.PULSE_LOST: "pulse lost",
    }
    filled = int(counts[kernel.FRAMES])
    return Run(
        chain=chain,
        times=frames.times[:filled],
        positions=frames.states[:filled, : chain.beads],
        velocities=frames.states[:filled, chain.beads :],
        status=status or endings[code],
        end_time=float(state.clock[kernel.TIME]),
        energy_drift=float(state.clock[kernel.ENERGY_DRIFT]),
        momentum_drift=float(state.clock[kernel.MOMENTUM_DRIFT]),
        steps=int(counts[kernel.STEPS]),
        evaluations=int(counts[kernel.EVALUATIONS]),
        rtol=rtol,
        _peaks=state.peaks,
        _crossings=state.crossings,
    )


def _transit_times(chain: Chain) -> Array:
    """Time per contact if the pulse kept its energy, as it nearly does in a slow taper.

    With v ~ m^(-1/2), each contact is passed in the compression time of its two beads.
    Used for the first step and the spacing of saved times, where a guess is enough.
    """
    reduced = reduced_mass(chain.masses[:-1], chain.masses[1:])
    speed = 1.0 / np.sqrt(chain.masses[:-1])
    return compression_time(reduced, chain.stiffness, speed, chain.exponent)


def _checked_number(name: str, value: float, low: float, high: float) -> float:
    number = real_number(name, value)
    if not (low <= number <= high and 0.0 < number < np.inf):
        allowed = f"between {low:g} and {high:g}" if np.isfinite(high) else "positive and finite"
        raise InputError(f"{name} must be {allowed}, got {number:g}")
    return number


def _checked_limit(max_steps: int) -> int:
    try:
        limit = 0 if isinstance(max_steps, bool) else operator.index(max_steps)
    except TypeError:
        limit = 0
    if limit < 1:
        raise InputError(f"max_steps must be a whole number of at least 1, got {max_steps!r}")
    return limit


def _checked_times(chain: Chain, times: ArrayLike, until: float | None) -> Array:
    given = np.asarray(times)
    if given.ndim != 1 or not given.size or given.dtype.kind not in "iuf":
        raise InputError(
            f"times must be a whole number or a list of increasing numbers, got {times!r}"
        )
    _fitting_count(chain, given.size)
    values = given.astype(float)
    good = np.isfinite(values) & (np.diff(values, prepend=-np.inf) > 0.0) & (values >= 0.0)
    if not good.all():
        bad = int(np.argmin(good))
        raise InputError(
            f"times to save at must be finite, increasing and not negative, but time {bad + 1} "
            f"of them is {values[bad]:g}"
        )
    if until is not None and values[-1] > until:
        raise InputError(
            f"the last time to save at is {values[-1]:g}, but the run stops at until = {until:g}"
        )
    return values


def _fitting_count(chain: Chain, frames: int) -> int:
    """The number of saved times, if they fit in memory."""
    # Positions and velocities, 8 bytes each, and once more while they are put together.
    needed = frames * chain.beads * 2 * 8 * 2
    if needed < 2**28:
        return frames
    import psutil

    free = psutil.virtual_memory().available
    if needed > free:
        raise InputError(
            f"{frames} saved times of {chain.beads} beads need {needed / 2**30:.1f} GiB, "
            f"and {free / 2**30:.1f} GiB are free: save fewer times"
        )
    return frames

"""Simulate many chains and keep only selected quantities, without trajectories."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from ..chain.bead_names import bead_number
from ..chain.chain import Chain
from ..chain.feature_support import require_chain, require_same_units
from ..collision import Array
from ..errors import IncompleteWarning, InputError, ModelRangeWarning, SimulationError, warn_user
from ..pulse.quantities import BODY_QUANTITIES, SENSOR_QUANTITIES
from ..pulse.quantity_names import column_name, unknown_quantity_error
from ..pulse.table_warnings import warn_exceeded, warn_failed
from ..recorded_warnings import ignore_warnings
from ..representation import counted
from ..threads import STOP, Signal, run_in_threads
from ..validation.keywords import checked_arguments
from ..validation.memory import check_memory
from ..validation.numbers import number, whole_number, worker_count
from ..validation.objects import Progress, callback, check_bool, check_list
from .body_force import MAY_FOLLOW
from .ensemble_columns import (
    TABLE_QUANTITIES,
    Outcome,
    Request,
    by_kernel,
    by_simulate,
    check_member,
    empty_columns,
    shape_of,
)
from .ensemble_input import kind_of
from .run_table import RunTable

DEFAULT_RTOL: Final = 1e-8
MIN_RTOL, MAX_RTOL = 1e-14, 1e-5
# Beads of a task: a fraction of a second, and enough to use all lanes of the kernel.
TASK_BEADS, MIN_TASK = 20_000, 16
# Bytes per bead that a task of the kernel uses in addition to the columns.
SCRATCH: Final = 8 * 20


class _Stopped(Exception):
    """Raised in a run that must stop."""


@checked_arguments("simulate_many")
def simulate_many(
    chains: Iterable[Chain],
    *,
    keep: str | Iterable[str] = ("velocity", "arrival"),
    sensors: Iterable[int | str] = (),
    until: float | None = None,
    rtol: float = DEFAULT_RTOL,
    max_steps: int | None = None,
    check_range: bool = True,
    threads: int | None = None,
    progress: Progress | None = None,
) -> RunTable:
    r"""Simulate all beads of many chains and keep only the requested quantities.

    The equation of motion and the end of each run are those of `hertzchain.simulate`.  Chains
    without losses and drive whose bead 1 is struck (of at most 150 beads, or with a right wall) are
    integrated several at a time by the Runge-Kutta-Nyström pair RKN8(6) (J. R. Dormand, M. E. A.
    El-Mikkawy, P. J. Prince, IMA J. Numer. Anal. 7, 423, 1987), each with its own step.  All other
    chains are integrated one by one by `simulate`, with the same columns.

    Parameters
    ----------
    chains : iterable of Chain
        Chains, all scaled or all in SI units; they may differ in length.
    keep : str or iterable of str
        Names of quantities (`hertzchain.pulse.quantities`): of the leading pulse, such as
        ``"velocity"`` or ``"peak_force"``; of the right wall, such as ``"wall_peak_force"``,
        ``"wall_impulse_of_impact"`` or ``"wall_duration"``; of the last body of a free end,
        ``"body_peak_force"``, ``"body_acceleration"`` and ``"body_duration"``, for which all chains
        are integrated by `simulate`; of sensors, such as
        ``"sensor_first_maximum"``; of the end of the run, such as ``"final_velocity"``,
        ``"end_time"`` or ``"energy_backward"``; and of the whole run, ``"largest_overlap"``,
        ``"dent"`` and, for chains of materials, ``"yield_ratio"``.  Full names, such as
        ``"wall_force.peak"`` or ``"body_force.peak"``, are accepted, too.
        Energies, such as ``"energy_lost"``, are fractions of the total with the lost energy (that
        of the impact, without a drive); those of `Run.budget` are in joules.
    sensors : iterable of int or str
        Numbers k of beads with a force sensor, which measures :math:`(F_{k-1} + F_k)/2`, or their
        names, such as ``"ball 4"``, if all chains have the same number of strikers.
    until : float, optional
        Stop time [scaled, or s]; by default each run ends as in `simulate`, or earlier if only the
        leading pulse and the peak on the wall are kept and no range is checked: when it is proven
        that no larger force follows.  The tolerance for this proof is 1e-4.
    rtol : float
        Relative tolerance per step, 1e-14 .. 1e-5.  Largest forces and velocities of short chains
        have errors of about this size; where waves from a wall meet, the motion amplifies them.
        Chains that `simulate` integrates use a tenth of this tolerance, at most 1e-6.
    max_steps : int, optional
        Step limit of each chain; by default 2000 per bead, and at least a million.
    check_range : bool
        Whether to compare chains of materials with the range of Hertz's law in the whole run.  This
        increases the time by half; without it, only the leading pulse is compared.
    threads : int, optional
        Number of threads.  The default is one per processor.
    progress : callable, optional
        Called as ``progress(chains_done, chains)`` a few times per second.

    Returns
    -------
    RunTable
        If a chain fails, its row is NaN and the table states the reason.

    Raises
    ------
    InputError
        If an option is out of range, some chains are scaled and others in SI units, or the table
        does not fit in memory.

    Warns
    -----
    IncompleteWarning
        If chains fail, with the reason of the first, or if a larger force on the last body of
        a free end may follow after the end of a run.
    ModelRangeWarning
        If chains exceed the limits of Hertz's law, unless ``check_range`` is false.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chains = [
    ...     hc.Chain.tapered("forward-exponential", q, beads=20).replace(right_wall=hc.Wall())
    ...     for q in (0.01, 0.02, 0.04)
    ... ]
    >>> table = hc.simulate_many(chains, keep=["wall_peak_force", "wall_duration"])
    >>> table["wall_peak_force"].round(3)
    array([1.187, 1.122, 0.973])
    """
    table = tabulate_runs(
        chains, keep=keep, sensors=sensors, until=until, rtol=rtol, max_steps=max_steps,
        check_range=check_range, threads=threads, progress=progress,
    )  # fmt: skip
    warn_failed(len(table), table.reasons)
    _warn_if_later_forces(table)
    if check_range and table.outside_range.any():
        rows = np.flatnonzero(table.outside_range).tolist()
        warn_exceeded("simulation", len(table), rows, table.exceeded_limits(rows[0])[0])
    return table


def _warn_if_later_forces(table: RunTable) -> None:
    """Warn once if runs end before the force on the last body of a free end is complete."""
    kept = [name for name in table.columns if name in BODY_QUANTITIES]
    if not kept:
        return
    rows = [
        row for row, chain in enumerate(table.chains)
        if chain is not None and row not in table.reasons
        and chain.right_wall is None and not table.complete[row]
        and np.isfinite(table[kept[0]][row])
    ]  # fmt: skip
    if rows:
        warn_user(
            f"{len(rows)} of {len(table)} runs end before the force on {_bodies(table, rows)} is "
            f"complete, the first that of chain {rows[0]}: {MAY_FOLLOW}",
            IncompleteWarning,
        )


def _bodies(table: RunTable, rows: Sequence[int]) -> str:
    """The last body of some of the chains."""
    caps = all(
        chain is not None and chain._free_cap for chain in map(table.chains.__getitem__, rows)
    )
    return "the cap" if caps else "the last body"


def tabulate_runs(
    chains: Iterable[Chain],
    *,
    keep: str | Iterable[str] = ("velocity", "arrival"),
    sensors: Iterable[int | str] = (),
    until: float | None = None,
    rtol: float = DEFAULT_RTOL,
    max_steps: int | None = None,
    check_range: bool = True,
    threads: int | None = None,
    progress: Progress | None = None,
) -> RunTable:
    """Compute the table of `simulate_many`, without its warnings."""
    if isinstance(chains, Chain):
        raise InputError("simulate_many requires a list of chains, got one; use simulate(chain)")
    given = check_list("chains", chains, "chains")
    request = Request(
        _checked_names(keep), _checked_sensors(sensors, given), until,
        number("rtol", rtol, least=MIN_RTOL, most=MAX_RTOL),
        None if max_steps is None else whole_number("max_steps", max_steps, least=1),
        check_bool("check_range", check_range),
    )  # fmt: skip
    return simulate_ensemble(given, request, threads, progress)


def simulate_ensemble(
    given: Sequence[object], request: Request, threads: int | None, progress: Progress | None
) -> RunTable:
    """Simulate chains, with the overlaps of whole runs only if the request needs them.

    Finding these overlaps takes half as long as the rest of the simulation.
    """
    callback("progress", progress)
    real = [each for each in given if isinstance(each, Chain)]
    require_same_units("simulate_many", real)
    if request.until is not None:
        unit = real[0]._unit("s") if real else None
        until = number("until", request.until, unit=unit, above=0.0)
        request = replace(request, until=until)
    if not request.sensors and any(name in SENSOR_QUANTITIES for name in request.keep):
        raise InputError("quantities of sensors need sensors: give the numbers of their beads")
    ensemble = _Ensemble(given, request)
    ensemble.run(worker_count("threads", threads), progress)
    return ensemble.table()


def _checked_names(keep: str | Iterable[str]) -> tuple[str, ...]:
    names = [keep] if isinstance(keep, str) else check_list("keep", keep, "names of quantities")
    if not names:
        raise InputError("keep must have at least one quantity, such as 'velocity', got none")
    for name in names:
        if not isinstance(name, str) or column_name(name) not in TABLE_QUANTITIES:
            raise unknown_quantity_error(name, [*TABLE_QUANTITIES])
    return tuple(dict.fromkeys(map(column_name, names)))


def _checked_sensors(sensors: Iterable[int | str], given: Sequence[object]) -> tuple[int, ...]:
    beads = check_list("sensors", sensors, "numbers or names of beads, such as 5 or 'ball 4'")
    chains = [each for each in given if isinstance(each, Chain)]
    strikers = {each.strikers for each in chains}
    if any(isinstance(bead, str) for bead in beads) and len(strikers) > 1:
        raise InputError(
            "the chains have different numbers of strikers, so that a name is not the same bead in "
            "each; give sensors as numbers of beads"
        )
    longest = max(chains, key=lambda each: each.beads, default=None)
    numbers = tuple(
        bead_number(longest, bead, "bead with a sensor")
        if isinstance(bead, str) and longest is not None
        else whole_number("bead with a sensor", bead, least=1)
        for bead in beads
    )
    if longest is not None and max(numbers, default=0) > longest.beads:
        raise InputError(
            f"there is no bead {max(numbers)} for a sensor in chains of up to {longest.beads} "
            f"beads; give beads from 1 to {longest.beads}"
        )
    return numbers


class _Ensemble:
    """The chains, and their results so far."""

    def __init__(self, given: Sequence[object], request: Request) -> None:
        self.request, self.count = request, len(given)
        self.reasons: dict[int, str] = {}
        self.chains: list[Chain | None] = [None] * self.count
        self.together: dict[tuple[int | bool, ...], list[int]] = {}
        self.alone: list[int] = []
        for row, chain in enumerate(given):
            try:
                require_chain("simulate_many", chain)
                assert isinstance(chain, Chain)
                self.chains[row] = chain
                check_member(chain, request)
                if request.by_kernel(chain):
                    kind = (*kind_of(chain), request.whole_run(chain))
                    self.together.setdefault(kind, []).append(row)
                else:
                    self.alone.append(row)
            except InputError as error:
                self.reasons[row] = str(error)
        longest = max((each.beads for each in self.chains if each is not None), default=0)
        self._check_memory(longest)
        self.columns = empty_columns(request.keep, self.count, longest, len(request.sensors))
        self.overlaps = np.zeros((self.count, longest + 1))
        self.status = np.full(self.count, "failed", dtype="<U24")
        self.complete, self.sensitive = np.zeros((2, self.count), bool)

    def _check_memory(self, longest: int) -> None:
        """Raise `InputError` if the table does not fit in memory."""
        shapes = [
            shape_of(name, self.count, longest, len(self.request.sensors))
            for name in self.request.keep
        ]
        needed = 8 * sum(int(np.prod(shape, dtype=float)) for shape in shapes)
        needed += 8 * self.count * (longest + 1) + SCRATCH * min(self.count, 512) * longest
        check_memory(
            f"the quantities of {counted(self.count, 'chain')} of up to {longest} beads", needed,
            "keep fewer quantities, or simulate fewer chains at a time",
        )  # fmt: skip

    def _tasks(self, threads: int) -> list[list[int]]:
        """Rows that are integrated together; single rows for `simulate`."""
        tasks = []
        for (beads, *_), rows in self.together.items():
            # Equal tasks for several threads; at the end of a task some lanes are idle.
            share = -(-len(rows) // (4 * threads)) if threads > 1 else len(rows)
            size = max(MIN_TASK, min(TASK_BEADS // beads, share))
            tasks += [rows[i : i + size] for i in range(0, len(rows), size)]
        return tasks + [[row] for row in self.alone]

    def run(self, threads: int, progress: Progress | None) -> None:
        """Integrate all chains, in threads."""
        run_in_threads(
            self._tasks(threads), self._outcome, self._store,
            threads=threads, of="chains", total=self.count, done=len(self.reasons),
            progress=progress,
        )  # fmt: skip

    def _outcome(self, rows: list[int], signal: Signal) -> Outcome:
        members = [chain for row in rows if (chain := self.chains[row]) is not None]
        if self.request.by_kernel(members[0]):
            return by_kernel(members, self.request, signal)
        return self._alone(members[0], signal)

    def _alone(self, chain: Chain, signal: Signal) -> Outcome:
        def check_stop(*_: int) -> None:
            if signal[STOP]:
                raise _Stopped

        try:
            # The whole table has one warning.
            with ignore_warnings(ModelRangeWarning, IncompleteWarning):
                return by_simulate(chain, self.request, check_stop)
        except (InputError, SimulationError) as error:
            nothing: Array = np.zeros((1, chain.beads + 1))
            no = np.zeros(1, bool)
            return Outcome({}, ["failed"], no, no, nothing, {0: str(error)})

    def _store(self, rows: list[int], found: Outcome) -> None:
        for name, values in found.columns.items():
            if values.ndim == 1:
                self.columns[name][rows] = values
            else:
                self.columns[name][rows, : values.shape[1]] = values
        self.overlaps[rows, : found.overlaps.shape[1]] = found.overlaps
        self.status[rows] = found.status
        self.complete[rows], self.sensitive[rows] = found.complete, found.sensitive
        for index, reason in found.reasons.items():
            row = rows[index]
            self.reasons[row], self.status[row] = reason, "failed"
            self.complete[row] = self.sensitive[row] = False
            for values in self.columns.values():
                values[row] = np.nan

    def table(self) -> RunTable:
        """The results as a table."""
        return RunTable(
            tuple(self.chains), self.request.sensors, self.columns, self.status,
            dict(sorted(self.reasons.items())), self.complete, self.sensitive, self.overlaps,
            self.request.check_range or self.request.keeps_largest,
        )  # fmt: skip

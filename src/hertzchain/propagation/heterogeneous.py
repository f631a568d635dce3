"""Pulses in heterogeneous chains: widen the window until two results agree.

The number of beads behind the pulse that influence it cannot be predicted: unequal beads scatter
the pulse, and in strong disorder dozens of beads behind the front still push it.  Each chain is
therefore integrated with one `WindowSettings` after the other, with more beads and smaller errors
(`hertzchain.kernels.wide_window`), until two results agree.  If the motion amplifies errors so
much that no two results agree, a `SimulationError` is raised.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError, SimulationError
from ..threads import COUNT, STOP
from .batch import (
    ARRIVAL,
    PEAK_OVERLAP,
    RESIDENCE,
    STRIKER_COLUMNS,
    STRUCK,
    Batch,
    Indices,
    difference,
)  # fmt: skip

# Largest tolerance allowed; a larger one would not give longer steps.
MAX_RTOL: Final = 1e-5
# Largest difference between two results that agree, in units of rtol.
AGREEMENT: Final = 3.0
# Largest work for all window settings of one chain, in bead steps: about five seconds, or ten
# times the work of a regular pulse in a long chain.
WORK, WORK_PER_BEAD = 150_000_000, 50_000
# If the kernel fails, chains up to this length are integrated completely, at two tolerances.
WHOLE, WHOLE_RTOLS = 2_000, (1e-12, 1e-13)
# Largest work of such an integration, in bead steps: about five seconds. Pulses that reach the end
# took up to 4e7; others have a light bead that bounces between heavy ones. Long chains are allowed
# the number of steps of a regular pulse in any case.
WHOLE_BEAD_STEPS, WHOLE_STEPS, WHOLE_STEPS_PER_BEAD = 50_000_000, 1_000_000, 50


@dataclass(frozen=True)
class WindowSettings:
    """Window and tolerances for a pulse in a heterogeneous chain.

    Attributes
    ----------
    behind : int
        Number of beads in the window behind the pulse.
    part, most : float
        Error allowed per step, as a fraction of the tolerance of the result, and its maximum.
    grading : float
        Factor by which the allowed error grows per bead behind the pulse, because errors there
        have less influence in regular chains.
    """

    behind: int
    part: float
    grading: float
    most: float = np.inf

    def window(self, rtol: float) -> tuple[int, float, float]:
        """Parameters of the kernel."""
        return self.behind, min(self.part * rtol, self.most), self.grading


# Each result is compared with that of the previous settings. The first settings are used only for
# chains with slowly changing radii.
WINDOW_SETTINGS: Final = (
    WindowSettings(12, 2.0, 1.5),
    WindowSettings(24, 1.0, 1.5),
    WindowSettings(48, 1 / 2, 1.5),
    WindowSettings(96, 1 / 8, 1.25),
    WindowSettings(200, 1 / 32, 1.1),
    WindowSettings(200, 1 / 128, 1.05, 1e-11),
    WindowSettings(200, 1 / 512, 1.0, 1e-12),
)


def follow_heterogeneous(
    todo: Indices, smooth: bool, rtol: float, batch: Batch, columns: Array, signal: Indices
) -> dict[int, str]:
    """Integrate chains of a batch with any radii and force laws."""
    settings = WINDOW_SETTINGS if smooth else WINDOW_SETTINGS[1:]
    failed, differences = _widen(todo, settings, rtol, batch, columns, signal)
    reasons = {}
    for index, last_difference in zip(failed, differences, strict=True):
        if signal[STOP]:
            break
        here = slice(batch.first[index], batch.first[index] + batch.beads[index])
        try:
            if np.isfinite(last_difference):
                raise SimulationError(_not_converged(last_difference, rtol))
            columns[:, here] = integrate_full_chain(batch.chain(int(index)), rtol, signal)
        except (SimulationError, InputError) as error:
            columns[:, here] = np.nan
            reasons[int(index)] = str(error)
    return reasons


def _widen(
    todo: Indices,
    settings: tuple[WindowSettings, ...],
    rtol: float,
    batch: Batch,
    columns: Array,
    signal: Indices,
) -> tuple[Indices, Array]:
    """Integrate chains with one window after the other, each until two results agree.

    Returns the chains without agreement, and the difference between the last two results of
    each (infinite if there are none).
    """
    from ..kernels import wide_window as kernel

    before, differences = columns, np.full(len(todo), np.inf)
    scratch = kernel.new_scratch()
    work = np.maximum(WORK, WORK_PER_BEAD * batch.beads)
    for window in settings:
        if not len(todo) or signal[STOP]:
            break
        found, status = np.zeros_like(columns), np.zeros(len(todo), np.int64)
        signal[COUNT] = 0
        left = work[todo]
        kernel.follow(
            window.window(rtol),
            (batch.given, batch.first[todo], batch.beads[todo], batch.chain_exponents[todo]),
            found, status, left, signal, scratch,
        )  # fmt: skip
        work[todo] = left
        _complete(found, batch)
        comparable = (status == kernel.FOLLOWED) & (window is not settings[0])
        compared = difference(found[:RESIDENCE], before[:RESIDENCE], batch.first)[todo]
        differences = np.where(comparable, compared, np.inf)
        agreed = differences <= AGREEMENT * rtol
        taken = batch.beads_of(todo[agreed])
        columns[:, taken] = found[:, taken]
        todo, differences, before = todo[~agreed], differences[~agreed], found
    return todo, differences


def _complete(found: Array, batch: Batch) -> None:
    """Fill in values that the kernel does not compute: first beads and residence times."""
    found[:STRIKER_COLUMNS, batch.first] = STRUCK
    between = np.diff(found[ARRIVAL], append=0.0)
    found[RESIDENCE] = np.where(found[RESIDENCE] > 0.0, found[RESIDENCE], between)
    found[PEAK_OVERLAP:, batch.first + batch.beads - 1] = np.nan


def integrate_full_chain(chain: Chain, rtol: float, signal: Indices) -> Array:
    """Integrate all beads of a chain at two tolerances; the results must agree."""
    if chain.beads > WHOLE:
        raise SimulationError(
            f"the pulse in this chain of {chain.beads} beads cannot be integrated: too many beads "
            "move at the same time, or their velocities are too small to represent; use at most "
            f"{WHOLE} beads or a weaker taper"
        )
    check, columns = (_simulate(chain, tolerance, signal) for tolerance in WHOLE_RTOLS)
    found = difference(columns[:RESIDENCE], check[:RESIDENCE], np.zeros(1, np.int64))[0]
    if found > AGREEMENT * rtol:
        raise SimulationError(_not_converged(found, rtol))
    return columns


def _simulate(chain: Chain, tolerance: float, signal: Indices) -> Array:
    from ..simulation.run_message import wide_range
    from ..simulation.simulate import simulate

    def watch(passed: int, _: int) -> None:
        signal[COUNT] = passed + chain.strikers
        if signal[STOP]:
            raise SimulationError("stopped")

    steps = min(WHOLE_BEAD_STEPS // chain.beads, WHOLE_STEPS)
    steps = max(steps, WHOLE_STEPS_PER_BEAD * chain.beads)
    balls = chain.beads - chain.strikers
    run = simulate(chain, times=0, rtol=tolerance, max_steps=steps, progress=watch, check=False)
    if run.status == "step limit":
        cause = wide_range(chain) or (
            "light beads bounce between heavy ones; use fewer beads or more similar radii, or call "
            "hertzchain.simulate, which allows more steps"
        )
        raise SimulationError(
            f"step limit reached: the pulse had passed {run.beads_passed} of {balls} beads after "
            f"{steps} steps; {cause}"
        )
    if not run.success or run.beads_passed < balls:
        raise SimulationError(run.message)
    pulse = run.pulse()
    found = pulse.columns()
    of_contacts = (np.append(found[name], np.nan) for name in ("peak_overlap", "residence"))
    return np.array([pulse.velocity, pulse.peak_time, pulse.arrival, *of_contacts])


def _not_converged(found: float, rtol: float) -> str:
    # Rounded up: otherwise the advised value might be too small.
    possible = 1.5 * found / AGREEMENT
    advice = f" or rtol = {possible:.0e} or more" if possible <= MAX_RTOL else ""
    return (
        f"results at two tolerances differ by {found:.0e}, more than rtol = {rtol:g} allows: the "
        f"motion of this chain amplifies rounding errors; use fewer beads{advice}"
    )

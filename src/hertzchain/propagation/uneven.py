"""Pulses through uneven chains: the widest window it takes, and two results that agree.

How many beads behind a pulse matter to it cannot be told from the chain: between unequal
beads it is scattered, and in strong disorder what runs in front has been fed from dozens of
beads behind.  So each chain is followed by one `Way` after the other, with more beads and
smaller errors (`hertzchain.kernels.wide_front`), until two results agree; what the motion
magnifies so much that none do is an error.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from hertzchain.chain.chain import Chain
from hertzchain.contacts import Array
from hertzchain.errors import InputError, SimulationError
from hertzchain.propagation.batch import (
    ARRIVAL,
    PASSED,
    PEAK_OVERLAP,
    RESIDENCE,
    STOP,
    STRIKER_KNOWS,
    STRUCK,
    Batch,
    Indices,
    difference,
)  # fmt: skip

# Largest tolerance that may be asked for: above, steps no longer get longer.
LARGEST_RTOL: Final = 1e-5
# Largest difference, in parts of rtol, of two results that agree.
AGREEMENT: Final = 3.0
# Work of all ways of one chain, in slots of the window stepped: some five seconds, or what ten
# regular passages of a long chain take.
WORK, WORK_PER_BEAD = 150_000_000, 50_000
# Where the kernel gives a chain up, all of it is integrated, at two tolerances, if it is short.
WHOLE, WHOLE_RTOLS = 2_000, (1e-12, 1e-13)
# Work of one such integration, in bead-steps: some five seconds. Pulses that get through took up
# to 4e7; what takes more is a light bead that rattles between heavy ones. Long chains have steps
# for a regular pulse in any case.
WHOLE_BEAD_STEPS, WHOLE_STEPS, WHOLE_STEPS_PER_BEAD = 50_000_000, 1_000_000, 50


@dataclass(frozen=True)
class Way:
    """One way to follow a pulse through an uneven chain.

    Attributes
    ----------
    behind : int
        Beads kept behind the pulse.
    part, most : float
        Tolerated error of a step: in parts of the tolerance of the result, and at most.
    grading : float
        Factor by which it grows from bead to bead behind the pulse. What is left behind
        matters the less, the more regular the chain.
    """

    behind: int
    part: float
    grading: float
    most: float = np.inf

    def window(self, rtol: float) -> tuple[int, float, float]:
        """Parameters of the kernel.

        Parameters
        ----------
        rtol : float
            Tolerance of the results.

        Returns
        -------
        tuple
            Beads behind, tolerated error of a step, and its growth per bead.

        Examples
        --------
        >>> Way(48, 0.5, 1.5).window(1e-8)
        (48, 5e-09, 1.5)
        """
        return self.behind, min(self.part * rtol, self.most), self.grading


# Each way's result is checked against that of the one before. The first is for beads of slowly
# changing radii alone.
WAYS: Final = (
    Way(12, 2.0, 1.5),
    Way(24, 1.0, 1.5),
    Way(48, 1 / 2, 1.5),
    Way(96, 1 / 8, 1.25),
    Way(200, 1 / 32, 1.1),
    Way(200, 1 / 128, 1.05, 1e-11),
    Way(200, 1 / 512, 1.0, 1e-12),
)


def follow_uneven(
    todo: Indices, smooth: bool, rtol: float, batch: Batch, columns: Array, signal: Indices
) -> dict[int, str]:
    """Follow some chains of a batch, whatever their beads and force laws.

    Parameters
    ----------
    todo : ndarray of int
        Numbers of the chains, from 0.
    smooth : bool
        Whether their radii change slowly.
    rtol : float
        Tolerance of the results.
    batch : Batch
        The chains.
    columns : ndarray, shape (5, M)
        Results of the batch, to be filled in: columns as of `Passage`.
    signal : ndarray, shape (2,)
        Set entry STOP to end early, with columns unfinished; entry PASSED counts beads.

    Returns
    -------
    dict
        Why a chain could not be followed, by its number; its columns are NaN.

    Examples
    --------
    >>> batch = Batch.of([Chain.from_radii([1.0, 0.3, 1.0])])
    >>> columns = np.zeros((5, 3))
    >>> follow_uneven(np.array([0]), False, 1e-8, batch, columns, np.zeros(2, np.int64))
    {}
    >>> columns[0].round(6)
    array([1.      , 1.147847, 0.997314])
    """
    ways = WAYS if smooth else WAYS[1:]
    failed, differences = _widen(todo, ways, rtol, batch, columns, signal)
    reasons = {}
    for index, apart in zip(failed, differences, strict=True):
        if signal[STOP]:
            break
        here = slice(batch.first[index], batch.first[index] + batch.beads[index])
        try:
            if np.isfinite(apart):
                raise SimulationError(_magnified(apart, rtol))
            columns[:, here] = follow_whole(batch.chain(int(index)), rtol, signal)
        except (SimulationError, InputError) as error:
            columns[:, here] = np.nan
            reasons[int(index)] = str(error)
    return reasons


def _widen(
    todo: Indices,
    ways: tuple[Way, ...],
    rtol: float,
    batch: Batch,
    columns: Array,
    signal: Indices,
) -> tuple[Indices, Array]:
    """Follow some chains one way after the other, each until two results agree.

    Returns those without, and by how much the last two results of each differ: infinite if
    there were none.
    """
    from hertzchain.kernels import wide_front as kernel

    before, differences = columns, np.full(len(todo), np.inf)
    scratch = kernel.new_scratch()
    work = np.maximum(WORK, WORK_PER_BEAD * batch.beads)
    for way in ways:
        if not len(todo) or signal[STOP]:
            break
        found, status = np.zeros_like(columns), np.zeros(len(todo), np.int64)
        signal[PASSED] = 0
        left = work[todo]
        kernel.follow(
            way.window(rtol),
            (batch.given(), batch.first[todo], batch.beads[todo], batch.exponents[todo]),
            found, status, left, signal, scratch,
        )  # fmt: skip
        work[todo] = left
        _complete(found, batch)
        comparable = (status == kernel.FOLLOWED) & (way is not ways[0])
        compared = difference(found[:RESIDENCE], before[:RESIDENCE], batch.first)[todo]
        differences = np.where(comparable, compared, np.inf)
        agreed = differences <= AGREEMENT * rtol
        taken = batch.beads_of(todo[agreed])
        columns[:, taken] = found[:, taken]
        todo, differences, before = todo[~agreed], differences[~agreed], found
    return todo, differences


def _complete(found: Array, batch: Batch) -> None:
    """Fill in what the kernel does not find: the striker, and residences out of order."""
    found[:STRIKER_KNOWS, batch.first] = STRUCK
    between = np.diff(found[ARRIVAL], append=0.0)
    found[RESIDENCE] = np.where(found[RESIDENCE] > 0.0, found[RESIDENCE], between)
    found[PEAK_OVERLAP:, batch.first + batch.beads - 1] = np.nan


def follow_whole(chain: Chain, rtol: float, signal: Indices) -> Array:
    """Integrate every bead of a chain, at two tolerances whose results must agree.

    Parameters
    ----------
    chain : Chain
        A chain of at most `WHOLE` beads.
    rtol : float
        Tolerance of the results.
    signal : ndarray, shape (2,)
        As for `follow`.

    Returns
    -------
    ndarray, shape (5, N)
        Columns as of `Passage`.

    Raises
    ------
    SimulationError
        If the chain is too long, if the pulse could not be followed to the end, or if the
        results differ.

    Examples
    --------
    >>> chain = Chain.uniform(9, exponent=2.0)
    >>> follow_whole(chain, 1e-8, np.zeros(2, np.int64))[0, 1].round(6)
    np.float64(0.818363)
    """
    if chain.beads > WHOLE:
        raise SimulationError(
            f"the pulse of {chain.beads} beads could not be followed: too many of them are under "
            f"way at once, or move too little to represent; use at most {WHOLE} beads or a weaker "
            "taper"
        )
    check, columns = (_simulated(chain, tolerance, signal) for tolerance in WHOLE_RTOLS)
    apart = difference(columns[:RESIDENCE], check[:RESIDENCE], np.zeros(1, np.int64))[0]
    if apart > AGREEMENT * rtol:
        raise SimulationError(_magnified(apart, rtol))
    return columns


def _simulated(chain: Chain, tolerance: float, signal: Indices) -> Array:
    from hertzchain.simulation.simulate import simulate

    def watch(passed: int, _: int) -> None:
        signal[PASSED] = passed
        if signal[STOP]:
            raise SimulationError("stopped")

    steps = min(WHOLE_BEAD_STEPS // chain.beads, WHOLE_STEPS)
    steps = max(steps, WHOLE_STEPS_PER_BEAD * chain.beads)
    run = simulate(chain, times=0, rtol=tolerance, max_steps=steps, progress=watch, check=False)
    if run.status == "step limit":
        raise SimulationError(
            f"the pulse had passed {run.beads_passed} of {chain.beads} beads after {steps} steps, "
            "the work allowed for one chain: light beads bounce between heavy ones; use fewer "
            "beads or radii that differ less, or hertzchain.simulate, which takes longer"
        )
    if not run.success or run.beads_passed < chain.beads:
        raise SimulationError(run.message)
    pulse = run.pulse()
    found = pulse.columns()
    of_contacts = (np.append(found[name], np.nan) for name in ("peak_overlap", "residence"))
    return np.array([pulse.velocity, pulse.peak_time, pulse.arrival, *of_contacts])


def _magnified(apart: float, rtol: float) -> str:
    # Rounded up, to be met when asked for.
    met = 1.5 * apart / AGREEMENT
    advice = f" or ask for rtol = {met:.0e} or more" if met <= LARGEST_RTOL else ""
    return (
        f"results at two tolerances differ by {apart:.0e} where rtol is {rtol:g}: the motion "
        f"of this chain magnifies the smallest errors; use fewer beads{advice}"
    )

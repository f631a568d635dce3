"""The run with which a record is compared."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from ..chain.chain import Chain
from ..recorded_warnings import ignore_warnings
from ..simulation.run import Run
from ..simulation.simulate import simulate
from ..simulation.time_scales import transit_times
from ..traces.traces import Traces
from .compare_traces import check_unit_of_times

# Least number of saved times; signals are interpolated between them.
MIN_TIMES: Final = 4000
# The pulse leaves the last contact within this number of further transits of one contact.
LAST_TRANSITS: Final = 3.0
# A record of more than the first number of transits is first compared with a run of the second,
# which has at least this number of saved times per bead.
MANY_TRANSITS, FEW_TRANSITS, TIMES_PER_BEAD = 100.0, 10.0, 200


def run_to_compare(
    chain: Chain, data: Traces, begin: float, *, most: int | None = None,
    progress: Callable[..., None] | None = None,
) -> Run:  # fmt: skip
    """A run as long as the record of one shot from a time on, at up to ``most`` saved times."""
    times = data.shots[0].times
    end = _duration(chain, float(times[-1]) - begin)
    _check_unit_of_times(chain, data, end)
    count = max(MIN_TIMES, len(times))
    count = count if most is None else min(count, most)
    return simulate(chain, until=end, times=count, progress=progress)


def _duration(chain: Chain, record: float) -> float:
    """Duration of a record, or the time in which the pulse passes the chain if it is longer."""
    times = transit_times(chain)
    passed = float(times.sum() + LAST_TRANSITS * times.max(initial=0.0))
    return max(record, passed) if passed < float("inf") else record


def _check_unit_of_times(chain: Chain, data: Traces, end: float) -> None:
    """Check a record that lasts for very many transits of the pulse with a shorter run.

    The saved times of the whole run would be too far apart to resolve its pulse.
    """
    transit = float(transit_times(chain).sum())
    if end < MANY_TRANSITS * transit:
        return
    times = max(MIN_TIMES, TIMES_PER_BEAD * chain.beads)
    with ignore_warnings():  # the whole run issues the same warnings
        run = simulate(chain, until=FEW_TRANSITS * transit, times=times)
    check_unit_of_times(run, data)

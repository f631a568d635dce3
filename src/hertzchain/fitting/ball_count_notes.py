"""A note on the number of balls, if a row with one more or fewer agrees much better with data."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from ..errors import InputError, SimulationError
from ..recorded_warnings import ignore_warnings
from ..simulation.run import Run
from ..simulation.simulate import simulate
from .ball_count_causes import CHANGES
from .ball_counts import ball_count
from .exchanged_columns import MUCH_BETTER

# Differences of arrivals, in widths of a pulse, from which other numbers of balls are simulated.
OUTSIDE: Final = 0.1


def count_note(
    run: Run, own: float, difference: Callable[[Run], float]
) -> tuple[float, str] | None:
    """The difference of a run from data, and a note, if one ball more or fewer halves it.

    The ball is behind the last sensor in a ball; ``own`` is the difference of the run itself.
    """
    for more, change, words in CHANGES:
        try:
            chain = change(run.chain)
            with ignore_warnings():
                other = simulate(chain, until=float(run.times[-1]), times=len(run.times))
            best = difference(other)
        except (InputError, SimulationError):
            continue
        if best < MUCH_BETTER * own:
            return best, (
                f"with {words} ({ball_count(chain)}), the rms difference falls to "
                f"{best / own:.0%} of its value: check the number of balls"
                # Both delay later signals.
                + " and, because a gap delays the signals behind it as well, look for gaps"
                * (more > 0)
            )
    return None

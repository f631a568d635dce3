"""Times that the page shows: the passage of the pulse, the impact on a wall, and an echo."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError, SimulationError
from ..pulse.pulse import Pulse
from ..simulation.run import Run
from ..simulation.simulate import simulate
from ..simulation.time_scales import closing_speed, transit_times

# Extra time after the pulse has left, in units of its transit: with a wall, and without.
ECHO: Final = {True: 1.0, False: 0.12}
# The run that is shown lasts until a free last bead has separated: this multiple of the time from
# its first half of the impact, its arrival, to its largest velocity.
FREE_FLIGHT: Final = 1.5
# A longer time after the pulse has left, as in free flight to a distant wall, is compressed.
MAX_ECHOES: Final = 2
# Frames of such a flight, of the impact and of the time after it, in units of those of the passage.
FLIGHT_AND_IMPACT: Final = (0.25, 0.5, 0.25)
# Half the time around the peak on the wall that these frames show, in compression times.
HALF_IMPACT: Final = 3.0
# Tolerance of the run that determines how long a pulse takes to pass a chain.
ROUGH: Final = 1e-6


def saved_times(
    chain: Chain, exact: Pulse | None, frames: int, clock: str, progress: Any = None,
    end: float = 0.0, impact: float = 0.0, lasting: float = 0.0,
) -> Array:  # fmt: skip
    """Times to save: the same number for each bead that the pulse passes, or equally spaced.

    After the pulse has left, the times continue with the residence times in reverse order, at
    the rate of an echo, and at least until ``end``; if that is much later, as after free flight to
    the wall, most of them are near the time of the ``impact``.  Without an impact, and while a
    soft wall is loaded for the time ``lasting``, beads may collide at any time, so the times are
    equally spaced.
    """
    pulse, rough_end = (exact, 0.0) if exact is not None else _rough_pulse(chain, progress)
    arrival = np.array([np.nan]) if pulse is None or pulse.arrival is None else pulse.arrival
    end = max(end, _end_of_passage(chain, pulse))
    echo = ECHO[chain.right_wall is not None]
    known = np.isfinite(arrival)
    arrival = np.maximum.accumulate(arrival[known])
    # A driven wave has no single arrival: its crests change on their way.
    if chain.drive is not None or np.count_nonzero(np.diff(arrival)) < 2 or not known.all():
        last = max(end, rough_end, 1.2 * float(arrival.max(initial=0.0)))
        flights = _first_impact(chain, arrival) if clock == "beads" and known.all() else None
        corners = (0.0, last) if flights is None else (0.0, *flights, last)
        places = np.linspace(0.0, 1.0, len(corners))
        return np.interp(np.linspace(0.0, 1.0, frames), places, corners)
    if clock == "time":
        return np.linspace(0.0, max(arrival[-1] * (1.0 + echo), end, rough_end), frames)
    steps = np.diff(arrival)[::-1]
    count = len(steps)
    back_and_forth = np.concatenate((steps, steps[::-1]))
    echoes = max(end - arrival[-1], 0.0) / back_and_forth.sum()
    later = np.cumsum(np.tile(back_and_forth, 1 + int(min(echoes, MAX_ECHOES))))
    known_times = np.concatenate((arrival, arrival[-1] + later))
    places = np.arange(len(known_times), dtype=float)
    last = max(count * (1.0 + echo), float(np.interp(end, known_times, places)))
    half = HALF_IMPACT * float(transit_times(chain)[-1])
    near = int(np.searchsorted(known_times[:-1], impact))
    flight = impact > arrival[-1] + half and known_times[near] - known_times[near - 1] > half
    if echoes > MAX_ECHOES and (impact == 0.0 or lasting > 2.0 * half):
        known_times = np.append(arrival, end)
        places = np.append(places[: count + 1], last := 2.0 * count)
    elif echoes > MAX_ECHOES or flight:
        impact = max(impact, arrival[-1] + 2.0 * half)
        after = np.array((impact - half, impact + half, max(end, impact + 2.0 * half)))
        known_times = np.append(arrival, after)
        places = np.append(places[: count + 1], count * (1.0 + np.cumsum(FLIGHT_AND_IMPACT)))
        last = float(places[-1])
    # Half of the frames of a flight in a gap show the impact at its end.
    before = HALF_IMPACT * transit_times(chain)
    flown = np.flatnonzero(np.diff(arrival) > 2.0 * before)
    known_times = np.insert(known_times, flown + 1, (arrival[1:] - before)[flown])
    places = np.insert(places, flown + 1, flown + 0.5)
    return np.unique(np.interp(np.linspace(0.0, last, frames), places, known_times))


def _first_impact(chain: Chain, arrival: Array) -> tuple[float, float] | None:
    """Begin and end of the impact of one free ball on another that is far away."""
    if len(arrival) != 2 or chain.drive is not None or chain.right_wall is not None:
        return None
    half = HALF_IMPACT * float(transit_times(chain)[-1])
    return (arrival[1] - half, arrival[1] + half) if arrival[1] > 2.0 * half else None


def _end_of_passage(chain: Chain, pulse: Pulse | None) -> float:
    """Time at which a free last bead has left the chain; 0 if it is not known, or with a wall."""
    if chain.right_wall is not None or pulse is None or pulse.peak_time is None:
        return 0.0
    if pulse.arrival is None or not np.isfinite(pulse.peak_time[-1] + pulse.arrival[-1]):
        return 0.0
    arrival, peak = float(pulse.arrival[-1]), float(pulse.peak_time[-1])
    return arrival + FREE_FLIGHT * (peak - arrival)


def _rough_pulse(chain: Chain, progress: Any) -> tuple[Pulse | None, float]:
    """Pulse and end of a quick run, for chains that `propagate` does not support."""
    try:
        rough = simulate(chain, times=0, rtol=ROUGH, check=False, progress=progress)
    except InputError:
        if not _endless(chain):
            raise
        end = _last_change(chain) + 1.5 * float(transit_times(chain).sum())
        rough = simulate(chain, until=end, times=0, rtol=ROUGH, check=False, progress=progress)
    if not rough.success and rough.beads_passed <= 1:
        raise SimulationError(rough.message)
    return pulse_of(rough), rough.end_time


def _last_change(chain: Chain) -> float:
    """Last time at which the drive changes other than smoothly, such as the end of a table."""
    kinks = np.zeros(1) if chain.drive is None else np.append(0.0, chain.drive.kinks)
    return float(kinks[np.isfinite(kinks)].max())


def _endless(chain: Chain) -> bool:
    """Whether beads move, and nothing ends a run without stop time, such as an endless drive."""
    if chain.drive is not None or chain.gravity != 0.0 or chain.precompression > 0.0:
        return True
    return not chain.velocities[0] > 0.0 and closing_speed(chain) > 0.0


def pulse_of(run: Run) -> Pulse | None:
    """The pulse of a run, if there is one."""
    try:
        return run.pulse()
    except SimulationError:
        return None

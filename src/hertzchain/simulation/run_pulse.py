"""The pulse of a run, from the records of the compiled loop."""

from __future__ import annotations

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..pulse.notes import OF_FIRST_MAXIMA, bouncing_notes
from ..pulse.pulse import Pulse
from .missing_values import reason, together

LATE = "before the end of the run"


def pulse_of(chain: Chain, peaks: Array, crossings: Array, *, tails: bool = True) -> Pulse:
    """The leading pulse, as far as it has passed during the run; with notes on tails."""
    from ..kernels import state_layout
    from .tail import tailed

    tail = tailed(chain, crossings) if tails else np.zeros(chain.beads - 1, bool)

    peaked = peaks[state_layout.PEAK_VELOCITY] != 0.0
    passed = crossings[state_layout.CROSSING_TIME] > 0.0
    residence = residence_of(chain, crossings)
    return Pulse(
        chain=chain,
        method="simulation",
        velocity=np.where(peaked, peaks[state_layout.PEAK_VELOCITY], np.nan),
        peak_time=np.where(peaked, np.maximum(peaks[state_layout.PEAK_TIME], 0.0), np.nan),
        arrival=np.concatenate(
            ([0.0], np.where(passed, crossings[state_layout.CROSSING_TIME], np.nan))
        ),
        peak_overlap=np.where(passed, crossings[state_layout.OVERLAP], np.nan),
        residence=residence,
        notes=_notes(chain, peaked, passed, residence, tail),
    )


def residence_of(chain: Chain, crossings: Array) -> Array:
    """Times between the crossings of successive contacts; NaN where they are not defined."""
    from ..kernels import state_layout

    residence = times_between(
        crossings[state_layout.CROSSING_TIME], crossings[state_layout.RESIDENCE]
    )
    residence[_without_residence(chain)] = np.nan
    # Beads that stick together arrive at the same time.
    residence[residence == 0.0] = np.nan
    if chain.drive is not None:
        # These are crests of the drive, not of a pulse that moves from contact to contact.
        residence[residence < 0.0] = np.nan
    return residence


def times_between(times: Array, since_last: Array) -> Array:
    """Times between the crossings of successive contacts, shape (..., N - 1).

    They are NaN unless the pulse has passed both.  Recorded times ``since_last`` are more precise
    than differences; 0 if there are none.
    """
    found = np.where(since_last > 0.0, since_last, np.diff(times, prepend=0.0))
    passed = times > 0.0
    found[..., 1:][~passed[..., :-1]] = np.nan
    found[~passed] = np.nan
    return found


def moving_first(chain: Chain) -> int:
    """Number of beads at the front of a chain that move forward from the start."""
    return int(np.argmin(np.append(chain.velocities > 0.0, False)))


def _without_residence(chain: Chain) -> slice:
    """Beads whose residence time is not defined."""
    first = moving_first(chain)
    return slice({0: 1, 1: 0}.get(first, first))


def _notes(
    chain: Chain, peaked: Array, passed: Array, residence: Array, tailed: Array
) -> dict[str, str]:
    """Reasons for values that are missing or have another meaning, by quantity."""
    slow = reason("bead", ~peaked, f"no first maximum of the velocity {LATE}")
    tail = reason(
        "bead",
        tailed,
        "the momentum behind the crest, relative to that ahead of it, is more than twice that of a "
        "pulse without losses: losses have turned it into the front of a shock-like tail, which "
        "decays more slowly than a pulse",
    )
    unarrived = np.append(False, ~passed)
    unpassed = reason("contact", ~passed, f"no first maximum of the overlap {LATE}")
    undefined = np.zeros(chain.beads - 1, bool)
    undefined[_without_residence(chain)] = True
    why, crests = "they move from the start, and the pulse does not pass from one to the next", ""
    if not moving_first(chain):
        why = "not struck, and no pulse arrives there"
        crests = "times are from crest to crest, which a slow drive shifts; see Run.fronts"
    absent, seen = np.isnan(residence) & ~undefined, passed & np.append(True, passed[:-1])
    stay = together(
        reason("bead", undefined, why),
        reason("bead", absent & ~seen, f"no arrival there or at the next {LATE}"),
        reason("bead", absent & seen, "the crest reaches the next contact before this one"),
        crests if chain.drive is not None else "",
    )
    bouncing = bouncing_notes(chain.masses)
    notes = {name: together(slow, tail, bouncing.get(name, "")) for name in OF_FIRST_MAXIMA}
    notes |= {
        "peak_time": slow,
        "arrival": reason("bead", unarrived, f"not faster than the bead behind {LATE}"),
        "residence": stay,
        "peak_overlap": unpassed,
        "peak_force": unpassed,
    }
    return {name: note for name, note in notes.items() if note}

"""Proof that the largest force on the wall so far is the largest of the whole run.

If a chain is integrated only for this force, the motion after it matters only for the proof, and is
integrated with a larger tolerance.  If the force then comes close to the peak again, the lane
returns to the state before, and continues with the requested tolerance.
"""

from __future__ import annotations

from .compilation import compiled
from .elastic_forces import force_of, overlap_of
from .elastic_layout import (
    EXACT_PEAK,
    EXACT_TIME,
    F0,
    FORCE,
    GAUGE_ROWS,
    KEPT_F0,
    KEPT_V,
    KEPT_X,
    LANE_ROWS,
    LANES,
    NOTHING_MORE,
    PEAK,
    PEAK_TIME,
    TOLERANCE,
    TRANSIT_LIMIT,
    TRIED,
    WALL_DONE,
    V,
    X,
)
from .elastic_walls import expired, is_largest, nothing_can_happen, set_due

# Attempts per transit to prove that no larger force follows; each takes as long as a step.
PROOFS = 5
# Tolerance after the force has decreased to this fraction of its peak.
FALLEN, PROOF_TOLERANCE = 0.5, 1e-4
# The proof is that no later force comes closer to the peak than this fraction of it.
MARGIN = 0.01
# Code of `ending_with_peak` for a lane that must go back.
GO_BACK = -1


@compiled
def ending_with_peak(w, beads, lane, state, wall, rebounds):
    """Reason for a chain to end of which only the largest force on the wall is requested."""
    set_due(lane, state, PROOFS)
    peak, is_new = wall[PEAK], wall[PEAK_TIME] > state[EXACT_TIME, lane]
    if is_new and state[EXACT_PEAK, lane] > 0.0:
        return GO_BACK
    if peak > 0.0 and is_largest(w, beads, lane, peak):
        return WALL_DONE
    if nothing_can_happen(w, beads, lane):
        return NOTHING_MORE
    if expired(lane, state, rebounds, True):
        return TRANSIT_LIMIT
    # After a return, the peak is not new, and the tolerance remains.
    if is_new and w[FORCE + beads * LANES + lane] < FALLEN * peak:
        keep_state(w, beads, lane, state, wall)
        state[EXACT_PEAK, lane], state[EXACT_TIME, lane] = peak, wall[PEAK_TIME]
        state[TOLERANCE, lane] = max(state[TOLERANCE, lane], PROOF_TOLERANCE)
        wall[PEAK] = (1.0 - MARGIN) * peak
    return 0


@compiled
def keep_state(w, beads, lane, state, wall):
    """Keep the state of a lane, to which `go_back` returns."""
    for slot in range(lane, (beads + 2) * LANES, LANES):
        w[KEPT_X + slot], w[KEPT_V + slot] = w[X + slot], w[V + slot]
        w[KEPT_F0 + slot] = w[F0 + slot]
    for row in range(LANE_ROWS):
        state[LANE_ROWS + row, lane] = state[row, lane]
    for row in range(GAUGE_ROWS):
        wall[GAUGE_ROWS + row] = wall[row]


@compiled
def go_back(w, beads, lane, state, wall, pushes):
    """Return to the state that was kept; only the number of tried steps remains."""
    for slot in range(lane, (beads + 2) * LANES, LANES):
        w[X + slot], w[V + slot] = w[KEPT_X + slot], w[KEPT_V + slot]
        w[F0 + slot] = w[KEPT_F0 + slot]
    tried = state[TRIED, lane]
    for row in range(LANE_ROWS):
        state[row, lane] = state[LANE_ROWS + row, lane]
    for row in range(GAUGE_ROWS):
        wall[row] = wall[GAUGE_ROWS + row]
    state[TRIED, lane], state[EXACT_TIME, lane] = tried, wall[PEAK_TIME]
    at = beads * LANES + lane
    pushes[0, 0, lane] = force_of(w, at, overlap_of(w, at))


@compiled
def restore_peak(lane, state, wall):
    """Give the gauge of the wall the peak that the motion afterwards has not reached again."""
    if state[EXACT_PEAK, lane] > 0.0:
        wall[PEAK], wall[PEAK_TIME] = state[EXACT_PEAK, lane], state[EXACT_TIME, lane]

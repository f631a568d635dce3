"""Integration of all beads of elastic chains, several side by side, each with its own step.

`follow` integrates chains of equal length by RKN8(6) (`hertzchain.kernels.rkn8_step`).  It stores
no trajectories, only the first velocity maximum of each bead, the first largest overlap of each
contact, the forces of gauges (the right wall and sensors) and the final state.  A lane whose step
is rejected keeps its state; a lane whose chain has ended loads the next chain.
"""

from __future__ import annotations

import math

import numpy as np

from .compilation import OPTIONS, compiled, entry_point, internal
from .elastic_cap import ending_on_cap
from .elastic_events import record_events, record_fall, record_largest
from .elastic_forces import closing_of, force_of, overlap_of
from .elastic_kinks import drop_kinks, find_kinks, impulse_defect, pass_step
from .elastic_layout import (
    AT_REST,
    BODY,
    BY_ITSELF,
    CAN_ESCAPE,
    CROSSED,
    CROSSINGS,
    DONE,
    DUE,
    END_OF_ROWS,
    END_TIME,
    EXPONENT,
    F0,
    F8,
    FINAL_V,
    FINAL_X,
    FIRST_END,
    FIRST_IMPULSE,
    FIRST_STEP,
    FORCE,
    GAUGE_ROWS,
    GIVEN_AT_REST,
    GIVEN_BODY,
    GIVEN_EXPONENT,
    GIVEN_INVERSE_MASS,
    GIVEN_NOISE,
    GIVEN_STIFFNESS,
    GOOD,
    IMPACT_IMPULSE,
    IMPULSE,
    INVERSE_MASS,
    KINK_ROWS,
    LANE_ROWS,
    LANES,
    LAST_CROSSING,
    LAST_END,
    LAST_IMPULSE,
    LEAST_PUSH,
    LENGTH,
    LONGEST,
    MOST,
    NEW_V,
    NEW_X,
    NOISE,
    NOTHING_MORE,
    PEAK,
    PEAK_ONLY,
    PEAK_TIME,
    PEAKED,
    PEAKS,
    PULSE_LEFT,
    REBOUNDS,
    RECORD_PEAK,
    RECORD_PEAK_TIME,
    REFUSED,
    REST,
    ROW,
    SINCE,
    SINCE_CROSSING,
    START_V,
    STATUS,
    STEP,
    STEP_LIMIT,
    STEP_TOO_SMALL,
    STEPS,
    STIFFNESS,
    STOP,
    STRIKERS,
    TAKEN,
    TIME,
    TIME_REACHED,
    TOLERANCE,
    TRANSIT,
    TRANSIT_LIMIT,
    TRIED,
    UNTIL,
    WALL_COMPLETE,
    WALL_DONE,
    WALL_FIRST_END,
    WALL_FIRST_IMPULSE,
    WALL_IMPACT_IMPULSE,
    WALL_SINCE,
    WATCH_START,
    WORST,
    H,
    V,
    X,
)
from .elastic_proof import GO_BACK, ending_with_peak, go_back, restore_peak
from .elastic_walls import (
    check_wall,
    close,
    complete,
    expired,
    held,
    note_end,
    nothing_can_happen,
    restart,
    start_watch,
)
from .limits import FALL
from .rkn8_step import GROWTH, SAFETY, SHRINKAGE, STAGES, impulse_of, spread, take_step
from .scratch import aligned_zeros
from .state_layout import STRIKER_PEAK_TIME

inlined = internal(forceinline=True, **OPTIONS)

MIN_STEP, HALF = 1e-280, 0.5
# Steps longer than this fraction of the elapsed time occur only if all beads are in free flight.
LONG_STEP = 0.1


def scratch_for(gauges):
    """Scratch arrays of `follow`."""
    return (
        aligned_zeros(END_OF_ROWS), np.zeros((2 * LANE_ROWS, LANES)),
        np.zeros((STAGES, gauges, LANES)), np.zeros((LANES, gauges, 2 * GAUGE_ROWS)),
        np.zeros(LANES, np.int64), np.zeros(KINK_ROWS),
    )  # fmt: skip


@compiled
def load(w, beads, lane, chain, numbers, places, rtol, pushes, state, gauges, records):
    """Load a chain at time 0 into a lane."""
    for row in range(END_OF_ROWS // ROW):
        for i in range(beads + 7):
            w[row * ROW + i * LANES + lane] = 0.0
    struck = max(int(numbers[STRIKERS]), 1)
    for c in range(beads + 1):
        at = c * LANES + lane
        w[AT_REST + at], w[STIFFNESS + at] = chain[GIVEN_AT_REST, c], chain[GIVEN_STIFFNESS, c]
        w[EXPONENT + at] = chain[GIVEN_EXPONENT, c]
    for k in range(beads):
        at = k * LANES + lane
        w[V + LANES + at], w[INVERSE_MASS + at] = chain[START_V, k], chain[GIVEN_INVERSE_MASS, k]
        w[BODY + at], w[NOISE + at] = chain[GIVEN_BODY, k], chain[GIVEN_NOISE, k]
        left = force_of(w, at, w[AT_REST + at])
        right = force_of(w, at + LANES, w[AT_REST + at + LANES])
        w[FORCE + at], w[FORCE + at + LANES] = left, right
        w[F0 + at] = (left - right) * w[INVERSE_MASS + at] + w[BODY + at]
        if k < struck:
            w[PEAKED + at] = 1.0
            records[RECORD_PEAK_TIME, k] = STRIKER_PEAK_TIME if k > 0 else 0.0
            records[RECORD_PEAK, k] = chain[START_V, k]
    # The last bead has no next bead and therefore no crossing.
    w[CROSSED + (beads - 1) * LANES + lane] = 1.0
    for row in range(len(state)):
        state[row, lane] = 0.0
    state[STEP, lane], state[MOST, lane], state[DUE, lane] = numbers[FIRST_STEP], GROWTH, np.inf
    state[LAST_CROSSING, lane], state[PEAKS, lane] = -1.0, struck - 1.0
    state[TOLERANCE, lane] = rtol
    for g in range(len(places)):
        one, two = places[g, 0] * LANES + lane, places[g, 1] * LANES + lane
        for row in range(gauges.shape[2]):
            gauges[lane, g, row] = 0.0
        rest = 0.5 * (w[FORCE + one] + w[FORCE + two])
        gauges[lane, g, REST] = gauges[lane, g, PEAK] = pushes[0, g, lane] = rest


@compiled
def store(
    w, beads, lane, chain, numbers, status, state, gauges, places, records, summary, readings
):  # fmt: skip
    """Store the results of a chain that has ended."""
    for k in range(beads):
        records[FINAL_X, k] = w[X + (k + 1) * LANES + lane]
        records[FINAL_V, k] = w[V + (k + 1) * LANES + lane]
    restore_peak(lane, state, gauges[lane, 0])
    for g in range(len(places)):
        for row in range(GAUGE_ROWS):
            readings[g, row] = gauges[lane, g, row]
    peak, can_escape = gauges[lane, 0, PEAK], numbers[CAN_ESCAPE] != 0.0
    restart(lane, state, gauges[lane, 0, PEAK_TIME])
    note_end(w, beads, lane, chain, state, peak, gauges[lane, 0, IMPULSE])
    summary[END_TIME], summary[STATUS] = state[TIME, lane], status
    summary[TAKEN] = state[STEPS, lane]
    summary[REFUSED] = state[TRIED, lane] - state[STEPS, lane]
    summary[WALL_FIRST_IMPULSE] = state[FIRST_IMPULSE, lane]
    summary[WALL_FIRST_END] = state[FIRST_END, lane]
    summary[WALL_SINCE] = state[SINCE, lane]
    known = status == WALL_DONE or complete(w, beads, lane, chain, can_escape, state, peak)
    summary[WALL_COMPLETE] = 1.0 * (known and peak > 0.0)
    summary[WALL_IMPACT_IMPULSE] = state[IMPACT_IMPULSE, lane]


@compiled
def closes_unseen(w, beads, lane, h):
    """Whether a contact that is open at both ends of a step may have been closed in between."""
    for c in range(beads + 1):
        at = c * LANES + lane
        first = overlap_of(w, at)
        last = w[AT_REST + at] + (w[NEW_X + at] - w[NEW_X + LANES + at])
        parting = w[NEW_V + at] - w[NEW_V + LANES + at]
        open_ends = first <= 0.0 and last <= 0.0 and w[STIFFNESS + at] > 0.0
        if not open_ends or closing_of(w, at) <= 0.0 or parting >= 0.0:
            continue
        sharpest = 0.0
        for stage in range(F0, F8 + 1, ROW):
            left = w[stage + at - LANES] if c > 0 else 0.0
            right = w[stage + at] if c < beads else 0.0
            sharpest = max(sharpest, abs(left - right))
        if 0.125 * h * h * sharpest > max(-max(first, last), 1e-14 * abs(w[X + at])):
            return True
    return False


@compiled
def new_lengths(state):
    """Accept or reject the step of each lane, and store the factor of its next step."""
    # The compiler does not use vectors if the number of lanes is a constant.
    for lane in range(state.shape[1]):
        error = state[WORST, lane] / state[TOLERANCE, lane]
        good = error <= 1.0
        # An eighth root by three square roots; no growth right after a rejected step.
        change = SAFETY / math.sqrt(math.sqrt(math.sqrt(error + 1e-30)))
        change = change if change > SHRINKAGE else SHRINKAGE
        # When a contact opens or closes, errors decrease more slowly with the step than elsewhere.
        change = change if good or change < HALF else HALF
        state[WORST, lane] = change if change < state[MOST, lane] else state[MOST, lane]
        state[MOST, lane] = GROWTH if good else 1.0
        state[GOOD, lane] = 1.0 if good else 0.0
        state[TRIED, lane] += 1.0
        state[STEPS, lane] += state[GOOD, lane]


@inlined
def may_end(lane, beads, until, state):
    """Whether a chain may end after an accepted step, or a check of its wall is due."""
    time = state[TIME, lane]
    if time >= until or time + state[STEP, lane] >= state[DUE, lane]:
        return True
    if state[WATCH_START, lane] > 0.0:
        return False
    passed = state[PEAKS, lane] + state[CROSSINGS, lane] == 2.0 * beads - 2.0
    lone = state[WORST, lane] >= GROWTH or state[LENGTH, lane] > LONG_STEP * time
    return passed or lone


@compiled
def ending(w, beads, lane, chain, numbers, walled, state, gauges, records):
    """Reason for a chain to end after an accepted step; 0 if it continues."""
    time, impulse = state[TIME, lane], gauges[lane, 0, IMPULSE]
    by_itself = numbers[BY_ITSELF] != 0.0
    passed = state[PEAKS, lane] == beads - 1.0 and state[CROSSINGS, lane] == beads - 1.0
    started = state[WATCH_START, lane] > 0.0
    closed = started and state[TRANSIT, lane] == 0.0
    if time >= numbers[UNTIL]:
        return TIME_REACHED
    lone = state[WORST, lane] >= GROWTH or state[LENGTH, lane] > LONG_STEP * time
    if passed and not started:
        if by_itself and not walled:
            if numbers[LONGEST] > 0.0:
                peak = gauges[lane, gauges.shape[1] - 1, PEAK]
                return ending_on_cap(w, beads, lane, state, peak, records, numbers[LONGEST], lone)
            return PULSE_LEFT
        if walled:
            start_watch(w, beads, lane, state, records)
            started = True
    if lone and not started and (by_itself or walled):
        if nothing_can_happen(w, beads, lane):
            close(lane, state, impulse)
            closed = True
    if closed or not walled or not started:
        return NOTHING_MORE if closed and by_itself else 0
    if time + state[STEP, lane] < state[DUE, lane] or state[DUE, lane] > numbers[UNTIL]:
        return 0
    peak, can_escape = gauges[lane, 0, PEAK], numbers[CAN_ESCAPE] != 0.0
    if can_escape and numbers[PEAK_ONLY] != 0.0:
        return ending_with_peak(w, beads, lane, state, gauges[lane, 0], numbers[REBOUNDS])
    restart(lane, state, gauges[lane, 0, PEAK_TIME])
    check_wall(w, beads, lane, chain, state, peak, impulse)
    if not by_itself:
        return 0
    if state[TRANSIT, lane] == 0.0:
        return NOTHING_MORE
    late = expired(lane, state, numbers[REBOUNDS], can_escape)
    if late or held(lane, state):
        if complete(w, beads, lane, chain, can_escape, state, peak):
            return WALL_DONE
    return TRANSIT_LIMIT if late else 0


@inlined
def read_lane(w, beads, lane, least_push, places, pushes, state, gauges, kinks, count):
    """`read_gauges` of one lane."""
    h, pressed = state[LENGTH, lane], pushes[0, 0, lane] > 0.0
    for g in range(len(places)):
        start, end, top = pushes[0, g, lane], pushes[8, g, lane], 0.0
        # Stage 7 is at the end of the step, too, and less accurate.
        for stage in range(2, STAGES):
            force = pushes[stage, g, lane]
            top = force if force > top and stage != 7 else top
        if top > 0.0 or start > 0.0:
            defect = impulse_defect(places[g, 0], places[g, 1], lane, kinks, count)
            gauges[lane, g, IMPULSE] += impulse_of(h, pushes, g, lane) - defect
            if top > (1.0 - FALL) * gauges[lane, g, PEAK]:
                record_largest(w, beads, lane, places[g, 0], places[g, 1], start, end, top, state,
                               gauges[lane, g], kinks, count)  # fmt: skip
            if g > 0:
                record_fall(end, gauges[lane, g])
        pushes[0, g, lane] = end
    impulse = gauges[lane, 0, IMPULSE]
    if pressed and pushes[0, 0, lane] == 0.0:
        state[LAST_END, lane], state[LAST_IMPULSE, lane] = state[TIME, lane] + h, impulse
    if state[FIRST_END, lane] == 0.0 and impulse > least_push and pushes[0, 0, lane] == 0.0:
        if w[NEW_V + beads * LANES + lane] < 0.0:
            state[FIRST_END, lane] = state[TIME, lane] + h
            state[FIRST_IMPULSE, lane] = impulse


@compiled
def read_gauges(w, beads, numbers, places, pushes, state, gauges, which, kinks, count):
    """Update impulses and largest forces of gauges, and the ends of contacts with the wall."""
    for lane in range(len(which)):
        if state[GOOD, lane] > 0.0 and which[lane] >= 0:
            least_push = numbers[which[lane], LEAST_PUSH]
            read_lane(w, beads, lane, least_push, places, pushes, state, gauges, kinks, count)


@compiled
def accept(w, beads, state):
    """Advance the lanes whose step is accepted."""
    size, count = beads * LANES, 0.0
    for lane in range(LANES):
        count += state[GOOD, lane]
    if count == LANES:
        for i in range(size):
            w[X + LANES + i] = w[NEW_X + LANES + i]
            w[V + LANES + i] = w[NEW_V + LANES + i]
            w[F0 + i] = w[F8 + i]
        return
    spread(w, H, beads, state[GOOD])
    for i in range(size):
        yes = w[H + i] > 0.0
        w[X + LANES + i] = w[NEW_X + LANES + i] if yes else w[X + LANES + i]
        w[V + LANES + i] = w[NEW_V + LANES + i] if yes else w[V + LANES + i]
        w[F0 + i] = w[F8 + i] if yes else w[F0 + i]


@entry_point
def follow(
    chains, numbers, places, rtol, most_steps, hertz, walled, careful,
    records, summary, readings, signal, w, state, pushes, gauges, which, kinks,
):  # fmt: skip
    """Integrate chains of equal length until each has ended, or until ``signal`` requests a stop.

    Parameters
    ----------
    chains, numbers : (C, GIVEN_ROWS, N + 1) and (C, NUMBERS), as in `elastic_layout`
    places : (G, 2) contacts whose mean force each gauge measures; gauge 0 is the right wall
    rtol, most_steps : tolerance, and limit of the tried steps
    hertz, walled : whether all exponents are 3/2, and whether chains have a right wall
    careful : whether open contacts may close and open again within a step
    records, summary, readings : (C, RECORDS, N), (C, SUMMARY), (C, G, GAUGE_ROWS) results
    signal : (2,) see `STOP` and `DONE`
    w, state, pushes, gauges, which : zeros, of the shapes in `scratch_for`
    """
    count, beads = len(chains), chains.shape[2] - 1
    coming, running, kinked = 0, 0, 0
    for lane in range(LANES):
        which[lane] = -1
    for lane in range(min(LANES, count)):
        load(w, beads, lane, chains[coming], numbers[coming], places, rtol, pushes, state,
             gauges, records[coming])  # fmt: skip
        which[lane] = coming
        coming += 1
        running += 1
    while running > 0 and signal[STOP] == 0:
        for lane in range(LANES):
            if which[lane] < 0:
                state[STEP, lane] = state[LENGTH, lane] = 0.0
                continue
            left = numbers[which[lane], UNTIL] - state[TIME, lane]
            state[LENGTH, lane] = min(state[STEP, lane], left)
        spread(w, H, beads + 1, state[LENGTH])
        if hertz:
            kinked = find_kinks(w, beads, rtol, which, state, kinks, kinked)
        events = take_step(w, beads, hertz, rtol, places, pushes, state, kinks, kinked)
        new_lengths(state)
        if careful:
            for lane in range(LANES):
                h = state[LENGTH, lane]
                if which[lane] >= 0 and state[GOOD, lane] > 0.0:
                    if closes_unseen(w, beads, lane, h):
                        state[GOOD, lane], state[WORST, lane] = 0.0, 0.5
        if events > 0.0:
            record_events(w, beads, rtol, state, state[GOOD], which, records, kinks, kinked)
        read_gauges(w, beads, numbers, places, pushes, state, gauges, which, kinks, kinked)
        accept(w, beads, state)
        pass_step(kinks, kinked, state)
        for lane in range(LANES):
            c = which[lane]
            if c < 0:
                continue
            h, status = state[LENGTH, lane], 0
            if state[GOOD, lane] > 0.0:
                reached = h < state[STEP, lane]
                state[TIME, lane] = numbers[c, UNTIL] if reached else state[TIME, lane] + h
                state[SINCE_CROSSING, lane] += h
                state[STEP, lane] = h * state[WORST, lane]
                if may_end(lane, beads, numbers[c, UNTIL], state):
                    status = ending(w, beads, lane, chains[c], numbers[c], walled, state,
                                    gauges, records[c])  # fmt: skip
            else:
                state[STEP, lane] = h * state[WORST, lane]
                if not state[STEP, lane] > max(MIN_STEP, 1e-17 * state[TIME, lane]):
                    status = STEP_TOO_SMALL
            if status == 0 and state[TRIED, lane] >= most_steps:
                status = STEP_LIMIT
            if status == 0:
                continue
            if status == GO_BACK:
                drop_kinks(lane, kinks, kinked)
                go_back(w, beads, lane, state, gauges[lane, 0], pushes)
                continue
            store(w, beads, lane, chains[c], numbers[c], status, state, gauges, places, records[c],
                  summary[c], readings[c])  # fmt: skip
            signal[DONE] += 1
            which[lane], running = -1, running - 1
            drop_kinks(lane, kinks, kinked)
            for k in range(beads):
                w[PEAKED + k * LANES + lane] = w[CROSSED + k * LANES + lane] = 1.0
            if coming < count:
                load(w, beads, lane, chains[coming], numbers[coming], places, rtol, pushes,
                     state, gauges, records[coming])  # fmt: skip
                which[lane] = coming
                coming += 1
                running += 1

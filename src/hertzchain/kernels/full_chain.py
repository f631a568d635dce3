r"""Integration of all moving beads of a chain by adaptive methods of order 8.

`advance` takes steps (`hertzchain.kernels.stepping`) for the beads that need them
(`hertzchain.kernels.active_beads`), and locates events within each step
(`hertzchain.kernels.events`).

When a contact opens or closes, and when the impact begins, the force is not smooth (a power 3/2 of
time); the error estimate then shortens the steps.  If the force of a law jumps, depends on history
or is cut off, the step ends at the first time at which a contact must change its mode
(`hertzchain.kernels.contact_modes`).
"""

from __future__ import annotations

import numpy as np

from .active_beads import (
    STAY,
    STRIDE,
    bounds,
    collide_behind,
    contact_numbers,
    contacts_within,
    earliest_contact,
    leave_behind,
    part_of,
    place_behind,
    put_back,
    take_out,
    trimmed,
    unresolved_speed,
    window_too_small,
)
from .compilation import compiled, entry_point
from .conservation import kinetic, update_drift
from .contact_modes import (
    MIN_RELATIVE_SPEED,
    first_modes,
    follow_wall,
    forget_unloading,
    may_close_unseen,
    switch,
)
from .dop853 import STAGES, STEP_STAGES
from .driving import MOVING_WALL, NOTHING, PUSH, wall_motion
from .events import (
    least_speed,
    raise_to_rounding,
    record_events,
    record_jumps,
    record_stops,
)
from .forces import copy, overlap_and_closing
from .implicit import remember_overlaps
from .interpolant import COEFFICIENTS
from .mode_search import first_switch
from .state_layout import (
    CROSSINGS,
    EVALUATIONS,
    FASTEST,
    FROZEN,
    HIGH,
    IDLE_UNTIL,
    LAST_CROSSING,
    LOW,
    MOMENTUM_UNIT,
    PEAKS,
    SEGMENT,
    SINCE_CROSSING,
    STEP,
    STEPS,
    SWITCHES,
    TIME,
    UNRESOLVED,
)
from .stepping import SHRINKAGE, begin, change_of_step, first_row, is_implicit, take_step
from .wall_events import count_touches, record_wall_ends

# Status codes that `advance` returns.
RUNNING, PULSE_LEFT, TIME_REACHED, FRAMES_FULL, STEP_TOO_SMALL, PULSE_LOST, LAST_STEP = range(7)
# Further codes, which only `advance_window` returns: the window must be moved; it was too small for
# the last step, which is repeated; a contact behind the window may close.
WINDOW_MOVED, WINDOW_TOO_SMALL, CONTACT_BEHIND = 7, 8, 9

MIN_STEP = 1e-280
# If the pulse has not left the chain by this time, it never will.
ENDLESS = 1e300
# Largest relative difference of two accelerations that are equal except for rounding.
SAME_FALL = 1e-12
# Free flight of all beads is checked only after a step longer than this fraction of the elapsed
# time, because beads in contact do not allow such steps.
LONG_STEP = 0.1
# Number of successive steps too short to change the time, after which the run is stopped.
MAX_FROZEN = 100_000
# Longest step, as a fraction of the duration of a cubic rise of the drive's force.  The work on a
# free bead is of degree 8 in time, which the steps integrate exactly but the interpolant does not.
RISE_PART = 0.125
# Rows of scratch, each as long as the state.
ROWS = STAGES + COEFFICIENTS + 7


@compiled
def nothing_can_happen(y, setup, contacts):
    """Whether no two beads touch or approach each other: all are in free flight permanently."""
    beads = len(setup.inverse_mass)
    if contacts is None:
        for k in range(beads - 1):
            if y[k] > y[k + 1] or y[beads + k] > y[beads + k + 1]:
                return False
        return True
    if setup.drive != NOTHING:
        return False
    for c in range(beads + 1):
        if setup.stiffness[c] == 0.0:
            continue
        overlap, closing = overlap_and_closing(c, y, beads, setup.gap[c], (0.0, 0.0, 0.0))
        # Beads that fall freely keep their distance, except for rounding.
        behind = setup.body_force[c - 1] * setup.inverse_mass[c - 1] if c > 0 else 0.0
        ahead = setup.body_force[c] * setup.inverse_mass[c] if c < beads else 0.0
        pressing = behind - ahead > SAME_FALL * (abs(behind) + abs(ahead))
        if overlap > 0.0 or closing > 0.0 or pressing:
            return False
    return True


@compiled
def largest_speed(so_far, y, beads):
    """The largest speed so far, including those of a state."""
    largest = so_far
    for k in range(beads):
        largest = max(largest, abs(y[beads + k]))
    return largest


@entry_point
def start(y, clock, counts, setup, contacts, first_step):
    """Set the clock to zero, the first modes of the contacts and the reference of the drift."""
    clock[:] = 0.0
    counts[:] = 0
    counts[LAST_CROSSING] = -1
    counts[HIGH] = len(setup.inverse_mass)
    clock[STEP], clock[IDLE_UNTIL] = first_step, np.inf
    if contacts is not None:
        first_modes(y, setup, contacts)
    update_drift(y, clock, setup, contacts, 0, (0.0, 0.0, 0.0), True)


@compiled
def advance_window(
    y, chain, inverse_mass, low, edge, flights, flying, trim, budget, clock, counts, setup,
    contacts, until, stop_when_left, rtol, pause, frame_times, growing, frames, frame_forces,
    peaks, crossings, walls, stages, dense, work, expected,
):  # fmt: skip
    """`advance` for the beads of a window, from bead ``low`` on, until the window moves.

    ``y`` is the state of the window; ``chain`` and ``inverse_mass`` are those of all beads.
    ``flying`` is the energy and momentum of the beads behind the window, ``edge`` the
    `contact_numbers` of the contact with them, ``trim`` the result of `trimmed`.  ``peaks`` are
    those of the window, ``crossings`` those of the chain.  ``counts`` receives the ends of the next
    window.  Returns a status code and the number of steps tried.
    """
    beads = len(setup.inverse_mass)
    all_beads = (len(chain) - (len(y) - 2 * beads)) // 2
    trial, y_new, scratch, scale = work[0], work[1], work[2], work[3, :beads]
    implicit, reached = is_implicit(setup, contacts), least_speed(rtol, setup, contacts)
    behind = chain[all_beads + low - 1] if low > 0 else 0.0
    begin(clock[TIME], y, clock[STEP], setup, contacts, counts[SEGMENT], rtol, stages, work, scale)
    for tried in range(1, budget + 1):
        time, h = clock[TIME], clock[STEP]
        segment = counts[SEGMENT]
        piece_end = np.inf
        if contacts is not None and segment + 1 < len(setup.piece_starts):
            piece_end = setup.piece_starts[segment + 1]
            if setup.drive == PUSH and setup.pieces[segment, 3] != 0.0:
                h = min(h, RISE_PART * (piece_end - setup.piece_starts[segment]))
        stop = min(until, piece_end)
        cut = time + h >= stop
        last_step = cut and stop == until
        if last_step and pause:
            return LAST_STEP, tried
        if cut:
            h = stop - time
        if stop_when_left and not time + h < ENDLESS:
            return PULSE_LOST, tried
        if growing and time + h >= frame_times[-1]:
            return FRAMES_FULL, tried
        if low > 0 and not time + h < clock[IDLE_UNTIL]:
            return CONTACT_BEHIND, tried - 1
        error, evaluations = take_step(
            time, y, h, setup, contacts, segment, rtol, stages, trial, y_new, work, scale
        )
        counts[EVALUATIONS] += evaluations
        change = change_of_step(error, implicit)
        if not error <= 1.0:
            clock[STEP] = h * (change if error > 1.0 else SHRINKAGE)
            if not clock[STEP] > MIN_STEP:
                return STEP_TOO_SMALL, tried
            continue
        if contacts is not None and may_close_unseen(
            time, h, y, y_new, stages, first_row(contacts), scale, setup, segment, rtol
        ):
            clock[STEP] = 0.5 * h
            continue
        if window_too_small(
            time + h, y_new, low, all_beads, behind, STAY * clock[UNRESOLVED], flights, setup,
            contacts, edge,
        ):  # fmt: skip
            return WINDOW_TOO_SMALL, tried - 1
        # Steps this long occur only if the beads are in free flight.
        lone = (error == 0.0 or h > LONG_STEP * time) and not clock[IDLE_UNTIL] < np.inf
        if stop_when_left and lone and nothing_can_happen(y, setup, contacts):
            return PULSE_LOST, tried

        switching, dense_is_found = -1, False
        if contacts is not None:
            copy(contacts.force, contacts.last_force)
        still = 0.0
        if contacts is not None:
            # At the beginning of a motion from rest, the largest speed is that of this step.
            still = MIN_RELATIVE_SPEED * largest_speed(clock[FASTEST], y_new, beads)
            switching, theta, dense_is_found = first_switch(
                time, y, h, y_new, stages, dense, setup, contacts, segment, still, trial, scratch,
                contacts.on_positions,
            )  # fmt: skip
            if switching >= 0 and theta < 1.0:
                h *= theta
                cut = last_step = dense_is_found = False
                _, evaluations = take_step(
                    time, y, h, setup, contacts, segment, rtol, stages, trial, y_new, work, scale
                )
                counts[EVALUATIONS] += evaluations
        time_new = stop if cut else time + h
        record_events(
            time, time_new, h, y, y_new, dense_is_found, low, chain, flights, inverse_mass, clock,
            counts, setup, contacts, segment, stages, dense, scale, reached, expected, frame_times,
            frames, frame_forces, peaks, crossings, walls, trial, scratch,
        )  # fmt: skip

        if contacts is not None and implicit:
            remember_overlaps(contacts, contacts.implicit)
        copy(y_new, y)
        copy(stages[STEP_STAGES], stages[0])
        clock[TIME] = time_new
        clock[SINCE_CROSSING] += h
        counts[FROZEN] = counts[FROZEN] + 1 if time_new == time else 0
        if counts[FROZEN] > MAX_FROZEN:
            return STEP_TOO_SMALL, tried
        if not cut and switching < 0:
            clock[STEP] = h * change
        counts[STEPS] += 1
        if contacts is not None and switching >= 0:
            switch(
                switching, time_new, y, setup, contacts, segment, still, scratch,
                contacts.on_positions,
            )  # fmt: skip
            counts[SWITCHES] += 1
        if contacts is not None:
            wall = wall_motion(time_new, setup, segment)
            forget_unloading(y, wall, setup, contacts, contacts.on_positions)
        if cut and stop == piece_end:
            counts[SEGMENT] += 1
            if contacts is not None and setup.drive == MOVING_WALL:
                follow_wall(time_new, y, setup, contacts, counts[SEGMENT], still, scratch,
                            contacts.on_positions)  # fmt: skip
        if switching >= 0 or cut:
            begin(time_new, y, clock[STEP], setup, contacts, counts[SEGMENT], rtol, stages, work,
                  scale)  # fmt: skip
            if contacts is not None:
                raise_to_rounding(clock[STEP], scale, reached, setup, contacts)
            counts[PEAKS] += record_jumps(time_new, y, stages, scale, reached, low, peaks)
            if contacts is not None:
                record_stops(clock, counts, y, stages, scale, reached, setup, contacts, low, chain,
                             inverse_mass, crossings)  # fmt: skip
        if contacts is not None:
            record_wall_ends(time_new, y, stages[0], setup, counts[SEGMENT], clock[MOMENTUM_UNIT],
                             crossings, walls)  # fmt: skip
            count_touches(time_new, y, stages[0], walls)
        update_drift(y, clock, setup, contacts, counts[SEGMENT], flying, False)
        clock[UNRESOLVED] = unresolved_speed(y, beads, rtol, setup, contacts)
        now = bounds(y, setup, contacts, low, all_beads, trim, clock[UNRESOLVED])
        counts[LOW], counts[HIGH] = now
        left = counts[PEAKS] == all_beads - 1 and counts[CROSSINGS] == all_beads - 1
        if stop_when_left and left:
            return PULSE_LEFT, tried
        if last_step:
            return TIME_REACHED, tried
        if now[0] != low or now[1] != low + beads:
            return WINDOW_MOVED, tried
    return RUNNING, budget


@entry_point
def advance(
    y, clock, counts, setup, contacts, flights, until, stop_when_left, rtol, budget, bead_steps,
    pause, frame_times, growing, frames, frame_forces, peaks, crossings, walls, accelerations,
    scratch, ends, expected,
):  # fmt: skip
    """Take up to ``budget`` steps; returns a status code.

    All variables of the run are in the arrays, so that a further call resumes it.

    Parameters
    ----------
    y : (2N,) or (2N + ACCUMULATORS,) state; ``clock`` (CLOCK_SIZE,) and ``counts`` (COUNTS_SIZE,)
    setup, contacts : parameters of the equation of motion; modes and history of the contacts
    flights : (FLIGHT_ROWS, N) positions and times at which the beads behind the window left it
    until : time at which the run ends; with ``stop_when_left`` it also ends once all events are
        recorded
    rtol : tolerated error of a step, in units of the speeds around each bead
    bead_steps : limit of the sum over steps of the number of beads in the window; it also returns
        when this is reached
    pause : return before the step that ``until`` would cut short, in the state from which a longer
        run would continue
    frame_times, frames : (F,) times at which to save, and the (F, len(y)) states saved; with
        ``growing`` it returns `FRAMES_FULL` before a step would pass the last of these times
    frame_forces : (F, N + 1) contact forces saved; not used for a default chain
    peaks, crossings : (2, N), (CROSSING_ROWS, N - 1) as in `hertzchain.kernels.state_layout`;
        time 0 = not yet
    walls : (WALL_ROWS, 2) of the left and the right wall; 0 = not yet
    accelerations : (N,) accelerations at the start of the next step
    scratch, ends, expected : (ROWS * len(y),), (2, N + 1), (3, N) scratch
    """
    beads = len(setup.inverse_mass)
    trim = trimmed(setup, contacts)
    low, high, code, more = counts[LOW], counts[HIGH], WINDOW_MOVED, STRIDE
    nothing = (0.0, 0.0, 0.0)
    flying = kinetic(y[beads : beads + low], setup.inverse_mass[:low], nothing)
    accelerations[:] = 0.0
    while True:
        part = part_of(setup, contacts, low, high, ends)
        touching = contacts_within(contacts, low, high)
        edge = contact_numbers(low, setup, contacts)
        length = len(y) - 2 * (beads - (high - low))
        rows = scratch[: ROWS * length].reshape((ROWS, length))
        stages, dense = rows[:STAGES], rows[STAGES : STAGES + COEFFICIENTS]
        work, near = rows[STAGES + COEFFICIENTS : ROWS - 1], rows[ROWS - 1]
        take_out(y, beads, low, high, near)
        steps = counts[STEPS]
        allowed = min(budget, 1 + bead_steps // (high - low))
        code, tried = advance_window(
            near, y, setup.inverse_mass, low, edge, flights, flying, trim, allowed, clock, counts,
            part, touching, until, stop_when_left, rtol, pause, frame_times, growing, frames,
            frame_forces, peaks[:, low:high], crossings, walls, stages, dense, work,
            expected[:, : high - low],
        )  # fmt: skip
        put_back(near, beads, low, high, y)
        budget -= tried
        bead_steps -= tried * (high - low)
        time, last = clock[TIME], low
        if code < WINDOW_MOVED:
            copy(stages[0, high - low : 2 * (high - low)], accelerations[low:high])
        if code == WINDOW_TOO_SMALL:
            more *= 2
            low, high = max(0, low - more), min(beads, high + more)
        elif code == CONTACT_BEHIND:
            place_behind(y, beads, 0, low, time, flights)
            stay = STAY * clock[UNRESOLVED]
            done = collide_behind(y, low, time, clock[UNRESOLVED], setup, contacts, flights)
            clock[IDLE_UNTIL] = earliest_contact(y, 0, low, stay, time, setup, contacts)
            flying = kinetic(y[beads : beads + low], setup.inverse_mass[:low], nothing)
            if not (done and time + clock[STEP] < clock[IDLE_UNTIL]):
                low = 0
        else:
            low, high, more = counts[LOW], counts[HIGH], STRIDE
            if last == 0 and counts[STEPS] > steps:
                clock[IDLE_UNTIL] = np.inf
        if low < last:
            place_behind(y, beads, low, last, time, flights)
            flying = kinetic(y[beads : beads + low], setup.inverse_mass[:low], nothing)
        elif low > last and counts[STEPS] > steps:
            place_behind(y, beads, max(last - 1, 0), last, time, flights)
            leave_behind(y, last, low, time, flights)
            stay = STAY * clock[UNRESOLVED]
            earliest = earliest_contact(y, last, low, stay, time, setup, contacts)
            clock[IDLE_UNTIL] = min(clock[IDLE_UNTIL], earliest)
            flying = kinetic(y[beads + last : beads + low], setup.inverse_mass[last:low], flying)
        if code < WINDOW_MOVED:
            place_behind(y, beads, 0, low, time, flights)
            return code

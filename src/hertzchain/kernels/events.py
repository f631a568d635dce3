r"""Events within the steps: maxima of velocities and overlaps, and saved times.

On the interpolant of a step (`hertzchain.kernels.interpolant`), the first maximum of each
bead's velocity and the largest overlap of each contact are located by secants.
"""

from __future__ import annotations

from .active_beads import place_behind, put_back, trimmed
from .change_of_sign import first_change_of
from .compilation import compiled
from .contact_law import LOADED, force, law_of
from .contact_modes import sharpest_turn
from .dop853 import STEP_STAGES
from .driving import NOTHING
from .forces import copy
from .implicit import FINEST, closes_throughout, first_rest
from .interpolant import difference, polynomial, slope, state_within, value
from .leading_pulse import note_leading_pulse, rise_of
from .limits import REACHED, ROUNDED
from .nystrom import SHARPER
from .state_layout import (
    CROSSING_TIME,
    CROSSINGS,
    EVALUATIONS,
    FRAMES,
    LARGEST_OVERLAP,
    LAST_CROSSING,
    OVERLAP,
    PEAK_TIME,
    PEAK_VELOCITY,
    PEAKS,
    RESIDENCE,
    SINCE_CROSSING,
    TIME,
)
from .stepping import first_row, forces_within, interpolate, is_implicit, on_positions
from .stiff_law import closes_in, force_within
from .wall_events import record_walls, wall_may_peak

# The limit `REACHED` in tolerances where all beads move simultaneously and velocities below the
# tolerance may have any sign: under static forces, but not more than `MOST`, and in implicit steps,
# whose contacts may all be stiff.
TOLERANCES, MOST, STIFF_TOLERANCES = 100.0, 1e-4, 1e3


@compiled
def least_speed(rtol, setup, contacts):
    """Fraction of the speeds around a bead above which the pulse has reached the bead."""
    if is_implicit(setup, contacts):
        return max(REACHED, STIFF_TOLERANCES * max(rtol, FINEST))
    least = REACHED if contacts is None or not on_positions(contacts) else SHARPER * REACHED
    return least if trimmed(setup, contacts)[1] else max(least, min(TOLERANCES * rtol, MOST))


@compiled
def raise_to_rounding(h, scale, reached, setup, contacts):
    """Raise the units of the speeds of beads to those that rounding errors of forces may cause."""
    pushing, limit = contacts.last_force, ROUNDED * h / reached
    for k in range(len(scale)):
        unknown = limit * (abs(pushing[k]) + abs(pushing[k + 1])) * setup.inverse_mass[k]
        scale[k] = unknown if unknown > scale[k] else scale[k]


@compiled
def net_force_within(theta, k, y, dense, setup):
    """Net force on a bead of an elastic chain at the fraction theta of a completed step.

    It follows from positions, because the slope of the velocity is inaccurate where the last
    contact of a bead opens.
    """
    here = value(k, theta, y, dense)
    left = value(k - 1, theta, y, dense) if k > 0 else 0.0
    right = value(k + 1, theta, y, dense) if k < len(setup.inverse_mass) - 1 else 0.0
    behind, ahead = left - here - setup.gap[k], here - right - setup.gap[k + 1]
    return (
        force(behind, setup.stiffness[k], law_of(k, setup).exponent)
        - force(ahead, setup.stiffness[k + 1], law_of(k + 1, setup).exponent)
        + setup.body_force[k]
    )


@compiled
def acceleration_within(theta, k, h, y, dense, setup, contacts):
    """Acceleration of a bead, or net force on it, at the fraction theta of a completed step."""
    if contacts is not None:
        if on_positions(contacts) and setup.drive == NOTHING:
            return net_force_within(theta, k, y, dense, setup)
        return slope(len(setup.inverse_mass) + k, theta, h, dense)
    here = value(k, theta, y, dense)
    net = 0.0
    if k > 0:
        left = value(k - 1, theta, y, dense)
        net += force(left - here, setup.stiffness[k - 1], setup.exponent)
    if k < len(setup.inverse_mass) - 1:
        right = value(k + 1, theta, y, dense)
        net -= force(here - right, setup.stiffness[k], setup.exponent)
    return net


first_peak = first_change_of(acceleration_within)


@compiled
def closing_within(theta, c, closing, y, dense, setup, contacts):
    """Relative velocity of beads c and c + 1 at the fraction theta; not positive if they part.

    The speed at which a contact creeps may be less than the rounding error of the velocities.
    """
    if contacts is not None and setup.law.implicit and contacts.mode[c + 1] == LOADED:
        overlap = value(c, theta, y, dense) - value(c + 1, theta, y, dense) - setup.gap[c + 1]
        ahead = value(len(setup.inverse_mass) + c + 1, theta, y, dense)
        closes = closes_in(
            value(len(setup.inverse_mass) + c, theta, y, dense) - ahead, abs(ahead),
            force_within(c + 1, theta, contacts.implicit), overlap, setup.stiffness[c + 1],
            law_of(c + 1, setup).exponent,
        )  # fmt: skip
        return 1.0 if closes else 0.0
    return polynomial(theta, *closing)


first_rest_of_pair = first_change_of(closing_within)


@compiled
def crossing_within(c, beads, y, dense, setup, contacts):
    """Fraction of the step at which beads c and c + 1 first have equal velocities; 2 if none."""
    closing = difference(beads + c, beads + c + 1, y, dense)
    return first_rest_of_pair(closing[0], (c, closing, y, dense, setup, contacts))


@compiled
def may_peak(k, beads, stages, row, implicit):
    """Whether bead k, pushed at the start of the step, is not pushed at some stage.

    In an implicit step, a bead that has had no peak yet has been pushed up to the step.
    """
    i = beads + k
    if stages[0, i] <= 0.0 and not implicit:
        return False
    for j in range(row, STEP_STAGES + 1):
        if stages[j, i] <= 0.0:
            return True
    return False


@compiled
def rests(c, stages, setup, contacts):
    """Whether beads c and c + 1 stop approaching each other within an implicit step."""
    if contacts is not None and setup.law.implicit and contacts.mode[c + 1] == LOADED:
        return not closes_throughout(c + 1, setup, contacts.implicit, stages)
    return False


@compiled
def may_cross(c, h, stages, setup, contacts):
    """Whether beads c and c + 1, approaching at the start, may not approach at some time."""
    if contacts is not None and setup.law.implicit and contacts.mode[c + 1] == LOADED:
        return not closes_throughout(c + 1, setup, contacts.implicit, stages)
    closing = stages[0, c] - stages[0, c + 1]
    if closing <= 0.0:
        return False
    if on_positions(contacts):
        still = stages[STEP_STAGES, c] - stages[STEP_STAGES, c + 1]
        beads = len(setup.inverse_mass)
        return still <= 0.0 or (
            closing + still <= h * sharpest_turn(c + 1, beads, stages, first_row(contacts))
        )
    for j in range(1, STEP_STAGES + 1):
        if stages[j, c] <= stages[j, c + 1]:
            return True
    return False


@compiled
def touch(c, y, y_new, setup, contacts):
    """Whether beads c and c + 1 overlap at an end of the step.

    In a general chain they may fall together, or approach each other across a gap; the overlap must
    exceed the rounding error of their positions.
    """
    if contacts is None:
        return True
    gap = setup.gap[c + 1]
    for state in (y, y_new):
        left, right = state[c], state[c + 1]
        if left - right - gap > REACHED * (abs(left) + abs(right)):
            return True
    return False


@compiled
def record_peaks(h, time, y, y_new, stages, dense, setup, contacts, first, expected, peaks):
    """Record first maxima of velocity within the step, of the beads where one is expected.

    Returns their number, without bead 1, whose maximum is not required to end a run.
    """
    beads = len(setup.inverse_mass)
    found = 0
    for k in range(beads):
        if not expected[k]:
            continue
        of_bead = k, h, y, dense, setup, contacts
        theta = first_peak(acceleration_within(0.0, *of_bead), of_bead)
        if theta > 1.0 and is_implicit(setup, contacts):
            theta = first_rest(k, beads, stages)
        # Because of rounding, the interpolant may miss a change of sign at the end of the step.
        if theta > 1.0 and stages[STEP_STAGES, beads + k] <= 0.0:
            theta = 1.0
        if theta > 1.0:
            continue
        peaks[PEAK_TIME, k] = time + theta * h
        # A bead that has left both neighbours permanently keeps the velocity at the step's end.
        in_flight = stages[STEP_STAGES, beads + k] == 0.0 and (
            acceleration_within(theta, *of_bead) == 0.0
        )
        velocity = value(beads + k, theta, y, dense)
        peaks[PEAK_VELOCITY, k] = y_new[beads + k] if in_flight else velocity
        if first + k > 0:
            found += 1
    return found


@compiled
def record_jumps(time, y, stages, scale, reached, first, peaks):
    """Record first maxima of velocity where an acceleration jumped down, between two steps."""
    beads = len(scale)
    found = 0
    for k in range(min(first, 1), beads):
        i = beads + k
        jumped = stages[STEP_STAGES, i] > 0.0 and stages[0, i] <= 0.0
        if jumped and peaks[PEAK_VELOCITY, k] == 0.0 and y[i] > reached * scale[k]:
            peaks[PEAK_TIME, k] = time
            peaks[PEAK_VELOCITY, k] = y[i]
            if first + k > 0:
                found += 1
    return found


@compiled
def store_crossing(at, after, overlap, clock, counts, crossings):
    """Record the largest overlap of contact ``at``, a time ``after`` later than the clock.

    The residence time is counted from the previous crossing: a difference of two arrival times
    would suffer from cancellation where the pulse becomes much faster.
    """
    crossings[CROSSING_TIME, at] = clock[TIME] + after
    crossings[OVERLAP, at] = overlap
    crossings[LARGEST_OVERLAP, at] = max(crossings[LARGEST_OVERLAP, at], overlap)
    if counts[LAST_CROSSING] == at - 1:
        crossings[RESIDENCE, at] = clock[SINCE_CROSSING] + after
    counts[LAST_CROSSING] = at
    counts[CROSSINGS] += 1
    clock[SINCE_CROSSING] = -after


@compiled
def record_crossings(
    h, clock, counts, y, stages, dense, setup, contacts, first, chain, inverse_mass, expected,
    crossings, trial,
):  # fmt: skip
    """Record the first times of equal neighbour velocities within the step: largest overlaps.

    The window begins with bead ``first``; ``chain``, ``inverse_mass`` and the records are those
    of all beads.
    """
    beads = len(setup.inverse_mass)
    for c in range(beads - 1):
        if not expected[c]:
            continue
        theta = crossing_within(c, beads, y, dense, setup, contacts)
        ended = stages[STEP_STAGES, c] <= stages[STEP_STAGES, c + 1]
        if theta > 1.0 and (ended or rests(c, stages, setup, contacts)):
            theta = 1.0
        if theta > 1.0:
            continue
        behind = value(c, theta, y, dense)
        overlap = behind - value(c + 1, theta, y, dense)
        if contacts is not None:
            overlap = max(0.0, overlap - setup.gap[c + 1])
        store_crossing(first + c, theta * h, overlap, clock, counts, crossings)
        rise = rise_of(overlap, c, setup, contacts)
        state_within(theta, y, dense, trial)
        note_leading_pulse(
            first + c, rise, first, clock[TIME], counts, trial, chain, inverse_mass, crossings
        )


@compiled
def may_exceed(c, h, y, y_new, setup, contacts, largest):
    """Whether the overlap of beads c and c + 1 may have a maximum above the largest so far.

    A parabola rises above its values at the ends of the step by at most half of the term that is
    added to them.
    """
    beads = len(setup.inverse_mass)
    before, after = y[beads + c] - y[beads + c + 1], y_new[beads + c] - y_new[beads + c + 1]
    if not before > 0.0 or after > 0.0:
        return False
    overlap = max(y[c] - y[c + 1], y_new[c] - y_new[c + 1])
    if contacts is not None:
        overlap -= setup.gap[c + 1]
    return overlap + 0.25 * h * (before - after) > largest


@compiled
def record_largest_overlaps(y, y_new, dense, setup, contacts, first, expected, crossings):
    """Record maxima of overlaps that exceed the largest so far, of any wave."""
    beads = len(setup.inverse_mass)
    for c in range(beads - 1):
        if not expected[c]:
            continue
        theta = crossing_within(c, beads, y, dense, setup, contacts)
        if theta > 1.0:
            overlap = y_new[c] - y_new[c + 1]
        else:
            overlap = value(c, theta, y, dense) - value(c + 1, theta, y, dense)
        if contacts is not None:
            overlap -= setup.gap[c + 1]
        at = first + c
        crossings[LARGEST_OVERLAP, at] = max(crossings[LARGEST_OVERLAP, at], overlap)


@compiled
def record_stops(
    clock, counts, y, stages, scale, reached, setup, contacts, first, chain, inverse_mass,
    crossings,
):  # fmt: skip
    """Record largest overlaps of approaching beads that became stuck between two steps."""
    beads = len(scale)
    for c in range(beads - 1):
        closed_in = stages[STEP_STAGES, c] > stages[STEP_STAGES, c + 1]
        stopped = closed_in and stages[0, c] <= stages[0, c + 1]
        moves = abs(y[beads + c + 1]) > reached * scale[c + 1]
        if stopped and moves and crossings[CROSSING_TIME, first + c] == 0.0:
            overlap = y[c] - y[c + 1] - setup.gap[c + 1]
            store_crossing(first + c, 0.0, overlap, clock, counts, crossings)
            rise = rise_of(overlap, c, setup, contacts)
            note_leading_pulse(
                first + c, rise, first, clock[TIME], counts, y, chain, inverse_mass, crossings
            )


@compiled
def expect_first_peak(y, y_new, stages, row, scale, reached, implicit, peaks):
    """Whether the velocity of bead 1, which was not struck, may have its peak in the step."""
    beads = len(scale)
    forward = max(y[beads], y_new[beads]) > reached * scale[0]
    return forward and peaks[PEAK_VELOCITY, 0] == 0.0 and may_peak(0, beads, stages, row, implicit)


@compiled
def expect_events(
    h, y, y_new, stages, scale, reached, setup, contacts, first, peaks, crossings, expected
):
    """Mark beads and contacts that may have their first peak or crossing, or a larger overlap."""
    beads, implicit, row = len(scale), is_implicit(setup, contacts), first_row(contacts)
    anything = expected[0, 0] = first == 0 and expect_first_peak(
        y, y_new, stages, row, scale, reached, implicit, peaks
    )
    for k in range(1, beads):
        so_far = crossings[LARGEST_OVERLAP, first + k - 1]
        larger = may_exceed(k - 1, h, y, y_new, setup, contacts, so_far)
        expected[0, k] = expected[1, k - 1] = False
        expected[2, k - 1] = larger
        anything = anything or larger
        if peaks[PEAK_TIME, k] != 0.0 and crossings[CROSSING_TIME, first + k - 1] != 0.0:
            continue
        # A bead may reverse its direction within the step.
        before, after = y[beads + k], y_new[beads + k]
        forward = max(before, after) > reached * scale[k]
        peak = forward and peaks[PEAK_TIME, k] == 0.0 and may_peak(k, beads, stages, row, implicit)
        waiting = crossings[CROSSING_TIME, first + k - 1] == 0.0
        moves = max(abs(before), abs(after)) > reached * scale[k]
        crossing = moves and waiting and may_cross(k - 1, h, stages, setup, contacts)
        crossing = crossing and (
            touch(k - 1, y, y_new, setup, contacts) or (implicit and peaks[PEAK_TIME, k] > 0.0)
        )
        expected[0, k] = peak
        expected[1, k - 1] = crossing
        anything = anything or peak or crossing
    return anything


@compiled
def save_frames(time, time_new, h, y, dense, first, chain, flights, setup, contacts, segment,
                counts, frame_times, frames, frame_forces, trial, scratch):  # fmt: skip
    """Save states, and forces if requested, at the saved times within the step.

    ``y`` is the state of the window, which begins with bead ``first``, ``chain`` that of all beads.
    """
    beads = len(setup.inverse_mass)
    all_beads = (len(chain) - (len(y) - 2 * beads)) // 2
    frame = counts[FRAMES]
    while frame < len(frame_times) and frame_times[frame] <= time_new:
        theta = min(1.0, (frame_times[frame] - time) / h)
        state_within(theta, y, dense, trial)
        copy(chain, frames[frame])
        place_behind(frames[frame], all_beads, 0, first, frame_times[frame], flights)
        put_back(trial, all_beads, first, first + beads, frames[frame])
        if contacts is not None:
            forces_within(theta, time, h, trial, setup, contacts, segment, scratch)
            frame_forces[frame] = 0.0
            copy(contacts.force, frame_forces[frame, first : first + beads + 1])
        frame += 1
    counts[FRAMES] = frame


@compiled
def record_events(
    time, time_new, h, y, y_new, dense_is_found, first, chain, flights, inverse_mass, clock,
    counts, setup, contacts, segment, stages, dense, scale, reached, expected, frame_times, frames,
    frame_forces, peaks, crossings, walls, trial, scratch,
):  # fmt: skip
    """Record all events of a completed step, and compute its interpolant only if there are any."""
    frame = counts[FRAMES]
    save = frame < len(frame_times) and frame_times[frame] <= time_new
    if contacts is not None:
        raise_to_rounding(h, scale, reached, setup, contacts)
    event = expect_events(
        h, y, y_new, stages, scale, reached, setup, contacts, first, peaks, crossings, expected
    )
    walled = contacts is not None and wall_may_peak(
        time, h, y, y_new, stages, setup, contacts, segment, walls
    )
    if (save or event or walled) and not dense_is_found:
        counts[EVALUATIONS] += interpolate(
            time, y, h, y_new, setup, contacts, segment, stages, dense, trial, scratch
        )
    if event:
        counts[PEAKS] += record_peaks(
            h, time, y, y_new, stages, dense, setup, contacts, first, expected[0], peaks
        )
        record_crossings(
            h, clock, counts, y, stages, dense, setup, contacts, first, chain, inverse_mass,
            expected[1], crossings, trial,
        )  # fmt: skip
        record_largest_overlaps(y, y_new, dense, setup, contacts, first, expected[2], crossings)
    if walled:
        record_walls(
            time, h, y, y_new, setup, contacts, segment, stages, dense, walls, trial, scratch
        )
    if save:
        save_frames(time, time_new, h, y, dense, first, chain, flights, setup, contacts, segment,
                    counts, frame_times, frames, frame_forces, trial, scratch)  # fmt: skip

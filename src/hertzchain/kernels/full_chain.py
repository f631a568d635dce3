r"""The whole chain, every bead, by an adaptive Runge-Kutta method of order 8.

The state is one array ``y`` of length 2N: positions :math:`x_k`, then velocities
:math:`v_k`, and its derivative is :math:`(v_k, a_k)` with

.. math:: a_k = [F_{k-1} - F_k]/m_k, \qquad F_k = r_k (x_k - x_{k+1})_+^p .

`advance` takes steps of DOP853 (`hertzchain.kernels.dop853`) and looks between
them for what the eye would pick from the curves: the first maximum of each
bead's velocity and the largest overlap of each contact.  Both are found on the
method's interpolant of order 7 by bisection, not among the steps.

Contacts open and close with a force that is not smooth (a power 3/2 of time), and
so does the strike begin; there the error estimate shortens the steps by itself.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from hertzchain.kernels.dop853 import E3, E5, STAGES, STEP_STAGES, A, B, D

# What `advance` returns.
RUNNING, PULSE_LEFT, TIME_REACHED, FRAMES_FULL, STEP_TOO_SMALL, PULSE_LOST = range(6)

# Meaning of the entries of `clock` and `counts`, the parts of the state that are no arrays.
TIME, STEP, SINCE_CROSSING = 0, 1, 2
INITIAL_ENERGY, INITIAL_MOMENTUM, ENERGY_DRIFT, MOMENTUM_DRIFT, CLOCK_SIZE = range(3, 8)
STEPS, EVALUATIONS, FRAMES, PEAKS, CROSSINGS, LAST_CROSSING, FROZEN, COUNTS_SIZE = range(8)
# Rows of `peaks` and of `crossings`.
PEAK_TIME, PEAK_VELOCITY = 0, 1
CROSSING_TIME, OVERLAP, RESIDENCE = 0, 1, 2

# A bead slower than this, in parts of the speeds around it, is not reached yet: rounding
# ahead of the pulse could look like a maximum.
REACHED = 1e-11
# Beads to either side that set the scale of a bead's error, and the part of the fastest
# bead in contact that sets it where all of them are slow: the debris behind a pulse.
NEIGHBOURS = 3
SLOW = 1e-4
# Beads slower than this have not been reached: numbers that underflow ahead of the front.
AT_REST = 1e-290
SMALLEST_STEP = 1e-280
# A run that waits this long for the pulse to leave waits for ever.
ENDLESS = 1e300
BISECTIONS = 48
# Parts of a step that are searched for the first event: a light bead may turn twice in one.
PARTS = 8
# Steps too short for the clock to notice, in a row, after which the run is given up.
MOST_FROZEN = 100_000

compiled = njit(cache=True, nogil=True, error_model="numpy")


@compiled
def force(overlap, stiffness, exponent):
    """Contact force k d^p of a positive overlap; d^1.5 by a square root is 40 times faster."""
    if overlap <= 0.0:
        return 0.0
    if exponent == 1.5:
        return stiffness * overlap * np.sqrt(overlap)
    return stiffness * overlap**exponent


@compiled
def derivative(y, inverse_mass, stiffness, exponent, out):
    """Velocities and accelerations of all beads, Eq. (4) of the paper."""
    beads = len(inverse_mass)
    pushed = 0.0
    for k in range(beads - 1):
        pushing = force(y[k] - y[k + 1], stiffness[k], exponent)
        out[k] = y[beads + k]
        out[beads + k] = (pushed - pushing) * inverse_mass[k]
        pushed = pushing
    out[beads - 1] = y[2 * beads - 1]
    out[2 * beads - 1] = pushed * inverse_mass[beads - 1]


@compiled
def add_stages(y, h, weights, stages, count, out):
    """Write y + h * sum over the first stages of weight * stage into ``out``."""
    out[:] = y
    for j in range(count):
        if weights[j] != 0.0:
            factor = h * weights[j]
            for i in range(len(y)):
                out[i] += factor * stages[j, i]


@compiled
def try_step(y, h, inverse_mass, stiffness, exponent, stages, trial, y_new):
    """One step of order 8; stage 0 must hold the derivative at its start."""
    for s in range(1, STEP_STAGES):
        add_stages(y, h, A[s], stages, s, trial)
        derivative(trial, inverse_mass, stiffness, exponent, stages[s])
    add_stages(y, h, B, stages, STEP_STAGES, y_new)
    derivative(y_new, inverse_mass, stiffness, exponent, stages[STEP_STAGES])


@compiled
def complete_stages(y, h, inverse_mass, stiffness, exponent, stages, trial):
    """The three further stages that the interpolant needs."""
    for s in range(STEP_STAGES + 1, STAGES):
        add_stages(y, h, A[s], stages, s, trial)
        derivative(trial, inverse_mass, stiffness, exponent, stages[s])


@compiled
def velocity_scale(y, scale):
    """The speeds in which the beads' errors are measured.

    A bead's is the largest within a few beads, or a small part of that of the fastest
    bead in contact: beads that have lost contact move exactly, however fast they are.
    """
    beads = len(scale)
    fastest = 0.0
    for k in range(beads - 1):
        if y[k] > y[k + 1]:
            fastest = max(fastest, abs(y[beads + k]), abs(y[beads + k + 1]))
    for k in range(beads):
        largest = SLOW * fastest
        for j in range(max(k - NEIGHBOURS, 0), min(k + NEIGHBOURS + 1, beads)):
            largest = max(largest, abs(y[beads + j]))
        scale[k] = largest


@compiled
def error_norm(h, stages, scale, rtol):
    """Largest estimated error of a step, in tolerances; not a number if a stage is none.

    Positions count as the velocity error that would cause them within the step.
    """
    beads = len(scale)
    worst5 = 0.0
    worst3 = 0.0
    for k in range(beads):
        if scale[k] < AT_REST:
            continue
        for i in (k, beads + k):
            error5 = 0.0
            error3 = 0.0
            for j in range(STEP_STAGES + 1):
                error5 += E5[j] * stages[j, i]
                error3 += E3[j] * stages[j, i]
            unit = rtol * scale[k] if i < beads else rtol * scale[k] / h
            # Written so that what is not a number is kept: max() would lose it.
            if not abs(error5) / unit <= worst5:
                worst5 = abs(error5) / unit
            if not abs(error3) / unit <= worst3:
                worst3 = abs(error3) / unit
    if worst5 == 0.0:
        return 0.0
    return worst5 * worst5 / np.sqrt(worst5 * worst5 + 0.01 * worst3 * worst3)


@compiled
def interpolate(i, theta, h, y, y_new, stages):
    """Component i of the state at the fraction theta of a completed step."""
    change = y_new[i] - y[i]
    value = 0.0
    for row in range(3, -1, -1):
        coefficient = 0.0
        for j in range(STAGES):
            coefficient += D[row, j] * stages[j, i]
        value = (value + h * coefficient) * (theta if row % 2 == 1 else 1.0 - theta)
    value = (value + 2.0 * change - h * (stages[STEP_STAGES, i] + stages[0, i])) * theta
    value = (value + h * stages[0, i] - change) * (1.0 - theta)
    return y[i] + (value + change) * theta


@compiled
def acceleration_within(k, theta, h, y, y_new, stages, stiffness, exponent):
    """Net force on bead k at the fraction theta of a completed step."""
    here = interpolate(k, theta, h, y, y_new, stages)
    net = 0.0
    if k > 0:
        left = interpolate(k - 1, theta, h, y, y_new, stages)
        net += force(left - here, stiffness[k - 1], exponent)
    if k < len(stiffness):
        right = interpolate(k + 1, theta, h, y, y_new, stages)
        net -= force(here - right, stiffness[k], exponent)
    return net


@compiled
def peak_within(k, h, y, y_new, stages, stiffness, exponent):
    """Where in the step the net force on bead k first stops being positive; 2 if nowhere."""
    low = 0.0
    for part in range(1, PARTS + 1):
        high = part / PARTS
        if acceleration_within(k, high, h, y, y_new, stages, stiffness, exponent) <= 0.0:
            for _ in range(BISECTIONS):
                middle = 0.5 * (low + high)
                a = acceleration_within(k, middle, h, y, y_new, stages, stiffness, exponent)
                low, high = (middle, high) if a > 0.0 else (low, middle)
            return high
        low = high
    return 2.0


@compiled
def crossing_within(c, h, y, y_new, stages):
    """Where in the step the beads of contact c first have equal velocities; 2 if nowhere."""
    left = len(y) // 2 + c
    low = 0.0
    for part in range(1, PARTS + 1):
        high = part / PARTS
        ahead = interpolate(left + 1, high, h, y, y_new, stages)
        if interpolate(left, high, h, y, y_new, stages) <= ahead:
            for _ in range(BISECTIONS):
                middle = 0.5 * (low + high)
                ahead = interpolate(left + 1, middle, h, y, y_new, stages)
                closing = interpolate(left, middle, h, y, y_new, stages) > ahead
                low, high = (middle, high) if closing else (low, middle)
            return high
        low = high
    return 2.0


@compiled
def may_peak(k, stages):
    """Whether some stage of the step finds bead k, pushed at its start, no longer pushed."""
    i = stages.shape[1] // 2 + k
    if stages[0, i] <= 0.0:
        return False
    for j in range(1, STEP_STAGES + 1):
        if stages[j, i] <= 0.0:
            return True
    return False


@compiled
def may_cross(c, stages):
    """Whether some stage finds the beads of contact c, closing at its start, at equal speed."""
    if stages[0, c] <= stages[0, c + 1]:
        return False
    for j in range(1, STEP_STAGES + 1):
        if stages[j, c] <= stages[j, c + 1]:
            return True
    return False


@compiled
def record_peaks(h, time, y, y_new, stages, stiffness, exponent, expected, peaks):
    """First maxima of velocity within the step, of the beads where one is expected."""
    beads = len(stiffness) + 1
    found = 0
    for k in range(1, beads):
        if not expected[k]:
            continue
        theta = peak_within(k, h, y, y_new, stages, stiffness, exponent)
        if theta > 1.0:
            continue
        peaks[PEAK_TIME, k] = time + theta * h
        # A bead that has left both neighbours for good flies on at the step's last velocity.
        flies = stages[STEP_STAGES, beads + k] == 0.0 and (
            acceleration_within(k, theta, h, y, y_new, stages, stiffness, exponent) == 0.0
        )
        velocity = interpolate(beads + k, theta, h, y, y_new, stages)
        peaks[PEAK_VELOCITY, k] = y_new[beads + k] if flies else velocity
        found += 1
    return found


@compiled
def record_crossings(h, clock, counts, y, y_new, stages, expected, crossings):
    """First moments of equal neighbour velocities within the step: largest overlaps.

    The residence is counted from the crossing before, since the difference of two times
    loses its digits where the pulse becomes much faster than it was.
    """
    for c in range(crossings.shape[1]):
        if not expected[c]:
            continue
        theta = crossing_within(c, h, y, y_new, stages)
        if theta > 1.0:
            continue
        crossings[CROSSING_TIME, c] = clock[TIME] + theta * h
        behind = interpolate(c, theta, h, y, y_new, stages)
        crossings[OVERLAP, c] = behind - interpolate(c + 1, theta, h, y, y_new, stages)
        if counts[LAST_CROSSING] == c - 1:
            crossings[RESIDENCE, c] = clock[SINCE_CROSSING] + theta * h
        counts[LAST_CROSSING] = c
        counts[CROSSINGS] += 1
        clock[SINCE_CROSSING] = -theta * h


@compiled
def expect_events(y_new, stages, scale, peaks, crossings, expected):
    """Mark the beads and contacts whose first peak or crossing may lie within the step."""
    beads = len(scale)
    anything = False
    for k in range(1, beads):
        reached = y_new[beads + k] > REACHED * scale[k]
        peak = reached and peaks[PEAK_TIME, k] == 0.0 and may_peak(k, stages)
        waiting = crossings[CROSSING_TIME, k - 1] == 0.0
        crossing = reached and waiting and may_cross(k - 1, stages)
        expected[0, k] = peak
        expected[1, k - 1] = crossing
        anything = anything or peak or crossing
    return anything


@compiled
def nothing_can_happen(y):
    """Whether no beads touch and none approach: from here on all fly freely."""
    beads = len(y) // 2
    for k in range(beads - 1):
        if y[k] > y[k + 1] or y[beads + k] > y[beads + k + 1]:
            return False
    return True


@compiled
def conserved(y, inverse_mass, stiffness, exponent):
    """Energy, momentum and the sum of the beads' absolute momenta."""
    beads = len(inverse_mass)
    energy = 0.0
    momentum = 0.0
    absolute = 0.0
    for k in range(beads):
        p = y[beads + k] / inverse_mass[k]
        momentum += p
        absolute += abs(p)
        energy += 0.5 * p * y[beads + k]
        if k < beads - 1:
            overlap = y[k] - y[k + 1]
            energy += force(overlap, stiffness[k], exponent) * overlap / (exponent + 1.0)
    return energy, momentum, absolute


@compiled
def start(y, clock, counts, inverse_mass, stiffness, exponent, first_step):
    """Clock at zero, with the conserved quantities that drift is measured from."""
    energy, momentum, _ = conserved(y, inverse_mass, stiffness, exponent)
    clock[:] = 0.0
    counts[:] = 0
    counts[LAST_CROSSING] = -1
    clock[STEP] = first_step
    clock[INITIAL_ENERGY] = energy
    clock[INITIAL_MOMENTUM] = momentum


@compiled
def note_drift(y, clock, inverse_mass, stiffness, exponent):
    """Keep the largest relative departure from conservation.

    Momentum is compared with the sum of absolute momenta: in a backward taper the pulse
    gains momenta of thousands, against as much thrown back, and one is their difference.
    """
    energy, momentum, absolute = conserved(y, inverse_mass, stiffness, exponent)
    energy_drift = abs(energy / clock[INITIAL_ENERGY] - 1.0)
    momentum_drift = abs(momentum - clock[INITIAL_MOMENTUM]) / absolute
    clock[ENERGY_DRIFT] = max(clock[ENERGY_DRIFT], energy_drift)
    clock[MOMENTUM_DRIFT] = max(clock[MOMENTUM_DRIFT], momentum_drift)


@compiled
def advance(
    y, clock, counts, inverse_mass, stiffness, exponent,
    until, stop_when_left, rtol, budget,
    frame_times, growing, frames, peaks, crossings, stages, work, expected,
):  # fmt: skip
    """Take up to ``budget`` steps and say why it stopped.

    Everything that changes is in the arrays, so a run goes on where it stopped.

    Parameters
    ----------
    y : (2N,) state; ``clock`` (CLOCK_SIZE,) and ``counts`` (COUNTS_SIZE,) beside it
    inverse_mass, stiffness : (N,), (N - 1,); ``exponent`` the p of the force
    until : time not to step past; ``stop_when_left`` ends the run once all is recorded
    rtol : tolerated error of a step, in units of the speeds around each bead
    frame_times, frames : (F,) times to save at, and the (F, 2N) states saved; with
        ``growing`` the caller is asked for later times before a step would pass the last
    peaks, crossings : (2, N), (3, N - 1): time and velocity; time, overlap and residence;
        0 = not yet
    stages, work, expected : (STAGES, 2N), (3, 2N), (2, N) scratch
    """
    beads = len(inverse_mass)
    trial, y_new, scale = work[0], work[1], work[2, :beads]
    derivative(y, inverse_mass, stiffness, exponent, stages[0])
    for _ in range(budget):
        time, h = clock[TIME], clock[STEP]
        last_step = not stop_when_left and time + h >= until
        if last_step:
            h = until - time
        if stop_when_left and not time + h < ENDLESS:
            return PULSE_LOST
        if growing and time + h >= frame_times[-1]:
            return FRAMES_FULL
        velocity_scale(y, scale)
        try_step(y, h, inverse_mass, stiffness, exponent, stages, trial, y_new)
        counts[EVALUATIONS] += STEP_STAGES
        error = error_norm(h, stages, scale, rtol)
        change = 10.0 if error == 0.0 else min(10.0, max(0.2, 0.9 * error**-0.125))
        if not error <= 1.0:
            clock[STEP] = h * (change if error > 1.0 else 0.2)
            if not clock[STEP] > SMALLEST_STEP:
                return STEP_TOO_SMALL
            continue
        if stop_when_left and error == 0.0 and nothing_can_happen(y):
            return PULSE_LOST

        time_new = until if last_step else time + h
        frame = counts[FRAMES]
        save = frame < len(frame_times) and frame_times[frame] <= time_new
        event = expect_events(y_new, stages, scale, peaks, crossings, expected)
        if save or event:
            complete_stages(y, h, inverse_mass, stiffness, exponent, stages, trial)
            counts[EVALUATIONS] += STAGES - STEP_STAGES - 1
        if event:
            counts[PEAKS] += record_peaks(
                h, time, y, y_new, stages, stiffness, exponent, expected[0], peaks
            )
            record_crossings(h, clock, counts, y, y_new, stages, expected[1], crossings)
        while frame < len(frame_times) and frame_times[frame] <= time_new:
            theta = min(1.0, (frame_times[frame] - time) / h)
            for i in range(2 * beads):
                frames[frame, i] = interpolate(i, theta, h, y, y_new, stages)
            frame += 1
        counts[FRAMES] = frame

        y[:] = y_new
        stages[0] = stages[STEP_STAGES]
        clock[TIME] = time_new
        clock[SINCE_CROSSING] += h
        counts[FROZEN] = counts[FROZEN] + 1 if time_new == time else 0
        if counts[FROZEN] > MOST_FROZEN:
            return STEP_TOO_SMALL
        if not last_step:
            clock[STEP] = h * change
        counts[STEPS] += 1
        note_drift(y, clock, inverse_mass, stiffness, exponent)
        left = counts[PEAKS] == beads - 1 and counts[CROSSINGS] == beads - 1
        if stop_when_left and left:
            return PULSE_LEFT
        if last_step:
            return TIME_REACHED
    return RUNNING

"""Compiled drives: piecewise functions for the force on bead 1 or the position of the left wall."""

from __future__ import annotations

import numpy as np

from .compilation import compiled

# Kinds of drive: none, force on bead 1, position of the left wall.
NOTHING, PUSH, MOVING_WALL = range(3)
# A piece of the drive: a cubic in time, then amplitude and angular frequency of three sines.
CUBIC, SINES = 4, 3
# Values of n in the series of sin x - x for |x| < 1, from its last term; successive terms have the
# ratio -x^2/(n (n + 1)).
SINE_TERMS = tuple(range(18, 0, -2))
# If the slopes of the sines cancel to less than this fraction of the largest slope, their sum is a
# rounding error.
ROUNDED_SLOPE = 1e-14


@compiled
def sine_beyond_line(x):
    """Compute sin x - x without cancellation for small x."""
    if abs(x) > 1.0:
        return np.sin(x) - x
    square, total = x * x, 0.0
    for n in SINE_TERMS:
        total = (1.0 + total) * -square / (n * (n + 1.0))
    return x * total


@compiled
def drive_at(time, setup, segment):
    """Value, rate and acceleration of the drive at a time within a piece."""
    # A burst with a window begins with a higher power of time, because the linear terms of the
    # sines cancel.  At early times they are omitted: their rounding errors would exceed the sum.
    t = time - setup.piece_starts[segment]
    c = setup.pieces[segment]
    value = c[0] + t * (c[1] + t * (c[2] + t * c[3]))
    rate = c[1] + t * (2.0 * c[2] + t * 3.0 * c[3])
    second = 2.0 * c[2] + 6.0 * c[3] * t
    slope, largest, fastest = 0.0, 0.0, 0.0
    for i in range(SINES):
        amplitude, w = c[CUBIC + 2 * i], c[CUBIC + 2 * i + 1]
        slope += amplitude * w
        largest = max(largest, abs(amplitude * w))
        fastest = max(fastest, abs(w))
    if abs(slope) < ROUNDED_SLOPE * largest:
        slope = 0.0
    early = fastest * t < 1.0
    rate += slope
    if early:
        value += slope * t
    for i in range(SINES):
        amplitude, w = c[CUBIC + 2 * i], c[CUBIC + 2 * i + 1]
        value += amplitude * (sine_beyond_line(w * t) if early else np.sin(w * t))
        half = np.sin(0.5 * w * t)
        rate -= 2.0 * amplitude * w * half * half
        second -= amplitude * w * w * np.sin(w * t)
    return value, rate, second


@compiled
def rounding_of_drive(time, setup, segment):
    """Size of the terms of the drive that may cancel; its rounding error is relative to it."""
    t, c = time - setup.piece_starts[segment], setup.pieces[segment]
    size, fastest = 0.0, 0.0
    for i in range(SINES):
        size += abs(c[CUBIC + 2 * i])
        fastest = max(fastest, abs(c[CUBIC + 2 * i + 1]))
    return size if fastest * t >= 1.0 else 0.0


@compiled
def reach_of_wall(time, setup, segment):
    """Bounds of the size and acceleration of the drive from the start of a piece on."""
    t = time - setup.piece_starts[segment]
    c = setup.pieces[segment]
    size = abs(c[0]) + t * (abs(c[1]) + t * (abs(c[2]) + t * abs(c[3])))
    second = 2.0 * abs(c[2]) + 6.0 * abs(c[3]) * t
    for i in range(SINES):
        amplitude, w = abs(c[CUBIC + 2 * i]), c[CUBIC + 2 * i + 1]
        size += amplitude
        second += amplitude * w * w
    return size, second


@compiled
def wall_motion(time, setup, segment):
    """Position, velocity and acceleration of the left wall."""
    if setup.drive == MOVING_WALL:
        return drive_at(time, setup, segment)
    return 0.0, 0.0, 0.0

"""Explicit or implicit steps, their errors and interpolants."""

from __future__ import annotations

from .compilation import compiled
from .dop853 import STEP_STAGES
from .dop853_interpolant import find_coefficients
from .dop853_step import (
    complete_stages,
    error_norm,
    general_scale,
    try_step,
    velocity_scale,
)
from .driving import wall_motion
from .forces import copy, derivative
from .implicit import (
    implicit_coefficients,
    implicit_error,
    settle,
    try_implicit_step,
)
from .radau import IMPLICIT_STAGES
from .stiff_law import sliding_force_within

# Choice of the next step from the error: exponents, and bounds of the change.
EXPLICIT_ORDER, IMPLICIT_ORDER = -0.125, -1.0 / 6.0
SAFETY, SHRINKAGE, GROWTH = 0.9, 0.2, 10.0


@compiled
def is_implicit(setup, contacts):
    """Whether the steps of this chain are implicit."""
    if contacts is not None:
        return setup.law.implicit
    return False


@compiled
def begin(time, y, h, setup, contacts, segment, rtol, stages, work, scale):
    """Compute the derivative at the start of the next step."""
    if contacts is not None and setup.law.implicit:
        speeds = work[3, len(scale) : 2 * len(scale)]
        settle(
            time, y, h, setup, contacts, contacts.implicit, segment, rtol, stages, work[0], speeds,
            scale,
        )  # fmt: skip
        return
    derivative(time, y, setup, contacts, segment, stages[0])
    if contacts is not None:
        copy(contacts.force, contacts.last_force)


@compiled
def take_step(time, y, h, setup, contacts, segment, rtol, stages, trial, y_new, work, scale):
    """Take one step; returns its error in tolerances (NaN if it failed) and evaluations."""
    speeds = work[3, len(scale) : 2 * len(scale)]
    if contacts is None:
        try_step(time, y, h, setup, contacts, segment, stages, trial, y_new)
        velocity_scale(y, rtol, setup, speeds, scale)
        return error_norm(h, stages, scale, rtol, work[4:]), STEP_STAGES
    wall_speed = wall_motion(time + h, setup, segment)[1]
    if not setup.law.implicit:
        try_step(time, y, h, setup, contacts, segment, stages, trial, y_new)
        general_scale(time, h, y, y_new, wall_speed, setup, contacts, segment, rtol, speeds, scale)
        return error_norm(h, stages, scale, rtol, work[4:]), STEP_STAGES
    if not try_implicit_step(
        time, y, h, setup, contacts, contacts.implicit, segment, rtol, stages, y_new, speeds, scale
    ):
        return float("nan"), IMPLICIT_STAGES
    general_scale(time, h, y, y_new, wall_speed, setup, contacts, segment, rtol, speeds, scale)
    return implicit_error(h, stages, setup, scale, rtol), IMPLICIT_STAGES


@compiled
def change_of_step(error, implicit):
    """Factor from the length of this step to that of the next."""
    if error == 0.0:
        return GROWTH
    order = IMPLICIT_ORDER if implicit else EXPLICIT_ORDER
    return min(GROWTH, max(SHRINKAGE, SAFETY * error**order))


@compiled
def interpolate(time, y, h, y_new, setup, contacts, segment, stages, dense, trial):
    """Compute the coefficients of the interpolant of a step; returns evaluations."""
    if contacts is not None and setup.law.implicit:
        implicit_coefficients(h, stages, dense)
        return 0
    complete_stages(time, y, h, setup, contacts, segment, stages, trial)
    find_coefficients(h, y, y_new, stages, dense)
    return 3


@compiled
def forces_within(theta, time, h, state, setup, contacts, segment, scratch):
    """Compute the contact forces at the fraction theta of a step, from the state there."""
    if setup.law.implicit:
        wall = wall_motion(time + theta * h, setup, segment)
        for c in range(len(contacts.force)):
            contacts.force[c] = sliding_force_within(
                c, theta, h, state, wall, setup, contacts, contacts.implicit
            )
    else:
        derivative(time + theta * h, state, setup, contacts, segment, scratch)

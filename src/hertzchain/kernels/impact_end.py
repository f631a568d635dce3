"""End of the impact on a wall: times at which the wall is released and loaded again.

`hertzchain.kernels.wall_rule` states the rule.  The times are located within the steps, so that
they do not depend on the steps.
"""

from __future__ import annotations

from . import wall_rule
from .compilation import compiled
from .dop853 import STEP_STAGES
from .forces import ACCUMULATORS, LEFT_IMPULSE
from .interpolant import state_within, value
from .state_layout import (
    LAST_END,
    LAST_IMPULSE,
    LAST_TOUCHES,
    LOADED,
    STATIC,
    TOUCHES,
    WALL_PEAK,
)
from .stepping import forces_within, on_positions
from .wall_events import push_on_wall

BISECTIONS = 50

released_force, is_loaded = compiled(wall_rule.released_force), compiled(wall_rule.is_loaded)
end_after_pause = compiled(wall_rule.end_after_pause)


@compiled
def changes_load(stages, length, setup, walls):
    """Whether a wall is released or loaded within the step."""
    for side in range(2):
        push = stages[STEP_STAGES, length - ACCUMULATORS + LEFT_IMPULSE + side]
        if setup.stiffness[side * len(setup.inverse_mass)] > 0.0:
            level = released_force(walls[STATIC, side], walls[WALL_PEAK, side])
            if is_loaded(push, level) != (walls[LOADED, side] > 0.0):
                return True
    return False


@compiled
def place_of_change(
    side, level, loaded, time, h, y, dense, setup, contacts, segment, trial, scratch
):  # fmt: skip
    """Fraction of the step at which a wall becomes loaded, or is released."""
    low, high = 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if on_positions(contacts):
            push = push_on_wall(side, middle, time, h, y, dense, setup, contacts, segment)
        else:
            state_within(middle, y, dense, trial)
            forces_within(middle, time, h, trial, setup, contacts, segment, scratch)
            push = contacts.force[side * len(setup.inverse_mass)]
        if is_loaded(push, level) == loaded:
            high = middle
        else:
            low = middle
    return high


@compiled
def record_loads(time, h, y, y_new, stages, dense, setup, contacts, segment, walls, trial, scratch):
    """Record when each wall is released or loaded within the step, and the end of the impact."""
    for side in range(2):
        i = len(y) - ACCUMULATORS + LEFT_IMPULSE + side
        level = released_force(walls[STATIC, side], walls[WALL_PEAK, side])
        loaded = is_loaded(stages[STEP_STAGES, i], level)
        here = setup.stiffness[side * len(setup.inverse_mass)] > 0.0
        if not here or loaded == (walls[LOADED, side] > 0.0):
            continue
        theta = place_of_change(
            side, level, loaded, time, h, y, dense, setup, contacts, segment, trial, scratch
        )
        # Without a static force, the impulse no longer changes after the release.
        impulse = y_new[i] if level == 0.0 else value(i, theta, y, dense)
        note_load(side, loaded, time + theta * h, impulse, walls)


@compiled
def note_load(side, loaded, time, impulse, walls):
    """Record that a wall is released or loaded; the impact may have ended at the last release."""
    if loaded:
        walls[LOADED, side] = 1.0
        end_after_pause(side, time, walls)
        return
    walls[LOADED, side] = 0.0
    walls[LAST_END, side], walls[LAST_IMPULSE, side] = time, impulse
    walls[LAST_TOUCHES, side] = walls[TOUCHES, side]

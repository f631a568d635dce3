"""End of the impact on a wall, from the states between the steps of a record.

`hertzchain.kernels.impact_end` has the rule.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from ..collision import Array
from ..kernels.wall_rule import is_loaded, released_force
from ..simulation.time_scales import pause_of_impact
from ..simulation.wall_bound import RIGHT
from .equation import Equation
from .record import Block


@dataclass(eq=False)
class WallLoads:
    """Releases of one wall so far; the impact has ended at `since`, which is 0 before."""

    equation: Equation
    side: int
    pause: float = field(init=False)
    static: float = field(init=False)
    loaded: bool = False
    last: float = 0.0
    since: float = 0.0
    # Time, overlap and its rate at the start of the last step.
    before: Array = field(default_factory=lambda: np.zeros((1, 3)))

    def __post_init__(self) -> None:
        chain = self.equation.chain
        self.pause = pause_of_impact(chain)
        self.static = float(chain.static_state.forces[self._contact])
        # The force may never exceed the static one.
        self.since = math.ulp(0.0) if self.static > 0.0 else 0.0

    @property
    def _contact(self) -> int:
        return -1 if self.side == RIGHT else 0

    def follow(self, block: Block, forces: Array, tops: Array, peak_time: float) -> None:
        """Update the end of the impact by the starts of the steps of a block.

        ``forces`` are those on the wall at these times, ``tops`` the largest ones so far.
        """
        times = block.start + np.cumsum(block.lengths) - block.lengths
        overlaps = self.equation.overlaps_at(block.positions)[:, self._contact]
        rates = block.velocities[:, self._contact] * (1.0 if self.side == RIGHT else -1.0)
        states = np.concatenate((self.before, np.stack((times, overlaps, rates), axis=1)))
        levels = [released_force(self.static, float(top)) for top in tops]
        loaded = [is_loaded(*pair) for pair in zip(forces.tolist(), levels, strict=True)]
        for n in np.flatnonzero(np.array(loaded) != [self.loaded, *loaded[:-1]]):
            self._change(loaded[n], self._place(states[n : n + 2], levels[n]), peak_time)
        self.loaded, self.before = loaded[-1], states[-1:]
        self.pass_time(float(times[-1]), peak_time)

    def pass_time(self, time: float, peak_time: float) -> None:
        """Note the end of the impact if the wall has been released for long enough by now."""
        if self.since <= peak_time and (self.loaded or self.last > 0.0):
            self.since = 0.0
        released = not self.loaded and self.last > peak_time
        if self.since == 0.0 and released and time - self.last >= self.pause:
            self.since = self.last

    def _change(self, loaded: bool, time: float, peak_time: float) -> None:
        if loaded:
            self.pass_time(time, peak_time)
        else:
            self.last = time
        self.loaded = loaded

    def _place(self, states: Array, level: float) -> float:
        """Time at which the overlap reaches that of a force, between two states."""
        c, equation = self._contact, self.equation
        overlap = (level / equation.stiffness[c]) ** (1.0 / equation.exponents[c])
        times, overlaps, rates = states.T
        if not times[1] > times[0]:
            return float(times[1])
        roots = CubicHermiteSpline(times, overlaps, rates).solve(overlap, extrapolate=False)
        # A loss may end a contact before the overlap vanishes.
        return float(roots[0]) if len(roots) else float(times[1])

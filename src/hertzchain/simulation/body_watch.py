"""Criterion for a complete peak of the force on a cap behind a row, which also ends a run.

Without a given end, a run continues after the pulse has left the row until the bound of
`hertzchain.simulation.body_bound` proves that no later force on the cap exceeds the largest one, or
until `LONGEST` times the time that the pulse took to leave.  Without a bound, as under gravity or
precompression, the run ends when the pulse has left.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..kernels import state_layout
from .body_bound import body_bound
from .budget import overlaps_of, stored_energy

# Longest run, in times of the pulse.
LONGEST: Final = 50.0
# Steps between two checks.
STEPS_PER_CHECK: Final = 16


def has_rule(chain: Chain) -> bool:
    """Whether a run ends when the force on the cap is complete."""
    return chain._free_cap and body_bound(chain).known


class BodyWatch:
    """The force on the cap during a run; ``arrays`` are the arrays of its state."""

    def __init__(self, chain: Chain, arrays: dict[str, Array]) -> None:
        self.chain, self.arrays, self.bound = chain, arrays, body_bound(chain)
        # A contact with a dent of an earlier impact does not follow its loading curve.
        self.dented = bool(arrays["largest"].any()) and self.bound.reloads
        self.largest, self.left = 0.0, False

    @property
    def time(self) -> float:
        """Time of the run."""
        return float(self.arrays["clock"][state_layout.TIME])

    @property
    def peak(self) -> float:
        """A lower bound of the largest force so far."""
        overlap = float(self.arrays["crossings"][state_layout.LARGEST_OVERLAP, -1])
        return self.largest if self.dented else max(self.largest, self.bound.force(overlap))

    @property
    def expired(self) -> bool:
        """Whether the longest run has ended, or no bound is known."""
        peaks, crossings = self.arrays["peaks"], self.arrays["crossings"]
        transit = max(
            float(peaks[state_layout.PEAK_TIME].max()),
            float(crossings[state_layout.CROSSING_TIME].max()),
        )
        return not self.bound.known or self.time >= LONGEST * transit

    def later(self, forces: Array) -> float:
        """Bound of any later force, given the forces of all contacts now."""
        chain, beads = self.chain, self.chain.beads
        if chain.drive is not None and self.time < chain.drive.end:
            return np.inf
        y = self.arrays["y"]
        positions = y[:beads] + chain.static_state.positions
        overlaps = overlaps_of(chain, np.array([self.time]), positions[None])
        if not forces.size:
            forces = np.zeros(beads + 1)
        self.largest = max(self.largest, float(forces[beads - 1]))
        stored = stored_energy(chain, overlaps, forces[None], may_close=True)
        return self.bound.later(overlaps[0], stored[0], y[beads : 2 * beads])

    def complete(self, later: float) -> bool:
        """Whether no later force can exceed the largest one."""
        return self.bound.excludes_more(later, self.peak)

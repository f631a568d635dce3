"""Saved times and states of a run."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..chain.chain import Chain
from ..errors import InputError
from ..validation.numbers import whole_number
from .saved_times import check_memory_for, checked_times
from .time_scales import transit_times


class Frames:
    """Saved times and states.

    If the end is not known, the grid starts too fine.  Whenever it is full, every second time is
    removed and the spacing is doubled, to keep within the requested memory.
    """

    def __init__(
        self, chain: Chain, begin: float, until: float | None, times: int | ArrayLike
    ) -> None:
        self.spacing: float | None = None
        self.begin = begin
        if not isinstance(times, int | np.integer) or isinstance(times, bool):
            self.times = checked_times(chain, times, begin, until)
        elif (count := whole_number("times", times, least=0)) == 1:
            raise InputError("times must be 0 or at least 2 when it is a number, got 1")
        else:
            check_memory_for(chain, count)
            if until is None and count > 0:
                self.spacing = 0.5 * float(transit_times(chain).sum()) / count
                self.times = begin + self.spacing * np.arange(count)
            else:
                self.times = np.linspace(begin, until or 0.0, count)
        self.states, self.forces = np.empty((0, 0)), np.empty((0, 0))

    def allocate(self, length: int, contacts: int) -> None:
        """Allocate arrays for states with this number of components and contacts."""
        self.states = np.empty((len(self.times), length))
        self.forces = np.empty((len(self.times), contacts))

    def thin_out(self, filled: int) -> int:
        """Remove every second time; return the number of times that are kept."""
        assert self.spacing is not None
        kept = (filled + 1) // 2
        for saved in (self.states, self.forces):
            saved[:kept] = saved[:filled:2].copy()
        self.spacing *= 2.0
        self.times = self.begin + self.spacing * np.arange(len(self.times))
        return kept

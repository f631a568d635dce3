"""Recognise tapers of given radii, also those with a few changed beads, for descriptions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from ..collision import Array
from .taper_sizes import SHAPES, taper_between
from .tapers import ROUNDING

# At most one changed bead for so many beads; the median of the steps is then that of the taper.
PER_CHANGE: Final = 6


@dataclass(frozen=True)
class ChangedTaper:
    """Radii of a taper without the changes, and the number of beads with other radii."""

    radii: Array
    count: int

    @property
    def words(self) -> str:
        """Such as ``1 changed bead``."""
        return f"{self.count} changed bead{'s' * (self.count > 1)}"


def changed_taper(radii: Array) -> ChangedTaper | None:
    """The taper behind a row of which a few beads have other radii, if there is one."""
    beads = np.arange(len(radii))
    for shape in SHAPES if len(radii) >= PER_CHANGE else ():
        sizes = np.log(radii) if shape == "exponential" else radii
        starts = sizes - beads * np.median(np.diff(sizes))
        same = np.flatnonzero(np.abs(starts - np.median(starts)) < 1e-9 * np.ptp(sizes))
        if len(same) < 2:
            continue
        i, j = same[[0, -1]]
        line = sizes[i] + (beads - i) * ((sizes[j] - sizes[i]) / (j - i))
        found = np.exp(line) if shape == "exponential" else line
        count = int(np.count_nonzero(~np.isclose(radii, found, rtol=ROUNDING, atol=0.0)))
        if 0 < count <= len(radii) // PER_CHANGE and taper_behind(found)[0] is not None:
            return ChangedTaper(found, count)
    return None


def taper_behind(radii: Array) -> tuple[str | None, tuple[tuple[str, float], ...]]:
    """Name and parameters of the taper of beads whose chain names none."""
    ends = float(radii[0]), float(radii[-1])
    # Any two radii are a taper, and the last radius of a steeper one is not a size.
    if len(radii) > 2 and ends[0] != ends[1] and ends[1] / ends[0] > 2.0 ** -(len(radii) - 1):
        for shape in SHAPES:
            name, rate, found = taper_between(shape, len(radii), *ends)
            if np.allclose(radii, ends[0] * found, rtol=ROUNDING, atol=0.0):
                return name, (("rate", float(f"{rate:.12g}")),)
    return None, ()

"""How many times a run must save so that its waves are resolved."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from .time_scales import transit_times
from .trajectory import Trajectory

# Saved times within impulse/amplitude, the duration of a wave.
MIN_SAMPLES: Final = 8.0
# Contacts that the shortest listed wave passes.
SHORTEST: Final = 3
# Factors that make the number enough where the estimated durations are too long: by at most 10%
# at contacts of random chains and, under precompression, by 30% along a wave.
SPARE, SPARE_PRESSED = 1.1, 1.4
# Change of the ratio of durations at neighbouring contacts, and mass of the struck bead over that
# of the next one, up to which there is a single pulse; contacts at both ends that are not compared.
SMOOTH, HEAVY, ENDS = 1.1, 2.0, 3


def enough_times(
    run: Trajectory, contacts: Sequence[int] | None = None, samples: float = MIN_SAMPLES
) -> int:
    """Number of times that resolves all waves of a run, or those at some contacts.

    Waves that few saved times do not show are included, because the number follows from the largest
    overlaps, which do not depend on these times; 0 if no contact was compressed.
    """
    durations = _shortest_durations(run)
    each = _along_waves(run.chain, durations) if contacts is None else durations[list(contacts)]
    shortest = float(np.min(each, initial=np.inf))
    if not 0.0 < shortest < np.inf:
        return 0
    spare = SPARE_PRESSED if run.chain.precompression else SPARE
    return _rounded(spare * samples * _span(run) / shortest)


def advised_times(
    run: Trajectory, contacts: Sequence[int] | None = None, samples: float = MIN_SAMPLES
) -> str:
    """Advice to save as many times as `enough_times`."""
    times = enough_times(run, contacts, samples)
    return f"times={times} is enough" if times else "give simulate more times"


def are_few(
    run: Trajectory, contacts: Sequence[int] | None = None, samples: float = MIN_SAMPLES
) -> bool:
    """Whether fewer times than `enough_times` were requested."""
    requested = len(run.times) * _span(run) / _length(run)
    return requested < enough_times(run, contacts, samples)


def _along_waves(chain: Chain, durations: Array) -> Array:
    """Medians of durations that `Wave.samples` may contain, from those of all contacts."""
    passed = durations[np.isfinite(durations)]
    third = len(passed) // 3
    if third >= SHORTEST and _has_one_pulse(chain, passed):
        return np.array([np.median(passed[:third]), np.median(passed[-third:])])
    # Other waves begin and end anywhere.
    length = min(SHORTEST, len(durations))
    return np.asarray(
        np.median(np.lib.stride_tricks.sliding_window_view(durations, length), axis=1)
    )


def _has_one_pulse(chain: Chain, durations: Array) -> bool:
    """Whether nothing reflects or splits the pulse, so that it is the only wave."""
    free = not (chain.left_wall or chain.right_wall or chain.drive is not None)
    at_rest = not (chain.velocities[1:].any() or chain.static_state.forces.any())
    light = chain.masses[0] < HEAVY * chain.masses[1]
    # In an exponential taper, all ratios are the same.  Ends and the struck bead differ.
    ratios = np.diff(np.log(durations[ENDS:-ENDS]))
    smooth = float(np.abs(np.diff(ratios)).max(initial=0.0)) < math.log(SMOOTH)
    return free and at_rest and light and smooth


def _shortest_durations(run: Trajectory) -> Array:
    r"""Shortest duration, impulse over largest force, of waves at each contact, shape (N + 1,).

    That of a half sine with the frequency of one bead between its neighbours at rest, with the
    stiffness of both contacts at their largest overlaps, is :math:`2\sqrt{m/(K_{k-1} + K_k)}`.
    """
    chain, overlaps = run.chain, np.nan_to_num(run.largest_overlaps)
    p, stiffness = chain.contact_exponents, chain.contact_stiffness
    closed = (overlaps > 0.0) & (stiffness > 0.0)
    slopes = np.where(closed, p * stiffness * np.where(closed, overlaps, 1.0) ** (p - 1.0), 0.0)
    around = slopes[:-1] + slopes[1:]
    moved = around > 0.0
    beads = np.where(moved, 2.0 * np.sqrt(chain.masses / np.where(moved, around, 1.0)), np.inf)
    ends = np.array([np.inf])
    return np.minimum(np.concatenate((ends, beads)), np.concatenate((beads, ends)))


def _span(run: Trajectory) -> float:
    """Time over which the requested number of times is spread.

    Without a given end, `hertzchain.simulation.frames` doubles half a transit until the run ends.
    """
    if run.status == "time reached":
        return _length(run)
    half = 0.5 * float(transit_times(run.chain).sum())
    return half * 2.0 ** math.ceil(math.log2(max(_length(run), half) / half))


def _length(run: Trajectory) -> float:
    """Time from the first saved one to the end of a run."""
    return float(run.end_time - run.times[0]) if len(run.times) else run.end_time


def _rounded(needed: float) -> int:
    """The number, rounded upwards to two digits."""
    step = 10.0 ** (math.floor(math.log10(needed)) - 1)
    return int(math.ceil(needed / step) * step)

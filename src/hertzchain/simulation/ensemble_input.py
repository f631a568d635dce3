"""Conversion of the chains of an ensemble to arrays of the elastic kernel."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..collision import HERTZ_EXPONENT, Array, compression_time
from ..frozen import once
from ..kernels.limits import MIN_ROUGH_PUSH, ROUNDING
from ..kernels.wall_rule import MAX_REBOUNDS
from .body_watch import LONGEST, has_rule
from .kernel_input import static_closing
from .time_scales import rebound_in_series, transit_times
from .wall_bound import RIGHT, motion_can_escape, wall_targets

# First step as a fraction of the time in which the pulse passes the first contact.
FIRST_PART: Final = 1e-3
# The kernel ignores overlaps below an absolute limit; overlaps of the pulse must be far above it.
MIN_OVERLAP, MAX_OVERLAP = 1e-15, 1e15
MAX_EXPONENT: Final = 16.0
# For longer chains without a right wall `simulate` is faster, because it omits beads at rest and in
# free flight; with a wall, most beads move until the end.
MAX_BEADS_WITHOUT_WALL: Final = 150


def is_covered(chain: Chain, until: float | None) -> bool:
    """Whether the elastic kernel integrates a chain."""
    return _suits(chain) and (until is not None or not chain.gravity)


@once
def _suits(chain: Chain) -> bool:
    """Whether the elastic kernel integrates a chain without gravity."""
    from ..kernels.elastic_layout import MAX_BEADS

    if chain.drive is not None or not chain.velocities[0] > 0.0 or not chain.lossless:
        return False
    if chain.beads > (MAX_BEADS_WITHOUT_WALL if chain.right_wall is None else MAX_BEADS):
        return False
    p = float(chain.contact_exponents.max())
    return p <= MAX_EXPONENT and MIN_OVERLAP < _first_overlap(chain, p) < MAX_OVERLAP


def _first_overlap(chain: Chain, p: float) -> float:
    """`hertzchain.collision.collision_overlap` of the first two beads, or NaN."""
    # Plain numbers: this is called for each of many chains.
    first, second = chain.masses.item(0), chain.masses.item(1)
    energy = 0.5 * first * (second / (first + second)) * chain.velocities.item(0) ** 2
    try:
        return float(((p + 1.0) * energy / chain.stiffness.item(0)) ** (1.0 / (p + 1.0)))
    except ArithmeticError:
        return math.nan


@once
def kind_of(chain: Chain) -> tuple[int, bool, bool, bool]:
    """Length and features, which must be the same for all chains of one call of the kernel."""
    p = chain.contact_exponents
    hertz = bool(p.min() == HERTZ_EXPONENT == p.max())
    careful = chain.gravity != 0.0 or chain.precompression > 0.0 or bool(chain.gaps.any())
    return chain.beads, hertz, chain.right_wall is not None, careful


@dataclass(frozen=True, eq=False)
class KernelInput:
    """Chains of one kind: ``chains`` and ``numbers`` as in `hertzchain.kernels.elastic_layout`."""

    chains: Array
    numbers: Array
    hertz: bool
    walled: bool
    careful: bool


def kernel_input(
    chains: Sequence[Chain], until: float | None, *, peak_only: bool = False
) -> KernelInput:
    """Pack chains of one kind for the kernel; ``peak_only`` as in its layout."""
    from ..kernels import elastic_layout as layout

    beads, hertz, walled, careful = kind_of(chains[0])
    given = np.zeros((len(chains), layout.GIVEN_ROWS, beads + 1))
    numbers = np.zeros((len(chains), layout.NUMBERS))
    # One assignment for all chains takes less time than one for each.
    given[:, layout.START_V, :beads] = [chain.velocities for chain in chains]
    given[:, layout.GIVEN_INVERSE_MASS, :beads] = [chain.masses for chain in chains]
    np.reciprocal(given[:, layout.GIVEN_INVERSE_MASS, :beads],
                  out=given[:, layout.GIVEN_INVERSE_MASS, :beads])  # fmt: skip
    given[:, layout.GIVEN_STIFFNESS] = [chain.contact_stiffness for chain in chains]
    given[:, layout.GIVEN_EXPONENT] = [chain.contact_exponents for chain in chains]
    numbers[:, layout.STRIKERS] = [chain.strikers for chain in chains]
    for i, chain in enumerate(chains):
        rows = given[i]
        if chain.gravity != 0.0 or chain.precompression > 0.0:
            numbers[i, layout.FIRST_STEP] = _add_static_state(chain, rows)
        else:
            if careful:
                rows[layout.GIVEN_AT_REST, 1:beads] = -chain.gaps
            for wall, c in ((chain.left_wall, 0), (chain.right_wall, beads)):
                rows[layout.GIVEN_AT_REST, c] = -wall.gap if wall is not None else 0.0
    speeds, masses = given[:, layout.START_V, :beads], given[:, layout.GIVEN_INVERSE_MASS, :beads]
    times = compression_time(
        1.0 / (masses[:, 0] + masses[:, 1]), given[:, layout.GIVEN_STIFFNESS, 1], speeds[:, 0],
        HERTZ_EXPONENT if hertz else given[:, layout.GIVEN_EXPONENT, 1],
    )  # fmt: skip
    first = numbers[:, layout.FIRST_STEP]
    first[:] = FIRST_PART * np.where(first > 0.0, np.minimum(first, times), times)
    numbers[:, layout.LEAST_PUSH] = MIN_ROUGH_PUSH * (np.abs(speeds) / masses).sum(axis=1)
    numbers[:, layout.UNTIL] = math.inf if until is None else until
    numbers[:, layout.BY_ITSELF] = until is None
    if until is None:
        numbers[:, layout.LONGEST] = [LONGEST * has_rule(chain) for chain in chains]
    if walled:
        numbers[:, layout.REBOUNDS] = MAX_REBOUNDS * _rebounds(given, speeds, masses)
        at_rest = ~given[:, layout.GIVEN_BODY].any(axis=1)
        numbers[:, layout.PEAK_ONLY] = at_rest & (peak_only and until is None)
        numbers[:, layout.CAN_ESCAPE] = [motion_can_escape(chain, RIGHT) for chain in chains]
    return KernelInput(given, numbers, hertz, walled, careful)


def _rebounds(given: Array, speeds: Array, inverse_masses: Array) -> Array:
    """`hertzchain.simulation.time_scales.rebound_time` of struck chains."""
    from ..kernels import elastic_layout as layout

    mass = (1.0 / inverse_masses).sum(axis=1)
    momentum = (np.maximum(speeds, 0.0) / inverse_masses).sum(axis=1)
    stiffness, p = given[:, layout.GIVEN_STIFFNESS, 1:], given[:, layout.GIVEN_EXPONENT, 1:]
    return rebound_in_series(mass, momentum / mass, stiffness, p)


def _add_static_state(chain: Chain, rows: Array) -> float:
    """Store the static forces on a chain; return the shortest time in which it responds."""
    from ..kernels import elastic_layout as layout

    static, beads = chain.static_state, chain.beads
    rows[layout.GIVEN_AT_REST] = static_closing(chain) - static.gaps
    rows[layout.GIVEN_BODY, :beads] = static.body_forces / chain.masses
    pushing = static.forces[:-1] + static.forces[1:]
    rows[layout.GIVEN_NOISE, :beads] = ROUNDING * pushing / chain.masses
    if chain.right_wall is not None:
        target = wall_targets(chain)[-1]
        rows[layout.STATIC_FORCE], rows[layout.STATIC_OVERLAP] = target.forces, target.overlaps
    return float(transit_times(chain).min())

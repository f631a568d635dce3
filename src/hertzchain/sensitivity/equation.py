"""The equation of motion of an elastic chain as rows of the adjoint kernels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..chain.equilibrium import equilibrium
from ..chain.feature_support import require_chain
from ..collision import HERTZ_EXPONENT, Array
from ..errors import InputError
from ..simulation.kernel_input import static_closing
from ..simulation.time_scales import transit_times

METHOD: Final = "gradient"
# First step as a fraction of the shortest time in which a pulse passes a contact.
FIRST_PART: Final = 1e-3
# Rounding of static forces, as in `hertzchain.kernels.dop853_step`.
ROUNDING: Final = 5e-15


@dataclass(frozen=True, eq=False)
class Equation:
    """Numbers of the equation of motion; contacts 0..N include the walls."""

    chain: Chain
    masses: Array
    stiffness: Array
    exponents: Array
    # Overlaps at time 0, negative across a gap.
    overlaps: Array
    velocities: Array
    # Constant acceleration of each bead, and rounding errors of accelerations.
    body: Array
    noise: Array
    first_step: float
    hertz: bool
    careful: bool
    resting: bool

    @property
    def beads(self) -> int:
        """Number of beads."""
        return len(self.masses)

    def forces(self, overlaps: Array) -> Array:
        """Forces of all contacts, at overlaps in the last axis."""
        return np.asarray(self.stiffness * np.maximum(overlaps, 0.0) ** self.exponents)

    def overlaps_at(self, positions: Array) -> Array:
        """Overlaps of all contacts, at positions in the last axis."""
        pad = [(0, 0)] * (positions.ndim - 1) + [(1, 1)]
        return np.asarray(self.overlaps - np.diff(np.pad(positions, pad)))


def equation_of(chain: Chain) -> Equation:
    """Numbers of the equation of motion of a chain; raises an error if there is no gradient."""
    _check(chain)
    static = equilibrium(chain)
    loaded = chain.gravity != 0.0 or chain.precompression > 0.0
    pushing = static.forces[:-1] + static.forces[1:]
    return Equation(
        chain,
        chain.masses,
        chain.contact_stiffness,
        chain.contact_exponents,
        static_closing(chain) - static.gaps,
        chain.velocities,
        static.body_forces / chain.masses,
        ROUNDING * pushing / chain.masses,
        FIRST_PART * float(transit_times(chain).min()),
        bool((chain.contact_exponents == HERTZ_EXPONENT).all()),
        loaded or bool(chain.gaps.any()) or any(
            wall is not None and wall.gap > 0.0 for wall in (chain.left_wall, chain.right_wall)
        ),
        not loaded,
    )  # fmt: skip


def _check(chain: Chain) -> None:
    from ..kernels.adjoint_layout import MOST_BEADS

    require_chain(METHOD, chain)
    if chain.drive is not None:
        raise InputError(
            "gradient does not support a drive; use chain.replace(drive=None, velocities=...), or "
            "differences of simulate"
        )
    if not chain.lossless:
        law = next(each for each in chain.contact_losses if type(each).__name__ != "Elastic")
        raise InputError(
            f"gradient does not support the loss {law}; use chain.replace(loss=None), or "
            "differences of simulate_many"
        )
    if chain.beads > MOST_BEADS:
        raise InputError(
            f"gradient supports chains of at most {MOST_BEADS} beads, got {chain.beads}; shorten "
            "the chain"
        )

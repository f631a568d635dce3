"""The equation of motion of a chain, elastic or damped, as rows of the adjoint kernels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..chain.feature_support import require_chain
from ..chain.laws import Loss
from ..chain.laws.dashpot import Dashpot
from ..chain.laws.elastic import Elastic
from ..chain.laws.restitution import Restitution
from ..chain.laws.velocity_power import VelocityPower
from ..chain.laws.viscoelastic import Viscoelastic
from ..collision import HERTZ_EXPONENT, Array
from ..errors import InputError
from ..kernels.limits import ROUNDING
from ..simulation.ensemble_input import FIRST_PART
from ..simulation.kernel_input import static_closing
from ..simulation.time_scales import transit_times

METHOD: Final = "gradient"


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
    # Approximate time of a pulse to the end of the chain and back.
    passage: float
    # Whether all exponents are 3/2; None if contacts are damped.
    hertz: bool | None
    careful: bool
    resting: bool
    # Damping g d^q d' of each contact, and whether it may pull.
    damping: Array
    overlap_powers: Array
    pulls: Array

    @property
    def stages(self) -> int:
        """Number of stages of a step."""
        return 8 if self.hertz is not None else 12

    @property
    def weights(self) -> Array:
        """Weights of the stages in an impulse."""
        from ..kernels import dop853, rkn8

        return np.array(rkn8.B_VELOCITY if self.hertz is not None else dop853.B)

    @property
    def rate(self) -> float:
        """Rate of the fastest contact, by which errors of positions become those of velocities."""
        return FIRST_PART / self.first_step

    @property
    def beads(self) -> int:
        """Number of beads."""
        return len(self.masses)

    @property
    def has_free_pulse(self) -> bool:
        """Whether only beads near the crest of the leading pulse may matter for its quantities."""
        chain = self.chain
        ends = chain.left_wall is None and chain.right_wall is None
        struck = not chain.velocities[max(1, chain.strikers) :].any()
        elastic = self.hertz is not None
        return ends and struck and elastic and self.resting and not chain.gaps.any()

    def forces(self, overlaps: Array) -> Array:
        """Forces of all contacts, at overlaps in the last axis."""
        return np.asarray(self.stiffness * np.maximum(overlaps, 0.0) ** self.exponents)

    def kept_forces(self, kept: Array, c: int) -> Array:
        """Forces of a contact at the stages of steps, from the numbers kept, (steps, stages)."""
        if self.hertz is None:
            d, closing = kept[:, : self.stages, c], kept[:, self.stages : 2 * self.stages, c]
            damped = self.damping[c] * d ** self.overlap_powers[c] * closing
            force = self.stiffness[c] * d ** self.exponents[c] + damped
            return np.where((d > 0.0) & ((force > 0.0) | (self.pulls[c] > 0.0)), force, 0.0)
        p = self.exponents[c] * (2.0 if self.hertz else 1.0)
        return np.asarray(self.stiffness[c] * kept[:, :, c] ** p)

    def kept_impulses(self, kept: Array, lengths: Array, c: int, after: float) -> Array:
        """Impulse of a contact in each step, (steps,); ``after`` is the overlap at the end."""
        from ..kernels.adjoint_layout import KEPT_RELEASED

        forces = self.kept_forces(kept, c)
        if self.hertz is not None:
            return np.asarray(lengths * (forces @ self.weights))
        # The impulse of the damping of joined contacts is known at both ends of a step.
        d, closing = kept[:, : self.stages, c], kept[:, self.stages : 2 * self.stages, c]
        q, joined = self.overlap_powers[c], 1.0 - kept[:, KEPT_RELEASED, c]
        damped = self.damping[c] * np.where(d > 0.0, d**q, 0.0) * closing
        ends = self.damping[c] * np.append(d[:, 0], after) ** (q + 1.0) / (q + 1.0)
        rest = lengths * ((forces - joined[:, np.newaxis] * damped) @ self.weights)
        return np.asarray(rest + joined * np.diff(ends))

    def overlaps_at(self, positions: Array) -> Array:
        """Overlaps of all contacts, at positions in the last axis."""
        pad = [(0, 0)] * (positions.ndim - 1) + [(1, 1)]
        return np.asarray(self.overlaps - np.diff(np.pad(positions, pad)))


def equation_of(chain: Chain) -> Equation:
    """Numbers of the equation of motion of a chain; raises an error if there is no gradient."""
    _check(chain)
    static = chain.static_state
    loaded = chain.gravity != 0.0 or chain.precompression > 0.0
    damping, powers, pulls = _damping(chain)
    hertz = None if damping.any() else bool((chain.contact_exponents == HERTZ_EXPONENT).all())
    times = transit_times(chain)
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
        FIRST_PART * float(times.min()),
        2.0 * float(times.sum()),
        hertz,
        loaded or bool(chain.gaps.any()) or any(
            wall is not None and wall.gap > 0.0 for wall in (chain.left_wall, chain.right_wall)
        ),
        not loaded,
        damping,
        powers,
        pulls,
    )  # fmt: skip


def has_gradient(chain: Chain) -> bool:
    """Whether quantities of a chain have exact derivatives."""
    try:
        _check(chain)
    except InputError:
        return False
    return True


def _check(chain: Chain) -> None:
    from ..kernels.adjoint_layout import MAX_BEADS

    require_chain(METHOD, chain)
    if chain.drive is not None:
        raise InputError(
            "gradient does not support a drive; use chain.replace(drive=None, velocities=...), or "
            "differences of simulate"
        )
    for law in chain.contact_losses:
        if not is_linear(law):
            raise InputError(
                f"the loss {law} has no exact derivatives, because its force is not linear in the "
                "closing speed, jumps or depends on the past; use Viscoelastic, Restitution or "
                "Dashpot"
            )
    if chain.beads > MAX_BEADS:
        raise InputError(
            f"gradient supports chains of at most {MAX_BEADS} beads, got {chain.beads}; shorten "
            "the chain"
        )


def is_linear(law: Loss) -> bool:
    """Whether the force of a law is linear in the closing speed and does not jump or remember."""
    if isinstance(law, VelocityPower):
        return law.alpha == 1.0
    return isinstance(law, Elastic | Viscoelastic | Restitution | Dashpot)


def _damping(chain: Chain) -> tuple[Array, Array, Array]:
    """Strength and overlap power of the damping of each contact, and whether it may pull."""
    strength, powers = np.zeros(chain.beads + 1), np.ones(chain.beads + 1)
    pulls = np.ones(chain.beads + 1)
    for group in chain.contact_groups:
        row = group.law.row(group.contacts.exponent)
        there = group.contacts.stiffness > 0.0
        strength[group.index] = np.where(there, group.law.strength(group.contacts), 0.0)
        powers[group.index], pulls[group.index] = row.overlap_power, float(row.attractive)
    powers[strength == 0.0] = 1.0
    return strength, powers, pulls

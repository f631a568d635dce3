"""Conversion of a chain to the arrays of the compiled equations."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError
from ..frozen import once
from .drive_pieces import drive_pieces
from .kernel_laws import kernel_laws

if TYPE_CHECKING:
    from ..kernels.forces import DefaultChain, GeneralChain

# Features that the loop for default chains supports; all other chains use the general loop.
DEFAULT_FEATURES: Final = frozenset(
    {"SI units", "masses", "stiffness", "strikers", "velocities", "cap"}
)


@once
def kernel_chain(chain: Chain) -> DefaultChain | GeneralChain:
    """Parameters of the equation of motion of a chain, for the compiled loop."""
    from ..kernels.driving import MOVING_WALL, NOTHING, PUSH
    from ..kernels.forces import DefaultChain, GeneralChain

    if DEFAULT_FEATURES.issuperset(chain.features):
        return DefaultChain(1.0 / chain.masses, np.array(chain.stiffness), chain.exponents)
    static = chain.static_state
    drive = NOTHING
    if chain.drive is not None:
        drive = PUSH if chain.drive.of == "force" else MOVING_WALL
    try:
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            starts, pieces = drive_pieces(chain.drive)
    except ArithmeticError:
        starts, pieces = np.zeros(1), np.full((1, 1), np.inf)
    if not np.isfinite(pieces).all():
        raise InputError(f"{chain.drive} cannot be represented: check the units of its times")
    with np.errstate(over="ignore"):
        law, laws, damping = kernel_laws(chain)
    if not np.isfinite(damping).all():
        raise InputError(
            f"the damping by {chain.loss} is too large to be represented: check its units"
        )
    return GeneralChain(
        inverse_mass=1.0 / chain.masses,
        # Numba compiles another version for arrays that are read-only.
        stiffness=np.array(chain.contact_stiffness),
        exponent=law.exponent,
        # Positions are measured from equilibrium, where contacts overlap.  Rounding errors are
        # then relative to an overlap, not to the length of the chain.
        gap=static.gaps - static_closing(chain),
        damping=damping,
        law=law,
        laws=laws,
        body_force=np.array(static.body_forces),
        drive=drive,
        piece_starts=np.array(starts),
        pieces=np.array(pieces),
    )


def steps_are_implicit(chain: Chain) -> bool:
    """Whether the damping of a chain is too stiff for explicit steps."""
    from ..kernels.forces import DefaultChain

    equation = kernel_chain(chain)
    return not isinstance(equation, DefaultChain) and equation.law.implicit


def static_closing(chain: Chain) -> Array:
    """Overlaps of all contacts, walls included, due to the static positions."""
    return -np.diff(np.pad(chain.static_state.positions, 1))


def initial_state(chain: Chain) -> Array:
    """Positions, measured from equilibrium, and velocities at time 0."""
    return np.concatenate([np.zeros(chain.beads), chain.velocities])

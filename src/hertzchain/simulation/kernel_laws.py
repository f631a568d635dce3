"""Conversion of the contact laws of a chain to kernel arrays, and choice of implicit steps.

The laws themselves are in `hertzchain.chain.laws`, their compiled forces in
`hertzchain.kernels.contact_law`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from ..chain.chain import Chain
from ..chain.contact_groups import ContactGroup
from ..collision import Array, collision_overlap, compression_time
from ..errors import InputError
from ..kernels.law_kinds import DAMPED, ELASTIC, PLASTIC, UNLOADING, VECTORISED, LawRow
from .time_scales import typical_speed

if TYPE_CHECKING:
    from ..kernels.contact_law import Law

# Steps are implicit if the duration of a contact exceeds this many relaxation times of its damping:
# explicit steps would then be so short that a run would take longer.
STIFF: Final = 300.0
# Above this ratio, contacts are rigid for any step, and the equations of implicit steps overflow.
RIGID: Final = 1e250
# Speeds below this fraction of the typical speed are negligible while a chain at rest is set in
# motion.
SLOWEST: Final = 1e-3


def kernel_laws(chain: Chain) -> tuple[Law, Array, Array]:
    """Law that all contacts share, table of the law of each, (N + 1, COLUMNS), and their damping.

    If they differ, the first result has the kind of the law with the most checks.
    """
    from ..kernels.contact_law import Law

    groups = chain.contact_groups
    rows = [group.law.row(group.contacts.exponent) for group in groups]
    damping = np.zeros(chain.beads + 1)
    for group in groups:
        strength = group.law.strength(group.contacts)
        damping[group.index] = np.where(group.contacts.stiffness > 0.0, strength, 0.0)
    implicit = _steps_are_implicit(chain, groups, rows, damping)
    slowest = SLOWEST * typical_speed(chain) if implicit else 0.0
    exponent = groups[0].contacts.exponent
    if len(groups) == 1 and rows[0].kind in VECTORISED:
        own = rows[0]._asdict()
        law = Law(**own, exponent=exponent, implicit=implicit, slowest=slowest, shared=True)
        return law, _table(groups, rows), damping
    if implicit:
        # Implicit steps support only damped contacts.
        rows = [row._replace(kind=DAMPED) for row in rows]
    law = Law(_checked_for(rows), exponent, 0.0, 1.0, 1.0, True, implicit, slowest, shared=False)
    return law, _table(groups, rows), damping


def _table(groups: Sequence[ContactGroup], rows: Sequence[LawRow]) -> Array:
    from ..kernels import contact_law

    table = np.zeros((sum(len(group.index) for group in groups), contact_law.COLUMNS))
    for group, row in zip(groups, rows, strict=True):
        table[group.index, contact_law.EXPONENT] = group.contacts.exponent
        for name, value in row._asdict().items():
            table[group.index, getattr(contact_law, name.upper())] = value
    return table


def _checked_for(rows: Sequence[LawRow]) -> int:
    """Kind of the law that requires the most checks."""
    from ..kernels.compilation import uncompiled
    from ..kernels.contact_law import has_modes

    if UNLOADING in {row.kind for row in rows}:
        return UNLOADING
    return PLASTIC if any(map(uncompiled(has_modes), rows)) else ELASTIC


def _steps_are_implicit(
    chain: Chain, groups: Sequence[ContactGroup], rows: Sequence[LawRow], damping: Array
) -> bool:
    """Whether the damping is too stiff for explicit steps."""
    damped = [(group, row) for group, row in zip(groups, rows, strict=True) if row.kind == DAMPED]
    sudden = [group.law for group, row in damped if row.speed_power < 1.0]
    remember = [
        group.law for group, row in zip(groups, rows, strict=True)
        if row.kind not in (ELASTIC, DAMPED)
    ]  # fmt: skip
    if sudden and remember:
        raise InputError(
            f"contacts under {sudden[0]} (alpha < 1) need implicit steps, which cannot follow "
            f"contacts under {remember[0]}: use alpha >= 1, or another law for these"
        )
    if sudden or remember:
        return bool(sudden)
    return any(STIFF < _relaxation(chain, group, row, damping) < RIGID for group, row in damped)


def _relaxation(chain: Chain, group: ContactGroup, row: LawRow, damping: Array) -> float:
    """Largest ratio of the duration of a contact to the relaxation time of its damping."""
    there = group.contacts.stiffness > 0.0
    speed = typical_speed(chain)
    if speed == 0.0 or not there.any():
        return 0.0
    contacts, own = group.contacts.only(there), damping[group.index][there]
    mass, k, p = contacts.reduced_mass, contacts.stiffness, contacts.exponent
    static = (chain.static_state.forces[group.index][there] / k) ** (1.0 / p)
    overlap = np.maximum(collision_overlap(mass, k, speed, p), static)
    a = row.speed_power
    steepness = a * own * overlap**row.overlap_power * speed ** (a - 1.0)
    return float(np.max(steepness * compression_time(mass, k, speed, p) / mass))

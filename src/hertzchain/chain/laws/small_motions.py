"""Damping constants of compressed contacts for small motions, from the form of their law."""

from __future__ import annotations

import numpy as np

from ...collision import Array
from ...errors import InputError, ModelRangeWarning, warn_user
from ...kernels.law_kinds import DAMPED, ELASTIC, YIELDING, LawRow


def damping_constants(law: str, row: LawRow, strength: Array, overlap: Array) -> Array:
    """Derivative of the damping force by the closing speed, at rest and at the static overlaps."""
    none = np.zeros(len(overlap))
    # A law without loss, and a contact that has not yielded, are elastic.
    if row.kind in (ELASTIC, YIELDING) or (row.kind != DAMPED and row.kept == 1.0):
        return none
    if row.kind != DAMPED:
        raise InputError(
            f"contacts under {law} close along one curve and open along another, so that no motion "
            "is small enough to be linear: use simulate, or loss=None"
        )
    if row.speed_power == 1.0 or not strength.any():
        return np.asarray(strength * overlap**row.overlap_power)
    if row.speed_power < 1.0:
        raise InputError(
            f"the force of {law} rises infinitely fast from rest, with the power "
            f"{row.speed_power:g} of the speed, so that no motion is small enough to be linear: "
            "use simulate, or loss=None"
        )
    warn_user(
        f"the damping force of {law} grows with the power {row.speed_power:g} of the speed: small "
        "motions are not damped, and decay rates are 0; real ringing decays ever more slowly",
        ModelRangeWarning,
    )
    return none

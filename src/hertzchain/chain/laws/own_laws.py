"""Checks of the methods of a law, which also apply to laws that are defined in a script."""

from __future__ import annotations

import math

import numpy as np

from ...collision import Array
from ...errors import InputError, short_repr
from ...kernels.law_kinds import DAMPED, LawRow
from .base import ContactArrays, Loss


def checked_strength(law: Loss, contacts: ContactArrays) -> Array:
    """Strength of each contact by a law; `InputError` if a method of the law is wrong."""
    row = law.row(contacts.exponent)
    if not isinstance(row, LawRow):
        raise InputError(f"row of the law {law.name!r} must return a LawRow, got {short_repr(row)}")
    if row.kind == DAMPED:
        _check_powers(law, row)
        if type(law).strength is Loss.strength:
            raise InputError(
                f"the law {law.name!r} is DAMPED but has no method strength, so that nothing would "
                "be lost; define strength(self, contacts), which returns the damping coefficient "
                "of each contact"
            )
    count = len(contacts.stiffness)
    with np.errstate(over="ignore", under="ignore"):
        strength = np.asarray(law.strength(contacts), dtype=float)
    if strength.shape != (count,):
        raise InputError(
            f"strength of the law {law.name!r} must return one number per contact, an array of "
            f"shape ({count},), got shape {strength.shape}; use len(contacts.stiffness)"
        )
    return strength


def _check_powers(law: Loss, row: LawRow) -> None:
    """Powers with which a viscous force does not become infinite at touch or at rest."""
    for name, least in (("overlap_power", ">= 0"), ("speed_power", "> 0")):
        power = getattr(row, name)
        if not (math.isfinite(power) and (power > 0.0 or (power == 0.0 and least == ">= 0"))):
            raise InputError(
                f"{name} of the law {law.name!r} must be {least}, got {power:g}: its force would "
                "be infinite or jump where contacts touch or rest"
            )

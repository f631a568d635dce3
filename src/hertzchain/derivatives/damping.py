"""Derivatives of the damping with respect to parameters of losses, masses and stiffness.

The strength of a law is an algebraic function of one number per contact; a central difference of it
is accurate to about ten digits.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any, Final

import numpy as np

from ..chain.contact_groups import ContactGroup
from ..collision import Array
from .backward_pass import Slopes
from .equation import Equation

SIZE: Final = 1e-5


def _difference(change: Callable[[float], Array], value: Any) -> Array:
    """Derivative of a function at a value, from factors slightly above and below 1."""
    with np.errstate(divide="ignore", invalid="ignore"):
        found = (change(1.0 + SIZE) - change(1.0 - SIZE)) / (2.0 * SIZE * value)
    return np.nan_to_num(found, nan=0.0, posinf=0.0, neginf=0.0)


def _changed(group: ContactGroup, name: str) -> Array:
    """Derivative of the strength by an array of the contacts."""
    values = getattr(group.contacts, name)

    def strength(factor: float) -> Array:
        changed: dict[str, Any] = {name: values * factor}
        return group.law.strength(dataclasses.replace(group.contacts, **changed))

    return _difference(strength, values)


def add_damping(equation: Equation, slopes: Slopes) -> Slopes:
    """Slopes in which the damping follows masses and stiffness."""
    by_stiffness, by_mass = slopes.stiffness.copy(), slopes.masses.copy()
    masses = np.pad(equation.masses, 1, constant_values=np.inf)
    for group in equation.chain.contact_groups:
        at = group.index[group.contacts.stiffness > 0.0]
        there = group.contacts.stiffness > 0.0
        by_stiffness[at] += slopes.damping[at] * _changed(group, "stiffness")[there]
        by_reduced = slopes.damping[at] * _changed(group, "reduced_mass")[there]
        # 1/mu = 1/m + 1/m'.
        reduced = group.contacts.reduced_mass[there]
        for shift in (0, 1):
            own = masses[at + shift]
            inner = np.isfinite(own)
            share = by_reduced * (reduced / own) ** 2
            np.add.at(by_mass, at[inner] + shift - 1, share[inner])
    return dataclasses.replace(slopes, stiffness=by_stiffness, masses=by_mass)


def by_law(equation: Equation, slopes: Slopes, name: str) -> Array:
    """Derivative with respect to a parameter of all laws that have it."""
    total = 0.0
    for group in equation.chain.contact_groups:
        if name not in group.law.parameters():
            continue
        value = getattr(group.law, name)

        def strength(factor: float, group: ContactGroup = group, value: float = value) -> Array:
            changed: dict[str, Any] = {name: value * factor}
            return dataclasses.replace(group.law, **changed).strength(group.contacts)

        there = group.contacts.stiffness > 0.0
        total += float(slopes.damping[group.index[there]] @ _difference(strength, value)[there])
    return np.asarray(total)

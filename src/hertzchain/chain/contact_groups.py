"""The contacts of a chain, those with the walls included, grouped by their law and exponent."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..collision import Array, reduced_mass
from .laws import Loss
from .laws.base import ContactArrays
from .materials import Material


@dataclass(frozen=True, eq=False)
class ContactGroup:
    """Contacts that have the same law and exponent: which of 0..N, and what they are like."""

    law: Loss
    index: Array
    contacts: ContactArrays


def reduced_masses(masses: Array) -> Array:
    """Reduced masses of contacts 0..N; next to a wall, which cannot move, the mass of the bead."""
    inner = reduced_mass(masses[:-1], masses[1:])
    return np.concatenate((masses[:1], inner, masses[-1:]))


def group_contacts(
    losses: Sequence[Loss],
    exponents: Array,
    stiffness: Array,
    masses: Array,
    radii: Array | None = None,
    materials: Sequence[Material] | None = None,
) -> tuple[ContactGroup, ...]:
    """Groups of contacts 0..N, in the order in which they are first met.

    Radii in metres are those of the beads, infinite for flat ones; materials are those of left
    wall, beads and right wall.
    """
    reduced = reduced_masses(masses)
    effective = None if radii is None else effective_radii(radii)
    strength = None if materials is None else yield_strengths(materials)
    if all(law is losses[0] for law in losses) and np.all(exponents == exponents[0]):
        contacts = ContactArrays(float(exponents[0]), stiffness, reduced, effective, strength)
        return (ContactGroup(losses[0], np.arange(len(stiffness)), contacts),)
    members: dict[tuple[Loss, float], list[int]] = {}
    for c, key in enumerate(zip(losses, exponents.tolist(), strict=True)):
        members.setdefault(key, []).append(c)
    return tuple(
        ContactGroup(
            law,
            np.array(index),
            ContactArrays(
                exponent,
                stiffness[index],
                reduced[index],
                None if effective is None else effective[index],
                None if strength is None else strength[index],
            ),
        )
        for (law, exponent), index in members.items()
    )


def effective_radii(radii: Array) -> Array:
    """Effective radii of contacts 0..N, 1/R = 1/R_1 + 1/R_2; infinite if both sides are flat."""
    curvature = np.concatenate(([0.0], 1.0 / radii, [0.0]))
    with np.errstate(divide="ignore"):
        return np.asarray(1.0 / (curvature[:-1] + curvature[1:]))


def yield_strengths(materials: Sequence[Material]) -> Array:
    """Yield strength of the softer material of each contact; infinite where none is known."""
    known = np.array([each.yield_strength or np.inf for each in materials])
    return np.minimum(known[:-1], known[1:])


def loading_forces(groups: Sequence[ContactGroup], overlaps: Array) -> Array:
    """Forces of contacts 0..N that reach these overlaps slowly for the first time."""
    forces = np.zeros(len(overlaps))
    for group in groups:
        forces[group.index] = group.law.loading_force(overlaps[group.index], group.contacts)
    return forces


def dents(groups: Sequence[ContactGroup], largest: Array) -> Array:
    """Residual overlaps of contacts 0..N after these largest overlaps."""
    found = np.zeros(len(largest))
    for group in groups:
        found[group.index] = group.law.dent(largest[group.index], group.contacts)
    return found


def law_yield_ratios(groups: Sequence[ContactGroup], largest: Array) -> Array:
    """Pressure over the yield pressure of the laws of contacts 0..N; NaN if they have none."""
    found = np.full(len(largest), np.nan)
    for group in groups:
        found[group.index] = group.law.yield_ratio(largest[group.index], group.contacts)
    return found


def loading_overlaps(groups: Sequence[ContactGroup], forces: Array) -> Array:
    """Overlaps of contacts 0..N that carry these forces for the first time; 0 at free ends."""
    overlaps = np.zeros(len(forces))
    for group in groups:
        loaded = (forces[group.index] > 0.0) & (group.contacts.stiffness > 0.0)
        found = group.law.loading_overlap(forces[group.index], group.contacts)
        overlaps[group.index] = np.where(loaded, found, 0.0)
    return overlaps

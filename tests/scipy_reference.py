"""An independent second path: SciPy's integrator and root finder, ten lines of physics."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq


def accelerations(radii, x):
    m = radii**3
    r = np.sqrt(2.0 * radii[:-1] * radii[1:] / (radii[:-1] + radii[1:]))
    force = r * np.maximum(x[:-1] - x[1:], 0.0) ** 1.5
    a = np.zeros_like(x)
    a[:-1] -= force
    a[1:] += force
    return a / m


def trajectory(radii, until, rtol=1e-13):
    radii = np.asarray(radii, float)
    n = len(radii)
    start = np.zeros(2 * n)
    start[n] = 1.0
    return solve_ivp(
        lambda _, y: np.concatenate([y[n:], accelerations(radii, y[:n])]),
        (0.0, until),
        start,
        method="DOP853",
        rtol=rtol,
        atol=1e-22,
        dense_output=True,
    )


def peaks(radii, until, foot=1e-6):
    """First velocity maxima of beads 2..N-1: (velocities, times), by root-finding a = 0."""
    radii = np.asarray(radii, float)
    n = len(radii)
    solution = trajectory(radii, until)
    y = solution.y
    a = np.array([accelerations(radii, state[:n]) for state in y.T]).T
    velocities, times = np.empty(n - 2), np.empty(n - 2)
    for k in range(1, n - 1):
        nearby = np.abs(y[n + max(k - 3, 0) : n + min(k + 4, n)]).max(axis=0)
        turned = (a[k, :-1] > 0) & (a[k, 1:] <= 0) & (y[n + k, 1:] > foot * nearby[1:])
        i = int(np.argmax(turned))
        when = brentq(
            lambda t, k=k: accelerations(radii, solution.sol(t)[:n])[k],
            solution.t[i],
            solution.t[i + 1],
            xtol=1e-15,
            rtol=1e-15,
        )
        velocities[k - 1], times[k - 1] = solution.sol(when)[n + k], when
    return velocities, times

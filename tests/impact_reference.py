"""End of the impact on a right wall by SciPy: DOP853 with events, and compression times."""

from __future__ import annotations

import numpy as np
from scipy.integrate import quad, solve_ivp


def pause(chain):
    """Mean time in which a pulse passes a contact: of a collision, or of sound if it is shorter."""
    half = quad(lambda u: (1.0 - u**2.5) ** -0.5, 0.0, 1.0)[0]
    masses, static = chain.masses, chain.static_state.forces[1:-1]
    times = []
    for k, stiffness in enumerate(chain.stiffness):
        speed = chain.velocities[0] * np.sqrt(masses[0] / masses[k])
        reduced = masses[k] * masses[k + 1] / (masses[k] + masses[k + 1])
        time = half / speed * (1.25 * reduced * speed**2 / stiffness) ** 0.4
        slope = 1.5 * stiffness ** (2 / 3) * static[k] ** (1 / 3)
        times.append(min(time, np.sqrt(reduced / slope)) if slope > 0.0 else time)
    return np.mean(times)


def impact(chain, until):
    """End of the impact by the documented rule, and impulse until then."""
    beads, k, p = chain.beads, chain.contact_stiffness, chain.contact_exponents
    state = chain.static_state
    # Displacements are those from equilibrium.
    gaps = np.concatenate(([0.0], chain.gaps, [chain.right_wall.gap]))
    stiffness = np.where(k > 0.0, k, 1.0)
    at_rest = np.where(state.forces > 0.0, (state.forces / stiffness) ** (1.0 / p), -gaps)

    def forces(y):
        return k * np.maximum(at_rest - np.diff(np.pad(y[:beads], 1)), 0.0) ** p

    def rates(_, y):
        pushing = forces(y)
        a = (state.body_forces - np.diff(pushing)) / chain.masses
        return np.concatenate((y[beads : 2 * beads], a, pushing[-1:]))

    start = np.concatenate((np.zeros(beads), chain.velocities, [0.0]))
    speed = np.abs(chain.velocities).max()
    options = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-13 * speed, "max_step": until / 500}
    turns = lambda _, y: y[2 * beads - 1]  # noqa: E731
    first = solve_ivp(rates, (0.0, until), start, events=turns, **options)
    tops = [forces(y)[-1] for y in first.y_events[0]]
    peak_time = first.t_events[0][np.argmax(tops)]
    static = state.forces[-1]
    level = static + 1e-3 * (max(tops) - static) if static > 0.0 else 0.0
    depth = (level / k[-1]) ** (1.0 / p[-1])
    found = solve_ivp(
        rates, (0.0, until), start,
        events=lambda _, y: y[beads - 1] + at_rest[-1] - depth, **options,
    )  # fmt: skip
    times, states = found.t_events[0], found.y_events[0]
    falls = times > peak_time
    times, states = times[falls], states[falls]
    following = np.append(times[1:], until)
    for n in range(0, len(times), 2):
        if following[n] - times[n] >= pause(chain):
            return times[n], states[n][-1]
    raise AssertionError("the impact has not ended")

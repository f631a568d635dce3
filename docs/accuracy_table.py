"""Compare the peaks of `hertzchain.simulate` with an independent integration.

The reference shares only the paper's equation of motion with the package.  It uses SciPy's DOP853
near the smallest tolerance that SciPy accepts, and finds velocity maxima as roots of the
acceleration on the dense output.
"""

import numpy as np
from scipy.integrate import OdeSolution, solve_ivp
from scipy.optimize import brentq

import hertzchain as hc

# At 1e-13 the error of the reference in backward tapers is 1e-9, because its error norm is a mean
# over all beads, most of which are at rest.
RTOL = 2.3e-14

CHAINS = (
    hc.Chain.uniform(60),
    hc.Chain.tapered("backward-exponential", 0.05, beads=100),
    hc.Chain.tapered("backward-exponential", 0.1, beads=100),
    hc.Chain.tapered("forward-exponential", 0.1, beads=60),
    hc.Chain.tapered("backward-linear", 0.9, beads=100),
    hc.Chain.tapered("forward-linear", 0.009, beads=100),
)


def reference_peaks(radii: np.ndarray, until: float) -> tuple[np.ndarray, np.ndarray]:
    """Velocity and time of the first velocity maximum of beads 2..N-1."""
    beads = len(radii)
    masses = radii**3
    stiffness = np.sqrt(2.0 * radii[:-1] * radii[1:] / (radii[:-1] + radii[1:]))

    def derivative(_: float, state: np.ndarray) -> np.ndarray:
        force = stiffness * np.maximum(state[: beads - 1] - state[1:beads], 0.0) ** 1.5
        net = np.concatenate(([0.0], force)) - np.concatenate((force, [0.0]))
        return np.concatenate((state[beads:], net / masses))

    struck = np.zeros(2 * beads)
    struck[beads] = 1.0
    solution = solve_ivp(
        derivative, (0.0, until), struck, "DOP853", rtol=RTOL, atol=1e-22, dense_output=True
    )
    assert solution.success, solution.message
    dense: OdeSolution = solution.sol

    def acceleration(time: float, k: int) -> float:
        return float(derivative(time, dense(time))[beads + k])

    accelerations = np.array([derivative(0.0, y)[beads:] for y in solution.y.T])
    velocities = solution.y[beads:]
    times = np.empty(beads - 2)
    for k in range(1, beads - 1):
        # First zero with a sign change from + to -, while the bead is not much slower than others.
        around = np.abs(velocities[max(k - 3, 0) : k + 4]).max(axis=0)
        falling = (accelerations[:-1, k] > 0.0) & (accelerations[1:, k] <= 0.0)
        i = int(np.argmax(falling & (velocities[k] > 1e-6 * around)[1:]))
        times[k - 1] = brentq(acceleration, *solution.t[i : i + 2], (k,), xtol=1e-15, rtol=1e-15)
    return np.array([dense(t)[beads + k] for k, t in enumerate(times, start=1)]), times


def main() -> None:
    """Print a Markdown table with the largest relative errors over beads 2..N-1 of each chain."""
    print("| chain | peak velocity | at k | peak time | at k | energy drift | momentum drift |")
    print("|---|---|---|---|---|---|---|")
    for chain in CHAINS:
        run = hc.simulate(chain, times=0)
        pulse = run.pulse()
        velocity, time = reference_peaks(chain.radii, run.end_time)
        v_errors = np.abs(pulse.velocity[1:-1] / velocity - 1.0)
        t_errors = np.abs(pulse.peak_time[1:-1] / time - 1.0)
        print(
            f"| {chain.description} | {v_errors.max():.1e} | {v_errors.argmax() + 2} "
            f"| {t_errors.max():.1e} | {t_errors.argmax() + 2} "
            f"| {run.energy_drift:.1e} | {run.momentum_drift:.1e} |"
        )


if __name__ == "__main__":
    main()

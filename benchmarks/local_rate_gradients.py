"""Accuracy of the derivatives of the local-rate law, compared with `propagate`.

    python benchmarks/local_rate_gradients.py [--last]

For each chain of 60 beads and each quantity, the script prints the largest error of the
derivatives with respect to all radii in % of the largest one: at bead 35, at the last bead (or
contact), and at bead 35 in % of the largest one other than that of the struck bead.

With ``--last``, it prints the largest error of each quantity at the last four beads (or contacts)
of random chains, six of each class.
"""

import sys
import warnings

import numpy as np
from local_rate_chains import SMOOTH, scattered, smooth_rates

import hertzchain as hc

BEADS, INSIDE = 60, 35
QUANTITIES = ("velocity", "energy", "arrival", "residence", "peak_force")
# With all radii c times as large, a quantity grows by this power of c; propagate uses the first
# radius as unit of length, the law's derivatives do not.
POWERS = {"velocity": 0.0, "energy": 3.0, "arrival": 1.0, "residence": 1.0, "peak_force": 2.0}
STEP = 2e-4
# Central differences of fourth order.
DIFFERENCES = ((2, -1.0 / 12.0), (1, 8.0 / 12.0), (-1, -8.0 / 12.0), (-2, 1.0 / 12.0))


def cases() -> dict[str, np.ndarray]:
    """Rates of the chains."""
    k, random = np.arange(BEADS - 1), np.random.default_rng(0)
    return {
        "equal beads": np.zeros(BEADS - 1),
        "growing, 0.05": np.full(BEADS - 1, 0.05),
        "sine, 0.03": 0.03 * np.sin(2.0 * np.pi * k / 40.0),
        "forward, -0.02": np.full(BEADS - 1, -0.02),
        "forward, -0.04": np.full(BEADS - 1, -0.04),
        "forward, -0.08": np.full(BEADS - 1, -0.08),
        "equal, scatter 0.3%": np.diff(0.003 * random.normal(size=BEADS)),
        "sine, scatter 0.3%": 0.03 * np.sin(2.0 * np.pi * k / 40.0)
        + np.diff(0.003 * random.normal(size=BEADS)),
    }


def simulated(radii: np.ndarray) -> dict[str, np.ndarray]:
    """Derivatives of logarithms of all columns, (beads or contacts, radii)."""
    moved = [
        radii * np.exp(factor * STEP * row) for row in np.eye(BEADS) for factor, _ in DIFFERENCES
    ]
    table = hc.propagate_many([hc.Chain.from_radii(each) for each in moved], rtol=1e-10)
    weights = np.array([weight for _, weight in DIFFERENCES]) / STEP
    found = {}
    for quantity, power in POWERS.items():
        # The arrival of the struck bead is zero.
        values = [table[i].column(quantity) for i in range(len(moved))]
        logs = np.log(np.maximum(np.array(values), 1e-300))
        slopes = np.einsum("jfk,f->kj", logs.reshape(BEADS, len(DIFFERENCES), -1), weights)
        slopes[:, 0] += power
        found[quantity] = slopes
    return found


def error(radii: np.ndarray, quantity: str, bead: int, expected: np.ndarray) -> np.ndarray:
    """Errors of the derivatives at a bead, relative to the largest derivative."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        _, found = hc.local_rate_gradient(hc.Chain.from_radii(radii), quantity, bead=bead)
    return np.abs(found - expected) / np.abs(expected).max()


def random_chains(count: int) -> dict[str, list[np.ndarray]]:
    """Rates of random chains by class."""
    random = np.random.default_rng(927403)
    found: dict[str, list[np.ndarray]] = {"equal, scatter 0.3%": []}
    for i in range(count):
        found["equal, scatter 0.3%"].append(scattered(random, 0.003, BEADS))
        for name, lowest, offset in (("> -0.03", -0.03, 0.0), ("> -0.08", -0.08, -0.03)):
            top = random.uniform(0.01, 0.03)
            rates = smooth_rates(random, SMOOTH[i % 8], BEADS - 1, top, lowest - offset) + offset
            found.setdefault(f"tapers {name}", []).append(rates)
            rates = rates + scattered(random, 0.003, BEADS)
            found.setdefault(f"tapers {name}, scatter 0.3%", []).append(rates)
    return found


def last_beads() -> None:
    """Print the largest errors at the last beads and contacts."""
    print(f"{'':28}" + "".join(f"{name:>12}" for name in QUANTITIES))
    for name, chains in random_chains(6).items():
        largest = dict.fromkeys(QUANTITIES, 0.0)
        for rates in chains:
            radii = np.exp(np.concatenate([[0.0], np.cumsum(rates)]))
            true = simulated(radii)
            for quantity in QUANTITIES:
                count = len(true[quantity])
                for bead in range(count - 3, count + 1):
                    errors = error(radii, quantity, bead, true[quantity][bead - 1])
                    largest[quantity] = max(largest[quantity], errors.max())
        print(f"{name:28}" + "".join(f"{100.0 * value:12.2f}" for value in largest.values()))


def main() -> None:
    """Print a table."""
    if "--last" in sys.argv:
        last_beads()
        return
    print(f"{'':22}" + "".join(f"{name:>22}" for name in QUANTITIES))
    print(f"{'':22}" + f"{'35     60    35*':>22}" * len(QUANTITIES))
    for name, rates in cases().items():
        radii = np.exp(np.concatenate([[0.0], np.cumsum(rates)]))
        true, cells = simulated(radii), []
        for quantity in QUANTITIES:
            errors = []
            for bead in (INSIDE, len(true[quantity])):
                expected = np.abs(true[quantity][bead - 1])
                relative = error(radii, quantity, bead, true[quantity][bead - 1])
                errors.append(relative.max())
                if bead == INSIDE:
                    others = relative[1:].max() * expected.max() / expected[1:].max()
            cells.append("".join(f"{100.0 * value:7.2f}" for value in (*errors, others)))
        print(f"{name:22}" + "".join(f"{cell:>22}" for cell in cells))


if __name__ == "__main__":
    main()

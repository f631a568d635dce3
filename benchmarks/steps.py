"""The piecewise local-rate law with one jump: ``python benchmarks/steps.py``.

Prints the largest error of the velocity from the jump on, 40 beads ahead of it, and of arrival time
and force, for steps and odd beads in several tapers.
"""

import numpy as np

import hertzchain as hc

BEADS, FIRST = 110, 41
K = np.arange(BEADS)
TAPERS = {
    "uniform": np.ones(BEADS),
    "exponential +0.02": np.exp(0.02 * K),
    "exponential -0.04": np.exp(-0.04 * K),
    "backward-linear 0.05": 1 + 0.05 * K,
    "forward-linear 0.006": 1 - 0.006 * K,
    "sine 0.02": np.exp(0.02 * 60 / 6.28 * np.sin(6.28 * K / 60)),
    "rate +0.03 to -0.03": np.exp(np.minimum(0.03 * K, 0.03 * (2 * FIRST - K))),
    "rate -0.02 to +0.05": np.exp(np.maximum(-0.02 * K, -0.02 * FIRST + 0.05 * (K - FIRST))),
}


def errors(radii):
    """Relative errors of velocity, arrival time and force."""
    chain = hc.Chain.from_radii(radii)
    compared = hc.piecewise_local_rate(chain).compare(hc.propagate(chain, rtol=1e-9))
    return [np.abs(compared.errors(name)) for name in ("velocity", "arrival", "peak_force")]


if __name__ == "__main__":
    print(
        "largest errors: velocity from the jump on, 40 beads ahead; arrival; force 40 beads ahead"
    )
    for kind, jump in (("step", K >= FIRST), ("odd bead", K == FIRST)):
        for factor in (0.5, 0.62, 0.85, 1.2, 1.6, 2.0):
            for name, taper in TAPERS.items():
                v, t, force = errors(np.where(jump, factor, 1.0) * taper)
                shown = v[FIRST:-2].max(), v[FIRST + 40], t[1:].max(), force[FIRST + 40]
                print(f"{kind:8} {factor:4} {name:21}", " ".join(f"{e:.3%}" for e in shown))

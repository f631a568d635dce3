"""The local-rate law with other strikers: ``python benchmarks/strikers.py``.

Prints the largest error of the velocity from bead 2 on and from bead 40 on, that of the law with an
equal striker, and the largest errors of arrival time and force, for strikers and tapers.
"""

import warnings

import numpy as np

import hertzchain as hc

BEADS = 110
K = np.arange(BEADS)
TAPERS = {
    "uniform": np.ones(BEADS),
    "exponential +0.05": np.exp(0.05 * K),
    "exponential -0.03": np.exp(-0.03 * K),
    "backward-linear 0.02": 1 + 0.02 * K,
    "backward-linear 0.1": 1 + 0.1 * K,
    "forward-linear 0.006": 1 - 0.006 * K,
    "sine 0.02": np.exp(0.02 * 60 / 6.28 * np.sin(6.28 * K / 60)),
}


def errors(chain, of=("velocity", "arrival", "peak_force")):
    """Absolute relative errors of the law."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        compared = hc.local_rate(chain).compare(hc.propagate(chain, rtol=1e-10))
    return [np.abs(compared.errors(name)) for name in of]


def struck(radii, mass):
    """The beads after the first, struck by a sphere of a mass relative to that of bead 1."""
    size = np.cbrt(mass) * radii[0]
    return hc.Chain.from_radii(radii[1:]).struck_by(radius=float(size / radii[1]))


if __name__ == "__main__":
    print(
        "errors: velocity from bead 2, from 40, of an equal striker from 40; arrival; force from 40"
    )
    for mass in (0.25, 0.6, 1.7, 3.5, 8.0):
        for name, radii in TAPERS.items():
            v, t, force = errors(struck(radii, mass))
            (clean,) = errors(hc.Chain.from_radii(radii), ("velocity",))
            shown = v[1:].max(), v[39:-3].max(), clean[39:-3].max(), t[1:].max(), force[39:-3].max()
            print(f"mass {mass:4}  {name:21}", " ".join(f"{error:.3%}" for error in shown))

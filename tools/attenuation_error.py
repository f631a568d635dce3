"""Second order of `attenuation`, and its error: ``python tools/attenuation_error.py``.

A wave is simulated in equal beads with each law, and its decay per bead is compared with that of
the first order, x, at the velocity that the wave has there.  The coefficients c of the difference,
(x - decay) / x^2, are printed for several exponents p and small x, as medians over the beads; then,
for p = 3/2, the errors of `attenuation` and their estimates, in %; and of contacts that yield, the
two coefficients that fit the decays best, and the errors by the overlap over that at yield.  One
minute of one core.
"""

import warnings

import numpy as np

import hertzchain as hc
from hertzchain.theory.attenuation import STEP, estimated_error, first_order

EXPONENTS = (1.5, 2.0, 3.0)
# First-order decays per bead at which c and the errors are determined.
SMALL, LARGE = (0.0025, 0.005, 0.01), (0.01, 0.02, 0.025, 0.03, 0.04, 0.05)
# Beads at which the wave neither depends on the impact nor on the free end.
BEADS, FIRST, LAST = 70, 15, 40
# Peak velocity of the first wave.
VELOCITY = 0.6816
LAWS = {
    "restitution": lambda loss: hc.Restitution(1.0 - loss),
    "viscoelastic": hc.Viscoelastic,
    "dashpot": hc.Dashpot,
    "walton-braun": lambda loss: hc.WaltonBraun(1.0 - loss),
    "unloading-ratio": hc.UnloadingRatio,
}
# Overlaps over that at yield in the first wave, without its loss.
RATIOS = (1.2, 1.5, 2.2, 3.0, 4.5, 6.0, 7.0, 8.0)
# Largest of them whose first wave is not overtaken, and first bead and smallest decay of the fit of
# the coefficients; nearer the impact, the wave is still forming.
FITTED, SETTLED, LEAST = 7.0, 19, 5e-4
POWERS = (0.6, 1.0, 1.5, 1.81, 2.4, 3.0)


def velocity_power(alpha):
    """A family of laws with one exponent."""
    return lambda gamma: hc.VelocityPower(gamma, alpha)


def chain_with(law, decay, exponent=1.5):
    """Equal beads with the loss that has this decay in the middle of the beads, at first order."""
    velocity = VELOCITY * np.exp(-0.5 * (FIRST + LAST) * decay)
    loss = 1e-3
    for _ in range(20):
        chain = hc.Chain.uniform(BEADS, exponent=exponent).replace(loss=law(loss))
        loss *= decay / float(first_order(chain, velocity))
    return chain


def decays(chain):
    """Decay per bead at each bead: of the first order, by `attenuation` and simulated."""
    v = hc.simulate(chain, times=0, rtol=1e-12).pulse().velocity
    k = np.arange(FIRST, LAST)
    simulated = 0.5 * np.log(v[k - 1] / v[k + 1])
    return first_order(chain, v[k]), hc.attenuation(chain, v[k]), simulated


def coefficient(law, decay, exponent=1.5):
    """Coefficient c, as the median over the beads."""
    x, _, simulated = decays(chain_with(law, decay, exponent))
    return float(np.median((x - simulated) / x**2))


def errors(law, decay):
    """Relative error of `attenuation`, and its estimate."""
    chain = chain_with(law, decay)
    x, found, simulated = decays(chain)
    error = float(np.median(found / simulated)) - 1.0
    return error, estimated_error(chain.loss, 1.5, float(np.median(x)))


def chain_that_yields(ratio):
    """Equal beads that yield; the wave without loss has this overlap / yield overlap."""
    overlap = hc.solitary_wave().peak_force(VELOCITY) ** (2 / 3)
    return hc.Chain.uniform(BEADS).replace(loss=hc.ElasticPlastic(yield_overlap=overlap / ratio))


def yielding_decays(ratio, first=FIRST):
    """Overlaps / yield overlap, and decays per bead by `attenuation` and simulated."""
    chain = chain_that_yields(ratio)
    v = hc.simulate(chain, times=0, rtol=1e-12).pulse().velocity
    k = np.arange(first, LAST)
    simulated = 0.5 * np.log(v[k - 1] / v[k + 1])
    return ratio * (v[k] / VELOCITY) ** 0.8, hc.attenuation(chain, v[k]), simulated


def fitted_coefficients():
    """Coefficients a and b that fit x (1 + a dx/d ln v + b x^2) to decays of contacts that yield.

    The squares of the relative errors are least; also the largest of these errors.
    """
    rows, values = [], []
    for ratio in (each for each in RATIOS if each <= FITTED):
        chain = chain_that_yields(ratio)
        v = hc.simulate(chain, times=0, rtol=1e-12).pulse().velocity
        k = np.arange(SETTLED, LAST)
        x, higher, lower = (first_order(chain, v[k] * (1.0 + h)) for h in (0.0, STEP, -STEP))
        simulated = 0.5 * np.log(v[k - 1] / v[k + 1])
        used = x > LEAST
        rows.append(np.stack([(higher - lower) / (2.0 * STEP), x**2], axis=1)[used])
        values.append((simulated / x - 1.0)[used])
    terms, excess = np.concatenate(rows), np.concatenate(values)
    found = np.linalg.lstsq(terms, excess, rcond=None)[0]
    return found, float(np.abs((1.0 + terms @ found) / (1.0 + excess) - 1.0).max())


def main():
    """Print the coefficients and the errors."""
    warnings.simplefilter("ignore", hc.ModelRangeWarning)
    laws = LAWS | {f"velocity power {alpha:g}": velocity_power(alpha) for alpha in POWERS}
    for p in EXPONENTS:
        print(f"c, p = {p:g}; x =", *SMALL)
        for name, law in laws.items():
            print(f"{name:20}", *(f"{coefficient(law, x, p):8.2f}" for x in SMALL), flush=True)
    print("error and its estimate, in %; x =", *LARGE)
    for name, law in laws.items():
        found = (errors(law, x) for x in LARGE)
        shown = (f"{100 * error:8.2f} ({100 * estimate:.2f})" for error, estimate in found)
        print(f"{name:20}", *shown, flush=True)
    (a, b), largest = fitted_coefficients()
    print(f"contacts that yield: delay {a:.3f}, of the square {b:.1f}, errors up to {largest:.2%}")
    print("contacts that yield: error in %, at overlap / yield overlap")
    for ratio in RATIOS:
        overlaps, found, simulated = yielding_decays(ratio)
        error = 100 * (found / simulated - 1)
        shown = (f"{error[i]:8.2f} ({overlaps[i]:.2f})" for i in range(0, len(error), 6))
        print(f"first wave {ratio:9g}", *shown, flush=True)


if __name__ == "__main__":
    main()

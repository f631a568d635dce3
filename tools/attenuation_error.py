"""Error of the first order in the loss, `attenuation`: ``python tools/attenuation_error.py``.

A wave is simulated in equal beads with each law, and its decay per bead is compared with that of
the formula, x, at the velocity that the wave has there.  The coefficients c of the difference,
(x - decay) / x^2, are printed for several x, as medians over the beads and with their range.  Those
of `hertzchain.theory.attenuation` are medians over the x in brackets.  Twenty seconds of one core.
"""

import warnings

import numpy as np

import hertzchain as hc

# Decays per bead; coefficients are determined at those at which the warning begins.
DECAYS, CHOSEN = (0.0025, 0.005, 0.01, 0.02), (0.01, 0.02)
# Beads at which the wave neither depends on the impact nor on the free end.
BEADS, FIRST, LAST = 90, 20, 61
# Peak velocity of the first wave.
VELOCITY = 0.6816
LAWS = {
    "restitution": lambda loss: hc.Restitution(1.0 - loss),
    "viscoelastic": hc.Viscoelastic,
    "dashpot": hc.Dashpot,
    "walton-braun": lambda loss: hc.WaltonBraun(1.0 - loss),
    "unloading-ratio": hc.UnloadingRatio,
}
POWERS = (0.6, 1.0, 1.5, 1.81, 2.4, 3.0)


def velocity_power(alpha):
    """A family of laws with one exponent."""
    return lambda gamma: hc.VelocityPower(gamma, alpha)


def chain_with(law, decay):
    """Equal beads with the loss that has this decay in the middle of the beads, by the formula."""
    velocity = VELOCITY * np.exp(-0.5 * (FIRST + LAST) * decay)
    loss = 1e-3
    for _ in range(20):
        chain = hc.Chain.uniform(BEADS).replace(loss=law(loss))
        loss *= decay / float(hc.attenuation(chain, velocity))
    return chain


def coefficients(law, decay):
    """Coefficients c at each bead."""
    chain = chain_with(law, decay)
    v = hc.simulate(chain, times=0, rtol=1e-12).pulse().velocity
    k = np.arange(FIRST, LAST)
    x = hc.attenuation(chain, v[k])
    return (x - 0.5 * np.log(v[k - 1] / v[k + 1])) / x**2


def report(name, law):
    """Print the coefficients of a law; return the median over the chosen decays."""
    found = {decay: coefficients(law, decay) for decay in DECAYS}
    median = float(np.median(np.concatenate([found[decay] for decay in CHOSEN])))
    parts = [f"{np.median(c):6.2f} ({c.min():.2f} to {c.max():.2f})" for c in found.values()]
    print(f"{name:20}", "".join(f"{part:26}" for part in parts), f"[{median:.2f}]", flush=True)
    return median


def main():
    """Print all coefficients, and the linear function for `VelocityPower`."""
    warnings.simplefilter("ignore", hc.ModelRangeWarning)
    shown = (f"x = {x} in brackets" if x in CHOSEN else f"x = {x}" for x in DECAYS)
    print(f"{'c':20}", "".join(f"{each:26}" for each in shown))
    for name, law in LAWS.items():
        report(name, law)
    found = [report(f"velocity power {alpha:g}", velocity_power(alpha)) for alpha in POWERS]
    slope, start = np.polyfit(POWERS, found, 1)
    worst = np.abs((start + slope * np.array(POWERS)) / found - 1.0).max()
    print(f"velocity power: {start:.1f} + {slope:.1f} alpha, within {worst:.1%}")


if __name__ == "__main__":
    main()

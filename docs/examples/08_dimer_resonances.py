r"""
Which dimers weaken a pulse, and which let it pass?
===================================================

In a *dimer*, heavy and light beads alternate.  For some mass ratios the pulse passes as in a
uniform chain, for others it becomes weaker from cell to cell.  Which mass ratios are these?
"""

import matplotlib.pyplot as plt
import numpy as np

import hertzchain as hc

plt.style.use("hertzchain.figures")

# %%
# Follow the pulse along 121 beads for 300 mass ratios.  All contacts have the same stiffness.  The
# decay is read between beads 41 and 81: before them the pulse forms, and beyond them, near the
# strongest resonance, larger waves behind the pulse overtake it
# (:doc:`/how-to/dimer_resonances`).


def velocities(ratios):
    """Velocities of the heavy beads for several mass ratios."""
    chains = [hc.Chain.dimer(ratio, beads=121) for ratio in ratios]
    return hc.propagate_many(chains, rtol=1e-10).velocity[:, ::2]


def decays(ratios):
    """Decay per cell, from heavy bead 41 to heavy bead 81, for several mass ratios."""
    heavy = velocities(ratios)
    return np.log(heavy[:, 20] / heavy[:, 40]) / 20


ratios = np.geomspace(0.03, 0.99, 300)
decay = decays(ratios)

# %%
# The decay per cell has sharp minima.  There, the light bead makes a whole number of oscillations
# between its neighbours while the pulse passes, and it keeps no energy.  These mass ratios are
# called *antiresonances* (K. R. Jayaprakash, Y. Starosvetsky, A. F. Vakakis, Phys. Rev. E 83,
# 036606, 2011); those of the maxima are the *resonances*, at which the light beads take most energy
# from the pulse.

inner = slice(1, -1)
down = (decay[inner] < decay[:-2]) & (decay[inner] < decay[2:]) & (decay[inner] < 1e-3)
up = (decay[inner] > decay[:-2]) & (decay[inner] > decay[2:]) & (decay[inner] > 1e-6)
passing, stopping = ratios[inner][down], ratios[inner][up]

# %%
# The grid of 300 ratios does not hit the minima, which are narrow.  Refine each of them between its
# two neighbours, five times with 21 ratios that surround the best one more closely.

lowest = []
for i, ratio in enumerate(passing):
    width = ratio * (ratios[1] / ratios[0] - 1.0)
    for _ in range(5):
        near = np.linspace(ratio - width, ratio + width, 21)
        found = decays(near)
        ratio, width = near[found.argmin()], 0.2 * width
    passing[i] = ratio
    lowest.append(found.min())

# %%
# The curve contains the refined minima.  The smallest of them, 9e-10, is not an error of the
# integration: ``simulate`` with ``rtol=1e-13`` gives the same four digits.

everywhere = np.concatenate([ratios, passing])
order = everywhere.argsort()

figure, axes = plt.subplots(figsize=(8.0, 3.8))
axes.loglog(everywhere[order], np.concatenate([decay, lowest])[order])
axes.plot(passing, lowest, "^", label="passes (antiresonance)")
axes.plot(stopping, decay[inner][up], "v", label="decays most (resonance)")
axes.set_title("Decay of the velocity of a pulse in dimers")
axes.set_xlabel("mass of a light bead over that of a heavy bead")
axes.set_ylabel("decay per cell")
axes.set_xticks([0.03, 0.1, 0.3, 1.0], ["0.03", "0.1", "0.3", "1"])
axes.legend(loc="upper left")

# %%
# Maps of the force show the difference.  In the second one, the pulse leaves a train of small
# oscillations behind, which takes its energy.

figure, panels = plt.subplots(1, 2, figsize=(8.0, 3.4), sharey=True)
for axes, ratio, title in zip(
    panels, (passing[-1], stopping[-1]), ("passes", "decays"), strict=True
):
    run = hc.simulate(hc.Chain.dimer(ratio, beads=61), until=60.0, times=1200)
    run.plot("force", ax=axes)
    axes.set_title(f"mass ratio {ratio:.3f}: the pulse {title}")
panels[1].set_ylabel("")

# %%
# Answer
# ------

print("the pulse passes at mass ratios  ", ", ".join(f"{x:.4f}" for x in passing[::-1]))
print("with a decay per cell of         ", ", ".join(f"{x:.0e}" for x in lowest[::-1]))
print("and decays most at               ", ", ".join(f"{x:.3f}" for x in stopping[::-1]))
worst, decrease = ratios[decay.argmax()], 1 - np.exp(-decay.max())
print(f"at {worst:.3f}, the velocity decreases by {decrease:.1%} per cell (beads 41 to 81)")
heavy = velocities([worst])[0]
weakened = heavy / heavy[0]
for cell in (1, 5, 10, 20, 30, 40):
    cells = "cell" if cell == 1 else "cells"
    left = weakened[cell]
    print(f"  after {cell} {cells}: {left:.2f} of the velocity of the struck bead")

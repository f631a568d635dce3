"""
How much of a pulse does a wall or an interface reflect?
========================================================

A pulse reaches a wall, or a place where the beads change.  A fraction of its energy continues,
the rest returns.  How does this depend on the stiffness of the wall and on the size of the beads?
"""

import matplotlib.pyplot as plt
import numpy as np

import hertzchain as hc

plt.style.use("hertzchain.figures")

# %%
# Walls
# -----
#
# The wall is elastic, so all energy returns.  Its stiffness determines the peak force and the
# number of pulses that return.  The stiffness is relative to that of the contact of two beads.
# A flat wall of the same material has the value :math:`\sqrt{2}`, and a rigid flat wall
# :math:`2\sqrt{2}`.  Only a concave seat of the ball can be stiffer (shaded), because it has a
# larger area of contact.

stiffness = np.geomspace(0.02, 200.0, 60)
row = hc.Chain.uniform(30)
walls = [row.replace(right_wall=hc.Wall(stiffness=value)) for value in stiffness]
peak = hc.simulate_many(walls, keep=["wall_peak_force"])["wall_peak_force"]
chain_force = hc.propagate(row).peak_force[20]

figure, axes = plt.subplots(figsize=(8.0, 3.8))
axes.semilogx(stiffness, peak / chain_force)
for value, name in ((np.sqrt(2), "same material "), (2 * np.sqrt(2), "rigid ")):
    axes.axvline(value, color="0.5", linestyle="--", linewidth=0.9)
    axes.text(value, 0.5 if name == "rigid " else 0.7, name, horizontalalignment="right")
axes.text(2 * np.sqrt(2), 0.9, " concave seat of the ball")
axes.axvspan(2 * np.sqrt(2), stiffness[-1], color="0.93", zorder=0)
axes.margins(x=0)
axes.set_title("Peak force on a wall")
axes.set_xlabel("stiffness of the wall over that of a contact of two beads")
axes.set_ylabel("peak force over that in the chain")

# %%
# A soft wall acts for a long time on several beads, and more than one pulse returns.  From a stiff
# wall, almost all of the energy returns in the first pulse.

figure, panels = plt.subplots(1, 2, figsize=(8.0, 3.4), sharey=True)
for axes, value in zip(panels, (0.05, 20.0), strict=True):
    chain = row.replace(right_wall=hc.Wall(stiffness=value))
    hc.simulate(chain, until=70.0, times=1400).plot("force", ax=axes)
    axes.set_title(f"stiffness of the wall {value:g}")
panels[1].set_ylabel("")

# %%
# Interfaces
# ----------
#
# Now the second half of the beads has another radius.  ``Run.reflection`` adds up the energy that
# returns and the energy that passes.


def balance(radius):
    """Reflection at an interface between beads of radius 1 and of another radius."""
    radii = np.where(np.arange(120) < 60, 1.0, radius)
    run = hc.simulate(hc.Chain.from_radii(radii), until=170.0, times=3000)
    return run.reflection(50, 72)


radii = np.array([0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.15, 1.3, 1.5, 1.75, 2.0, 2.5])
found = [balance(radius) for radius in radii]
reflected = np.array([each.reflected_energy for each in found])
transmitted = np.array([each.transmitted_energy for each in found])

figure, axes = plt.subplots(figsize=(8.0, 3.8))
axes.plot(radii, transmitted, "o-", label="transmitted")
axes.plot(radii, reflected, "s-", label="reflected")
axes.set_title("Energy at an interface")
axes.set_xlabel("radius of the second half")
axes.set_ylabel("fraction of the incident energy")
axes.legend()

# %%
# Towards smaller beads nothing is reflected: the pulse continues as a train of several pulses.  The
# last ones are slow, and with radius 0.4 they still have 0.5% of the energy at the end of the run,
# before they have passed the second contact.  Towards larger beads a part returns.  The map shows
# both cases.

figure, panels = plt.subplots(1, 2, figsize=(8.0, 3.4), sharey=True)
for axes, radius in zip(panels, (0.5, 2.0), strict=True):
    chain = hc.Chain.from_radii(np.where(np.arange(80) < 40, 1.0, radius))
    run = hc.simulate(chain, until=80.0, times=1600)
    run.plot("force", ax=axes)
    axes.set_title(f"second half: radius {radius:g}")
panels[1].set_ylabel("")

# %%
# Answer
# ------

same = np.interp(np.log(np.sqrt(2)), np.log(stiffness), peak) / chain_force
rigid = hc.simulate(row.replace(right_wall=hc.Wall.rigid())).wall_force().peak
print(f"a wall of the same material carries {same:.2f} times the force in the chain,")
print(f"a rigid wall {rigid / chain_force:.2f} times, more than any other flat wall")
for radius in (0.5, 2.0):
    k = int(np.flatnonzero(radii == radius)[0])
    shares = f"{transmitted[k]:.1%} transmitted, {reflected[k]:.1%} reflected"
    print(f"radius {radius:g}: {shares}")

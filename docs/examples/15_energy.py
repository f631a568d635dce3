"""
Where does the energy of an impact go?
======================================

A striker brings energy to a row of balls in front of a wall.  How much of it reaches the wall, how
much is lost in the contacts, and how much returns?
"""

import matplotlib.pyplot as plt
import numpy as np

import hertzchain as hc

plt.style.use("hertzchain.figures")

# %%
# Twenty steel balls lose energy in each contact, with a coefficient of restitution of 0.97.  The
# energy budget of a run states where the energy is at every saved time.

balls = hc.Chain.from_materials("5 mm", "steel-52100", beads=20, loss=hc.Restitution(0.97))
chain = balls.struck_by(velocity="0.3 m/s").replace(right_wall=hc.Wall())
run = hc.simulate(chain, until="0.9 ms", times=1801)
budget = run.budget()
impact = sum(values[0] for values in budget.energy.values())

figure, axes = plt.subplots(figsize=(8.0, 3.8))
budget.plot(legend=False, ax=axes)
axes.set_title("Energy by location")
# The energy of the beads that lag behind the pulse is too small to be seen.
parts = {
    label: handle for handle, label in zip(*axes.get_legend_handles_labels())
    if not label.startswith("lagging")
}
axes.legend(parts.values(), parts, loc="center left", bbox_to_anchor=(1.0, 0.5), reverse=True)

# %%
# On the way to the wall, the pulse loses energy to the contacts that it passes, and leaves little
# behind.  At 0.4 ms, most of the remaining energy is stored in the contact with the wall; then it
# returns.  At the largest force on the wall, and at the end:

peak = np.argmin(abs(run.times - run.wall_force().peak_time))
print(f"{'':15}{1e6 * run.times[peak]:6.0f} µs{1e6 * run.times[-1]:6.0f} µs")
for place, values in budget.energy.items():
    print(f"{place:15}{values[peak] / impact:9.1%}{values[-1] / impact:9.1%}")

# %%
# More balls, or a larger loss
# ----------------------------
#
# A longer row keeps more of the energy away from the wall.  ``simulate_many`` returns the energy
# that was lost when the balls have separated again.

restitution = np.linspace(0.8, 1.0, 11)
figure, axes = plt.subplots(figsize=(8.0, 3.8))
lost = {}
for beads in (5, 10, 20):
    row = hc.Chain.from_materials("5 mm", "steel-52100", beads=beads)
    row = row.struck_by(velocity="0.3 m/s").replace(right_wall=hc.Wall())
    table = hc.simulate_many(
        [row.replace(loss=hc.Restitution(e)) for e in restitution],
        keep=["energy_lost", "wall_peak_force"], until=2e-3,
    )
    lost[beads] = table["energy_lost"]
    axes.plot(restitution, lost[beads], "o-", label=f"{beads} balls")
axes.set_title("Energy that is lost in the contacts")
axes.set_xlabel("coefficient of restitution")
axes.set_ylabel("fraction of the impact energy")
axes.legend()

# %%
# Answer
# ------
#
# A small loss in each contact adds up along the row, and the pulse passes every contact twice: on
# the way to the wall and on the way back.

parts = budget.energy["lost"] / impact
print(f"restitution 0.97, 20 balls: {parts[peak]:.0%} is lost on the way to the wall, "
      f"and {parts[-1]:.0%} in total")
print(f"restitution 0.9: {lost[5][5]:.0%} is lost with 5 balls, and {lost[20][5]:.0%} with 20")

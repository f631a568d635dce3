"""
Which order of given balls reduces the wall force most?
=======================================================

A steel ball of 20 mm diameter arrives at 0.05 m/s, and a wall must be protected.  You have fifteen
steel balls, five each of 6 mm, 12 mm and 20 mm.  In which order should they stand between the ball
and the wall?
"""

import textwrap

import matplotlib.pyplot as plt
import numpy as np

import hertzchain as hc

plt.style.use("hertzchain.figures")
SIZES = [3e-3, 6e-3, 10e-3]


def row(radii):
    """Return a row of steel balls, struck by a ball of 20 mm diameter, in front of a wall."""
    return hc.Chain.from_materials(
        [10e-3, *radii], "steel-52100", velocity=0.05, right_wall=hc.Wall()
    )


def peak_forces(chains):
    """Peak force on the wall [N] of each chain."""
    return hc.simulate_many(chains, keep=["wall_peak_force"])["wall_peak_force"]


# %%
# Simple orders
# -------------
#
# Begin with orders that one would try first, and with 2000 random ones.

small, medium, large = (np.full(5, size) for size in SIZES)
orders = {
    "from large to small": np.r_[large, medium, small],
    "from small to large": np.r_[small, medium, large],
    "in turns": np.column_stack([large, medium, small]).ravel(),
    "small balls between others": np.r_[
        np.column_stack([np.r_[large, medium][:5], small]).ravel(), medium
    ],
}
rng = np.random.default_rng(1)
randomly = [rng.permutation(orders["in turns"]) for _ in range(2000)]
simple = dict(zip(orders, peak_forces([row(radii) for radii in orders.values()])))
random_forces = peak_forces([row(radii) for radii in randomly])

# %%
# Let hertzchain search
# ---------------------
#
# There are 756 756 orders.  :obj:`~hertzchain.design` searches among them with a genetic algorithm
# and completes the search by exchanges of two balls.  The striker keeps its place.

start = row(orders["from large to small"])
problem = hc.Design(start, minimise="wall_force.peak", vary=[hc.vary.order(beads="2:")])
found = hc.design(problem, budget=8000, seed=1)
best = found.chain.radii[1:]

figure, axes = plt.subplots(figsize=(6.4, 4.8))
axes.hist(random_forces, bins=40, color="0.7", label="2000 random orders")
for i, (name, force) in enumerate(simple.items()):
    axes.axvline(force, color=f"C{i}", linestyle="--", label=name)
axes.axvline(found.value, color="black", label="design")
axes.set_title("Peak force on the wall of the same balls in different orders")
axes.set_xlabel("peak force [N]")
axes.set_ylabel("number of orders")
axes.set_xlim(0.9 * found.value, 1.05 * max(random_forces.max(), *simple.values()))
# The legend is below the axes, where it covers no line.
axes.legend(fontsize=9, ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.16))

# %%
# Is it a minimum?
# ----------------
#
# Exchange each pair of balls of the result.  Every exchange increases the force.  The map shows by
# how much; the ring marks the pair with the smallest increase.  Balls of equal size cannot be
# exchanged (blank).

count = len(best)
pairs = [(i, j) for i in range(count) for j in range(i) if best[i] != best[j]]
exchanged = []
for i, j in pairs:
    radii = best.copy()
    radii[[i, j]] = radii[[j, i]]
    exchanged.append(row(radii))
increase = 100.0 * (peak_forces(exchanged) / found.value - 1.0)
assert increase.min() > 0.0, "an exchange of two balls reduces the force: increase the budget"

table = np.full((count, count), np.nan)
for (i, j), change in zip(pairs, increase):
    table[i, j] = change
figure, (top, axes) = plt.subplots(2, 1, figsize=(6.4, 6.8), height_ratios=[1, 4])
hc.plot_chain(found.chain, ax=top)
top.set_title("The design; the first ball is the striker")

numbers = np.arange(1, count + 1)
# Both halves of the map are the same pairs, so that it has no empty half.
table = np.where(np.isnan(table), table.T, table)
shown = axes.pcolormesh(numbers, numbers, table, shading="nearest", cmap="viridis_r")
i, j = pairs[increase.argmin()]
for across, up in ((i + 1, j + 1), (j + 1, i + 1)):
    axes.plot(across, up, "o", markersize=11, markerfacecolor="none",
              markeredgecolor="#D55E00", markeredgewidth=2.5)
axes.set_aspect("equal")
axes.set_xticks(numbers[::2])
axes.set_yticks(numbers[::2])
axes.set_title("Increase of the peak force if two balls are exchanged")
axes.set_xlabel("place of a ball behind the striker")
axes.set_ylabel("place of the other ball")
figure.colorbar(shown, label="increase [%]")

# %%
# Tolerances
# ----------
#
# How much do diameter tolerances change the force?
# Here, the diameters of the fifteen balls vary within grade 100, or with a standard deviation of
# 1%.  The striker keeps its size (``beads="2:"``).

lots = [found.chain.with_scatter(seed, grade=100, beads="2:") for seed in range(100)]
rough = [found.chain.with_scatter(seed, relative=0.01, beads="2:") for seed in range(100)]
grade_100, one_percent = peak_forces(lots), peak_forces(rough)

# %%
# Answer
# ------
#
# The order matters more than one might expect.  The search has found a good order, which no
# exchange of two balls improves, but not necessarily the best one that exists.  If you can choose
# the sizes as well, small balls are better than any order of these.  The last line compares the
# design with a row of fifty equal balls of 4 mm, which is about as long as the design and has less
# than a tenth of its mass.

for name, force in simple.items():
    print(f"{name:28} {force:6.2f} N")
print(f"{'best of 2000 random orders':28} {random_forces.min():6.2f} N")
least = increase.min()
print(f"{'design':28} {found.value:6.2f} N, at least {least:.2f}% less than its neighbours")
smallest, largest = grade_100.min(), grade_100.max()
print(f"with balls of grade 100      {smallest:.4f} to {largest:.4f} N in 100 lots")
smallest, largest = one_percent.min(), one_percent.max()
print(f"with deviations of 1%        {smallest:.2f} to {largest:.2f} N in 100 lots")
print("order of the diameters, from the striker to the wall:")
print(textwrap.fill(", ".join(f"{2e3 * radius:g}" for radius in best) + " mm", 72))
fifty = np.full(50, 2e-3)
ratio = row(fifty).masses[1:].sum() / row(best).masses[1:].sum()
print(f"for comparison, fifty equal balls of 4 mm: {peak_forces([row(fifty)])[0]:.2f} N, "
      f"{2e3 * fifty.sum():.0f} mm, {ratio:.1%} of the mass")

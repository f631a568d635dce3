"""
Which row of balls reduces the force on a wall most?
====================================================

A steel ball of 20 mm diameter hits a row of balls at 0.05 m/s, and a wall is behind the row.
The row may be 200 mm long, and its balls must not be smaller than 4 mm.  Which balls should be
bought?
"""

# sphinx_gallery_thumbnail_number = 2
import textwrap

import matplotlib.pyplot as plt
import numpy as np

import hertzchain as hc

plt.style.use("hertzchain.plotting.hertzchain")
LENGTH, SMALLEST = 0.2, 2e-3
WALL = hc.Wall()


def row(radii):
    """Return a row of steel balls, struck by a ball of 20 mm diameter, in front of a wall."""
    balls = hc.Chain.from_materials(radii, "steel-52100")
    return balls.struck_by(radius=10e-3, velocity=0.05).replace(right_wall=WALL)


def peak_forces(chains):
    """Peak force on the wall [N] of each chain."""
    return hc.simulate_many(chains, keep=["wall_peak_force"])["wall_peak_force"]


equal = np.full(10, 10e-3)
print(f"ten equal balls of 20 mm: {peak_forces([row(equal)])[0]:.1f} N")

# %%
# Candidates
# ----------
#
# The candidates are tapers from a first to a last radius, with the number of balls that the
# length allows, and tapers with a small ball between neighbours.


def taper(first, last):
    """Return radii that decrease exponentially and fill the length."""
    beads = int(LENGTH / (first + last))
    while 2 * np.geomspace(first, last, beads).sum() > LENGTH:
        beads -= 1
    return np.geomspace(first, last, beads)


def with_small_balls(radii, ratio):
    """Return the radii with small balls in between, shortened to the length."""
    mixed = np.empty(2 * len(radii) - 1)
    mixed[::2] = radii
    mixed[1::2] = ratio * np.sqrt(radii[1:] * radii[:-1])
    return mixed[: np.searchsorted(np.cumsum(2 * mixed), LENGTH)]


def mass(radii):
    """Mass of the row [kg]."""
    return row(radii).masses[1:].sum()


first, last = np.meshgrid(np.linspace(4e-3, 10e-3, 13), np.linspace(SMALLEST, 10e-3, 17))
plain = [taper(a, b) for a, b in zip(first.flat, last.flat)]
force = peak_forces([row(radii) for radii in plain])

figure, axes = plt.subplots(figsize=(8.0, 4.2))
shape = first.shape
shown = axes.pcolormesh(2e3 * first, 2e3 * last, force.reshape(shape), shading="nearest")
axes.set_title("Peak force on the wall for simple tapers of 200 mm")
axes.set_xlabel("first diameter [mm]")
axes.set_ylabel("last diameter [mm]")
figure.colorbar(shown, label="peak force [N]")

# %%
# The best simple taper, and the same with small balls in between:

best_plain = plain[force.argmin()]
ratios = np.linspace(0.3, 0.9, 13)
decorated = [
    with_small_balls(taper(a, b), ratio)
    for a in np.linspace(5e-3, 10e-3, 6)
    for b in np.linspace(3e-3, 8e-3, 6)
    for ratio in ratios
]
decorated = [radii for radii in decorated if radii.min() >= SMALLEST]
force_decorated = peak_forces([row(radii) for radii in decorated])
best_decorated = decorated[force_decorated.argmin()]

# %%
# From radii to a parts list
# --------------------------
#
# Balls are sold in steps of half a millimetre, with the tolerance of grade 100.  Round the best
# design, and check what rounding and tolerance change.

rounded = np.round(2e3 * best_decorated * 2) / 2 * 1e-3 / 2
final = row(rounded)
lots = [
    row(hc.Chain.from_materials(rounded, "steel-52100").with_scatter(seed, grade=100).radii)
    for seed in range(100)
]
scattered = peak_forces(lots)

figure, (top, bottom) = plt.subplots(2, 1, figsize=(9.6, 5.0), height_ratios=[1, 2])
hc.plot_chain(final, ax=top)
top.set_title("The design; the first ball is the striker")
for name, radii in {"equal balls": equal, "best taper": best_plain,
                    "design": rounded}.items():  # fmt: skip
    run = hc.simulate(row(radii), until=1.8e-3, times=1800)
    bottom.plot(1e6 * run.times, run.force(run.chain.beads), label=name)
bottom.set_title("Force on the wall")
bottom.set_xlabel("time [µs]")
bottom.set_ylabel("force [N]")
bottom.legend()

# %%
# Answer
# ------
#
# Small balls between large ones scatter the pulse and reduce the peak more than any simple taper
# of the same length.  The result is the best of the candidates above, not the best row that
# exists.

found = peak_forces([row(equal), row(best_plain), final])
print(f"ten equal balls of 20 mm  {found[0]:6.1f} N")
print(f"best taper                {found[1]:6.1f} N, {1e3 * mass(best_plain):.0f} g")
print(f"design                    {found[2]:6.1f} N, {1e3 * mass(rounded):.0f} g, "
      f"{2e3 * rounded.sum():.0f} mm")  # fmt: skip
print(f"with balls of grade 100   {scattered.min():.1f} to {scattered.max():.1f} N in 100 lots")
print("parts, in order, steel 52100:")
print(textwrap.fill(", ".join(f"{2e3 * radius:g}" for radius in rounded) + " mm", 72))

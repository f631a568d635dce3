"""
How closely must the balls match?
=================================

Real balls differ a little.  How much do tolerances, or an invisible gap, change the force on the
wall?
"""

import matplotlib.pyplot as plt
import numpy as np

import hertzchain as hc

plt.style.use("hertzchain.figures")
balls = hc.Chain.from_materials(5e-3, "steel-52100", beads=30)


def experiment(chain):
    """The balls with a striker and a wall."""
    return chain.struck_by(velocity=0.1).replace(right_wall=hc.Wall())


nominal = hc.simulate_many([experiment(balls)], keep=["wall_peak_force"])["wall_peak_force"][0]

# %%
# Scatter of the radii
# --------------------
#
# For each standard deviation, 300 rows of balls are drawn and simulated.  The median force
# decreases roughly with the square of the scatter, because disorder scatters energy out of the
# pulse.

scatters = np.array([0.001, 0.003, 0.01, 0.02, 0.05, 0.1])
forces = []
for scatter in scatters:
    rows = [experiment(balls.with_scatter(seed, relative=scatter)) for seed in range(300)]
    forces.append(hc.simulate_many(rows, keep=["wall_peak_force"])["wall_peak_force"])

figure, axes = plt.subplots(figsize=(6.4, 4.0))
axes.boxplot(
    [each / nominal for each in forces], whis=(5, 95), showfliers=False,
    tick_labels=[f"{100 * scatter:g}%" for scatter in scatters],
)
axes.axhline(1.0, color="0.6", linewidth=0.7)
axes.set_title("Peak force on the wall in 300 rows; whiskers: 5% and 95%")
axes.set_xlabel("standard deviation of the radii")
axes.set_ylabel("force over that of equal balls")

# %%
# Grades of ISO 3290-1
# --------------------
#
# Balls are sold by grade.  Even the coarse grade 200 allows diameters to differ by only 10 µm.

spread = {}
for grade in (10, 28, 100, 200):
    rows = [experiment(balls.with_scatter(seed, grade=grade)) for seed in range(100)]
    found = hc.simulate_many(rows, keep=["wall_peak_force"])["wall_peak_force"]
    spread[grade] = found.std() / nominal
    print(f"grade {grade:3}: standard deviation of the peak force {spread[grade]:.2%}")

# %%
# Gaps
# ----
#
# A gap between two balls hardly changes the peak force, but it delays the pulse.  The ball in front
# of the gap moves like the last ball of a chain with a free end: it leaves at almost the velocity
# of the impact, 0.1 m/s, and crosses the gap at this velocity, whereas the pulse travels at
# 430 m/s.  Here one contact in the middle is open.

gaps = np.array([0.0, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0])
gapped = []
for gap in gaps:
    values = np.zeros(29)
    values[14] = 1e-6 * gap
    gapped.append(experiment(balls.replace(gaps=values)))
table = hc.simulate_many(gapped, keep=["wall_peak_force", "wall_peak_time"])
later = 1e6 * (table["wall_peak_time"] - table["wall_peak_time"][0])
overlap = 1e6 * hc.simulate(gapped[0]).largest_overlaps[15]

figure, (top, bottom) = plt.subplots(2, 1, figsize=(6.4, 5.6), sharex=True)
top.plot(gaps, 100.0 * (table["wall_peak_force"] / nominal - 1.0), "o-")
top.set_title("Change of the peak force by one open contact")
top.set_ylabel("change [%]")
bottom.plot(gaps, later, "o-")
bottom.set_title("Delay of the peak")
bottom.set_ylabel("delay [µs]")
bottom.set_xlabel("gap [µm]")
for axes in (top, bottom):
    axes.axvline(overlap, color="0.5", linestyle="--", linewidth=0.9,
                 label="peak overlap without gap")
bottom.legend(loc="lower right")

# %%
# Answer
# ------

lowered = 1 - np.median(forces[4]) / nominal
print(f"balls of grade 100 change the peak force by {spread[100]:.2%} (standard deviation)")
print(f"a scatter of 5% in radius lowers its median by {lowered:.0%}")
print(f"the peak overlap is only {overlap:.1f} µm; a gap of 1 µm delays the peak by "
      f"{later[4]:.1f} µs")
crossing = (gaps[-1] - gaps[-2]) / (later[-1] - later[-2])
print(f"a ball crosses a wide gap at {crossing:.4f} m/s")

r"""
Which chain transfers the most momentum to a heavy last ball?
=============================================================

A ball of radius 1 strikes a row of balls, the last of which has the radius 4.  If the balls in
between are chosen well, the last one receives more momentum than the striker had, because the light
balls recoil.  How should their radii grow?
"""

# sphinx_gallery_thumbnail_panel = (2, 1)
import matplotlib.pyplot as plt
import numpy as np

import hertzchain as hc

plt.style.use("hertzchain.figures")
N, LAST = 20, 4.0

# %%
# Begin with an exponential taper, in which all neighbours have the same ratio.
# :obj:`~hertzchain.gradient` returns the momentum of the last ball together with its derivatives
# with respect to all radii.  They show which balls matter.

taper = hc.Chain.from_radii(np.geomspace(1.0, LAST, N))


def sensitivity(chain):
    """Momentum of the last ball, and its change in % if one radius grows by 1%."""
    momentum, slope = hc.gradient(chain, "pulse.momentum", bead=N, to=["radii"])
    return momentum, slope["radii"] * chain.radii / momentum


momentum, by_radius = sensitivity(taper)
figure, axes = plt.subplots(figsize=(8.0, 4.0))
axes.bar(np.arange(1, N + 1), by_radius)
axes.set_xticks([1, 5, 10, 15, 20])
axes.set_title("Sensitivity of the last ball's momentum to each radius")
axes.set_xlabel("bead $j$")
axes.set_ylabel("sensitivity of the momentum,\n$\\partial\\ln P_{20} / \\partial\\ln R_j$")

# %%
# The striker and the last ball are given.  Of the others, those next to the two ends matter most,
# and the negative signs state that they should be smaller.  The momentum can hardly be improved by
# the balls in the middle.
#
# :obj:`~hertzchain.design` follows these gradients to the optimum.  There, no free radius has an
# effect of first order:

problem = hc.Design(taper, maximise="momentum@last",
                    vary=[hc.vary.radii(0.5, LAST, beads="2:19")])
found = hc.design(problem, budget=300)
largest = np.abs(sensitivity(found.chain)[1][1:-1]).max()
print(f"method: {found.method}; largest remaining sensitivity: {largest:.1e}")

# %%
# Compare the result with an exponential and a linear taper, by simulation:

designs = {
    "equal balls, then one of radius 4": np.append(np.ones(N - 1), LAST),
    "linear": np.linspace(1.0, LAST, N),
    "exponential": taper.radii,
    "optimised": found.chain.radii,
}
figure, (left, right) = plt.subplots(1, 2, figsize=(8.0, 3.6))
momentum = {}
for (name, radii), marker in zip(designs.items(), "osx+"):
    pulse = hc.propagate(hc.Chain.from_radii(radii))
    momentum[name] = pulse.momentum[-1]
    left.plot(np.arange(1, N + 1), radii, marker=marker, label=name)
    right.plot(np.arange(1, N + 1), pulse.momentum, marker=marker, label=name)
left.set_title("Radii")
left.set_ylabel("radius")
left.legend()
right.set_title("Momentum of each ball at its peak velocity")
right.set_ylabel("momentum / momentum of the striker")
for axes in (left, right):
    axes.set_xlabel("bead $k$")
    axes.set_xticks([1, 5, 10, 15, 20])

# %%
# Answer
# ------
#
# Let the radii grow by about the same factor from ball to ball.  An exponential taper is already
# close to the optimum; a smaller first step and a larger last one improve it a little.  Because of
# the conservation of energy, the momentum cannot exceed the square root of the mass ratio, here 8.

print(f"{'limit by energy conservation':36}{LAST**1.5:6.2f}")
for name, value in momentum.items():
    print(f"{name:36}{value:6.2f}")

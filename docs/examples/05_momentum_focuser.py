r"""
Which chain transfers the most momentum to a heavy last ball?
=============================================================

A ball of radius 1 strikes a row of twenty balls, the last of which has the radius 4.  If the balls
in between are chosen well, the last one receives more momentum than the striker had, because the
light balls recoil.  How should their radii grow?
"""

# sphinx_gallery_thumbnail_number = 2
import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import minimize

import hertzchain as hc

plt.style.use("hertzchain.plotting.hertzchain")
N, LAST = 20, 4.0

# %%
# Begin with an exponential taper, in which all neighbours have the same ratio.
# ``local_rate_gradient`` returns the momentum of one ball together with its derivatives with
# respect to all radii.  They show which radii matter: those of the striker, of the ball itself and
# of its neighbours.

begin = np.full(N - 1, np.log(LAST) / (N - 1))


def radii_of(rates):
    """Return the radii of a chain with given logarithms of the ratios of neighbours."""
    return np.exp(np.concatenate([[0.0], np.cumsum(rates)]))


momentum, by_radius = hc.local_rate_gradient(hc.Chain.from_radii(radii_of(begin)), "momentum",
                                             bead=15)  # fmt: skip
figure, axes = plt.subplots(figsize=(8.0, 4.0))
axes.bar(np.arange(1, N + 1), by_radius)
axes.set_xticks([1, 5, 10, 15, 20])
axes.set_title("Sensitivity of the momentum of ball 15 to each radius")
axes.set_xlabel("bead $j$")
axes.set_ylabel(r"$\partial\ln P_{15} / \partial\ln R_j$")

# %%
# The law has no free end, so the last ball requires the simulation.  ``propagate_many`` computes
# the momentum for all small changes of the ratios together, which gives the gradient.  The sum of
# the logarithms is fixed by the last radius.


def loss(rates, step=1e-5):
    """Negative logarithm of the momentum of the last ball, with its gradient."""
    changes = np.concatenate([np.zeros((1, N - 1)), step * np.eye(N - 1), -step * np.eye(N - 1)])
    table = hc.propagate_many([radii_of(rates + change) for change in changes])
    values = -np.log(table.radii[:, -1] ** 3 * table.velocity[:, -1])
    return values[0], (values[1:N] - values[N:]) / (2 * step)


fixed_end = {"type": "eq", "fun": lambda s: s.sum() - np.log(LAST), "jac": np.ones_like}
found = minimize(
    loss, begin, jac=True, method="SLSQP", bounds=[(-0.2, 0.4)] * (N - 1), constraints=fixed_end
)
print(found.message)

# %%
# Compare the result with an exponential and a linear taper, by simulation:

designs = {
    "equal balls, then one of radius 4": np.append(np.ones(N - 1), LAST),
    "linear": np.linspace(1.0, LAST, N),
    "exponential": radii_of(begin),
    "optimised": radii_of(found.x),
}
figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 3.8))
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
right.set_ylabel("momentum, that of the striker being 1")
for axes in (left, right):
    axes.set_xlabel("bead $k$")
    axes.set_xticks([1, 5, 10, 15, 20])

# %%
# Answer
# ------
#
# The growth must be distributed over all balls.  An exponential taper is already close to the
# optimum; the optimiser gains little by changing the first and the last ratios.  Energy
# conservation limits the momentum to the square root of the mass ratio.

print(f"{'limit by energy conservation':36}{LAST**1.5:6.2f}")
for name, value in momentum.items():
    print(f"{name:36}{value:6.2f}")

r"""
Can you add a chain, a theory, a law or a quantity without changing hertzchain?
===============================================================================

Suppose you want a taper that hertzchain does not have, a theory and a law of loss of your own, and
a number that no result contains.
"""

from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np

import hertzchain as hc
from hertzchain.chain.laws.base import Loss, may_pull, parameter
from hertzchain.kernels.law_kinds import DAMPED, LawRow

plt.style.use("hertzchain.figures")

# %%
# A chain
# -------
#
# Any list of radii is a chain.  Here the radii follow a power of the bead number.


def power_taper(length, power, beads):
    """Return a chain with radii (1 + (k - 1)/length)^power."""
    return hc.Chain.from_radii((1.0 + np.arange(beads) / length) ** power)


chain = power_taper(10.0, 0.6, beads=60)
chain

# %%
# A theory
# --------
#
# A theory is a function that returns a ``Pulse``.  This one assumes that the kinetic energy of the
# bead at the crest is a constant fraction of the energy of the impact, that of the solitary wave of
# equal beads.  The pulse can be compared and plotted like all others.


def constant_energy(chain):
    """Velocity of beads that have the same kinetic energy as in a chain of equal beads."""
    plateau = hc.propagate(hc.Chain.uniform(30)).energy[20]
    velocity = np.sqrt(2.0 * plateau / chain.masses)
    velocity[0] = 1.0
    return hc.Pulse(chain=chain, method="constant energy", velocity=velocity)


exact = hc.propagate(chain)
mine, bca = constant_energy(chain), hc.bca(chain)
print(mine.compare(exact))

# %%
# From bead 4 on, the velocities agree within 5%, far better than those of the BCA.  The assumption
# is not exact: the kinetic energy of the beads decreases slowly along the chain.

figure, axes = plt.subplots(figsize=(8.0, 3.8))
axes.set_title("A theory of your own, compared with the simulation")
hc.plot_pulses([exact, bca, mine], log=True, ax=axes)

# %%
# A law of loss
# -------------
#
# A subclass of ``Loss`` with a viscous force is a law.  In this one, the damping is proportional to
# the area of contact, and therefore to the overlap :math:`d`: :math:`F = k d^p + \gamma d\, d'`.
# Another elastic force would require a change of the compiled kernels.


@dataclass(frozen=True)
class AreaDashpot(Loss, name="area-dashpot"):
    """Damping in proportion to the area of contact, F = k d^p + gamma d d'."""

    damps = True
    gamma: float = parameter("gamma", "damping", least=0.0, unit="force/velocity/length")
    attractive: bool = may_pull(default=True)

    def row(self, exponent):  # noqa: ARG002
        """Powers of the overlap and of the speed, for all contacts."""
        return LawRow(DAMPED, overlap_power=1.0, speed_power=1.0, attractive=self.attractive)

    def strength(self, contacts):
        """Coefficient of each contact."""
        return np.full(len(contacts.stiffness), self.gamma)


equal = hc.Chain.uniform(60)
damped = hc.simulate(equal.replace(loss=AreaDashpot(0.02)), times=0).pulse()
left = damped.velocity[40] / hc.propagate(equal).velocity[40]
print(f"at bead 41, {left:.0%} of the velocity without loss is left")

# %%
# A quantity
# ----------
#
# A run has the positions and velocities of all beads at all saved times, from which any quantity
# can be computed.  This one is the number of beads that share the kinetic energy of the pulse,
# :math:`(\sum_k E_k)^2 / \sum_k E_k^2`.  The sums extend over three beads on each side of the
# crest, because in tapers up to 16% of the kinetic energy stays behind the pulse.


def participation(run):
    """Number of beads that share the kinetic energy, at the crests of inner beads."""
    energy = 0.5 * run.chain.masses * run.velocities**2
    crests = np.searchsorted(run.times, run.pulse().peak_time)
    near = [energy[crests[k], k - 3 : k + 4] for k in range(3, run.chain.beads - 3)]
    return np.array([part.sum() ** 2 / (part**2).sum() for part in near])


figure, axes = plt.subplots(figsize=(8.0, 3.8))
shared = {}
for name, each in {
    "growing beads": chain,
    "equal beads": hc.Chain.uniform(60),
    "shrinking beads": power_taper(10.0, -0.6, beads=60),
}.items():
    shared[name] = participation(hc.simulate(each, times=4000))
    axes.plot(np.arange(4, 58), shared[name], label=name)
axes.set_title("Number of beads that share the kinetic energy of the pulse")
axes.set_xlabel("bead $k$, when its velocity is largest")
axes.set_ylabel("number of beads")
axes.legend()

# %%
# Answer
# ------
#
# Yes: lists of radii are chains, functions that return a ``Pulse`` are theories, subclasses of
# ``Loss`` are laws, and arrays of a run give any quantity.  To make them available on the command
# line, follow :doc:`/how-to/extend`.

inner = slice(3, 59)
worst, worst_bca = (
    abs(pulse.compare(exact).errors("velocity")[inner]).max() for pulse in (mine, bca)
)
print(f"largest error of the theory, beads 4 to 59: {worst:.1%} "
      f"(BCA: {worst_bca:.1%})")
for name, values in shared.items():
    print(f"{name:16} {values[26]:.2f} beads share the energy when bead 30 is fastest")

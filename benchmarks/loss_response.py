"""Response of the pulse to one lossy contact: ``python benchmarks/loss_response.py``.

For exponential chains of rate s with a viscoelastic loss at one contact: the change of ln v per
strength of the loss at the next bead, two beads later and in the end; the factor per bead by which
the pulse forgets the loss; and the decay per bead and strength with the same relaxation time at all
contacts, as the sum over all contacts of the responses, and in a simulation.  About ten seconds.
"""

import numpy as np

import hertzchain as hc
from hertzchain.theory.attenuation import first_order

BEADS, CONTACT, LATE, STRENGTH = 80, 40, 55, 1e-5


def log_velocity(chain, loss):
    """Logarithms of the velocities with a loss."""
    pulse = hc.simulate(chain.replace(loss=loss), times=0, rtol=1e-13, check=False).pulse()
    return np.log(pulse.velocity)


def row(rate):
    """One line of the table."""
    chain = hc.Chain.from_radii(np.exp(rate * np.arange(BEADS)))
    free = log_velocity(chain, hc.Viscoelastic(0.0))
    # Strength of a relaxation time of 1.
    unit = (chain.stiffness / chain.masses[:-1]) ** 0.4 * np.exp(0.2 * free[:-1])
    time = STRENGTH / unit[CONTACT]
    one = [hc.Viscoelastic(time if k == CONTACT else 0.0) for k in range(BEADS - 1)]
    response = (log_velocity(chain, one) - free) / STRENGTH
    growth = np.diff(response)
    memory = (growth[LATE] / growth[LATE - 5]) ** 0.2
    # A pulse at contact LATE has met losses at all previous contacts.
    later = np.arange(CONTACT - 3, LATE + 1)
    sigma = free[CONTACT + 1] - free[CONTACT]
    past = np.exp((later - CONTACT) * (rate - 0.2 * sigma))
    terms = growth[later] * past
    fall = terms[-1] / terms[-6]
    summed = terms.sum() + terms[-1] * fall**0.2 / (1.0 - fall**0.2)
    change = log_velocity(chain, hc.Viscoelastic(time)) - free
    # The strength is smaller than without loss, since the pulse is slower.
    found = (change[CONTACT + 1] - change[CONTACT]) / STRENGTH * np.exp(-0.2 * change[CONTACT])
    print(
        f"{rate:6.2f} {response[CONTACT + 1]:8.4f} {response[CONTACT + 3]:8.4f} "
        f"{response[-5]:11.4f} {memory:6.2f} {-summed:7.4f} {-found:9.4f}",
        flush=True,
    )


if __name__ == "__main__":
    print("  rate     next    later  in the end memory  summed simulated")
    for each in (-0.08, -0.05, -0.02, 0.0, 0.02, 0.05, 0.09):
        row(each)
    wave = hc.Chain.uniform(2).replace(loss=hc.Viscoelastic(STRENGTH))
    print(f"equal beads, closed form: {float(first_order(wave, 1.0)) / STRENGTH:.4f}")

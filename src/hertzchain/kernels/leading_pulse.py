r"""The leading pulse where its crest passes a contact: rise time, momentum and kinetic energy.

The crest is at contact k at the first time :math:`s_k` at which :math:`v_k = v_{k+1}`; until
then the contact has handed over the momentum

.. math:: J_k = \sum_{j>k} m_j v_j(s_k) - \sum_{j>k} m_j v_j(0),
   \qquad \tau_k = \frac{J_k}{F_k(s_k) - F_k(0)} .

`hertzchain.simulation.leading_pulse` has the definition of the rear and the weights.
"""

from __future__ import annotations

from .compilation import compiled
from .contact_law import force, law_of, loading_force
from .dop853_interpolant import value
from .state_layout import (
    CROSSING_TIME,
    HANDED_OVER,
    LEADING_ENERGY,
    LEADING_MOMENTUM,
    RISE_TIME,
)

# The pulse has left a contact this many rise times after its crest.
LENGTH = 4.0


@compiled
def velocity_within(k, theta, first, y, dense, chain, all_beads):
    """Velocity of bead k of the chain in a step of the window that begins with bead ``first``."""
    beads = (len(y) - (len(chain) - 2 * all_beads)) // 2
    if k < first or k >= first + beads:
        return chain[all_beads + k]
    i = beads + k - first
    # Between two steps there is no interpolant.
    return y[i] if theta == 0.0 else value(i, theta, y, dense)


@compiled
def rise_of(overlap, c, setup, contacts):
    """Force of a largest overlap of contact c of the window, less the static force."""
    if contacts is None:
        return force(overlap, setup.stiffness[c], setup.exponent)
    stiffness, damping, law = setup.stiffness[c + 1], setup.damping[c + 1], law_of(c + 1, setup)
    static = loading_force(-setup.gap[c + 1], stiffness, damping, law)
    return loading_force(overlap, stiffness, damping, law) - static


@compiled
def note_leading_pulse(at, rise, theta, first, y, dense, chain, inverse_mass, crossings):
    """Record what the leading pulse is at the crossing of contact ``at`` of the chain.

    ``rise`` is the force of the contact above its static one.
    """
    beads = len(inverse_mass)
    for k in range(at + 1, beads):
        velocity = velocity_within(k, theta, first, y, dense, chain, beads)
        crossings[HANDED_OVER, at] += velocity / inverse_mass[k]
    handed_over = crossings[HANDED_OVER, at]
    if rise > 0.0 and handed_over > 0.0:
        crossings[RISE_TIME, at] = handed_over / rise
    now = crossings[CROSSING_TIME, at]
    rear, time, weight, momentum, energy = 0.0, 0.0, 1.0, 0.0, 0.0
    for k in range(beads):
        weight = 1.0
        if k < beads - 1 and crossings[CROSSING_TIME, k] != 0.0:
            if crossings[RISE_TIME, k] > 0.0:
                time = crossings[RISE_TIME, k]
                rear = max(rear, crossings[CROSSING_TIME, k] + LENGTH * time)
            if time > 0.0:
                weight = min(1.0, max(0.0, (rear - now) / time))
        velocity = velocity_within(k, theta, first, y, dense, chain, beads)
        if velocity > 0.0:
            momentum += weight * velocity / inverse_mass[k]
            energy += 0.5 * weight * velocity**2 / inverse_mass[k]
    crossings[LEADING_MOMENTUM, at] = momentum
    crossings[LEADING_ENERGY, at] = energy

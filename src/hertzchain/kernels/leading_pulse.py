r"""The leading pulse where its crest passes a contact: rise time, momentum and kinetic energy.

The crest is at contact k at the first time :math:`s_k` at which :math:`v_k = v_{k+1}`; until
then the contact has transferred the momentum

.. math:: J_k = \sum_{j>k} m_j v_j(s_k) - \sum_{j>k} m_j v_j(0),
   \qquad \tau_k = \frac{J_k}{F_k(s_k) - F_k(0)} .

`hertzchain.simulation.leading_pulse` has the definition of the rear and the weights.
"""

from __future__ import annotations

from .compilation import compiled
from .contact_law import force, law_of, loading_force
from .state_layout import (
    CROSSING_TIME,
    HANDED_OVER,
    LEADING_ENERGY,
    LEADING_MOMENTUM,
    LEFT_BY_PULSE,
    RISE_TIME,
)

# The pulse has left a contact this many rise times after the crest has passed.
LENGTH = 4.0


@compiled
def velocity_of(k, first, y, chain, all_beads):
    """Velocity of bead k of the chain, from the state of the window that begins at ``first``."""
    beads = (len(y) - (len(chain) - 2 * all_beads)) // 2
    if k < first or k >= first + beads:
        return chain[all_beads + k]
    return y[beads + k - first]


@compiled
def rise_of(overlap, c, setup, contacts):
    """Force of contact c of the window at a largest overlap, minus its static force."""
    if contacts is None:
        return force(overlap, setup.stiffness[c], setup.exponent)
    stiffness, damping, law = setup.stiffness[c + 1], setup.damping[c + 1], law_of(c + 1, setup)
    static = loading_force(-setup.gap[c + 1], stiffness, damping, law)
    return loading_force(overlap, stiffness, damping, law) - static


@compiled
def skip_beads_left(time, counts, beads, crossings):
    """Count the beads that the pulse has left by ``time``; returns the last of their rise times."""
    k = counts[LEFT_BY_PULSE]
    last = k
    while last > 0 and not crossings[RISE_TIME, last - 1] > 0.0:
        last -= 1
    rise_time = crossings[RISE_TIME, last - 1] if last > 0 else 0.0
    while k < beads - 1 and crossings[CROSSING_TIME, k] != 0.0:
        own = crossings[RISE_TIME, k]
        if own > 0.0:
            if crossings[CROSSING_TIME, k] + LENGTH * own > time:
                break
            rise_time = own
        if rise_time == 0.0:
            break
        k += 1
    counts[LEFT_BY_PULSE] = k
    return rise_time


@compiled
def note_leading_pulse(at, rise, first, start, counts, y, chain, inverse_mass, crossings):
    """Record rise time, momentum and energy of the leading pulse when its crest is at a contact.

    ``at`` is the contact, ``rise`` its force minus its static force, ``start`` the time at the
    start of the step, and ``y`` the state of the window at that moment.
    """
    beads = len(inverse_mass)
    end = first + (len(y) - (len(chain) - 2 * beads)) // 2
    for k in range(at + 1, end):
        velocity = velocity_of(k, first, y, chain, beads)
        crossings[HANDED_OVER, at] += velocity / inverse_mass[k]
    handed_over = crossings[HANDED_OVER, at]
    if rise > 0.0 and handed_over > 0.0:
        crossings[RISE_TIME, at] = handed_over / rise
    now = crossings[CROSSING_TIME, at]
    rear, weight, momentum, energy = 0.0, 1.0, 0.0, 0.0
    time = skip_beads_left(start, counts, beads, crossings)
    for k in range(counts[LEFT_BY_PULSE], end):
        weight = 1.0
        if k < beads - 1 and crossings[CROSSING_TIME, k] != 0.0:
            if crossings[RISE_TIME, k] > 0.0:
                time = crossings[RISE_TIME, k]
                rear = max(rear, crossings[CROSSING_TIME, k] + LENGTH * time)
            if time > 0.0:
                weight = min(1.0, max(0.0, (rear - now) / time))
        velocity = velocity_of(k, first, y, chain, beads)
        if velocity > 0.0:
            momentum += weight * velocity / inverse_mass[k]
            energy += 0.5 * weight * velocity**2 / inverse_mass[k]
    crossings[LEADING_MOMENTUM, at] = momentum
    crossings[LEADING_ENERGY, at] = energy

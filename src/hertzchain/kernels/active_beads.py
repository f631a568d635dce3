r"""Beads to integrate: those between the beads in free flight and the beads at rest.

Ahead of a pulse the beads are at rest; behind it many have separated permanently, or their
contacts are idle::

      constant velocity        the window                 at rest
      <-o  <-o   <-o  |  o o O O o o o o o o  |  o o o o o o o o
                      |    margin      margin |

A contact is *idle* if its beads separate.  It is also idle if its beads approach more slowly than
the steps resolve (a fraction of the tolerance times the largest speed in the window) and the
contact stores less energy than motion at that speed.  Behind a pulse in equal beads, all contacts
are idle.

If no static forces act, only the beads of the window are integrated.  The state stores where and
when each bead behind the window left it; from then on the bead has a constant velocity.  Beads
behind the window that meet at less than the resolved speed collide as hard spheres, so that energy
and momentum are conserved.  A bead returns to the window when the contact between it and the window
is no longer idle (because a pulse returns), or when beads behind the window meet at a higher speed
or meet a wall.  The window is integrated like a separate chain.  Its ends belong to the state, so
that a resumed run is the same as an uninterrupted one.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types
from numba.extending import overload

from .compilation import OPTIONS, compiled
from .contact_law import force, has_modes, law_of
from .driving import NOTHING
from .forces import (
    Contacts,
    DefaultChain,
    GeneralChain,
    copy,
    largest_size,
    overlap_and_closing,
)
from .state_layout import FLIGHT_POSITION, FLIGHT_TIME

# A bead is at rest if its displacement and speed are less than this fraction of the largest ones
# of the BEHIND beads behind it.  The foot of a pulse decays doubly exponentially, so that no digit
# of a result depends on this fraction.
QUIET, BEHIND = 1e-60, 3
# Relative motion is ignored below this fraction of the tolerance times the largest speed.  Behind a
# pulse, errors of the steps cause relative speeds of a tenth of this value.
NOISE = 0.1
# Beads remain behind the window until one approaches the next at more than this many times the
# ignored speed.
STAY = 4.0
# Average number of collisions per bead behind the window, at one time, after which all beads return
# to the window.
MAX_COLLISIONS = 100
# Beads at rest or in free flight that are kept at each end of the window; number of beads by which
# the window grows or shrinks.
MARGIN, STRIDE = 4, 8
WITHOUT_CACHE: Any = OPTIONS | {"cache": False, "no_cpython_wrapper": True}


@compiled
def trimmed(setup, contacts):
    """Whether the window may omit beads on the left and on the right.

    Under static forces no bead may be omitted: the rounding error of the sum of these forces moves
    even beads that are in equilibrium.
    """
    if contacts is None:
        return True, True
    for k in range(len(setup.body_force)):
        if setup.body_force[k] != 0.0:
            return False, False
    for c in range(len(setup.gap)):
        if setup.gap[c] < 0.0 and setup.stiffness[c] > 0.0:
            return False, False
    return setup.drive == NOTHING, True


@compiled
def moves(y, beads, k):
    """Whether bead k is not at rest."""
    speed, shift = 0.0, 0.0
    for j in range(max(k - BEHIND, 0), k):
        speed = max(speed, abs(y[beads + j]))
        shift = max(shift, abs(y[j]))
    return abs(y[beads + k]) > QUIET * speed or abs(y[k]) > QUIET * shift


@compiled
def unresolved_speed(y, beads, rtol, setup, contacts):
    """Relative speed below which motion is ignored; negative if no motion may be ignored.

    Beads in free flight behind a pulse may be much faster than the pulse and are not considered.
    If steps are implicit, the overlaps cannot be computed from the positions.
    """
    if contacts is not None and setup.law.implicit:
        return -1.0
    first = 0
    while first < beads - 1:
        overlap, closing = overlap_and_closing_of(first + 1, y, setup, contacts)
        if not (overlap < 0.0 and closing < 0.0):
            break
        first += 1
    return NOISE * rtol * largest_size(y[beads + first : 2 * beads])


@compiled
def contact_numbers(c, setup, contacts):
    """Stiffness, exponent and largest inverse mass of contact c, and whether it has no modes.

    Contact c joins beads c - 1 and c (0-based); contact 0 is the contact with the left wall.
    """
    lighter = setup.inverse_mass[c]
    if c > 0:
        lighter = max(lighter, setup.inverse_mass[c - 1])
    if contacts is None:
        return setup.stiffness[c - 1] if c > 0 else 0.0, setup.exponent, lighter, True
    return setup.stiffness[c], law_of(c, setup).exponent, lighter, not has_modes(setup.law)


@compiled
def idle(overlap, closing, unresolved, numbers):
    """Whether a contact has no effect that the steps resolve."""
    if overlap < 0.0 and closing < 0.0:
        return True
    if unresolved < 0.0 or not closing <= unresolved:
        return False
    stiffness, exponent, lighter, elastic = numbers
    if overlap < 0.0 or (overlap == 0.0 and closing <= 0.0):
        return True
    # A contact whose mode depends on its history may leave the window only if it is open.
    return elastic and force(overlap, stiffness, exponent) * overlap * lighter <= unresolved**2


@compiled
def idle_overlap(unresolved, numbers):
    """Largest overlap of an idle contact."""
    stiffness, exponent, lighter, elastic = numbers
    if not elastic:
        return 0.0
    return (unresolved**2 / (lighter * stiffness)) ** (1.0 / (exponent + 1.0))


@compiled
def idle_time(overlap, closing, unresolved, numbers):
    """Time for which a contact behind the window, between beads of constant velocity, is idle."""
    if closing <= 0.0:
        return np.inf
    if not closing <= unresolved:
        return 0.0
    return max(0.0, (idle_overlap(unresolved, numbers) - overlap) / closing)


@compiled
def overlap_and_closing_of(c, y, setup, contacts):
    """Overlap of contact c of the undriven chain ``setup``, and its rate of change."""
    beads = len(setup.inverse_mass)
    if contacts is None:
        return y[c - 1] - y[c], y[beads + c - 1] - y[beads + c]
    return overlap_and_closing(c, y, beads, setup.gap[c], (0.0, 0.0, 0.0))


@compiled
def contact_is_idle(c, y, unresolved, setup, contacts):
    """Whether contact c of the chain ``setup`` is idle; a contact with an absent wall is idle."""
    numbers = contact_numbers(c, setup, contacts)
    if c == 0 and numbers[0] == 0.0:
        return True
    overlap, closing = overlap_and_closing_of(c, y, setup, contacts)
    return idle(overlap, closing, unresolved, numbers)


@compiled
def earliest_contact(y, first, last, unresolved, time, setup, contacts):
    """Time until which contacts ``first`` to ``last`` - 1 are idle."""
    earliest = np.inf
    for c in range(first, last):
        numbers = contact_numbers(c, setup, contacts)
        if c > 0 or numbers[0] > 0.0:
            overlap, closing = overlap_and_closing_of(c, y, setup, contacts)
            earliest = min(earliest, time + idle_time(overlap, closing, unresolved, numbers))
    return earliest


@compiled
def collide_behind(y, low, time, unresolved, setup, contacts, flights):
    """Collide beads behind ``low`` that meet at less than the resolved speed, as hard spheres.

    Returns whether all collisions could be computed.
    """
    beads, inverse_mass = len(setup.inverse_mass), setup.inverse_mass
    c, left = 1, MAX_COLLISIONS * low
    while c < low:
        overlap, closing = overlap_and_closing_of(c, y, setup, contacts)
        if overlap > 0.0 and 0.0 < closing <= STAY * unresolved:
            numbers = contact_numbers(c, setup, contacts)
            if numbers[3] and overlap > idle_overlap(unresolved, numbers):
                passed_on = 2.0 * closing / (inverse_mass[c - 1] + inverse_mass[c])
                y[beads + c - 1] -= passed_on * inverse_mass[c - 1]
                y[beads + c] += passed_on * inverse_mass[c]
                leave_behind(y, c - 1, c + 1, time, flights)
                left -= 1
                if left == 0:
                    return False
                c = max(c - 1, 1)
                continue
        c += 1
    return True


@compiled
def leave_behind(y, first, last, time, flights):
    """Record where and when beads ``first`` to ``last`` - 1 leave the window."""
    for k in range(first, last):
        flights[FLIGHT_POSITION, k] = y[k]
        flights[FLIGHT_TIME, k] = time


@compiled
def place_behind(y, beads, first, last, time, flights):
    """Compute the positions of beads ``first`` to ``last`` - 1, behind the window, at ``time``."""
    for k in range(first, last):
        y[k] = flights[FLIGHT_POSITION, k] + (time - flights[FLIGHT_TIME, k]) * y[beads + k]


@compiled
def bounds(y, setup, contacts, first, all_beads, trim, unresolved):
    """First bead of the next window and the one after its last.

    ``y`` and ``setup`` are those of the present window, which begins with bead ``first``.
    """
    beads = len(setup.inverse_mass)
    active = 0
    if trim[0] and (first > 0 or contact_is_idle(0, y, unresolved, setup, contacts)):
        while active < beads - 1 and contact_is_idle(active + 1, y, unresolved, setup, contacts):
            active += 1
    low = max(0, (first + active - MARGIN) // STRIDE * STRIDE)
    high = all_beads
    if trim[1]:
        last = beads - 1
        while last > 0 and not moves(y, beads, last):
            last -= 1
        high = (first + last + MARGIN + STRIDE) // STRIDE * STRIDE
    # If no bead will ever touch another, all are in free flight or at rest, but one step is needed.
    if low >= high:
        low = max(0, high - STRIDE)
    return low, min(high, all_beads)


@compiled
def window_too_small(
    time, y_new, low, all_beads, behind, unresolved, flights, setup, contacts, numbers
):  # fmt: skip
    """Whether a step moved a bead at an end of the window, which must not move.

    ``behind`` is the velocity of the bead behind the window, ``numbers`` are the
    `contact_numbers` of the contact with it.
    """
    beads = len(setup.inverse_mass)
    if low > 0:
        left = flights[FLIGHT_POSITION, low - 1] + (time - flights[FLIGHT_TIME, low - 1]) * behind
        gap = setup.gap[0] if contacts is not None else 0.0
        if not idle(left - y_new[0] - gap, behind - y_new[beads], unresolved, numbers):
            return True
    return low + beads < all_beads and moves(y_new, beads, beads - 1)


def part_of(setup, contacts, low, high, ends):
    """Equation of motion of the beads of a window; ``ends`` is scratch, (2, N + 1).

    In compiled code the choice is made when the caller is compiled; this body runs only if
    compilation is disabled (NUMBA_DISABLE_JIT=1).
    """
    if contacts is None:
        return default_part(setup, low, high)
    return general_part(setup, low, high, ends)


@overload(part_of, jit_options=WITHOUT_CACHE)
def _(setup, contacts, low, high, ends):  # noqa: ARG001
    if isinstance(contacts, types.NoneType):
        return lambda setup, contacts, low, high, ends: default_part(setup, low, high)  # noqa: ARG005
    return lambda setup, contacts, low, high, ends: general_part(setup, low, high, ends)  # noqa: ARG005


@compiled
def default_part(setup, low, high):
    """`part_of` for a default chain."""
    return DefaultChain(
        setup.inverse_mass[low:high], setup.stiffness[low : high - 1], setup.exponent
    )


@compiled
def general_part(setup, low, high, ends):
    """`part_of` for a general chain."""
    last = high - low
    stiffness, damping = ends[0, : last + 1], ends[1, : last + 1]
    copy(setup.stiffness[low : high + 1], stiffness)
    copy(setup.damping[low : high + 1], damping)
    # The contacts with beads outside the window are open.
    if low > 0:
        stiffness[0] = damping[0] = 0.0
    if high < len(setup.inverse_mass):
        stiffness[last] = damping[last] = 0.0
    return GeneralChain(
        setup.inverse_mass[low:high], stiffness, setup.exponent, setup.gap[low : high + 1],
        damping, setup.law, setup.laws[low : high + 1], setup.body_force[low:high],
        setup.drive, setup.piece_starts, setup.pieces,
    )  # fmt: skip


def contacts_within(contacts, low, high):
    """Modes and history of the contacts of a window, or `None`; as `part_of`."""
    return None if contacts is None else general_contacts_within(contacts, low, high)


@overload(contacts_within, jit_options=WITHOUT_CACHE)
def _(contacts, low, high):  # noqa: ARG001
    if isinstance(contacts, types.NoneType):
        return lambda contacts, low, high: None  # noqa: ARG005
    return lambda contacts, low, high: general_contacts_within(contacts, low, high)


@compiled
def general_contacts_within(contacts, low, high):
    """`contacts_within` for a general chain."""
    return Contacts(
        contacts.mode[low : high + 1], contacts.largest[low : high + 1],
        contacts.force[low : high + 1], contacts.last_force[low : high + 1], contacts.scratch,
        contacts.powers, contacts.implicit, contacts.on_positions,
    )  # fmt: skip


@compiled
def take_out(y, all_beads, low, high, near):
    """Copy the positions and velocities of the beads of a window, and the accumulators."""
    beads = high - low
    copy(y[low:high], near[:beads])
    copy(y[all_beads + low : all_beads + high], near[beads : 2 * beads])
    copy(y[2 * all_beads :], near[2 * beads :])


@compiled
def put_back(near, all_beads, low, high, y):
    """Copy the state of a window back into that of the chain, the reverse of `take_out`."""
    beads = high - low
    copy(near[:beads], y[low:high])
    copy(near[beads : 2 * beads], y[all_beads + low : all_beads + high])
    copy(near[2 * beads :], y[2 * all_beads :])

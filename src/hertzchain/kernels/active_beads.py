r"""Which beads a step is taken for: those between the ones that fly and the ones that rest.

Ahead of a pulse the beads are at rest; behind it many have lost contact for good::

      flying, exactly          the window                 at rest
      <-o  <-o   <-o  |  o o O O o o o o o o  |  o o o o o o o o
                      |    margin      margin |

Where nothing is held together by static forces, only the beads between are integrated; those
that fly move on by velocity times step.  The window is a chain of its own, with arrays that are
parts of the chain's.  Which beads are in it follows from their positions and velocities alone, so
that a run goes on from a saved state as if it had not stopped.
"""

from __future__ import annotations

from typing import Any

from numba import types
from numba.extending import overload

from .compilation import OPTIONS, compiled
from .contact_law import laws_within
from .driving import NOTHING
from .forces import Contacts, DefaultChain, GeneralChain, copy, overlap_and_closing

# A bead rests that has moved less, and is slower, than this part of those a few beads behind;
# the foot of a pulse falls off doubly exponentially, so that no digit depends on it.
QUIET, BEHIND = 1e-60, 3
# Beads kept at both ends of the window that rest or fly, and the number it grows or shrinks by.
MARGIN, STRIDE = 4, 8
WITHOUT_CACHE: Any = {name: OPTIONS[name] for name in OPTIONS if name != "cache"}


@compiled
def trimmed(setup, contacts):
    """Whether the window may leave beads out on the left and on the right.

    Under static forces beads at rest are pushed by what is left of their sum in rounding.
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
def in_free_flight(y, beads, k, setup, contacts):
    """Whether bead k has lost the next one for good, as far as the two know."""
    if contacts is None:
        return y[k] < y[k + 1] and y[beads + k] < y[beads + k + 1]
    overlap, closing = overlap_and_closing(k + 1, y, beads, setup.gap[k + 1], (0.0, 0.0, 0.0))
    return overlap < 0.0 and closing < 0.0


@compiled
def bounds(y, setup, contacts, first, all_beads, trim):
    """First bead of the window and the one after its last, of all beads or from a window."""
    beads = len(setup.inverse_mass)
    active = 0
    if trim[0] and (first > 0 or leaves_wall(y, beads, setup, contacts)):
        while active < beads - 1 and in_free_flight(y, beads, active, setup, contacts):
            active += 1
    low = max(0, (first + active - MARGIN) // STRIDE * STRIDE)
    high = all_beads
    if trim[1]:
        last = beads - 1
        while last > 0 and not moves(y, beads, last):
            last -= 1
        high = (first + last + MARGIN + STRIDE) // STRIDE * STRIDE
    return low, min(high, all_beads)


@compiled
def leaves_wall(y, beads, setup, contacts):
    """Whether the first bead will not meet a wall."""
    if contacts is None or setup.stiffness[0] == 0.0:
        return True
    overlap, closing = overlap_and_closing(0, y, beads, setup.gap[0], (0.0, 0.0, 0.0))
    return overlap < 0.0 and closing < 0.0


@compiled
def window_too_small(y, y_new, low, high, all_beads):
    """Whether a step moved what it must not: a bead at the end of the window."""
    beads = high - low
    if low > 0 and y_new[beads] != y[beads]:
        return True
    return high < all_beads and moves(y_new, beads, beads - 1)


def part_of(setup, contacts, low, high, ends):
    """The equation of the beads of a window; ``ends`` is scratch, (2, N + 1).

    In compiled code the one or the other is chosen when the caller is compiled; this is what runs
    when numba is told to compile nothing (NUMBA_DISABLE_JIT=1).
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
    """`part_of` a plain chain."""
    return DefaultChain(
        setup.inverse_mass[low:high], setup.stiffness[low : high - 1], setup.exponent
    )


@compiled
def general_part(setup, low, high, ends):
    """`part_of` any other chain."""
    last = high - low
    stiffness, damping = ends[0, : last + 1], ends[1, : last + 1]
    copy(setup.stiffness[low : high + 1], stiffness)
    copy(setup.damping[low : high + 1], damping)
    # The contacts with beads out of the window are open.
    if low > 0:
        stiffness[0] = damping[0] = 0.0
    if high < len(setup.inverse_mass):
        stiffness[last] = damping[last] = 0.0
    return GeneralChain(
        setup.inverse_mass[low:high], stiffness, setup.exponent, setup.gap[low : high + 1],
        damping, setup.law, laws_within(setup.laws, low, high), setup.body_force[low:high],
        setup.drive, setup.piece_starts, setup.pieces,
    )  # fmt: skip


@compiled
def contacts_within(contacts, low, high):
    """What the contacts of a window remember."""
    if contacts is None:
        return None
    return Contacts(
        contacts.mode[low : high + 1], contacts.largest[low : high + 1],
        contacts.force[low : high + 1], contacts.last_force[low : high + 1], contacts.scratch,
        contacts.powers, contacts.implicit, contacts.search,
    )  # fmt: skip


@compiled
def take_out(y, all_beads, low, high, near):
    """Positions, velocities and ledger of the beads of a window."""
    beads = high - low
    copy(y[low:high], near[:beads])
    copy(y[all_beads + low : all_beads + high], near[beads : 2 * beads])
    copy(y[2 * all_beads :], near[2 * beads :])


@compiled
def put_back(near, all_beads, low, high, y):
    """The reverse of `take_out`."""
    beads = high - low
    copy(near[:beads], y[low:high])
    copy(near[beads : 2 * beads], y[all_beads + low : all_beads + high])
    copy(near[2 * beads :], y[2 * all_beads :])

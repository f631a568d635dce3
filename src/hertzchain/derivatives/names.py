"""Names of the quantities that have a gradient."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from ..chain.bead_names import bead_number, with_bead_numbers
from ..chain.chain import Chain
from ..errors import InputError, unknown_name_error
from ..pulse.quantities import QUANTITIES
from ..pulse.quantity_names import full_name
from ..simulation.body_peak import not_on_a_wall
from ..simulation.end_forces import static_forces_around
from ..validation.numbers import whole_number

PULSE: Final = (
    "velocity", "momentum", "energy", "peak_time", "arrival", "residence", "peak_overlap",
    "peak_force",
)  # fmt: skip
WALL: Final = (
    "peak", "maxima", "peak_time", "impulse", "first_contact_impulse", "impulse_of_impact",
    "duration",
)  # fmt: skip
BODY: Final = ("peak", "acceleration")
OF_BODY: Final[tuple[str, ...]] = tuple(f"body_force.{each}" for each in BODY)
DURATION: Final = "body_force.duration"
SENSOR: Final = ("first_maximum", "first_maximum_time", "largest", "largest_time", "impulse")
FINAL: Final = ("velocity", "position")
# At the largest forward velocity of a bead in the whole run.
BEAD: Final = ("largest_velocity", "largest_momentum", "largest_energy")
ENERGY: Final = ("kinetic", "forward", "backward", "contacts", "walls")
KNOWN: Final = (
    *(f"pulse.{each}" for each in PULSE),
    *(f"wall_force.{each}" for each in WALL),
    *(f"left_wall_force.{each}" for each in WALL),
    *OF_BODY,
    *(f"sensor.{each}" for each in SENSOR),
    *(f"final.{each}" for each in FINAL),
    *(f"bead.{each}" for each in BEAD),
    *(f"energy.{each}" for each in ENERGY),
)
NEED_END: Final = (
    "sensor.impulse", "sensor.largest", "sensor.largest_time",
    *OF_BODY,
)  # fmt: skip
# Times of maxima need rates of forces; the stored energy depends on whether a contact pushes.
NOT_DAMPED: Final = (
    "pulse.peak_time", "wall_force.peak_time", "left_wall_force.peak_time",
    "sensor.first_maximum_time", "sensor.largest_time", "energy.contacts", "energy.walls",
)  # fmt: skip


@dataclass(frozen=True)
class Name:
    """A quantity: group, item, and the bead if the quantity belongs to one."""

    group: str
    item: str
    bead: int | None

    @property
    def quantity(self) -> str:
        """Name in the table of quantities, of an item at a bead."""
        return self.item.removeprefix("largest_")

    def __str__(self) -> str:
        at = "" if self.bead is None else f"@{self.bead}"
        return f"{self.group}.{self.item}{at}"


def parse(chain: Chain, given: object, bead: int | str | None, until: float | None) -> Name:
    """A quantity of a chain; raises `InputError` if the chain does not have it."""
    given = with_bead_numbers(chain, given) if isinstance(given, str) else given
    bead = bead_number(chain, bead) if isinstance(bead, str) else bead
    text, at, number = given.partition("@") if isinstance(given, str) else (given, "", "")
    text = full_name(text) if isinstance(text, str) else text
    text = f"pulse.{text}" if text in PULSE else text
    _check_known(text)
    group, item = str(text).split(".")
    most = QUANTITIES[item].count(chain.beads) if group == "pulse" else chain.beads
    if at and not (number.isdigit() or number == "last"):
        wall = "; that on the wall is wall_force.peak" if number == "wall" else ""
        raise InputError(f"the bead of {given!r} must be a number or 'last'{wall}")
    last = most if number == "last" else bead
    at_bead = int(number) if number.isdigit() else last
    if group in ("wall_force", "left_wall_force"):
        side = "right" if group == "wall_force" else "left"
        if getattr(chain, f"{side}_wall") is None:
            raise InputError(
                f"{text} does not exist: the {side} end of this chain is free; use "
                f"chain.replace({side}_wall=Wall())"
            )
        at_bead = None
        if item == "duration" and chain.static_state.forces[-1 if side == "right" else 0]:
            raise InputError(
                f"{text} has no gradient under a static force of gravity or precompression; use "
                f"{group}.peak or {group}.impulse"
            )
    elif group == "body_force":
        at_bead = None
        _check_body(chain, str(text))
    elif group in ("pulse", "sensor", "final", "bead"):
        if at_bead is None:
            raise InputError(f"{text} belongs to a bead; give bead, or '{text}@{chain.beads}'")
        at_bead = whole_number(f"bead of {text}", at_bead, least=1, most=most)
        if group == "sensor" and static_forces_around(chain, at_bead):
            raise InputError(
                f"{text} has no gradient in an end bead on which a force of precompression acts; "
                "use the sensor in another bead"
            )
    else:
        at_bead = None
    if until is None and (group in ("final", "energy") or f"{group}.{item}" in NEED_END):
        raise InputError(f"{text} depends on the end of the run; give until")
    if until is None and chain.gravity != 0.0 and group != "pulse":
        raise InputError(f"{text} of a chain under gravity has no natural end; give until")
    if until is None and group == "bead" and (chain.right_wall is not None or chain.precompression):
        raise InputError(
            f"{text} has no natural end in a chain with a right wall or precompression, because "
            "waves return; give until"
        )
    if not chain.lossless and f"{group}.{item}" in NOT_DAMPED:
        raise InputError(
            f"{text} has no gradient in a chain with losses, only in elastic chains; use a force, "
            "a velocity or an arrival"
        )
    return Name(group, item, at_bead)


def _check_known(text: Any) -> None:
    """Raise `InputError` if a quantity does not exist or has no gradient."""
    if text == DURATION:
        raise InputError(
            f"{DURATION} has no gradient, because it jumps where the force between two pulses "
            f"falls below a tenth of the largest; use {' or '.join(OF_BODY)}, or compare chains"
        )
    if text not in KNOWN:
        raise unknown_name_error("quantity", text, KNOWN)


def _check_body(chain: Chain, text: str) -> None:
    """Raise `InputError` if a chain has no force on a last body with a gradient."""
    if chain.right_wall is not None:
        raise InputError(not_on_a_wall(text))
    if chain.static_state.forces.any():
        raise InputError(
            f"{text} has no gradient under a static force of gravity or precompression; use the "
            "velocity of the body, such as velocity@last"
        )

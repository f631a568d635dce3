"""Methods of `hertzchain.Chain` that join chains, cut pieces out of them and reverse them."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np

from ..collision import HERTZ_EXPONENT
from ..errors import InputError
from ..validation.keywords import checked_arguments
from .fields import ChainFields
from .laws import Loss
from .mass_and_stiffness import contact_stiffness
from .per_contact import LINEAR, MaterialPairs, given_laws

C = TypeVar("C", bound=ChainFields)
# Features of the set-up, which must agree where chains are joined.
COMMON = ("gravity", "precompression", "held_by")


def part(self: C, beads: slice) -> C:
    """Return a piece of the chain: ``chain[10:]`` are all beads but the first ten.

    Array indices start at 0: ``chain[10:30]`` has beads 11 to 30.  What belongs to an end
    that is cut off (its wall, the strikers, a cap, a drive) is dropped.  If none of the remaining
    beads moves, the first one has the velocity that bead 1 had.

    Parameters
    ----------
    beads : slice
        Neighbouring beads; ``chain[::-1]`` is `Chain.reversed`.

    Raises
    ------
    InputError
        If the slice has no bead or a step, or a scaled chain has features whose units
        would change, because its first bead is not of radius 1.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.Chain.from_radii([8.0, 4.0, 2.0, 1.0])[1:].radii
    array([1.  , 0.5 , 0.25])
    """
    _require_slice(beads)
    if beads == slice(None, None, -1):
        return reversed_beads(self)
    try:
        start, stop, step = beads.indices(self.beads)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"a piece of a chain has whole numbers, such as chain[10:20], got [{_shown(beads)}]: "
            f"{error}"
        ) from None
    if step != 1 or stop <= start:
        raise InputError(
            "a piece of a chain has at least one bead, without a step, such as chain[10:] or "
            f"chain[:20]; [{_shown(beads)}] has {len(range(start, stop, step))} of "
            f"{self.beads} beads" + ("" if step == 1 else f", and a step of {step}")
        )
    if 0 < start < self.strikers or 0 < self.strikers >= stop:
        raise InputError(
            f"the chain begins with {self.strikers} strikers: keep all of them and a bead, or cut "
            "off all of them"
        )
    changes = cut(self, start, stop)
    if start > 0:
        changes |= {"left_wall": None, "drive": None, "strikers": 0, "striker_properties": ()}
    if stop < self.beads:
        changes |= {"right_wall": None, "cap": None}
    if "velocities" in self.given and start > 0 and not changes["velocities"].any():
        changes["velocities"] = np.zeros(stop - start)
        changes["velocities"][0] = self.velocities[0]
    return _rescaled(self, changes)


@checked_arguments("reversed")
def reversed_beads(self: C) -> C:
    """Return the chain with its beads in reverse order, struck at what was its last bead.

    Masses, materials, gaps and contact laws move with the beads; walls, gravity, drive and the
    velocity of the impact stay where they are.

    Raises
    ------
    InputError
        If there are strikers or a cap, or beads other than bead 1 move: reverse the chain first.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.Chain.from_radii([1.0, 2.0, 4.0]).reversed().radii
    array([1.  , 0.5 , 0.25])
    """
    if self.strikers or self.cap is not None or self.velocities[1:].any():
        raise InputError(
            "a chain with strikers, a cap or several moving beads cannot be reversed: call "
            "reversed first, then struck_by, with_cap or replace(velocities=...)"
        )
    changes = {
        name: value[::-1] for name, value in cut(self, 0, self.beads).items() if name != "scatter"
    }
    if "velocities" in changes:
        changes["velocities"] = self.velocities
    if self.scatter is not None:
        changes["scatter"] = self.scatter.with_radii(self.scatter.radii[::-1])
    return _rescaled(self, changes)


def joined(self: C, other: C) -> C:
    """Return both chains as one: ``one + other`` has the beads of ``one``, then the others.

    The chains touch.  The first bead of each scaled chain has the radius 1, so that
    ``Chain.uniform(3) + Chain.from_radii([2, 2])`` has five equal beads; give all scaled radii in
    one call of `Chain.from_radii` instead.  The impact on ``other`` is dropped; other initial
    velocities are kept.  Gravity and precompression must agree.

    Parameters
    ----------
    other : Chain
        Chain of the same units, without a left wall, strikers and a drive.  A cap at its end is
        kept; ``one`` must have none.

    Raises
    ------
    InputError
        If there is a wall between the chains, only one of them has materials or SI units, static
        forces differ, or the contact between them does not follow from radii and materials.

    Examples
    --------
    >>> import hertzchain as hc
    >>> taper = hc.Chain.tapered(first="10 mm", last="5 mm", beads=20, material="steel-316")
    >>> taper + hc.Chain.from_materials("5 mm", "ptfe", beads=10)
    Chain(30 beads of steel-316 and ptfe, diameters 20 mm to 10 mm, impact at 1 m/s)
    """
    if not isinstance(other, ChainFields):
        return NotImplemented
    _check_joint(self, other)
    changes: dict[str, Any] = {
        "radii": np.concatenate((self.radii, other.radii)),
        "right_wall": other.right_wall,
        "cap": other.cap,
    }
    if self.materials is not None and other.materials is not None:
        changes["materials"] = self.materials + other.materials
    if self.scatter is not None and other.scatter is not None and self.scatter.like(other.scatter):
        nominal = np.concatenate((self.scatter.radii, other.scatter.radii))
        changes["scatter"] = self.scatter.with_radii(nominal)
    given = self.given | other.given
    if "masses" in given:
        changes["masses"] = np.concatenate((self.masses, other.masses))
    if "stiffness" in given:
        changes["stiffness"] = [*self.stiffness, _joint_stiffness(self, other), *other.stiffness]
    if "gaps" in given:
        changes["gaps"] = np.concatenate((self.gaps, [0.0], other.gaps))
    moving = other.velocities if "velocities" in other.features else np.zeros(other.beads)
    if "velocities" in self.given or moving.any():
        changes["velocities"] = np.concatenate((self.velocities, moving))
    changes["exponent"] = _joined_values("exponents", self, other, self.exponent, other.exponent)
    changes["loss"] = _joined_values("losses", self, other, self.loss, other.loss)
    return self.replace(**changes)


def _shown(beads: slice) -> str:
    ends = ("" if each is None else str(each) for each in (beads.start, beads.stop))
    return ":".join(ends) + ("" if beads.step is None else f":{beads.step}")


def _require_slice(beads: object) -> None:
    if not isinstance(beads, slice):
        raise InputError(
            f"a bead is not a chain: use a slice such as chain[10:], or chain.radii[{beads!r}] for "
            "the radius of one bead"
        )


def cut(chain: ChainFields, start: int, stop: int) -> dict[str, Any]:
    """Fields of a part of the beads that have one value per bead or contact."""
    changes: dict[str, Any] = {"radii": chain.radii[start:stop]}
    if chain.scatter is not None:
        changes["scatter"] = chain.scatter.with_radii(chain.scatter.radii[start:stop])
    if chain.materials is not None:
        changes["materials"] = chain.materials[start:stop]
    for name in ("masses", "velocities"):
        if name in chain.given:
            changes[name] = getattr(chain, name)[start:stop]
    for name in ("stiffness", "gaps"):
        if name in chain.given:
            changes[name] = getattr(chain, name)[start : stop - 1]
    if isinstance(chain.exponent, np.ndarray):
        changes["exponent"] = chain.exponent[start : stop - 1]
    elif chain.exponent == LINEAR and stop - start == 1:
        # That of the pad between two bodies.
        changes["exponent"] = HERTZ_EXPONENT
    if isinstance(chain.loss, tuple):
        changes["loss"] = chain.loss[start : stop - 1]
    return changes


def _rescaled(chain: C, changes: dict[str, Any]) -> C:
    """Replace the beads; scaled radii in units of another first one, if no other unit changes."""
    radii = changes["radii"]
    first = float(radii[changes.get("strikers", chain.strikers)])
    if chain.units == "scaled" and first not in (1.0, chain.radii[chain.strikers]):
        left, right = (
            changes.get(f"{end}_wall", getattr(chain, f"{end}_wall")) for end in ("left", "right")
        )
        present = {
            **{name: name in changes for name in ("masses", "stiffness", "gaps")},
            "gravity": chain.gravity != 0.0,
            "precompression": chain.precompression > 0.0,
            "drive": changes.get("drive", chain.drive) is not None,
            "cap": changes.get("cap", chain.cap) is not None,
            "wall": any(
                each and (each.stiffness or each.gap or each.loss) for each in (left, right)
            ),
            "loss": any(map(_has_scale, given_laws(chain.loss))),
        }
        scaled = [name for name, there in present.items() if there]
        if scaled:
            raise InputError(
                f"the first of these beads has a radius of {first:g}, which would change the units "
                f"of the scaled chain and with them its {', '.join(scaled)}; set "
                "these afterwards, or build the chain in SI units"
            )
        with np.errstate(over="ignore", under="ignore"):
            changes["radii"] = radii / first
            if "scatter" in changes:
                nominal = changes["scatter"].radii / first
                changes["scatter"] = changes["scatter"].with_radii(nominal)
    return chain.replace(**changes)


def _has_scale(law: Loss) -> bool:
    return any(each.dimension for each in law.parameters().values())


def _check_joint(one: ChainFields, other: ChainFields) -> None:
    if one.units != other.units or (one.materials is None) != (other.materials is None):
        raise InputError(
            "only chains of the same kind can be joined: both of materials, both in SI units or "
            f"both scaled; these are {one} and {other}"
        )
    inner = {
        "right_wall of the first": one.right_wall, "cap of the first": one.cap,
        "left_wall of the second": other.left_wall,
        "strikers of the second": other.strikers, "drive of the second": other.drive,
    }  # fmt: skip
    present = [name for name, value in inner.items() if value]
    if present:
        raise InputError(f"chains are joined where nothing is between them: omit the "
                         f"{' and the '.join(present)} chain")  # fmt: skip
    for name in COMMON:
        if getattr(one, name) != getattr(other, name):
            raise InputError(
                f"{name} of joined chains must be equal, got {getattr(one, name)!r} and "
                f"{getattr(other, name)!r}; set it after joining them"
            )


def _joint_stiffness(one: ChainFields, other: ChainFields) -> float:
    """Hertz stiffness of the contact between two chains."""
    if one.contact_exponents[-2] != HERTZ_EXPONENT or (one.materials is None and not one.scaled):
        raise InputError(
            "the stiffness of the contact between the chains does not follow from radii and "
            "materials; build one chain, with stiffness for each contact"
        )
    kinds = None
    if one.materials is not None and other.materials is not None:
        kinds = (one.materials[-1], other.materials[0])
    ends = np.array([one.radii[-1], other.radii[0]])
    return float(contact_stiffness(ends, kinds, np.array([HERTZ_EXPONENT]), scaled=one.scaled)[0])


def _joined_values(what: str, one: ChainFields, other: ChainFields, first: Any, then: Any) -> Any:
    """One value if both chains have it, else a list; the joint is like the last contact of one."""
    if isinstance(first, MaterialPairs) or isinstance(then, MaterialPairs):
        if repr(first) == repr(then):
            return first
        raise InputError(f"chains whose {what} are given by different pairs of materials cannot "
                         "be joined; set them afterwards")  # fmt: skip
    listed = [
        list(each) if isinstance(each, tuple | np.ndarray) else [each] * (chain.beads - 1)
        for each, chain in ((first, one), (then, other))
    ]
    # A single bead has no contact, and the one between is like the first of the other chain.
    between = (listed[0][-1:] or listed[1][:1] or [first])[0]
    values = [*listed[0], between, *listed[1]]
    return values[0] if all(each == values[0] for each in values) else values

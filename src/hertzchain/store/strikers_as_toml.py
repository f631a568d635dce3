"""Strikers as the tables [[chain.struck_by]] of a chain file."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping
from typing import Any, Final

from ..chain.chain import Chain
from ..chain.materials import Material
from ..chain.striker_properties import SPHERE
from ..chain.strikers import MAX_FALL, speed_of_fall
from ..errors import InputError
from ..recorded_warnings import ignore_warnings
from ..units import STANDARD_GRAVITY
from .compact_beads import with_prefix

# Digits of a size or mass that was probably given.
DIGITS: Final = 6
# Characters of a velocity from which it was probably not given.
LONG: Final = 10


def balls_of(chain: Chain) -> Chain:
    """The beads behind the strikers, at rest unless they move, without loads and boundaries."""
    first = chain.strikers
    alone = chain.replace(
        left_wall=None, right_wall=None, drive=None, loss=None, gravity=0.0, precompression=0.0
    )[first:]
    moving = chain.velocities[first:]
    return alone.replace(
        velocities=moving if moving.any() else None, gaps=alone.gaps if alone.gaps.any() else None
    )


def struck_by_entries(
    chain: Chain, balls: Chain, names: Mapping[Material, str], *, with_units: bool
) -> list[dict[str, Any]]:
    """Keys of each table, in the order of `Chain.struck_by`: from the balls to the left."""
    found: list[dict[str, Any]] = []
    for k in reversed(range(chain.strikers)):
        entry, gap = _striker(chain, balls, k), float(chain.gaps[k])
        alike = found and {**found[-1], "count": 0, "gap": 0} == {**entry, "count": 0, "gap": 0}
        if alike and gap == 0.0:
            found[-1]["count"] = found[-1].get("count", 1) + 1
        else:
            found.append(entry | ({"gap": gap} if gap else {}))
    for each in found:
        if "material" in each:
            each["material"] = names[each["material"]]
    return [*map(_with_units, found)] if with_units and chain.units == "SI" else found


def _striker(chain: Chain, balls: Chain, k: int) -> dict[str, Any]:
    """Arguments of `Chain.struck_by`, without gap and count."""
    own = chain.striker_properties[k] if chain.striker_properties else SPHERE
    found: dict[str, Any] = {"velocity": float(chain.velocities[k])}
    mass = float(chain.masses[k]) if "masses" in chain.given else own.mass
    if mass is not None:
        found["mass"] = mass
    if chain.materials is not None and chain.materials[k] != chain.materials[chain.strikers]:
        found["material"] = chain.materials[k]
    if own.stiffness is not None or "stiffness" in chain.given:
        found["stiffness"] = float(chain.stiffness[k])
    if own.flat:
        return found | {"radius": "flat"}
    radius, mass = float(chain.radii[k]), float(f"{chain.masses[k]:.{DIGITS}g}")
    sizes: list[dict[str, Any]] = [{}, {"mass": mass}]
    if float(f"{radius:.{DIGITS}g}") == radius or "mass" in found:
        sizes.pop()
    fitting = (each for each in sizes if _usual_radius(balls, found | each) == radius)
    return found | next(fitting, {"radius": radius})


def _usual_radius(balls: Chain, arguments: Mapping[str, Any]) -> float:
    """Radius of a striker without a given one: that of the first ball, or of a sphere's mass."""
    with contextlib.suppress(InputError), ignore_warnings():
        return float(balls.struck_by(**arguments).radii[0])
    return math.nan


def _speed(velocity: float) -> dict[str, Any]:
    """The velocity, or the short height that gives it exactly, which was probably given."""
    if len(repr(velocity)) > LONG:
        height = float(f"{0.5 * velocity**2 / STANDARD_GRAVITY:.{DIGITS}g}")
        if height <= MAX_FALL and speed_of_fall("height", height) == velocity:
            return {"height": with_prefix(height, "mm")}
    return {"velocity": f"{velocity!r} m/s"}


def _with_units(entry: Mapping[str, Any]) -> dict[str, Any]:
    """Keys with text that is the same number, such as ``"200 g"``; stiffness has no usual unit."""
    found = _speed(entry["velocity"]) | {k: v for k, v in entry.items() if k != "velocity"}
    for key, unit in (("mass", "g"), ("gap", "mm")):
        if key in entry:
            found[key] = with_prefix(entry[key], unit)
    if isinstance(entry.get("radius"), float):
        found["diameter"] = with_prefix(2.0 * found.pop("radius"), "mm")
    return found

"""Parameters of a chain by name: their values in a chain, and chains with other values.

Chains with other values issue no warnings: the nominal chain has issued its own, and a fit tries
many values.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ..chain.chain import Chain
from ..chain.drives import with_factor
from ..chain.laws import Loss
from ..chain.random_materials import named_materials
from ..chain.striker_properties import face_radii
from ..chain.walls import Wall
from ..collision import HERTZ_EXPONENT, Array
from ..errors import InputError, unknown_name_error
from ..recorded_warnings import ignore_warnings
from ..units import is_unit, unit_of_stiffness
from ..validation.numbers import FRACTION
from .ball_counts import numbers_in_words
from .law_parameters import (
    SMOOTH_STEP,
    SWITCHING,
    SWITCHING_STEP,
    TYPICAL,
    has,
    names_of_losses,
    walls_with_own_laws,
)
from .loss_values import changed_losses, contact_index
from .material_parameters import constant_of, with_constants
from .names import ENDS, Name


@dataclass(frozen=True)
class Kind:
    """Unit, unit in scaled variables, bounds and typical size of a parameter of a chain.

    A parameter of a dimension other than ``"1"`` is fitted in units of the motion, so that a
    change of only stiffness or velocity requires no simulation.  A factor is fitted by its
    logarithm: velocity, stiffness and gains, which can compensate each other, then do so along a
    straight line; its sign, which is positive unless it is ``signed``, is that of the start.
    ``step`` is the step of differences in units of the typical size.
    """

    unit: str = ""
    scale: str = "1"
    lower: float = -np.inf
    upper: float = np.inf
    typical: float = 1.0
    step: float = 1e-4
    factor: bool = False
    signed: bool = False

    @property
    def unit_of_text(self) -> str | None:
        """Unit to which text is converted; None if the unit depends on an exponent."""
        return FRACTION if not self.unit else self.unit if is_unit(self.unit) else None


KINDS: Final[Mapping[str, Kind]] = {
    "stiffness": Kind(lower=1e-3, upper=1e3, factor=True),
    "exponent": Kind(lower=1.05, upper=4.0, step=3e-5),
    "drive.factor": Kind(lower=1e-3, upper=1e3, factor=True),
    "struck_by.velocity": Kind("m/s", factor=True),
    "struck_by.mass": Kind("kg", lower=1e-15, factor=True),
    "struck_by.radius": Kind("m", lower=1e-9, factor=True),
    "materials.young": Kind("Pa", lower=1.0, factor=True),
    "materials.density": Kind("kg/m^3", lower=1e-3, upper=1e6, factor=True),
    "materials.poisson": Kind(lower=-0.99, upper=0.499, typical=0.3),
    "radius": Kind("m", lower=1e-9, factor=True),
    "mass": Kind("kg", lower=1e-15, factor=True),
    "cap.mass": Kind("kg", lower=1e-15, factor=True),
    "gap": Kind("m", "length", lower=0.0, typical=0.1, step=1e-2),
    "precompression": Kind("N", "force", lower=0.0, typical=0.1, step=1e-3),
    "gravity": Kind("m/s^2", "acceleration", typical=0.1, step=1e-3),
    "wall.stiffness": Kind("N/m^p", lower=1e-6, factor=True),
    "wall.exponent": Kind(lower=1.05, upper=4.0, step=3e-5),
    "wall.gap": Kind("m", "length", lower=0.0, typical=0.1, step=1e-2),
}
# Smaller exponents of `VelocityPower` need very short steps.
MIN_ALPHA: Final = 0.5
# Relative difference up to which radii or masses are equal.
SAME: Final = 1e-9


class UnknownParameterError(InputError):
    """A chain does not have the parameter of a name."""

    def __init__(self, chain: Chain, name: Name) -> None:
        known = known_names(chain)
        super().__init__(*unknown_name_error("parameter of this chain", str(name), known).args)


def known_names(chain: Chain) -> list[str]:
    """Names of the parameters that a chain has."""
    names = ["stiffness", "stiffness[8-9]", "gap[8-9]", "mass[8]", "gravity", "precompression"]
    if isinstance(chain.exponents, float):
        names.append("exponent")
    if chain.drive is not None:
        names.append("drive.factor")
    if chain.strikers or chain.velocities[0]:
        names.append("struck_by.velocity")
    if chain.strikers:
        names.append("struck_by.mass")
    flat = any(each.flat for each in chain.striker_properties)
    if chain.strikers and chain.materials is not None and not flat:
        names.append("struck_by.radius")
    if chain.materials is not None:
        of_balls = {each.name for each in chain.materials}
        for kind in dict.fromkeys((chain.materials[-1].name, *named_materials(chain))):
            fields = ("young", "poisson", "density") if kind in of_balls else ("young", "poisson")
            names += [f"materials[{kind}].{field}" for field in fields]
        names.append("radius[8]")
    if chain.cap is not None:
        names.append("cap.mass")
    for end in ENDS:
        if getattr(chain, end) is not None:
            names += [f"{end}.{field}" for field in ("stiffness", "gap", "exponent")]
    return names + names_of_losses(chain)


def kind_of(chain: Chain, name: Name) -> Kind:
    """Kind of a parameter; raises `InputError` if the chain does not have it."""
    key = name.key
    for end in ENDS:
        if key.startswith(f"{end}."):
            if getattr(chain, end) is None:
                raise InputError(f"{name} is not a parameter of this chain: it has no {end}")
            key = key.removeprefix(f"{end}.")
            key = key if key.startswith("loss.") else f"wall.{key}"
    if key.startswith("loss."):
        return _loss_kind(chain, name)
    example = {"materials": "materials[NAME].", "radius": "radius[8]", "mass": "mass[8]"}
    known = known_names(chain)
    shown = {each.split("[")[0].split(".")[0] for each in known} | {"wall"}
    absent = key.startswith(("struck_by.", "cap.")) and key not in known
    if key not in KINDS or key.split(".")[0] not in shown or absent:
        raise UnknownParameterError(chain, name)
    if key == "exponent" and "exponent" not in known:
        raise InputError("the contacts of this chain have several exponents; they cannot be fitted")
    if key.split(".")[0] in example and not name.item:
        raise InputError(f"{name} needs an item in brackets, such as {example[key.split('.')[0]]}")
    if key == "wall.stiffness":
        exponent = chain.contact_exponents[0 if name.key.startswith("left") else -1]
        return dataclasses.replace(KINDS[key], unit=unit_of_stiffness(exponent))
    return KINDS[key]


def _loss_kind(chain: Chain, name: Name) -> Kind:
    field = name.key.rsplit(".", 1)[1]
    law = _law_with(chain, name, field)
    about = law.parameters()[field]
    metadata: Any = type(law).__dataclass_fields__[field].metadata.get("scale", "1")
    scale = metadata(law) if callable(metadata) else metadata
    lower = about.bounds.get("least", about.bounds.get("above", -np.inf))
    lower = lower + 1e-6 if "above" in about.bounds else lower
    if field == "alpha":
        lower = max(lower, MIN_ALPHA)
    upper = about.bounds.get("most", about.bounds.get("below", np.inf) - 1e-6)
    typical = TYPICAL[type(law)].get(field, 1.0)
    if scale == "1" and upper <= 1.0:
        typical = 0.05  # the fraction that is lost
    step = SWITCHING_STEP if isinstance(law, SWITCHING) else SMOOTH_STEP
    units = {"time": "s", "length": "m", "damping": "kg/s"}
    unit = units.get(about.dimension, "N (s/m)^alpha" if field == "gamma" else about.dimension)
    return Kind(unit, scale, lower, upper, typical, step)


def _law_with(chain: Chain, name: Name, field: str) -> Loss:
    """The first law to which a name refers."""
    losses = chain.contact_losses
    if name.key.startswith(ENDS):
        laws = [losses[0 if name.key.startswith("left") else -1]]
    elif name.item:
        laws = [losses[contact_index(chain, name) + 1]]
    else:
        own = walls_with_own_laws(chain).values()
        laws = [each for k, each in enumerate(losses) if k not in own]
    for law in laws:
        if has(law, field):
            return law
    raise UnknownParameterError(chain, name)


def bead_indices(chain: Chain, name: Name) -> list[int]:
    """Indices of the strikers, or of balls such as ``5,10``, counted without the strikers."""
    if name.key.startswith("struck_by."):
        return [*range(chain.strikers)]
    if name.key == "cap.mass":
        return [chain.beads - 1]
    # A cap has a mass, as the ball behind the last one.
    balls = chain.beads - chain.strikers - (chain.cap is not None and name.key == "radius")
    numbers = [part.strip() for part in name.item.split(",")]
    if not all(each.isdigit() and 1 <= int(each) <= balls for each in numbers):
        which = "is not a ball" if len(numbers) == 1 else "are not balls"
        raise InputError(f"{name} {which} of this chain, whose {numbers_in_words(chain)}")
    return [int(each) + chain.strikers - 1 for each in numbers]


def _common(chain: Chain, name: Name) -> float:
    """Radius or mass that one or several balls have in common."""
    key = name.key.removeprefix("struck_by.").removeprefix("cap.")
    values = (chain.radii if key == "radius" else chain.masses)[bead_indices(chain, name)]
    if np.ptp(values) > SAME * values[0]:
        raise InputError(
            f"{name} requires balls of one {key}, but theirs are {values.min():.5g} to "
            f"{values.max():.5g} {KINDS[name.key].unit}; name each ball in a separate parameter"
        )
    return float(values[0])


def value_of(chain: Chain, name: Name) -> float:
    """Value of a parameter in a chain; 1 for factors."""
    key = name.key
    if key in ("stiffness", "drive.factor"):
        if name.item:
            contact_index(chain, name)
        return 1.0
    if key.removeprefix("struck_by.") in ("radius", "mass", "cap.mass"):
        return _common(chain, name)
    if key == "gap":
        return float(chain.gaps[contact_index(chain, name)])
    if key == "struck_by.velocity":
        return float(np.abs(chain.velocities).max())
    if key.startswith("materials."):
        return constant_of(chain, name)
    if key == "exponent":
        return float(chain.exponents)
    if key in ("gravity", "precompression"):
        return float(getattr(chain, key))
    if ".loss." in key or key.startswith("loss."):
        field = key.rsplit(".", 1)[1]
        return float(getattr(_law_with(chain, name, field), field))
    end, field = key.split(".")
    side = ENDS.index(end)
    if field == "stiffness":
        return chain.wall_stiffness[side]
    if field == "exponent":
        return float(chain.contact_exponents[-side])
    return float(getattr(getattr(chain, end), field))


@ignore_warnings()
def with_sizes(chain: Chain, values: Mapping[Name, float], reference: float) -> Chain:
    """The chain with other materials, sizes, stiffness, exponents and velocities.

    ``reference`` is the overlap at which the force does not depend on the exponent.  A given
    stiffness of Hertz contacts, such as that of a fitted chain, changes with the radii.
    """
    changes: dict[str, Any] = {}
    if (radii := _with_values(chain, "radius", chain.radii, values)) is not None:
        changes = {"radii": radii} | _given_stiffness(chain, radii)
    out = chain.replace(**changes) if changes else chain
    constants = {name: value for name, value in values.items() if name.key.startswith("materials.")}
    out = with_constants(out, constants)
    # The masses of the other balls follow from the changed radii and densities.
    if (masses := _with_values(out, "mass", out.masses, values)) is not None:
        out = out.replace(masses=masses)
    return out.replace(**_forces_and_speeds(out, values, reference))


def _with_values(chain: Chain, key: str, own: Array, values: Mapping[Name, float]) -> Array | None:
    """Radii or masses with the values of the parameters of this key; None without them."""
    keys = (key, f"struck_by.{key}", f"cap.{key}")
    chosen = {name: value for name, value in values.items() if name.key in keys}
    found = own.copy()
    for name, value in chosen.items():
        found[bead_indices(chain, name)] = value
    return found if chosen else None


def _given_stiffness(chain: Chain, radii: Array) -> dict[str, Any]:
    """Given stiffness of Hertz contacts, which is proportional to the root of effective radii."""
    changes: dict[str, Any] = {}
    hertz, own = chain.contact_exponents == HERTZ_EXPONENT, chain.striker_properties
    before, after = (1.0 / face_radii(chain._bodies, each) for each in (chain.radii, radii))
    before, after = (each[:-1] + each[1:] for each in (before, after))
    curved = hertz[1:-1] & (after > 0.0)
    factors = np.sqrt(np.divide(before, after, out=np.ones_like(after), where=curved))
    if "stiffness" in chain.given:
        changes["stiffness"] = chain.stiffness * factors
    if chain.cap is not None and (k := chain.cap.stiffness) is not None:
        changes["cap"] = dataclasses.replace(chain.cap, stiffness=k * factors[-1])
    if any(each.stiffness is not None for each in own):
        changes["striker_properties"] = [
            each
            if (k := each.stiffness) is None
            else dataclasses.replace(each, stiffness=k * ratio)
            for each, ratio in zip(own, factors.tolist(), strict=False)
        ]
    for side, end in zip((0, -1), ENDS, strict=True):
        wall: Wall | None = getattr(chain, end)
        if wall is not None and wall.stiffness is not None and hertz[side]:
            ratio = float(radii[side] / chain.radii[side])
            changes[end] = dataclasses.replace(wall, stiffness=wall.stiffness * ratio**0.5)
    return changes


def _forces_and_speeds(
    chain: Chain, values: Mapping[Name, float], reference: float
) -> dict[str, Any]:
    stiffness, walls = chain.stiffness.copy(), np.array(chain.wall_stiffness)
    changes: dict[str, Any] = {}
    exponents: list[float | None] = [None, None]
    touched = False
    for name, value in values.items():
        if name.key == "stiffness" and name.item:
            stiffness[contact_index(chain, name)] *= value
        elif name.key == "stiffness":
            stiffness, walls = stiffness * value, np.where(springs(chain), walls, walls * value)
        elif name.key == "exponent":
            factor = reference ** (float(chain.exponents) - value)
            stiffness = stiffness * factor
            walls = np.where(following(chain, values), walls * factor, walls)
            changes["exponent"] = value
        elif name.key == "struck_by.velocity":
            fastest = float(np.abs(chain.velocities).max())
            changes["velocities"] = chain.velocities * (value / fastest)
            continue
        elif name.key.endswith("_wall.exponent"):
            side = ENDS.index(name.key.split(".")[0])
            walls[side] *= reference ** (float(chain.contact_exponents[-side]) - value)
            exponents[side] = value
        elif not name.key.endswith("_wall.stiffness"):
            continue
        touched = True
    for name, value in values.items():
        if name.key.endswith("_wall.stiffness"):
            walls[ENDS.index(name.key.split(".")[0])] = value
    if touched:
        changes["stiffness"] = stiffness
        for side, end in enumerate(ENDS):
            wall: Wall | None = getattr(chain, end)
            if wall is not None:
                changes[end] = dataclasses.replace(
                    wall, stiffness=float(walls[side]),
                    exponent=wall.exponent if exponents[side] is None else exponents[side],
                )  # fmt: skip
    return changes


def springs(chain: Chain) -> list[bool]:
    """Whether each wall has its own stiffness and exponent, as the spring of a load cell.

    A wall of a material has a given stiffness, too, in the file of a fitted chain.
    """
    return [
        (wall := getattr(chain, end)) is not None
        and wall.stiffness is not None
        and wall.exponent not in (None, chain.contact_exponents[1])
        for end in ENDS
    ]


def constants_of_ends(chain: Chain) -> list[Name]:
    """Names of the mass of a cap and of the stiffness of walls."""
    cap = [Name("cap.mass")] if chain.cap is not None else []
    return cap + [Name(f"{end}.stiffness") for end in ENDS if getattr(chain, end) is not None]


def is_free(name: Name, free: Collection[Name], chain: Chain) -> bool:
    """Whether a constant is free, by its name or, if it is the mass of a cap, by its number."""
    if name in free or name.key != "cap.mass":
        return name in free
    number = str(chain.beads - chain.strikers)
    listed = (each.item.replace(" ", "").split(",") for each in free if each.key == "mass")
    return any(number in numbers for numbers in listed)


def following(chain: Chain, names: Collection[Name]) -> list[bool]:
    """Whether each wall has the exponent of the chain, not its own, given or free."""
    given = [getattr(getattr(chain, end), "exponent", None) is not None for end in ENDS]
    free = {name.key for name in names}
    return [not (own or f"{end}.exponent" in free) for own, end in zip(given, ENDS, strict=True)]


@ignore_warnings()
def with_motion(chain: Chain, values: Mapping[Name, float]) -> Chain:
    """The chain with other losses, gaps, precompression and gravity."""
    changes: dict[str, Any] = {}
    gaps = chain.gaps.copy()
    for name, value in values.items():
        if name.key == "gap":
            gaps[contact_index(chain, name)] = value
            changes["gaps"] = gaps
        elif name.key == "drive.factor" and chain.drive is not None:
            changes["drive"] = with_factor(chain.drive, value)
        elif name.key in ("precompression", "gravity"):
            changes[name.key] = value
        elif name.key.endswith("_wall.gap"):
            end = name.key.split(".")[0]
            changes[end] = dataclasses.replace(getattr(chain, end), gap=value)
    if losses := {name: value for name, value in values.items() if "loss." in name.key}:
        of_chain, of_walls = changed_losses(chain, losses)
        changes |= of_chain
        for end, law in of_walls.items():
            wall = changes.get(end, getattr(chain, end))
            changes[end] = dataclasses.replace(wall, loss=law)
    return chain.replace(**changes) if changes else chain


def is_motion(name: Name) -> bool:
    """Whether `with_motion` sets a parameter."""
    return (
        name.key in ("gap", "precompression", "gravity", "drive.factor")
        or "loss." in name.key
        or name.key.endswith("_wall.gap")
    )

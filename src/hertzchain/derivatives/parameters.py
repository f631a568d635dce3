"""Derivatives with respect to fields of a chain, from those of its equation of motion."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..chain.laws import Loss
from ..chain.walls import Wall
from ..collision import Array
from ..errors import InputError
from ..validation.objects import check_choice, check_list
from .backward_pass import Slopes
from .damping import add_damping, by_law
from .equation import Equation
from .static_loads import add_static_loads

MATERIAL: Final = ("young", "poisson", "density", "yield_strength")
PARAMETERS: Final = (
    "radii", "masses", "stiffness", "gaps", "velocities", *MATERIAL, "left_wall.stiffness",
    "right_wall.stiffness", "left_wall.gap", "right_wall.gap", "precompression", "gravity",
    "loss.time", "loss.coefficient", "loss.gamma",
)  # fmt: skip
# Parameters with one value per contact of two beads; other lists have one per bead.
OF_CONTACTS: Final = ("stiffness", "gaps")


def checked_parameters(chain: Chain, to: str | Iterable[str]) -> tuple[str, ...]:
    """Names of parameters that a chain has; raises `InputError` for others."""
    names = [to] if isinstance(to, str) else check_list("to", to, "names of parameters")
    if not names:
        raise InputError("to must have at least one parameter, such as 'radii', got none")
    for name in names:
        check_choice("parameter", name, PARAMETERS)
        if name in MATERIAL and chain.materials is None:
            raise InputError(
                f"{name} is a parameter of materials, which this chain does not have; use 'masses' "
                "and 'stiffness', or create the chain with Chain.from_materials"
            )
        if name == "yield_strength" and not any(law.yields for law in chain.contact_losses):
            raise InputError(
                "yield_strength changes only contacts that yield, and this chain has none: give "
                "it the loss ElasticPlastic()"
            )
        end = name.split(".")[0]
        if end.endswith("_wall") and getattr(chain, end) is None:
            raise InputError(
                f"the chain has no {name}, because it has no {end}; add one, or omit {name}"
            )
        if name.startswith("loss.") and not any(_has(law, name) for law in chain.contact_losses):
            raise InputError(
                f"the chain has no {name}, because no law of its contacts has it; omit {name}"
            )
        if name.startswith("loss."):
            _check_damped(chain, name)
        if name == "precompression" and not chain.precompression > 0.0:
            raise InputError(
                "a chain without precompression has no derivative to it, because overlaps grow "
                "as its power 1/p; give a small precompression"
            )
        if name == "gravity" and chain.gravity == 0.0:
            raise InputError(
                "a chain without gravity has no derivative to it, because static overlaps grow as "
                "its power 1/p; give a small gravity"
            )
    return tuple(dict.fromkeys(names))


def _check_damped(chain: Chain, name: str) -> None:
    """Raise an error if the parameter of a law has the value of an elastic chain."""
    item = name.removeprefix("loss.")
    elastic = 1.0 if item == "coefficient" else 0.0
    if any(getattr(law, item) == elastic for law in chain.contact_losses if _has(law, name)):
        near = 0.999 if elastic else 1e-6
        raise InputError(
            f"a chain with {name} = {elastic:g} has no derivative to it, because it is integrated "
            f"as an elastic chain; give a value that is nearly {elastic:g}, such as {near:g}"
        )


def by_fields(equation: Equation, slopes: Slopes, to: Iterable[str]) -> dict[str, Array]:
    """Derivatives with respect to the fields ``to``, each with all other given fields fixed."""
    chain = equation.chain
    damped = slopes if equation.hertz is not None else add_damping(equation, slopes)
    full, by_load, by_gravity = add_static_loads(equation, damped)
    found: Mapping[str, Callable[[], Array]] = {
        "radii": lambda: _by_radii(chain, full),
        "masses": lambda: full.masses,
        "stiffness": lambda: full.stiffness[1:-1],
        "gaps": lambda: -full.overlaps[1:-1],
        "velocities": lambda: full.velocities,
        "young": lambda: _by_compliance(chain, full) * [
            -each.compliance / each.young for each in chain.materials or ()
        ],
        "poisson": lambda: _by_compliance(chain, full) * [
            -2.0 * each.poisson / each.young for each in chain.materials or ()
        ],
        "density": lambda: _by_density(chain, full),
        "left_wall.stiffness": lambda: full.stiffness[0],
        "right_wall.stiffness": lambda: full.stiffness[-1],
        "left_wall.gap": lambda: -full.overlaps[0],
        "right_wall.gap": lambda: -full.overlaps[-1],
        "precompression": lambda: np.asarray(by_load),
        "gravity": lambda: np.asarray(by_gravity),
        "loss.time": lambda: by_law(equation, slopes, "time"),
        "loss.coefficient": lambda: by_law(equation, slopes, "coefficient"),
        "loss.gamma": lambda: by_law(equation, slopes, "gamma"),
    }  # fmt: skip
    return {name: np.array(found[name](), float) for name in to}


def _has(law: Loss, name: str) -> bool:
    return name.removeprefix("loss.") in law.parameters()


def _walls(chain: Chain) -> tuple[tuple[int, int, Wall], ...]:
    """Bead, contact and wall of the walls whose stiffness follows from the bead."""
    walls = (0, 0, chain.left_wall), (-1, -1, chain.right_wall)
    return tuple(
        (bead, contact, wall) for bead, contact, wall in walls
        if wall is not None and wall.stiffness is None
    )  # fmt: skip


def _by_radii(chain: Chain, slopes: Slopes) -> Array:
    radii = chain.radii
    out = np.where(chain._follows("masses"), 3.0 * slopes.masses * chain.masses / radii, 0.0)
    # k ~ (1/R + 1/S)^(-1/2): d ln k/dR = R^(-2)/(2 (1/R + 1/S)); a flat face has 1/R = 0.
    curved = 1.0 / chain.face_radii
    share = 0.5 * _by_logarithm(chain, slopes, curved[:-1] + curved[1:])
    out[:-1] += share * curved[:-1] ** 2
    out[1:] += share * curved[1:] ** 2
    for bead, contact, _ in _walls(chain):
        k = chain.contact_stiffness[contact]
        out[bead] += 0.5 * slopes.stiffness[contact] * k / radii[bead]
    return out


def _by_logarithm(chain: Chain, slopes: Slopes, sums: Array) -> Array:
    """Derivatives by the logarithm of each stiffness that follows from radii, over ``sums``."""
    by = slopes.stiffness[1:-1] * chain.stiffness
    return np.divide(by, sums, out=np.zeros_like(by), where=chain._follows("stiffness"))


def _by_density(chain: Chain, slopes: Slopes) -> Array:
    volumes = 4.0 / 3.0 * math.pi * chain.radii**3
    return np.where(chain._follows("masses"), slopes.masses * volumes, 0.0)


def _by_compliance(chain: Chain, slopes: Slopes) -> Array:
    """Derivatives with respect to the compliance of each bead's material: k ~ 1/(C + C')."""
    assert chain.materials is not None
    own, out = np.array([each.compliance for each in chain.materials]), np.zeros(chain.beads)
    share = _by_logarithm(chain, slopes, own[:-1] + own[1:])
    out[:-1] -= share
    out[1:] -= share
    for bead, contact, wall in _walls(chain):
        by_modulus = slopes.stiffness[contact] * chain.contact_stiffness[contact]
        # A wall of the bead's own material changes with it.
        other = own[bead] if wall.material is None else wall.material.compliance
        factor = 2.0 if wall.material is None else 1.0
        out[bead] -= factor * by_modulus / (own[bead] + other)
    return out

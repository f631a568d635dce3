"""Free parameters on which no signal depends, because the chain states what they would change."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from ..chain.chain import Chain
from ..errors import InputError
from ..representation import listed
from ..traces.traces import Traces
from .chain_parameters import bead_indices, is_motion, with_motion, with_sizes
from .law_parameters import names_of_losses
from .names import Name
from .parameters import Parameter
from .symmetry import similarity_key, units_of

# Relative change by which a parameter is moved, or this part of its typical size from zero.
MOVED: Final = 1e-3
# Reason why a parameter has no effect, and parameters that can be free instead.
REASONS: Final = {
    "materials.young": ("the stiffness of all its contacts is given", "{contacts}"),
    "materials.poisson": ("the stiffness of all its contacts is given", "{contacts}"),
    "materials.density": ("the masses are given", "'mass[8]' of single balls"),
    "radius": ("its mass and the stiffness of its contacts are given", "{parts}"),
    "crosstalk": ("no neighbouring column has the same unit", "'gain[*]' or 'offset[*]'"),
}
# Contacts of which each is named; of more, one is an example.
MAX_NAMED: Final = 2
# The same for the density of a material of which no ball is made.
OF_WALL: Final = ("only a wall is made of this material, and it does not move", "'{young}'")


def check_used(parameters: Sequence[Parameter], traces: Traces, chains: Sequence[Chain]) -> None:
    """Raise `InputError` if a parameter changes neither the motion of a chain nor a sensor."""
    for each in parameters:
        if each.of_chain:
            shots = range(len(chains)) if each.shot is None else (each.shot,)
            used = any(_changes(each, chains[shot]) for shot in shots)
        else:
            used = each.name.key != "crosstalk" or _has_neighbours(traces)
        if not used:
            raise InputError(_sentence(each, chains[each.shot or 0]))


def _changes(parameter: Parameter, chain: Chain) -> bool:
    """Whether the motion depends on a parameter; true if a changed value is not allowed."""
    units, name, value = units_of(chain), parameter.name, parameter.start
    moved = value * (1.0 - MOVED) if value else MOVED * parameter.kind.typical
    change = with_motion if is_motion(name) else _resized
    try:
        keys = [similarity_key(change(chain, {name: each}), units) for each in (value, moved)]
    except InputError:
        return True
    return keys[0] != keys[1]


def _resized(chain: Chain, values: dict[Name, float]) -> Chain:
    return with_sizes(chain, values, units_of(chain).scales.length)


def _has_neighbours(traces: Traces) -> bool:
    """Whether two neighbouring columns have the same unit."""
    return any(
        one.unit == two.unit
        for shot in traces.shots
        for one, two in zip(shot.signals, shot.signals[1:], strict=False)
    )


def _sentence(parameter: Parameter, chain: Chain) -> str:
    name = parameter.name
    reason, others = REASONS.get(name.key, ("no contact depends on it", ""))
    if name.key == "materials.density" and all(
        each.name != name.item for each in chain.materials or ()
    ):
        reason, others = OF_WALL
    if not others:
        others = ", ".join(map(repr, names_of_losses(chain))) or "'stiffness'"
    contacts, mass = _contact_names(name, chain), repr(str(replace(name, key="mass")))
    others = others.format(
        contacts=listed(contacts, "or"), parts=listed([mass, *contacts], "or"),
        young=Name("materials.young", name.item),
    )  # fmt: skip
    return f"{str(name)!r} has no effect, because {reason}; free {others} instead"


def _contact_names(name: Name, chain: Chain) -> list[str]:
    """Names of the factors of the contacts of a ball or a material, or of one of many."""
    if name.key == "radius":
        touching = {*bead_indices(chain, name)}
    else:
        touching = {i for i, kind in enumerate(chain.materials or ()) if kind.name == name.item}
    contacts = [i for i in range(chain.beads - 1) if {i, i + 1} & touching]
    # The names of contacts of balls begin with 0, the last striker.
    numbers = [i - chain.strikers + 1 for i in contacts if i >= chain.strikers - 1]
    names = [repr(str(Name("stiffness", f"{k}-{k + 1}", name.shot))) for k in numbers]
    if not names or len(contacts) == chain.beads - 1:
        return [repr(str(Name("stiffness", shot=name.shot)))]
    return names if len(names) <= MAX_NAMED else [f"{names[0]} of single contacts"]

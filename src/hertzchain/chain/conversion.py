"""Conversion of chains and results between scaled variables and SI units.

Only `hertzchain.Scales` calls it; nothing is converted implicitly.  The unit of each number is in
the metadata of its field (`hertzchain.chain.scales.scale`).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any, Final, TypeVar

import numpy as np

from ..collision import hertz_stiffness
from ..errors import InputError, short_repr
from ..validation.numbers import number
from .cap import Cap
from .chain import Chain as Chain
from .feature_support import require_chain
from .laws import Loss
from .materials import contact_modulus, sphere_stiffness
from .parts import Part
from .scales import Scales
from .striker_properties import SPHERE, StrikerProperties

# Relative difference of numbers that differ by a conversion only.
ROUNDING: Final = 1e-12
# Units of the arrays and numbers of a chain.
CHAIN_SCALES: Final[Mapping[str, str]] = {
    "radii": "radius", "masses": "mass", "stiffness": "stiffness", "velocities": "velocity",
    "gaps": "length", "precompression": "force", "gravity": "acceleration",
}  # fmt: skip

T = TypeVar("T")


def scales_of(chain: Chain, velocity: float | None = None) -> Scales:
    """The scales of a chain in SI units, as `Scales.of`."""
    require_chain("Scales.of", chain, beads=1)
    if chain.units != "SI":
        raise InputError(
            "scales belong to a chain in SI units; for a scaled one give radius, mass, "
            "velocity and length"
        )
    fastest = float(np.abs(chain.velocities).max())
    if velocity is None and fastest == 0.0:
        raise InputError("nothing moves at time 0: give the velocity to scale with")
    speed = number("velocity", fastest if velocity is None else velocity, unit="m/s", above=0.0)
    unit = chain.strikers
    radius, mass = float(chain.radii[unit]), float(chain.masses[unit])
    if chain.materials is not None and "stiffness" not in chain.given:
        own = chain.materials[unit]
        stiffness = float(sphere_stiffness(radius, radius, contact_modulus(own, own)))
    else:
        if chain.beads == 1:
            raise InputError(
                "the unit of length of a single bead requires its material: use "
                "Chain.from_materials, or give Scales(radius, mass, velocity, length)"
            )
        # That of the next contact, as if its beads were of one material.
        ratio = hertz_stiffness(1.0, chain.radii[min(unit + 1, chain.beads - 1)] / radius)
        stiffness = float(chain.stiffness[min(unit, chain.beads - 2)] / ratio)
    exponent = float(chain.contact_exponents[1 + min(unit, chain.beads - 2)])
    length = (mass * (speed * speed) / stiffness) ** (1.0 / (exponent + 1.0))
    return Scales(radius, mass, speed, length, exponent)


def converted(item: T, scales: Scales, *, to_si: bool) -> T:
    """A chain, a part of one or a result in other units, as `Scales.to_si` and `to_scaled`."""
    if isinstance(item, Chain):
        return _converted_chain(item, scales, to_si=to_si)  # type: ignore[return-value]
    if not _is_convertible(item):
        raise InputError(
            f"cannot convert {short_repr(item)}: only chains, parts of chains, runs, states, "
            "pulses and fronts can be converted; convert the run and compute the result from it"
        )
    changes: dict[str, Any] = {}
    for field in dataclasses.fields(item):  # type: ignore[arg-type]
        value = getattr(item, field.name)
        if "scale" in field.metadata and value is not None:
            unit, axis = field.metadata["scale"], field.metadata["axis"]
            own = unit(item) if callable(unit) else unit
            changes[field.name] = _in_units(value, own, scales, axis=axis, to_si=to_si)
        elif isinstance(value, Chain) or _is_convertible(value):
            changes[field.name] = converted(value, scales, to_si=to_si)
    return dataclasses.replace(item, **changes)  # type: ignore[type-var]


def _is_convertible(item: object) -> bool:
    """Whether it is a dataclass that names the units of its fields, or a part of a chain."""
    if not dataclasses.is_dataclass(item) or isinstance(item, type):
        return False
    return isinstance(item, Part) or any("scale" in f.metadata for f in dataclasses.fields(item))


def _in_units(value: Any, unit: Any, scales: Scales, *, axis: int, to_si: bool) -> Any:
    """Numbers in other units."""
    if isinstance(value, dict):
        return value | {
            name: _in_units(value[name], part, scales, axis=axis, to_si=to_si)
            for name, part in unit.items()
        }
    factor: Any
    if isinstance(unit, str):
        factor = scales.unit(unit)
    else:
        factors = {name: scales.unit(name) for name in {*unit}}
        shape = [1] * value.ndim
        shape[axis] = -1
        factor = np.array([factors[name] for name in unit]).reshape(shape)
    return value * factor if to_si else value / factor


def _converted_chain(chain: Chain, scales: Scales, *, to_si: bool) -> Chain:
    wanted, units = ("SI", "scaled") if to_si else ("scaled", "SI")
    if chain.units != units:
        raise InputError(f"the chain is in {chain.units} units already: {chain.description}")
    p = chain.exponents
    same = isinstance(p, float)
    if same and p != scales.exponent:
        raise InputError(
            f"these scales are for p = {scales.exponent:g}, but the chain has p = {p:g}"
        )
    changes: dict[str, Any] = {
        name: _in_units(getattr(chain, name), unit, scales, axis=0, to_si=to_si)
        for name, unit in CHAIN_SCALES.items()
    }
    if not same:
        own_units = [f"force/length^{each}" for each in p.tolist()]
        changes["stiffness"] = _in_units(chain.stiffness, own_units, scales, axis=0, to_si=to_si)
        changes["exponent"] = p
    if chain.scatter is not None:
        scatter = converted(chain.scatter, scales, to_si=to_si)
        changes["scatter"] = scatter.with_radii(scatter.radii)
    if chain.drive is not None:
        changes["drive"] = converted(chain.drive, scales, to_si=to_si)
    laws = _resolved_laws(chain)
    once = {law: converted(law, scales, to_si=to_si) for law in laws}
    changes["loss"] = [once[law] for law in laws[1:-1]]
    for name, end in (("left_wall", 0), ("right_wall", -1)):
        if (wall := getattr(chain, name)) is not None:
            # Materials are in SI units: a scaled wall has a stiffness.
            own, exponent = chain.wall_stiffness[end], float(chain.contact_exponents[end])
            resolved = dataclasses.replace(
                wall, stiffness=own, material=None, loss=laws[end] if len(once) > 1 else None,
                exponent=None if same and exponent == scales.exponent else exponent,
            )  # fmt: skip
            changes[name] = converted(resolved, scales, to_si=to_si)
    flat = tuple(StrikerProperties(flat=each.flat) for each in chain.striker_properties)
    cap = None if chain.cap is None else Cap()
    found = chain.replace(units=wanted, **changes, striker_properties=flat, cap=cap)
    return _derived_where_possible(found, chain.striker_properties)


def _resolved_laws(chain: Chain) -> list[Loss]:
    """Laws of all contacts, with parameters from materials replaced by numbers."""
    laws = list(chain.contact_losses)
    for group in chain.contact_groups:
        for c, law in zip(group.index, group.law.resolved(group.contacts), strict=True):
            laws[c] = law
    return laws


def _derived_where_possible(chain: Chain, given: Sequence[StrikerProperties]) -> Chain:
    """The chain without given masses and stiffness, where they follow from its other fields.

    Only those of strikers and of a cap are then given that differ, or that were given to flat
    strikers (``given``).
    """
    properties = list(given) or [SPHERE] * chain.strikers
    for name, item in (("masses", "mass"), ("stiffness", "stiffness")):
        own = getattr(chain, name).tolist()
        for k, each in enumerate(properties):
            # The radius of a flat striker is that of a sphere of its mass, which is given.
            kept = each.flat and getattr(each, item) is not None
            properties[k] = _with(each, item, own[k] if kept else None)
        try:
            derived = chain.replace(**{name: None}, striker_properties=properties)
        except InputError:
            continue  # The chain has nothing from which they could be computed.
        same = np.isclose(getattr(derived, name), own, rtol=ROUNDING, atol=0.0)
        last = len(own) - 1 if chain.cap is not None else len(own)
        if same[chain.strikers : last].all():
            for k in np.flatnonzero(~same[:last]).tolist():
                properties[k] = _with(properties[k], item, own[k])
            cap = chain.cap
            if cap is not None and not same[-1]:  # the contact with a cap of another material
                cap = Cap(cap.mass, own[-1])
            chain = derived.replace(striker_properties=properties, cap=cap)
    return chain


def _with(properties: StrikerProperties, item: str, value: float | None) -> StrikerProperties:
    changes: dict[str, Any] = {item: value}
    return dataclasses.replace(properties, **changes)

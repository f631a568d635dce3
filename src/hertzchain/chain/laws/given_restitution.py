"""The parameter of a loss law for which a collision has a given coefficient of restitution."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from ...errors import InputError
from ...representation import listed
from ...validation.numbers import FRACTION, SCALED, number
from ..scales import Scales

# Range of the search: of ratios, and of other parameters in units of the motion.
RATIOS: Final = (1e-9, 1.0 - 1e-9)
MULTIPLES: Final = (1e-8, 30.0)


def usual_contact(chain: Any) -> int:
    """The contact whose restitution is meant without its number: the first one of two balls.

    It is that of a striker, or of a single ball with a wall, if there is no other one.
    """
    return chain.strikers + 1 if chain.beads > chain.strikers + 1 else 1


def law_with_restitution(
    law: type[Any], coefficient: Any, speed: Any, contacts: Any, *, si: bool,
    others: Mapping[str, Any],
) -> Any:  # fmt: skip
    """The law of this kind with a coefficient of restitution at one speed."""
    from scipy.optimize import brentq

    name = _free_parameter(law, others)
    e = number("coefficient of restitution", coefficient, unit=FRACTION, above=0.0, below=1.0)
    before = number("speed", speed, unit="m/s" if si else SCALED, above=0.0)

    def made(value: float) -> Any:
        return law(**{name: value, **others})

    def excess(log_value: float) -> float:
        value = float(np.exp(log_value))
        return made(value).resolved(contacts)[0]._restitution(before, contacts) - e

    low, high = np.log(_range(law, name, before, contacts, others)).tolist()
    if excess(low) * excess(high) > 0.0:
        raise InputError(
            f"no {law.parameters()[name].called} gives {law.name} a coefficient of restitution of "
            f"{e:g} at this speed: choose another law"
        )
    return made(float(np.exp(brentq(excess, low, high, xtol=1e-12))))


def _free_parameter(law: type[Any], others: Mapping[str, Any]) -> str:
    """The parameter that follows from the restitution: the only number that is not given."""
    numbers = [name for name, about in law.parameters().items() if not about.boolean]
    for name in others:
        if name not in law.parameters():
            known = ", ".join(law.parameters())
            raise InputError(f"{law.name} has no parameter {name!r}: choose from {known}")
    left = [name for name in numbers if name not in others]
    if not numbers:
        raise InputError(f"{law.name} has no parameter, so it has no given restitution")
    optional = {each.name for each in dataclasses.fields(law) if each.default is None}
    if optional:
        raise InputError(
            f"the restitution of {law.name} follows from the yield strengths of the materials, not "
            "from one coefficient: choose another law"
        )
    if not left:
        all_given = f"{listed(['restitution', *numbers])} are {'all' if numbers[1:] else 'both'}"
        of_them = f"one of {listed(numbers)}" if numbers[1:] else numbers[0]
        raise InputError(f"{all_given} given, but the restitution determines {of_them}: omit one")
    if len(left) != 1:
        raise InputError(
            f"one coefficient of restitution determines one parameter of {law.name}, not "
            f"{len(left)} ({', '.join(numbers)}): give all but one"
        )
    return left[0]


def _range(
    law: type[Any], name: str, speed: float, contacts: Any, others: Mapping[str, Any]
) -> tuple[float, float]:
    """Smallest and largest value of a parameter that is tried."""
    scale: Any = law.__dataclass_fields__[name].metadata.get("scale")
    if scale is None:
        return RATIOS
    mass, stiffness = float(contacts.reduced_mass[0]), float(contacts.stiffness[0])
    p = contacts.exponent
    length = (mass * speed**2 / stiffness) ** (1.0 / (p + 1.0))
    units = Scales(radius=1.0, mass=mass, velocity=speed, length=length, exponent=p)
    text = scale(law(**{name: 1.0, **others})) if callable(scale) else scale
    low, high = MULTIPLES
    return low * units.unit(text), high * units.unit(text)

"""The parameter of a loss law for which a collision has a given coefficient of restitution."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from ...errors import InputError, InputWarning, warn_user
from ...representation import listed
from ...validation.numbers import FRACTION, SCALED, number
from ..materials import FIRST_YIELD, FULLY_PLASTIC
from ..scales import Scales

# Range of the search: of ratios, and of other parameters in units of the motion.
RATIOS: Final = (1e-9, 1.0 - 1e-9)
MULTIPLES: Final = (1e-8, 30.0)
# Factor between a yield pressure and its usual range from which it is probably not one.
UNUSUAL: Final = 2.0


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

    if hasattr(law, "_overlap_at_yield"):
        return _yielding(law, coefficient, speed, contacts, si=si, others=others)
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


def _yielding(
    law: type[Any], coefficient: Any, speed: Any, contacts: Any, *, si: bool,
    others: Mapping[str, Any],
) -> Any:  # fmt: skip
    """The elastic-plastic law; its pressure is a factor of the yield strength, if that is known."""
    name = "yield_overlap"
    if contacts.radius is not None:
        strength = contacts.yield_strength
        known = strength is not None and bool(np.isfinite(strength).all())
        name = "factor" if known else "yield_pressure"
    _check_names(law, others)
    if given := [each for each in others if others[each] is not None]:
        raise InputError(
            f"restitution and {given[0]} are both given, but the restitution determines the yield "
            "pressure: omit one"
        )
    e = number("coefficient of restitution", coefficient, unit=FRACTION, above=0.0, most=1.0)
    if e == 1.0:
        raise InputError(
            "a collision with the coefficient of restitution 1 has not yielded, so that it does "
            "not determine the yield pressure: give a coefficient below 1, of a faster collision"
        )
    before = number("speed", speed, unit="m/s" if si else SCALED, above=0.0)
    # This raises an error unless the contact is that of spheres.
    law().row(contacts.exponent)
    overlap = law._overlap_at_yield(e, before, contacts)
    if name == "yield_overlap":
        return law(yield_overlap=overlap)
    # The overlap at yield is proportional to the square of the pressure.
    found = float(np.sqrt(overlap / law(**{name: 1.0}).strength(contacts)[0]))
    if name == "factor" and not FIRST_YIELD / UNUSUAL < found < UNUSUAL * FULLY_PLASTIC:
        warn_user(
            f"the coefficient of restitution {e:g} requires a yield pressure of {found:.3g} times "
            f"the yield strength, far from the usual {FIRST_YIELD:g} to {FULLY_PLASTIC:g}: either "
            "the yield strength of the material is another one, or the loss has another cause, "
            "such as viscosity or the vibration of a plate",
            InputWarning,
        )
    return law(**{name: found})


def _check_names(law: type[Any], others: Mapping[str, Any]) -> None:
    """Raise `InputError` if the law has no such parameter."""
    for name in others:
        if name not in law.parameters():
            known = ", ".join(law.parameters())
            raise InputError(f"{law.name} has no parameter {name!r}: choose from {known}")


def _free_parameter(law: type[Any], others: Mapping[str, Any]) -> str:
    """The parameter that follows from the restitution: the only number that is not given."""
    numbers = [name for name, about in law.parameters().items() if not about.boolean]
    _check_names(law, others)
    left = [name for name in numbers if name not in others]
    if not numbers:
        raise InputError(f"{law.name} has no parameter, so it has no given restitution")
    optional = {each.name for each in dataclasses.fields(law) if each.default is None}
    if optional:
        raise InputError(
            f"{law.name} has further parameters ({listed(sorted(optional))}), which one "
            "coefficient of restitution does not determine: give its parameters instead"
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

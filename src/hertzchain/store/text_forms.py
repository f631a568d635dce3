"""Walls, caps and losses as text: ``5 kN/mm``, ``5 g, steel-304``, ``viscoelastic=0.6 us``."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, Final

from ..chain.laws.base import LAWS
from ..errors import InputError
from ..units import comma_advice, has_dimension, quantity
from ..validation.objects import check_choice


def wall_from_text(what: str, text: str) -> dict[str, Any]:
    """The table of a wall: of the bead's material, rigid, of a material or of a stiffness."""
    text = text.strip()
    if text == "rigid":
        return {"rigid": True}
    if not text.lstrip("+-.")[:1].isdigit() and text:
        return {"material": text}
    found = quantity(text)
    if found is not None and has_dimension(found[1], "N/m"):
        # Laws of loss are those of spheres, and a linear spring is that of a load cell or pad.
        return {"stiffness": text, "exponent": 1.0, "loss": {"law": "elastic"}}
    if found is not None and has_dimension(found[1], "N/m^1.5"):
        return {"stiffness": text}
    raise InputError(
        f"{what} must be same, rigid, a material, or a stiffness such as '5 kN/mm' "
        f"(exponent 1) or '2e10 N/m^1.5', got {text!r}{comma_advice(text)}"
    )


def cap_from_text(what: str, text: str) -> dict[str, Any]:
    """The table of a cap: mass or frequency and, separated by commas, material and stiffness."""
    if advice := comma_advice(text):
        raise InputError(
            f"{what} has a comma between two digits, got {text!r}{advice}, or a space after a "
            "comma that separates values"
        )
    units = {"kg": "mass", "Hz": "frequency", "N/m": "stiffness", "N/m^1.5": "stiffness"}
    given: dict[str, Any] = {}
    for part in map(str.strip, text.split(",")):
        if part == "flat":
            continue  # as any cap
        found = quantity(part)
        unit = next((each for each in units if found and has_dimension(found[1], each)), "")
        if not unit and (found is not None or not part[:1].isalpha()):
            raise InputError(
                f"{what} must be a mass or the resonance frequency on the wall, and perhaps a "
                f"material and the stiffness of its contact with the last bead, such as {what} "
                f"'5 g, steel-304', or '5 g, 1 kN/mm' with a pad, got {part!r}"
            )
        key = units.get(unit, "material")
        if key in given:
            raise InputError(f"{what} {text!r} has two values of the {key}: omit one")
        given[key] = part
        if unit == "N/m":
            given["exponent"] = 1.0
    return given


def loss_from_text(what: str, text: str) -> dict[str, Any]:
    """The table of a law of loss: its name, perhaps with a parameter, and other keys."""
    if advice := comma_advice(text):
        raise InputError(
            f"{what} has a comma between two digits, got {text!r}{advice}, or a space after a "
            "comma that separates values"
        )
    first, *others = text.split(",")
    name, equals, value = (part.strip() for part in first.partition("="))
    parameters = LAWS[check_choice(f"law of {what}", name, LAWS)].parameters()
    given = {"law": name}
    pairs = [each.partition("=") for each in others]
    if equals and not parameters:
        raise InputError(f"{what}: {name} has no parameter, got {text!r}")
    for key, sign, own in [(next(iter(parameters), ""), equals, value)] * bool(equals) + pairs:
        if not sign or not own.strip():
            raise InputError(
                f"{what} must be a law with its parameter, such as 'restitution=0.95' or "
                f"'viscoelastic=0.6 us', and perhaps others as key=value, got {text!r}"
            )
        if key.strip() in given:
            raise InputError(f"{what} {text!r} has two values of the {key.strip()}: omit one")
        given[key.strip()] = _value(own.strip())
    return given


def _value(text: str) -> Any:
    """A number or boolean of a chain file, or text with a unit."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


# Tables of [chain] that can be text.
TEXT_FORMS: Final[Mapping[str, Callable[[str, str], dict[str, Any]]]] = MappingProxyType({
    "left_wall": wall_from_text, "right_wall": wall_from_text, "cap": cap_from_text,
    "loss": loss_from_text,
})  # fmt: skip


def with_tables(table: Mapping[str, Any]) -> dict[str, Any]:
    """The table [chain] with tables instead of texts of walls, a cap and a loss."""
    return {
        name: TEXT_FORMS[name](f"{name} of [chain]", value)
        if name in TEXT_FORMS and isinstance(value, str)
        else value
        for name, value in table.items()
    }

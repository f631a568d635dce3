"""Columns of pulses, and of tables of pulses, by the table of quantities."""

from __future__ import annotations

from dataclasses import field
from typing import Any, TypeVar

from ..chain.scales import scale
from .quantities import QUANTITIES, Quantity

C = TypeVar("C")


def with_columns(cls: type[C]) -> type[C]:
    """Give a class, before it becomes a dataclass, every quantity of the table.

    Stored quantities become fields, with the unit by which `hertzchain.Scales` converts them and,
    if the class does not declare them, the default `None`; derived ones become properties.  The
    class has a method ``_input(name)`` that returns an input of a formula.
    """
    for quantity in QUANTITIES.values():
        name = quantity.name
        if quantity.stored:
            declared = name in cls.__annotations__ and name not in vars(cls)
            default: dict[str, Any] = {} if declared else {"default": None}
            cls.__annotations__.setdefault(name, "Array | None")
            setattr(cls, name, field(metadata=scale(quantity.scale), **default))
        elif name not in vars(cls):
            setattr(cls, name, _derived_property(quantity))
    return cls


def derive(item: Any, quantity: Quantity) -> Any:
    """A quantity by its formula; `None` if it has none, or an input is missing."""
    inputs = [item._input(name) for name in quantity.inputs]
    if quantity.formula is None or any(values is None for values in inputs):
        return None
    return quantity.formula(*inputs)


def _derived_property(quantity: Quantity) -> property:
    of = "contact" if quantity.per == "contact" else "bead"
    return property(
        lambda item: derive(item, quantity), doc=f"{quantity.description}, of each {of}."
    )

"""Columns of pulses, and of tables of pulses, by the table of quantities."""

from __future__ import annotations

from dataclasses import field
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..chain.scales import scale
from ..collision import Array
from ..frozen import Frozen
from ..representation import range_and_mean
from ..validation.keywords import checked_methods
from ..validation.objects import check_choice
from .quantities import COLUMN_QUANTITIES, QUANTITIES, Quantity

C = TypeVar("C")


@checked_methods
class Columns(Frozen):
    """Quantities by name, of a pulse or of a table of pulses."""

    def column(self, quantity: str) -> Array | None:
        """One quantity by its name, as the attribute of that name.

        Parameters
        ----------
        quantity : str
            A name in `hertzchain.pulse.quantities.COLUMN_QUANTITIES`.

        Returns
        -------
        ndarray or None
            Of length N, or N - 1 for quantities per contact; in a `PulseTable` with a leading
            axis of chains.  `None` if the method does not predict it, as ``velocity_error`` of a
            simulation.

        Raises
        ------
        InputError
            If there is no such quantity.

        Examples
        --------
        >>> import hertzchain as hc
        >>> float(hc.bca(hc.Chain.uniform(3)).column("velocity")[2])
        1.0
        >>> hc.propagate_many([[1.0, 1.0], [1.0, 2.0]]).column("momentum").round(4)
        array([[1.    , 1.    ],
               [1.    , 1.7778]])
        """
        check_choice("quantity", quantity, COLUMN_QUANTITIES)
        values: Array | None = getattr(self, quantity)
        return values

    def columns(self) -> dict[str, Array]:
        """Every quantity that the method predicts, by name, except the speed of the pulse.

        Returns
        -------
        dict
            Arrays as those of `column`.

        Examples
        --------
        >>> import hertzchain as hc
        >>> list(hc.modified_bca(hc.Chain.tapered("forward-linear", 0.005, beads=9)).columns())
        ['velocity', 'momentum', 'energy']
        """
        found = {name: self.column(name) for name in QUANTITIES}
        return {name: values for name, values in found.items() if values is not None}


def with_columns(cls: type[C]) -> type[C]:
    """Give a class, before it becomes a dataclass, every quantity of the table.

    Stored quantities become fields, with the unit by which `hertzchain.Scales` converts them and,
    if the class does not declare them, the default `None`; derived ones become properties.  The
    class has a method ``_input(name)`` that returns an input of a formula.
    """
    for quantity in COLUMN_QUANTITIES.values():
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


def over_chains(quantity: Quantity, values: Array, beads: NDArray[np.int64], units: str) -> str:
    """Name, range and mean of a quantity of chains, at the last bead or contact of each."""
    where = ""
    if quantity.per in ("bead", "contact"):
        where, last = f" of the last {quantity.per}", beads - 1 - (quantity.per == "contact")
        rows = np.flatnonzero((last >= 0) & (last < values.shape[1]))
        values = values[rows, last[rows]]
    return f"{quantity.name}{where} {range_and_mean(values.ravel().tolist(), quantity.unit, units)}"

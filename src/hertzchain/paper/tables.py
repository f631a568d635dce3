"""The paper's three tables, held against our integration and our theory entry by entry."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from hertzchain.calibration import Window, beads_in_window, line
from hertzchain.chain.chain import Taper
from hertzchain.paper.published import Fit, Printed, PublishedTable, published_tables
from hertzchain.pulse.pulse import Pulse
from hertzchain.theory.bca import exponential_rates, forward_linear_momentum_slope

Pulses = Mapping[tuple[Taper, float], Pulse]
Column = Literal["BCA", "numerical"]

# The paper does not state its fits. These windows were found by search. That of table 1 is
# sharp: a bead more or less at its end spoils five entries; tables 2 and 3 leave more freedom.
WINDOWS: Final[dict[Fit, Window]] = {"exponential": (5, 80), "linear": (5, 60)}

# The forward momentum column of table 1 has seven decimals, more than the paper's own
# integration was good for: agreement there means 1.0e-6.
SEVEN_DECIMALS_TOLERANCE: Final = 1.0e-6


@dataclass(frozen=True)
class Entry:
    """One number of a table: as printed, as we get it, and whether they agree.

    Examples
    --------
    >>> entry = Entry("table1", "backward-exponential", "numerical", 0.01,
    ...               Printed("0.01491"), 0.014913)
    >>> entry.units, entry.verdict
    (0, 'same digits')
    """

    table: str
    taper: Taper
    column: Column
    rate: float
    printed: Printed
    ours: float

    @property
    def units(self) -> int:
        """Our value, rounded to the printed digits, minus the printed one, in last digits."""
        return round(round(self.ours, self.printed.decimals) / self.printed.unit) - round(
            self.printed.value / self.printed.unit
        )

    @property
    def tolerance(self) -> int:
        """Units of the last digit that count as agreement."""
        if self.printed.decimals == 7 and self.column == "numerical":
            return round(SEVEN_DECIMALS_TOLERANCE / self.printed.unit)
        return 1

    @property
    def agrees(self) -> bool:
        """Whether the two agree within the tolerance."""
        return abs(self.units) <= self.tolerance

    @property
    def verdict(self) -> str:
        """The comparison in words."""
        if self.units == 0:
            return "same digits"
        if not self.agrees:
            return "differs"
        return "within one unit" if self.tolerance == 1 else "within 1.0e-6"


@dataclass(frozen=True)
class Table:
    """A table of the paper with our numbers beside it."""

    published: PublishedTable
    window: Window
    entries: tuple[Entry, ...]

    @property
    def agreeing(self) -> int:
        """How many entries agree."""
        return sum(entry.agrees for entry in self.entries)


def table_chains(name: str) -> set[tuple[Taper, float]]:
    """The chains whose integration a table needs.

    Parameters
    ----------
    name : str
        ``"table1"``, ``"table2"`` or ``"table3"``.

    Returns
    -------
    set of (taper, rate)

    Examples
    --------
    >>> len(table_chains("table3"))
    10
    """
    columns = published_tables()[name].columns
    return {(column.taper, rate.value) for column in columns for rate in column.rates}


def reproduce_table(name: str, pulses: Pulses, window: Window | None = None) -> Table:
    """Recompute one table.

    The column "numerical" is the slope of a least-squares line through ln P_k or
    ln E_k (tables 1 and 2) or P_k (table 3) over the beads of the window; "BCA" is
    the closed form, Eqs. (16), (18), (26), (27) and the slope of Eq. (24).

    Parameters
    ----------
    name : str
        ``"table1"``, ``"table2"`` or ``"table3"``.
    pulses : mapping of (taper, rate) to Pulse
        Integrated chains; at least those of `table_chains`.
    window : tuple of int, optional
        First and last bead of the fit; by default 5..80 for tables 1 and 2 and 5..60
        for table 3.

    Returns
    -------
    Table

    Raises
    ------
    InputError
        If the window does not fit the chains.

    Examples
    --------
    >>> from hertzchain.paper.reproduction import integrate_chains
    >>> table = reproduce_table("table3", integrate_chains(table_chains("table3")))
    >>> f"{table.agreeing} of {len(table.entries)}"
    '20 of 20'
    """
    published = published_tables()[name]
    used = window or WINDOWS[published.fit]
    entries = []
    for column in published.columns:
        for rate, bca, numerical in zip(column.rates, column.bca, column.numerical, strict=True):
            theory = _theory(published, column.taper, rate.value)
            fitted = fitted_slope(pulses[column.taper, rate.value], published, used)
            entries += [
                Entry(name, column.taper, "BCA", rate.value, bca, theory),
                Entry(name, column.taper, "numerical", rate.value, numerical, fitted),
            ]
    return Table(published, used, tuple(entries))


def fitted_slope(pulse: Pulse, table: PublishedTable, window: Window) -> float:
    """Slope of the table's quantity (or of its logarithm) over the beads of a window.

    Parameters
    ----------
    pulse : Pulse
        The integrated pulse.
    table : PublishedTable
        Says which quantity, and whether its logarithm is fitted.
    window : tuple of int
        First and last bead.

    Returns
    -------
    float

    Examples
    --------
    >>> import hertzchain as hc
    >>> pulse = hc.propagate(hc.Chain.tapered("backward-exponential", 0.01, beads=100))
    >>> round(fitted_slope(pulse, published_tables()["table1"], (5, 80)), 5)
    0.01491
    """
    k = beads_in_window(window, pulse.chain.beads)
    values = pulse.momentum if table.quantity == "momentum" else pulse.energy
    y = values[k - 1] if table.fit == "linear" else np.log(values[k - 1])
    return float(line(k.astype(float), y)[0][1])


def _theory(table: PublishedTable, taper: Taper, rate: float) -> float:
    if table.fit == "linear":
        return forward_linear_momentum_slope(rate)
    return exponential_rates(taper, rate)[table.quantity]

"""The pulses of many chains in one table, with a leading chain axis."""

from __future__ import annotations

import operator
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..chain.chain import Chain
from ..collision import Array, hertz_stiffness
from ..errors import InputError, SimulationError, short_repr
from ..representation import counted, short, size_in_words
from ..validation.keywords import checked_methods
from .columns import Columns, over_chains, with_columns
from .notes import bouncing_notes
from .pulse import Pulse
from .quantities import BEAD_QUANTITIES, QUANTITIES

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes


@checked_methods
@dataclass(frozen=True, eq=False)
@with_columns
class PulseTable(Columns):
    """The effect of the leading pulse on each bead of C chains.

    Chains may differ in length: N is the length of the longest, and rows of shorter chains are
    filled with NaN.  Rows of chains whose pulse could not be followed are NaN throughout.

    Its columns are the quantities of `hertzchain.pulse.quantities.QUANTITIES` [scaled, or SI], with
    shape (C, N), or (C, N - 1) for quantities per contact.

    Attributes
    ----------
    radii : ndarray, shape (C, N)
        Radii [scaled, or m].  Rows of radii are divided by their first, and their times, momenta,
        energies and forces are in units of the first bead of each row.
    beads : ndarray of int, shape (C,)
        Number of beads of each chain.
    exponents : ndarray, shape (C,)
        Exponent of the contact force of each chain; NaN if its contacts differ.
    velocity, peak_time, arrival : ndarray, shape (C, N)
        As in `Pulse` [scaled, or SI].
    peak_overlap, residence : ndarray, shape (C, N - 1)
        As in `Pulse` [scaled, or SI].
    reasons : mapping
        Why a chain failed, by its index; empty if none did.
    chains : tuple of Chain
        The chains, with None for a row of radii, if they are in SI units (then so are radii and
        columns) or if the masses, stiffness, exponents or impact velocities of some do not follow
        from the radii.  Otherwise empty.

    Examples
    --------
    >>> import hertzchain as hc
    >>> table = hc.propagate_many([[1.0, 1.0, 1.0], [1.0, 2.0]])
    >>> table
    PulseTable(2 chains of up to 3 beads: velocity of the last bead 0.2222 to 0.9945, mean 0.6084;
        peak_force of the last contact 0.6816 to 1.128, mean 0.905)
    >>> table.velocity[1].round(4)
    array([1.    , 0.2222,    nan])
    """

    radii: Array
    beads: NDArray[np.int64]
    exponents: Array
    velocity: Array
    peak_time: Array
    arrival: Array
    peak_overlap: Array
    residence: Array
    reasons: Mapping[int, str]
    chains: tuple[Chain | None, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "reasons", MappingProxyType(dict(self.reasons)))
        for values in vars(self).values():
            if isinstance(values, np.ndarray):
                values.setflags(write=False)

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"reasons": dict(self.reasons)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        super().__setstate__(state | {"reasons": MappingProxyType(state["reasons"])})

    @property
    def masses(self) -> Array:
        """Masses of the beads [scaled, or kg], shape (C, N); NaN for chains that failed."""
        if self.chains:
            return self._padded("masses", 0)
        return np.asarray(self._followed_radii**3)

    @property
    def stiffness(self) -> Array:
        """Stiffness of the contacts [scaled, or N/m^p], shape (C, N - 1); NaN for failed chains."""
        if self.chains:
            return self._padded("stiffness", 1)
        radii = self._followed_radii
        return hertz_stiffness(radii[:, :-1], radii[:, 1:])

    @property
    def centre_distances(self) -> Array:
        """Distances between the centres of neighbours [R_1, or m], shape (C, N - 1)."""
        if self.chains:
            return self._padded("centre_distances", 1)
        radii = self._followed_radii
        return np.asarray(radii[:, :-1] + radii[:, 1:])

    @property
    def _followed_radii(self) -> Array:
        """Radii without those of chains that failed, which may be invalid."""
        radii = self.radii.copy()
        radii[list(self.reasons)] = np.nan
        return radii

    def _input(self, name: str) -> Any:
        """An input of the formula of a quantity, with a leading chain axis."""
        if name == "loading_force":
            stiffness, p = self.stiffness, self._contact_exponents
            return lambda overlaps: stiffness * overlaps**p
        # One per contact, for quantities such as that of the guide "Extending".
        if name == "exponents":
            return self._contact_exponents
        return getattr(self, name)

    @property
    def _contact_exponents(self) -> Array:
        """Exponents of the contacts, shape (C, 1), or (C, N - 1) if those of a chain differ."""
        found = self.exponents[:, np.newaxis]
        if any(chain is not None and not isinstance(chain.exponents, float)
               for chain in self.chains):  # fmt: skip
            found = np.repeat(found, self.radii.shape[1] - 1, axis=1)
            for row, chain in enumerate(self.chains):
                if chain is not None:
                    found[row, : chain.beads - 1] = chain.exponents
        return found

    @property
    def status(self) -> NDArray[np.str_]:
        """``"followed"`` or ``"failed"`` of each chain, shape (C,)."""
        status = np.full(len(self), "followed")
        status[list(self.reasons)] = "failed"
        return status

    def chain(self, index: int) -> Chain:
        """The chain of a row.

        Parameters
        ----------
        index : int
            Row, from 0; negative ones count from the end.

        Raises
        ------
        InputError
            If its radii are invalid.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.propagate_many([[2.0, 4.0]]).chain(0).radii
        array([1., 2.])
        """
        row = self._row(index)
        kept = self.chains[row] if self.chains else None
        if kept is not None:
            return kept
        return Chain(self.radii[row, : self.beads[row]], float(self.exponents[row]))

    def __getitem__(self, index: int) -> Pulse:
        row = self._row(index)
        if row in self.reasons:
            raise SimulationError(f"chain {row} has no pulse: {self.reasons[row]}")
        beads = int(self.beads[row])
        # Derived quantities would be computed for all chains.
        stored = {
            each.name: getattr(self, each.name) for each in QUANTITIES.values() if each.stored
        }
        columns: dict[str, Any] = {
            name: values[row, : QUANTITIES[name].count(beads)]
            for name, values in stored.items() if values is not None
        }  # fmt: skip
        chain = self.chain(row)
        notes = bouncing_notes(chain.masses)
        return Pulse(chain=chain, method="propagation", notes=notes, **columns)

    def __iter__(self) -> Iterator[Pulse]:
        return (self[index] for index in range(len(self)))

    def __len__(self) -> int:
        return len(self.beads)

    def _row(self, index: int) -> int:
        try:
            row = operator.index(index)
        except TypeError:
            raise InputError(f"a row is a whole number, got {short_repr(index)}") from None
        if not -len(self) <= row < len(self):
            raise IndexError(f"there is no chain {row} among {len(self)}, counted from 0")
        return row % len(self)

    @property
    def units(self) -> str:
        """``"SI"`` or ``"scaled"``."""
        in_si = any(chain is not None and chain.units == "SI" for chain in self.chains)
        return "SI" if in_si else "scaled"

    def _padded(self, name: str, fewer: int) -> Array:
        """An array of each chain that was followed, as rows filled with NaN."""
        rows = np.full((len(self), self.radii.shape[1] - fewer), np.nan)
        for row, chain in enumerate(self.chains):
            if row not in self.reasons:
                known = self.chain(row) if chain is None else chain
                rows[row, : known.beads - fewer] = getattr(known, name)
        return rows

    def to_xarray(self) -> xr.Dataset:
        """Labelled dataset with dimensions ``chain``, ``bead`` = 1..N and ``contact``.

        Returns
        -------
        xarray.Dataset
            One variable per quantity, with its unit (if not scaled), description and symbol;
            ``beads`` and ``status`` by chain.

        Examples
        --------
        >>> import hertzchain as hc
        >>> dict(hc.propagate_many([[1.0, 1.0], [1.0, 2.0]]).to_xarray().sizes)
        {'chain': 2, 'bead': 2, 'contact': 1}
        """
        import xarray as xr

        longest = self.velocity.shape[1]
        variables: dict[str, tuple[object, ...]] = {
            name: (("chain", QUANTITIES[name].per), values, QUANTITIES[name].attributes(self.units))
            for name, values in self.columns().items()
        }
        radius = BEAD_QUANTITIES["radius"].attributes(self.units)
        variables["radius"] = (("chain", "bead"), self.radii, radius)
        variables["beads"] = ("chain", self.beads, {"long_name": "number of beads"})
        variables["status"] = ("chain", self.status, {"long_name": "followed or failed"})
        return xr.Dataset(
            variables,
            coords={
                "chain": np.arange(len(self)),
                "bead": np.arange(1, longest + 1),
                "contact": np.arange(1, max(longest, 1)),
            },
            attrs={"method": "propagation"},
        )

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per bead of each chain that was followed.

        Returns
        -------
        pandas.DataFrame
            Indexed by ``chain``, counted from 0, and ``bead``; a quantity of contact k is in row
            k.  ``attrs["units"]`` has the units ("1": scaled).

        Examples
        --------
        >>> import hertzchain as hc
        >>> table = hc.propagate_many([[1.0, 1.0], [1.0, 2.0, 3.0]]).to_dataframe()
        >>> len(table), table.index.names
        (5, FrozenList(['chain', 'bead']))
        """
        import pandas as pd

        rows = {
            row: self[row].to_dataframe() for row in range(len(self)) if row not in self.reasons
        }
        if not rows:
            raise InputError("no chain was followed, so the table has no rows")
        table = pd.concat(rows, names=["chain"])
        table.attrs["units"] = next(iter(rows.values())).attrs["units"]
        return table

    def plot(self, quantity: str = "velocity", *, ax: Axes | None = None) -> Axes:
        """Plot the median of a quantity along the chains, and a band with 90% of the chains.

        If the last beads leave a free end at a larger velocity, their median has a symbol without
        a line, and a bar instead of the band.

        Parameters
        ----------
        quantity : str
            Name of a column.
        ax : matplotlib.axes.Axes, optional
            Axes to draw into.  By default, a new figure is created.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            If no chain has the quantity.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(20)
        >>> many = [chain.with_scatter(seed, relative=0.03) for seed in range(50)]
        >>> hc.propagate_many(many).plot("arrival").get_ylabel()
        'arrival time $t_k$'
        """
        from ..plotting.pulse_tables import plot_pulse_table

        return plot_pulse_table(self, quantity, ax=ax)

    @property
    def _longest(self) -> str:
        """Number of beads and strikers of the longest chain in words."""
        if not len(self):
            return size_in_words(0, 0)
        row = int(np.argmax(self.beads))
        chain = self.chains[row] if self.chains else None
        return size_in_words(int(self.beads[row]), 0 if chain is None else chain.strikers)

    def _repr_html_(self) -> str:
        from ..notebook.tables import pulse_table_html

        return pulse_table_html(self)

    def __repr__(self) -> str:
        failed = f", {len(self.reasons)} failed" if self.reasons else ""
        units = ", SI" if self.units == "SI" else ""
        about = f"{counted(len(self), 'chain')} of up to {self._longest}{units}{failed}"
        columns = self.columns() if len(self) > len(self.reasons) else {}
        return short("PulseTable", about, *(
            over_chains(QUANTITIES[name], columns[name], self.beads, self.units)
            for name in ("velocity", "peak_force") if name in columns
        ))  # fmt: skip

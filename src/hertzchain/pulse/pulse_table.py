"""The pulses of many chains in one table, with a leading chain axis."""

from __future__ import annotations

import operator
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hertzchain.arguments import one_of
from hertzchain.chain.chain import Chain
from hertzchain.contacts import Array, hertz_stiffness
from hertzchain.errors import InputError, SimulationError, shown
from hertzchain.frozen import Frozen
from hertzchain.pulse.pulse import Pulse
from hertzchain.pulse.quantities import QUANTITIES, Quantity

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False)
class PulseTable(Frozen):
    """What the leading pulse does to each bead of each of C chains.

    Chains may differ in length: N is that of the longest, and rows of shorter ones are
    filled with NaN.  So are the rows of chains that could not be followed, all of them.

    Attributes
    ----------
    radii : ndarray, shape (C, N)
        Radii, in units of each chain's first [scaled].
    beads : ndarray of int, shape (C,)
        Number of beads of each chain.
    exponents : ndarray, shape (C,)
        Exponent of the contact force of each chain.
    velocity, peak_time, arrival : ndarray, shape (C, N)
        As in `Pulse` [scaled].
    peak_overlap, residence : ndarray, shape (C, N - 1)
        As in `Pulse` [scaled].
    reasons : mapping
        Why a chain failed, by its index; empty if none did.

    Examples
    --------
    >>> import hertzchain as hc
    >>> table = hc.propagate_many([[1.0, 1.0, 1.0], [1.0, 2.0], [1.0, -1.0]])
    >>> table
    PulseTable(3 chains of up to 3 beads, 1 failed)
    >>> table.reasons[2]
    'radius of bead 2 is -1: radii must be positive and finite'
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

    def __post_init__(self) -> None:
        object.__setattr__(self, "reasons", MappingProxyType(dict(self.reasons)))
        for name in ("radii", "velocity", "peak_time", "arrival", "peak_overlap", "residence"):
            getattr(self, name).setflags(write=False)

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"reasons": dict(self.reasons)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        super().__setstate__(state | {"reasons": MappingProxyType(state["reasons"])})

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

        Returns
        -------
        Chain

        Raises
        ------
        InputError
            If its radii cannot be those of a chain.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.propagate_many([[2.0, 4.0]]).chain(0).radii
        array([1., 2.])
        """
        row = self._row(index)
        return Chain(self.radii[row, : self.beads[row]], float(self.exponents[row]))

    def __getitem__(self, index: int) -> Pulse:
        row = self._row(index)
        if row in self.reasons:
            raise SimulationError(f"chain {row} has no pulse: {self.reasons[row]}")
        beads = int(self.beads[row])
        return Pulse(
            chain=self.chain(row),
            method="propagation",
            velocity=self.velocity[row, :beads],
            peak_time=self.peak_time[row, :beads],
            arrival=self.arrival[row, :beads],
            peak_overlap=self.peak_overlap[row, : beads - 1],
            residence=self.residence[row, : beads - 1],
        )

    def __iter__(self) -> Iterator[Pulse]:
        return (self[index] for index in range(len(self)))

    def __len__(self) -> int:
        return len(self.beads)

    def _row(self, index: int) -> int:
        try:
            row = operator.index(index)
        except TypeError:
            raise InputError(f"a row is a whole number, got {shown(index)}") from None
        if not -len(self) <= row < len(self):
            raise IndexError(f"there is no chain {row} among {len(self)}, counted from 0")
        return row % len(self)

    def column(self, quantity: Quantity) -> Array | None:
        """One quantity of all chains by its name, as `Pulse.column`.

        Parameters
        ----------
        quantity : str
            Name of the quantity.

        Returns
        -------
        ndarray, shape (C, N) or (C, N - 1), or None
            `None` where an integration has nothing to tell, as of ``velocity_error``.

        Raises
        ------
        InputError
            For an unknown name.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.propagate_many([[1.0, 1.0], [1.0, 2.0]]).column("momentum").round(4)
        array([[1.    , 1.    ],
               [1.    , 1.7778]])
        """
        one_of("quantity", quantity, QUANTITIES)
        if quantity == "momentum":
            return self.radii**3 * self.velocity
        if quantity == "energy":
            return 0.5 * self.radii**3 * self.velocity**2
        if quantity == "peak_force":
            stiffness = hertz_stiffness(self.radii[:, :-1], self.radii[:, 1:])
            return stiffness * self.peak_overlap ** self.exponents[:, np.newaxis]
        found: Array | None = getattr(self, quantity, None)
        return found

    def to_xarray(self) -> xr.Dataset:
        """Labelled dataset with dimensions ``chain``, ``bead`` = 1..N and ``contact``.

        Returns
        -------
        xarray.Dataset
            One variable a quantity, with units ("1": scaled) and long names; ``beads``
            and ``status`` by chain.

        Examples
        --------
        >>> import hertzchain as hc
        >>> dict(hc.propagate_many([[1.0, 1.0], [1.0, 2.0]]).to_xarray().sizes)
        {'chain': 2, 'bead': 2, 'contact': 1}
        """
        import xarray as xr

        longest = self.velocity.shape[1]
        columns: dict[str, tuple[object, ...]] = {
            name: (("chain", "bead"), getattr(self, name), _labels(QUANTITIES[name][1]))
            for name in ("velocity", "peak_time", "arrival")
        }
        columns |= {
            name: (("chain", "contact"), getattr(self, name), _labels(QUANTITIES[name][1]))
            for name in ("peak_overlap", "residence")
        }
        columns["radius"] = (("chain", "bead"), self.radii, _labels("radius"))
        columns["beads"] = ("chain", self.beads, {"long_name": "number of beads"})
        columns["status"] = ("chain", self.status, {"long_name": "what became of the chain"})
        return xr.Dataset(
            columns,
            coords={
                "chain": np.arange(len(self)),
                "bead": np.arange(1, longest + 1),
                "contact": np.arange(1, max(longest, 1)),
            },
            attrs={"method": "propagation"},
        )

    def __repr__(self) -> str:
        failed = f", {len(self.reasons)} failed" if self.reasons else ""
        return f"PulseTable({len(self)} chains of up to {self.velocity.shape[1]} beads{failed})"


def _labels(long_name: str) -> dict[str, str]:
    return {"units": "1", "long_name": long_name}

"""Quantities of many simulated chains in one table, with a leading chain axis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from ..chain.chain import Chain
from ..chain.hertz_range import HertzRange, hertz_range
from ..chain.hertz_ratios import exceeds_limits
from ..chain.stiff_walls import TOO_STIFF, stiff_wall_reasons
from ..collision import Array
from ..frozen import Frozen
from ..pulse.columns import over_chains
from ..pulse.quantities import WALL_QUANTITIES
from ..pulse.quantity_names import column_name
from ..representation import counted, short, size_in_words
from ..validation.keywords import checked_methods
from ..validation.numbers import whole_number
from ..validation.objects import check_choice
from .ensemble_columns import TABLE_QUANTITIES

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

# Largest number of chains whose ranges a representation states, which takes a second.
MAX_CHECKED: Final = 3000


@checked_methods
@dataclass(frozen=True, eq=False)
class RunTable(Frozen):
    """Quantities of C simulated chains; the result of `hertzchain.simulate_many`.

    Chains may differ in length: N is the length of the longest, and rows of shorter chains are
    filled with NaN, as are rows of chains that failed.

    Attributes
    ----------
    chains : tuple of Chain
        The chains; `None` in place of invalid members.
    sensors : tuple of int
        Numbers of the beads with a sensor.
    columns : mapping of str to ndarray
        The kept quantities [scaled, or SI]: shape (C, N) per bead, (C, N - 1) per contact,
        (C, S) per sensor, and (C,) per wall or run.
    status : ndarray of str, shape (C,)
        Reason for the end of each run, as `Run.status`, or ``"failed"``.
    reasons : mapping
        Reasons why chains failed, by their index; empty if none did.
    complete : ndarray of bool, shape (C,)
        Whether the largest force on the right wall is complete, as `WallForce.complete`, or with
        quantities of the last body, whether no larger force on it can follow; if not,
        ``wall_peak_force`` is NaN.  Impulse of the impact and duration are NaN as long as the
        impact has not ended.
    sensitive : ndarray of bool, shape (C,)
        Whether the largest force on the right wall may be sensitive to small changes, such as
        another tolerance, as `WallForce.sensitive`; `hertzchain.Run.horizon` of the chain estimates
        how long it is predictable.
    outside_range : ndarray of bool, shape (C,)
        Whether a chain of materials left the range of Hertz's law at any time of the run.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chains = [hc.Chain.uniform(n).replace(right_wall=hc.Wall()) for n in (10, 20)]
    >>> table = hc.simulate_many(chains, keep=["wall_peak_force", "velocity"])
    >>> table
    RunTable(2 chains of up to 20 beads: wall_peak_force 1.243 to 1.244, mean 1.243; velocity of the
        last bead 0.5962 to 0.5968, mean 0.5965)
    >>> table["wall_peak_force"].round(4)
    array([1.2437, 1.2432])
    """

    chains: tuple[Chain | None, ...]
    sensors: tuple[int, ...]
    columns: Mapping[str, Array]
    status: NDArray[np.str_]
    reasons: Mapping[int, str]
    complete: NDArray[np.bool_]
    sensitive: NDArray[np.bool_]
    _overlaps: Array = field(repr=False)
    _of_whole_runs: bool = field(default=True, repr=False)

    def __post_init__(self) -> None:
        for name in ("columns", "reasons"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))
        flags = (self.status, self.complete, self.sensitive)
        for values in (*self.columns.values(), *flags, self._overlaps):
            values.setflags(write=False)

    def __getstate__(self) -> dict[str, Any]:
        mappings = {"columns": dict(self.columns), "reasons": dict(self.reasons)}
        return {name: value for name, value in vars(self).items() if name != "outside_range"} | (
            mappings
        )

    def __setstate__(self, state: dict[str, Any]) -> None:
        super().__setstate__(state)
        self.__post_init__()

    def __len__(self) -> int:
        return len(self.chains)

    def __getitem__(self, name: str) -> Array:
        name = check_choice("quantity of this table", column_name(name), self.columns)
        return self.columns[name]

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.columns)

    @property
    def beads(self) -> NDArray[np.int64]:
        """Number of beads of each chain, shape (C,)."""
        return np.array([0 if each is None else each.beads for each in self.chains], np.int64)

    @property
    def _longest(self) -> str:
        """Number of beads and strikers of the longest chain in words."""
        lengths = [(each.beads, each.strikers) for each in self.chains if each is not None]
        return size_in_words(*max(lengths, default=(0, 0)))

    @property
    def units(self) -> str:
        """``"SI"`` or ``"scaled"``."""
        return next((each.units for each in self.chains if each is not None), "scaled")

    @cached_property
    def outside_range(self) -> NDArray[np.bool_]:
        """Whether each chain of materials has left the range of Hertz's law, shape (C,)."""
        return np.array([self._exceeds(i) for i in range(len(self))], bool)

    def exceeded_limits(self, index: int) -> tuple[str, ...]:
        """Limits of Hertz's law that a chain exceeds, a sentence each, as for `outside_range`.

        Parameters
        ----------
        index : int
            Index of the chain, from 0.

        Returns
        -------
        tuple of str
            Empty within the limits, without materials, and if the chain failed.

        Raises
        ------
        InputError
            If there is no such chain.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.from_materials(5e-3, "ptfe", beads=9, velocity=0.5)
        >>> import warnings
        >>> with warnings.catch_warnings():
        ...     warnings.simplefilter("ignore", hc.ModelRangeWarning)
        ...     table = hc.simulate_many([chain])
        >>> table.exceeded_limits(0)[0].partition(" (")[0]
        'pressure / yield is 2.63 at contact 1'
        """
        index = whole_number("index of a chain", index, least=0, most=len(self) - 1)
        found = self._hertz_range(index)
        return () if found is None else found.violations

    def _exceeds(self, index: int) -> bool:
        """Whether `exceeded_limits` has any for a chain; this takes a fifth of the time."""
        chain = self.chains[index]
        if chain is None or index in self.reasons or chain.materials is None:
            return False
        return exceeds_limits(chain, self._overlaps[index, : chain.beads + 1])

    def _hertz_range(self, index: int) -> HertzRange | None:
        """Comparison of a chain with the limits of Hertz's law; `None` if there is none."""
        chain = self.chains[index]
        if chain is None or index in self.reasons or chain.materials is None:
            return None
        return hertz_range(chain, self._overlaps[index, : chain.beads + 1])

    @property
    def _peak_note(self) -> str:
        """Number of chains whose largest force on the wall may be sensitive to small changes."""
        found = int(self.sensitive.sum())
        if not found or not WALL_QUANTITIES.keys() & self.columns.keys():
            return ""
        return f"{counted(found, 'largest force')} on the wall may be sensitive to small changes"

    def _stiff_walls(self, index: int) -> list[str]:
        """A clause for each wall whose spring is too stiff; none if whole runs are not known."""
        chain = self.chains[index]
        if chain is None or index in self.reasons or not self._of_whole_runs:
            return []
        return stiff_wall_reasons(chain, self._overlaps[index, : chain.beads + 1])

    @property
    def _wall_note(self) -> str:
        """Number of chains with a wall whose spring is too stiff to replace a contact."""
        if len(self) > MAX_CHECKED or self.units != "SI":
            return ""
        found = sum(bool(self._stiff_walls(i)) for i in range(len(self)))
        return f"in {counted(found, 'chain')}, the spring of a {TOO_STIFF}" if found else ""

    @property
    def _range_note(self) -> str:
        """Number of chains that have left the range of Hertz's law."""
        checked = sum(
            each is not None and each.materials is not None and i not in self.reasons
            for i, each in enumerate(self.chains)
        )
        if not checked:
            return ""
        if len(self) > MAX_CHECKED:
            return "outside_range states which chains are outside Hertz's range"
        outside = int(self.outside_range.sum())
        part = "" if self._of_whole_runs else " (reflections not checked)"
        return f"{outside} of {checked} chains outside Hertz's range{part}"

    def to_xarray(self) -> xr.Dataset:
        """Labelled dataset with dimensions ``chain``, ``bead``, ``contact`` and ``sensor``.

        Returns
        -------
        xarray.Dataset
            One variable per kept quantity, with its unit (if not scaled) and description;
            ``status``, ``complete``, ``sensitive``, ``outside_range`` and ``beads`` by chain.

        Examples
        --------
        >>> import hertzchain as hc
        >>> table = hc.simulate_many([hc.Chain.uniform(9)], keep=["velocity"])
        >>> dict(table.to_xarray().sizes)
        {'chain': 1, 'bead': 9}
        """
        import xarray as xr

        variables: dict[str, tuple[Any, ...]] = {}
        coordinates: dict[str, Any] = {"chain": np.arange(len(self))}
        for name, values in self.columns.items():
            quantity, dimensions = TABLE_QUANTITIES[name], ["chain"]
            if values.ndim == 2:
                labels = np.arange(1, values.shape[1] + 1)
                place = str(quantity.per) if quantity.per != "run" else "bead"
                coordinates[place] = np.array(self.sensors) if place == "sensor" else labels
                dimensions.append(place)
            variables[name] = (dimensions, values, quantity.attributes(self.units))
        variables["status"] = ("chain", self.status, {"long_name": "end of the run"})
        variables["complete"] = (
            "chain", self.complete, {"long_name": "largest force on the right end is complete"}
        )  # fmt: skip
        variables["sensitive"] = (
            "chain", self.sensitive,
            {"long_name": "largest force on the right wall may be sensitive to small changes"},
        )  # fmt: skip
        variables["outside_range"] = (
            "chain", self.outside_range, {"long_name": "outside the range of Hertz's law"}
        )  # fmt: skip
        variables["beads"] = ("chain", self.beads, {"long_name": "number of beads"})
        return xr.Dataset(variables, coords=coordinates, attrs={"method": "simulation"})

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per chain.

        Returns
        -------
        pandas.DataFrame
            A column per quantity, such as ``"end_time"``, or one per bead, contact or sensor, such
            as ``"velocity_1"``; also ``"beads"``, ``"status"``, ``"complete"``,
            ``"sensitive"``, ``"outside_range"`` and ``"reason"``.

        Examples
        --------
        >>> import hertzchain as hc
        >>> table = hc.simulate_many([hc.Chain.uniform(3)], keep=["arrival"])
        >>> [*table.to_dataframe().columns[:3]]
        ['arrival_1', 'arrival_2', 'arrival_3']
        """
        import pandas as pd

        found: dict[str, Any] = {}
        for name, values in self.columns.items():
            if values.ndim == 1:
                found[name] = values
                continue
            numbers = (
                self.sensors
                if TABLE_QUANTITIES[name].per == "sensor"
                else range(1, values.shape[1] + 1)
            )
            found |= {f"{name}_{k}": values[:, i] for i, k in enumerate(numbers)}
        found |= {"beads": self.beads, "status": self.status, "complete": self.complete}
        found |= {"sensitive": self.sensitive, "outside_range": self.outside_range}
        found["reason"] = [self.reasons.get(i, "") for i in range(len(self))]
        return pd.DataFrame(found, index=pd.RangeIndex(len(self), name="chain"))

    def _repr_html_(self) -> str:
        from ..notebook.tables import run_table_html

        return run_table_html(self)

    def __repr__(self) -> str:
        failed = f", {len(self.reasons)} failed" if self.reasons else ""
        units = ", SI" if self.units == "SI" else ""
        late = int((~self.complete).sum()) - len(self.reasons)
        incomplete = f", {late} incomplete" if late > 0 else ""
        about = f"{counted(len(self), 'chain')} of up to {self._longest}{units}{failed}{incomplete}"
        notes = filter(None, (self._peak_note, self._wall_note, self._range_note))
        return short("RunTable", "; ".join((about, *notes)), *(
            over_chains(TABLE_QUANTITIES[name], values, self.beads, self.units)
            for name, values in self.columns.items()
        ))  # fmt: skip

"""Tables of the modes of a chain; base of `Spectrum`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..collision import Array
from ..validation.keywords import checked_methods
from .host_bands import HostBands

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


@checked_methods
class ModeTables(HostBands):
    """Conversion of the modes of a spectrum to tables."""

    @property
    def decay_rates(self) -> Array:
        """Rates of decay of the modes."""
        raise NotImplementedError

    @property
    def damping_ratios(self) -> Array:
        """Damping ratios of the modes."""
        raise NotImplementedError

    def _columns(self) -> dict[str, tuple[Array, str]]:
        """Values of each mode, and their units."""
        si = self.chain.units == "SI"
        number, per_second, hertz = ("1", "1/s", "Hz") if si else ("", "", "")
        localised = np.isin(np.arange(1, len(self.frequencies) + 1), self.localised)
        return {
            "frequency": (self.frequencies, hertz),
            "decay_rate": (self.decay_rates, per_second),
            "damping_ratio": (self.damping_ratios, number),
            "participation": (self.participation, number),
            "localised": (localised, number),
        }

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per mode.

        Returns
        -------
        pandas.DataFrame
            Indexed by ``mode``, from 1; columns ``frequency``, ``decay_rate``, ``damping_ratio``,
            ``participation`` and ``localised``.  ``attrs["units"]`` has their units.

        Examples
        --------
        >>> import hertzchain as hc
        >>> held = hc.Chain.uniform(40).replace(precompression=1.0, held_by="force")
        >>> table = hc.spectrum(held.with_defects({20: 0.5})).to_dataframe()
        >>> table[table.localised].frequency.round(4).to_dict()
        {40: 0.7529}
        """
        import pandas as pd

        columns = self._columns()
        modes = pd.RangeIndex(1, len(self.frequencies) + 1, name="mode")
        table = pd.DataFrame({name: values for name, (values, _) in columns.items()}, index=modes)
        table.attrs["units"] = {name: unit for name, (_, unit) in columns.items()}
        return table

    def to_xarray(self) -> xr.Dataset:
        """Labelled dataset with coordinates ``mode`` = 1..M and ``bead`` = 1..N.

        Returns
        -------
        xarray.Dataset
            The columns of `to_dataframe`, with their units, and ``shape``, the displacements of the
            beads in each mode (`modes`).  With losses, they are complex.

        Examples
        --------
        >>> import hertzchain as hc
        >>> held = hc.Chain.uniform(40).replace(precompression=1.0, held_by="force")
        >>> dataset = hc.spectrum(held.with_defects({20: 0.5})).to_xarray()
        >>> int(abs(dataset["shape"].sel(mode=40)).idxmax())
        20
        """
        import xarray as xr

        variables = {
            name: ("mode", values, {"units": unit} if unit else {})
            for name, (values, unit) in self._columns().items()
        }
        beads, modes = self.modes.shape
        return xr.Dataset(
            {**variables, "shape": (("bead", "mode"), self.modes)},
            coords={"bead": np.arange(1, beads + 1), "mode": np.arange(1, modes + 1)},
            attrs={"chain": self.chain.description},
        )

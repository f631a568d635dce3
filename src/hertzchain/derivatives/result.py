"""Value of a quantity and its derivatives."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError, unknown_name_error
from ..frozen import Frozen
from ..representation import short
from ..simulation.wall_bound import LATER_IMPACTS, RIGHT, motion_can_escape
from ..validation.keywords import checked_methods
from .accuracy import Accuracy
from .differences import Differences
from .kinks import kink_note
from .parameters import OF_CONTACTS

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes


@checked_methods
@dataclass(frozen=True, eq=False)
class Gradient(Frozen):
    """Value of a quantity and its derivatives; unpacks as ``value, gradient``.

    ``gradient["radii"]`` is the array of derivatives dQ/dR with respect to the radii, and
    ``gradient.relative("radii")`` that of logarithmic ones, in percent per 1%, as of
    `local_rate_gradient`.

    Attributes
    ----------
    quantity : str
        Name of the quantity, with its bead, such as ``"pulse.velocity@90"``.
    value : float
        Value [scaled, or SI]; NaN if the quantity does not exist in the run.
    gradient : mapping of str to ndarray
        Derivatives with respect to the parameters in ``to``, each of the shape of the parameter.
    status : str
        ``"complete"``, or why the quantity is incomplete or does not exist.
    steps : int
        Number of steps of the integration.
    unit : str
        Unit of the value; empty in a scaled chain.
    units : mapping of str to str
        Units of the derivatives, such as ``"N/m"``; empty in a scaled chain.
    parameters : mapping of str to ndarray
        Values of the parameters [scaled, or SI].
    method : str
        ``"adjoint"`` for exact derivatives, or ``"central differences"`` of simulations, for losses
        without exact ones.
    kinks : tuple of str
        Parameters of which a change of one entry by 1% can make another maximum of a force on a
        wall the largest one, so that the derivatives are valid only for smaller changes.
    """

    quantity: str
    value: float
    gradient: Mapping[str, Array] = field(repr=False)
    status: str
    steps: int
    _accuracy: Accuracy | Differences = field(repr=False, compare=False)
    unit: str = field(default="", repr=False)
    units: Mapping[str, str] = field(default_factory=dict, repr=False)
    parameters: Mapping[str, Array] = field(default_factory=dict, repr=False)
    _chain: Chain | None = field(default=None, repr=False, compare=False)
    method: str = field(default="adjoint", repr=False)
    kinks: tuple[str, ...] = field(default=(), repr=False)

    def __setstate__(self, state: dict[str, Any]) -> None:
        super().__setstate__(state)
        for values in (*self.gradient.values(), *self.parameters.values()):
            values.setflags(write=False)

    @cached_property
    def error(self) -> float:
        """Estimated relative error of the derivatives, in units of the largest of an array.

        It is five times the difference from a second gradient, with a tenth of the tolerance and a
        wider window, which is computed when the attribute is first read.  With damping, it is
        at least an estimate that follows from the tolerance.  Of central differences, it is the
        change if their step is twice as large.
        """
        return self._accuracy.relative_error(self.gradient)

    def __iter__(self) -> Iterator[float | Mapping[str, Array]]:
        return iter((self.value, self.gradient))

    def __getitem__(self, name: str) -> Array:
        if isinstance(name, int | np.integer) and not isinstance(name, bool):
            raise InputError(
                f"a gradient is indexed by the name of a parameter, such as "
                f"gradient[{next(iter(self.gradient))!r}], got {name}; its value is "
                "gradient.value, and 'value, slopes = gradient' gives both"
            )
        if not isinstance(name, str) or name not in self.gradient:
            raise unknown_name_error("parameter of this gradient", name, self.gradient)
        return self.gradient[name]

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.gradient)

    def relative(self, name: str = "radii") -> Array:
        r"""Logarithmic derivatives :math:`\partial \ln Q/\partial \ln x` of the quantity.

        They state by how many percent the quantity Q changes if the parameter x of a bead or
        contact grows by 1%.  Compare these if you ask which bead matters most: absolute
        derivatives favour small beads.

        Parameters
        ----------
        name : str
            One of the parameters of this gradient.

        Returns
        -------
        ndarray
            Of the shape of the parameter; 0 where it is 0.

        Raises
        ------
        InputError
            If the gradient does not have the parameter, or the value of the quantity is 0.

        Examples
        --------
        >>> import hertzchain as hc
        >>> found = hc.gradient(hc.Chain.uniform(3), "pulse.energy@3", to="velocities")
        >>> found.relative("velocities").round(4)
        array([2., 0., 0.])
        """
        slopes = self[name]
        if self.value == 0.0:
            raise InputError(
                f"{self.quantity} is 0 and has no relative derivatives; use the absolute ones"
            )
        own = self.parameters[name]
        # Central differences have no derivative by an entry that is 0.
        return np.where(own == 0.0, 0.0, slopes * own / self.value)

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per bead or contact of each parameter.

        Returns
        -------
        pandas.DataFrame
            Columns ``parameter``, ``number`` of the bead or contact (missing for a parameter
            without one), ``value`` of the parameter, ``derivative`` of the quantity and its
            ``unit``, which is empty in a scaled chain, and ``relative``, the logarithmic
            derivative: the change of the quantity in percent if the parameter grows by 1% (missing
            if the quantity is 0).

        Examples
        --------
        >>> import hertzchain as hc
        >>> found = hc.gradient(hc.Chain.uniform(3), "pulse.energy@3", to="velocities")
        >>> found.to_dataframe().derivative.round(4).tolist()
        [0.9891, 0.0021, 0.0033]
        """
        import pandas as pd

        rows = []
        for name, slopes in self.gradient.items():
            single = np.ndim(slopes) == 0
            values = np.broadcast_to(self.parameters[name], np.shape(slopes))
            relative = np.full(np.shape(slopes), np.nan) if self.value == 0 else self.relative(name)
            entries = zip(*map(np.atleast_1d, (values, slopes, relative)), strict=True)
            rows += [
                (name, None if single else k, value, slope, self.units.get(name, ""), percent)
                for k, (value, slope, percent) in enumerate(entries, 1)
            ]
        columns = ["parameter", "number", "value", "derivative", "unit", "relative"]
        return pd.DataFrame(rows, columns=columns).astype({"number": "Int64"})

    def to_xarray(self) -> xr.Dataset:
        """Labelled dataset with coordinates ``bead`` = 1..N and ``contact`` = 1..N - 1.

        Returns
        -------
        xarray.Dataset
            A variable with the derivatives by each parameter, with their unit as an attribute, if
            they have one.  A parameter without beads or contacts has no dimension.

        Examples
        --------
        >>> import hertzchain as hc
        >>> found = hc.gradient(hc.Chain.uniform(3), "pulse.energy@3", to=["radii", "gaps"])
        >>> dict(found.to_xarray().sizes)
        {'bead': 3, 'contact': 2}
        """
        import xarray as xr

        dimensions = {
            name: ("contact" if name in OF_CONTACTS else "bead",) * np.ndim(slopes)
            for name, slopes in self.gradient.items()
        }
        variables = {
            name: (dimensions[name], slopes, {"units": unit} if (unit := self.units[name]) else {})
            for name, slopes in self.gradient.items()
        }
        sizes = {dimension: len(self.gradient[name])
                 for name, own in dimensions.items() for dimension in own}  # fmt: skip
        return xr.Dataset(
            variables,
            coords={name: np.arange(1, size + 1) for name, size in sizes.items()},
            attrs={"quantity": self.quantity, "value": self.value, "unit": self.unit},
        )

    def plot(self, name: str = "radii", *, ax: Axes | None = None) -> Axes:
        """Plot by how many percent the quantity changes if a parameter of each bead grows by 1%.

        Parameters
        ----------
        name : str
            One of the parameters of this gradient with a value for each bead or contact.
        ax : matplotlib.axes.Axes, optional
            Axes to draw into.  By default, a new figure is created.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            As `relative`.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.gradient(hc.Chain.uniform(5), "pulse.velocity@5", to="radii").plot().get_ylabel()
        'velocity of bead 5:\\nchange [%] per 1% of the radius'
        """
        from ..plotting.gradients import plot_gradient

        return plot_gradient(self, name, ax=ax)

    @property
    def _remarks(self) -> list[str]:
        """Status, forces on the wall that a later impact may exceed, and kinks."""
        chain = self._chain
        on_wall = self.quantity.startswith("wall_force")
        later = on_wall and chain is not None and not motion_can_escape(chain, RIGHT)
        kinks = [kink_note(self.kinks)] if self.kinks else []
        return [self.status] + [LATER_IMPACTS] * later + kinks

    def __repr__(self) -> str:
        units = {name: f" [{unit}]" if unit else "" for name, unit in self.units.items()}
        names = "derivatives by " + ", ".join(f"{name}{units[name]}" for name in self.gradient)
        value = f"{self.value:.6g}" + (f" {self.unit}" if self.unit not in ("", "1") else "")
        return short(
            "Gradient", f"{self.quantity} = {value}", names,
            f"relative error about {self.error:.1g}",
            "" if self.method == "adjoint" else f"by {self.method}", *self._remarks,
            f"in % per 1%: relative({next(iter(self.gradient))!r})",
        )  # fmt: skip

    def _repr_html_(self) -> str:
        from ..notebook.gradients import gradient_html

        return gradient_html(self)

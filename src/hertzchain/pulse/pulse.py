"""The leading pulse, one row per bead: the result of every simulation and every theory.

`Pulse.compare` compares two of them.  A quantity that a method does not predict is `None`.  A value
that a run has not determined is NaN, with the reason in ``notes``.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from ..chain.chain import Chain
from ..chain.feature_support import require_chain
from ..collision import Array
from ..errors import InputError
from ..representation import listed, measure, percent, short
from ..validation.entries import NoEntries
from ..validation.keywords import checked_fields, checked_methods
from ..validation.numbers import number
from ..validation.objects import check_choice, check_type, text
from .alternating_speed import alternates_at, over_two_contacts
from .checked_column import checked_column
from .columns import Columns, derive, with_columns
from .notes import WARNING, checked_notes, notes_in_words
from .quantities import BEAD_QUANTITIES, COLUMN_QUANTITIES, QUANTITIES

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes

    from .comparison import Comparison


# Methods whose error is that of an integration.
SIMULATIONS: Final = ("simulation", "propagation")
# Method of pulses of large beads alone, whose values at small beads are NaN.
EFFECTIVE_CHAIN: Final = "effective chain"
NOT_ESTIMATED: Final = (
    "this theory does not estimate its error; hc.scoreboard() measures it in classes of chains"
)


@checked_fields
@checked_methods
@dataclass(frozen=True, eq=False)
@with_columns
class Pulse(Columns, NoEntries):
    r"""The effect of the leading pulse on each bead of a chain.

    Its columns are the quantities of `hertzchain.pulse.quantities.QUANTITIES`, in scaled variables
    or, for a chain in SI units, in SI units.  Beads have numbers from 1, arrays start at 0:
    :doc:`/reference/numbering`.

    Attributes
    ----------
    chain : Chain
        The chain along which it travelled.
    method : str
        The method that computed it, such as ``"simulation"`` or ``"BCA"``.
    velocity : ndarray, shape (N,)
        First local maximum :math:`v_k` of each bead's velocity [scaled, or m/s].  For bead 1, which
        moves first, it is the impact velocity; for the last bead, the velocity with which it
        leaves the chain.
    peak_time : ndarray, shape (N,), or None
        Time of that maximum [scaled, or s].
    arrival : ndarray, shape (N,), or None
        Time :math:`t_k` at which bead k overtakes bead k - 1, and at which the overlap of contact
        k - 1 is largest [scaled, or s]; 0 for bead 1.
    peak_overlap : ndarray, shape (N - 1,), or None
        First maximum of the overlap of each contact [scaled, or m].
    residence : ndarray, shape (N - 1,), or None
        Residence time :math:`T_k = t_{k+1} - t_k` on bead k [scaled, or s]; from the arrivals if
        not given.  In strongly heterogeneous chains the pulse may arrive at beads out of order, and
        the residence time may be negative; among several strikers it is not defined.
    velocity_error : ndarray, shape (N,), or None
        Estimated relative error of each velocity, if the method estimates it; 0 for bead 1, and
        NaN where the error is unknown.  It exceeds 96% or more of the errors in each class of
        random chains, but errors in one chain are correlated.
    velocity_spread, arrival_spread : ndarray, shape (N,), or None
    peak_force_spread : ndarray, shape (N - 1,), or None
        Standard deviations of ln v, ln t and ln F over random chains, by `disorder`.
    notes : dict of str
        For each quantity with missing values, where it is NaN and why; also where a quantity has
        another meaning than usual.  A column without a note has no NaN.  The note ``"warning"`` has
        the warnings of a theory about a chain outside its range.
    restitution : float
        Coefficient of restitution of a theory that considers collisions of two beads one after the
        other; 1 for every other method.

    Examples
    --------
    >>> import hertzchain as hc
    >>> pulse = hc.bca(hc.Chain.tapered("backward-exponential", 0.05, beads=4))
    >>> pulse.momentum.round(4)
    array([1.    , 1.0768, 1.1595, 1.2485])
    """

    chain: Chain
    method: str
    velocity: Array
    peak_time: Array | None = None
    arrival: Array | None = None
    peak_overlap: Array | None = None
    residence: Array | None = None
    velocity_error: Array | None = None
    velocity_spread: Array | None = None
    arrival_spread: Array | None = None
    peak_force_spread: Array | None = None
    notes: Mapping[str, str] = field(default_factory=dict)
    restitution: float = 1.0

    def __post_init__(self) -> None:
        require_chain("Pulse", self.chain)
        text("method of a pulse", self.method)
        object.__setattr__(self, "notes", checked_notes(self.notes))
        number("restitution of a pulse", self.restitution, above=0.0, most=1.0)
        if self.velocity is None:
            raise InputError("a pulse requires the velocity of each bead, got None")
        for quantity in QUANTITIES.values():
            if quantity.stored:
                values = getattr(self, quantity.name)
                values = derive(self, quantity) if values is None else values
                if values is not None:
                    checked = checked_column(self, quantity, values)
                    object.__setattr__(self, quantity.name, checked)

    def _input(self, name: str) -> Any:
        """An input of the formula of a quantity: another quantity, or an array of the chain."""
        return getattr(self if name in QUANTITIES else self.chain, name)

    @property
    def bead(self) -> np.ndarray[Any, np.dtype[np.int64]]:
        """Bead numbers k = 1..N, shape (N,)."""
        return np.arange(1, self.chain.beads + 1)

    @property
    def momentum(self) -> Array:
        """Momentum P_k = m_k v_k [scaled, or N s], shape (N,)."""
        found: Array = derive(self, QUANTITIES["momentum"])
        return found

    @property
    def energy(self) -> Array:
        """Kinetic energy E_k = m_k v_k^2 / 2 [scaled, or J], shape (N,)."""
        found: Array = derive(self, QUANTITIES["energy"])
        return found

    @property
    def peak_force(self) -> Array | None:
        """Force of contact k at its largest overlap, F = r_k d^p [scaled, or N], shape (N - 1,).

        If the contact yields, it is the force of its loading curve.  It does not include the force
        of a damping law, with which the largest force is larger and earlier: see `Run.forces`.
        """
        found: Array | None = derive(self, QUANTITIES["peak_force"])
        return found

    @property
    def speed(self) -> Array | None:
        r"""Speed of the pulse from contact to contact, shape (N - 1,).

        .. math:: V_k = \frac{D_k}{T_k}

        with the initial distance :math:`D_k` of the centres of beads k and k + 1 and the residence
        time :math:`T_k`; :math:`1/T_k` is the speed in beads per time.  In m/s for a chain in SI
        units, otherwise in radii :math:`R_1'` per unit of time.  `None` if the method does not
        predict residence times.  If the masses alternate, so does the speed, and that of the pulse
        is the mean over two contacts, :math:`(D_k + D_{k+1})/(T_k + T_{k+1})`.  It is negative
        where a light bead reaches its maximum before the heavy one behind it.  The speed to the
        last bead of a free end differs from the others, because no bead ahead delays the arrival.

        In equal beads of mass m with contacts of stiffness k, and p = 3/2, it tends to
        :math:`V = 0.9074700784\,(k/m)^{2/5} v^{1/5}` beads per time, with the velocity v of
        a bead at its maximum (`hertzchain.solitary_wave`).

        Examples
        --------
        Balls of bearing steel of 10 mm diameter, struck with 0.4 m/s:

        >>> import hertzchain as hc
        >>> chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=60, velocity=0.4)
        >>> pulse = hc.simulate(chain).pulse()
        >>> print(f"{pulse.speed[40]:.2f} m/s, {1 / pulse.residence[40]:.0f} beads/s")
        561.69 m/s, 56169 beads/s
        """
        found: Array | None = derive(self, COLUMN_QUANTITIES["speed"])
        return found

    def unit(self, quantity: str) -> str:
        """Unit of a quantity, ``"1"`` if it is scaled.

        Parameters
        ----------
        quantity : str
            A name in `hertzchain.pulse.quantities.COLUMN_QUANTITIES`.

        Raises
        ------
        InputError
            If there is no such quantity.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.bca(hc.Chain.uniform(3)).unit("peak_force")
        '1'
        """
        check_choice("quantity", quantity, COLUMN_QUANTITIES)
        return COLUMN_QUANTITIES[quantity].unit_in(self.chain.units)

    def _predicted(self, quantity: str) -> Array:
        """A quantity; an error lists those that the method predicts."""
        values = self.column(quantity)
        if values is None:
            names = listed([*self.columns()])
            hint = "; disorder predicts it" if quantity.endswith("_spread") else ""
            if quantity == "speed":
                hint = (
                    "; the speed of the pulse follows from residence times, which it does not have"
                )
            raise InputError(f"{self.method} does not predict {quantity}, only {names}{hint}")
        return values

    def compare(self, reference: Pulse) -> Comparison:
        """Compare this pulse with another one of the same chain.

        Parameters
        ----------
        reference : Pulse
            The pulse with which it is compared.

        Returns
        -------
        Comparison
            Relative errors per bead; ``print`` shows the largest and the root mean square.

        Raises
        ------
        InputError
            If the two chains differ.

        Warns
        -----
        ModelRangeWarning
            If one pulse is of a theory with a coefficient of restitution and the chain of the
            other has a loss law: the theory overestimates the loss.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(30)
        >>> comparison = hc.bca(chain).compare(hc.propagate(chain))
        >>> round(comparison.worst("velocity"), 2)
        0.47
        """
        from .comparison import Comparison

        return Comparison(self, reference)

    def to_xarray(self) -> xr.Dataset:
        """Labelled dataset with coordinate ``bead`` = 1..N and ``contact`` = 1..N-1.

        Returns
        -------
        xarray.Dataset
            One variable per quantity, with its unit (if not scaled), description and symbol.

        Examples
        --------
        >>> import hertzchain as hc
        >>> dataset = hc.bca(hc.Chain.uniform(5)).to_xarray()
        >>> float(dataset.velocity.sel(bead=5))
        1.0
        """
        import xarray as xr

        units = self.chain.units
        variables: dict[str, tuple[object, ...]] = {}
        for name, values in self.columns().items():
            attributes = QUANTITIES[name].attributes(units)
            if name in self.notes:
                attributes["comment"] = self.notes[name]
            variables[name] = (QUANTITIES[name].per, values, attributes)
        for name, values in (("radius", self.chain.radii), ("mass", self.chain.masses)):
            variables[name] = ("bead", values, BEAD_QUANTITIES[name].attributes(units))
        return xr.Dataset(
            variables,
            coords={"bead": self.bead, "contact": self.bead[:-1]},
            attrs={"chain": self.chain.description, "method": self.method}
            | ({WARNING: self.notes[WARNING]} if WARNING in self.notes else {}),
        )

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per bead; a quantity of contact k is in row k.

        Returns
        -------
        pandas.DataFrame
            Indexed by ``bead``; the last row is NaN in columns of contacts.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.bca(hc.Chain.uniform(5)).to_dataframe().velocity.loc[5].item()
        1.0
        """
        import pandas as pd

        columns = {
            name: pd.Series(values, index=self.bead[: len(values)])
            for name, values in self.columns().items()
        }
        table = pd.DataFrame(columns, index=pd.Index(self.bead, name="bead"))
        table.attrs["units"] = {
            name: QUANTITIES[name].unit_in(self.chain.units) for name in columns
        }
        return table

    def save(self, path: str | os.PathLike[str]) -> None:
        """Save the pulse: ``.nc`` (netCDF) or ``.csv``, by the file's extension.

        `hertzchain.load_pulse` reads a netCDF file as the same pulse again.

        Parameters
        ----------
        path : path-like
            File to write; an existing file is replaced when the new one is complete.

        Raises
        ------
        InputError
            For another extension, or if the file cannot be written.

        Examples
        --------
        >>> import hertzchain as hc, tempfile
        >>> from pathlib import Path
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     hc.propagate(hc.Chain.uniform(9)).save(Path(folder) / "pulse.nc")
        """
        from ..store.pulse_files import save_pulse

        save_pulse(self, path)

    def plot(
        self,
        quantity: str = "velocity",
        *,
        label: str | None = None,
        log: bool = False,
        legend: bool = True,
        ax: Axes | None = None,
    ) -> Axes:
        """Plot one quantity against the bead number.

        Parameters
        ----------
        quantity : str
            ``"velocity"``, ``"momentum"``, ``"energy"``, ``"arrival"``, ``"peak_force"`` or another
            name in ``pulse.columns()``, or ``"speed"``.
        label : str, optional
            Name in the legend; by default the method.
        log : bool
            Whether the y axis is logarithmic.
        legend : bool
            Whether the axes have a legend.
        ax : matplotlib.axes.Axes, optional
            Axes to draw into, which may have other pulses or another quantity, which the legend
            and the label of the y axis then name.  By default, a new figure is created.

        Examples
        --------
        >>> import hertzchain as hc
        >>> axes = hc.bca(hc.Chain.uniform(5)).plot("arrival", log=True)
        >>> axes.get_xlabel(), axes.get_yscale()
        ('bead $k$', 'log')
        """
        from ..plotting.pulses import plot_pulses

        labels = None if label is None else [text("label", label)]
        return plot_pulses([self], quantity, labels=labels, log=log, legend=legend, ax=ax)

    def __repr__(self) -> str:
        return short("Pulse", self.method, self.chain.description, self._main_numbers(4))

    def __str__(self) -> str:
        names = ", ".join(self.columns())
        lines = [f"{self.method}, {self.chain.description}"]
        lines.append(f"  {self._main_numbers(9)}; has {names}")
        return "\n".join(lines + [f"  {note}" for note in self._all_notes()])

    def _main_numbers(self, digits: int) -> str:
        """Velocity of the last bead; speed and, in SI units, force in the middle of the chain."""
        units, contact = self.chain.units, self.chain.beads // 2
        alternating = alternates_at(self.speed, contact)
        spread = "" if self.velocity_spread is None else f" +- {percent(self.velocity_spread[-1])}"
        middle = [
            f"{name} {measure(values[contact - 1], unit, units)}"
            for name, values, unit in (
                ("speed", None if alternating else self.speed, "m/s"),
                ("force", self.peak_force if units == "SI" else None, "N"),
            )
            if values is not None and np.isfinite(values[contact - 1])
        ]
        shown = f"v_{self.chain.beads} = {measure(self.velocity[-1], 'm/s', units, digits)}{spread}"
        if alternating and self.residence is not None:
            shown += f"; speed {over_two_contacts(self.chain, self.residence, contact)}"
        return f"{shown}; {', '.join(middle)} at contact {contact}" if middle else shown

    def _all_notes(self) -> list[str]:
        """The notes, and a sentence about the error that a theory estimates, or does not."""
        found = notes_in_words(self.notes, (*QUANTITIES, WARNING))
        if self.velocity_error is not None and np.isfinite(self.velocity_error[1:]).any():
            k = int(np.nanargmax(self.velocity_error))
            size = f"{percent(self.velocity_error[k])} (bead {k + 1})"
            known = " where it is known" if np.isnan(self.velocity_error).any() else ""
            found.append(f"largest estimated error of the velocity{known}: {size}")
        if self.velocity_error is None and self.method not in SIMULATIONS:
            found.append(NOT_ESTIMATED)
        return found

    def _repr_html_(self) -> str:
        from ..notebook.pulses import pulse_html

        return pulse_html(self)


def checked_pulse(name: str, given: Any) -> Pulse:
    """A pulse, also from that of an effective chain."""
    pulse = given._as_pulse() if hasattr(given, "_as_pulse") else given
    of_run = "that of a run is run.pulse()"
    hint = of_run if hasattr(pulse, "pulse") else "propagate and the theories return one"
    check_type(name, pulse, Pulse, hint)
    return pulse


# Values of all fields that have a default.
_DEFAULTS = {item.name: item.default for item in fields(Pulse) if item.default is not MISSING}


def assemble_pulse(**columns: Any) -> Pulse:
    """A pulse of new read-only columns that need no checks, which would take 20 microseconds."""
    pulse = Pulse.__new__(Pulse)
    pulse.__dict__.update({**_DEFAULTS, "notes": {}, **columns})
    return pulse

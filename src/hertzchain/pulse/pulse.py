"""The leading pulse, a row per bead: the one result of every simulation and every theory.

A `Pulse` says what passed each bead; `compare` holds two of them against each
other.  What a method does not predict is `None`, and what a run has not seen is NaN with
a reason in ``notes``, never a number that looks like a prediction.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from hertzchain.arguments import one_of, text
from hertzchain.chain.chain import Chain
from hertzchain.chain.coverage import check_chain
from hertzchain.checks import number, real_numbers
from hertzchain.contacts import Array
from hertzchain.errors import InputError
from hertzchain.frozen import Frozen
from hertzchain.pulse.comparison import Comparison
from hertzchain.pulse.notes import checked_notes, notes_in_words
from hertzchain.pulse.quantities import PER_CONTACT, QUANTITIES, SI_UNITS, Quantity

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes

    from hertzchain.chain.scales import Scales


@dataclass(frozen=True, eq=False)
class Pulse(Frozen):
    r"""What the leading pulse does to each bead of a chain.

    Attributes
    ----------
    chain : Chain
        The chain it ran along.
    method : str
        What computed it, such as ``"simulation"`` or ``"BCA"``.
    velocity : ndarray, shape (N,)
        First local maximum :math:`v_k` of each bead's velocity [scaled]; bead 1
        is the striker and has its strike velocity, the last bead the velocity
        with which it leaves the chain.
    peak_time : ndarray, shape (N,), or None
        Time of that maximum [scaled].
    arrival : ndarray, shape (N,), or None
        Time :math:`t_k` at which bead k overtakes bead k - 1, the moment of
        largest overlap of contact k - 1 [scaled]; 0 for bead 1.
    peak_overlap : ndarray, shape (N - 1,), or None
        First maximum of the overlap of each contact [scaled].
    residence : ndarray, shape (N - 1,), or None
        Residence time :math:`T_k = t_{k+1} - t_k` on bead k [scaled]; from the arrivals if
        not given.  In strongly uneven chains arrivals need not be in order, and it may be
        negative; among several strikers it is not defined.
    velocity_error : ndarray, shape (N,), or None
        Estimated relative error of each velocity, by a method that estimates one; 0 for bead 1.
    notes : dict of str
        By the name of a quantity, where it is NaN and why, or where it means something else
        than usual.  A column without a note has no NaN.
    restitution : float
        Coefficient of restitution of a theory that lets one pair of beads collide at a time; 1
        for every other method.

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
    notes: Mapping[str, str] = field(default_factory=dict)
    restitution: float = 1.0

    def __post_init__(self) -> None:
        check_chain("Pulse", self.chain)
        text("method of a pulse", self.method)
        object.__setattr__(self, "notes", checked_notes(self.notes))
        number("restitution of a pulse", self.restitution, above=0.0, most=1.0)
        if self.velocity is None:
            raise InputError("a pulse has at least the velocity of each bead, got None")
        beads = self.chain.beads
        for name in (
            "velocity", "peak_time", "arrival", "peak_overlap", "residence", "velocity_error",
        ):  # fmt: skip
            values = getattr(self, name)
            if name == "residence" and values is None and self.arrival is not None:
                values = np.diff(self.arrival)
            if values is not None:
                length = beads - 1 if name in PER_CONTACT else beads
                object.__setattr__(self, name, _checked_column(self, name, values, length))

    def factors(self, scales: Scales) -> Mapping[str, float]:
        """Units of the columns, for `hertzchain.Scales`.

        Parameters
        ----------
        scales : Scales
            The units.

        Returns
        -------
        dict

        Examples
        --------
        >>> import hertzchain as hc
        >>> scales = hc.Scales(radius=1.0, mass=1.0, velocity=2.0, length=1.0)
        >>> hc.bca(hc.Chain.uniform(3)).factors(scales)["velocity"]
        2.0
        """
        times = dict.fromkeys(("peak_time", "arrival", "residence"), scales.time)
        return {"velocity": scales.velocity, "peak_overlap": scales.length} | times

    @property
    def bead(self) -> np.ndarray[Any, np.dtype[np.int64]]:
        """Bead numbers k = 1..N, shape (N,)."""
        return np.arange(1, self.chain.beads + 1)

    @property
    def momentum(self) -> Array:
        """Momentum P_k = m_k v_k [scaled], shape (N,)."""
        return self.chain.masses * self.velocity

    @property
    def energy(self) -> Array:
        """Kinetic energy E_k = m_k v_k^2 / 2 [scaled], shape (N,)."""
        return 0.5 * self.momentum * self.velocity

    @property
    def peak_force(self) -> Array | None:
        """Largest force F = r_k d^p of contact k [scaled], shape (N - 1,)."""
        if self.peak_overlap is None:
            return None
        return self.chain.stiffness * self.peak_overlap**self.chain.exponent

    @property
    def speed(self) -> Array | None:
        r"""Speed with which the pulse runs from contact to contact, shape (N - 1,).

        .. math:: V_k = \frac{D_k}{T_k}

        with the distance :math:`D_k` of the centres of beads k and k + 1, which touch at
        first, and the residence time :math:`T_k`; :math:`1/T_k` is the speed in beads per
        time.  In m/s for a chain in SI units, otherwise in radii :math:`R_1'` per unit of
        time.  `None` if the method does not predict residence times.

        In equal beads of mass m with contacts of stiffness k, and p = 3/2, it becomes
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
        return None if self.residence is None else self.chain.centre_distances / self.residence

    def column(self, quantity: Quantity) -> Array | None:
        """One quantity by its name, as the attribute of that name.

        Parameters
        ----------
        quantity : str
            A key of `hertzchain.pulse.pulse.QUANTITIES`.

        Returns
        -------
        ndarray or None
            `None` if the method does not predict it.

        Raises
        ------
        InputError
            If there is no such quantity.

        Examples
        --------
        >>> import hertzchain as hc
        >>> float(hc.bca(hc.Chain.uniform(3)).column("velocity")[2])
        1.0
        """
        one_of("quantity", quantity, QUANTITIES)
        values: Array | None = getattr(self, quantity)
        return values

    def unit(self, quantity: Quantity) -> str:
        """Unit of a quantity, ``"1"`` if it is scaled.

        Parameters
        ----------
        quantity : str
            A key of `hertzchain.pulse.pulse.QUANTITIES`.

        Returns
        -------
        str

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
        one_of("quantity", quantity, QUANTITIES)
        return SI_UNITS[quantity] if self.chain.units == "SI" else "1"

    def columns(self) -> dict[Quantity, Array]:
        """Every quantity that the method predicts, by name.

        Returns
        -------
        dict
            Arrays of length N, or N - 1 for quantities of a contact.

        Examples
        --------
        >>> import hertzchain as hc
        >>> list(hc.modified_bca(hc.Chain.tapered("forward-linear", 0.005, beads=9)).columns())
        ['velocity', 'momentum', 'energy']
        """
        found = {name: self.column(name) for name in QUANTITIES}
        return {name: values for name, values in found.items() if values is not None}

    def compare(self, reference: Pulse) -> Comparison:
        """Hold this pulse against another one of a chain with the same radii.

        Parameters
        ----------
        reference : Pulse
            The pulse to measure errors from.

        Returns
        -------
        Comparison
            Relative errors per bead; ``print`` shows the worst and typical ones.

        Raises
        ------
        InputError
            If the two chains differ.

        Warns
        -----
        ModelRangeWarning
            If one is by a theory with a coefficient of restitution, and the other of a chain
            with a law of loss: the theory loses too much.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(30)
        >>> comparison = hc.bca(chain).compare(hc.propagate(chain))
        >>> round(comparison.worst("velocity"), 2)
        0.47
        """
        return Comparison(self, reference)

    def to_xarray(self) -> xr.Dataset:
        """Labelled dataset with coordinate ``bead`` = 1..N and ``contact`` = 1..N-1.

        Returns
        -------
        xarray.Dataset
            One variable a quantity, with units ("1" if scaled) and long names.

        Examples
        --------
        >>> import hertzchain as hc
        >>> dataset = hc.bca(hc.Chain.uniform(5)).to_xarray()
        >>> float(dataset.velocity.sel(bead=5))
        1.0
        """
        import xarray as xr

        variables: dict[str, object] = {
            str(name): (
                "contact" if name in PER_CONTACT else "bead",
                values,
                {"units": self.unit(name), "long_name": QUANTITIES[name][1]}
                | ({"comment": self.notes[name]} if name in self.notes else {}),
            )
            for name, values in self.columns().items()
        }
        length, mass = ("m", "kg") if self.chain.units == "SI" else ("1", "1")
        variables["radius"] = ("bead", self.chain.radii, {"units": length, "long_name": "radius"})
        variables["mass"] = ("bead", self.chain.masses, {"units": mass, "long_name": "mass"})
        return xr.Dataset(
            variables,
            coords={"bead": self.bead, "contact": self.bead[:-1]},
            attrs={"chain": self.chain.description, "method": self.method},
        )

    def to_dataframe(self) -> pd.DataFrame:
        """Table with a row per bead; a quantity of contact k stands in row k.

        Returns
        -------
        pandas.DataFrame
            Indexed by ``bead``; the last row has no contact and is NaN there.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.bca(hc.Chain.uniform(5)).to_dataframe().velocity.loc[5].item()
        1.0
        """
        import pandas as pd

        columns = {
            str(name): pd.Series(values, index=self.bead[: len(values)])
            for name, values in self.columns().items()
        }
        return pd.DataFrame(columns, index=pd.Index(self.bead, name="bead"))

    def plot(self, quantity: Quantity = "velocity", *, ax: Axes | None = None) -> Axes:
        """Draw one quantity against the bead number.

        Parameters
        ----------
        quantity : str
            Name of the quantity.
        ax : matplotlib.axes.Axes, optional
            Axes to draw into; a new figure's if not given.

        Returns
        -------
        matplotlib.axes.Axes

        Examples
        --------
        >>> import hertzchain as hc
        >>> axes = hc.bca(hc.Chain.uniform(5)).plot("arrival")
        >>> axes.get_xlabel()
        'bead $k$'
        """
        from hertzchain.plotting.pulses import plot_pulses

        return plot_pulses([self], quantity, ax=ax)

    def __repr__(self) -> str:
        return f"Pulse({self.method}: {self.chain.description})"

    def __str__(self) -> str:
        names = ", ".join(self.columns())
        last = f"v_{self.chain.beads} = {self.velocity[-1]:.9g}"
        lines = [f"{self.method}, {self.chain.description}", f"  {last}; has {names}"]
        return "\n".join(lines + [f"  {note}" for note in notes_in_words(self.notes)])

    def _repr_html_(self) -> str:
        title = f"<p><b>{escape(self.method)}</b>, {escape(self.chain.description)}</p>"
        return title + str(self.to_dataframe().to_html(max_rows=12, na_rep="", float_format="%.6g"))


def _checked_column(pulse: Pulse, name: str, given: ArrayLike, length: int) -> Array:
    """Read-only copy of a column, unless it could only mislead."""
    place = "contact" if name in PER_CONTACT else "bead"
    values = real_numbers(name, given, place).copy()
    if values.shape != (length,):
        raise InputError(f"{name} of a pulse must have shape ({length},), got {values.shape}")
    good = np.isfinite(values)
    explained = np.isnan(values) & (name in pulse.notes)
    if name == "residence":
        good &= values != 0.0  # out of order is possible, no time at all is a lost digit
    else:
        # Strikers have their velocity from the start.
        known = max(1, pulse.chain.strikers)
        first = known if name in ("arrival", "peak_time", "velocity_error") else 0
        good[first:] &= values[first:] > 0.0
    good |= explained
    if not good.all():
        k = int(np.argmin(good))
        raise InputError(
            f"{name} of {place} {k + 1} is {values[k]:g} by {pulse.method} for the chain "
            f"{pulse.chain.description}: it must be positive and finite; if it underflows or "
            "overflows, use fewer beads or a weaker taper"
        )
    values.setflags(write=False)
    return values

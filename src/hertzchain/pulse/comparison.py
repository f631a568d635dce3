"""Comparison of two pulses of the same chain, bead by bead."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from ..collision import Array
from ..errors import InputError, ModelRangeWarning, warn_user
from ..representation import percent, short
from ..validation.keywords import checked_fields, checked_methods
from ..validation.numbers import whole_number
from ..validation.objects import check_bool, check_choice
from .chain_units import in_same_units, same_beads
from .free_end import ends_free
from .pulse import EFFECTIVE_CHAIN, Pulse, checked_pulse
from .quantities import COLUMN_QUANTITIES, ON_REQUEST, QUANTITIES

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

# Quantities that are plotted by default.
DRAWN: Final[tuple[str, ...]] = ("velocity", "arrival", "residence", "peak_force")
# Bead from which the first beads, where the pulse forms, no longer dominate errors of arrivals.
FORMED: Final = 11
BEFORE_END: Final = "without the last bead, at the free end"


@checked_fields
@checked_methods
@dataclass(frozen=True, eq=False)
class Comparison:
    """Relative errors of one pulse with respect to another of the same chain.

    If one pulse is in SI units and the other is scaled, the scaled one is converted.

    Attributes
    ----------
    pulse : Pulse
        The pulse that is evaluated.
    reference : Pulse
        The pulse with which it is compared.

    Raises
    ------
    InputError
        If the chains differ.

    Warns
    -----
    ModelRangeWarning
        As for `Pulse.compare`.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.tapered("backward-exponential", 0.05, beads=50)
    >>> comparison = hc.bca(chain).compare(hc.propagate(chain))
    >>> comparison.worst_bead("velocity") > 40
    True
    """

    pulse: Pulse
    reference: Pulse

    def __post_init__(self) -> None:
        for name in ("pulse", "reference"):
            object.__setattr__(self, name, checked_pulse(name, getattr(self, name)))
        pulse, reference = in_same_units(self.pulse, self.reference)
        object.__setattr__(self, "pulse", pulse)
        object.__setattr__(self, "reference", reference)
        ours, theirs = pulse.chain, reference.chain
        if not same_beads(ours, theirs):
            raise InputError(
                "pulses of different chains cannot be compared: "
                f"{ours.description} and {theirs.description}"
            )
        _warn_of_restitution(self.pulse, self.reference)
        _warn_of_restitution(self.reference, self.pulse)

    def errors(self, quantity: str) -> Array:
        """Relative errors, (pulse - reference) / reference, bead by bead.

        Where the reference is 0, as the arrival and peak time of bead 1, the error is the
        difference.

        Parameters
        ----------
        quantity : str
            Name of the quantity.

        Returns
        -------
        ndarray
            Shape (N,), or (N - 1,) for quantities per contact.

        Raises
        ------
        InputError
            If one of the two methods does not predict the quantity, or it is unknown.

        Examples
        --------
        >>> import hertzchain as hc
        >>> pulse = hc.bca(hc.Chain.uniform(3))
        >>> pulse.compare(pulse).errors("velocity")
        array([0., 0., 0.])
        """
        if not (isinstance(quantity, str) and quantity in COLUMN_QUANTITIES):
            check_choice("quantity", quantity, self.quantities)
        ours, theirs = self.pulse._predicted(quantity), self.reference._predicted(quantity)
        return (ours - theirs) / np.where(theirs == 0.0, 1.0, theirs)

    @property
    def quantities(self) -> list[str]:
        """Names of the quantities that both methods predict."""
        theirs = self.reference.columns()
        ours = (name for name in self.pulse.columns() if not QUANTITIES[name].estimate)
        return [name for name in ours if name in theirs]

    def worst(self, quantity: str, *, first_bead: int = 2, last_bead: int | None = None) -> float:
        """Largest absolute relative error of a range of beads, where both pulses have a value.

        Parameters
        ----------
        quantity : str
            Name of the quantity.
        first_bead : int
            First bead (or contact) that is considered.
        last_bead : int, optional
            Last bead (or contact) that is considered, by default that of the chain.  Most
            theories do not describe the last bead of a free end.

        Examples
        --------
        >>> import hertzchain as hc
        >>> pulse = hc.bca(hc.Chain.uniform(3))
        >>> pulse.compare(pulse).worst("velocity")
        0.0
        """
        return self._reduce(quantity, first_bead, last_bead, lambda e: float(np.nanmax(e)))

    def rms(self, quantity: str, *, first_bead: int = 2, last_bead: int | None = None) -> float:
        """Root mean square of the relative errors of a range of beads, like `worst`.

        Parameters
        ----------
        quantity, first_bead, last_bead
            As for `worst`.

        Examples
        --------
        >>> import hertzchain as hc
        >>> pulse = hc.bca(hc.Chain.uniform(3))
        >>> pulse.compare(pulse).rms("momentum")
        0.0
        """
        return self._reduce(
            quantity, first_bead, last_bead, lambda e: float(np.sqrt(np.nanmean(e**2)))
        )

    def worst_bead(
        self, quantity: str, *, first_bead: int = 2, last_bead: int | None = None
    ) -> int:
        """Bead (or contact) number of the largest error.

        Parameters
        ----------
        quantity, first_bead, last_bead
            As for `worst`.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(30)
        >>> hc.bca(chain).compare(hc.propagate(chain)).worst_bead("velocity")
        28
        """
        return first_bead + int(
            self._reduce(quantity, first_bead, last_bead, lambda e: float(np.nanargmax(e)))
        )

    def to_dataframe(self) -> pd.DataFrame:
        """Table of the relative errors, with one row per bead; those of contact k are in row k.

        Returns
        -------
        pandas.DataFrame
            Indexed by ``bead``; columns are the `quantities`.  The last row is NaN in columns of
            contacts.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(30)
        >>> table = hc.bca(chain).compare(hc.propagate(chain)).to_dataframe()
        >>> round(table.velocity.loc[20].item(), 3)
        0.467
        """
        import pandas as pd

        beads = self.pulse.bead
        columns = {
            name: pd.Series(errors, index=beads[: len(errors)])
            for name in self.quantities for errors in (self.errors(name),)
        }  # fmt: skip
        return pd.DataFrame(columns, index=pd.Index(beads, name="bead"))

    def plot(
        self, quantity: str | None = None, *, log: bool = False, legend: bool = True,
        ax: Axes | None = None,
    ) -> Axes:  # fmt: skip
        """Plot the relative errors in percent, from bead or contact 2 on.

        Parameters
        ----------
        quantity : str, optional
            Name of the quantity; by default velocity, arrival, residence and peak force, if both
            methods predict them.
        log : bool
            Whether the y axis is logarithmic, with the absolute values of the errors.
        legend : bool
            Whether the axes have a legend.
        ax : matplotlib.axes.Axes, optional
            Axes to draw into.  By default, a new figure is created.

        Raises
        ------
        InputError
            If one of the two methods does not predict the quantity, or it is unknown.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(30)
        >>> axes = hc.bca(chain).compare(hc.propagate(chain)).plot()
        >>> axes.get_ylabel()
        'error [%]'
        """
        from ..plotting.comparisons import plot_comparison

        check_bool("log", log)
        check_bool("legend", legend)
        names = [name for name in DRAWN if name in self.quantities]
        if quantity is not None:
            names = [check_choice("quantity", quantity, (*self.quantities, *ON_REQUEST))]
        return plot_comparison(self, names, log=log, legend=legend, ax=ax)

    def _reduce(
        self, quantity: str, first_bead: int, last_bead: int | None,
        summary: Callable[[Array], float],
    ) -> float:  # fmt: skip
        errors = np.abs(self.errors(quantity))
        first_bead = whole_number(
            f"first_bead of {quantity}", first_bead, least=1, most=len(errors)
        )
        if last_bead is not None:
            last_bead = whole_number(
                f"last_bead of {quantity}", last_bead, least=first_bead, most=len(errors)
            )
        counted = errors[first_bead - 1 : last_bead]
        if np.isnan(counted).all():
            part = f"from {first_bead} on" if last_bead is None else f"{first_bead} to {last_bead}"
            raise InputError(f"no bead {part} has {quantity} in both pulses; see their notes")
        return summary(counted)

    def __repr__(self) -> str:
        worst = [
            f"{name} {percent(self.worst(name))} (k = {self.worst_bead(name)})"
            for name in self.quantities
            if not np.isnan(self.errors(name)[1:]).all()
        ]
        about = f"{self.pulse.method} against {self.reference.method}"
        return short(
            "Comparison", about, self.pulse.chain.description, f"largest errors {', '.join(worst)}",
            *([f"{BEFORE_END}: {before}"] if (before := self._errors_before_end) else []),
        )  # fmt: skip

    def __str__(self) -> str:
        return self._text(self.quantities)

    def _text(self, names: list[str]) -> str:
        """The errors of quantities as a table, with notes."""
        width = max(13, *map(len, names))
        # The law of disorder describes other chains than a simulation without scatter.
        what = (
            "effect of the scatter" if self.pulse.velocity_spread is not None else "relative errors"
        )
        lines = [
            f"{self.pulse.method} against {self.reference.method}, "
            f"{self.pulse.chain.description}; {what}, k >= 2",
            f"  {'quantity':<{width}}{'worst':>10}{'at k':>6}{'rms':>10}",
        ]
        for name in names:
            if np.isnan(self.errors(name)[1:]).all():
                continue  # Two beads have one contact; a run may not have determined other values.
            worst, rms = percent(self.worst(name)), percent(self.rms(name))
            lines.append(f"  {name:<{width}}{worst:>10}{self.worst_bead(name):>6}{rms:>10}")
        if before := self._errors_before_end:
            lines += [f"  {BEFORE_END}:", f"    {before}"]
        return "\n".join([*lines, *self._note_on_arrival()])

    @property
    def _errors_before_end(self) -> str:
        """Largest errors of the other beads, if the largest of all are those at a free end."""
        last, pair = self.pulse.chain.beads, (self.pulse, self.reference)
        names = [name for name in self.quantities if any(ends_free(each, name) for each in pair)]
        return ", ".join(
            f"{name} {percent(self.worst(name, last_bead=last - 1))}"
            for name in names
            if not np.isnan(self.errors(name)[1:-1]).all() and self.worst_bead(name) == last
        )

    def _note_on_arrival(self) -> list[str]:
        """Why the arrival of an effective chain has a large error, if that is at a first bead."""
        effective = EFFECTIVE_CHAIN in (self.pulse.method, self.reference.method)
        if not effective or "arrival" not in self.quantities or self.pulse.chain.beads < 2 * FORMED:
            return []
        if self.worst_bead("arrival") >= FORMED:
            return []
        later = percent(self.worst("arrival", first_bead=FORMED))
        return [
            "  arrival: at the first beads, times are short and the pulse has not formed;",
            f"    from bead {FORMED} on, the largest error is {later}",
        ]

    def _repr_html_(self) -> str:
        from ..notebook.pulses import comparison_html

        return comparison_html(self)


def _warn_of_restitution(theory: Pulse, other: Pulse) -> None:
    """Warn that a theory of single collisions overestimates the loss in a chain."""
    if theory.restitution < 1.0 and not other.chain.lossless:
        warn_user(
            f"{theory.method} assumes at every bead the loss of a collision of two beads, but in a "
            f"chain each contact is unloaded only in part. With {other.chain.loss}, the pulse "
            "decays less: at the same coefficient of restitution, the decay exponent is 1.2 to 3.4 "
            "times smaller. For a small loss in equal beads, use attenuation",
            ModelRangeWarning,
        )

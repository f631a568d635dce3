"""Two pulses of one chain held against each other, bead by bead."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hertzchain.checks import whole_number
from hertzchain.contacts import Array
from hertzchain.errors import InputError, ModelRangeWarning, shown
from hertzchain.pulse.quantities import Quantity

if TYPE_CHECKING:
    from hertzchain.pulse.pulse import Pulse


@dataclass(frozen=True, eq=False)
class Comparison:
    """Relative errors of one pulse, measured from another of the same chain.

    Attributes
    ----------
    pulse : Pulse
        The pulse judged.
    reference : Pulse
        What it is measured from.

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
            given = getattr(self, name)
            if not hasattr(given, "velocity_error"):
                raise InputError(
                    f"{name} must be a Pulse, got {shown(given)}; theories and propagate make one"
                )
        ours, theirs = self.pulse.chain, self.reference.chain
        same_law = (ours.exponent, ours.units) == (theirs.exponent, theirs.units)
        if not same_law or not all(
            np.array_equal(getattr(ours, name), getattr(theirs, name))
            for name in ("radii", "masses", "stiffness")
        ):
            raise InputError(
                "pulses of different chains cannot be compared: "
                f"{ours.description} and {theirs.description}"
            )
        _warn_of_restitution(self.pulse, self.reference)
        _warn_of_restitution(self.reference, self.pulse)

    def errors(self, quantity: Quantity) -> Array:
        """Relative errors, (ours - reference) / reference, bead by bead.

        The start of the clock is no prediction: arrival and peak times of bead 1
        are compared as differences (both are 0).

        Parameters
        ----------
        quantity : str
            Name of the quantity.

        Returns
        -------
        ndarray
            Shape (N,), or (N - 1,) for quantities of a contact.

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
        ours, theirs = self.pulse.column(quantity), self.reference.column(quantity)
        if ours is None or theirs is None:
            missing = self.pulse if ours is None else self.reference
            raise InputError(f"{missing.method} does not predict {quantity}")
        return (ours - theirs) / np.where(theirs == 0.0, 1.0, theirs)

    @property
    def quantities(self) -> list[Quantity]:
        """Names of the quantities that both methods predict."""
        theirs = self.reference.columns()
        estimate = "velocity_error"
        return [name for name in self.pulse.columns() if name in theirs and name != estimate]

    def worst(self, quantity: Quantity, *, first_bead: int = 2) -> float:
        """Largest absolute relative error from ``first_bead`` on, of the beads that both have.

        Parameters
        ----------
        quantity : str
            Name of the quantity.
        first_bead : int
            First bead (or contact) that counts.

        Returns
        -------
        float

        Examples
        --------
        >>> import hertzchain as hc
        >>> pulse = hc.bca(hc.Chain.uniform(3))
        >>> pulse.compare(pulse).worst("velocity")
        0.0
        """
        return self._reduce(quantity, first_bead, lambda e: float(np.nanmax(e)))

    def rms(self, quantity: Quantity, *, first_bead: int = 2) -> float:
        """Root mean square of the relative errors from ``first_bead`` on, as of `worst`.

        Parameters
        ----------
        quantity, first_bead
            As for `worst`.

        Returns
        -------
        float

        Examples
        --------
        >>> import hertzchain as hc
        >>> pulse = hc.bca(hc.Chain.uniform(3))
        >>> pulse.compare(pulse).rms("momentum")
        0.0
        """
        return self._reduce(quantity, first_bead, lambda e: float(np.sqrt(np.nanmean(e**2))))

    def worst_bead(self, quantity: Quantity, *, first_bead: int = 2) -> int:
        """Bead (or contact) number of the largest error.

        Parameters
        ----------
        quantity, first_bead
            As for `worst`.

        Returns
        -------
        int

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(30)
        >>> hc.bca(chain).compare(hc.propagate(chain)).worst_bead("velocity")
        28
        """
        return first_bead + int(
            self._reduce(quantity, first_bead, lambda e: float(np.nanargmax(e)))
        )

    def _reduce(
        self, quantity: Quantity, first_bead: int, summary: Callable[[Array], float]
    ) -> float:
        errors = np.abs(self.errors(quantity))
        first_bead = whole_number(
            f"first_bead of {quantity}", first_bead, least=1, most=len(errors)
        )
        counted = errors[first_bead - 1 :]
        if np.isnan(counted).all():
            raise InputError(
                f"no bead from {first_bead} on has {quantity} in both pulses: see their notes"
            )
        return summary(counted)

    def __str__(self) -> str:
        lines = [
            f"{self.pulse.method} against {self.reference.method}, "
            f"{self.pulse.chain.description}; relative errors, k >= 2",
            f"  {'quantity':<13}{'worst':>10}{'at k':>6}{'rms':>10}",
        ]
        for name in self.quantities:
            if np.isnan(self.errors(name)[1:]).all():
                continue  # two beads have one contact, and a run may not have seen any other
            worst, at, rms = self.worst(name), self.worst_bead(name), self.rms(name)
            lines.append(f"  {name:<13}{worst:>10.2%}{at:>6}{rms:>10.2%}")
        return "\n".join(lines)


def _warn_of_restitution(theory: Pulse, other: Pulse) -> None:
    """Single collisions lose more than the contacts of a chain do."""
    if theory.restitution < 1.0 and other.chain.loss is not None:
        warnings.warn(
            f"{theory.method} takes the loss of a collision of two beads at every bead, but in a "
            f"chain each contact is relieved in part only: under {other.chain.loss} the pulse "
            "decays less, at the same coefficient of restitution 1.2 to 3.4 times less in the "
            "exponent",
            ModelRangeWarning,
            stacklevel=5,
        )

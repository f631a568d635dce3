r"""Energy that passed each contact, to the right and to the left.

Where disorder breaks waves up after a few contacts, a list of waves says little; the energy that
flowed through each contact in either direction still does:

.. math:: E_k^\pm = \int \max(\pm f_k v_k, 0)\,dt

with force and velocity as in `hertzchain.simulation.wave_events`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hertzchain.chain.chain import Chain
from hertzchain.contacts import Array
from hertzchain.simulation.wave_events import (
    ContactCurves,
    check_saved_times,
    events_at,
    largest_force_of,
    require_resolved,
    sign_change,
)

if TYPE_CHECKING:
    import pandas as pd

    from hertzchain.simulation.run import Run


@dataclass(frozen=True, eq=False)
class EnergyFlux:
    """Energy that passed each contact from the first saved time to the last.

    Attributes
    ----------
    chain : Chain
        The chain.
    right, left : ndarray, shape (N - 1,)
        Energy that flowed towards bead N, and towards bead 1, through contact k between beads k
        and k + 1 [scaled, or J].  Energy that comes back and leaves again counts each time.
    """

    chain: Chain
    right: Array
    left: Array

    @property
    def net(self) -> Array:
        """Energy to the right less energy to the left, shape (N - 1,) [scaled, or J]."""
        return self.right - self.left

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per contact.

        Returns
        -------
        pandas.DataFrame
            Indexed by ``contact``; columns ``right``, ``left`` and ``net``.

        Examples
        --------
        >>> import hertzchain as hc
        >>> flux = hc.simulate(hc.Chain.uniform(30), until=30.0).energy_flux()
        >>> flux.to_dataframe().loc[15].round(4).tolist()
        [0.4968, 0.0, 0.4968]
        """
        import pandas as pd

        contacts = pd.Index(np.arange(1, self.chain.beads), name="contact")
        columns = {"right": self.right, "left": self.left, "net": self.net}
        return pd.DataFrame(columns, index=contacts)

    def __repr__(self) -> str:
        k = int(np.argmax(self.right)) + 1
        return (
            f"EnergyFlux({self.chain.description}: most to the right {self.right[k - 1]:.4g} at "
            f"contact {k}, to the left {self.left.max():.4g} at contact {self.left.argmax() + 1})"
        )


def energy_flux_of(run: Run) -> EnergyFlux:
    """Energy that passed each contact; see `hertzchain.Run.energy_flux`.

    Parameters
    ----------
    run : Run
        A run with saved times.

    Returns
    -------
    EnergyFlux

    Examples
    --------
    >>> import hertzchain as hc
    >>> flux = energy_flux_of(hc.simulate(hc.Chain.uniform(30), until=30.0))
    >>> bool(flux.left.max() < 0.02 * flux.right.max())
    True
    """
    check_saved_times(run)
    strongest = int(np.argmax(np.max(run.forces[:, 1:-1], axis=0))) + 1
    for event in events_at(run, strongest, 0.99 * largest_force_of(run)):
        require_resolved(run, event, "the strongest wave")
    flows = [_to_and_fro(ContactCurves(run, k)) for k in range(1, run.chain.beads)]
    right, left = np.array(flows).T
    return EnergyFlux(run.chain, right, left)


def _to_and_fro(curves: ContactCurves) -> tuple[float, float]:
    """Integrals of the positive and of the negative part of the power."""
    times, power = curves.times, curves.power
    turns = np.flatnonzero(power[:-1] * power[1:] < 0.0)
    turning = sign_change(curves.power_curve, times[turns], times[turns + 1])
    # An open contact between two waves has no power at all, and so no change of sign.
    edges = np.sort(np.concatenate((times[[0, -1]], turning, times[power == 0.0])))
    pieces = np.diff(curves.power_curve.antiderivative()(edges))
    return float(pieces[pieces > 0.0].sum()), float(-pieces[pieces < 0.0].sum())

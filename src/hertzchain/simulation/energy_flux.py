r"""Energy that passed each contact, to the right and to the left.

In disordered chains, waves break up after a few contacts, and a list of waves is of little use.
The energy that flowed through each contact in either direction is still meaningful:

.. math:: E_k^\pm = \int \max(\pm f_k v_k, 0)\,dt

with force and velocity as in `hertzchain.simulation.wave_events`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..frozen import Compared
from ..representation import measure, short
from ..validation.keywords import checked_methods
from .energy_balance import EnergyBalance, balance_of
from .trajectory import Trajectory
from .wave_events import (
    ContactCurves,
    check_saved_times,
    events_at,
    require_resolved,
    sign_change,
    static_forces_of,
)

if TYPE_CHECKING:
    import pandas as pd


@checked_methods
@dataclass(frozen=True, eq=False)
class EnergyFlux(Compared):
    """Energy that passed each contact from the first saved time to the last.

    Attributes
    ----------
    chain : Chain
        The chain.
    right, left : ndarray, shape (N - 1,)
        Energy that flowed towards bead N, and towards bead 1, through contact k between beads k
        and k + 1 [scaled, or J].  Energy that returns and passes again is counted each time.
    """

    chain: Chain
    right: Array
    left: Array

    @property
    def net(self) -> Array:
        """Energy to the right minus energy to the left, shape (N - 1,) [scaled, or J]."""
        return self.right - self.left

    def balance(self, before: int, after: int | str) -> EnergyBalance:
        """Parts of the energy that passed one contact, up to the end of the run.

        Use it where a single wave cannot be separated, so that `Run.reflection` raises an error.
        The balance is exact, but it includes all waves from the beginning to the end of the run:
        end it before waves return from the ends of the chain.

        Parameters
        ----------
        before, after : int
            Contacts on both sides of an interface or defect, in the direction of the wave.  For a
            wall or free end, ``after`` is N or 0; for a wall, also ``"wall"``, ``"right wall"`` or
            ``"left wall"``.

        Returns
        -------
        EnergyBalance
            The parts that returned, passed and remained, and the range of the first of them at
            neighbouring contacts.

        Raises
        ------
        InputError
            If there are no such contacts.
        SimulationError
            If no energy flows through ``before`` towards ``after``.

        Examples
        --------
        A dimer in front of equal beads; the pulse sheds waves:

        >>> import hertzchain as hc
        >>> import numpy as np
        >>> masses = np.ones(140)
        >>> masses[1:70:2] = 0.5
        >>> run = hc.simulate(hc.Chain.uniform(140).replace(masses=masses), until=130, times=4000)
        >>> run.energy_flux().balance(54, 70)
        EnergyBalance(contacts 54 to 70: incident energy 0.347, returned 0.0125 (0.0058 to 0.0132 at
            neighbouring contacts), passed 0.8347, kept 0.1528)
        """
        return balance_of(self.chain, (self.right, self.left), before, after)

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
        right, left = int(np.argmax(self.right)), int(np.argmax(self.left))
        units = self.chain.units
        return short(
            "EnergyFlux",
            self.chain.description,
            f"most to the right {measure(self.right[right], 'J', units)} at contact {right + 1}, "
            f"to the left {measure(self.left[left], 'J', units)} at contact {left + 1}",
        )

    def _repr_html_(self) -> str:
        from ..notebook.waves import energy_flux_html

        return energy_flux_html(self)


def energy_flux_of(self: Trajectory) -> EnergyFlux:
    """Energy that passed each contact, to the right and to the left.

    Use it for strongly disordered chains, in which waves last for a few contacts only, and for
    precompressed chains, in which rarefactions carry energy, too.

    Raises
    ------
    InputError
        If fewer than 8 times were saved during the passage of the strongest wave.

    See Also
    --------
    Run.reflection : Coefficients of single waves of compression, and the waves themselves.

    Notes
    -----
    The powers are quintic splines through the saved times.  With 8 of them during the strongest
    wave, which are required, the energies have errors of about 1e-4 of the largest one, and with
    twice as many, of 2e-5: weaker waves behind a pulse are shorter.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(30).replace(right_wall=hc.Wall.rigid())
    >>> flux = hc.simulate(chain, until=60.0, times=600).energy_flux()
    >>> f"{flux.right[19]:.3f} to the right, {flux.left[19]:.3f} to the left"
    '0.497 to the right, 0.497 to the left'
    """
    check_saved_times(self)
    # Walls are excluded: no energy passes them, and their forces are larger.
    dynamic = np.max(self.forces - static_forces_of(self), axis=0)[1:-1]
    strongest = int(np.argmax(dynamic)) + 1
    for event in events_at(self, strongest, 0.99 * max(0.0, float(dynamic.max()))):
        require_resolved(self, event, "the strongest wave")
    flows = [energy_to_and_fro(ContactCurves(self, k)) for k in range(1, self.chain.beads)]
    right, left = np.array(flows).T
    return EnergyFlux(self.chain, right, left)


def energy_to_and_fro(curves: ContactCurves) -> tuple[float, float]:
    """Integrals of the positive and of the negative part of the power."""
    times, power = curves.times, curves.power
    turns = np.flatnonzero(power[:-1] * power[1:] < 0.0)
    turning = sign_change(curves.power_curve, times[turns], times[turns + 1])
    # The power of an open contact between two waves is zero, which is not a change of sign.
    edges = np.sort(np.concatenate((times[[0, -1]], turning, times[power == 0.0])))
    pieces = np.diff(curves.power_curve.antiderivative()(edges))
    return float(pieces[pieces > 0.0].sum()), abs(float(pieces[pieces < 0.0].sum()))

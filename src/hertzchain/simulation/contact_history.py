"""The history of the contacts of a run: which are open, and the dents that they keep."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..chain.contact_groups import dents
from ..chain.stiff_walls import stiff_wall_notes
from ..collision import Array
from ..validation.keywords import checked_methods
from .body_peak import body_force_of
from .budget import overlaps_of
from .largest_overlaps import OPEN
from .other_names import OtherNames
from .trajectory import Trajectory


@checked_methods
@dataclass(frozen=True, eq=False)
class ContactHistory(OtherNames, Trajectory):
    """A trajectory with the history of its contacts; `hertzchain.Run` has the fields."""

    body_force = body_force_of

    @cached_property
    def dents(self) -> Array:
        r"""Dent of each contact after the run, shape (N + 1,) [scaled, or m].

        Contact numbers are those of `forces`.  A dent is the residual overlap at which a contact
        opens after its largest overlap: how much closer the centres of both bodies are when they
        touch again.  It has the law of the contact:

        - `ElasticPlastic`: :math:`d_p = d_m - F_m/(k\sqrt{d_m})`, with the largest overlap
          :math:`d_m` beyond yield and its force :math:`F_m`;
        - `WaltonBraun`: :math:`(1 - K_1/K_2)\,d_m`;
        - all other laws: 0.

        Two bodies of the same material and size have half of the dent each.  If one of them is
        softer, most of the dent is in this body.  A run that starts with dents
        (`State.struck_again`) includes them.

        Examples
        --------
        Two steel balls of 10 mm diameter that collide at 2 m/s, and at 0.2 m/s:

        >>> import hertzchain as hc
        >>> for speed in ("2 m/s", "0.2 m/s"):
        ...     pair = hc.Chain.from_materials("5 mm", "steel-52100", beads=2, velocity=speed)
        ...     run = hc.simulate(pair.replace(loss=hc.ElasticPlastic()), until="1 ms")
        ...     print(f"{1e6 * run.dents[1]:.2f} um")
        5.70 um
        0.00 um
        """
        return dents(self.chain.contact_groups, self._furthest_overlaps)

    @property
    def notes(self) -> tuple[str, ...]:
        """Reservations about walls of a given stiffness, one sentence for each.

        A linear spring replaces the Hertz contact of the last ball.  A note states if its largest
        deflection is less than ten times the overlap of this contact under the same force; the
        force of both in series is then noticeably different.

        Examples
        --------
        >>> import hertzchain as hc
        >>> row = hc.Chain.from_materials("5 mm", "steel-52100", beads=3, velocity=0.1)
        >>> for stiffness in ("0.5 kN/mm", "50 kN/mm"):
        ...     run = hc.simulate(row.replace(right_wall=hc.Wall(stiffness, exponent=1)))
        ...     print(len(run.notes))
        0
        1
        >>> run.notes[0].rpartition(": ")[2]
        "with_cap('0.08 g')"
        """
        return stiff_wall_notes(self.chain, self._furthest_overlaps)

    @property
    def _furthest_overlaps(self) -> Array:
        """Largest overlaps, including those before the start of the run."""
        return np.maximum(self.largest_overlaps, self.state.arrays["largest"])

    def open_contacts(self) -> Array:
        """Determine which contacts between beads are open at the saved times.

        Returns
        -------
        ndarray of bool, shape (T, N - 1)
            True for open contacts, including those that open at a permanent dent or whose force
            is cut off.  Successive closed contacts hold a fragment of the chain together.

        Examples
        --------
        >>> import hertzchain as hc
        >>> run = hc.simulate(hc.Chain.tapered("backward-exponential", 0.1, beads=20))
        >>> bool(run.open_contacts()[-1, :10].all())
        True
        """
        overlaps = overlaps_of(self.chain, self.times, self.positions)[:, 1:-1]
        released = (self.forces[:, 1:-1] == 0.0) & (overlaps > OPEN * self.largest_overlaps[1:-1])
        return np.asarray((overlaps < 0.0) | released)

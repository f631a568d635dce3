"""Parts of the energy that passed one contact: what returned, passed another one, or remained."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import SimulationError
from ..representation import measure, short
from ..validation.keywords import checked_methods
from .contact_pairs import pair_of_contacts

# Neighbouring contacts at which the returned energy is evaluated, too.
NEARBY: Final = 6
# Energies below this fraction of others are rounding errors.
ROUNDING: Final = 1e-12


@checked_methods
@dataclass(frozen=True, eq=False)
class EnergyBalance:
    r"""Balance of the energy of all waves between two contacts, from the beginning of a run.

    With the energy :math:`E_j^+` that flowed through contact j = ``before`` towards k = ``after``,
    and :math:`E_j^-` in the opposite direction,

    .. math:: R = E_j^- / E_j^+, \qquad T = (E_k^+ - E_k^-) / E_j^+, \qquad K = 1 - R - T .

    Attributes
    ----------
    chain : Chain
        The chain.
    before, after : int
        The contacts.
    incident_energy : float
        Energy that flowed through ``before`` towards ``after``, in all waves [scaled, or J].
    returned_energy : float
        Part R of it that flowed back, because of reflections or oscillations behind a pulse.
        Where waves of opposite directions meet, only the difference of their powers flows, so
        that R is smaller than the part that was reflected.
    passed_energy : float
        Part T that passed ``after`` and did not return; 0 where ``after`` is a wall or a free end.
    nearby_energy : tuple of float
        Smallest and largest R at the 6 contacts in front of ``before``.  A wide range shows that
        waves meet there.

    See Also
    --------
    Run.reflection : Coefficients of a single wave; prefer them where they can be determined.

    Examples
    --------
    >>> import hertzchain as hc
    >>> import numpy as np
    >>> chain = hc.Chain.from_radii(np.where(np.arange(120) < 60, 1.0, 2.0))
    >>> hc.simulate(chain, until=140.0, times=1500).energy_flux().balance(50, 75)
    EnergyBalance(contacts 50 to 75: incident energy 0.4968, returned 0.5227 (0.5214 to 0.5227 at
        neighbouring contacts), passed 0.4760, kept 0.0012)
    """

    chain: Chain
    before: int
    after: int
    incident_energy: float
    returned_energy: float
    passed_energy: float
    nearby_energy: tuple[float, float]

    @property
    def kept_energy(self) -> float:
        """Part K that flowed in between the two contacts, and remained or was lost there."""
        return 1.0 - self.returned_energy - self.passed_energy

    def _repr_html_(self) -> str:
        from ..notebook.waves import energy_balance_html

        return energy_balance_html(self)

    def __repr__(self) -> str:
        low, high = self.nearby_energy
        return short(
            "EnergyBalance",
            f"contacts {self.before} to {self.after}",
            f"incident energy {measure(self.incident_energy, 'J', self.chain.units)}, returned "
            f"{self.returned_energy:.4f} ({low:.4f} to {high:.4f} at neighbouring contacts), "
            f"passed {self.passed_energy:.4f}, kept {self.kept_energy:.4f}",
        )


def balance_of(
    chain: Chain, flows: Sequence[Array], before: int, after: int | str
) -> EnergyBalance:
    """The balance between two contacts, from the energy to the right and to the left."""
    beads = chain.beads
    first, second = pair_of_contacts(chain, before, after)
    sign = 1 if second > first else -1
    there, back = flows[::sign]
    incident = float(there[first - 1])
    if not incident > ROUNDING * max(float(there.max()), float(back.max())):
        raise SimulationError(f"no energy flows through contact {first} towards contact {second}")
    near = first - 1 - sign * np.arange(1, NEARBY + 1)
    near = near[(near >= 0) & (near < beads - 1)]
    near = near[there[near] > ROUNDING * incident]
    parts = back[near] / there[near] if len(near) else np.array([math.nan])
    passed = there[second - 1] - back[second - 1] if 0 < second < beads else 0.0
    return EnergyBalance(
        chain=chain, before=first, after=second, incident_energy=incident,
        returned_energy=float(back[first - 1]) / incident,
        passed_energy=float(passed) / incident,
        nearby_energy=(float(parts.min()), float(parts.max())),
    )  # fmt: skip

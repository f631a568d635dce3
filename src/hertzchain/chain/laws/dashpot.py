"""A linear dashpot in parallel with the spring of each contact."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...collision import Array
from ...kernels.law_kinds import DAMPED, LawRow
from ...validation.keywords import checked_fields
from .base import ContactArrays, Loss, may_pull, parameter


@checked_fields
@dataclass(frozen=True)
class Dashpot(Loss, name="dashpot"):
    r"""A linear dashpot in parallel with the spring of each contact.

    .. math:: F = k\,d^{\,p} + \gamma\,d'

    during contact only: A. Rosas, A. H. Romero, V. F. Nesterenko, K. Lindenberg, Phys.
    Rev. Lett. 98, 164301 (2007), doi:10.1103/PhysRevLett.98.164301.

    Attributes
    ----------
    gamma : float
        Damping constant >= 0 [scaled, or kg/s].
    attractive : bool
        Whether the force may pull before the overlap ends; the usual form does.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.Dashpot(6.0)
    Dashpot(gamma=6.0, attractive=True)
    """

    damps = True
    gamma: float = parameter("gamma", "damping constant", "damping", least=0.0)
    attractive: bool = may_pull(default=True)

    def row(self, exponent: float) -> LawRow:
        return LawRow(DAMPED, attractive=self.attractive)

    def strength(self, contacts: ContactArrays) -> Array:
        return np.full(len(contacts.stiffness), self.gamma)

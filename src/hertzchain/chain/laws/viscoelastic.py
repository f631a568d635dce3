"""Spheres of a viscoelastic material."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...collision import Array
from ...kernels.law_kinds import DAMPED, LawRow
from ...validation.keywords import checked_fields
from .base import ContactArrays, ContactsAtRest, Loss, may_pull, parameter


@checked_fields
@dataclass(frozen=True)
class Viscoelastic(Loss, name="viscoelastic"):
    r"""Spheres of a viscoelastic material, after Kuwabara and Kono.

    .. math:: F = k\left(d^{\,p} + p\,A\,d^{\,p-1} d'\right)

    For spheres (p = 3/2): G. Kuwabara, K. Kono, Jpn. J. Appl. Phys. 26, 1230 (1987),
    doi:10.1143/JJAP.26.1230; N. V. Brilliantov, F. Spahn, J.-M. Hertzsch, T. Poeschel,
    Phys. Rev. E 53, 5382 (1996), doi:10.1103/PhysRevE.53.5382.  Restitution falls as
    :math:`1 - e \propto A v^{1/5}`.  The law is of first order in A over the duration of a
    contact; `hertzchain.simulate` warns if A exceeds that of all contacts.

    Attributes
    ----------
    time : float
        Relaxation time A >= 0 of the material [scaled, or s].
    attractive : bool
        Whether the force may pull before the overlap ends.  By default it may not,
        because dry beads do not cohere; the series for e in powers of the speed assume that it
        does.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.Viscoelastic(1e-6)
    Viscoelastic(time=1e-06, attractive=False)
    """

    damps = True
    time: float = parameter("relaxation time", "relaxation time of the material", "time", least=0.0)
    attractive: bool = may_pull(default=False)

    @property
    def relaxation_time(self) -> float:
        return self.time

    def row(self, exponent: float) -> LawRow:
        return LawRow(DAMPED, overlap_power=exponent - 1.0, attractive=self.attractive)

    def strength(self, contacts: ContactArrays) -> Array:
        return np.asarray(contacts.exponent * self.time * contacts.stiffness)

    def damper(self, contacts: ContactsAtRest) -> Array:
        return np.asarray(self.time * contacts.spring)

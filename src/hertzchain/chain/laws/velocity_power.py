"""A loss by a power of the relative velocity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...collision import Array
from ...kernels.law_kinds import DAMPED, LawRow
from ...validation.keywords import checked_fields
from .base import ContactArrays, Loss, may_pull, parameter


@checked_fields
@dataclass(frozen=True)
class VelocityPower(Loss, name="velocity-power"):
    r"""A loss by a power of the relative velocity.

    .. math:: F = k\,d^{\,p} + \gamma\,\mathrm{sgn}(d')\,|d'|^{\alpha}

    R. Carretero-Gonzalez, D. Khatri, M. A. Porter, P. G. Kevrekidis, C. Daraio, Phys.
    Rev. Lett. 102, 024102 (2009), doi:10.1103/PhysRevLett.102.024102.

    Attributes
    ----------
    gamma : float
        Strength >= 0 [scaled, or N (s/m)^alpha].
    alpha : float
        Exponent, 0 < alpha <= 10.
    attractive : bool
        Whether the force may pull before the overlap ends; the usual form does.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.VelocityPower(0.1, alpha=1.81)
    VelocityPower(gamma=0.1, alpha=1.81, attractive=True)
    """

    damps = True
    gamma: float = parameter(
        "gamma", "strength [scaled, or N (s/m)^alpha]", least=0.0,
        unit=lambda law: f"force/velocity^{law.alpha}",
    )  # fmt: skip
    alpha: float = parameter("alpha", "exponent of the relative velocity", above=0.0, most=10.0)
    attractive: bool = may_pull(default=True)

    def __post_init__(self) -> None:
        # The unit of gamma depends on alpha.
        self._check("alpha")
        super().__post_init__()

    def _unit(self, name: str) -> str | None:
        return f"N*s**{self.alpha:.9f}/m**{self.alpha:.9f}" if name == "gamma" else None

    def row(self, exponent: float) -> LawRow:
        return LawRow(DAMPED, speed_power=self.alpha, attractive=self.attractive)

    def strength(self, contacts: ContactArrays) -> Array:
        return np.full(len(contacts.stiffness), self.gamma)

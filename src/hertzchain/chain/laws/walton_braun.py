"""Plastic contacts without a yield point."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...collision import Array
from ...errors import InputError
from ...kernels.law_kinds import PLASTIC, LawRow
from ...validation.keywords import checked_fields
from .base import ContactArrays, ContactsAtRest, Loss, parameter


@checked_fields
@dataclass(frozen=True)
class WaltonBraun(Loss, name="walton-braun"):
    r"""Plastic contacts: unloading is steeper, and ends at a permanent dent.

    The law has no yield point: any force dents a contact, and the first loading is always
    elastic.  `hertzchain.ElasticPlastic` is the law of beads with a yield point.

    .. math::

        F = k\,d^{\,p} \ \text{(first loading)}, \qquad
        F = k\,d_m^{\,p} \left(\frac{d - d_r}{d_m - d_r}\right)^{p}_+
        \ \text{(below the largest overlap so far, } d_m\text{)}, \qquad
        d_r = (1 - K_1/K_2)\,d_m .

    Unloading and reloading run along the second curve, on which the beads separate at
    the dent :math:`d_r`.  With p = 1 it is the bilinear law of O. R. Walton, R. L. Braun,
    J. Rheol. 30, 949 (1986), doi:10.1122/1.549893, with stiffnesses :math:`K_1` and
    :math:`K_2`; here it has the exponent of the contact.  A collision returns the part
    :math:`K_1/K_2` of its energy for any p, hence :math:`e = \sqrt{K_1/K_2}` at the
    first collision of a contact.

    Attributes
    ----------
    ratio : float
        :math:`K_1/K_2`, above 0 and at most 1 (elastic).

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.WaltonBraun(0.81)
    WaltonBraun(ratio=0.81)
    """

    leaves_dents = True
    words = "Walton\N{EN DASH}Braun"
    ratio: float = parameter(
        "ratio K1/K2 of loading to unloading", "stiffness of loading over that of unloading",
        fraction=True, above=0.0, most=1.0,
    )  # fmt: skip

    def row(self, exponent: float) -> LawRow:
        return LawRow(PLASTIC, kept=self.ratio)

    def stored_energy(self, overlap: Array, force: Array, contacts: ContactArrays) -> Array:
        """Stored energy, which depends only on the force."""
        p = contacts.exponent
        needed = self.loading_overlap(force, contacts)
        return np.asarray(self.ratio * force * needed / (p + 1.0))

    def largest_overlap(self, energy: Array, contacts: ContactArrays) -> Array:
        return super().largest_overlap(energy / self.ratio, contacts)

    def dent(self, largest: Array, contacts: ContactArrays) -> Array:
        return np.asarray((1.0 - self.ratio) * largest)

    def damper(self, contacts: ContactsAtRest) -> Array:
        if self.ratio < 1.0:
            raise InputError(
                f"contacts under {self} close along one curve and open along a steeper one, so "
                "that no motion is small enough to be linear; contacts that were compressed more "
                f"before follow the steeper one: use loss=None and stiffness / {self.ratio:g}**"
                f"{contacts.exponent:g}, also for walls"
            )
        return super().damper(contacts)

    def _restitution(self, speed: float, contacts: ContactArrays) -> float:
        return math.sqrt(self.ratio)

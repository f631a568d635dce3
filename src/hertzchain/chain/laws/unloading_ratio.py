"""A force that is smaller while the beads separate."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...collision import Array
from ...errors import InputError
from ...kernels.law_kinds import UNLOADING, LawRow
from ...validation.keywords import checked_fields
from .base import ContactArrays, ContactsAtRest, Loss, parameter


@checked_fields
@dataclass(frozen=True)
class UnloadingRatio(Loss, name="unloading-ratio"):
    r"""A force that is smaller while the beads separate than while they approach.

    .. math:: F = k\,d^{\,p} \times \begin{cases} 1 & d' \ge 0 \\ 1 - w & d' < 0 \end{cases}

    with the loss w of S. Sen and coworkers: S. Sen, J. Hong, J. Bang, E. Avalos, R. Doney, Phys.
    Rep. 462, 21 (2008), doi:10.1016/j.physrep.2007.10.007.  A collision returns the part
    1 - w of its energy: :math:`e = \sqrt{1-w}`.

    Attributes
    ----------
    ratio : float
        Part w of the force that is missing in unloading, 0 <= w < 1.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.UnloadingRatio(0.1)
    UnloadingRatio(ratio=0.1)
    """

    ratio: float = parameter(
        "unloading ratio w",
        "part of the force that is missing in unloading",
        fraction=True,
        least=0.0,
        below=1.0,
    )

    def row(self, exponent: float) -> LawRow:
        return LawRow(UNLOADING, kept=1.0 - self.ratio)

    def stored_energy(self, overlap: Array, force: Array, contacts: ContactArrays) -> Array:
        p, curve = contacts.exponent, (1.0 - self.ratio) * contacts.stiffness
        return np.asarray(curve * np.maximum(overlap, 0.0) ** (p + 1.0) / (p + 1.0))

    def damper(self, contacts: ContactsAtRest) -> Array:
        if self.ratio > 0.0:
            raise InputError(
                f"the force of {self} is discontinuous when a contact begins to open; "
                "no motion is small enough to be linear: use simulate, or loss=None"
            )
        return super().damper(contacts)

    def _restitution(self, speed: float, contacts: ContactArrays) -> float:
        return math.sqrt(1.0 - self.ratio)

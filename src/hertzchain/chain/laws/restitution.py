"""The same coefficient of restitution at every speed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...collision import HERTZ_EXPONENT, Array
from ...kernels.law_kinds import DAMPED, LawRow
from ...validation.keywords import checked_fields, checked_methods
from ..input_checks import checked_wall_exponent
from .base import ContactArrays, Loss, may_pull, parameter


@checked_methods
@checked_fields
@dataclass(frozen=True)
class Restitution(Loss, name="restitution"):
    r"""The same coefficient of restitution at every speed: Hertz damping.

    .. math::

        F = k\,d^{\,p} + c \sqrt{\mu k}\; d^{(p-1)/2}\, d',
        \qquad c = \sqrt{2(p+1)}\;\zeta, \qquad
        \zeta = \frac{-\ln e}{\sqrt{\ln^2 e + \pi^2}}

    with :math:`\mu` the reduced mass of the two beads.  In the variable
    :math:`d^{(p+1)/2}` the collision is a damped linear oscillator, which determines e exactly,
    for any p; for p = 3/2 the law is that of Y. Tsuji, T. Tanaka, T. Ishida, Powder Technol.
    71, 239 (1992), doi:10.1016/0032-5910(92)88030-L, with the damping that makes e exact.
    If the force may not pull, the contact ends earlier, with

    .. math:: e = \exp(-2\varphi\cot\varphi), \qquad \zeta = \cos\varphi ,

    (hyperbolic for :math:`\zeta > 1`), and :math:`\zeta` is the solution of this equation, so
    that e is exact in both cases.

    Attributes
    ----------
    coefficient : float
        Coefficient of restitution e, 0 < e <= 1, such as 0.95 or ``"95%"``.
    attractive : bool
        Whether the force may pull before the overlap ends; the usual form does.

    Examples
    --------
    >>> import hertzchain as hc
    >>> law = hc.Restitution(0.9)
    >>> round(law.damping(), 6)
    0.07495
    """

    damps = True
    coefficient: float = parameter(
        "coefficient of restitution",
        "coefficient of restitution",
        fraction=True,
        above=0.0,
        most=1.0,
    )
    attractive: bool = may_pull(default=True)

    @property
    def damping_ratio(self) -> float:
        r"""Damping ratio :math:`\zeta` of the equivalent linear oscillator."""
        log = abs(math.log(self.coefficient))
        if self.attractive:
            return log / math.hypot(log, math.pi)
        return _ratio_without_pull(log)

    def damping(self, exponent: float = HERTZ_EXPONENT) -> float:
        r"""Factor c of :math:`\sqrt{\mu k}\,d^{(p-1)/2} d'`.

        Parameters
        ----------
        exponent : float
            Exponent p of the contact force.

        Raises
        ------
        InputError
            If the exponent is out of range.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.Restitution(1.0).damping()
        0.0
        """
        return math.sqrt(2.0 * (checked_wall_exponent(exponent) + 1.0)) * self.damping_ratio

    def row(self, exponent: float) -> LawRow:
        return LawRow(DAMPED, overlap_power=0.5 * (exponent - 1.0), attractive=self.attractive)

    def strength(self, contacts: ContactArrays) -> Array:
        root = np.sqrt(contacts.reduced_mass * contacts.stiffness)
        return np.asarray(self.damping(contacts.exponent) * root)

    def _restitution(self, speed: float, contacts: ContactArrays) -> float:
        return self.coefficient


def _ratio_without_pull(log: float) -> float:
    """Solve -ln e = 2 phi cot phi for zeta = cos phi; the right side rises and is 2 at 1."""

    def lost(zeta: float) -> float:
        if zeta < 1.0:
            phi = math.acos(zeta)
            return 2.0 * phi / math.tan(phi)
        psi = math.acosh(zeta)
        return 2.0 * psi / math.tanh(psi) if psi > 0.0 else 2.0

    low, high = 0.0, 1.0
    while lost(high) < log:
        high *= 2.0
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return middle
        low, high = (middle, high) if lost(middle) < log else (low, middle)

r"""What a contact loses: laws of dissipation, one for all contacts of a chain.

Each law is a frozen dataclass that says what stands beside, or instead of, the
elastic force :math:`F = k\,d^{\,p}` of a contact with overlap :math:`d`, while
:math:`d > 0`.  Where a law's force would pull the beads together before they part, the
field ``attractive`` says whether it may: `True` ends the contact where the overlap
does, `False` where the force does, after which the beads fly apart freely.

================  ============================================  ======================
law               force                                         restitution
================  ============================================  ======================
`Restitution`     :math:`k d^p + c\sqrt{\mu k}\,d^{(p-1)/2}d'`  e at any speed
`Viscoelastic`    :math:`k (d^p + p A\,d^{p-1} d')`             falls with speed
`UnloadingRatio`  :math:`(1-w)\,k d^p` if :math:`d' < 0`        :math:`\sqrt{1-w}`
`VelocityPower`   :math:`k d^p \pm \gamma\,|d'|^\alpha`         depends on speed
`Dashpot`         :math:`k d^p + \gamma d'`                     rises with speed
`WaltonBraun`     plastic: unloading to a dent that stays       :math:`\sqrt{K_1/K_2}`
================  ============================================  ======================

A law is in the units of its chain; only those of `Viscoelastic`, `VelocityPower` and
`Dashpot` have any.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from hertzchain.arguments import truth
from hertzchain.chain.parts import Part
from hertzchain.chain.sizes import checked_exponent
from hertzchain.checks import number
from hertzchain.contacts import HERTZ_EXPONENT

if TYPE_CHECKING:
    from hertzchain.chain.scales import Scales


@dataclass(frozen=True)
class Restitution(Part):
    r"""The same coefficient of restitution at every speed: Hertz damping.

    .. math::

        F = k\,d^{\,p} + c \sqrt{\mu k}\; d^{(p-1)/2}\, d',
        \qquad c = \sqrt{2(p+1)}\;\zeta, \qquad
        \zeta = \frac{-\ln e}{\sqrt{\ln^2 e + \pi^2}}

    with :math:`\mu` the reduced mass of the two beads.  In the variable
    :math:`d^{(p+1)/2}` the collision is a damped linear oscillator, from which e follows
    exactly, for any p; for p = 3/2 it is Y. Tsuji, T. Tanaka, T. Ishida, Powder Technol.
    71, 239 (1992), doi:10.1016/0032-5910(92)88030-L, with the damping that makes e exact.
    If the force may not pull, the contact ends earlier, at

    .. math:: e = e^{-2\varphi\cot\varphi}, \qquad \zeta = \cos\varphi ,

    (hyperbolic for :math:`\zeta > 1`), and :math:`\zeta` is solved from that: e is exact
    either way.

    Attributes
    ----------
    coefficient : float
        Coefficient of restitution e, 0 < e <= 1.
    attractive : bool
        Whether the force may pull before the overlap ends; the usual form does.

    Examples
    --------
    >>> law = Restitution(0.9)
    >>> round(law.damping(), 6)
    0.07495
    """

    coefficient: float
    attractive: bool = True

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "attractive", truth("attractive", self.attractive))
        value = number("coefficient of restitution", self.coefficient, above=0.0, most=1.0)
        object.__setattr__(self, "coefficient", value)

    @property
    def damping_ratio(self) -> float:
        r"""The damping ratio :math:`\zeta` of the equivalent linear oscillator."""
        log = -math.log(self.coefficient)
        if self.attractive:
            return log / math.hypot(log, math.pi)
        return _ratio_without_pull(log)

    def damping(self, exponent: float = HERTZ_EXPONENT) -> float:
        r"""The factor c of :math:`\sqrt{\mu k}\,d^{(p-1)/2} d'`.

        Parameters
        ----------
        exponent : float
            Exponent p of the contact force.

        Returns
        -------
        float

        Raises
        ------
        InputError
            If the exponent is out of its range.

        Examples
        --------
        >>> Restitution(1.0).damping()
        0.0
        """
        return math.sqrt(2.0 * (checked_exponent(exponent) + 1.0)) * self.damping_ratio


@dataclass(frozen=True)
class Viscoelastic(Part):
    r"""Spheres of a viscoelastic material, after Kuwabara and Kono.

    .. math:: F = k\left(d^{\,p} + p\,A\,d^{\,p-1} d'\right)

    For spheres (p = 3/2): G. Kuwabara, K. Kono, Jpn. J. Appl. Phys. 26, 1230 (1987),
    doi:10.1143/JJAP.26.1230; N. V. Brilliantov, F. Spahn, J.-M. Hertzsch, T. Poschel,
    Phys. Rev. E 53, 5382 (1996), doi:10.1103/PhysRevE.53.5382.  Restitution falls as
    :math:`1 - e \propto A v^{1/5}`.

    Attributes
    ----------
    time : float
        The material's relaxation time A >= 0 [scaled, or s].
    attractive : bool
        Whether the force may pull before the overlap ends.  By default it may not, as
        dry beads do not cohere; the series for e in powers of the speed have it pull.

    Examples
    --------
    >>> Viscoelastic(1e-6)
    Viscoelastic(time=1e-06, attractive=False)
    """

    time: float
    attractive: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "attractive", truth("attractive", self.attractive))
        object.__setattr__(self, "time", number("relaxation time", self.time, unit="s", least=0.0))

    def factors(self, scales: Scales) -> Mapping[str, float]:
        """Units of the fields that have one.

        Parameters
        ----------
        scales : Scales
            The units.

        Returns
        -------
        dict

        Examples
        --------
        >>> import hertzchain as hc
        >>> list(Viscoelastic(1e-6).factors(hc.Scales(1.0, 1.0, 1.0, 2.0)))
        ['time']
        """
        return {"time": scales.time}


@dataclass(frozen=True)
class UnloadingRatio(Part):
    r"""A force that is smaller while the beads part than while they approach.

    .. math:: F = k\,d^{\,p} \times \begin{cases} 1 & d' \ge 0 \\ 1 - w & d' < 0 \end{cases}

    the w of S. Sen and coworkers: S. Sen, J. Hong, J. Bang, E. Avalos, R. Doney, Phys.
    Rep. 462, 21 (2008), doi:10.1016/j.physrep.2007.10.007.  A collision returns the part
    1 - w of its energy: :math:`e = \sqrt{1-w}`.

    Attributes
    ----------
    ratio : float
        The part w of the force that is lacking in unloading, 0 <= w < 1.

    Examples
    --------
    >>> UnloadingRatio(0.1)
    UnloadingRatio(ratio=0.1)
    """

    ratio: float

    def __post_init__(self) -> None:
        super().__post_init__()
        value = number("unloading ratio w", self.ratio, least=0.0, below=1.0)
        object.__setattr__(self, "ratio", value)


@dataclass(frozen=True)
class VelocityPower(Part):
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
    >>> VelocityPower(0.1, alpha=1.81)
    VelocityPower(gamma=0.1, alpha=1.81, attractive=True)
    """

    gamma: float
    alpha: float
    attractive: bool = True

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "attractive", truth("attractive", self.attractive))
        object.__setattr__(self, "alpha", number("alpha", self.alpha, above=0.0, most=10.0))
        unit = f"N*s**{self.alpha:.9f}/m**{self.alpha:.9f}"
        object.__setattr__(self, "gamma", number("gamma", self.gamma, unit=unit, least=0.0))

    def factors(self, scales: Scales) -> Mapping[str, float]:
        """Units of the fields that have one.

        Parameters
        ----------
        scales : Scales
            The units.

        Returns
        -------
        dict

        Examples
        --------
        >>> import hertzchain as hc
        >>> VelocityPower(0.1, 2.0).factors(hc.Scales(1.0, 1.0, velocity=2.0, length=1.0))
        {'gamma': 1.0}
        """
        return {"gamma": scales.force / scales.velocity**self.alpha}


@dataclass(frozen=True)
class Dashpot(Part):
    r"""A linear dashpot beside the spring of each contact.

    .. math:: F = k\,d^{\,p} + \gamma\,d'

    acting in contact only: A. Rosas, A. H. Romero, V. F. Nesterenko, K. Lindenberg, Phys.
    Rev. Lett. 98, 164301 (2007), doi:10.1103/PhysRevLett.98.164301.

    Attributes
    ----------
    gamma : float
        Damping constant >= 0 [scaled, or kg/s].
    attractive : bool
        Whether the force may pull before the overlap ends; the usual form does.

    Examples
    --------
    >>> Dashpot(6.0)
    Dashpot(gamma=6.0, attractive=True)
    """

    gamma: float
    attractive: bool = True

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "attractive", truth("attractive", self.attractive))
        object.__setattr__(self, "gamma", number("gamma", self.gamma, unit="kg/s", least=0.0))

    def factors(self, scales: Scales) -> Mapping[str, float]:
        """Units of the fields that have one.

        Parameters
        ----------
        scales : Scales
            The units.

        Returns
        -------
        dict

        Examples
        --------
        >>> import hertzchain as hc
        >>> Dashpot(6.0).factors(hc.Scales(1.0, 1.0, velocity=2.0, length=1.0))
        {'gamma': 2.0}
        """
        return {"gamma": scales.force / scales.velocity}


@dataclass(frozen=True)
class WaltonBraun(Part):
    r"""Plastic contacts: unloading is steeper, and ends at a dent that stays.

    The law has no yield point: contacts are dented by any force, however small, and the
    first loading is Hertz' at any force.  It is not the law of beads that begin to yield.

    .. math::

        F = k\,d^{\,p} \ \text{(first loading)}, \qquad
        F = k\,d_m^{\,p} \left(\frac{d - d_r}{d_m - d_r}\right)^{p}_+
        \ \text{(below the largest overlap so far, } d_m\text{)}, \qquad
        d_r = (1 - K_1/K_2)\,d_m .

    Unloading and reloading run along the second curve, on which the beads lose touch at
    the dent :math:`d_r`.  With p = 1 it is the bilinear law of O. R. Walton, R. L. Braun,
    J. Rheol. 30, 949 (1986), doi:10.1122/1.549893, with stiffnesses :math:`K_1` and
    :math:`K_2`; here it has the chain's exponent.  A collision returns the part
    :math:`K_1/K_2` of its energy for any p, so that :math:`e = \sqrt{K_1/K_2}` at the
    first collision of a contact.

    Attributes
    ----------
    ratio : float
        :math:`K_1/K_2`, above 0 and at most 1 (elastic).

    Examples
    --------
    >>> WaltonBraun(0.81)
    WaltonBraun(ratio=0.81)
    """

    ratio: float

    def __post_init__(self) -> None:
        super().__post_init__()
        value = number("ratio K1/K2 of loading to unloading", self.ratio, above=0.0, most=1.0)
        object.__setattr__(self, "ratio", value)


Loss: TypeAlias = (
    Restitution | Viscoelastic | UnloadingRatio | VelocityPower | Dashpot | WaltonBraun
)


def _ratio_without_pull(log: float) -> float:
    """The damping ratio at which ``-ln e`` is as given, if the contact ends with its force.

    ``-ln e`` = 2 phi cot phi rises with cos phi = zeta; it is 2 at zeta = 1.
    """

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

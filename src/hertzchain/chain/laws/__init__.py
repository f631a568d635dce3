r"""Laws by which contacts lose energy, one file each.

Each law is a frozen dataclass that states which force is added to, or replaces, the elastic force
:math:`F = k\,d^{\,p}` of a contact with overlap :math:`d`, while :math:`d > 0`.  If the force of a
law would pull the beads together before they separate, the field ``attractive`` selects the end of
the contact: with `True` it ends when the overlap is zero, with `False` when the force is zero.

================  ============================================  ======================
law               force                                         restitution
================  ============================================  ======================
`Elastic`         :math:`k d^p`                                 1
`Restitution`     :math:`k d^p + c\sqrt{\mu k}\,d^{(p-1)/2}d'`  e at any speed
`Viscoelastic`    :math:`k (d^p + p A\,d^{p-1} d')`             falls with speed
`UnloadingRatio`  :math:`(1-w)\,k d^p` if :math:`d' < 0`        :math:`\sqrt{1-w}`
`VelocityPower`   :math:`k d^p \pm \gamma\,|d'|^\alpha`         depends on speed
`Dashpot`         :math:`k d^p + \gamma d'`                     rises with speed
`WaltonBraun`     plastic: unloading to a permanent dent        :math:`\sqrt{K_1/K_2}`
`ElasticPlastic`  plastic above a yield pressure                falls above a speed
================  ============================================  ======================

The numbers of a law are in the units of its chain.  To add a law, add a file with a class derived
from `hertzchain.chain.laws.base.Loss`, and its force to `hertzchain.kernels.contact_law`.
"""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

from .base import LAWS, Loss

_MODULES = [each.name for each in iter_modules(__path__)]
__all__ = ("LAWS", "Loss")

for _name in _MODULES:
    import_module(f"{__name__}.{_name}")


def __dir__() -> list[str]:
    return [*__all__, *_MODULES]  # for completion

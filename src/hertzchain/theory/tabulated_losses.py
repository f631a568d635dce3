"""Laws of loss with tables for the local-rate law: how strong a loss is, and its limits."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar, Final

import numpy as np

from ..chain.chain import Chain
from ..chain.laws.base import Loss
from ..chain.laws.restitution import Restitution
from ..chain.laws.unloading_ratio import UnloadingRatio
from ..chain.laws.viscoelastic import Viscoelastic
from ..collision import HERTZ_EXPONENT, Array
from ..errors import InputError
from ..representation import listed

# Limits of the laws, within those of the tables.
MIN_RESTITUTION, MAX_RATIO, MAX_VISCOELASTIC = 0.9, 0.1, 0.06


@dataclass(frozen=True)
class TabulatedLoss(ABC):
    """A law of loss whose strength at contact k is c_k v_k^q, with the velocity v_k before it.

    Attributes
    ----------
    largest : float
        Largest strength of the tables.
    attractive : bool or None
        Whether the force of the law may pull; `None` if the law has no such choice, or if it
        hardly matters.
    """

    largest: float
    attractive: bool | None = None
    kind: ClassVar[type[Loss]]
    power: ClassVar[float] = 0.0
    # Limit of strengths that depend on the velocity, and their formula.
    limit: ClassVar[float] = np.inf
    formula: ClassVar[str] = ""

    def accepts(self, law: Loss) -> bool:
        """Whether the tables are those of a law."""
        return type(law) is self.kind and (
            self.attractive is None or getattr(law, "attractive", None) == self.attractive
        )

    @abstractmethod
    def coefficients(self, law: Any, chain: Chain) -> Array:
        """Coefficients c_k of a law in a scaled chain, shape (contacts,)."""

    def label(self, law: Loss) -> str:
        """Name of a law in messages, without parameters that have units."""
        return self.kind.__name__ if self.power else str(law)

    def violated(self, law: Any) -> str:  # noqa: ARG002
        """The requirement that a law violates in every chain, if there is one."""
        return ""

    def check(self, law: Loss, method: str) -> None:
        """Raise an error for a law that is too strong in every chain."""
        if requirement := self.violated(law):
            raise InputError(f"{method} requires {requirement}; use simulate")

    def check_strength(self, strength: Array, chain: Chain, method: str) -> None:
        """Raise an error for strengths along a chain that are too large."""
        beyond = np.flatnonzero(~(strength <= self.limit))
        if beyond.size:
            k = int(beyond[0])
            raise InputError(
                f"{method} requires {self.formula} of at most {self.limit:g}, but this is "
                f"{strength[k]:.3g} at bead {k + 1} (chain: {chain.description}); use simulate, "
                "or fewer beads"
            )


class _Restitution(TabulatedLoss):
    """The strength is the damping ratio."""

    kind = Restitution

    def coefficients(self, law: Restitution, chain: Chain) -> Array:
        return np.full(chain.beads - 1, law.damping_ratio)

    def violated(self, law: Restitution) -> str:
        if law.coefficient >= MIN_RESTITUTION:
            return ""
        return f"a restitution coefficient of at least {MIN_RESTITUTION:g}, got {law.coefficient:g}"


class _UnloadingRatio(TabulatedLoss):
    """The strength is the ratio w."""

    kind = UnloadingRatio

    def coefficients(self, law: UnloadingRatio, chain: Chain) -> Array:
        return np.full(chain.beads - 1, law.ratio)

    def violated(self, law: UnloadingRatio) -> str:
        if law.ratio <= MAX_RATIO:
            return ""
        return f"an unloading ratio of at most {MAX_RATIO:g}, got {law.ratio:g}"


class _Viscoelastic(TabulatedLoss):
    """The strength is the relaxation time in units of the time scale of the pulse."""

    kind = Viscoelastic
    power = (HERTZ_EXPONENT - 1.0) / (HERTZ_EXPONENT + 1.0)
    limit = MAX_VISCOELASTIC
    formula = "the strength A (k/m)^(2/5) v^(1/5) of Viscoelastic"

    def coefficients(self, law: Viscoelastic, chain: Chain) -> Array:
        frequency = (chain.stiffness / chain.masses[:-1]) ** (1.0 / (HERTZ_EXPONENT + 1.0))
        return np.asarray(law.time * frequency)


# By the names of the tables.
LAWS: Final = MappingProxyType(
    {
        "restitution": _Restitution(0.036, attractive=True),
        "restitution without pull": _Restitution(0.036, attractive=False),
        "unloading ratio": _UnloadingRatio(0.105),
        "viscoelastic": _Viscoelastic(0.064),
    }
)


def tabulated_loss(law: Loss, method: str) -> str:
    """Name of the tables of a law, after checking that there are some."""
    for name, tabulated in LAWS.items():
        if tabulated.accepts(law):
            tabulated.check(law, method)
            return name
    kinds = sorted({tabulated.kind.__name__ for tabulated in LAWS.values()})
    raise InputError(
        f"{method} has no tables for {type(law).__name__}, only for {listed(kinds)}; use simulate"
    )

"""Coefficient of restitution of the first impact, with its error, from a fitted law of loss."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..chain.chain import Chain
from ..chain.laws.restitution import Restitution
from ..collision import Array
from ..errors import InputError
from ..representation import measure, with_error
from .problem import differences

if TYPE_CHECKING:
    from .result import FitResult


@dataclass(frozen=True)
class FittedRestitution:
    """Coefficient of restitution of a law at one speed.

    Attributes
    ----------
    value, error : float
        Coefficient of the first contact, and its standard error.
    speed : float
        Fitted speed of the impact [m/s], regarded as exact.
    """

    value: float
    error: float
    speed: float

    @property
    def row(self) -> tuple[str, str]:
        """Name with the speed, and value with error."""
        return f"restitution at {measure(self.speed, 'm/s')}", with_error(self.value, self.error)

    def as_dict(self) -> dict[str, float]:
        """Plain values for JSON."""
        return asdict(self)


class WithRestitution:
    """Base class of results of fits."""

    @cached_property
    def restitution(self: FitResult) -> FittedRestitution | None:  # type: ignore[misc]
        """Coefficient of restitution at the speed of the impact, with its error, or None."""
        return fitted_restitution(self)


def fitted_restitution(result: FitResult) -> FittedRestitution | None:
    r"""Coefficient of the first contact, with :math:`\sigma^2 = g^T C g` from its gradient g.

    C is the covariance of the parameters.  There is none without a fitted loss with an error, or
    without an impact, or if the coefficient is itself a parameter.
    """
    errors = result.errors.items()
    fitted = [error for name, error in errors if name.startswith("loss.")]
    chain = result.chain
    contact = max(chain.strikers, 1)
    if result.meaningless or not fitted or not np.isfinite(fitted).all() or chain.beads < 2:
        return None
    law = chain.contact_losses[contact]
    speed = float(chain.velocities[contact - 1] - chain.velocities[contact])
    pressed = chain.static_state.forces.any()
    if law is None or isinstance(law, Restitution) or speed <= 0.0 or pressed:
        return None
    model = result.model

    def coefficient(variables: Array) -> Array:
        return np.array([_of_contact(model.chain(0, model.values(variables)), contact, speed)])

    try:
        value = float(coefficient(result.variables)[0])
        change = differences(lambda u: np.array([*model.values(u).values()]), result.variables)
        slopes = differences(coefficient, result.variables)[0] @ np.linalg.inv(change)
    except (InputError, np.linalg.LinAlgError):
        return None
    if not np.isfinite(result.sigmas[np.abs(slopes) > 0.0]).all():
        return None
    error = math.sqrt(max(float(slopes @ result.covariance @ slopes), 0.0))
    return FittedRestitution(value, error, speed) if error > 0.0 else None


def _of_contact(chain: Chain, contact: int, speed: float) -> float:
    law = chain.contact_losses[contact]
    return 1.0 if law is None else law.restitution(speed, chain=chain, contact=contact)

"""Constants of a chain that a fit takes as exact, and the change of the parameters per 1% of them.

The change of the optimum follows from the derivatives of the fit and from one further simulation
for each constant.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError, SimulationError
from ..representation import short
from .chain_parameters import ENDS, value_of
from .names import Name
from .problem import differences
from .weights import remaining_weights

if TYPE_CHECKING:
    from .result import FitResult

# Relative change of a constant to which results refer, and the step of the difference.
PER: Final = 0.01
STEP: Final = 1e-3
# Changes of all parameters below this number of their standard errors are not mentioned.
MENTIONED: Final = 0.1
# Part of the change of the stiffness below which others are due to the step of the difference.
ALONE: Final = 0.02


@dataclass(frozen=True)
class FixedConstant:
    """A constant of the chain that a fit takes as exact.

    Attributes
    ----------
    name : str
        Name with which it can be a free parameter, such as ``"right_wall.stiffness"``.
    moved : str
        The parameter that changes most, in standard errors: of the chain, if any is free.
    changes : dict
        Changes of the parameters if the constant were 1% larger, by name, in SI.
    in_sigmas : dict
        The same in standard errors of the parameters.
    relative : dict
        The same as fractions of the values; NaN for a value of zero.
    """

    name: str
    moved: str
    changes: dict[str, float]
    in_sigmas: dict[str, float]
    relative: dict[str, float]

    @property
    def matters(self) -> bool:
        """Whether `moved` changes by more than a tenth of its standard error per 1%."""
        return abs(self.in_sigmas[self.moved]) > MENTIONED

    @property
    def note(self) -> str:
        """A sentence; empty if the constant hardly matters."""
        return f"{self}; to include its uncertainty, free it with a prior" if self.matters else ""

    def __str__(self) -> str:
        change = self.relative[self.moved]
        by = f"{change:+.2%}, " if np.isfinite(change) else ""
        return (
            f"{self.name} is taken as exact: 1% more changes {self.moved} by "
            f"{by}{abs(self.in_sigmas[self.moved]):.1f} sigma"
        )

    def __repr__(self) -> str:
        return short("FixedConstant", str(self))


def fixed_constants(result: FitResult) -> tuple[FixedConstant, ...]:
    """Moduli, densities and stiffness of walls that are not free, and on which a fit depends."""
    problem, model = result.problem, result.model
    weights = remaining_weights(problem, result.residual_vector)
    change = differences(lambda u: np.array([*model.values(u).values()]), result.variables)
    response = change @ np.linalg.pinv(weights[:, None] * result.jacobian, rcond=1e-10)
    free = {replace(each, shot="") for each in model.names}
    found = []
    for name in _constants(result.chain):
        if name in free:
            continue
        try:
            column = _derivative(result, name)
        except (SimulationError, InputError):
            continue
        if column.any():
            shifts = -PER * (response[:, : len(column)] @ (weights[: len(column)] * column))
            found.append(_constant(name, shifts, result))
    found = [each for each in found if not _is_in_stiffness(each)]
    return tuple(sorted(found, key=lambda each: -abs(each.in_sigmas[each.moved])))


def _constants(chain: Chain) -> list[Name]:
    """Constants of materials and walls by the names with which they can be free."""
    materials = dict.fromkeys(each.name for each in chain.materials or ())
    found = [
        Name(f"materials.{field}", each) for each in materials for field in ("young", "density")
    ]
    return found + [Name(f"{end}.stiffness") for end in ENDS if getattr(chain, end) is not None]


def _derivative(result: FitResult, name: Name) -> Array:
    """Derivative of the residuals of the data with respect to the logarithm of a constant."""
    problem, values = result.problem, result.model.values(result.variables)
    base, moved = dict(values), dict(values)
    for shot, chain in enumerate(result.chains, start=1):
        own = replace(name, shot=str(shot))
        base[own] = value_of(chain, name)
        moved[own] = (1.0 + STEP) * base[own]
    change = (problem.predicted(moved) - problem.predicted(base)) / problem.scale / STEP
    return np.where(problem.skipped, 0.0, change)


def _constant(name: Name, shifts: Array, result: FitResult) -> FixedConstant:
    with np.errstate(divide="ignore", invalid="ignore"):
        in_sigmas = np.where(result.sigmas > 0.0, shifts / result.sigmas, 0.0)
        relative = np.where(result.estimates != 0.0, shifts / result.estimates, np.nan)
    columns = (shifts, in_sigmas, relative)
    changes = [dict(zip(result.names, each.tolist(), strict=True)) for each in columns]
    of_chain = [i for i, each in enumerate(result.model.parameters) if each.of_chain]
    moved = max(of_chain or range(len(shifts)), key=lambda i: abs(in_sigmas[i]))
    return FixedConstant(str(name), result.names[moved], *changes)


def _is_in_stiffness(constant: FixedConstant) -> bool:
    """Whether a modulus only changes the factor of all contacts, whose stiffness is the same."""
    sizes = {name: abs(size) for name, size in constant.in_sigmas.items()}
    own = sizes.pop("stiffness", 0.0)
    return constant.name.endswith(".young") and max(sizes.values(), default=0.0) < ALONE * own

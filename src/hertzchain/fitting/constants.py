"""Constants that a fit takes as exact, and the change of the parameters per 1% of them.

The change of the optimum follows from the derivatives of the fit.  Each constant of the chain needs
one further simulation; gains of calibrated sensors and the sampling interval need none.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..chain.walls import Wall
from ..collision import Array
from ..errors import InputError, SimulationError
from ..representation import listed, short
from ..traces.traces import Traces
from .chain_parameters import constants_of_ends, is_free, value_of
from .names import ENDS, Name
from .problem import SMALL, Problem, differences
from .weights import remaining_weights

# Relative change of a constant to which results refer, and the step of a difference that requires a
# simulation.
PER: Final = 0.01
STEP: Final = 1e-3
# Changes of all parameters below this number of their standard errors are not mentioned.
MENTIONED: Final = 0.1
# Part of the change of the stiffness below which others are due to the step of the difference.
ALONE: Final = 0.02
INTERVAL: Final = "sampling interval"


@dataclass(frozen=True)
class FixedConstant:
    """A constant of the chain or of the sensors that a fit takes as exact.

    Attributes
    ----------
    name : str
        Name with which it can be a free parameter, such as ``"right_wall.stiffness"`` or
        ``"gain"``; of several gains, their names, and ``"sampling interval"``, which cannot be
        free.
    moved : str
        The parameter that changes most, in standard errors: of the chain, if any is free.
    changes : dict
        Changes of the parameters if the constant were 1% larger, by name, in SI.
    in_sigmas : dict
        The same in standard errors of the parameters.
    relative : dict
        The same as fractions of the values; NaN for a value of zero.
    label : str
        Its name in a sentence, if that is another one.
    """

    name: str
    moved: str
    changes: dict[str, float]
    in_sigmas: dict[str, float]
    relative: dict[str, float]
    label: str = ""

    @property
    def matters(self) -> bool:
        """Whether `moved` changes by more than a tenth of its standard error per 1%."""
        return abs(self.in_sigmas[self.moved]) > MENTIONED

    @property
    def note(self) -> str:
        """A sentence; empty if the constant hardly matters."""
        if not self.matters:
            return ""
        if self.name == INTERVAL:
            return str(self)
        what = "it with a prior"
        if self.label:
            several = self.name != "gain"
            what = f"{self.name} with priors" if several else f"{self.name!r} with a prior"
        return f"{self}; to include its uncertainty, free {what}"

    def __str__(self) -> str:
        change = self.relative[self.moved]
        by = f"{change:+.2%}, " if np.isfinite(change) else ""
        return (
            f"{self.label or self.name} is taken as exact: 1% more changes {self.moved} by "
            f"{by}{abs(self.in_sigmas[self.moved]):.1f} sigma"
        )

    def __repr__(self) -> str:
        return short("FixedConstant", str(self))


@dataclass(frozen=True, eq=False)
class Optimum:
    """The optimum of a fit: variables, residuals and their derivatives, values and chains."""

    problem: Problem
    variables: Array
    jacobian: Array
    residuals: Array
    estimates: Array
    sigmas: Array
    chains: tuple[Chain, ...]


def fixed_constants(optimum: Optimum) -> tuple[FixedConstant, ...]:
    """Constants that are not free, and on which a fit depends.

    These are moduli, densities, the mass of a cap, the stiffness of walls, the factor of a drive,
    gains of calibrated sensors, and the sampling interval.
    """
    model = optimum.problem.model
    weights = remaining_weights(optimum.problem, optimum.residuals)
    change = differences(lambda u: np.array([*model.values(u).values()]), optimum.variables)
    response = change @ np.linalg.pinv(weights[:, None] * optimum.jacobian, rcond=1e-10)
    found = []
    for name, label, column in _derivatives(optimum):
        if column.any():
            shifts = -PER * (response[:, : len(column)] @ (weights[: len(column)] * column))
            found.append(_constant(name, label, shifts, optimum))
    found = [each for each in found if not _is_in_stiffness(each)]
    return tuple(sorted(found, key=lambda each: -abs(each.in_sigmas[each.moved])))


def _derivatives(optimum: Optimum) -> Iterator[tuple[str, str, Array]]:
    """Name, label and derivative of the data for the logarithm of each constant."""
    problem, model = optimum.problem, optimum.problem.model
    free = {replace(each, shot="") for each in model.names}
    values = model.values(optimum.variables)
    for name in _constants(optimum.chains[0]):
        if is_free(name, free, optimum.chains[0]) or _follows(name, free, optimum.chains[0]):
            continue
        base, moved = dict(values), dict(values)
        for shot, chain in enumerate(optimum.chains, start=1):
            own = replace(name, shot=str(shot))
            base[own] = value_of(chain, name)
            moved[own] = (1.0 + STEP) * base[own]
        try:
            change = problem.predicted(moved) - problem.predicted(base)
        except (SimulationError, InputError):
            continue
        yield str(name), "", _column(problem, change / STEP)
    here = problem.predicted(values)
    for label, names in _fixed_gains(model.traces, free):
        moved = values | dict.fromkeys(names, 1.0 + SMALL)
        change = problem.predicted(moved) - here
        yield listed([*map(str, names)]), label, _column(problem, change / SMALL)
    slower = Problem(replace(model, traces=_slower(model.traces)))
    change = slower.predicted(values) - here
    yield INTERVAL, f"the {INTERVAL}", _column(problem, change / SMALL)


def _column(problem: Problem, derivative: Array) -> Array:
    """Derivative of the residuals of the data from that of the predicted values."""
    return np.where(problem.skipped, 0.0, derivative / problem.scale)


def _fixed_gains(traces: Traces, free: Collection[Name]) -> Iterator[tuple[str, list[Name]]]:
    """Labels and names of the gains of calibrated sensors that are not free, by their unit."""
    units = {each.name: each.unit for _, each in traces if each.calibrated}
    if Name("gain") in free:
        return
    for unit in dict.fromkeys(units.values()):
        alike = [each for each, own in units.items() if own == unit]
        fixed = [Name("gain", each) for each in alike if Name("gain", each) not in free]
        if not fixed:
            continue
        which = "all" if len(fixed) == len(alike) else "the other"
        label = f"the gain of {which} sensors in {unit}" if len(fixed) > 1 else ""
        yield label, [Name("gain")] if len(fixed) == len(traces.names) > 1 else fixed


def _slower(traces: Traces) -> Traces:
    """Traces whose sampling interval is longer by a small step."""
    return Traces(tuple(each.with_scaled_times(1.0 + SMALL) for each in traces.shots))


def _constants(chain: Chain) -> list[Name]:
    """Constants of drives, materials, caps and walls by the names with which they can be free."""
    materials = dict.fromkeys(each.name for each in chain.materials or ())
    found = [
        Name(f"materials.{field}", each) for each in materials for field in ("young", "density")
    ]
    if chain.drive is not None:
        found.append(Name("drive.factor"))
    return found + constants_of_ends(chain)


def _follows(name: Name, free: Collection[Name], chain: Chain) -> bool:
    """Whether the stiffness of a wall follows from a modulus that is free and only the wall has."""
    end = name.key.split(".")[0]
    wall: Wall | None = getattr(chain, end) if end in ENDS else None
    if wall is None or wall.stiffness is not None or wall.material is None:
        return False
    of_ball = any(each.name == wall.material.name for each in chain.materials or ())
    return not of_ball and Name("materials.young", wall.material.name) in free


def _constant(name: str, label: str, shifts: Array, optimum: Optimum) -> FixedConstant:
    with np.errstate(divide="ignore", invalid="ignore"):
        in_sigmas = np.where(optimum.sigmas > 0.0, shifts / optimum.sigmas, 0.0)
        relative = np.where(optimum.estimates != 0.0, shifts / optimum.estimates, np.nan)
    parameters = optimum.problem.model.parameters
    names = [str(each) for each in parameters]
    columns = (shifts, in_sigmas, relative)
    changes, sigmas, parts = (dict(zip(names, each.tolist(), strict=True)) for each in columns)
    of_chain = [i for i, each in enumerate(parameters) if each.of_chain]
    moved = max(of_chain or range(len(shifts)), key=lambda i: abs(in_sigmas[i]))
    return FixedConstant(name, names[moved], changes, sigmas, parts, label)


def _is_in_stiffness(constant: FixedConstant) -> bool:
    """Whether a modulus only changes the factor of all contacts, whose stiffness is the same."""
    sizes = {name: abs(size) for name, size in constant.in_sigmas.items()}
    own = sizes.pop("stiffness", 0.0)
    return constant.name.endswith(".young") and max(sizes.values(), default=0.0) < ALONE * own

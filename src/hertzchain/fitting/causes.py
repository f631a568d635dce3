"""A possible cause of residuals, and the fit with further parameters that tries it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from ..errors import SimulationError
from .advice import advice_to_free
from .chain_parameters import constants_of_ends
from .chain_parameters import is_free as is_free_constant
from .model import Model
from .names import Name
from .parameters import Parameter, kind_and_value
from .problem import Problem
from .result import FitResult

Refit = Callable[[Problem, Mapping[str, float], int], FitResult]
# A parameter that is nearer to its fixed value, in standard deviations, is not a cause.
CLEAR: Final = 2.0
# Values of an effect of several sensors are reported beyond this number of standard deviations.
CERTAIN: Final = 5.0
# Parameters that change the level which the model has before the measured pulse.
OF_LEVEL: Final = ("offset", "time_offset")


@dataclass(frozen=True)
class Cause:
    """A cause, the fit with it, and the advice to a user."""

    what: str
    advice: str
    result: FitResult
    added: int
    # Whether all columns or all times are read wrongly.
    whole: bool = False
    # Whether the columns or the times are read differently, so that all values are others.
    misread: bool = False
    # Whether amplitudes are wrong by so much that other causes mean nothing before.
    gross: bool = False
    # Whether columns are in another order.
    order: bool = False
    # Whether a sensor is in another ball.
    place: bool = False
    # Whether the row has another number of balls.
    count: bool = False
    # Whether a ball of the row, or a gap in it, is another one.
    row: bool = False
    # Parameters that the fit has in addition.
    names: tuple[Name, ...] = ()
    # The fit from which this one starts, if it is not that without a cause.
    base: FitResult | None = None

    @property
    def delays(self) -> bool:
        """Whether the cause is a delay of one or several sensors."""
        return bool(self.names) and all(each.key == "delay" for each in self.names)

    @property
    def shifts_level(self) -> bool:
        """Whether the cause moves the levels of signals before the pulse, or the pulse itself."""
        return any(each.key in OF_LEVEL for each in self.names)

    @property
    def values(self) -> str:
        """Lines with the parameters of the fit, if these are not in the description."""
        if not self.misread or self.result.meaningless:
            return ""
        rows = self.result.rows()
        longest = max(len(name) for name, _ in rows)
        return "".join(f"\n  {name:<{longest}}  {row}" for name, row in rows)


def try_further(
    result: FitResult, names: Sequence[Name], refit: Refit, model: Model | None = None,
    neutral: float | None = None, factor: float = 1.0, least: float = CLEAR,
    start: Mapping[str, float] | None = None,
) -> Cause | None:  # fmt: skip
    """The fit with further parameters, by default of the same chains, from the optimum or a start.

    None if it fails, or if no parameter differs by ``least`` standard errors from the value without
    the cause, which is by default that of the model.
    """
    model, values = model or result.model, result.values
    parameters = list(model.parameters)
    if start is None:
        parameters = [replace(each, start=values[str(each)]) for each in parameters]
    fixed = {}
    for name in names:
        kind, value = kind_and_value(name, model.traces, model.chains)
        value = values.get(str(replace(name, shot="")), value)
        parameters.append(Parameter(name, kind, factor * value))
        fixed[str(name)] = value if neutral is None else neutral
    try:
        problem = Problem(replace(model, parameters=tuple(parameters)))
        found = refit(problem, values if start is None else start, 1)
    except SimulationError:
        return None
    if not _beyond(least, fixed, found):
        return None
    rows = dict(found.rows())
    clear = list(fixed)
    if len(names) > 1:
        clear = _beyond(CERTAIN, fixed, found) or clear
    shown = ", ".join(f"{name} = {rows[name]}" for name in clear)
    advice = advice_to_free(names, model.traces)
    return Cause(shown, advice, found, len(names), names=tuple(names))


def _beyond(times: float, fixed: Mapping[str, float], found: FitResult) -> list[str]:
    """Parameters that differ by more than some standard errors from their fixed values."""
    values, errors = found.values, found.errors
    return [name for name, value in fixed.items()
            if abs(values[name] - value) > times * errors[name]]  # fmt: skip


def is_free(key: str, model: Model) -> bool:
    """Whether a parameter of all contacts is free, in all shots or in some."""
    return any(each.key == key and not each.item for each in model.names)


def fixed_ends(model: Model) -> list[Name]:
    """The mass of a cap and the stiffness of walls, if they are not free."""
    chain, free = model.chains[0], {replace(each, shot="") for each in model.names}
    return [name for name in constants_of_ends(chain) if not is_free_constant(name, free, chain)]

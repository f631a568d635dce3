"""The budget of a search: a number of simulations, or a time."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from ..errors import InputError
from ..simulation.ensemble_columns import ALONE
from ..simulation.ensemble_input import is_covered
from ..validation.numbers import has_unit, number, whole_number

if TYPE_CHECKING:
    from .problem import Design

DEFAULT: Final = 20_000
# Largest time that an elastic chain takes in a search [s], which grows with the square of the
# number of beads if there are more than this number, and the factor by which chains that are not
# integrated together take longer.
SLOWEST, MANY_BEADS, LOSSY = 1e-3, 20.0, 30.0


class Spent(Exception):
    """Raised if the budget does not permit the next evaluation."""


@dataclass(frozen=True)
class Budget:
    """Simulations, or seconds."""

    runs: float = math.inf
    seconds: float = math.inf

    def used(self, runs: int, seconds: float) -> float:
        """Part of the budget that is used."""
        return max(runs / self.runs, seconds / self.seconds)


def simulations_within(limit: Budget, problem: Design) -> float:
    """Number of simulations that a budget surely permits, also on a slow computer."""
    if math.isfinite(limit.runs):
        return limit.runs
    chain = problem.chain
    # The kernel that integrates chains together records no durations on a body.
    alone = any(ALONE in each.columns for each in problem.measures)
    together = is_covered(chain, problem.until) and not alone
    each = SLOWEST * (1.0 + (chain.beads / MANY_BEADS) ** 2) * (1.0 if together else LOSSY)
    return limit.seconds / each


def budget_from(given: Any) -> Budget:
    """A number of simulations, or a time such as ``"60 s"``."""
    if given is None:
        return Budget(runs=DEFAULT)
    if isinstance(given, str) and not has_unit(given):
        try:
            given = int(given)
        except ValueError:
            raise InputError(
                f"the budget must be a number of simulations or a time, such as '60 s', got "
                f"{given!r}"
            ) from None
    if has_unit(given):
        return Budget(seconds=number("budget", given, unit="s", above=0.0))
    return Budget(runs=whole_number("budget", given, least=1))


class Clock:
    """Time since the search began, continued from the time that earlier parts used."""

    def __init__(self) -> None:
        self.begun, self.before = time.monotonic(), 0.0

    def resume(self, seconds: float) -> None:
        """Continue from a time."""
        self.begun, self.before = time.monotonic(), seconds

    @property
    def seconds(self) -> float:
        """Time used so far."""
        return self.before + time.monotonic() - self.begun

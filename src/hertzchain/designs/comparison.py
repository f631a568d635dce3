"""A design compared with its references, with elastic contacts and with contacts that yield."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from ..chain.yield_pressure import assumes_pressure
from ..errors import InputError, SimulationError
from ..representation import counted
from ..simulation.state import fingerprint
from .ball_space import BallSpace
from .ball_tapers import GEOMETRIC_TAPER
from .limits_if_yielding import violated_only_if_yielding
from .reference_chains import EQUAL_BALLS, EQUAL_PLACES, SORTED_BALLS
from .verified import Verified, met

if TYPE_CHECKING:
    from ..chain.chain import Chain
    from .result import DesignResult

# Name of the design among chains that are shown.
DESIGN: Final = "design"
GIVEN: Final = "given chain"
# Relative difference of values that is not reported.
NEGLIGIBLE: Final = 1e-3


@dataclass(frozen=True)
class ReferenceComparison:
    """A chain to compare with, beside the design.

    Attributes
    ----------
    value, own : float
        Objective of this chain and of the design.
    value_if_yielding, own_if_yielding : float
        The same with contacts that yield; of a chain whose contacts do not, the elastic value.
    met : bool
        Whether this chain meets the constraints.
    within_range : bool
        Whether the values with contacts that yield are within the range of their law, so that they
        can be compared.
    """

    value: float
    own: float
    value_if_yielding: float
    own_if_yielding: float
    met: bool
    within_range: bool = True

    @property
    def reversed(self) -> bool:
        """Whether the better one of both is another one if contacts yield, within the range."""
        elastic, yielding = self.own - self.value, self.own_if_yielding - self.value_if_yielding
        return self.within_range and elastic * yielding < 0.0


def compared(result: DesignResult, found: Verified) -> ReferenceComparison:
    """The design and a chain to compare with."""
    return ReferenceComparison(
        result.objective_of(found), result.value, objective_if_yielding(result, found),
        objective_if_yielding(result, result.verified), met(result.problem, found.values),
        not any(each.yielding_outside_range for each in (found, result.verified)),
    )  # fmt: skip


def value_in_samples(result: DesignResult, found: Verified) -> float:
    """The statistic of the objective in new samples of the scatter; NaN if there is none."""
    scatter, single = result.problem.scatter, result.problem.objective.single
    if scatter is None or single is None:
        return math.nan
    return found.scattered.get(f"{scatter.statistic} of {single}", math.nan)


def has_yielding_value(result: DesignResult, found: Verified) -> bool:
    """Whether the objective has another value with contacts that yield."""
    if not found.yielding or all(each.of_chain for each in result.problem.objective.measures):
        return False
    return math.isfinite(result._objective(found.yielding))


def objective_if_yielding(result: DesignResult, found: Verified) -> float:
    """Objective with contacts that yield; of a chain whose contacts do not, the elastic one."""
    known = has_yielding_value(result, found)
    return result._objective(found.yielding if known else found.values)


def objective_if_fully_plastic(result: DesignResult, found: Verified) -> float:
    """Objective at the largest possible yield pressure; the elastic one if contacts do not yield.

    NaN if it is not known.
    """
    if all(each.of_chain for each in result.problem.objective.measures):
        return result.objective_of(found)
    if found.fully_plastic is None:
        known = has_yielding_value(result, found) or assumes_pressure(found.chain)
        return math.nan if known else result.objective_of(found)
    measures = result.problem.objective.measures
    if any(str(each) not in found.fully_plastic.values for each in measures):
        return math.nan
    return result._objective(found.fully_plastic.values)


def advantage(result: DesignResult, own: float, other: float) -> float:
    """Relative part by which a value of the design is better than another one; NaN if unknown."""
    if not (math.isfinite(own) and math.isfinite(other)) or not other:
        return math.nan
    return float(result._sign * (other - own) / abs(other))


def better_if_yielding(result: DesignResult) -> int | None:
    """Index of the best runner-up with contacts that yield, if it is better than the design.

    With a scatter, runners-up are worse by its statistic, which is not that of these values.
    """
    if result.problem.scatter is not None or result.verified.yielding_outside_range:
        return None
    values = {
        i: result._sign * objective_if_yielding(result, each)
        for i, each in enumerate(result.runners_up)
        if met(result.problem, each.values) and not each.yielding_outside_range
        and not violated_only_if_yielding(result.problem, each)
    }  # fmt: skip
    finite = {i: value for i, value in values.items() if math.isfinite(value)}
    best = min(finite, default=None, key=lambda i: finite[i])
    own = result._sign * objective_if_yielding(result, result.verified)
    better = best is not None and finite[best] < own - NEGLIGIBLE * abs(own)
    return best if better else None


def best_reference(result: DesignResult) -> str | None:
    """Name of the best reference that meets the constraints, if the design is hardly better."""
    best = _best_feasible(result)
    if best is None or not result.met:
        return None
    if result.problem.scatter is not None:
        # Objectives are those of samples; the chains themselves can be the same.
        equal = (name for name, each in result.references.items() if _same(each, result.verified))
        return next(equal, None)
    other = result.objective_of(result.references[best])
    better = result._sign * (other - result.value)
    return best if better <= NEGLIGIBLE * abs(other) else None


def _best_feasible(result: DesignResult) -> str | None:
    """Name of the best reference that meets the constraints."""
    names = [name for name, found in result.references.items()
             if met(result.problem, found.values)]  # fmt: skip
    scores = {name: result._sign * result.objective_of(result.references[name]) for name in names}
    return min(scores, default=None, key=lambda name: scores[name])


def shown_chains(result: DesignResult) -> dict[str, Verified]:
    """The chains of a figure, by name: the best one without a search, and the design.

    The first one is the best reference that meets the constraints, or the given chain if there
    is none or if it is better; it is omitted if the design is the same chain (`same_as`).  A given
    chain that violates the constraints is before it.
    """
    words, other = _without_search(result)
    own = {DESIGN: result.verified}
    found = own if _same(other, result.verified) else {words: other} | own
    given = compared_chains(result).get(GIVEN)
    if given is None or other is given or met(result.problem, given.values):
        return found
    return {GIVEN: given} | found


def same_as(result: DesignResult) -> str:
    """Name of the best chain without a search, if the design is the same chain; else empty."""
    words, other = _without_search(result)
    return words if _same(other, result.verified) else ""


def _same(one: Verified, other: Verified) -> bool:
    return fingerprint(one.chain) == fingerprint(other.chain)


def _without_search(result: DesignResult) -> tuple[str, Verified]:
    """The best chain without a search, and its name."""
    initial, name = result._initial, _best_feasible(result)
    words, other = GIVEN, initial
    if name is not None:
        found = result.references[name]
        loss = result._sign * (result.objective_of(found) - result.objective_of(initial))
        if not loss > 0.0 or not met(result.problem, initial.values):
            words, other = _best_in_words(result, name), found
    return words, other


def _best_in_words(result: DesignResult, name: str) -> str:
    return f"best {name}" if result.compared[name] > 1 else name


def references_in_words(result: DesignResult) -> dict[str, Verified]:
    """The references, with the numbers of chains of which they are the best, and their balls."""

    def described(name: str) -> str:
        tried, possible = result.compared[name], met(result.problem, result.references[name].values)
        best = f"best {name}" if possible else f"{name} closest to the constraints"
        text = f"{best} (of {tried} tried)" if tried > 1 else name
        balls = equal_balls(result, name) or _sorted_balls(result, name)
        return f"{text}, {balls}" if balls else text

    return {described(name): found for name, found in result.references.items()}


def compared_chains(result: DesignResult) -> dict[str, Verified]:
    """The given chain, if it is not among the references and has a value, and these, in words."""
    found = references_in_words(result)
    given = _given(result)
    if given is None or any(_same(given, each) for each in found.values()):
        return found
    return {GIVEN: given} | found


def _given(result: DesignResult) -> Verified | None:
    """Numbers of the given chain, unless other lines of the summary state them."""
    unmet = not (result.met or result.front or result.problem.scatter is not None)
    given = None if unmet or not result.references else given_chain(result)
    return given if given is not None and math.isfinite(result.objective_of(given)) else None


def given_chain(result: DesignResult) -> Verified | None:
    """Numbers of the given chain, if it can be simulated."""
    try:
        return result._initial
    except (InputError, SimulationError):
        return None


def _sorted_balls(result: DesignResult, name: str) -> str:
    """The sizes at both ends of sorted balls or of a taper, such as ``10 mm to 4 mm``."""
    space, chain = result.problem.space, result.references[name].chain
    if name not in (SORTED_BALLS, GEOMETRIC_TAPER) or not isinstance(space, BallSpace):
        return ""
    sizes = chain.radii[space.places[0] :][: chosen_balls(result, chain, space)]
    factor, unit = (2e3, " mm") if chain.units == "SI" else (1.0, "")
    return " to ".join(f"{factor * sizes[i]:g}{unit}" for i in (0, -1))


def equal_balls(result: DesignResult, name: str) -> str:
    """The balls of the row of equal ones, such as ``24 balls of 5 mm ptfe``; else empty."""
    space, chain = result.problem.space, result.references[name].chain
    if (
        name not in (EQUAL_BALLS, EQUAL_PLACES)
        or not isinstance(space, BallSpace)
        or chain.materials is None
    ):
        return ""
    first, count = int(space.places[0]), chosen_balls(result, chain, space)
    return (
        f"{counted(count, 'ball')} of {2e3 * chain.radii[first]:g} mm {chain.materials[first].name}"
    )


def chosen_balls(result: DesignResult, chain: Chain, space: BallSpace) -> int:
    """Number of balls of a chain in the places that vary, some of which may be empty."""
    return chain.beads - (result.problem.chain.beads - space.size)

"""Rough fits with a gap at a contact, from small and large sizes.

In front of the first sensor, a gap mainly delays all signals, as the time offset does.  A
linearised fit then finds only a small gap, which changes the form of the pulse in the same
direction, so that a large one is found only by a search that begins with it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from ..chain.chain import Chain
from ..errors import InputError, SimulationError
from .ball_counts import ball_count
from .least_squares import roughly_solved
from .model import Model
from .names import TIME_OFFSET, Name
from .parameters import Parameter, kind_and_value
from .problem import Problem
from .result import FitResult
from .starts import aligned
from .symmetry import units_of

# Sizes from which a search begins, in units of the motion: a gap below the overlaps of the
# contacts, and those from similar ones to one that a ball crosses without touching its neighbours.
# From a size that is wrong by more than a factor of about 1.5, a few evaluations do not suffice.
SMALL: Final = 0.02
WIDE: Final = (0.5, 1.0, 2.0, 5.0)
# Evaluations from each size, which are enough to recognise the best contact.
EVALUATIONS: Final = 4
# Evaluations with a gap that is held, whose sum of squares decides whether data exclude it.
HELD_EVALUATIONS: Final = 20
# Steps of the search for the smallest gap.
STEPS: Final = 6
# Standard deviation of the prior that holds a gap, as a part of its size.
HELD: Final = 1e-4
WALL_GAP: Final = Name("right_wall.gap")


@dataclass(frozen=True, eq=False)
class RoughGap:
    """A gap at a contact, with the values and the sum of squares of a rough fit."""

    name: Name
    cost: float
    problem: Problem

    @property
    def starts(self) -> dict[str, float]:
        """Values of all parameters."""
        return {str(each.name): each.start for each in self.problem.model.parameters}

    @property
    def size(self) -> float:
        """The gap [m]."""
        return self.starts[str(self.name)]


def gap_names(chain: Chain) -> list[Name]:
    """Contacts that may have a gap: of beads, and of the last ball with a wall."""
    balls = [k + 1 - chain.strikers for k in range(chain.beads - 1)]
    names = [Name("gap", f"{ball}-{ball + 1}") for ball in balls]
    # A cap is part of a load cell.
    walled = chain.right_wall is not None and chain.cap is None
    return [*names, WALL_GAP] if walled else names


def contact_words(name: Name, chain: Chain) -> str:
    """The two bodies of a contact, such as "balls 3 and 4"."""
    if name == WALL_GAP:
        return "the last ball and the wall"
    first, last = map(int, name.item.split("-"))
    if first == 0:
        return "the striker and ball 1"
    return f"ball {first} and the cap" if last > ball_count(chain) else f"balls {first} and {last}"


def first_sensor(result: FitResult) -> int:
    """Number of the first ball with a sensor; a larger one than that of all balls for a wall."""
    strikers, beads = result.chain.strikers, result.chain.beads
    places = [signal.place for _, signal in result.traces]
    return min((each.bead(result.chain) - strikers for each in places), default=beads)


def is_in_front(name: Name, result: FitResult) -> bool:
    """Whether a gap delays all signals, because no sensor is in front of it."""
    return name != WALL_GAP and int(name.item.split("-")[0]) < first_sensor(result)


def is_between(name: Name, sensor: str, result: FitResult) -> bool:
    """Whether the sensors on one side of a contact are this one alone, or all others.

    A gap there and a delay of the sensor have nearly the same effect if the time offset is free.
    """
    chain = result.chain
    first = int(name.item.split("-")[0]) if name.item else ball_count(chain)
    places = {each.name: each.place.bead(chain) - chain.strikers for _, each in result.traces}
    beyond = {each for each, place in places.items() if place > first}
    return {sensor} in (beyond, places.keys() - beyond)


def sizes_of(name: Name, result: FitResult) -> tuple[float, ...]:
    """Sizes from which a search for a gap begins; larger ones between sensors look like delays."""
    end = result.chain.beads - result.chain.strikers
    last = name == WALL_GAP or int(name.item.split("-")[1]) == end
    return (SMALL, *WIDE) if last or is_in_front(name, result) else (SMALL,)


def rough_gap(result: FitResult, name: Name, sizes: Sequence[float]) -> RoughGap | None:
    """The best rough fit of a gap from these sizes, in units of the motion."""
    unit = units_of(result.chain).scales.length
    return better_of(*(_rough(result, name, size * unit) for size in sizes))


def better_of(*gaps: RoughGap | None) -> RoughGap | None:
    """The rough fit with the least sum of squares, if there is any."""
    found = (each for each in gaps if each is not None)
    return min(found, key=lambda one: one.cost, default=None)


def own_cost(result: FitResult) -> float:
    """The sum of squares of a fit without a gap, with the weights of rough fits."""
    return float(result._residual_vector @ result._residual_vector)


def least_size(gap: RoughGap, limit: float) -> float:
    """The smallest gap at this contact whose sum of squares does not exceed a limit [m]."""
    low, high = 0.0, gap.size
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        held = _held(gap, middle)
        if held is None or held.cost > limit:
            low = middle
        else:
            high = middle
    return high


def _held(gap: RoughGap, size: float) -> RoughGap | None:
    """The rough fit with a gap of about this size."""
    model, name = gap.problem.model, gap.name
    parameters = [
        replace(each, start=size, prior=(size, HELD * size)) if each.name == name else each
        for each in model.parameters
    ]
    values = {each.name: each.start for each in parameters}
    model = replace(model, parameters=tuple(parameters))
    return _solved(gap.problem, model, values, name, HELD_EVALUATIONS)


def _rough(result: FitResult, name: Name, size: float) -> RoughGap | None:
    """The rough fit of a gap from one size."""
    model = result.model
    kind, _ = kind_and_value(name, model.traces, model.chains)
    parameters = (*model.parameters, Parameter(name, kind, size))
    known = result.values
    values = {each: known[str(each)] for each in model.names} | {name: size}
    return _solved(result.problem, replace(model, parameters=parameters), values, name)


def _solved(
    like: Problem, model: Model, values: Mapping[Name, float], name: Name,
    evaluations: int = EVALUATIONS,
) -> RoughGap | None:  # fmt: skip
    """The rough fit from values whose time offsets are aligned first; none if it fails."""
    try:
        # Only a time offset depends on the gap so strongly that a search from others fails.
        moved = aligned(model, dict(values))
    except (InputError, SimulationError):
        return None
    values = {each: (moved if each.key == TIME_OFFSET else values)[each] for each in values}
    return solved_from(like, model, values, name, evaluations)


def solved_from(
    like: Problem, model: Model, values: Mapping[Name, float], name: Name, evaluations: int
) -> RoughGap | None:
    """The rough fit from values; none if it fails.

    Samples have the weights of another problem, so that sums of squares can be compared.
    """
    try:
        problem = _starting(model, values, like)
        solution = roughly_solved(problem, evaluations)
    except (InputError, SimulationError):
        return None
    return RoughGap(name, solution.cost, _starting(model, model.values(solution.variables), like))


def _starting(model: Model, values: Mapping[Name, float], like: Problem) -> Problem:
    """The problem of a model whose parameters start from these values."""
    parameters = tuple(replace(each, start=values[each.name]) for each in model.parameters)
    problem = Problem(replace(model, parameters=parameters))
    problem.set_correlated(like.correlated)
    problem.skipped, problem.smooth = like.skipped, like.smooth
    return problem

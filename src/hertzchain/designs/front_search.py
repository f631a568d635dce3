"""Genetic search for the Pareto front of two objectives among balls or orders."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..collision import Array
from .ball_space import Choice
from .dominance import best_spread, undominated
from .genetic import CHILDREN, Population, search
from .trials import Outcome, Trials

# Parts of the budget of the searches for the best of one objective.  The second one needs no
# search if it follows from the chain, such as a mass.
FIRST, SECOND = 0.2, 0.1
# Number of parents, and generations without a new point of the front after which all neighbours
# of one of its points are tried.  Of six problems whose fronts are known, more parents or more
# patience find less of the front in 1000 simulations, and about as much in 4000.
MEMBERS, PATIENCE = 30, 1
# Generations of random choices without a new one after which the search ends.
MAX_IDLE: Final = 30


class FrontPopulation(Population):
    """Choices on and behind a front, and the moves that make new ones."""

    def __init__(self, trials: Trials, rng: np.random.Generator, signs: tuple[float, float]):
        super().__init__(trials, rng)
        measures = trials.problem.reported
        self.signs = np.array(signs)
        self.columns = [trials.position[each] for each in measures]
        self.front: list[Outcome] = []
        self.explored: set[bytes] = set()

    def try_all(self, choices: list[Choice]) -> bool:
        """Evaluate the choices that are new; whether the front has a new point."""
        long = filter(self.space.long_enough, choices)
        tried = {neat.tobytes(): neat for neat in map(self.space.neat, long)}
        return self.add(self.trials.evaluate(
            [neat for key, neat in tried.items() if key not in self.known]
        ))  # fmt: skip

    def add(self, outcomes: list[Outcome]) -> bool:
        """Add evaluated choices; whether the front has a new point."""
        if not outcomes:
            return False
        self.known |= {each.x.tobytes(): each for each in outcomes}
        before = {each.x.tobytes() for each in self.front}
        pool = {each.x.tobytes(): each for each in [*self.members, *self.front, *outcomes]}
        usable = [each for each in pool.values() if np.isfinite(each.rank).all()]
        met = [each for each in usable if each.met]
        costs = self._costs(met)
        self.front = [met[i] for i in undominated(costs)]
        self.members = [met[i] for i in best_spread(costs, MEMBERS)]
        # Choices that nearly meet the constraints are parents until enough others do.
        others = sorted((each for each in usable if not each.met), key=lambda each: each.rank)
        self.members += others[: MEMBERS - len(self.members)]
        return any(each.x.tobytes() not in before for each in self.front)

    def _costs(self, outcomes: list[Outcome]) -> Array:
        values = np.array([each.values[self.columns] for each in outcomes])
        return self.signs * values.reshape(-1, 2)

    def _parent(self) -> Choice:
        place = int(self.rng.integers(0, len(self.members), 2).min())
        return np.asarray(self.members[place].x)

    def unexplored(self) -> Choice | None:
        """A random point of the front whose neighbours have not been tried."""
        left = [each for each in self.front if each.x.tobytes() not in self.explored]
        if not left:
            return None
        chosen = left[int(self.rng.integers(len(left)))].x
        self.explored.add(chosen.tobytes())
        return np.asarray(chosen)


def search_front(
    first: Trials, second: Trials, seed: int, signs: tuple[float, float]
) -> list[Outcome]:
    """Use the budget for the front; the best of each start of the first objective.

    ``first`` and ``second`` are the trials of one objective each, with a common memory, and
    ``signs`` the signs of the measures in the objectives.
    """
    memory = first.memory
    assert memory is not None
    begin = first.used
    ends = search(first, begin + FIRST * (1.0 - begin), seed)
    if not second.problem.objective.measures[0].of_chain:
        second.add_counts(first)
        search(second, first.used + SECOND * (1.0 - begin), seed)
        first.add_counts(second)
    population = FrontPopulation(first, np.random.default_rng([seed, 3]), signs)
    if memory:
        points, values = zip(*memory.values(), strict=True)
        population.add(first.outcomes(points, np.array(values)))
    _complete(first, population)
    return ends


def _complete(trials: Trials, population: FrontPopulation) -> None:
    """Children of the population, neighbours of the front, and random choices in turn."""
    waited = idle = 0
    while trials.used < 1.0 and idle < MAX_IDLE:
        count = len(population.known)
        if count >= population.space.count:
            break
        if population.members:
            better = population.try_all([population.child() for _ in range(CHILDREN)])
            waited = 0 if better else waited + 1
        if waited < PATIENCE and len(population.known) > count:
            continue
        if (point := population.unexplored()) is not None:
            population.try_all(population.neighbours(point))
        elif len(population.known) == count:
            population.try_all([population.random() for _ in range(CHILDREN)])
        idle = 0 if len(population.known) > count else idle + 1

"""Search in a space of balls or orders: enumeration, and a genetic search with exchanges."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from .ball_space import BallSpace, Choice
from .reference_chains import reference_points
from .trials import Outcome, Trials

BATCH: Final = 512
POPULATION, CHILDREN, PARENTS = 25, 50, 3
# Rows of each material with which a search among several materials begins, in addition.
OF_ONE_MATERIAL: Final = 10
# Mutations per child; generations without a better choice after which exchanges are tried.
# With all values known, 500 of 500 seeds find the best of 2^15 sequences of steel and PTFE within
# 4000 runs (median 812), as they do among 3^8, 4^8 and, with empty places, 87 380 rows of balls,
# and 6435 and 34 650 orders.  More mutations, or less patience, need more runs.
MUTATIONS, PATIENCE = 0.7, 30
MAX_ENUMERATED: Final = 1e5


def enumerate_all(trials: Trials, end: float) -> None:
    """Try all choices, except those of the chains to compare with, until the budget is used."""
    space = trials.problem.space
    assert isinstance(space, BallSpace)
    tried = {choice.tobytes() for group in reference_points(trials.problem).values()
             for choice in group} if trials.references else set()  # fmt: skip
    # Choices that other points of a Pareto front have tried need no budget.
    free = trials.memory is not None
    others = (each for each in _all_choices(space) if each.tobytes() not in tried)
    choices = itertools.islice(others, None if free else trials.room)

    def batches() -> Iterator[list[Choice]]:
        while (free or trials.used < end) and (batch := list(itertools.islice(choices, BATCH))):
            yield batch

    trials.evaluate_all(batches())


def _all_choices(space: BallSpace) -> Iterator[Choice]:
    if space.given is not None:
        yield from _orders(sorted(space.given.tolist()))
        return
    yield from space.rows()


def _orders(items: list[int]) -> Iterator[Choice]:
    """All distinct orders, in lexicographic order."""
    current = np.array(items)
    while True:
        yield current.copy()
        falls = np.flatnonzero(current[:-1] < current[1:])
        if not len(falls):
            return
        i = falls[-1]
        j = np.flatnonzero(current > current[i])
        j = j[j > i][-1]
        current[[i, j]] = current[[j, i]]
        current[i + 1 :] = current[i + 1 :][::-1]


def _of_the_same_material(space: BallSpace) -> dict[int, list[int]]:
    """The other balls of the material of each ball; empty unless there are several materials."""
    kinds = [each.material for each in space.balls]
    if len(set(kinds)) == 1:
        return {}
    others = {i: [j for j, each in enumerate(kinds) if each == own and j != i]
              for i, own in enumerate(kinds)}  # fmt: skip
    return {i: found for i, found in others.items() if found}


class Population:
    """Choices that are known, best first, and the moves that make new ones."""

    def __init__(self, trials: Trials, rng: np.random.Generator) -> None:
        space = trials.problem.space
        assert isinstance(space, BallSpace)
        self.trials, self.space, self.rng = trials, space, rng
        self.known: dict[bytes, Outcome] = {}
        self.members: list[Outcome] = []
        self.alike = _of_the_same_material(space)

    def try_all(self, choices: list[Choice]) -> bool:
        """Evaluate the choices that are new; whether the best one is better than before.

        Those that are known from an earlier start become members without another simulation.
        """
        long = filter(self.space.long_enough, choices)
        tried = {neat.tobytes(): neat for neat in map(self.space.neat, long)}
        new = [neat for key, neat in tried.items() if key not in self.known]
        for each in self.trials.evaluate(new):
            self.known[each.x.tobytes()] = each
        before = self.members[0].rank if self.members else (np.inf,) * 3
        members = {each.x.tobytes(): each for each in self.members}
        members |= {key: self.known[key] for key in tried if key in self.known}
        self.members = sorted(members.values(), key=lambda each: each.rank)[:POPULATION]
        return bool(self.members) and self.members[0].rank < before

    def random(self) -> Choice:
        """A random choice."""
        if self.space.given is not None:
            return self.rng.permutation(self.space.given)
        found = self.rng.integers(0, self.space.kinds, self.space.size)
        return self.space.from_stock(found, self.rng)

    def of_one_material(self) -> list[Choice]:
        """Random rows of one material each, if there are several.

        Constraints such as a limit of yield may permit only one material, which random rows of all
        materials hardly ever have at every place.
        """
        kinds = [each.material for each in self.space.balls]
        if self.space.given is not None or len(set(kinds)) == 1:
            return []
        found = []
        for material in dict.fromkeys(kinds):
            own = [i for i, each in enumerate(kinds) if each == material]
            own += range(len(kinds), self.space.kinds)  # an empty place
            rows = self.rng.choice(own, (OF_ONE_MATERIAL, self.space.size))
            found += [self.space.from_stock(row, self.rng) for row in rows]
        return found

    def child(self) -> Choice:
        """A child of two good choices, with mutations and an occasional exchange."""
        one, other = (self._parent() for _ in range(2))
        if self.space.order:
            return self._order_child(one, other)
        size = self.space.size
        found = np.where(self.rng.random(size) < 0.5, one, other)
        changed = self.rng.random(size) < MUTATIONS / size
        shift = self.rng.integers(1, self.space.kinds, size)
        other_ball = (found + shift) % self.space.kinds
        if self.alike and self.rng.random() < 0.5:
            other_ball = np.array([self.rng.choice(self.alike.get(i, [i])) for i in found.tolist()])
        found = np.where(changed, other_ball, found)
        found = self.space.from_stock(found, self.rng)
        return self._exchanged(found) if self.rng.random() < 0.3 else found

    def _parent(self) -> Choice:
        places = self.rng.integers(0, len(self.members), PARENTS)
        return np.asarray(self.members[int(places.min())].x)

    def _order_child(self, one: Choice, other: Choice) -> Choice:
        """Keep the common places; fill the others at random with the balls that are left."""
        found = np.where(one == other, one, -1)
        open_places = np.flatnonzero(found < 0)
        found[open_places] = self.rng.permutation(one[open_places])
        for _ in range(1 + self.rng.poisson(0.5)):
            found = self._exchanged(found)
        return found

    def _exchanged(self, choice: Choice) -> Choice:
        i, j = self.rng.integers(0, self.space.size, 2)
        found = choice.copy()
        found[[i, j]] = found[[j, i]]
        return found

    def neighbours(self, choice: Choice) -> list[Choice]:
        """All choices with one ball replaced, or two exchanged."""
        found = []
        if not self.space.order:
            for place in range(self.space.size):
                for item in range(self.space.kinds):
                    if item != choice[place]:
                        changed = choice.copy()
                        changed[place] = item
                        if self.space.in_stock(changed):
                            found.append(changed)
        for i, j in itertools.combinations(range(self.space.size), 2):
            if choice[i] != choice[j]:
                changed = choice.copy()
                changed[[i, j]] = changed[[j, i]]
                found.append(changed)
        return found


def search(
    trials: Trials, end: float, seed: int, start: Sequence[Choice] = ()
) -> list[Outcome]:  # fmt: skip
    """Genetic search with restarts, each completed by exchanges; the best of each start.

    The first population consists of the choices to start from, if there are any.
    """
    rng, ends = np.random.default_rng([seed, 2]), list[Outcome]()
    known: dict[bytes, Outcome] = {}
    while trials.used < end:
        population = Population(trials, rng)
        population.known, tried = known, len(known)
        begin = list(start) if start and not ends else []
        first = begin or [population.random() for _ in range(POPULATION)]
        first += population.of_one_material() if not begin else []
        given = population.space.start
        population.try_all(first if given is None or ends else [given, *first])
        waited = 0
        while trials.used < end and waited < PATIENCE and population.members:
            better = population.try_all([population.child() for _ in range(CHILDREN)])
            waited = 0 if better else waited + 1
        while trials.used < end and population.members:
            near = population.neighbours(np.asarray(population.members[0].x))
            if not population.try_all(near):
                break
        if population.members:
            ends.append(population.members[0])
        if len(known) == tried or len(known) >= population.space.count:
            break
    return ends

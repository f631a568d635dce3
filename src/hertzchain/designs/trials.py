"""Evaluation of trial designs: simulated together, counted, stored in a journal, compared."""

from __future__ import annotations

import hashlib
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError
from ..store.journal import Journal
from ..threads import Threads
from ..validation.numbers import worker_count
from ..validation.objects import Progress
from . import exact_gradients
from .ball_space import BallSpace
from .finite_differences import STEP_RTOL, differences
from .measured import measured
from .models import by_model
from .problem import Design
from .requirements import TOLERANCE, violation
from .search_budget import Budget, Clock, Spent

if TYPE_CHECKING:
    from .verified import Verified

# Tolerance of trial runs; results are verified with a tighter one.
RTOL: Final = 1e-5
KEPT: Final = 12
MAX_FAILURES: Final = 1000
# Trials that a budget of time permits at most.
UNLIMITED: Final = 10**12
# A budget of time is checked after this part of it, or this time [s]: at first after a few trials,
# then after at most so many times as many as before.
SMALL_PART, LONGEST_PART, FIRST_SIZE, GROWTH = 0.02, 1.0, 8, 8


@dataclass(frozen=True, eq=False)
class Outcome:
    """A trial design: its point or choice, the values of all measures, score and violation.

    Score and violation are NaN if a value is unknown.
    """

    x: Any
    values: Array
    score: float
    violation: float
    # Order of trials with the same score, which a number of balls often has.
    tie: float = 0.0
    # Violation of the limits of the chain itself, such as its length.
    of_chain: float = 0.0

    @property
    def met(self) -> bool:
        """Whether all constraints are met."""
        return self.violation <= TOLERANCE

    @property
    def rank(self) -> tuple[float, float, float]:
        """Order of trials: those that meet the constraints by score, then by violation."""
        if np.isnan(self.score) or np.isnan(self.violation):
            return np.inf, np.inf, np.inf
        return (0.0 if self.met else self.violation), self.score, self.tie

    @property
    def closeness(self) -> tuple[float, ...]:
        """Order if no trial meets all limits: first those that meet the limits of the chain."""
        return max(self.of_chain - TOLERANCE, 0.0), *self.rank


class Reference(NamedTuple):
    """The best of the chains of one kind, and the numbers of those tried and rejected."""

    outcome: Outcome
    tried: int
    rejected: int


@dataclass(eq=False)
class Trials:
    """All trials of a search."""

    problem: Design
    budget: Budget
    journal: Journal
    seed: int
    threads: int | None = None
    progress: Progress | None = None
    runs: int = 0
    rejected: int = 0
    gradients: int = 0
    history: list[tuple[int, float]] = field(default_factory=list)
    best: list[Outcome] = field(default_factory=list)
    closest: Outcome | None = None
    reasons: dict[str, int] = field(default_factory=dict)
    references: dict[str, Reference] = field(default_factory=dict)
    # Points and values by tolerance and point, if several searches of a Pareto front share them.
    memory: dict[bytes, tuple[Any, Array]] | None = None
    # Number of the best trials that are kept.
    kept: int = KEPT
    # Points whose chains have no values, at most `MAX_FAILURES`.
    failures: list[Any] = field(default_factory=list)
    # Verified chains by point, also of all searches of a Pareto front.
    verified: dict[bytes, Verified] = field(default_factory=dict)
    # Number of trials after which a budget of time is checked.
    size: int = FIRST_SIZE
    # Scores of all trials of an enumeration that meet the constraints.
    scores: list[float] | None = None

    def __post_init__(self) -> None:
        self.clock, self.rejecting = Clock(), threading.Lock()
        self.measures = self.problem.measures
        self.position = {measure: i for i, measure in enumerate(self.measures)}
        self.terms = [self.position[m] for m in self.problem.objective.measures]
        self.limits = [self.position[each.measure] for each in self.problem.requirements]
        scatter, beads = self.problem.scatter, self.problem.chain.beads
        self.draws = None if scatter is None else scatter._draws(self.seed, beads)
        self.bad = np.array([self.problem.bad_sides[each] for each in self.measures], float)
        self.exact = exact_gradients.covered(self.problem)

    @property
    def used(self) -> float:
        """Part of the budget that is used."""
        return 1.0 if self.room < 1 else self.budget.used(self.runs, self.journal.seconds)

    @property
    def samples(self) -> int:
        """Number of simulations of one trial."""
        return 1 if self.draws is None else len(self.draws)

    @property
    def room(self) -> int:
        """Number of trials that a budget of simulations still permits."""
        left = min(self.budget.runs - self.runs, float(UNLIMITED))
        return max(0, int(left // self.samples))

    def evaluate(self, points: Sequence[Any], *, rtol: float = RTOL) -> list[Outcome]:
        """Simulate the chains at several points; at the first ones if the budget ends there."""
        if self.memory is None:
            return self._simulate(points[: self.room], rtol)
        keys = [_place(point, rtol) for point in points]
        new = {key: point for key, point in zip(keys, points, strict=True)
               if key not in self.memory}  # fmt: skip
        fresh = [*new][: self.room]
        if fresh:
            outcomes = self._simulate([new[key] for key in fresh], rtol)
            # With a budget of time, only the first points may have been simulated.
            self.memory |= {
                key: (each.x, each.values) for key, each in zip(fresh, outcomes, strict=False)
            }
        known = {key: point for key, point in zip(keys, points, strict=True) if key in self.memory}
        if not known:
            return []
        found = self.outcomes([*known.values()], np.array([self.memory[key][1] for key in known]))
        self._note(found, 0)
        return found

    def remember(self, outcomes: Sequence[Outcome]) -> None:
        """Let trials that are not counted become points of a Pareto front."""
        assert self.memory is not None
        for each in outcomes:
            self.memory.setdefault(_place(each.x, RTOL), (each.x, each.values))

    def _simulate(self, points: Sequence[Any], rtol: float) -> list[Outcome]:
        found: list[Outcome] = []
        # At least one trial is simulated, even if the time is over.
        while len(found) < len(points) and (self.used < 1.0 or not self.best):
            part = points[len(found) : len(found) + self._at_a_time]
            before = self.journal.seconds
            values = self._journalled("values", part, partial(self._values, part, rtol))
            outcomes = self.outcomes(part, values)
            self._note(outcomes, self.samples)
            self._adjust_size(len(part), self.journal.seconds - before)
            found += outcomes
        return found

    @property
    def _at_a_time(self) -> int:
        """Number of trials after which a budget of time is checked."""
        return self.size if np.isfinite(self.budget.seconds) else UNLIMITED

    def _adjust_size(self, trials: int, seconds: float) -> None:
        """Choose how many trials fit into a small part of the time.

        The times are those of the journal, and thus the same if a search is resumed.
        """
        wanted = min(LONGEST_PART, SMALL_PART * self.budget.seconds)
        fitting = trials * wanted / max(seconds, 1e-9)
        self.size = int(np.clip(fitting, 1, GROWTH * self.size))

    def evaluate_all(self, batches: Iterator[list[Any]]) -> None:
        """Evaluate many batches; with several threads, two at a time.

        Chains are made while kernels run for the other batch.  Trials are noted in order.
        """
        workers = 2 if worker_count("threads", self.threads) > 1 else 1
        timed = np.isfinite(self.budget.seconds)
        waiting: deque[tuple[list[Any], Future[Array]]] = deque()
        with Threads(workers) as executor:
            try:
                for batch in batches:
                    if self.journal.known or workers == 1 or self.memory is not None or timed:
                        self.evaluate(batch)
                        continue
                    waiting.append((batch, executor.submit(self._values, batch, RTOL)))
                    if len(waiting) > workers:
                        self._finish(*waiting.popleft())
                while waiting:
                    self._finish(*waiting.popleft())
            finally:
                for _, future in waiting:
                    future.cancel()

    def _finish(self, batch: list[Any], future: Future[Array]) -> None:
        """Note the trials of a batch that is being evaluated."""
        values = self._journalled("values", batch, future.result)
        self._note(self.outcomes(batch, values), self.samples)

    def outcomes(self, points: Sequence[Any], values: Array) -> list[Outcome]:
        """Scores of values that are known."""
        scores = self.problem.objective.score(values[:, self.terms])
        excess = violation(self.problem.requirements, values[:, self.limits])
        failed = ~np.isfinite(values).all(axis=1)
        scores[failed] = np.nan
        ties = np.zeros(len(scores))
        if (limit := self.problem.tie_breaker) is not None:
            ties = limit.excess(values[:, self.position[limit.measure]])
        own = [each for each in self.problem.requirements if each.measure.of_chain]
        of_chain = violation(tuple(own), values[:, [self.position[each.measure] for each in own]])
        columns = points, values, scores, excess, ties, of_chain
        return [Outcome(*each) for each in zip(*columns, strict=True)]

    @property
    def tops(self) -> list[Outcome]:
        """The best trials; if none meets all limits, the closest ones by their `closeness`."""
        if (first := self.closest) is None or self.best[0].met:
            return self.best
        others = [each for each in self.best if each.closeness[0] <= first.closeness[0]]
        return [first, *(each for each in others if not np.array_equal(each.x, first.x))]

    def slopes(self, point: Array) -> tuple[Outcome, Array, Array]:
        """Values at a point, the derivatives of all measures, shape (M, n), and linear models.

        The models are rows of a sample of the scatter (0 without), a value of the objective's
        measure, and its derivatives: of all maxima of the force on the wall and of all samples.
        """
        count = len(self.measures)
        self._require(self._cost_of_slopes)
        packed = self._journalled("slopes", [point], lambda: self._slopes(point))
        # The first entry of the last row is the cost, in simulations.
        self.gradients += 1
        (outcome,) = self.outcomes([point], packed[:count, 1:2].T)
        self._note([outcome], int(packed[-1, 0]))
        return outcome, packed[:count, 2:], packed[count:-1]

    @property
    def _cost_of_slopes(self) -> int:
        """Largest number of simulations that derivatives at a point are counted as."""
        if not self.exact:
            return (2 * self.problem.space.size + 1) * self.samples
        if self.draws is None:
            return exact_gradients.COST
        return self.samples * (1 + exact_gradients.COST)

    def _require(self, cost: int) -> None:
        if self.runs + cost > self.budget.runs:
            raise Spent

    def _slopes(self, point: Array) -> Array:
        """Rows of values and derivatives of measures, models and, in the last row, the cost."""
        found = self._exact_slopes(point) if self.exact else None
        if found is None:
            self._require((2 * len(point) + 1) * self.samples)
            values, slopes, cost = differences(
                lambda points: self._values(points, STEP_RTOL), point
            )
            cost *= self.samples
            found = values, slopes, np.zeros((0, 2 + len(point))), cost
        values, slopes, models, cost = found
        last = np.zeros((1, 2 + len(point)))
        last[0, 0] = cost
        own = np.column_stack([np.zeros(len(values)), values, slopes])
        return np.vstack([own, models, last])

    def _exact_slopes(self, point: Array) -> tuple[Array, Array, Array, int] | None:
        """Values, exact derivatives, models, and the cost; `None` if there are none here."""
        try:
            if self.draws is None:
                found = exact_gradients.values_and_slopes(self.problem, point)
                return *found, exact_gradients.COST
            chain = self.chain_of(point)
            if chain is None:
                return None
            sampled, values = self._sampled(chain)
            for i, each in enumerate(self.measures):
                if each.of_chain:
                    values[i] = each.from_chain(chain, np.nan)
            slopes, models, count = exact_gradients.scattered_slopes(
                self.problem, point, self.draws, sampled, self.bad, self.threads
            )
        except exact_gradients.NOT_COVERED:
            return None
        return values, slopes, models, len(self.draws) + count * exact_gradients.COST

    def simulated(self, chains: Sequence[Chain | None], rtol: float) -> Array:
        """Values of all measures of chains, shape (C, M), without summary of a scatter."""
        if self.problem.model != "simulation":
            return by_model(self.problem.model, chains, self.measures, self._reject)
        values = np.full((len(chains), len(self.measures)), np.nan)
        made = [chain is not None for chain in chains]
        found = measured(
            [chain for chain in chains if chain is not None], self.measures,
            rtol=rtol, until=self.problem.until, threads=self.threads,
            progress=self.report_progress,
        )  # fmt: skip
        values[made] = found.values
        for reason in found.reasons:
            self._reject(reason)
        return values

    def _values(self, points: Sequence[Any], rtol: float) -> Array:
        chains = [self.chain_of(point) for point in points]
        if self.draws is None:
            values = self.simulated(chains, rtol)
        else:
            values = np.array([self._summary(chain) for chain in chains])
        for i, (chain, point) in enumerate(zip(chains, points, strict=True)):
            price = self.problem.space.price(point)
            for j, each in enumerate(self.measures):
                if each.of_chain and chain is not None:
                    values[i, j] = each.from_chain(chain, price)
        return values

    def _summary(self, chain: Chain | None) -> Array:
        """Means or CVaR of the measures of chains with scatter."""
        if chain is None:
            return np.full(len(self.measures), np.nan)
        try:
            return self._sampled(chain)[1]
        except InputError as error:
            self._reject(str(error))
            return np.full(len(self.measures), np.nan)

    def _sampled(self, chain: Chain) -> tuple[Array, Array]:
        """Values of all samples of a scatter, shape (S, M), and their summary."""
        scatter = self.problem.scatter
        values = self.simulated(scatter._chains(chain, self.draws), RTOL)
        summary = np.array([
            column[scatter._worst(column, sign)].mean()
            for column, sign in zip(values.T, self.bad, strict=True)
        ])  # fmt: skip
        return values, summary

    def new_samples(self, point: Any, compute: Callable[[], Array]) -> Array:
        """Values of new samples after the search, from the journal if they are known.

        They do not count as time of the search.
        """
        key = _key("new samples", [point])
        known = self.journal.take(key)
        if known is None:
            known = compute()
            self.journal.add(key, self.journal.seconds, known)
        return known

    def chain_of(self, point: Any) -> Chain | None:
        """The chain at a point; `None`, and counted, if there is no such chain."""
        try:
            return self.problem.space.chain_of(point)
        except InputError as error:
            self._reject(str(error))
            return None

    def _reject(self, reason: str) -> None:
        with self.rejecting:
            self.reasons[reason] = self.reasons.get(reason, 0) + 1

    def add_counts(self, part: Trials) -> None:
        """Continue the counts of a search that is a part of this one."""
        self.runs, self.gradients = part.runs, part.gradients
        self.rejected, self.failures = part.rejected, part.failures

    def _journalled(self, what: str, points: Sequence[Any], compute: Callable[[], Array]) -> Array:
        key = _key(what, points)
        known = self.journal.take(key)
        if known is None:
            known = compute()
            self.journal.add(key, self.clock.seconds, known)
        elif not self.journal.known:
            self.clock.resume(self.journal.seconds)
        self.report_progress()
        return known

    def report_progress(self, *_: int) -> None:
        """Report the number of simulations, or the time, and the budget."""
        if self.progress is None:
            return
        if np.isfinite(self.budget.runs):
            budget, space = int(self.budget.runs), self.problem.space
            # Each choice is simulated once; a search with scatter begins without it.
            most = space.count * self.samples if isinstance(space, BallSpace) else budget
            total = int(most) if self.runs <= most < budget else budget
            self.progress(min(self.runs, total), total)
        else:
            whole = max(1, round(self.budget.seconds))
            self.progress(min(int(self.clock.seconds), whole), whole)

    def note_without_cost(self, found: Sequence[Outcome]) -> None:
        """Compare chains with the best trials that were simulated in addition to the budget."""
        self._note(found, 0)

    def _note(self, found: Sequence[Outcome], cost: int) -> None:
        """Count trials, keep the best ones, and record each improvement of the best score."""
        best = self.best[0].rank if self.best else (np.inf,) * 3
        for each in found:
            self.runs += cost
            if cost and not np.isfinite(each.values).all():
                self.rejected += 1
                self.failures += [each.x] * (len(self.failures) < MAX_FAILURES)
            if self.scores is not None and cost and each.met and np.isfinite(each.score):
                self.scores.append(each.score)
            if each.rank < best:
                best = each.rank
                if each.met and not (self.history and each.score >= self.history[-1][1]):
                    self.history.append((self.runs, each.score))
        known = {np.ascontiguousarray(each.x).tobytes(): each for each in [*self.best, *found]}
        usable = [each for each in known.values() if np.isfinite(each.rank).all()]
        closest = [self.closest] if self.closest is not None else []
        self.closest = min([*closest, *usable], key=lambda each: each.closeness, default=None)
        self.best = sorted(known.values(), key=lambda each: each.rank)[: self.kept]


def _key(what: str, points: Sequence[Any]) -> str:
    """Key of a record of the journal."""
    joined = b"".join(np.ascontiguousarray(point).tobytes() for point in points)
    return hashlib.sha256(what.encode() + joined).hexdigest()[:16]


def _place(point: Any, rtol: float) -> bytes:
    return str(rtol).encode() + np.ascontiguousarray(point).tobytes()

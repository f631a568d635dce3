"""Verification of the best trials of a search and of the chains to compare with."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..kernels.compile_notice import write_current
from ..simulation.slow_run import INTERVAL
from .limits_if_yielding import violated_only_if_yielding
from .new_samples import sampled_values, summary_of_samples
from .size_space import SizeSpace
from .verified import RTOL, Verified, excess_with_scatter, quietly

if TYPE_CHECKING:
    from .trials import Outcome, Trials


class Best(NamedTuple):
    """The best trial by verified values, its numbers, and those of the others, best first."""

    outcome: Outcome
    verified: Verified
    others: tuple[Verified, ...]


class Verification:
    """Numbers of trials from new simulations, with a line every few seconds."""

    def __init__(self, trials: Trials, chains: int) -> None:
        self.trials, self.chains, self.done = trials, chains, 0
        self.written = time.monotonic()

    def numbers(self, outcome: Outcome) -> Verified:
        """Numbers of a trial without new samples of a scatter, unless these are known."""
        trials, key = self.trials, np.ascontiguousarray(outcome.x).tobytes()
        self.done += 1
        if key not in trials.verified:
            problem = trials.problem
            chain, price = problem.space.chain_of(outcome.x), problem.space.price(outcome.x)
            if isinstance(problem.space, SizeSpace):
                chain = problem.space.with_short_sizes(chain)
            trials.verified[key] = quietly(problem, chain, price, None, self._report_chain)
        return trials.verified[key]

    def with_samples(self, outcome: Outcome, what: str) -> Verified:
        """Numbers of a verified trial; with a scatter, with those of new samples."""
        trials, key = self.trials, np.ascontiguousarray(outcome.x).tobytes()
        found = trials.verified[key]
        if trials.problem.scatter is None or found.scattered:
            return found

        def report(done: int, total: int) -> None:
            self._write(f"{done} of {total} new samples of the scatter, {what}")

        sampled = trials.new_samples(
            outcome.x,
            lambda: sampled_values(
                trials.problem, found.chain, trials.seed, trials.threads, report
            ),
        )
        trials.verified[key] = replace(found, scattered=summary_of_samples(trials.problem, sampled))
        return trials.verified[key]

    def reference(self, outcome: Outcome) -> Verified:
        """Numbers of a chain to compare with."""
        found, single = self.numbers(outcome), self.trials.problem.objective.single
        if single is None or single.of_chain:
            # The objective is not compared in samples.
            return found
        return self.with_samples(outcome, "chain to compare with")

    def best(self, tops: Sequence[Outcome]) -> Best:
        """The best of some trials.

        With a scatter, trials have the order of the search, since its values are summaries of
        samples; a violation in new samples counts as one in the search.  New samples are simulated
        only of trials that can still be the best ones, because a violation never improves a trial.
        """
        pairs = [(top, self.numbers(top)) for top in tops]
        if self.trials.problem.scatter is None:
            pairs.sort(key=lambda pair: self._verified_rank(*pair))
            return Best(*pairs[0], tuple(found for _, found in pairs[1:]))
        ranked = sorted(((top.rank, i, False) for i, (top, _) in enumerate(pairs)))
        while not ranked[0][2]:
            _, i, _ = ranked[0]
            top = pairs[i][0]
            found = self.with_samples(top, f"design {i + 1}" if i else "design")
            pairs[i] = top, found
            first, second, third = top.rank
            first += sum(excess_with_scatter(self.trials.problem, found).values())
            ranked = sorted([((first, second, third), i, True), *ranked[1:]])
        order = [pairs[i] for _, i, _ in ranked]
        return Best(*order[0], tuple(found for _, found in order[1:]))

    def _verified_rank(self, outcome: Outcome, found: Verified) -> tuple[float, ...]:
        """Order of verified trials.

        Contacts that yield may leave the range of the law, or violate limits, too.
        """
        trials = self.trials
        values = np.array([[found.values[str(each)] for each in trials.measures]])
        violated, *others = trials.outcomes([outcome.x], values)[0].rank
        guarded = any(each.default for each in trials.problem.requirements)
        outside = guarded and found.not_a_prediction
        broken = bool(violated_only_if_yielding(trials.problem, found))
        return violated, float(outside), float(broken), *others

    def _report_chain(self, *_: int) -> None:
        self._write(f"chain {self.done} of {self.chains} is integrated again at rtol {RTOL:g}")

    def _write(self, text: str) -> None:
        """Write a line, if a progress is shown and the last one is old enough."""
        now = time.monotonic()
        if self.trials.progress is not None and now - self.written >= INTERVAL:
            self.written = now
            write_current(f"hertzchain: verifying the result: {text}")

"""Smooth tapers by the local-rate law, with its own error estimate as a constraint.

The optimiser would otherwise find the errors of the law instead of good chains.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError, ModelRangeWarning
from ..recorded_warnings import ignore_warnings
from ..theory.local_rate import (
    DIFFERENTIABLE,
    local_rate,
    local_rate_gradient,
    velocity_errors,
)
from .problem import Design
from .requirements import Requirement
from .size_space import SizeSpace, size_space
from .sizes import Sizes

# Largest estimated error of the law in a design; smallest estimate that can be distinguished.  With
# a limit of 3e-3, the error of a design of 100 beads was 7e-3.
LIMIT, MIN_ESTIMATE = 2e-3, 1e-12
# The largest estimate of each of some parts of the chain is a constraint, approximated by the sum
# of this power.  With one constraint for all, the search would stop where several are largest.
SEGMENTS, POWER = 16, 40
# Numbers of coefficients of successive searches, before that of the problem.
COARSE: Final = (8, 16)
# Largest change of a coefficient in one search, relative to its range; number of searches with the
# coefficients of the problem.  The coarse ones are starts for these.
BOX, ROUNDS = 0.5, 4
# The searches end when one gains less than this, because the simulation gives the final digits.
ITERATIONS, MIN_GAIN = 25, 2e-2
PRECISION, COARSE_PRECISION = 1e-5, 1e-4
STEP: Final = 1e-6


def covers(problem: Design) -> bool:
    """Whether the law gives the objective, and all variables are splines of radii."""
    measure = problem.objective.single
    if problem.scatter is not None or problem.model != "simulation" or not problem.chain.lossless:
        return False
    if measure is None or measure.over is not None or measure.key not in DIFFERENTIABLE:
        return False
    one = problem.vary[0]
    if len(problem.vary) > 1 or not isinstance(one, Sizes):
        return False
    if one.by != "spline" or one.field != "radii" or one.monotone is not None or one.symmetric:
        return False
    if not all(each.measure.of_chain for each in problem.requirements):
        return False
    try:
        with ignore_warnings(ModelRangeWarning):
            local_rate(problem.chain)
    except InputError:
        return False
    return True


@dataclass(frozen=True, eq=False)
class Promise:
    """A point, the value that the law promises, and its estimated error."""

    x: Array
    value: float
    error: float


class Law:
    """The law as a function of the coefficients of a spline."""

    def __init__(self, problem: Design, space: SizeSpace) -> None:
        measure = problem.objective.single
        assert measure is not None
        self.problem, self.space, self.quantity = problem, space, measure.key
        self.bead = measure.index(problem.chain.beads) + 1
        self.sign = problem.objective.sign

    def chain(self, x: Array) -> Chain:
        """The chain at a point, which may be slightly outside the limits."""
        return self.space.chain_of(np.clip(x, 0.0, 1.0))

    def objective(self, x: Array) -> tuple[float, Array]:
        """Logarithm of the value, with its sign, and its derivatives."""
        chain = self.chain(x)
        value, logarithmic = local_rate_gradient(chain, self.quantity, bead=self.bead)
        slope = self.space.pull(np.clip(x, 0.0, 1.0), {"radii": logarithmic / chain.radii})
        return self.sign * float(np.log(value)), self.sign * slope

    def estimates(self, x: Array) -> Array:
        """Estimated errors of the velocities that the objective depends on; 1 if unknown."""
        chain, last = self.problem.chain, max(self.bead, 2)
        error: Array | None
        if chain.features or not isinstance(chain.exponents, float):
            error = local_rate(self.chain(x)).velocity_error
        else:
            error = velocity_errors(self.space.radii(np.clip(x, 0.0, 1.0)), chain.exponents)
        if error is None:
            return np.ones(last - 1)
        return np.nan_to_num(error[1:last], nan=1.0, posinf=1.0) + MIN_ESTIMATE

    def rooms(self, x: Array) -> Array:
        """Logarithms of the limit over the estimates of parts of the chain; negative beyond it."""
        parts = np.array_split(self.estimates(x), min(SEGMENTS, max(self.bead, 2) - 1))
        tops = [part.max() for part in parts]
        norms = [
            top * float(((part / top) ** POWER).sum()) ** (1.0 / POWER)
            for part, top in zip(parts, tops, strict=True)
        ]
        return float(np.log(LIMIT)) - np.log(norms)

    def room(self, x: Array) -> float:
        """The smallest of `rooms`."""
        return float(self.rooms(x).min())

    def rooms_slope(self, x: Array) -> Array:
        """Differences of `rooms`, shape (parts, n)."""
        steps = np.where(x < 0.5, STEP, -STEP)
        here = self.rooms(x)
        return np.array([(self.rooms(x + step) - here) for step in np.diag(steps)]).T / steps

    def limits(self) -> list[tuple[Callable[[Array], Array], Callable[[Array], Array]]]:
        """Constraints by which all radii are within their limits, and their derivatives."""
        (block,) = self.space.blocks
        low, high = block.limits
        rows = block.matrix * (high - low)
        rest = block.offset + block.matrix.sum(axis=1) * low
        least, most = block.ends
        return [
            (lambda x: rest + rows @ x - least, lambda _: rows),
            (lambda x: most - rest - rows @ x, lambda _: -rows),
        ]

    def excess(self, requirement: Requirement, x: Array) -> float:
        """Relative violation of a constraint on the chain."""
        return float(requirement.excess(requirement.measure.from_chain(self.chain(x), np.nan)))


def promise(problem: Design) -> Promise:
    """The best smooth design that the law finds within its range."""
    (vary,) = problem.vary
    assert isinstance(problem.space, SizeSpace)
    final = problem.space.size
    levels = [k for k in COARSE if k < final] + [None]
    chains: list[Chain] = []
    best: Promise | None = None
    with ignore_warnings(ModelRangeWarning):
        for level in levels:
            space = problem.space if level is None else (
                size_space(problem.chain, [vary.with_knots(level)])
            )  # fmt: skip
            law = Law(problem, space)
            starts = [space.point(chain) for chain in chains] or _tapers(space)
            found = [climb(law, start, coarse=level is not None) for start in starts]
            best = min(found, key=lambda each: (law.room(each.x) < -1e-3, each.value))
            chains = [law.chain(best.x)]
        assert best is not None
        return Promise(best.x, float(np.exp(law.sign * best.value)), best.error)


def _tapers(space: SizeSpace) -> list[Array]:
    """Starts: gentle tapers in both directions."""
    middle = float(space.point(space.chain).mean())
    ends = [min(1.0, middle + 0.15), max(0.0, middle - 0.15)]
    return [space.taper(middle, end) for end in ends]


def climb(law: Law, start: Array, *, coarse: bool) -> Promise:
    """Searches within boxes around the best point so far; ``value`` is the objective of the law."""
    from scipy.optimize import minimize

    (block,) = law.space.blocks
    # The search works with coefficients, of which a change by 1 is a change by a factor e.
    width = block.limits[1] - block.limits[0]

    def scaled(function: Callable[[Array], Array], by: float) -> Callable[[Array], Array]:
        return lambda c: function(c / width) / by

    def objective(c: Array) -> tuple[float, Array]:
        value, slope = law.objective(c / width)
        return value, slope / width

    constraints = [
        {"type": "ineq", "fun": scaled(fun, 1.0), "jac": scaled(jac, width)}
        for fun, jac in [(law.rooms, law.rooms_slope), *law.limits()]
    ]
    constraints += [
        {"type": "ineq", "fun": lambda c, r=each: -law.excess(r, c / width)}
        for each in law.problem.requirements
    ]
    x, box = np.clip(start, 0.0, 1.0), BOX
    value = law.objective(x)[0]
    precision = COARSE_PRECISION if coarse else PRECISION
    for _ in range(1 if coarse else ROUNDS):
        low, high = np.maximum(x - box, 0.0), np.minimum(x + box, 1.0)
        bounds = [*zip(width * low, width * high, strict=True)]
        try:
            found = minimize(
                objective, width * x, jac=True, method="SLSQP", bounds=bounds,
                constraints=constraints, options={"maxiter": ITERATIONS, "ftol": precision},
            )  # fmt: skip
            point = np.clip(found.x / width, 0.0, 1.0)
            gained = value - law.objective(point)[0]
            inside = law.room(point) > -1e-2
        except InputError:
            inside, gained = False, 0.0
        if inside and (gained > 0.0 or law.room(x) < -1e-2):
            moved = np.abs(point - x).max()
            x, value = point, value - gained
            if moved < 0.9 * box and gained < MIN_GAIN:
                break
        else:
            box *= 0.3
            if box < 1e-3:
                break
    return Promise(x, value, float(law.estimates(x).max()))

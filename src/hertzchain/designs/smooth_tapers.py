"""Smooth tapers by the local-rate law, with its own error estimate as a constraint.

The optimiser would otherwise find the errors of the law instead of good chains.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError, ModelRangeWarning
from ..theory.local_rate import DIFFERENTIABLE, local_rate, local_rate_gradient
from .problem import Design
from .requirements import Requirement
from .size_space import SizeSpace, size_space
from .sizes import Sizes

# Largest estimated error of the law in a design; smallest estimate that can be distinguished.
LIMIT, MIN_ESTIMATE = 1e-3, 1e-12
# Numbers of coefficients of successive searches, before that of the problem.
COARSE: Final = (6, 12)
# Largest change of a coefficient in one search, relative to its range; number of searches with the
# coefficients of the problem.  The coarse ones are starts for these.
BOX, ROUNDS = 0.5, 4
# The searches end when one gains less than this, because the simulation gives the final digits.
ITERATIONS, MIN_GAIN = 60, 1e-3
PRECISION, COARSE_PRECISION = 1e-5, 1e-4
STEP: Final = 1e-6


def covers(problem: Design) -> bool:
    """Whether the law gives the objective, and all variables are splines of radii."""
    sizes, measure = problem.vary, problem.objective.single
    sizes = [sizes] if isinstance(sizes, Sizes) else list(sizes)
    if problem.scatter is not None or problem.model != "simulation" or not problem.chain.lossless:
        return False
    if measure is None or measure.key not in DIFFERENTIABLE:
        return False
    if len(sizes) != 1 or not isinstance(sizes[0], Sizes):
        return False
    one = sizes[0]
    if one.by != "spline" or one.field != "radii" or one.monotone is not None or one.symmetric:
        return False
    if not all(each.measure.of_chain for each in problem.requirements):
        return False
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ModelRangeWarning)
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
    evaluations: int


class Law:
    """The law as a function of the coefficients of a spline."""

    def __init__(self, problem: Design, space: SizeSpace) -> None:
        measure = problem.objective.single
        assert measure is not None
        self.problem, self.space, self.quantity = problem, space, measure.key
        self.bead = measure.index(problem.chain.beads) + 1
        self.sign = float(np.sign(problem.objective.weights[0]))
        self.evaluations = 0

    def chain(self, x: Array) -> Chain:
        """The chain at a point, which may be slightly outside the limits."""
        return self.space.chain_of(np.clip(x, 0.0, 1.0))

    def objective(self, x: Array) -> tuple[float, Array]:
        """Logarithm of the value, with its sign, and its derivatives."""
        self.evaluations += 1
        chain = self.chain(x)
        value, logarithmic = local_rate_gradient(chain, self.quantity, bead=self.bead)
        slope = self.space.pull(np.clip(x, 0.0, 1.0), {"radii": logarithmic / chain.radii})
        return self.sign * float(np.log(value)), self.sign * slope

    def room(self, x: Array) -> float:
        """Logarithm of the limit over the estimated error; negative beyond the limit."""
        self.evaluations += 1
        error = local_rate(self.chain(x)).velocity_error
        assert error is not None
        worst = float(error[: self.bead].max()) if self.bead > 1 else 0.0
        if not np.isfinite(worst):
            return -10.0
        return float(np.log(LIMIT) - np.log(worst + MIN_ESTIMATE))

    def room_slope(self, x: Array) -> Array:
        """Differences of the estimate."""
        steps = np.where(x < 0.5, STEP, -STEP)
        here = self.room(x)
        return np.array([(self.room(x + step) - here) for step in np.diag(steps)]) / steps

    def limits(self) -> list[dict[str, Any]]:
        """Constraints by which all radii are within their limits."""
        (block,) = self.space.blocks
        low, high = block.limits
        rows = block.matrix * (high - low)
        rest = block.offset + block.matrix.sum(axis=1) * low
        least, most = block.ends
        return [
            {"type": "ineq", "fun": lambda x: rest + rows @ x - least, "jac": lambda _: rows},
            {"type": "ineq", "fun": lambda x: most - rest - rows @ x, "jac": lambda _: -rows},
        ]

    def excess(self, requirement: Requirement, x: Array) -> float:
        """Relative violation of a constraint on the chain."""
        return float(requirement.excess(requirement.measure.from_chain(self.chain(x), np.nan)))


def promise(problem: Design) -> Promise:
    """The best smooth design that the law finds within its range."""
    vary = problem.vary if isinstance(problem.vary, Sizes) else problem.vary[0]
    assert isinstance(problem.space, SizeSpace)
    final = problem.space.size
    levels = [k for k in COARSE if k < final] + [None]
    chains: list[Chain] = []
    best: Promise | None = None
    evaluations = 0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ModelRangeWarning)
        for level in levels:
            space = problem.space if level is None else (
                size_space(problem.chain, [vary.with_knots(level)])
            )  # fmt: skip
            law = Law(problem, space)
            starts = [space.point(chain) for chain in chains] or _tapers(space)
            found = [climb(law, start, coarse=level is not None) for start in starts]
            evaluations += law.evaluations
            best = min(found, key=lambda each: (law.room(each.x) < -1e-3, each.value))
            chains = [law.chain(best.x)]
        assert best is not None
        return Promise(best.x, float(np.exp(law.sign * best.value)), best.error, evaluations)


def _tapers(space: SizeSpace) -> list[Array]:
    """Starts: gentle tapers in both directions."""
    middle = float(space.point(space.chain).mean())
    ends = [min(1.0, middle + 0.15), max(0.0, middle - 0.15)]
    return [space.taper(middle, end) for end in ends]


def climb(law: Law, start: Array, *, coarse: bool) -> Promise:
    """Searches within boxes around the best point so far; ``value`` is the objective of the law."""
    from scipy.optimize import minimize

    constraints = [{"type": "ineq", "fun": law.room, "jac": law.room_slope}, *law.limits()]
    constraints += [
        {"type": "ineq", "fun": lambda x, r=each: -law.excess(r, x)}
        for each in law.problem.requirements
    ]
    x, box = np.clip(start, 0.0, 1.0), BOX
    value = law.objective(x)[0]
    precision = COARSE_PRECISION if coarse else PRECISION
    for _ in range(1 if coarse else ROUNDS):
        bounds = [*zip(np.maximum(x - box, 0.0), np.minimum(x + box, 1.0), strict=True)]
        try:
            found = minimize(
                law.objective, x, jac=True, method="SLSQP", bounds=bounds,
                constraints=constraints, options={"maxiter": ITERATIONS, "ftol": precision},
            )  # fmt: skip
            point = np.clip(found.x, 0.0, 1.0)
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
    return Promise(x, value, LIMIT * float(np.exp(-law.room(x))), law.evaluations)

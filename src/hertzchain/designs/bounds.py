"""Bounds that no design can exceed, from conservation of momentum and energy."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..chain.chain import Chain
from .ball_space import BallSpace
from .balls import Ball
from .measures import IMPULSE, Measure
from .problem import Design
from .requirements import TOLERANCE


@dataclass(frozen=True)
class Bound:
    """A limit of a measure: at least (sign 1) or at most (sign -1) a value, and the reason."""

    measure: Measure
    value: float
    sign: int
    reason: str

    def __str__(self) -> str:
        side = "at least" if self.sign > 0 else "at most"
        return f"{self.measure} is {side} {self.value:.4g}, because {self.reason}"

    def allows(self, limit: float, sign: int) -> bool:
        """Whether the measure can be at most (sign 1) or at least (sign -1) a limit."""
        return sign != self.sign or sign * (limit - self.value) >= -1e-9 * abs(self.value)


def bound_of(problem: Design, measure: Measure) -> Bound | None:
    """The bound of a measure for all designs; `None` if none is known."""
    chain = problem.chain
    if measure.over is not None or _driven(chain) or problem.until is not None:
        return None
    momentum = _momentum(chain)
    if momentum is None:
        return None
    if measure.key == IMPULSE and chain.left_wall is None:
        return Bound(measure, momentum, 1,
                     "the wall must stop the momentum of the impact")  # fmt: skip
    if measure.key == "energy_share":
        return Bound(measure, 1.0, -1, "no bead has more energy than the impact")
    if measure.key == "energy":
        return Bound(measure, _energy(chain), -1, "no bead has more energy than the impact")
    return None


def _driven(chain: Chain) -> bool:
    """Whether forces other than those of contacts and walls act on the beads."""
    return chain.drive is not None or chain.gravity != 0.0 or chain.precompression > 0.0


def _momentum(chain: Chain) -> float | None:
    """Momentum of the impact; `None` without one, or if a bead moves towards bead 1."""
    moving = chain.velocities != 0.0
    if not moving.any() or (chain.velocities < 0.0).any():
        return None
    return float(chain.masses @ chain.velocities)


def _energy(chain: Chain) -> float:
    return 0.5 * float(chain.masses @ chain.velocities**2)


def bounds_of(problem: Design) -> tuple[Bound, ...]:
    """Bounds of all measures of a problem, if its impact does not vary."""
    if impact_varies(problem):
        return ()
    found = [bound_of(problem, measure) for measure in problem.measures]
    return tuple(each for each in found if each is not None and math.isfinite(each.value))


def impact_varies(problem: Design) -> bool:
    """Whether a variable changes the masses of beads that move at time 0."""
    moving = set(np.flatnonzero(problem.chain.velocities).tolist())
    space = problem.space
    if isinstance(space, BallSpace):
        return bool(moving & set(space.places.tolist()))
    return any(
        moving & set(block.places.tolist()) for block in space.blocks if block.field != "gaps"
    )


def note_on_impact(problem: Design) -> list[str]:
    """A note if a bead that moves at the beginning is among those that vary."""
    strikers = problem.chain.strikers
    moving = np.flatnonzero(problem.chain.velocities)
    if not impact_varies(problem) or moving.max() >= max(1, strikers):
        return []
    what = f"striker{'s' if strikers > 1 else ''}" if strikers else "bead that moves at first"
    return [
        f"the {what} {'vary' if strikers > 1 else 'varies'}, too, and with it the impact; "
        f"beads = '{max(1, strikers) + 1}:' lets only the beads behind vary"
    ]


def impossible(problem: Design) -> str | None:
    """The reason why the constraints of a problem cannot be met, if a bound shows it."""
    for each in problem.requirements:
        if each.sign > 0 and each.limit < 0.0:
            return f"{each} cannot be met: {each.measure} is never negative"
    for bound in bounds_of(problem):
        for each in problem.requirements:
            if each.measure == bound.measure and not bound.allows(each.limit, each.sign):
                return f"{each} cannot be met: {bound}"
    return _outside_rows(problem)


def _outside_rows(problem: Design) -> str | None:
    """A limit that no row meets, because of the balls to choose from and their number."""
    space = problem.space
    if not isinstance(space, BallSpace):
        return None
    for each in problem.requirements:
        least, most = _range_of_rows(space, each.measure.key)
        side, nearest = ("least", least) if each.sign > 0 else ("most", most)
        if each.excess(nearest) > TOLERANCE:
            return f"{each} cannot be met: every row has at {side} {each.shown(nearest)}"
    return None


def _range_of_rows(space: BallSpace, key: str) -> tuple[float, float]:
    """Least and largest sum over the balls of a row; infinite for other measures."""
    chain = space.chain
    given = {"length": 2.0 * chain.radii, "mass": chain.masses, "beads": np.ones(chain.beads),
             "price": np.zeros(chain.beads)}  # fmt: skip
    striking = int((space.places < chain.strikers).sum())
    # Without a striker, the ball behind it would be one.
    if key not in given or (striking and space.optional):
        return -math.inf, math.inf
    if space.order:
        balls = given[key][space.places]
    else:
        counts = space.limits or [space.size] * len(space.balls)
        balls = np.repeat([_share(ball, key) for ball in space.balls], counts)
    fixed = np.setdiff1d(np.arange(chain.beads)[chain._balls], space.places)
    others, ordered = float(given[key][fixed].sum()), np.sort(balls)
    # The price is that of all balls that vary.
    left_out = 0 if key == "price" else striking
    least = ordered[: max(0, space.least - left_out)]
    most = ordered[::-1][: space.size - left_out]
    return others + float(least.sum()), others + float(most.sum())


def _share(ball: Ball, key: str) -> float:
    """Part of a ball in the length, mass, number of beads or price of a row."""
    if key == "mass":
        return ball.material.density * 4.0 / 3.0 * math.pi * ball.radius**3
    return {"length": ball.diameter, "beads": 1.0, "price": ball.price}[key]

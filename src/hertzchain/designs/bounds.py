"""Bounds that no design can exceed, from conservation of momentum and energy."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..chain.chain import Chain
from .ball_space import BallSpace
from .measures import IMPULSE, Measure, in_words
from .problem import Design


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
    if _driven(chain) or problem.until is not None:
        return None
    momentum = _momentum(chain)
    if momentum is None:
        return None
    if measure.key in ("wall_force.impulse", IMPULSE) and chain.left_wall is None:
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
    """Momentum of the impact; `None` if it depends on the design."""
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
    if hasattr(space, "places"):
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
    return _too_small(problem)


def _too_small(problem: Design) -> str | None:
    """Whether the balls that every row has are longer or heavier than a limit."""
    space, chain = problem.space, problem.chain
    if not isinstance(space, BallSpace) or space.order or _driven(chain):
        return None
    fixed = np.setdiff1d(np.arange(chain.strikers, chain.beads), space.places)
    smallest = min(2.0 * ball.radius for ball in space.balls)
    size = {"length": 2.0 * float(chain.radii[fixed].sum()),
            "mass": float(chain.masses[fixed].sum())}  # fmt: skip
    striking = int((space.places < chain.strikers).sum())
    size["length"] += smallest * max(0, space.least - striking)
    for each in problem.requirements:
        least = size.get(each.measure.key)
        if least is not None and each.sign > 0 and least > each.limit * (1.0 + 1e-9):
            shown = in_words(least, each.measure.unit, chain.units)
            which = "every row has at least" if space.least else "the balls that do not vary have"
            return f"{each} cannot be met: {which} {shown}"
    return None

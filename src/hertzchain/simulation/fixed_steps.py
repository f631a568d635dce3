"""Choice of a splitting method and its fixed step, and the loop that takes the steps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError, InputWarning, warn_user
from ..validation.numbers import number
from ..validation.objects import check_choice
from .kernel_input import static_closing
from .time_scales import transit_times, typical_speed

if TYPE_CHECKING:
    from ..kernels.symplectic import Springs


DEFAULT_DRIFT: Final = 1e-5
MIN_DRIFT, MAX_DRIFT = 1e-11, 1e-2
# Drift at which a run with a given step ends, relative to the largest energy.
UNSTABLE: Final = 0.5


@dataclass(frozen=True)
class Cost:
    """Drift and computing time of a method, measured on 100 equal beads between walls.

    The relative drift of the energy is ``size * a**order * b**growth``, where a and b are the step
    and the length of the run in units of 1/omega, with the highest angular frequency omega of the
    chain; ``price`` is the relative computing time of a step.
    """

    size: float
    order: float
    growth: float
    price: float

    def step(self, drift: float, length: float) -> float:
        """Step for a drift, both the step and the length in units of 1/omega."""
        return float((drift / (self.size * length**self.growth)) ** (1.0 / self.order))


COSTS: Final = {
    "verlet": Cost(0.083, 2.0, 0.0, 1.0),
    "forward-4": Cost(8.6e-4, 3.0, 0.5, 2.3),
}


@dataclass(frozen=True)
class FixedSteps:
    """A splitting method, its step [scaled, or s], and the largest drift that is accepted.

    A run that exceeds this drift is repeated with shorter steps, unless the step was ``given``.
    """

    name: str
    step: float
    drift: float = UNSTABLE
    given: bool = False

    def exceeded(self, drift: float) -> bool:
        """Whether a drift is too large; it is NaN if the energy overflows."""
        return not drift <= self.drift

    def shorter(self, excess: float) -> FixedSteps:
        """Steps for a run whose drift exceeded the request by this factor."""
        change = max(0.5, 0.85 * excess ** (-1.0 / COSTS[self.name].order))
        return replace(self, step=self.step * change)

    def warn(self, drift: float) -> None:
        """Warn about a given step that causes a large drift."""
        if self.given and MAX_DRIFT < drift <= self.drift:
            warn_user(
                f"with step = {self.step:g}, the energy has drifted by {drift:.1%}, and the run is "
                "not accurate: give a shorter step, or drift instead of step",
                InputWarning,
            )


def require_fixed_steps(chain: Chain) -> None:
    """Raise `InputError` for forces that depend on more than positions."""
    if not chain.lossless:
        raise InputError(
            f"method 'symplectic' supports elastic contacts only, but this chain has "
            f"{chain.loss if chain.loss is not None else 'losses'}, which depends on velocity or "
            "history; use method 'adaptive'"
        )
    if chain.drive is not None:
        raise InputError(
            f"method 'symplectic' does not support drives, but this chain has {chain.drive}; use "
            "method 'adaptive'"
        )


def fastest_frequency(chain: Chain) -> float:
    """Highest possible angular frequency: that of a contact that stores the whole energy."""
    masses = chain.masses
    motion = 0.5 * float((masses * chain.velocities**2).sum())
    motion = max(motion, 0.5 * float(masses.max()) * typical_speed(chain) ** 2)
    static = chain.static_state.forces
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = np.concatenate(([0.0], 1.0 / masses, [0.0]))
    k, p = chain.contact_stiffness, chain.contact_exponents
    there = k > 0.0
    k, p = k[there], p[there]
    lighter = (inverse[:-1] + inverse[1:])[there]
    resting = (static[there] / k) ** (1.0 / p)
    stored = k * resting ** (p + 1.0) / (p + 1.0)
    largest = ((p + 1.0) * (motion + stored) / k) ** (1.0 / (p + 1.0))
    # Neighbours that move in opposite directions deform the contacts on both sides of each bead.
    squared = p * k * lighter * np.maximum(largest ** (p - 1.0), 2.0 * resting ** (p - 1.0))
    return math.sqrt(float(squared.max()))


def fixed_steps(
    chain: Chain, method: str, step: float | None, drift: float | None, length: float | None
) -> FixedSteps | None:
    """Splitting method and step of a run; `None` for the adaptive method."""
    check_choice("method", method, ("adaptive", "symplectic", *COSTS))
    if method == "adaptive":
        if step is not None or drift is not None:
            raise InputError(
                "step and drift require method 'symplectic', 'verlet' or 'forward-4'; the error of "
                "method 'adaptive' is set by rtol"
            )
        return None
    require_fixed_steps(chain)
    if step is not None and drift is not None:
        raise InputError("give step or drift, not both: the step follows from the drift")
    names = [*COSTS] if method == "symplectic" else [method]
    return plan(chain, step, DEFAULT_DRIFT if drift is None else drift, length, names)


def plan(
    chain: Chain, step: float | None, drift: float, length: float | None, names: Sequence[str]
) -> FixedSteps:
    """Choose the fastest of some methods, with the given step or the step for a drift."""
    from ..kernels.symplectic import SPLITTINGS

    if step is not None:
        step = number("step", step, unit=chain._unit("s"), above=0.0)
    drift = number("drift", drift, least=MIN_DRIFT, most=MAX_DRIFT)
    frequency = fastest_frequency(chain)
    if frequency == 0.0:
        return FixedSteps(names[0], step or (length or 1.0) / 1000.0, given=step is not None)
    if length is None:
        length = 2.0 * float(transit_times(chain).sum())
    periods = max(1.0, frequency * length)
    if step is not None:
        name = names[-1]
        limit = SPLITTINGS[name].limit / frequency
        if not step < limit:
            unit = " s" if chain.units == "SI" else ""
            raise InputError(
                f"step = {step:g}{unit} is unstable: in the stiffest contact of this chain, steps "
                f"must be below {limit:.4g}{unit}; try {0.02 * limit:.2g}{unit}"
            )
        return FixedSteps(name, step, given=True)
    steps = {name: COSTS[name].step(drift, periods) for name in names}
    cheapest = min(steps, key=lambda name: COSTS[name].price / steps[name])
    longest = 0.2 * SPLITTINGS[cheapest].limit
    return FixedSteps(cheapest, min(steps[cheapest], longest) / frequency, drift)


class FixedLoop:
    """The compiled loop of fixed steps, with its arguments."""

    def __init__(self, chain: Chain, steps: FixedSteps) -> None:
        from ..kernels import symplectic

        self.kernel: Any = symplectic
        splitting = symplectic.SPLITTINGS[steps.name]
        self.numbers = tuple(
            np.array(each) for each in (splitting.kicks, splitting.drifts, splitting.gradients)
        )
        self.springs = _springs(chain)
        self.scratch = symplectic.new_scratch(chain.beads)  # type: ignore[no-untyped-call]

    def advance(
        self, integration: Any, end: tuple[float, bool], steps: int, work: int, pause: bool
    ) -> int:
        """Take at most this number of steps; return a code for the reason to stop."""
        arrays, frames = integration.state.arrays, integration.frames
        code: int = self.kernel.advance(
            arrays["y"], integration.clock, integration.counts, integration.equation,
            integration.contacts, self.springs,
            *self.numbers, *end, steps, work, pause, frames.times, frames.spacing is not None,
            frames.states, frames.forces, arrays["peaks"], arrays["crossings"], arrays["walls"],
            integration.accelerations, *self.scratch,
        )  # fmt: skip
        if integration.contacts is not None:
            integration.contacts.last_force[:] = self.scratch[0].forces
        return code


def _springs(chain: Chain) -> Springs:
    from ..kernels.symplectic import Springs

    static = chain.static_state
    exponents = np.array(chain.contact_exponents, float)
    gaps: Array = static.gaps - static_closing(chain)
    return Springs(
        inverse_mass=1.0 / chain.masses,
        stiffness=np.array(chain.contact_stiffness, float),
        closed_by=-gaps,
        exponents=exponents,
        same=bool(np.ptp(exponents) == 0.0),
        outside=static.body_forces / chain.masses,
    )

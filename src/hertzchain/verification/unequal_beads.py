"""Alternating heavy and light beads, and small beads between large ones."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from ..chain.chain import Chain
from ..simulation.simulate import simulate
from ..theory.effective_chain import effective_chain
from ..theory.solitary_wave import solitary_wave
from .case import TWO_INTEGRATIONS, Case

JAYAPRAKASH = "Jayaprakash et al., PRE 83, 036606 (2011): anti-resonances"


def cases() -> Iterator[Case]:
    """Mass ratios at which solitary waves exist, and ratios at which pulses decay."""
    for ratio in (1.0, 0.342845, 0.154752, 0.090127, 0.061503):
        yield Case(
            "dimers", f"velocity 181 over 61, mass ratio {ratio:g}", 1.0, 1e-8, JAYAPRAKASH,
            partial(_kept, ratio, 61, 181), "recalled",
        )  # fmt: skip
    for ratio, kept, tolerance in ((0.58, 0.58209, 2e-5), (0.2397, 0.94636, 2e-5),
                                   (0.1224, 0.99367, 2e-5)):  # fmt: skip
        yield Case(
            "dimers", f"velocity 81 over 41, mass ratio {ratio:g}", kept, tolerance,
            TWO_INTEGRATIONS, partial(_kept, ratio, 41, 81), "computed",
        )  # fmt: skip
    yield Case(
        "dimers", "time per cell over the effective chain's", 1.0, 2.5e-4,
        "springs in series; light beads of radius 0.3", _decorated,
    )  # fmt: skip


def _kept(ratio: float, first: int, last: int) -> float:
    run = simulate(Chain.dimer(ratio, beads=last + 40), times=0)
    velocity = run.pulse().velocity
    return float(velocity[last - 1] / velocity[first - 1])


def _decorated() -> float:
    decorated = Chain.uniform(60).decorated(0.3)
    pulse = simulate(decorated, times=0).pulse()
    effective = effective_chain(decorated)
    large = np.arange(40, 80, 2)
    assert pulse.peak_time is not None
    measured = float(np.diff(pulse.peak_time[large]).mean())
    middle = 20
    wave = solitary_wave()
    speed = wave.speed(
        velocity=float(pulse.velocity[large].mean()), mass=float(effective.masses[middle]),
        stiffness=float(effective.stiffness[middle]),
    )  # fmt: skip
    return measured * float(speed)

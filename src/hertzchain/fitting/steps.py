"""The order in which causes of residuals are tried that are not errors of columns or times."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from .ball_count_causes import likely_count, other_counts
from .cap_notes import before_departure
from .causes import Cause, Refit
from .common_effects import separate_effects
from .constant_causes import with_cap, with_exponent, with_masses, with_moduli, with_walls
from .free_causes import other_places, with_effects, with_losses, with_pairs, with_shots
from .gap_causes import gap_causes
from .result import FitResult
from .row_causes import row_causes
from .second_pulse import without_second_pulse
from .static_causes import static_causes, vertical_row


@dataclass(frozen=True)
class Step:
    """A function that tries causes, and words for those that other functions do not name."""

    tried: Callable[[FitResult, Mapping[str, float], Refit], Iterator[Cause]]
    words: str = ""
    # Words for the progress, if those above are empty.
    shown: str = ""
    # Whether it is tried although a delay explains the residuals, because its causes look like one.
    after_delays: bool = False
    # Whether it begins from the fit with free offsets of the sensors whose zeros are wrong, which
    # can hide its causes.
    with_zeros: bool = False


def _counts_and_effects(
    result: FitResult, start: Mapping[str, float], refit: Refit
) -> Iterator[Cause]:
    """Fits with another number of balls and with effects of sensors, which may look like it."""
    yield from likely_count(result, start, refit)
    yield from with_effects(result, start, refit)


# One after the other, until a cause explains the residuals.
STEPS: Final = (
    Step(without_second_pulse, shown="a second pulse"),
    Step(before_departure, shown="the departure of the cap"),
    Step(other_places, shown="other balls of a sensor"),
    Step(_counts_and_effects, shown="numbers of balls, and zeros, gains and delays"),
    Step(separate_effects, shown="effects of single sensors"),
    Step(vertical_row, "static forces", with_zeros=True),
    Step(row_causes, "odd balls", after_delays=True, with_zeros=True),
    Step(gap_causes, "one gap", with_zeros=True),
    Step(with_shots, "differences between shots", with_zeros=True),
    Step(with_losses, "the loss", with_zeros=True),
    Step(static_causes, "static forces", with_zeros=True),
    Step(with_exponent, "the exponent", with_zeros=True),
    Step(with_cap, "the cap and the walls", with_zeros=True),
    Step(with_walls, "the walls", with_zeros=True),
    Step(with_moduli, "the moduli", with_zeros=True),
    Step(with_masses, "the mass of balls with sensors", with_zeros=True),
    Step(other_counts, "one ball more or fewer", with_zeros=True),
    Step(with_pairs, shown="pairs of effects of sensors"),
)

"""Labels of logarithmic axes, in one notation per axis."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from matplotlib.ticker import Formatter

# Range of the numbers that are written without powers of ten.
PLAIN: Final = (1e-4, 1e5)
# Relative rounding errors of ticks.
ROUNDING: Final = 1e-9


class OneNotation(Formatter):
    """Plain numbers, or powers of ten for all numbers if a visible one is very small or large."""

    def __init__(self, factor: float = 1.0) -> None:
        self._factor = factor

    def __call__(self, value: float, pos: int | None = None) -> str:  # noqa: ARG002
        """Label of a single number."""
        shown = self._factor * value
        return with_power(shown) if _is_extreme([shown]) else f"{shown:g}"

    def format_ticks(self, values: Iterable[float]) -> list[str]:
        """Labels of all ticks, of which those beyond the limits of the axis are not visible."""
        assert self.axis is not None
        ticks = [self._factor * float(each) for each in values]
        low, high = sorted(self._factor * float(each) for each in self.axis.get_view_interval())
        visible = [each for each in ticks if low / (1 + ROUNDING) <= each <= high * (1 + ROUNDING)]
        write = with_power if _is_extreme(visible) else "{:g}".format
        return [write(each) for each in ticks]


def _is_extreme(values: Iterable[float]) -> bool:
    """Whether a number is outside the range of plain numbers."""
    low, high = PLAIN
    return any(not low * (1 - ROUNDING) <= each <= high * (1 + ROUNDING) for each in values)


def with_power(value: float) -> str:
    """A number with a power of ten, such as 5 x 10^-5 or 10^-4."""
    digits, _, power = f"{value:.6e}".partition("e")
    factor = f"{float(digits):g}"
    ten = f"10^{{{int(power)}}}"
    text = ten if factor == "1" else f"{factor}\\times{ten}"
    # In the font of plain numbers.
    return f"$\\mathdefault{{{text}}}$"

"""Colours, symbols and lines of the curves of pulses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

from .alternating_beads import END_SYMBOL, FILLABLE
from .style import MARKERS

# Lines of different methods, if curves of a chain share a colour.
LINES: Final = (
    "-", "--", ":", "-.", (0, (9, 2)), (0, (5, 1.5, 1, 1.5, 1, 1.5)), (0, (1, 4)),
    (0, (7, 1.5, 2.5, 1.5)), (0, (2, 2.5)), (0, (9, 1.5, 1, 1.5)),
)  # fmt: skip


@dataclass(frozen=True)
class Look:
    """Numbers of the colour, of the symbol and of the line of a curve, and of beads per symbol."""

    colour: int
    symbol: int
    line: int = 0
    spacing: int = 1
    alternating: bool = False

    @property
    def marker(self) -> str:
        """Symbol of the beads; those of heavy and light ones are filled and open."""
        symbols = FILLABLE if self.alternating else MARKERS
        # Curves whose colours repeat have another symbol: seven is no multiple of their number.
        return symbols[self.symbol % len(symbols)]

    @property
    def end(self) -> str:
        """Symbol of a free end, which must not look like that of a heavy bead."""
        return END_SYMBOL if self.alternating else self.marker


def looks_of(words: Sequence[Sequence[str]], begin: int, *, alternating: bool) -> list[Look]:
    """Colours by chain and lines by method if there are several of both, otherwise by pulse.

    Lines of several methods for one chain differ, too: they often coincide.
    """
    chains = list(dict.fromkeys(tuple(chain) for _, *chain in words))
    methods = list(dict.fromkeys(method for method, *_ in words))
    different = len({*map(tuple, words)}) == len(words) >= len(chains) + len(methods)
    if not different or min(len(chains), len(methods)) < 2:
        lines = range(len(words)) if len(methods) == len(words) else [0] * len(words)
        return [
            Look(begin + i, begin + i, line, begin + len(words), alternating)
            for i, line in enumerate(lines)
        ]
    return [
        # At a common bead, symbols of one colour would look like a filled one.
        Look(
            begin + chains.index((*chain,)),
            i := methods.index(method),
            i,
            len(methods),
            alternating,
        )
        for method, *chain in words
    ]


def share_colours(looks: Sequence[Look]) -> bool:
    """Whether colours show chains, and several pulses have the same one."""
    return len({look.colour for look in looks}) < len(looks)


def line_style(look: Look) -> dict[str, Any]:
    """Line and symbol of a curve, as arguments of `Axes.plot`."""
    return {
        "linestyle": LINES[look.line % len(LINES)], "linewidth": 0.9,
        "marker": look.marker, "markerfacecolor": "none",
    }  # fmt: skip

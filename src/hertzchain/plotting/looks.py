"""Colours, symbols and lines of the curves of pulses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

from .alternating_beads import END_SYMBOL, FILLABLE
from .colours import colour_of
from .methods import METHODS, looks_of_methods
from .style import MARKERS

# Lines of different methods, if curves of a chain share a colour.
LINES: Final = (
    "-", "--", ":", "-.", (0, (9, 2)), (0, (5, 1.5, 1, 1.5, 1, 1.5)), (0, (1, 4)),
    (0, (7, 1.5, 2.5, 1.5)), (0, (2, 2.5)), (0, (9, 1.5, 1, 1.5)),
)  # fmt: skip


@dataclass(frozen=True)
class Look:
    """Numbers of the colour, of the symbol and of the line of a curve, and of beads per symbol.

    Symbols of curves with another ``place`` are at other beads.
    """

    colour: int
    symbol: int
    line: int = 0
    place: int = 0
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


def looks_of(
    words: Sequence[Sequence[str]], numbers: Sequence[int], *, own: bool, alternating: bool
) -> list[Look]:
    """Colours by chain and lines by method if there are several of both, otherwise by pulse.

    ``numbers`` are those of free colours. Several methods for one chain have their ``own`` looks,
    unless the axes have other curves.
    """
    chains = list(dict.fromkeys(tuple(chain) for _, *chain in words))
    methods = list(dict.fromkeys(method for method, *_ in words))
    different = len({*map(tuple, words)}) == len(words) >= len(chains) + len(methods) - 1
    given = looks_of_methods(methods)
    if not different or min(len(chains), len(methods)) < 2:
        count, all_differ = max(numbers) + 1, len(methods) == len(words)
        if given and all_differ and len(words) > 1 and own:
            return [
                Look(each.colour, each.symbol, each.line, i, len(words), alternating)
                for i, each in enumerate(given)
            ]
        return [
            Look(number, number, i if all_differ else 0, number, count, alternating)
            for i, number in enumerate(numbers)
        ]
    return [
        # At a common bead, symbols of one colour would look like a filled one.
        Look(
            numbers[chains.index((*chain,))],
            given[i].symbol if given else i,
            given[i].line if given else i,
            i,
            len(methods),
            alternating,
        )
        for method, *chain in words
        for i in [methods.index(method)]
    ]


def method_style(method: str) -> dict[str, Any]:
    """Colour, line and name of a method, such as ``bca``, as arguments of `Axes.plot`."""
    name, colour, _, line = METHODS[method]
    return {"color": colour_of(colour), "linestyle": LINES[line], "label": name}


def share_colours(looks: Sequence[Look]) -> bool:
    """Whether colours show chains, and several pulses have the same one."""
    return len({look.colour for look in looks}) < len(looks)


def line_style(look: Look) -> dict[str, Any]:
    """Line and symbol of a curve, as arguments of `Axes.plot`."""
    return {
        "linestyle": LINES[look.line % len(LINES)], "linewidth": 0.9,
        "marker": look.marker, "markerfacecolor": "none",
    }  # fmt: skip

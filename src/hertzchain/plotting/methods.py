"""Name, colour, symbol and line of each method, which all figures of several methods share."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType
from typing import Final, NamedTuple


class Method(NamedTuple):
    """Name of a method in figures, and numbers of its colour, symbol and line.

    Numbers of colours are those of `curve_colour`, in which -1 is grey and 7 repeats 0.
    """

    name: str
    colour: int
    symbol: int
    line: int


# Colours and dashes are those of the app where it has the method.
METHODS: Final = MappingProxyType({
    "simulate": Method("simulation", 0, 0, 0),
    "propagate": Method("propagation", 1, 0, 0),
    "bca": Method("BCA", 2, 2, 1),
    "local-rate": Method("local-rate law", 3, 3, 3),
    "modified-bca": Method("modified BCA", 4, 4, 2),
    "two-thirds-bca": Method("2/3 BCA", 6, 6, 8),
    "hard-sphere": Method("hard sphere", -1, 7, 9),
    "effective-chain": Method("effective chain", 10, 8, 7),
    "piecewise-local-rate": Method("piecewise local-rate law", 12, 9, 6),
    "modified-bca-printed": Method("modified BCA, printed", 5, 5, 5),
})  # fmt: skip
# Look of the propagation beside the simulation, with which it coincides.
BESIDE: Final = METHODS["propagate"]._replace(symbol=1, line=4)
# Look of a method that is not listed.
OWN: Final = METHODS["modified-bca-printed"]
BY_NAME: Final = MappingProxyType({each.name: each for each in METHODS.values()})


def name_of(method: str) -> str:
    """Name in figures of a method of sweeps and scoreboards."""
    return METHODS[method].name if method in METHODS else method


def looks_of_methods(names: Sequence[str]) -> list[Method] | None:
    """Method of each name in figures or of sweeps; others look like methods that do not occur.

    None if there are more names than looks.
    """
    if len(names) > len(METHODS):
        return None
    # The BCA with a coefficient of restitution, and the modified one with other constants.
    found = [METHODS.get(each) or BY_NAME.get(each) or BY_NAME.get(each.partition(",")[0])
             for each in names]  # fmt: skip
    looks: list[Method | None] = [
        each if each not in found[:i] else None for i, each in enumerate(found)
    ]
    free = [each for each in reversed([*METHODS.values()]) if each not in looks]
    # First those whose colour no other method has.
    free.sort(key=lambda each: each.colour > 6)
    shown = [each or free.pop(0) for each in looks]
    both = METHODS["simulate"] in shown
    return [BESIDE if both and each == METHODS["propagate"] else each for each in shown]

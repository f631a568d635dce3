"""Kinks of the largest force: a small change makes another maximum the largest one."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from typing import Final

import numpy as np

from ..collision import Array
from ..representation import listed
from .backward_pass import backward_pass
from .dependence import Reader
from .names import Name
from .parameters import by_fields

# Relative change of one entry, and the deviation from the derivatives, relative to the largest
# change, from which these mislead.
PART, MISLEADING = 0.01, 0.1
# Maxima that are smaller by more than this part do not become the largest by such a change.
NEAR: Final = 0.05


def has_kinks(name: Name) -> bool:
    """Whether a quantity is the largest of several maxima."""
    return name.group.endswith(("wall_force", "body_force")) and name.item == "peak"


def kink_note(names: Iterable[str]) -> str:
    """The warning about parameters of which small changes lead beyond a kink."""
    return (
        f"a change of one of the {listed([*names])} by {PART:.0%} can make another maximum of the "
        "force the largest one, so that these derivatives are not valid for such changes"
    )


def mislead(expected: Array, larger: Array, smaller: Array) -> bool:
    """Whether changes of a value differ from the expected ones; unknown changes are NaN."""
    differences = np.maximum(np.abs(larger - expected), np.abs(smaller + expected))
    if np.isnan(differences).all():
        return False
    return bool(np.nanmax(differences) > MISLEADING * np.nanmax(np.abs(expected)))


def kinks_of_maxima(
    reader: Reader, name: Name, slopes: Mapping[str, Array], parameters: Mapping[str, Array]
) -> tuple[str, ...]:
    """Parameters of which a change by 1% makes another maximum the largest, by its derivatives."""
    if not has_kinks(name):
        return ()
    read = reader.read(dataclasses.replace(name, item="maxima"))
    top = read[0][1].value
    near = [each for _, each, _ in read[1:] if each.value > (1.0 - NEAR) * top]
    others = [by_fields(reader.record.equation, backward_pass(reader.record, each), slopes)
              for each in near]  # fmt: skip
    found = []
    for key, own in parameters.items():
        step = PART * np.atleast_1d(own)
        lines = [(each.value - top, step * other[key]) for each, other in
                 zip(near, others, strict=True)]  # fmt: skip
        expected = step * slopes[key]
        larger, smaller = (_largest(expected, lines, sign) for sign in (1.0, -1.0))
        if mislead(expected, larger, smaller):
            found.append(key)
    return tuple(found)


def _largest(expected: Array, lines: Sequence[tuple[float, Array]], sign: float) -> Array:
    """Change of the largest of several linear functions."""
    values = [sign * expected, *(below + sign * change for below, change in lines)]
    return np.asarray(np.max(values, axis=0))

"""Enlarged panels, for curves that are not visible beside stronger or longer ones."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes

from .style import MUCH, set_panel_title


class Group(NamedTuple):
    """Indices of the curves of an enlarged panel, and whether they have their own axis of times."""

    curves: list[int]
    short: bool


def small_groups(tops: Sequence[float], ends: Sequence[float]) -> list[Group]:
    """Groups of curves that are not visible beside the others: weak ones, and short ones.

    A group that has curves of very different size or length itself is followed by further ones.

    Parameters
    ----------
    tops, ends : sequence of float
        Largest value and last time of each curve.

    Examples
    --------
    >>> from hertzchain.plotting.enlarged import small_groups
    >>> small_groups([600.0, 40.0, 500.0], [1.0, 30.0, 30.0])
    [Group(curves=[1], short=False), Group(curves=[0], short=True)]
    """
    weak, short = _small(tops), _small(ends)
    kinds = [(i in weak, i in short) for i in range(len(tops))]
    groups = []
    for kind in ((True, False), (True, True), (False, True)):
        curves = [i for i, each in enumerate(kinds) if each == kind]
        if not curves:
            continue
        groups.append(Group(curves, kind[1]))
        smaller = small_groups([tops[i] for i in curves], [ends[i] for i in curves])
        groups += [Group([curves[i] for i in each.curves], kind[1] or each.short)
                   for each in smaller]  # fmt: skip
    return groups


def _small(values: Sequence[float]) -> set[int]:
    """Indices of the positive values that are much smaller than the largest one.

    Values are separated where neighbouring ones differ most: of similar ones, all are small, or
    none.
    """
    order = [int(i) for i in np.argsort(values) if values[i] > 0.0]
    large = order
    while large and values[large[-1]] > MUCH * values[large[0]]:
        ratios = [values[j] / values[i] for i, j in itertools.pairwise(large)]
        large = large[1 + int(np.argmax(ratios)) :]
    return {*order} - {*large}


def finish_enlarged(axes: Axes, first: Axes, names: str, *, short: bool) -> None:
    """State above an enlarged panel how its scales differ from those of the first panel.

    Times remain those of the first panel unless the curves are short.
    """
    if not short:
        axes.set_xlim(first.get_xlim())
    longest = first.get_xlim()[1]
    factors = {
        "force": first.get_ylim()[1] / axes.get_ylim()[1], "time": longest / axes.get_xlim()[1]
    }  # fmt: skip
    # Two digits, also of numbers above 100.
    scales = [
        f"{name} axis enlarged {float(f'{factor:.2g}'):g} times"
        for name, factor in factors.items()
        if factor > 1.1
    ]
    title = f"{names}: {' and '.join(scales)}"
    set_panel_title(axes, title, loc="left", fontsize="medium")

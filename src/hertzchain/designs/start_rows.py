"""Rows of balls with which a search begins, from texts such as ``2 x 5 mm ptfe``."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, short_repr
from ..representation import counted
from ..units import is_unit
from ..validation.numbers import number
from . import stock
from .ball_space import BallSpace
from .balls import Ball, among

# Ends a ball that moves at time 0 in the line `order` of a summary.
ARRIVES: Final = " (arrives)"
# An optional number of equal balls, a diameter with its unit, and an optional material.
_FORM: Final = re.compile(r"(?:(\d+) ?x )?(\d[\d./ ]*(?:e-?\d+ ?)?)(\w+)(?: (.+))?")


def start_row(space: BallSpace, given: Sequence[Any]) -> NDArray[np.int64]:
    """The choice with these balls from the first place on; further places are empty.

    Balls of the line ``order`` of a summary that arrive are left out, unless they vary.
    """
    groups = [_ball_and_count(entry, space.balls) for entry in _varying(space, given)]
    total = sum(count for _, count in groups)
    if total > space.size or (total < space.size and not space.optional):
        most = "at most " if space.optional else ""
        advice = "" if space.optional else "; optional = true permits empty places"
        raise InputError(
            f"start must have {most}{counted(space.size, 'ball')}, one for each place that varies, "
            f"got {total}{advice if total < space.size else ''}"
        )
    row = [ball for ball, count in groups for _ in range(count)]
    found = np.array(row + [len(space.balls)] * (space.size - total))
    if not space.long_enough(found):
        raise InputError(f"start must have at least {counted(space.least, 'ball')}, got {total}")
    if not space.in_stock(found):
        assert space.limits is not None
        missing = int(np.argmax(stock.excess(space.limits, found)))
        raise InputError(
            f"start has {row.count(missing)} balls of {space.balls[missing]}, of which "
            f"{space.limits[missing]} are in stock"
        )
    return found


def _varying(space: BallSpace, given: Sequence[Any]) -> list[Any]:
    """Balls without those that arrive; without only the mark of arrival if they vary."""
    vary = bool(np.isin(np.flatnonzero(space.chain.velocities), space.places).all())
    found = []
    for entry in given:
        arrives = isinstance(entry, str) and entry.endswith(ARRIVES)
        if not arrives or vary:
            found.append(entry.removesuffix(ARRIVES) if arrives else entry)
    return found


def _ball_and_count(entry: Any, balls: tuple[Ball, ...]) -> tuple[int, int]:
    """A ball of the catalogue, and how often it is repeated."""
    count, size, kind = _parts(entry)
    diameter = number("diameter of a ball of start", size, unit="m", above=0.0)
    fitting = [i for i, ball in enumerate(balls) if among(ball.diameter, (diameter,))
               and kind in ("", ball.material.name, ball.name.lower())]  # fmt: skip
    if not fitting:
        known = ", ".join(
            dict.fromkeys(f"{1e3 * b.diameter:g} mm {b.material.name}" for b in balls)
        )
        raise InputError(
            f"{short_repr(entry)} of start is not among the balls that may be chosen: {known}"
        )
    if len({balls[i].material for i in fitting}) > 1:
        kinds = " or ".join(balls[i].material.name for i in fitting)
        raise InputError(f"{short_repr(entry)} of start has no material: add {kinds}")
    return fitting[0], count


def _parts(entry: Any) -> tuple[int, Any, str]:
    """Number of balls, their diameter, and their material or name; empty if it is not given."""
    if not isinstance(entry, str):
        return 1, entry, ""
    form = _FORM.fullmatch(" ".join(entry.split()))
    if form is None or not is_unit(form[3]):
        raise InputError(
            "a ball of start must be a diameter with its unit, and a material if there are "
            f"several, such as '5 mm', '5 mm ptfe' or '2 x 5 mm ptfe', got {short_repr(entry)}"
        )
    return int(form[1] or 1), f"{form[2].strip()} {form[3]}", (form[4] or "").lower()

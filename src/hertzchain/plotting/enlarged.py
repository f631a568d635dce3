"""Enlarged panels, for curves that are not visible beside stronger or longer ones."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes

from .style import MUCH


def small_groups(tops: Sequence[float], ends: Sequence[float]) -> list[list[int]]:
    """Indices of curves that are not visible beside the others: weak ones, and short ones.

    Parameters
    ----------
    tops, ends : sequence of float
        Largest value and last time of each curve.

    Examples
    --------
    >>> from hertzchain.plotting.enlarged import small_groups
    >>> small_groups([600.0, 40.0, 500.0], [1.0, 4.0, 30.0])
    [[1], [0]]
    """
    weak = [i for i, top in enumerate(tops) if max(tops) > MUCH * top > 0.0]
    short = [i for i, end in enumerate(ends) if max(ends) > MUCH * end and i not in weak]
    return [group for group in (weak, short) if group]


def finish_enlarged(axes: Axes, first: Axes, names: str) -> None:
    """State above an enlarged panel how its scales differ from those of the first panel.

    Times remain those of the first panel unless curves would be short there.
    """
    longest, own = first.get_xlim()[1], axes.get_xlim()[1]
    if longest <= MUCH * own:
        axes.set_xlim(first.get_xlim())
    factors = {
        "force": first.get_ylim()[1] / axes.get_ylim()[1], "time": longest / axes.get_xlim()[1]
    }  # fmt: skip
    scales = [f"{name} axis enlarged {factor:.2g} times" for name, factor in factors.items()
              if factor > 1.1]  # fmt: skip
    axes.set_title(f"{names}: {' and '.join(scales)}", loc="left", fontsize="medium")

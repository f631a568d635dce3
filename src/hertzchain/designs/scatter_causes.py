"""The causes of a scatter, each simulated alone and sorted by their effect."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from ..chain.feature_support import require_chain
from ..errors import InputError
from ..frozen import ShortDir
from ..representation import short, usual_unit, with_decimals
from ..validation.keywords import checked_arguments, checked_methods
from ..validation.objects import Progress, callback
from .distribution import Distribution, distribution
from .scatter import Scatter, scatter_from
from .yield_range import YIELD_HIGH, YIELD_LOW

if TYPE_CHECKING:
    import pandas as pd

    from ..chain.chain import Chain

NOTE: Final = (
    "each cause has been simulated alone; the variances add up to that of all causes only if no "
    "cause changes the effect of another one"
)
NOT_RANDOM: Final = (
    "the changes in parentheses, from the smallest to the largest possible yield pressure, are not "
    "random and not part of any variance"
)


@checked_methods
@dataclass(frozen=True, eq=False, repr=False)
class ScatterCauses(ShortDir):
    """Effects of the causes of a scatter, each alone; result of `scatter_causes`.

    ``print(found)`` shows the table that ``hertzchain scatter --causes`` prints.

    Attributes
    ----------
    alone : dict of str to Distribution
        Values with each cause alone, by the cause in words, such as ``"speed +-5%"``, from the
        largest to the smallest standard deviation.
    """

    alone: Mapping[str, Distribution]

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per cause; ``attrs["units"]`` has the units ("1": scaled).

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(5).replace(right_wall=hc.Wall())
        >>> both = hc.Scatter(radius=0.001, speed=0.02, samples=20)
        >>> found = hc.scatter_causes(chain, "wall_force.peak", both)
        >>> list(found.to_dataframe().columns)
        ['mean', 'standard_deviation', 'failed']
        """
        import pandas as pd

        columns = "mean", "standard_deviation", "failed"
        rows = {
            cause: [getattr(each, name) for name in columns] for cause, each in self.alone.items()
        }
        table = pd.DataFrame.from_dict(rows, orient="index", columns=columns)
        table.index.name = "cause"
        unit = self._first.unit
        table.attrs["units"] = {"mean": unit, "standard_deviation": unit, "failed": "1"}
        return table

    @property
    def _first(self) -> Distribution:
        return next(iter(self.alone.values()))

    def _rows(self, harder: Distribution | None = None) -> list[list[str]]:
        """Cells of the heading and of each cause, with parts of the nominal value.

        That of the larger yield pressure, ``harder``, has the change of the nominal value.
        """
        first = self._first
        factor, unit = usual_unit(first.nominal, first.unit) if first.unit != "1" else (1.0, "")
        size = 100.0 / abs(first.nominal) if first.nominal else math.nan
        rows = [["each cause alone" + f", {YIELD_LOW}" * (harder is not None), "mean", "",
                 "standard deviation", ""]]  # fmt: skip
        for cause, each in self.alone.items():
            values, spread = (each.mean, each.standard_deviation), each.standard_deviation
            texts = with_decimals([factor * value for value in values], factor * spread)
            parts = with_decimals([size * value for value in values], size * spread)
            cells = [cause]
            for text, part in zip(texts, parts, strict=True):
                cells += [f"{text} {unit}".rstrip(), f"{part}%"]
            rows.append(cells)
        if harder is not None:
            value, part = f"{factor * harder.nominal:.4g} {unit}", f"{size * harder.nominal:.4g}%"
            change = harder.nominal - first.nominal
            # The row has its place in the order of the effects.
            place = 1 + sum(each.standard_deviation >= abs(change) for each in self.alone.values())
            changes = f"({factor * change:+.3g} {unit}".rstrip() + ")", f"({size * change:+.3g}%)"
            rows.insert(place, [f"{YIELD_HIGH}, without deviations", value, part, *changes])
        return rows

    def _table(self, harder: Distribution | None = None) -> str:
        """Lines with the mean and the standard deviation of each cause, and notes."""
        rows = self._rows(harder)
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = [
            "  ".join([f"  {name:{widths[0]}}", *map(str.rjust, cells, widths[1:])])
            for name, *cells in rows
        ]
        notes = [f"note: {note}" for note in ([] if harder is None else [NOT_RANDOM]) + [NOTE]]
        return "\n".join([*(line.rstrip() for line in lines), *notes])

    def __str__(self) -> str:
        return self._table()

    def __repr__(self) -> str:
        first = self._first
        ranked = (f"{row[-1]} by {row[0]} alone" for row in self._rows()[1:])
        return short("ScatterCauses", f"standard deviation of {first.quantity}", *ranked)

    def _repr_html_(self) -> str:
        from ..notebook.designs import scatter_causes_html

        return scatter_causes_html(self)


@checked_arguments("scatter_causes")
def scatter_causes(
    chain: Chain,
    quantity: str,
    scatter: Scatter,
    *,
    until: float | str | None = None,
    seed: int = 1,
    threads: int | None = None,
    progress: Progress | None = None,
) -> ScatterCauses:
    r"""Rank the causes of a scatter by their effect on a quantity.

    `distribution` is evaluated with each of the deviations alone: of the radii, the gaps, the
    speed, Young's modulus and the yield strength.  The standard deviations :math:`s_i` are those
    of the causes; :math:`s^2 = \sum_i s_i^2` holds for all causes together only if no cause
    changes the effect of another one.

    Parameters
    ----------
    chain : Chain
        The chain without deviations.
    quantity : str
        Name such as ``"wall_force.peak"``, as in `distribution`.
    scatter : Scatter
        At least two deviations, with the number of chains of each, ``samples``.
    until : float or str, optional
        Stop time of the simulations; by default they end when the quantity is complete.
    seed : int
        Seed of the random numbers, the same for each cause.
    threads : int, optional
        Number of threads, by default one for each processor.
    progress : callable, optional
        Called as ``progress(chains_done, chains)``.

    Returns
    -------
    ScatterCauses

    Raises
    ------
    InputError
        If there are fewer than two causes, or for a reason that `distribution` has.
    SimulationError
        If fewer than two chains of a cause have a value.

    Warns
    -----
    ModelRangeWarning
        If chains exceed the limits of Hertz's law.

    See Also
    --------
    distribution : Values with all causes together.

    Examples
    --------
    >>> import hertzchain as hc
    >>> balls = hc.Chain.from_materials("5 mm", "steel-52100", beads=10, right_wall=hc.Wall())
    >>> row = balls.struck_by(velocity="0.1 m/s")
    >>> scatter = hc.Scatter(grade=100, gaps="5 um", speed="2%", samples=100)
    >>> print(hc.scatter_causes(row, "wall_force.peak", scatter))
      each cause alone          mean             standard deviation
      speed +-2%            25.693 N    100.15%             0.635 N     2.48%
      random gaps (5 um)   26.4982 N   103.291%            0.0697 N    0.272%
      grade 100           25.65385 N  99.99951%           0.00198 N  0.00773%
    note: each cause has been simulated alone; ...
    """
    callback("progress", progress)
    require_chain("scatter_causes", chain)
    deviations = scatter_from(scatter)
    causes = {} if deviations is None else deviations._causes(chain.units)
    if len(causes) < 2:
        raise InputError(
            "scatter_causes compares at least two causes, such as Scatter(grade=100, "
            f"gaps='5 um'), got {next(iter(causes), 'none')}"
        )
    found: dict[str, Distribution] = {}
    for cause, alone in causes.items():
        found[cause] = distribution(
            chain, quantity, alone, until=until, seed=seed, threads=threads,
            progress=_part_of(progress, len(found), len(causes)),
        )  # fmt: skip
    spreads = {cause: each.standard_deviation for cause, each in found.items()}
    return ScatterCauses(
        {each: found[each] for each in sorted(found, key=lambda key: -spreads[key])}
    )


def _part_of(progress: Progress | None, number: int, causes: int) -> Progress | None:
    """Progress of all causes, of which ``number`` are done."""
    if progress is None:
        return None
    return lambda done, total: progress(number * total + done, causes * total)

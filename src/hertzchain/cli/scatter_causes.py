"""The causes of a scatter, each simulated alone and sorted by their effect."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, Final

import click

if TYPE_CHECKING:
    from ..chain.chain import Chain
    from ..designs.distribution import Distribution
    from ..designs.scatter import Scatter

NOTE: Final = (
    "each cause has been simulated alone; the variances add up to that of all causes only if no "
    "cause changes the effect of another one"
)
NOT_RANDOM: Final = (
    "the changes in parentheses, from the smallest to the largest possible yield pressure, are not "
    "random and not part of any variance"
)


def causes_of(deviations: Scatter, chain: Chain, *, as_csv: bool) -> dict[str, Scatter]:
    """Scatters with each cause alone, by their words."""
    causes = deviations._causes(chain.units)
    if as_csv or len(causes) < 2:
        raise click.UsageError(
            "--causes compares at least two causes, such as --grade 100 --gaps 5um, and cannot be "
            "combined with --csv"
        )
    return causes


def each_alone(
    chain: Chain, causes: Iterable[str], simulated: Callable[[Chain, str, str], Distribution]
) -> dict[str, Distribution]:
    """Values with each cause alone, from the largest to the smallest standard deviation."""
    from ..errors import ModelRangeWarning
    from ..recorded_warnings import ignore_warnings

    with ignore_warnings(ModelRangeWarning):  # That of all causes together is shown.
        found = {cause: simulated(chain, f" with {cause} alone", cause) for cause in causes}
    spreads = {cause: each.standard_deviation for cause, each in found.items()}
    return {cause: found[cause] for cause in sorted(found, key=lambda each: -spreads[each])}


def causes_document(alone: dict[str, Distribution]) -> list[dict[str, Any]] | None:
    """The same for JSON; None if they were not requested."""
    found = [
        {
            "cause": cause,
            "mean": each.mean,
            "standard_deviation": each.standard_deviation,
            "failed": each.failed,
        }
        for cause, each in alone.items()
    ]
    return found or None


def causes_table(alone: dict[str, Distribution], harder: Distribution | None) -> str:
    """Lines with the mean and the standard deviation of each cause; empty without any.

    That of the larger yield pressure, ``harder``, has the change of the nominal value.
    """
    from ..designs.yield_range import YIELD_HIGH, YIELD_LOW
    from ..representation import usual_unit, with_decimals

    if not alone:
        return ""
    first = next(iter(alone.values()))
    factor, unit = usual_unit(first.nominal, first.unit) if first.unit != "1" else (1.0, "")
    size = 100.0 / abs(first.nominal) if first.nominal else math.nan
    rows = [["each cause alone" + f", {YIELD_LOW}" * (harder is not None), "mean", "",
             "standard deviation", ""]]  # fmt: skip
    for cause, each in alone.items():
        values = each.mean, each.standard_deviation
        texts = with_decimals(
            [factor * value for value in values], factor * each.standard_deviation
        )
        parts = with_decimals([size * value for value in values], size * each.standard_deviation)
        cells = zip(texts, parts, strict=True)
        rows.append([cause, *(cell for text, part in cells
                              for cell in (f"{text} {unit}".rstrip(), f"{part}%"))])  # fmt: skip
    notes = [f"note: {NOTE}"]
    if harder is not None:
        value, part = f"{factor * harder.nominal:.4g} {unit}", f"{size * harder.nominal:.4g}%"
        change = harder.nominal - first.nominal
        # The row has its place in the order of the effects.
        place = 1 + sum(each.standard_deviation >= abs(change) for each in alone.values())
        changes = f"({factor * change:+.3g} {unit}".rstrip() + ")", f"({size * change:+.3g}%)"
        rows.insert(place, [f"{YIELD_HIGH}, without deviations", value, part, *changes])
        notes.insert(0, f"note: {NOT_RANDOM}")
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = [
        "  ".join([f"  {name:{widths[0]}}",
                   *(f"{cell:>{width}}" for cell, width in zip(cells, widths[1:], strict=True))])
        for name, *cells in rows
    ]  # fmt: skip
    return "\n".join([*(line.rstrip() for line in lines), *notes])

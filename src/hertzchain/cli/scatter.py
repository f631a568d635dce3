"""The command `scatter`: a quantity of many chains whose beads or gaps deviate at random."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from ..recorded_warnings import ignore_warnings
from .chain_completion import complete_grades
from .chain_options import ChainOptions, chain_from, chain_options
from .exit_codes import DONE, FAILED
from .options import (
    Grade,
    StrictCommand,
    as_typed,
    by_name,
    figure_option,
    json_option,
    length_from,
    measure_from,
    quantity_option,
    time_from,
    until_option,
)
from .output import save_figure, show_json
from .progress import progress_bar
from .wording import on_command_line
from .wrapped_text import show_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..chain.chain import Chain
    from ..designs.distribution import Distribution
    from ..designs.scatter import Scatter
    from ..designs.scatter_causes import ScatterCauses

PERCENTILES: Final = (1, 5, 50, 95, 99)
NO_SCATTER: Final = (
    "give --scatter, such as 1%, or --grade, such as 100, or --gaps, such as 5um, or "
    "--speed-scatter, such as 2%, or --young-scatter or --yield-scatter, such as 5%"
)

ONE_CAUSE: Final = "--causes compares at least two causes, such as --grade 100 --gaps 5um"


@click.command(cls=StrictCommand)
@chain_options
@click.option(
    "--scatter",
    "relative",
    metavar="SCATTER",
    help="Relative standard deviation of each diameter, such as 0.01 or 1%.  Logarithms of "
    "diameters are normally distributed.",
)
@click.option(
    "--grade",
    type=Grade(),
    shell_complete=complete_grades,
    help="Grade of the balls by ISO 3290-1, from 3 to 200 (or G3 to G200), instead of --scatter.  "
    "Diameters are uniformly distributed over the variation that the grade permits within a lot: "
    "0.5 um (nominal +-0.25 um) for grade 10, and 5 um for grade 100.",
)
@click.option(
    "--gaps",
    metavar="LENGTH",
    help="Add a random gap between balls, such as 5um, alone or with --scatter or --grade.  Each "
    "gap is the absolute value of a normal variable with this standard deviation.",
)
@click.option(
    "--speed-scatter",
    "of_speed",
    metavar="SCATTER",
    help="Relative standard deviation of the speed of the impact, such as 0.02 or 2%, alone or in "
    "addition.  That of the height of a fall is twice as large.  Logarithms are normally "
    "distributed.",
)
@click.option(
    "--young-scatter",
    "of_young",
    multiple=True,
    metavar="[MATERIAL=]SCATTER",
    help="Relative standard deviation of Young's modulus of all materials or of one, such as 5% or "
    "nylon=20%, alone or in addition; repeatable, and with a name, an exception.  It is a property "
    "of the material, not of a ball: in each random chain, all balls, strikers and walls of one "
    "material have the same factor, and those of other materials have another one.  Logarithms "
    "are normally distributed.",
)
@click.option(
    "--yield-scatter",
    "of_yield",
    multiple=True,
    metavar="[MATERIAL=]SCATTER",
    help="The same for the yield strength, with --loss elastic-plastic.",
)
@click.option(
    "--only",
    "some",
    metavar="BEADS",
    help="Beads whose diameters and gaps deviate, such as '2:' (all from bead 2 on) or '3:8'.  "
    "[default: all but strikers]",
)
@click.option(
    "--chains", "count", type=int, default=300, show_default=True, help="Number of chains."
)
@click.option("--seed", type=int, default=1, show_default=True, help="Seed of the random numbers.")
@click.option(
    "--causes", "apart", is_flag=True,
    help="Also simulate each cause alone, with as many chains, and list the causes by their "
    "standard deviation.",
)  # fmt: skip
@quantity_option
@until_option
@json_option()
@click.option("--csv", "as_csv", is_flag=True, help="Print the values of all chains as CSV.")
@figure_option("Plot the distribution to FILE.")
def scatter(
    options: ChainOptions, relative: str | None, grade: int | None, gaps: str | None,
    of_speed: str | None, of_young: tuple[str, ...], of_yield: tuple[str, ...], some: str | None,
    count: int, seed: int, apart: bool, quantity: str | None, until: str | None, as_json: bool,
    as_csv: bool, plot: Path | None,
) -> int:  # fmt: skip
    """Show how much random deviations change a quantity.

    Many chains with random deviations are simulated, and the distribution of the quantity is
    printed.  All else is as in the given chain.  If there is no striker, bead 1 is the projectile,
    and its mass scatters, too; use --only "2:" to keep the momentum of the impact.  Without
    simulations, `hertzchain pulse --method disorder` predicts mean and spread of the leading pulse.

    \b
    Examples:
      hertzchain scatter --material steel-52100 --diameter "10 mm" --beads 20 \\
          --speed "0.1 m/s" --wall same --scatter 1%
      hertzchain scatter chain.toml --grade 100 --quantity arrival@last --plot arrival.png
      hertzchain scatter chain.toml --gaps 5um
      hertzchain scatter chain.toml --grade 100 --speed-scatter 2%
      hertzchain scatter chain.toml --young-scatter 1% --young-scatter nylon=20%
      hertzchain scatter chain.toml --grade 100 --gaps 5um --speed-scatter 2% --causes
    """
    import hertzchain

    from ..chain.impact_speed import relative_deviation
    from ..validation.numbers import whole_number

    if as_csv and (as_json or apart):
        raise click.UsageError("--csv cannot be combined with --json or --causes")
    if relative is not None and grade is not None:
        raise click.UsageError("give --scatter, such as 1%, or --grade, such as 100, not both")
    given = (relative, grade, gaps, of_speed, of_young or None, of_yield or None)
    if all(each is None for each in given):
        if quantity is not None:
            measure_from(quantity, chain_from(options))
        raise click.UsageError(NO_SCATTER)
    whole_number("--seed", seed, least=0)
    whole_number("--chains", count, least=2, most=10_000)
    chain = chain_from(options)
    part = None if relative is None else _part(relative, chain)
    name, end = str(measure_from(quantity, chain)), time_from("--until", until, chain)
    sizes = None if gaps is None else length_from("--gaps", gaps, chain)
    speed = None if of_speed is None else relative_deviation("--speed-scatter", as_typed(of_speed))
    young = _of_materials("--young-scatter", of_young)
    strength = _of_materials("--yield-scatter", of_yield)
    deviations = hertzchain.Scatter(
        part, grade, samples=count, beads=some, gaps=sizes, speed=speed, young=young,
        yield_strength=strength,
    )  # fmt: skip

    if apart and len(deviations._causes(chain.units)) < 2:
        raise click.UsageError(ONE_CAUSE)

    def simulated(row: Chain, words: str = "") -> Distribution:
        with progress_bar(f"random chains and the nominal one{words}") as progress:
            return hertzchain.distribution(
                row, name, deviations, until=end, seed=seed, progress=progress
            )

    found = simulated(chain)
    alone = _each_alone(chain, name, deviations, end, seed) if apart else None
    harder = (
        None if as_csv and plot is None else _at_fully_plastic_pressure(chain, found, simulated)
    )
    if plot is not None:
        save_figure(_plotted(found, harder), plot)
    if as_json:
        show_json(_document(found, harder) | {"causes": _causes_document(alone)})
    elif as_csv:
        unit = "" if found.unit == "1" else f" [{found.unit}]"
        click.echo(f"{found.quantity}{unit}")
        click.echo("\n".join(map(repr, found.values.tolist())))
    else:
        tables = [_table(found, harder)] + ([] if alone is None else [alone._table(harder)])
        show_text("\n".join(tables))
    return FAILED if found.failed else DONE


def _each_alone(
    chain: Chain, name: str, deviations: Scatter, end: float | None, seed: int
) -> ScatterCauses:
    """Values with each cause alone; the warning for all causes together has been shown."""
    from ..designs.scatter_causes import scatter_causes
    from ..errors import ModelRangeWarning

    with (
        progress_bar("random chains with each cause alone") as progress,
        ignore_warnings(ModelRangeWarning),
    ):
        return scatter_causes(chain, name, deviations, until=end, seed=seed, progress=progress)


def _part(text: str, chain: Chain) -> float:
    """A scatter, which need not be a percentage."""
    from ..chain.random_radii import relative_scatter

    return relative_scatter("--scatter", as_typed(text), chain=chain, above=0.0)


def _of_materials(option: str, texts: tuple[str, ...]) -> float | dict[str, float] | None:
    """A scatter of a constant of all materials, or by material."""
    from ..chain.per_contact import OTHERS
    from ..chain.random_materials import spread_from

    given = by_name(option, "material", "nylon", OTHERS, texts)
    return None if given is None else spread_from(option, given)


def _at_fully_plastic_pressure(
    chain: Chain, found: Distribution, simulated: Callable[[Chain, str], Distribution]
) -> Distribution | None:
    """The same random chains at the largest possible yield pressure, if this changes values."""
    import numpy as np

    from ..chain.materials import FULLY_PLASTIC
    from ..chain.yield_pressure import assumes_pressure, with_factor

    if not assumes_pressure(chain):
        return None
    other = simulated(with_factor(chain, FULLY_PLASTIC), " at the larger yield pressure")
    same = found.nominal == other.nominal and np.array_equal(found.values, other.values)
    return None if same else other


def _plotted(found: Distribution, harder: Distribution | None) -> Axes:
    if harder is None:
        return found.plot()
    from ..designs.yield_range import YIELD_HIGH, YIELD_LOW
    from ..plotting.distributions import plot_at_both_pressures

    return plot_at_both_pressures(found, harder, (YIELD_LOW, YIELD_HIGH))


def _document(found: Distribution, harder: Distribution | None) -> dict[str, Any]:
    from ..validation.json_types import finite

    causes = "radius", "grade", "gaps", "speed", "young", "yield_strength"
    given = {key: getattr(found.scatter, key) for key in causes}
    return {
        "scatter": given,
        "quantity": found.quantity,
        "unit": found.unit,
        **_statistics(found),
        "at_fully_plastic_pressure": None if harder is None else _statistics(harder),
        "nominal_with_yielding_contacts": None if isnan(found.yielding) else found.yielding,
        "yielding_overlap_ratio": finite(found.yielding_overlap_ratio),
        "yielding_within_range": None if isnan(found.yielding) else not found._with_yield.outside,
        "reason": found.reason,
        "outside_range": found.outside_range,
        "values": found.values.tolist(),
        "notes": _notes(found, harder),
    }


def _causes_document(alone: ScatterCauses | None) -> list[dict[str, Any]] | None:
    """Effects of each cause, in their order; None if they were not requested."""
    return None if alone is None else alone.to_dataframe().reset_index().to_dict("records")


def _statistics(found: Distribution) -> dict[str, Any]:
    return {
        "nominal": found.nominal,
        "mean": found.mean,
        "standard_deviation": found.standard_deviation,
        "percentiles": {str(percent): found.percentile(percent) for percent in PERCENTILES},
        "failed": found.failed,
    }


def _rows(found: Distribution, percents: Sequence[int]) -> dict[str, float]:
    """Values of a distribution, by the names of their rows."""
    rows = {"nominal": found.nominal, "mean": found.mean,
            "standard deviation": found.standard_deviation}  # fmt: skip
    return rows | {f"{percent}% are below": found.percentile(percent) for percent in percents}


def _column(found: Distribution, percents: Sequence[int], factor: float, unit: str) -> list[str]:
    """The same values in words."""
    from ..representation import with_decimals

    values = [factor * value for value in _rows(found, percents).values()]
    shown = with_decimals(values, factor * found.standard_deviation)
    return [f"{value} {unit}".rstrip() for value in shown]


def _table(found: Distribution, harder: Distribution | None) -> str:
    """Lines with values, each also relative to the nominal chain."""
    from ..designs.yield_range import YIELD_HIGH, YIELD_LOW
    from ..representation import usual_unit, with_decimals

    # Notes state which percentiles so few values do not determine.
    both = [found] if harder is None else [found, harder]
    few = {each for each in PERCENTILES for one in both if one._few_values_note([each])}
    percents = [each for each in PERCENTILES if each not in few]
    rows, good = _rows(found, percents), len(found.values)
    lines = [found.chain.description]
    lines.append(f"{found.quantity}: {good} of {good + found.failed} random chains")
    unit = usual_unit(found.nominal, found.unit) if found.unit != "1" else (1.0, "")
    columns = [_column(found, percents, *unit), [""] * len(rows)]
    if found.nominal:
        relative = [100.0 * value / found.nominal for value in rows.values()]
        spread = 100.0 * found.standard_deviation / abs(found.nominal)
        columns[1] = ["", *(f"{part}%" for part in with_decimals(relative, spread)[1:])]
    names = [*rows]
    if harder is not None:
        columns.append(_column(harder, percents, *unit))
        names.insert(0, "")
        headings = YIELD_LOW, "", YIELD_HIGH
        for heading, column in zip(headings, columns, strict=True):
            column.insert(0, heading)
    widths = [max(map(len, column)) for column in columns]
    for name, *cells in zip(names, *columns, strict=True):
        texts = (f"{cell:>{width}}" for cell, width in zip(cells, widths, strict=True))
        lines.append(f"  {name:18}  {'  '.join(texts)}".rstrip())
    return "\n".join([*lines, *(f"note: {note}" for note in _notes(found, harder))])


def _notes(found: Distribution, harder: Distribution | None) -> list[str]:
    """Remarks on the values, for the table and for JSON."""
    from ..chain.yield_pressure import assumed_for_all, note_on_soft_balls
    from ..designs.measures import measure_of, notes_on
    from ..designs.yield_range import LEGEND
    from ..representation import counted

    notes = []
    if found.failed:
        count = counted(found.failed, "chain")
        notes.append(f"{count} without a value, the first because {found.reason}")
    if few := found._few_values_note(PERCENTILES):
        notes.append(f"{few} (--chains)")
    notes += notes_on(found.chain, [measure_of(found.chain, found.quantity)])
    soft = note_on_soft_balls(found.chain, yielding=bool(found._yielding_note))
    pressure = assumed_for_all(found.chain) if harder is None else LEGEND
    materials = *found._stiff_walls, found._yielding_note, pressure, soft
    return notes + [on_command_line(note) for note in materials if note]

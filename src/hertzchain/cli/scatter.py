"""The command `scatter`: a quantity of many chains whose beads deviate at random."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from .chain_options import ChainOptions, chain_from, chain_options
from .exit_codes import DONE, FAILED
from .options import PICTURES, check_writable, measure_from, with_width
from .output import save_figure, show_json
from .progress import progress_bar

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..chain.chain import Chain
    from ..collision import Array
    from ..designs.measures import Measure

PERCENTILES: Final = (1, 5, 50, 95, 99)


@click.command()
@chain_options
@click.option("--relative", metavar="PART", help="Standard deviation of ln R, such as 0.01 or 1%.")
@click.option("--grade", type=int, help="Grade of the balls by ISO 3290-1 instead, 3 to 200.")
@click.option(
    "--only", "some", metavar="BEADS", help="Beads that deviate, such as 2:.  [default: all]"
)
@click.option("--chains", "count", type=int, default=300, show_default=True, help="Random chains.")
@click.option("--seed", type=int, default=1, show_default=True, help="Seed of the random radii.")
@click.option(
    "--quantity",
    metavar="NAME",
    help="Such as wall_force.peak, velocity@20 or arrival@last.  [default: wall_force.peak; "
    "without a wall, velocity@last]",
)
@click.option("--json", "as_json", is_flag=True, help="Print everything as JSON.")
@click.option(
    "--plot",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Plot the distribution to FILE (.png, .svg or .pdf).",
)
@with_width("plot")
def scatter(
    options: ChainOptions, relative: str | None, grade: int | None, some: str | None, count: int,
    seed: int, quantity: str | None, as_json: bool, plot: Path | None,
) -> int:  # fmt: skip
    """Show how a quantity varies if radii scatter.

    Many chains with random radii are simulated, and the distribution of the quantity is printed.
    All chains have the materials, walls and impact of the given one.  Bead 1 often is the
    projectile, whose deviation changes the impact itself: --only 2: omits it.

    \b
    Examples:
      hertzchain scatter --material steel-52100 --diameter "10 mm" --beads 20 \\
          --speed "0.1 m/s" --wall same --relative 1%
      hertzchain scatter chain.toml --grade 100 --quantity arrival@last --plot arrival.png
    """
    import numpy as np

    import hertzchain

    from ..validation.numbers import whole_number

    check_writable(plot, "--plot", PICTURES)
    if (relative is None) == (grade is None):
        raise click.UsageError("give --relative, such as 1%, or --grade, such as 100")
    part = None if relative is None else _part(relative)
    whole_number("--seed", seed, least=0)
    whole_number("--chains", count, least=2, most=10_000)
    chain = chain_from(options)
    measure = measure_from(quantity, chain)
    deviations = hertzchain.Scatter(radius=part, grade=grade, samples=count, beads=some)
    deviations._check(chain)
    chains = deviations._chains(chain, deviations._draws(seed, chain.beads))
    with progress_bar("chains simulated") as progress:
        table = hertzchain.simulate_many([chain, *chains], keep=measure.columns, progress=progress)
    nominal, *values = measure.from_table(table)
    found = np.array(values)
    good = found[np.isfinite(found)]
    if len(good) < 2 or not np.isfinite(nominal):
        raise hertzchain.SimulationError(f"fewer than two chains have a value of {measure}")
    summary = _summary(chain, measure, float(nominal), good)
    if plot is not None:
        save_figure(_drawn(chain, measure, float(nominal), good), plot)
    if as_json:
        from ..store import results

        document = {"schema_version": results.SCHEMA_VERSION} | summary
        show_json(document | {"failed": count - len(good), "values": good.tolist()})
    else:
        click.echo(_in_words(chain, summary, len(good), count))
    return DONE if len(good) == count else FAILED


def _part(text: str) -> float:
    try:
        return float(text.removesuffix("%")) * (0.01 if text.endswith("%") else 1.0)
    except ValueError:
        raise click.UsageError(f"--relative must look like 0.01 or 1%, got {text!r}") from None


def _summary(chain: Chain, measure: Measure, nominal: float, values: Array) -> dict[str, object]:
    import numpy as np

    percentiles = np.percentile(values, PERCENTILES).tolist()
    return {
        "quantity": str(measure),
        "unit": measure.unit if chain.units == "SI" else "1",
        "nominal": nominal,
        "mean": float(values.mean()),
        "standard_deviation": float(values.std(ddof=1)),
        "percentiles": dict(zip(map(str, PERCENTILES), percentiles, strict=True)),
    }


def _in_words(chain: Chain, summary: dict[str, object], good: int, count: int) -> str:
    """Lines with values, each also relative to the nominal chain."""
    from ..representation import measure

    nominal, unit = summary["nominal"], str(summary["unit"])
    assert isinstance(nominal, float)
    percentiles = summary["percentiles"]
    assert isinstance(percentiles, dict)
    rows = {"nominal": nominal, "mean": summary["mean"],
            "standard deviation": summary["standard_deviation"]}  # fmt: skip
    rows |= {f"{name}% are below": value for name, value in percentiles.items()}
    lines = [chain.description, f"{summary['quantity']} of {good} of {count} random chains"]
    for name, value in rows.items():
        assert isinstance(value, float)
        shown = measure(value, unit, "scaled" if unit == "1" else "SI", 5)
        part = "" if name == "nominal" else f"{100.0 * value / nominal:9.2f}%"
        lines.append(f"  {name:18}  {shown:>12}{part}")
    return "\n".join(lines)


def _drawn(chain: Chain, measure: Measure, nominal: float, values: Array) -> Axes:
    from ..plotting.style import COLOURS, figure_style, get_axes, set_title
    from ..plotting.titles import chain_title

    unit = f" [{measure.unit}]" if chain.units == "SI" and measure.unit != "1" else ""
    with figure_style():
        axes = get_axes(None)
        axes.hist(values, bins="auto", color=COLOURS[5])
        axes.axvline(nominal, color="black", label="nominal chain")
        axes.axvline(values.mean(), color=COLOURS[2], linestyle="--", label="mean")
        axes.set_xlabel(f"{measure.label}{unit}")
        axes.set_ylabel("number of chains")
        axes.legend()
        set_title(axes, chain_title(chain))
    return axes

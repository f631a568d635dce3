"""The command `sensitivity`: how much a quantity depends on each bead."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from .chain_options import ChainOptions, chain_from, chain_options
from .options import PICTURES, check_writable, measure_from, with_width
from .output import save_figure, show_json, show_table
from .pulse_tables import table_rows

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from rich.table import Table

    from ..sensitivity.gradient import Gradient

BY: Final = ("radii", "masses", "stiffness", "velocities", "young", "density")
NOUNS: Final = {"radii": "the radius", "masses": "the mass", "velocities": "the velocity",
                "young": "Young's modulus"}  # fmt: skip


@click.command()
@chain_options
@click.option(
    "--quantity",
    metavar="NAME",
    help="Such as wall_force.peak, velocity@20 or arrival@last.  [default: wall_force.peak; "
    "without a wall, velocity@last]",
)
@click.option(
    "--to",
    "by",
    type=click.Choice(BY),
    default="radii",
    show_default=True,
    help="Parameter of each bead or contact that changes.",
)
@click.option("--all", "every_bead", is_flag=True, help="Show every bead in the table.")
@click.option("--json", "as_json", is_flag=True, help="Print everything as JSON.")
@click.option(
    "--plot",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Plot the relative changes to FILE (.png, .svg or .pdf).",
)
@with_width("plot")
def sensitivity(
    options: ChainOptions, quantity: str | None, by: str, every_bead: bool, as_json: bool,
    plot: Path | None,
) -> None:  # fmt: skip
    """Show which beads a quantity depends on.

    The table states by how many percent the quantity changes if the radius (or another parameter)
    of one bead grows by 1%.  The derivatives are exact and follow from one run.

    \b
    Examples:
      hertzchain sensitivity --material steel-52100 --diameter "20 mm:8 mm" --beads 20 \\
          --speed "0.1 m/s" --wall same
      hertzchain sensitivity chain.toml --quantity arrival@last --to masses --plot arrival.png
    """
    import hertzchain

    from ..designs.exact_gradients import name_of
    from ..errors import InputError

    check_writable(plot, "--plot", PICTURES)
    chain = chain_from(options)
    measure = measure_from(quantity, chain)
    name = name_of(measure, chain.beads)
    if name is None:
        raise InputError(f"{measure} has no derivatives; use wall_force.peak or velocity@last")
    found = hertzchain.gradient(chain, name, to=by)
    if plot is not None:
        save_figure(_drawn(found, by, measure.label), plot)
    if as_json:
        from ..store import results

        document = {"schema_version": results.SCHEMA_VERSION, "quantity": name}
        document |= {"value": found.value, "unit": found.unit, "parameter": by}
        document |= {"gradient": found[by].tolist(), "gradient_unit": found.units[by]}
        show_json(document | {"relative": found.relative(by).tolist(), "error": found.error})
    else:
        click.echo(f"{chain.description}\n{found!r}")
        show_table(_table(found, by, every_bead))


def _table(found: Gradient, by: str, every_bead: bool) -> Table:
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    absolute, relative = found[by], found.relative(by)
    rows = table_rows(len(absolute), every_bead)
    few = f"{len(rows)} of {len(absolute)}; --all shows every one"
    table = Table(box=box.SIMPLE_HEAD, caption=None if len(rows) == len(absolute) else few)
    unit = f" [{found.units[by]}]" if found.units[by] else ""
    for column in (_place(by), "% per 1%", f"derivative{unit}"):
        table.add_column(escape(column), justify="right", no_wrap=True)
    for i in rows:
        table.add_row(f"{i + 1}", f"{relative[i]:+.4f}", f"{absolute[i]:.5g}")
    return table


def _place(by: str) -> str:
    return "contact k" if by == "stiffness" else "bead k"


def _drawn(found: Gradient, by: str, label: str) -> Axes:
    import numpy as np
    from matplotlib.ticker import MaxNLocator

    from ..plotting.style import COLOURS, figure_style, get_axes, set_title

    relative = found.relative(by)
    with figure_style():
        axes = get_axes(None)
        axes.bar(np.arange(1, len(relative) + 1), relative, color=COLOURS[1])
        axes.axhline(0.0, color="black", linewidth=0.8)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set_xlabel(f"{_place(by).removesuffix('k')}$k$")
        axes.set_ylabel("relative change [%]")
        set_title(axes, f"{label}: change per 1% of {NOUNS.get(by, by)}")
    return axes

"""The command `pulse`: the leading pulse, by one or several methods."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import click

from hertzchain.cli.options import PICTURES, chain_from, chain_options, check_writable
from hertzchain.cli.progress import progress_of
from hertzchain.cli.pulse_tables import side_by_side, table_of
from hertzchain.cli.show import save_axes, show_table

METHODS: Final = (
    "propagate", "simulate", "bca", "modified-bca", "modified-bca-printed", "two-thirds-bca",
    "hard-sphere", "local-rate",
)  # fmt: skip


@click.command()
@chain_options
@click.option(
    "--method",
    "methods",
    multiple=True,
    default=("propagate",),
    show_default=True,
    metavar="NAME",
    help=f"Repeatable: {', '.join(METHODS)}.",
)
@click.option(
    "--quantity",
    default="velocity",
    show_default=True,
    metavar="NAME",
    help="What to draw, and to show side by side when there are several methods: "
    "velocity, momentum, energy, peak_time, arrival, residence, peak_overlap, peak_force, "
    "velocity_error.",
)
@click.option("--log", is_flag=True, help="Draw with a logarithmic ordinate.")
@click.option("--all", "every_bead", is_flag=True, help="Show every bead in the table.")
@click.option("--json", "as_json", is_flag=True, help="Print everything as JSON.")
@click.option("--csv", "as_csv", is_flag=True, help="Print everything as CSV.")
@click.option(
    "--plot",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Also draw the quantity into FILE (.png, .svg or .pdf).",
)
def pulse(
    file: Path | None, chain_file: Path | None, taper: str | None, rate: float | None,
    beads: int | None, methods: tuple[str, ...], quantity: str, every_bead: bool, as_json: bool,
    as_csv: bool, plot: Path | None, log: bool,
) -> None:  # fmt: skip
    """Follow the leading pulse along a chain, by one or several methods.

    The chain comes from the options or from a FILE, TOML or CSV.  One in SI units is
    followed in the paper's scaled variables and shown in SI.

    \b
    Examples:
      hertzchain pulse --taper backward-exponential --rate 0.05 --beads 100
      hertzchain pulse --taper forward-linear --rate 0.009 --method propagate --method bca
      hertzchain pulse chain.toml --csv > pulse.csv
    """
    from hertzchain.arguments import one_of
    from hertzchain.errors import InputError
    from hertzchain.pulse.quantities import QUANTITIES
    from hertzchain.store import results
    from hertzchain.sweeps.methods import pulse_by

    if as_json and as_csv:
        raise click.UsageError("--json and --csv exclude each other")
    for method in methods:
        one_of("method", method, METHODS)
    one_of("quantity", quantity, QUANTITIES)
    check_writable(plot, "--plot", PICTURES)
    chain = chain_from(file, chain_file, taper, rate, beads)
    with progress_of("beads passed") as progress:
        pulses = [pulse_by(method, chain, progress) for method in dict.fromkeys(methods)]
    if plot is not None:
        from hertzchain.plotting.pulses import plot_pulses

        save_axes(plot_pulses(pulses, quantity, log=log), plot)  # type: ignore[arg-type]
    if as_json:
        click.echo(results.pulses_as_json(pulses))
    elif as_csv:
        click.echo(results.pulses_as_csv(pulses), nl=False)
    elif len(pulses) == 1:
        show_table(table_of(pulses[0], every_bead))
    else:
        for missing in (other for other in pulses if other.column(quantity) is None):  # type: ignore[arg-type]
            raise InputError(f"{missing.method} does not predict {quantity}")
        show_table(side_by_side(pulses, quantity, every_bead))  # type: ignore[arg-type]
        for other in pulses[1:]:
            click.echo(f"\n{other.compare(pulses[0])}")

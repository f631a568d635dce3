"""The command `pulse`: compute the leading pulse by one or several methods."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click
from click.core import ParameterSource

from ..pulse.quantities import COLUMN_QUANTITIES, ON_REQUEST
from .chain_options import ChainOptions, chain_options, chains_from
from .options import Fraction, LateHelp, StrictCommand, as_typed, figure_option, json_option
from .output import save_figure, show_json, show_table
from .progress import progress_bar
from .pulse_tables import pulse_table, side_by_side

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..chain.chain import Chain
    from ..pulse.pulse import Pulse
    from ..validation.objects import Progress


# Names that users give to quantities.
SYNONYMS: Final = {
    "force": "peak_force", "overlap": "peak_overlap", "time": "arrival", "duration": "residence",
}  # fmt: skip
DISORDER: Final = "disorder"
# Spreads are predicted by that method only.
PREDICTED: Final = tuple(name for name in COLUMN_QUANTITIES if not name.endswith("_spread"))
# The theory of the large beads of a chain with small ones between them.
EFFECTIVE: Final = "effective-chain"
# All methods of sweeps that support the chain.
ALL: Final = "all"


def _methods() -> tuple[str, ...]:
    from ..sweeps.methods import METHODS

    return (*METHODS, DISORDER, EFFECTIVE)


def _method_help() -> str:
    return (
        f"Method; repeatable: {', '.join(_methods())}; or all, for both simulations and the "
        "theories that support the chain, without disorder and effective-chain."
    )


@click.command(cls=StrictCommand)
@chain_options
@click.option(
    "--method",
    "methods",
    multiple=True,
    default=("propagate",),
    show_default=True,
    metavar="NAME",
    cls=LateHelp,
    late_help=_method_help,
)
@click.option(
    "--quantity",
    default="velocity",
    show_default=True,
    metavar="NAME",
    help="Quantity to plot and, if it is given or there are several methods, to show alone, chains "
    "or methods side by side: "
    f"{', '.join(PREDICTED)}; with --method disorder also "
    f"{', '.join(name for name in COLUMN_QUANTITIES if name not in PREDICTED)}.  The velocity is "
    "that of the beads, the speed that of the pulse from bead to bead.",
)
@click.option(
    "--rtol",
    type=Fraction(),
    help="Relative tolerance per step of propagate (1e-10 to 1e-5) and simulate (1e-14 to 1e-6).  "
    "[default: 1e-8; with --method simulate, 1e-13]",
)
@click.option(
    "--scatter",
    metavar="NUMBER",
    help="Scatter of the radii for --method disorder, the theory of the mean and spread of random "
    "chains: relative standard deviation of the diameters (of ln R), such as 1%, at most 3%.  All "
    "beads deviate, bead 1 too; `hertzchain scatter --only 2:` keeps the mass of the projectile.",
)
@click.option(
    "--modulus-scatter",
    metavar="NUMBER",
    help="The same for the Young's moduli, at most 10%.",
)
@click.option(
    "--log/--linear",
    default=None,
    help="Scale of the y axis.  [default: logarithmic if velocities, momenta, energies, forces or "
    "overlaps differ by a factor of 50 or more]",
)
@click.option("--all", "every_bead", is_flag=True, help="Show every bead in the table.")
@json_option()
@click.option("--csv", "as_csv", is_flag=True, help="Print everything as CSV.")
@figure_option(
    "Also plot the quantity to FILE; with several methods, below it their differences from the "
    "reference, and for --method disorder alone, its spread."
)
def pulse(
    options: ChainOptions, methods: tuple[str, ...], quantity: str, rtol: float | None,
    scatter: str | None, modulus_scatter: str | None, every_bead: bool, as_json: bool,
    as_csv: bool, plot: Path | None, log: bool | None,
) -> None:  # fmt: skip
    """Compute the leading pulse by one or several methods.

    The chain is given by options or by FILE (TOML or CSV); --plot compares several files.  For a
    chain in SI units, the pulse is computed in the paper's scaled variables and printed in SI
    units.  Several methods are compared with the simulation or, if there is none, with the first
    method.  Of the effective chain of large beads with small ones between them, only the times are
    predictions.

    \b
    Examples:
      hertzchain pulse --taper backward-exponential --rate 0.05 --beads 100
      hertzchain pulse --taper forward-linear --rate 0.009 --method propagate --method bca
      hertzchain pulse --material steel-52100 --diameter "20 mm:5 mm" --beads 40
      hertzchain pulse chain.toml --csv > pulse.csv
      hertzchain pulse equal.toml tapered.toml --quantity momentum --plot momentum.png
      hertzchain pulse chain.toml --method disorder --scatter 1%
    """
    from ..store import results
    from ..sweeps.methods import SIMULATIONS
    from ..validation.objects import check_choice

    if as_json and as_csv:
        raise click.UsageError("--json and --csv cannot be combined")
    for method in methods:
        check_choice("method", method, (*_methods(), ALL))
    chosen = _chosen(methods)
    if not (as_json or as_csv):
        # The first pulse is the reference of comparisons.
        chosen.sort(key=lambda each: each not in SIMULATIONS)
    quantity = SYNONYMS.get(quantity, quantity)
    check_choice("quantity", quantity, COLUMN_QUANTITIES)
    if quantity not in PREDICTED and DISORDER not in methods:
        raise click.UsageError(f"--quantity {quantity} requires --method disorder")
    chains = chains_from(options)
    part = None if scatter is None else _part(scatter, next(iter(chains.values())))
    of_moduli = None if modulus_scatter is None else as_typed(modulus_scatter)
    settings = _settings(chosen, rtol, part, of_moduli)
    if len(chains) > 1 and (as_json or as_csv):
        raise click.UsageError(
            "--json and --csv print one chain: give one chain FILE, and run the command for each"
        )
    # `simulate` supports every chain.
    optional = {*chosen} - {*methods, "simulate"}
    source = click.get_current_context().get_parameter_source("quantity")
    alone = source is ParameterSource.COMMANDLINE
    found = {}
    with progress_bar("beads passed") as progress:
        for name, chain in chains.items():
            found[name] = _all_computed(chain, progress, settings, optional)
    if plot is not None or not (as_json or as_csv):
        having = {name: _with_quantity(each, quantity) for name, each in found.items()}
        # A note that methods are omitted is about this quantity.
        alone, found = alone or having != found, having
    pulses = [pulse for each in found.values() for pulse in each]
    _name_without_spread(pulses, quantity)
    if plot is not None:
        save_figure(_plotted(found, quantity, log), plot)
    more = [quantity] if quantity in ON_REQUEST else []
    if as_json:
        import json

        show_json(json.loads(results.pulses_as_json(pulses, more)))
    elif as_csv:
        click.echo(results.pulses_as_csv(pulses, more), nl=False)
    else:
        _show_found(found, quantity, alone=alone, every_bead=every_bead)


def _plotted(found: Mapping[str, Sequence[Pulse]], quantity: str, log: bool | None) -> Axes:
    """Plot a quantity of the pulses of one or several chains."""
    from ..plotting.decades import extends_over_decades
    from ..plotting.pulses import plot_pulses
    from ..plotting.spreads import spread_of
    from ..plotting.style import literal

    pulses = [pulse for each in found.values() for pulse in each]
    labels = None
    # Without labels, the legend has entries for chains and for methods, not for all pairs.
    if 1 < len(found) == len(pulses):
        labels = [literal(name) for name in found]
    spread = any(spread_of(each, quantity) is not None for each in pulses)
    residuals = len(found) == 1 and (len(pulses) > 1 or spread)
    if log is None:
        log = extends_over_decades(pulses, quantity)
    return plot_pulses(pulses, quantity, labels=labels, log=log, residuals=residuals)


def _chosen(methods: tuple[str, ...]) -> list[str]:
    """The given methods, of which ``all`` stands for several, each once."""
    from ..sweeps.methods import METHODS

    return list(dict.fromkeys(
        each for given in methods for each in (METHODS if given == ALL else (given,))
    ))  # fmt: skip


def _part(text: str, chain: Chain) -> float | str:
    """A relative scatter as typed; `disorder` checks it."""
    from ..chain.random_radii import reject_length

    reject_length("--scatter", text, chain)
    return as_typed(text)


def _settings(
    methods: list[str], rtol: float | None, scatter: float | str | None,
    modulus_scatter: float | str | None,
) -> dict[str, dict[str, Any]]:  # fmt: skip
    """Options of each method."""
    from ..sweeps.methods import SIMULATIONS

    of_simulations = {} if rtol is None else {"rtol": rtol}
    if of_simulations and not {*methods} & {*SIMULATIONS}:
        raise click.UsageError("--rtol requires --method propagate or --method simulate")
    given = {"scatter": scatter, "modulus_scatter": modulus_scatter}
    of_disorder = {name: value for name, value in given.items() if value is not None}
    if DISORDER in methods and not of_disorder:
        raise click.UsageError(
            "--method disorder requires --scatter, such as 1%, or --modulus-scatter"
        )
    if of_disorder and DISORDER not in methods:
        raise click.UsageError(
            "--scatter and --modulus-scatter require --method disorder; hertzchain scatter "
            "simulates random chains"
        )
    of: dict[str, dict[str, Any]] = {
        **dict.fromkeys(SIMULATIONS, of_simulations),
        DISORDER: of_disorder,
    }
    return {method: of.get(method, {}) for method in methods}


def _all_computed(
    chain: Chain, progress: Progress | None, settings: dict[str, dict[str, Any]],
    optional: set[str],
) -> list[Pulse]:  # fmt: skip
    """Pulses by all methods but the optional ones that do not support the chain."""
    found = {
        each: _computed(each, chain, progress, own, optional=each in optional)
        for each, own in settings.items()
    }
    _name_omitted([method for method, each in found.items() if each is None])
    return [each for each in found.values() if each is not None]


def _computed(
    method: str, chain: Chain, progress: Progress | None, settings: dict[str, Any], *,
    optional: bool = False,
) -> Pulse | None:  # fmt: skip
    """The pulse by a method; `None` if an optional one does not support the chain."""
    from ..errors import InputError
    from ..sweeps.methods import pulse_by
    from ..theory.disorder import disorder
    from ..theory.effective_chain import effective_chain

    try:
        if method == DISORDER:
            return disorder(chain, **settings)
        if method == EFFECTIVE:
            return effective_chain(chain).bca().pulse()
        return pulse_by(method, chain, progress, **settings)
    except InputError:
        if not optional:
            raise
        return None


def _name_omitted(methods: list[str]) -> None:
    """Name methods that ``all`` stands for but that do not support the chain."""
    if methods:
        click.echo(f"note: omitted, because they do not support this chain: {', '.join(methods)}; "
                   f"--method {methods[0]} states why", err=True)  # fmt: skip


def _with_quantity(pulses: list[Pulse], quantity: str) -> list[Pulse]:
    """Those of the pulses that have a quantity; an error if there is none."""
    lacking = [pulse for pulse in pulses if pulse.column(quantity) is None]
    if len(lacking) == len(pulses):
        pulses[0]._predicted(quantity)
    for pulse in lacking:
        click.echo(f"note: {pulse.method} is omitted, as it does not predict the {quantity}",
                   err=True)  # fmt: skip
    return [pulse for pulse in pulses if pulse.column(quantity) is not None]


def _name_without_spread(pulses: list[Pulse], quantity: str) -> None:
    """Note that a pulse has spreads, but none of this quantity, so that figures show no band."""
    from ..plotting.spreads import spread_of

    own = quantity.endswith(("_spread", "_error"))
    predicted = [spread_of(each, quantity) for each in pulses if each.velocity_spread is not None]
    if not own and any(spread is None for spread in predicted):
        click.echo(f"note: the disorder law predicts no spread of the {quantity}, only those of "
                   "velocity, arrival and peak_force; hertzchain scatter simulates others",
                   err=True)  # fmt: skip


def _show_found(
    found: Mapping[str, list[Pulse]], quantity: str, *, alone: bool, every_bead: bool
) -> None:
    """Print one table of a quantity that was given of several chains, or tables of each chain."""
    pulses = [pulse for each in found.values() for pulse in each]
    kinds = {(pulse.method, pulse.chain.units) for pulse in pulses}
    if alone and 1 < len(found) == len(pulses) and len(kinds) == 1:
        show_table(side_by_side(pulses, quantity, every_bead, names=list(found)))
        return
    for each in found.values():
        _show_pulses(each, quantity, alone=alone, every_bead=every_bead)


def _show_pulses(pulses: list[Pulse], quantity: str, *, alone: bool, every_bead: bool) -> None:
    """Print a table of one chain: all quantities of one pulse, or one quantity."""
    if len(pulses) == 1 and not alone:
        show_table(pulse_table(pulses[0], every_bead))
        return
    show_table(side_by_side(pulses, quantity, every_bead))
    for other in pulses[1:]:
        comparison = other.compare(pulses[0])
        more = [quantity] if quantity in ON_REQUEST else []
        click.echo(f"\n{comparison._text([*comparison.quantities, *more])}")

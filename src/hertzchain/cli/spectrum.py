"""The command `spectrum`: frequencies, bands and gaps of a precompressed chain."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from .chain_options import ChainOptions, chain_at_rest_options, chain_from
from .options import StrictCommand, figure_option, json_option
from .output import save_figure, show_json

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..chain.chain import Chain
    from ..theory.spectrum import Spectrum

# Localised modes that are listed.
MAX_LISTED: Final = 5


@click.command(cls=StrictCommand)
@chain_at_rest_options
@click.option("--all", "every_mode", is_flag=True, help="List the frequencies of all modes.")
@click.option(
    "--transfer", "contact", type=int, metavar="CONTACT",
    help="With --plot or --csv, plot or print the force in this contact per harmonic force on "
    "bead 1, instead of the bands; contact k is between beads k and k + 1.",
)  # fmt: skip
@click.option(
    "--modes", metavar="1,2,...",
    help="With --plot, plot the displacements of the beads in these modes, numbered from 1, "
    "instead of the bands.",
)  # fmt: skip
@json_option("Print modes, bands and gaps as JSON.")
@click.option(
    "--csv",
    "as_csv",
    is_flag=True,
    help="With --transfer, print it as CSV, for example with '> transfer.csv'.",
)
@figure_option("Plot the bands, or the frequencies of the modes, to FILE.")
def spectrum(
    options: ChainOptions, every_mode: bool, contact: int | None, modes: str | None,
    as_json: bool, as_csv: bool, plot: Path | None,
) -> None:  # fmt: skip
    """Show frequencies, bands and gaps of a precompressed chain.

    A chain whose contacts carry a static force transmits sound.  If its beads repeat a cell, the
    frequency bands of an infinite chain with this cell, the gaps between them and the speed of
    long waves are printed; in the gaps no waves propagate.

    \b
    Examples:
      hertzchain spectrum --material steel-316 --diameter "19 mm" --beads 20 \\
          --precompression "20 N"
      hertzchain spectrum crystal.toml --plot bands.png
      hertzchain spectrum crystal.toml --transfer 16 --plot transfer.png
      hertzchain spectrum crystal.toml --modes 1,2,3 --plot modes.png
    """
    import hertzchain

    if as_csv and len(options.files) > 1:
        raise click.UsageError(
            "--csv takes no file name, because the table is printed; write, for example, "
            "--csv > transfer.csv, and give one chain FILE"
        )
    if contact is None and as_csv:
        raise click.UsageError("--csv prints a transfer function: add --transfer CONTACT")
    if contact is not None and not (plot or as_csv):
        raise click.UsageError("--transfer requires --plot FILE or --csv")
    if modes is not None and (plot is None or contact is not None):
        raise click.UsageError(
            "--modes requires --plot FILE"
            if plot is None
            else "--modes and --transfer are two figures; give one of them"
        )
    if as_json and as_csv:
        raise click.UsageError("--json and --csv cannot be combined")
    found = hertzchain.spectrum(_under_load(chain_from(options)))
    table = "" if contact is None else _transfer(found, contact)
    numbers = None if modes is None else _numbers(modes)
    if plot is not None:
        save_figure(_figure(found, contact, numbers), plot)
    if as_csv:
        click.echo(table)
    elif as_json:
        show_json(_document(found))
    else:
        click.echo(_table(found, every_mode=every_mode, hint=modes is None))


def _numbers(text: str) -> list[int]:
    """Numbers of modes, separated by commas."""
    try:
        return [int(part) for part in text.split(",")]
    except ValueError:
        raise click.UsageError(f"--modes must look like 1,2, got {text!r}") from None


def _figure(found: Spectrum, contact: int | None, modes: list[int] | None) -> Axes:
    """A transfer function, shapes of modes, or the bands."""
    if contact is not None:
        return found.plot_transfer(contact)
    return found.plot() if modes is None else found.plot_modes(modes)


def _under_load(chain: Chain) -> Chain:
    """The chain, if its contacts carry a static force."""
    if chain.precompression == 0.0 and chain.gravity == 0.0:
        raise click.UsageError(
            "the contacts of this chain carry no static force: give --precompression, such as "
            "'20 N', or precompression in the chain file"
        )
    return chain


def _transfer(found: Spectrum, contact: int) -> str:
    """The force in a contact per force on bead 1 as CSV."""
    import numpy as np

    frequencies = found._usual_frequencies
    values = found.transfer_force(frequencies, contact)
    unit = " [Hz]" if found.chain.units == "SI" else ""
    lines = [f"frequency{unit},amplitude,phase [rad]"]
    rows = zip(frequencies, np.abs(values), np.angle(values), strict=True)
    lines += [",".join(f"{value:.10g}" for value in row) for row in rows]
    return "\n".join(lines)


def _bands(found: Spectrum) -> tuple[Any, Any, float | None]:
    """Edges of the bands, gaps and sound speed, if the chain repeats a cell."""
    from ..errors import InputError

    with suppress(InputError):
        return found.band_edges().tolist(), found.gaps().tolist(), found.sound_speed
    return None, None, None


def _host(found: Spectrum) -> Any:
    """Edges of the bands of the host, if most beads repeat a cell."""
    from ..errors import InputError

    with suppress(InputError):
        return found.host_edges.tolist()
    return None


def _host_lines(found: Spectrum, shown: Callable[[float, float], str]) -> list[str]:
    """Bands of the host of a chain that repeats no cell."""
    host = _host(found)
    if host is None:
        return ["  no bands: masses or springs do not repeat"]
    return [f"  host band {i}  {shown(*band)}" for i, band in enumerate(host, 1)]


def _localised_lines(found: Spectrum, factor: float, unit: str, *, hint: bool) -> list[str]:
    """Localised modes with the bead that has most of their energy, and the option for a figure."""
    chosen = found.localised
    lines = [
        f"  localised    {factor * found.frequencies[j - 1]:.5g}{unit}, mode {j}, around bead "
        f"{found._bead_of_mode(j)}, participation "
        f"{found.participation[j - 1]:.3g}"
        for j in chosen[:MAX_LISTED]
    ]
    if (more := len(chosen) - len(lines)) > 0:
        lines.append(f"  localised    {more} more modes")
    if hint and lines:
        numbers = ",".join(str(j) for j in chosen[:MAX_LISTED])
        lines.append(f"  shapes       --modes {numbers} --plot FILE")
    return lines


def _document(found: Spectrum) -> dict[str, Any]:
    from ..validation.json_types import finite

    bands, gaps, speed = _bands(found)
    document: dict[str, Any] = finite({
        "units": found.chain.units,
        "frequencies": found.frequencies.tolist(),
        "decay_rates": found.decay_rates.tolist(),
        "bands": bands,
        "gaps": gaps,
        "sound_speed": speed,
        "host_bands": _host(found),
        "localised_modes": [
            {"mode": int(j), "bead": found._bead_of_mode(j),
             "frequency": float(found.frequencies[j - 1]),
             "participation": float(found.participation[j - 1])}
            for j in found.localised
        ],
    })  # fmt: skip
    return document


def _table(found: Spectrum, *, every_mode: bool, hint: bool) -> str:
    from ..representation import in_column, measure

    bands, gaps, speed = _bands(found)
    units, factor, unit = found.chain.units, 1.0, ""
    if units == "SI":
        factor, unit = 1e-3, " kHz"

    def shown(low: float, high: float) -> str:
        if math.isinf(high):
            return f"above {factor * low:.5g}{unit}"
        return f"{factor * low:.5g} to {factor * high:.5g}{unit}"

    f = found.frequencies
    lines = [found.chain.description, f"  {len(f)} modes     {shown(f[0], f[-1])}"]
    if bands is None:
        lines += _host_lines(found, shown)
    else:
        lines += [f"  band {i}       {shown(*band)}" for i, band in enumerate(bands, 1)]
        lines += [f"  no waves     {shown(*gap)}" for gap in gaps]
        lines.append(f"  sound speed  {measure(speed or 0.0, 'm/s', units)}")
    lines += _localised_lines(found, factor, unit, hint=hint)
    if every_mode:
        heading = "frequency [kHz]" if unit else "frequency"
        lines.append(f"{'mode':>6}{heading:>18}")
        shown_modes = in_column([factor * each for each in f], 6)
        lines += [f"{j:>6}{each:>18}" for j, each in enumerate(shown_modes, 1)]
    return "\n".join(lines)

"""Options that commands share, and checks of what was given."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

if TYPE_CHECKING:
    from hertzchain.chain.chain import Chain

# Endings of pictures.
PICTURES: Final = (".png", ".svg", ".pdf")


def chain_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options that describe a chain, shared by the commands that need one."""
    for option in (
        click.argument("file", required=False, type=click.Path(path_type=Path)),
        click.option(
            "--chain",
            "chain_file",
            type=click.Path(path_type=Path),
            metavar="FILE",
            help="The same as FILE: TOML, or CSV with a row a bead.",
        ),
        click.option(
            "--taper",
            help="uniform, or backward-/forward- with linear/exponential.  [default: uniform]",
        ),
        click.option("--rate", type=float, help="Tapering parameter: S (linear), q (exponential)."),
        click.option("--beads", type=int, help="Number of beads N.  [default: 100]"),
    )[::-1]:
        command = option(command)
    return command


def chain_from(
    file: Path | None,
    chain_file: Path | None,
    taper: str | None,
    rate: float | None,
    beads: int | None,
) -> Chain:
    """The chain that the `chain_options` describe."""
    from hertzchain.arguments import one_of
    from hertzchain.chain.chain import TAPERS, Chain
    from hertzchain.store.chain_files import load_chain

    if file is not None and chain_file is not None:
        raise click.UsageError("give the chain as FILE or as --chain FILE, not both")
    file = chain_file if file is None else file
    if file is not None:
        if not (taper is None and rate is None and beads is None):
            raise click.UsageError("give a chain FILE or --taper, --rate and --beads, not both")
        return load_chain(file)
    count = 100 if beads is None else beads
    if taper is None and rate is not None:
        raise click.UsageError(f"--rate needs --taper: {', '.join(TAPERS)}")
    if taper is None or taper == "uniform":
        if rate is not None:
            raise click.UsageError("a uniform chain has no --rate")
        return Chain.uniform(count)
    one_of("taper", taper, (*TAPERS, "uniform"))
    if rate is None:
        usual = "its S, such as 0.005" if taper.endswith("linear") else "its q, such as 0.05"
        raise click.UsageError(f"--taper {taper} needs --rate, {usual}")
    return Chain.tapered(taper, rate, beads=count)


def time_from(option: str, text: str | None, chain: Chain) -> float | None:
    """A time of an option: a number or, for a chain in SI units, one with a unit, such as 2ms."""
    from hertzchain.checks import SCALED, number

    if text is None:
        return None
    try:
        given: float | str = float(text)
    except ValueError:
        given = text
    return number(option, given, unit="s" if chain.units == "SI" else SCALED)


def window_from(option: str, text: str) -> tuple[int, int]:
    """First and last bead of ``FIRST:LAST``."""
    try:
        first, last = (int(part) for part in text.split(":"))
    except ValueError:
        raise click.UsageError(f"{option} must look like 5:60, got {text!r}") from None
    return first, last


def numbers_from(option: str, text: str) -> tuple[float, ...]:
    """Numbers separated by commas."""
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise click.UsageError(f"{option} must look like 0.01,0.02, got {text!r}") from None


def names_from(text: str | None) -> list[str] | None:
    """Names separated by commas, of an option that may be left out."""
    return None if text is None else [part.strip() for part in text.split(",") if part.strip()]


def check_writable(path: Path | None, option: str, endings: tuple[str, ...]) -> None:
    """Refuse a file that could not be written, before any work is done for it."""
    if path is None:
        return
    if path.suffix not in endings:
        raise click.UsageError(f"{option} {path} must end in {' or '.join(endings)}")
    if not path.parent.is_dir():
        raise click.UsageError(f"{option} {path}: there is no folder {path.parent}")

"""Options for the parameters of a fit, and their values."""

from __future__ import annotations

import click

from .options import as_typed

free_option = click.option(
    "--free",
    multiple=True,
    metavar="NAME",
    help="Free parameter, such as loss.time or 'gain[*]'; repeatable.  [default: those of the "
    "table [fit] of the chain file; without it, the stiffness, the velocity of the striker, the "
    "parameter of the loss, the time offset and the gains of sensors in V]",
)
also_free_option = click.option(
    "--also-free",
    multiple=True,
    metavar="NAME",
    help="Parameter that is free in addition to those of --free or the chain file; repeatable.",
)
prior_option = click.option(
    "--prior",
    "priors",
    multiple=True,
    metavar="NAME=VALUE,ERROR",
    help="Value and standard deviation of a parameter from other measurements, such as "
    "struck_by.velocity=0.3,0.003; repeatable.",
)


def priors_from(texts: tuple[str, ...]) -> dict[str, tuple[float | str, float | str]]:
    """Value and standard deviation of parameters by name."""
    return dict(_prior(text) for text in texts)


def _prior(text: str) -> tuple[str, tuple[float | str, float | str]]:
    name, _, rest = text.rpartition("=")
    try:
        value, error = (as_typed(part) for part in rest.split(","))
    except ValueError:
        raise click.UsageError(
            f"--prior must look like struck_by.velocity=0.3,0.003, got {text!r}"
        ) from None
    return name, (value, error)

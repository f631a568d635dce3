"""Options for the parameters of a fit, and their values."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from .options import as_typed, seconds_from

if TYPE_CHECKING:
    from ..traces.traces import Traces

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
start_option = click.option(
    "--start",
    "starting_values",
    multiple=True,
    metavar="NAME=VALUE",
    help="Value from which a parameter starts, such as time_offset=80us; that of a time_offset "
    "which is not free is its value.  Repeatable.",
)
time_offset_option = click.option(
    "--time-offset",
    multiple=True,
    metavar="TIME",
    help="Known time of the data at which the simulation begins, such as -50us.  It is not "
    "fitted.  Repeat the option for the times of several shots.  [default: that of the table [fit] "
    "of the chain file, or the start of a drive in the file of the traces; otherwise free]",
)
begin_option = click.option(
    "--from",
    "begin",
    metavar="TIME",
    help="First time of the data to use, such as 50us, as read from the file.  [default: that of "
    "the record]",
)
until_option = click.option(
    "--until",
    metavar="TIME",
    help="Last time of the data to use, such as 550us, as read from the file.  [default: that of "
    "the record]",
)


def part_of(traces: Traces, begin: str | None, until: str | None) -> Traces:
    """Traces of the times of the data that the options select."""
    first, last = (
        None if text is None else seconds_from(option, text)
        for option, text in (("--from", begin), ("--until", until))
    )
    return traces if first is None and last is None else traces.between(first, last)


def start_from(texts: tuple[str, ...]) -> dict[str, float | str]:
    """Values from which parameters start, by name."""
    return dict(_start(text) for text in texts)


def _start(text: str) -> tuple[str, float | str]:
    name, equals, value = text.rpartition("=")
    if not (name and equals and value.strip()):
        raise click.UsageError(f"--start must look like time_offset=80us, got {text!r}")
    return name, as_typed(value)


def time_offset_from(texts: tuple[str, ...]) -> float | list[float] | None:
    """Time offsets of all shots, or of each, in seconds."""
    times = [seconds_from("--time-offset", text) for text in texts]
    return times if len(times) > 1 else next(iter(times), None)


def priors_from(texts: tuple[str, ...]) -> dict[str, tuple[float | str, float | str]]:
    """Value and standard deviation of parameters by name."""
    return dict(_prior(text) for text in texts)


def _prior(text: str) -> tuple[str, tuple[float | str, float | str]]:
    name, _, rest = text.rpartition("=")
    try:
        value, error = (as_typed(part) for part in rest.split(","))
    except ValueError:
        raise click.UsageError(
            "--prior must look like struck_by.velocity=0.3,0.003, with the value and its standard "
            f"deviation, got {text!r}"
        ) from None
    return name, (value, error)

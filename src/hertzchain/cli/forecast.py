"""The command `forecast`: errors of a fit to the signals of a planned experiment."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from .fit_options import also_free_option, free_option, prior_option, priors_from
from .options import StrictCommand, json_option, noise_from, seconds_from
from .output import show_json
from .wording import on_command_line


@click.command(cls=StrictCommand)
@click.argument("chain", type=click.Path(path_type=Path))
@click.option(
    "--sensor",
    "sensors",
    multiple=True,
    required=True,
    metavar="PLACE",
    help="Place of a sensor, such as 'ball 7', wall, 'load cell' or 'ball 3 velocity'.  A sensor "
    "without calibration, such as 'ball 7 [V]', needs a prior of its gain.  A noise in V or mV, or "
    "a free gain with a unit such as 20 mV/N, has the same effect; such a gain also converts a "
    "noise in N of a sensor without [V].  Repeatable.",
)
@click.option(
    "--noise",
    "noises",
    multiple=True,
    required=True,
    metavar="[SENSOR=]SIZE",
    help="Standard deviation of a sample of all sensors or of one, such as '3 mV' or "
    "'wall=0.05 N'; repeatable, and with a name, an exception.",
)
@click.option("--interval", required=True, metavar="TIME", help="Sampling interval, such as 1us.")
@free_option
@also_free_option
@prior_option
@click.option(
    "--until",
    metavar="TIME",
    help="Time from the impact to the last sample, such as 700us.  [default: 1.5 times the time in "
    "which the pulse passes the chain]",
)
@json_option()
def forecast(
    chain: Path, sensors: tuple[str, ...], noises: tuple[str, ...], interval: str,
    free: tuple[str, ...], also_free: tuple[str, ...], priors: tuple[str, ...], until: str | None,
    as_json: bool,
) -> None:  # fmt: skip
    """Forecast the errors of a fit before you measure.

    CHAIN is a chain file with assumed values; its table [fit] names free parameters and priors.
    The errors are those of independent noise.  They are the smallest that any fit to such signals
    can have.  A line gives the duration of the pulse in each sensor, its number of samples, and the
    interval with which there are ten.

    \b
    Examples:
      hertzchain forecast experiment.toml --sensor "ball 7" --sensor wall \\
              --noise "0.05 N" --interval 1us
      hertzchain forecast experiment.toml --sensor "ball 7" --noise 0.05 --interval 5us \\
              --free stiffness --free time_offset
    """
    import hertzchain

    noise: Any = noise_from(noises)
    step = seconds_from("--interval", interval)
    end = None if until is None else seconds_from("--until", until)
    plan = hertzchain.forecast(
        chain, [*sensors], noise=noise, interval=step, free=list(free) or None,
        also_free=list(also_free) or None, priors=priors_from(priors), until=end,
    )  # fmt: skip
    if as_json:
        show_json(plan.as_dict())
    else:
        click.echo(on_command_line(plan.summary(width=None)))

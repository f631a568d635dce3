"""The command line: each command parses its options, calls the library and prints the result.

Results go to stdout, messages and progress to stderr.  Exit codes: 0 success, 1 failure,
2 bad usage or input, 3 finished but outside tolerance, 130 interrupted.
"""

from __future__ import annotations

import sys
import warnings
from typing import Final

import click

# Modules of this package import only click at the top, so that `--help` is fast; commands import
# the rest of the library when they run.
from . import (
    app,
    calibrate,
    cite,
    compare,
    design,
    fit,
    forecast,
    pulse,
    reproduce,
    scatter,
    scoreboard,
    sensitivity,
    sheet,
    simulate,
    spectrum,
    sweep,
    verify,
    warm_up,
)  # fmt: skip
from .environment import prepare_environment
from .exit_codes import BAD_INPUT, DONE, FAILED, INTERRUPTED
from .shown_warnings import forget_warnings, show_warning
from .wording import on_command_line

GROUPS: Final = {
    "See": (app.app,),
    "Simulate and predict": (simulate.simulate, pulse.pulse, spectrum.spectrum),
    "Design": (design.design, sensitivity.sensitivity, scatter.scatter),
    "Measured traces": (forecast.forecast, compare.compare, fit.fit),
    "Teaching": (sheet.sheet,),
    "Sweeps": (sweep.sweep,),
    "The paper and other known results": (
        reproduce.reproduce, scoreboard.scoreboard, calibrate.calibrate, verify.verify, cite.cite,
    ),
    "Installation": (warm_up.warm_up,),
}  # fmt: skip

# Meanings of unknown commands.
OTHER_COMMANDS: Final = {
    **dict.fromkeys(("hammer", "striker", "impact"), "simulate with --striker"),
    **dict.fromkeys(("run", "wall", "force"), "'simulate'"),
}  # fmt: skip


class Overview(click.Group):
    """A group whose help lists its commands by what they are for."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find a command; the message about an unknown one lists those that exist."""
        from ..errors import unknown_name_error

        if args and args[0] not in self.commands and not args[0].startswith("-"):
            meant = OTHER_COMMANDS.get(args[0].lower(), "")
            raise unknown_name_error("command", args[0], list(self.commands), meant=meant)
        return super().resolve_command(ctx, args)

    def format_commands(self, _: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands under the headings of `GROUPS`."""
        width = max(len(name) for name in self.commands)
        for heading, commands in GROUPS.items():
            with formatter.section(heading):
                limit = formatter.width - 6 - width
                rows = [
                    (f"{each.name:{width}}", each.get_short_help_str(limit)) for each in commands
                ]
                formatter.write_dl(rows)


@click.group(
    cls=Overview,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(package_name="hertzchain")
def cli() -> None:
    """Impacts on granular chains: simulate, predict, compare.

    \b
    Examples, to begin with:
      hertzchain app
          build a chain in the browser and watch the impact
      hertzchain simulate --material steel-52100 --diameter "20 mm:8 mm" \\
              --beads 20 --speed "0.1 m/s" --wall same
          the force of an impact on a wall
      hertzchain pulse --taper backward-exponential --rate 0.05 --beads 100
          the leading pulse, bead by bead
      hertzchain COMMAND --help
          options and examples of a command
    """


for _command in (each for commands in GROUPS.values() for each in commands):
    cli.add_command(_command)


def main() -> None:
    """Run the command line and exit with its code."""
    from ..errors import InputError, SimulationError, StoreError

    if sys.stdout is None:
        click.echo("Error: cannot write the results: standard output is closed", err=True)
        sys.exit(FAILED)
    try:
        with warnings.catch_warnings():
            forget_warnings()
            warnings.showwarning = show_warning
            prepare_environment()
            code = cli.main(standalone_mode=False)
    except click.ClickException as error:
        # Errors of values need no lines about the usage, like those of the library.
        if type(error) in (click.UsageError, click.BadParameter):
            click.echo(f"Error: {error.format_message()}", err=True)
        else:
            error.show()
        code = error.exit_code
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted", err=True)
        code = INTERRUPTED
    except InputError as error:
        click.echo(f"Error: {on_command_line(str(error))}", err=True)
        code = BAD_INPUT
    except (SimulationError, StoreError) as error:
        click.echo(f"Error: {on_command_line(str(error))}", err=True)
        code = FAILED
    except OSError as error:
        # For example, a closed pipe or a full disk.
        if not isinstance(error, BrokenPipeError):
            click.echo(f"Error: cannot write the results: {error.strerror}", err=True)
        sys.stdout = None
        code = FAILED
    sys.exit(code or DONE)

"""The command line: parse, call one library function, show.

Results go to stdout, messages and progress to stderr.  Exit codes: 0 done, 1 failed,
2 bad usage or input, 3 finished but outside tolerance, 130 interrupted.
"""

from __future__ import annotations

import sys
import warnings

import click

# Nothing heavier in any file here: `--help` must answer at once, so commands import what they need.
from hertzchain.cli import calibrate, cite, pulse, reproduce, scoreboard, simulate, sweep, verify
from hertzchain.cli.environment import prepare_environment
from hertzchain.cli.exit_codes import BAD_INPUT, DONE, FAILED, INTERRUPTED


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(package_name="hertzchain")
def cli() -> None:
    """Impacts on granular chains: simulate, predict, compare.

    \b
    Example:
      hertzchain pulse --taper backward-exponential --rate 0.05 --beads 100
    """


for _command in (
    pulse.pulse, simulate.simulate, reproduce.reproduce, calibrate.calibrate,
    scoreboard.scoreboard, sweep.sweep, verify.verify, cite.cite,
):  # fmt: skip
    cli.add_command(_command)


def main() -> None:
    """Run the command line and leave with its exit code."""
    from hertzchain.errors import InputError, SimulationError, StoreError

    if sys.stdout is None:
        click.echo("Error: cannot write the results: standard output is closed", err=True)
        sys.exit(FAILED)
    try:
        with warnings.catch_warnings():
            warnings.showwarning = _show_warning
            prepare_environment()
            code = cli.main(standalone_mode=False)
    except click.ClickException as error:
        error.show()
        code = error.exit_code
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted", err=True)
        code = INTERRUPTED
    except InputError as error:
        click.echo(f"Error: {error}", err=True)
        code = BAD_INPUT
    except (SimulationError, StoreError) as error:
        click.echo(f"Error: {error}", err=True)
        code = FAILED
    except OSError as error:
        # Such as a pipe that was closed or a disk that is full.
        if not isinstance(error, BrokenPipeError):
            click.echo(f"Error: cannot write the results: {error.strerror}", err=True)
        sys.stdout = None
        code = FAILED
    sys.exit(code or DONE)


def _show_warning(message: Warning | str, *_: object, **__: object) -> None:
    click.echo(f"Warning: {message}", err=True)

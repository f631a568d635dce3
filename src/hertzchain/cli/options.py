"""Options shared by several commands, and checks of their values."""

from __future__ import annotations

import functools
import itertools
import math
import os
from collections.abc import Callable
from difflib import SequenceMatcher
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import click

from .chain_completion import complete_measures
from .wording import TYPED, in_words_of_the_command

if TYPE_CHECKING:
    from ..chain.chain import Chain
    from ..designs.measures import Measure

Command: TypeAlias = Callable[..., Any]
# File name extensions of figures.
PICTURES: Final = (".png", ".svg", ".pdf")


class Fraction(click.ParamType):  # type: ignore[type-arg]
    """A number without a dimension, such as 0.05 or 5%."""

    name = "number"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Convert the text of an option; the default is a number already."""
        del ctx
        option = "" if param is None else max(param.opts, key=len)
        return value if isinstance(value, float) else fraction_from(option, value)


class Grade(click.ParamType):  # type: ignore[type-arg]
    """A grade of balls, such as 10 or G10."""

    name = "integer"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Convert the text of an option, with or without the letter of ISO 3290-1."""
        text = str(value).strip()
        try:
            return int(text[1:] if text[:1] in ("G", "g") else text)
        except ValueError:
            self.fail(f"{text!r} is not a grade, such as 100 or G100", param, ctx)


class StrictCommand(click.Command):
    """A command that rejects options given twice, of which Click would use the last."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the options, each of which has one value unless it is repeatable."""
        if not ctx.resilient_parsing:
            try:
                _, _, order = self.make_parser(ctx).parse_args(list(args))
            except click.NoSuchOption as error:
                raise _explained(self, error, ctx) from None
            for param in order:
                if _has_one_value(param) and order.count(param) > 1:
                    option = " or ".join(param.opts)
                    raise click.UsageError(f"{option} is given {order.count(param)} times; give "
                                           "it once", ctx)  # fmt: skip
            _check_no_file_of_json(self, args, ctx)
            ctx.meta[TYPED] = _other_names(self, args)
        return super().parse_args(ctx, args)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command; messages of the library are in the words of its options."""
        with in_words_of_the_command():
            return super().invoke(ctx)


def _other_names(command: click.Command, args: list[str]) -> dict[str, str]:
    """Options that were typed by another name than their first one, with this name."""
    typed = {arg.partition("=")[0] for arg in args}
    return {
        param.opts[0]: name
        for param in command.params
        for name in param.opts[1:]
        if name.startswith("--") and name in typed and param.opts[0] not in typed
    }


def _check_no_file_of_json(command: click.Command, args: list[str], ctx: click.Context) -> None:
    """Reject a file after ``--json``, which other options for results take."""
    flags = {name for param in command.params if param.name == "as_json" for name in param.opts}
    for option, after in itertools.pairwise(args):
        if option in flags and after.endswith(".json"):
            raise click.UsageError(
                "--json prints to the terminal and takes no file: to write one, redirect the "
                f"output, --json > {after}",
                ctx,
            )


# Names of options that are keys of chain files, where these differ.
KEYS_OF_FILES: Final = {
    "striker_mass": "mass = ... in [[chain.struck_by]]",
    "gap": "gaps = [...] in [chain]",
    "left_wall": "a table [chain.left_wall]",
    "drive": "a table [chain.drive]",
    "defect": "with_defects = [{bead = ..., radius = ...}] in [chain]",
}
# Options that have another name than the same argument of a function.
NAMES_OF_ARGUMENTS: Final = {"samples": "--chains", "relative": "--scatter"}


def _explained(
    command: click.Command, error: click.NoSuchOption, ctx: click.Context
) -> click.UsageError:
    """The error, with the closest option, or the key of chain files that has this meaning."""
    similar = _closest(error.option_name, error.possibilities or [])
    error = click.NoSuchOption(error.option_name, possibilities=similar, ctx=ctx)
    name = error.option_name.lstrip("-").replace("-", "_")
    other = NAMES_OF_ARGUMENTS.get(name)
    if any(other in param.opts for param in command.params):
        return click.UsageError(f"No such option '{error.option_name}'; use {other}", ctx)
    if not any(param.name in ("files", "file", "chain") for param in command.params):
        return error
    from ..store.chain_schema import KEYS

    key = KEYS_OF_FILES.get(name) or (f"{name} = ... in [chain]" if name in KEYS else "")
    if not key:
        return error
    return click.UsageError(
        f"No such option '{error.option_name}'; in a chain FILE, write {key}", ctx
    )


def _closest(name: str, similar: list[str]) -> list[str]:
    """Those of several similar names that are most similar: one, unless they are equally so."""
    ratios = [SequenceMatcher(None, each, name).ratio() for each in similar]
    return [each for each, ratio in zip(similar, ratios, strict=True) if ratio == max(ratios)]


def _has_one_value(param: click.Parameter) -> bool:
    return isinstance(param, click.Option) and not (param.multiple or param.is_flag)


class LateHelp(click.Option):
    """An option whose help is computed when it is shown, because it imports the library."""

    def __init__(self, *names: Any, late_help: Callable[[], str], **settings: Any) -> None:
        super().__init__(*names, **settings)
        self.late_help = late_help

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        """Names and help of the option."""
        self.help = self.late_help()
        return super().get_help_record(ctx)


def as_typed(text: str) -> float | str:
    """The number that a text is; any other text is left to the parser of units."""
    try:
        return float(text)
    except ValueError:
        return text


def fraction_from(option: str, text: str) -> float:
    """Parse a number or a percentage."""
    from ..validation.numbers import FRACTION, number

    return number(option, as_typed(text), unit=FRACTION)


def time_from(option: str, text: str | None, chain: Chain) -> float | None:
    """Parse a time: a number or, for a chain in SI units, a number with a unit, such as 2ms."""
    return None if text is None else _measure_from(option, text, chain, "s", "us")


def length_from(option: str, text: str, chain: Chain) -> float:
    """Parse a length: a number or, for a chain in SI units, a number with a unit, such as 5um."""
    return _measure_from(option, text, chain, "m", "um")


def _measure_from(option: str, text: str, chain: Chain, unit: str, small: str) -> float:
    from ..validation.numbers import SCALED, number

    if chain.units == "SI":
        # Runs last microseconds to milliseconds, and gaps are short, so a number above 1 is not
        # meant in seconds or metres.
        require_unit(option, text, unit, small)
    return number(option, as_typed(text), unit=unit if chain.units == "SI" else SCALED, above=0.0)


def seconds_from(option: str, text: str) -> float:
    """Parse a time with its unit."""
    from ..validation.numbers import number

    require_unit(option, text, "s", "us")
    return number(option, as_typed(text), unit="s")


def require_unit(option: str, text: str, unit: str, small: str | None = None) -> None:
    """Reject a number without a unit, which could be meant in any; 0 requires none.

    Numbers from 1 on are meant in the unit ``small`` if it is given.
    """
    from ..representation import measure

    value = as_typed(text)
    if isinstance(value, float) and value and math.isfinite(value):
        usual = f"{text.strip()} {unit}"
        if small is not None:
            usual = f"{value:g} {small}" if abs(value) >= 1.0 else measure(value, unit)
        raise click.UsageError(
            f"{option} {text.strip()} has no unit; write, for example, {option} '{usual}'"
        )


def reject_decimal_comma(option: str, text: str) -> None:
    """Reject a comma between digits in an option whose values are separated by commas."""
    from ..units import comma_advice

    if advice := comma_advice(text):
        raise click.UsageError(
            f"{option} has a comma between two digits, got {text!r}{advice}, or a space after a "
            "comma that separates values"
        )


def bead_from(text: str) -> int | str:
    """The number of a bead; any other text is left to the parser of names."""
    return int(text) if text.strip().isdecimal() else text


def window_from(option: str, text: str) -> tuple[int, int]:
    """Parse ``FIRST:LAST``, the first and last bead of a window."""
    try:
        first, last = (int(part) for part in text.split(":"))
    except ValueError:
        raise click.UsageError(f"{option} must look like 5:60, got {text!r}") from None
    return first, last


def numbers_from(option: str, text: str) -> tuple[float, ...]:
    """Parse numbers or percentages separated by commas."""
    parts = text.split(",")
    if not all(map(str.strip, parts)):
        raise click.UsageError(f"{option} must look like 0.01,0.02 or 1%,2%, got {text!r}")
    return tuple(fraction_from(option, part) for part in parts)


def names_from(text: str | None) -> list[str] | None:
    """Parse names separated by commas; None if the option is not given."""
    return None if text is None else [part.strip() for part in text.split(",") if part.strip()]


def measure_from(text: str | None, chain: Chain) -> Measure:
    """A quantity of a chain; by default the peak on its wall or cap, or the last velocity."""
    from ..designs.measures import measure_of

    free = "body_force.peak" if chain._free_cap else "velocity@last"
    usual = free if chain.right_wall is None else "wall_force.peak"
    return measure_of(chain, usual if text is None else text)


def check_chain_file(path: Path) -> None:
    """Raise the error on a missing chain file before other files are read."""
    if not path.exists():
        import hertzchain

        hertzchain.load_chain(path)


def check_writable(path: Path | None, option: str, endings: tuple[str, ...]) -> None:
    """Check the extension and folder of an output file before anything is computed."""
    if path is None:
        return
    from ..representation import listed

    if path.suffix not in endings:
        raise click.UsageError(f"{option} {path} must end in {listed(endings, 'or')}")
    if not path.parent.is_dir():
        raise click.UsageError(f"{option} {path}: the folder {path.parent} does not exist")
    from ..errors import InputError

    if path.is_dir():
        raise InputError(f"{option} {path} is a folder; give the name of a file")
    # A file is replaced by a new one, which its folder must allow.
    if not os.access(path.parent, os.W_OK):
        raise InputError(f"{option} {path}: the folder {path.parent} is not writable")


sensors_option = click.option(
    "--sensor",
    "sensors",
    multiple=True,
    metavar="COLUMN[=PLACE]",
    help="Column to read and, if its header does not name them, the place of the sensor and the "
    "unit, such as CH1=wall or 'CH2=ball 5 [V]'; repeatable.  If several files have the same "
    "columns, name the file, as in ch1.csv=wall or 'ch1.csv:Volt=wall'.  [default: all columns]",
)


def sensors_from(texts: tuple[str, ...]) -> dict[str, str] | None:
    """Places of sensors by the names of their columns; None for all columns."""
    places: dict[str, str] = {}
    for text in texts:
        # Names of files may have an equals sign.
        column, _, place = map(str.strip, text.rpartition("=") if "=" in text else (text, "", ""))
        if not column:
            raise click.UsageError(f"--sensor {text!r} names no column; write it as in CH1=wall")
        if column in places:
            raise click.UsageError(f"--sensor {column} is given twice; give each column one place")
        places[column] = place or column
    return places or None


noise_option = click.option(
    "--noise",
    "noises",
    multiple=True,
    metavar="[SENSOR=]SIZE",
    help="Standard deviation of the noise of all sensors or of one, such as '3 mV' or "
    "'wall=0.05 N'; repeatable, and with a name, an exception.  [default: from the samples before "
    "the pulse]",
)


def noise_from(texts: tuple[str, ...]) -> float | str | dict[str, float | str] | None:
    """Noise of all sensors, or by sensor; None if it has to be estimated."""
    from ..traces.noise import OTHERS

    return by_name("--noise", "sensor", "wall", OTHERS, texts)


def by_name(
    option: str, noun: str, example: str, others: str, texts: tuple[str, ...]
) -> float | str | dict[str, float | str] | None:
    """Values such as ``5%`` for all, or by name, such as ``nylon=20%``; None without any."""
    if len(texts) == 1 and "=" not in texts[0]:
        return as_typed(texts[0])
    unnamed = [text for text in texts if "=" not in text]
    if len(unnamed) > 1:
        raise click.UsageError(
            f"{option} {unnamed[1]!r} names no {noun}, nor does {option} {unnamed[0]!r}; give one "
            f"for all {noun}s, and exceptions such as {option} '{example}={unnamed[1]}'"
        )
    found: dict[str, float | str] = {}
    for text in texts:
        name, equals, value = text.rpartition("=")
        found[name.strip() if equals else others] = as_typed(value.strip())
    return found or None


quantity_option = click.option(
    "--quantity",
    metavar="NAME",
    shell_complete=complete_measures,
    help="The quantity, such as wall_force.peak.  Those of the last body of a free end are "
    "body_force.peak and body_force.acceleration.  Quantities of a bead have its place after @, as "
    "in velocity@20 and arrival@last; 'velocity@ball 19' does not count the strikers.  The force "
    "in a sensor is 'sensor.largest@ball 4' or 'sensor.first_maximum@ball 4'.  "
    "[default: wall_force.peak; with a cap and no wall, body_force.peak; else velocity@last]",
)


until_option = click.option(
    "--until",
    metavar="TIME",
    help="Stop time of the simulations, such as 60 or, in SI units, 2ms.  [default: when the "
    "quantity is complete]",
)


def json_option(purpose: str = "Print everything as JSON.") -> Callable[[Command], Command]:
    """Add the option ``--json``."""
    return click.option("--json", "as_json", is_flag=True, help=purpose)


def figure_option(purpose: str) -> Callable[[Command], Command]:
    """Add the options ``--plot FILE`` and ``--width``; FILE is checked before the command runs."""

    def decorate(command: Command) -> Command:
        @click.option(
            "--plot", type=click.Path(path_type=Path), metavar="FILE",
            help=purpose.replace("FILE", "FILE (.png, .svg or .pdf)"),
        )  # fmt: skip
        @with_width("plot")
        @functools.wraps(command)
        def with_option(*arguments: Any, **options: Any) -> Any:
            check_writable(options["plot"], "--plot", PICTURES)
            return command(*arguments, **options)

        return with_option

    return decorate


def with_width(parameter: str) -> Callable[[Command], Command]:
    """Add the option ``--width`` to a command whose figure is written to this parameter."""

    def decorate(command: Command) -> Command:
        @click.option(
            "--width",
            metavar="WIDTH",
            help="Draw the figure for a journal: 'single column' (86 mm wide), 'double column' "
            "(178 mm), a length such as '120 mm', or a number of inches.  The figure then has no "
            "title.",
        )
        @functools.wraps(command)
        def with_option(*arguments: Any, width: str | None, **options: Any) -> Any:
            if width is None:
                return command(*arguments, **options)
            if not options[parameter]:
                raise click.UsageError(f"--width requires a figure; add --{parameter} FILE")
            from ..plotting.style import figure_style

            with figure_style(as_typed(width)):
                return command(*arguments, **options)

        return with_option

    return decorate

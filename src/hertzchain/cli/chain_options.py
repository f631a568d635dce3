"""Options that describe a chain, and the chain that they describe."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from ..errors import InputError
from .chain_changes import (
    at_speed,
    before_wall,
    compressed,
    law_from,
    struck,
    under_gravity,
    wall_with_loss,
    with_cap,
)
from .chain_completion import complete_losses, complete_materials, complete_tapers, complete_walls
from .options import Fraction, as_typed, require_unit

if TYPE_CHECKING:
    from ..chain.chain import Chain

REPEATED: Final = "  Repeat it to compare several."


class ImpactOption(click.Option):
    """A speed or a height, of which only `simulate` compares several."""

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        """Names and help of the option."""
        found = super().get_help_record(ctx)
        if found is None or ctx.command.name == "simulate":
            return found
        return found[0], found[1].replace(REPEATED, "")


# Options of the impact.
IMPACT: Final = (
    click.option(
        "--speed",
        "--velocity",
        "speed",
        multiple=True,
        metavar="SPEED",
        cls=ImpactOption,
        help="Velocity of the impact, such as '0.1 m/s'.  Replaces that of a FILE; if nothing "
        "moves in the file, its strikers or else bead 1 get this velocity."
        f"{REPEATED}  [default: 1 m/s, at which steel balls yield]",
    ),
    click.option(
        "--height",
        multiple=True,
        metavar="HEIGHT",
        cls=ImpactOption,
        help="Height from which the strikers, or else bead 1, fall from rest, such as '5 mm'; "
        "it replaces --speed.  The speed follows from the standard gravity, 9.80665 m/s^2, also "
        f"with another --gravity.{REPEATED}",
    ),
    click.option(
        "--striker",
        metavar="STRIKER",
        help="Add a striker, which hits the chain at rest: a number of beads like the first, or a "
        "mass, a diameter, flat, a material or several of these, such as '30 g' or '50 g, flat'.  "
        "Instead of --speed, you can give the height from which it falls, as in 'height=5 mm', or "
        "its energy, as in '500 g, flat, 2 J'.  "
        "[default: bead 1 moves]",
    ),
)
CHAIN_OPTIONS: Final = (
    click.argument("files", nargs=-1, metavar="[FILE]...", type=click.Path(path_type=Path)),
    click.option(
        "--chain",
        "chain_file",
        type=click.Path(path_type=Path),
        metavar="FILE",
        help="The same as FILE: TOML, or CSV with one row per bead.",
    ),
    click.option(
        "--taper",
        shell_complete=complete_tapers,
        help="How the sizes change along the chain: uniform, or backward-linear, "
        "forward-linear, backward-exponential or forward-exponential, which need --rate.  Between "
        "a first and a last size: linear or exponential.  [default: uniform; between two sizes, "
        "exponential]",
    ),
    click.option(
        "--rate",
        type=Fraction(),
        help="Rate of a taper, such as 0.05 or 5%: S of a linear one, q of an exponential one.",
    ),
    click.option("--beads", type=int, help="Number of beads N.  [default: 100]"),
    click.option(
        "--diameter",
        metavar="FIRST[:LAST]",
        help="Diameter of all beads, such as '20 mm', or of the first and the last one, such as "
        "'20 mm:5 mm'.",
    ),
    click.option("--radius", metavar="FIRST[:LAST]", help="Radius, instead of the diameter."),
    click.option(
        "--material",
        metavar="NAME[,NAME]...",
        shell_complete=complete_materials,
        help="Material of the beads, such as steel-52100.  The chain is then in SI units.  Beads "
        "have several materials in turn, as in 'steel-304, ptfe'.",
    ),
    *IMPACT,
    click.option(
        "--wall",
        metavar="NAME",
        shell_complete=complete_walls,
        help="Add a wall behind the last bead: of the bead's material (same), rigid, of another "
        "material, or with a stiffness such as '5 kN/mm'.  This spring replaces the Hertz contact "
        "of the last ball: if it is stiffer than this contact, add a light cap (--cap).  A pad k1 "
        "in front of a wall k2 has the stiffness k1 k2 / (k1 + k2).  Replaces the wall of a FILE; "
        "none removes it, so that the last bead or cap is free.",
    ),
    click.option(
        "--gravity",
        metavar="G",
        help="Acceleration along the chain, positive towards the last bead.  A column whose first "
        "bead is on top has '9.81 m/s^2'.  Replaces that of a FILE.",
    ),
    click.option(
        "--precompression",
        metavar="FORCE",
        help="Static force on every contact, such as '20 N'.  A wall at rest holds its end; an end "
        "without a wall is free to move under this constant force.  Replaces that of a FILE.",
    ),
    click.option(
        "--cap",
        metavar="CAP",
        help="Add a flat body behind the last ball.  In front of a wall, it is the cap of a load "
        "cell; without a wall, it is a free body such as a box with an instrument.  Give its mass, "
        "or its resonance frequency on the wall.  You can add its material, as in "
        "'5 g, steel-304', and the stiffness of a pad or spring in front of it, as in "
        "'5 g, 1 kN/mm'.  Replaces the cap of a FILE.",
    ),
    click.option(
        "--loss",
        metavar="LAW",
        shell_complete=complete_losses,
        help="Law of the loss in contacts with its parameter, such as restitution=0.96, "
        "viscoelastic='0.6 us' or elastic-plastic.  The parameter can also follow from a measured "
        "restitution and the speed of that impact, as in "
        "'viscoelastic, restitution=0.93, speed=0.8 m/s'; instead of the speed, you can give the "
        "height of a fall, as in 'height=30 mm'.  The balls of this measurement are the first two "
        "that touch, or those of another contact, such as contact=3 or contact=wall.  Replaces "
        "the loss of a FILE.",
    ),
    click.option(
        "--wall-loss",
        metavar="LAW",
        shell_complete=complete_losses,
        help="Law of the loss in the contact with the wall, if it differs from that between "
        "beads.  It has the same form as --loss, with the restitution of the last bead at the "
        "wall.",
    ),
)
# Options that can be used with a FILE.
CHANGES: Final = (
    "speed", "height", "striker", "wall", "gravity", "precompression", "cap", "loss", "wall_loss",
)  # fmt: skip


@dataclass(frozen=True)
class ChainOptions:
    """Values of the options, as given."""

    files: tuple[Path, ...] = ()
    chain_file: Path | None = None
    taper: str | None = None
    rate: float | None = None
    beads: int | None = None
    diameter: str | None = None
    radius: str | None = None
    material: str | None = None
    speed: str | None = None
    striker: str | None = None
    wall: str | None = None
    gravity: str | None = None
    precompression: str | None = None
    cap: str | None = None
    loss: str | None = None
    wall_loss: str | None = None
    # The height of which `speed` is the speed after the fall.
    height: str | None = None
    # Speeds or heights after the first one, which `simulate` compares with it.
    others: tuple[str, ...] = ()

    @property
    def option_of_speed(self) -> str:
        """The option that gives the speed."""
        return "--speed" if self.height is None else "--height"


def chain_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options that describe a chain; the command gets them as its first argument."""
    return _with_options(command, CHAIN_OPTIONS)


def chain_at_rest_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The same without the options of an impact."""
    return _with_options(command, tuple(each for each in CHAIN_OPTIONS if each not in IMPACT))


def _with_options(command: Callable[..., Any], options: tuple[Any, ...]) -> Callable[..., Any]:
    @functools.wraps(command)
    def with_chain(**given: Any) -> Any:
        names = given.keys() & {each.name for each in fields(ChainOptions)}
        found = {name: given.pop(name) for name in names}
        if "speed" in found:
            found |= _impact(found["speed"], found["height"])
        return command(ChainOptions(**found), **given)

    for option in options[::-1]:
        with_chain = option(with_chain)
    return with_chain


def _impact(speeds: tuple[str, ...], heights: tuple[str, ...]) -> dict[str, Any]:
    """Values of the options of the speed: the first speed or height, and the others."""
    if speeds and heights:
        raise click.UsageError("--height determines the speed: omit it or --speed")
    first, *others = heights or speeds or (None,)
    given: dict[str, Any] = {"speed": first, "height": None, "others": tuple(others)}
    return given | (with_height(first) if first is not None and heights else {})


def with_height(height: str) -> dict[str, str]:
    """A height, and the speed after a fall from it."""
    from ..chain.strikers import speed_of_fall
    from ..validation.numbers import number

    require_unit("--height", height, "m", "mm")
    fall = number("--height", as_typed(height), unit="m", above=0.0)
    return {"height": height, "speed": f"{speed_of_fall('--height', fall)!r} m/s"}


def chain_from(options: ChainOptions) -> Chain:
    """The one chain that the options describe."""
    if len(options.files) > 1:
        raise click.UsageError(f"give one chain FILE, got {len(options.files)}")
    return next(iter(chains_from(options).values()))


def chains_from(options: ChainOptions) -> dict[str, Chain]:
    """The chains of all files, by the names of the files; one without a name for options."""
    from ..store.chain_files import load_chain

    if options.others:
        given = ", ".join((str(options.height or options.speed), *options.others))
        raise click.UsageError(
            f"give one {options.option_of_speed}, got {given}; simulate accepts several"
        )
    if options.files and options.chain_file is not None:
        raise click.UsageError("give the chain as FILE or as --chain FILE, not both")
    files = options.files or tuple(filter(None, (options.chain_file,)))
    if not files:
        return {"": _changed(_described(options), options)}
    beside = [
        each.name for each in fields(options)
        if each.name not in ("files", "chain_file", "others", *CHANGES)
        and getattr(options, each.name) is not None
    ]  # fmt: skip
    if beside:
        raise click.UsageError(
            f"give a chain FILE or --{' and --'.join(beside)}, not both; "
            f"'{files[0]}' is read as FILE"
        )
    names = [file.stem for file in files]
    if len(set(names)) < len(names):
        names = [os.fspath(file) for file in files]
    if len(set(names)) < len(names):
        raise click.UsageError(f"each chain FILE may be given once, got {', '.join(names)}")
    chains = {name: load_chain(file) for name, file in zip(names, files, strict=True)}
    if options.speed is not None:
        chains = {
            name: at_speed(chain, options.speed, options.option_of_speed)
            for name, chain in chains.items()
        }
    return {
        name: _changed(chain, options, file)
        for file, (name, chain) in zip(files, chains.items(), strict=True)
    }


def _changed(chain: Chain, options: ChainOptions, file: Path | None = None) -> Chain:
    """The chain with the strikers, wall, static forces, cap and losses of the options.

    If the losses do not suit the chain of a file, the error names the file.
    """
    if options.striker is not None:
        chain = struck(chain, options.striker, options.speed, options.option_of_speed)
    if options.wall is not None:
        chain = before_wall(chain, options.wall)
    if options.gravity is not None:
        chain = under_gravity(chain, options.gravity)
    if options.precompression is not None:
        chain = compressed(chain, options.precompression)
    if options.cap is not None:
        chain = with_cap(chain, options.cap)
    losses: dict[str, Any] = {}
    if options.loss is not None:
        losses["loss"] = law_from(options.loss, chain, own_law=options.wall_loss is not None)
    if options.wall_loss is not None:
        losses["right_wall"] = wall_with_loss(options.wall_loss, chain)
    # A wall that the law of the beads does not describe has its own before it is checked.
    try:
        return chain.replace(**losses) if losses else chain
    except InputError as error:
        raise error if file is None else InputError(f"{file}: {error}") from None


def _described(options: ChainOptions) -> Chain:
    from ..chain.chain import Chain
    from ..validation.numbers import number

    beads = 100 if options.beads is None else options.beads
    sizes = _sizes(options)
    if options.material is None and options.speed is not None:
        raise click.UsageError(
            f"{options.option_of_speed} requires --material and --diameter: in scaled variables, "
            "the velocity of the impact is 1"
        )
    if options.material is not None and not sizes:
        raise click.UsageError(
            "--material requires the size of the beads, such as --diameter '10 mm'"
        )
    if options.material is not None:
        _require_units(options, sizes)
    materials = None if options.material is None else _materials(options.material, beads)
    kind: dict[str, Any] = {"materials": materials, "velocity": None}
    if options.speed is not None:
        kind["velocity"] = number("--speed", as_typed(options.speed), unit="m/s")
    if any(name.startswith("last") for name in sizes):
        if options.rate is not None:
            raise click.UsageError("two sizes determine the rate of a taper: omit --rate")
        return Chain.tapered(options.taper, beads=beads, **sizes, **kind)
    if sizes and options.material is None:
        raise click.UsageError(
            "the size of equal beads has no effect in scaled variables, where the first radius is "
            "1: add --material, or give two sizes, such as --diameter 20:5"
        )
    if options.taper is None or options.taper == "uniform":
        if options.rate is not None:
            _refuse_rate(options)
        if not sizes:
            return Chain.uniform(beads)
        name = "radii" if options.diameter is None else "diameters"
        return Chain.from_materials(**{name: next(iter(sizes.values()))}, beads=beads, **kind)
    return _tapered(options.taper, options.rate, beads, sizes | kind)


def _materials(text: str, beads: int) -> str | list[str]:
    """The material of all beads, or those of the beads in turn."""
    names = [name.strip() for name in text.split(",")]
    if len(names) > max(beads, 1):
        there = "is only 1 bead" if beads == 1 else f"are only {beads} beads"
        raise click.UsageError(
            f"--material has {len(names)} materials, but there {there}: omit some"
        )
    return names[0] if len(names) == 1 else (names * beads)[:beads]


def _require_units(options: ChainOptions, sizes: dict[str, Any]) -> None:
    """Reject a length or a speed without a unit, which could be meant in any."""
    option = "--radius" if options.diameter is None else "--diameter"
    for size in sizes.values():
        require_unit(option, f"{size:g}" if isinstance(size, float) else size, "mm")
    if options.speed is not None:
        require_unit("--speed", options.speed, "m/s")


def _refuse_rate(options: ChainOptions) -> None:
    from ..chain.tapers import TAPERS

    if options.taper is None:
        raise click.UsageError(f"--rate requires --taper: {', '.join(TAPERS)}")
    raise click.UsageError("--rate cannot be used with a uniform chain")


def _tapered(taper: str, rate: float | None, beads: int, more: dict[str, Any]) -> Chain:
    from ..chain.chain import Chain
    from ..chain.taper_sizes import SHAPES
    from ..chain.tapers import TAPERS
    from ..validation.objects import check_choice

    if taper in SHAPES:
        raise click.UsageError(
            f"--taper {taper} requires two sizes, such as --diameter '20 mm:5 mm'; with --rate, "
            f"it is {' or '.join(SHAPES[taper])}"
        )
    check_choice("taper", taper, (*TAPERS, "uniform"))
    if rate is None:
        usual = "its S, such as 0.005" if taper.endswith("linear") else "its q, such as 0.05"
        raise click.UsageError(f"--taper {taper} requires --rate, {usual}")
    return Chain.tapered(taper, rate, beads=beads, **more)


def _sizes(options: ChainOptions) -> dict[str, Any]:
    """Arguments of `Chain.tapered` from ``--diameter FIRST:LAST`` or ``--radius FIRST:LAST``."""
    from ..units import comma_advice

    if options.diameter is not None and options.radius is not None:
        raise click.UsageError("give --diameter or --radius, not both")
    option = "--radius" if options.diameter is None else "--diameter"
    text = options.radius if options.diameter is None else options.diameter
    if text is None:
        return {}
    parts = [part.strip() for part in text.split(":")]
    if len(parts) > 2 or not all(parts) or "," in text:
        raise click.UsageError(
            f"{option} must look like '20 mm' or, with a colon between first and last, "
            f"'20 mm:5 mm', got {text!r}{comma_advice(text)}"
        )
    suffix = "_diameter" if options.radius is None else ""
    return {f"{end}{suffix}": as_typed(part) for end, part in zip(("first", "last"), parts)}  # noqa: B905

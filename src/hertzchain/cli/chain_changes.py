"""Options that change a chain, of a file or of others: impact, wall, static forces, cap, losses."""

from __future__ import annotations

from dataclasses import MISSING, fields
from typing import TYPE_CHECKING, Any, Final

import click

from .options import as_typed, reject_decimal_comma, require_unit
from .wording import on_command_line

if TYPE_CHECKING:
    from ..chain.chain import Chain
    from ..chain.laws import Loss
    from ..chain.walls import Wall

# Largest number of strikers, if the chain has as many beads, that is certainly not a mass in grams.
MAX_STRIKERS: Final = 20
# Properties of a striker that determine its speed.
OF_SPEED: Final = {
    "height": "a height to fall from, which determines the speed",
    "energy": "an energy, which determines the speed",
    "velocity": "a speed",
}
BOOLEANS: Final = {"true": True, "false": False}


def at_speed(chain: Chain, speed: str, option: str = "--speed") -> Chain:
    """The chain of a file with another velocity of the impact, given by an option.

    In a chain at rest, the strikers or bead 1 get the velocity.
    """
    from ..chain.impact_speed import at_impact_speed

    if option == "--height" and chain.scaled:
        raise click.UsageError(
            "--height requires a chain in SI units: give the velocity of the impact, --speed"
        )
    if not chain.scaled:
        require_unit(option, speed, "m/s")
    what = f"{'speed after ' * (option == '--height')}{option}"
    return at_impact_speed(chain, as_typed(speed), what)


def struck(chain: Chain, striker: str, speed: str | None, option: str = "--speed") -> Chain:
    """The chain struck by beads like its first one or by others, at the velocity of its impact.

    This is ``speed``, of an option, if it is given, and that from a height of the striker instead.
    """
    given = _striker(striker, chain)
    fixed = next((words for key, words in OF_SPEED.items() if key in given), None)
    if fixed is not None and speed is not None:
        raise click.UsageError(f"--striker {striker!r} has {fixed}: omit it or {option}")
    if chain.strikers:
        raise click.UsageError("--striker adds strikers, but the file has some: change them there")
    if chain.drive is not None:
        raise click.UsageError(
            "--striker replaces the impact of bead 1, but the chain of the file has a drive: add "
            "strikers to the file"
        )
    if not chain.velocities.any() and fixed is None:
        raise click.UsageError(
            "--striker requires the velocity of the impact, and no bead of the file moves: add "
            "--speed"
        )
    if chain.velocities[1:].any():
        raise click.UsageError(
            "--striker replaces the impact of bead 1, but in the file other beads move: add "
            "strikers to the file"
        )
    if chain.velocities[0] < 0.0:
        raise click.UsageError(
            f"--striker requires a speed towards the chain, above 0, but that of the impact is "
            f"{chain.velocities[0]:g}: give a positive --speed"
        )
    if fixed is None:
        given["velocity"] = float(chain.velocities[0])
    return chain.replace(velocities=None).struck_by(**given)


def _striker(text: str, chain: Chain) -> dict[str, Any]:
    """Arguments of `Chain.struck_by` from text such as ``2`` or ``50 g, flat``."""
    from ..units import has_dimension, quantity
    from ..validation.numbers import whole_number

    reject_decimal_comma("--striker", text)
    given: dict[str, Any] = {}
    value: Any
    for part in map(str.strip, text.split(",")):
        found = quantity(part)
        if part.lstrip("+-").isdigit():
            key, value = "count", whole_number("--striker", int(part), least=1)
        elif part == "flat":
            key, value = "radius", part
        elif part.startswith("height="):
            key, value = "height", part.removeprefix("height=").strip()
            require_unit("height of --striker", value, "m", "mm")
        elif found is not None and has_dimension(found[1], "kg"):
            key, value = "mass", part
        elif found is not None and has_dimension(found[1], "m"):
            key, value = "diameter", part
        elif found is not None and has_dimension(found[1], "J"):
            key, value = "energy", part
        elif found is not None and has_dimension(found[1], "m/s"):
            key, value = "velocity", part
        elif found is None and part[:1].isalpha():
            key, value = "material", _material_of_striker(part, chain)
        else:
            raise click.UsageError(
                "--striker must be a number of beads like the first, or a mass, a diameter, flat, "
                "a speed, an energy, a material or height=..., such as --striker '50 g, flat', "
                f"got {part!r}"
            )
        if key in given:
            raise click.UsageError(f"--striker {text!r} has two values of the {key}: omit one")
        given[key] = value
    if given.get("count", 1) > 1 and "radius" in given:
        raise click.UsageError(
            f"--striker {text!r} has {given['count']} flat strikers, of which one strikes at most: "
            f"omit the number, or write its unit, such as '{given['count']} mm'"
        )
    _warn_count_for_mass(given, chain)
    if chain.scaled and given.keys() != {"count"}:
        raise click.UsageError(
            f"--striker {text!r} requires --material; in scaled variables, it is a number of beads "
            "like the first"
        )
    return given


def _material_of_striker(part: str, chain: Chain) -> str:
    """The name of a material, unless it is a misspelt ``flat`` or ``height=...``."""
    from ..chain.materials import catalogue
    from ..errors import similar_names

    name, equals, value = (each.strip() for each in part.partition("="))
    own = {each.name for each in chain.materials or ()}
    if part.lower() in own | {*catalogue()} or part in own:
        return part
    if equals:
        near = f"; did you mean 'height={value}'?" if similar_names(name, ["height"]) else ""
        raise click.UsageError(
            f"--striker has no key {name!r}{near or ': choose height=..., the height of a fall'}"
        )
    if similar_names(part, ["flat"]):
        raise click.UsageError(f"--striker: {part!r} is not known; did you mean 'flat'?")
    return part


def with_cap(chain: Chain, text: str) -> Chain:
    """The chain with a cap from text such as ``5 g``, ``8 kHz`` or ``5 g, steel-304, 1 kN/mm``."""
    from ..store.text_forms import cap_from_text

    given = cap_from_text("--cap", text)
    if chain.scaled:
        raise click.UsageError(f"--cap {text!r} requires --material")
    return chain.with_cap(**given)


def _warn_count_for_mass(given: dict[str, Any], chain: Chain) -> None:
    """Warn about so many strikers that the number is probably a mass in grams."""
    from ..errors import InputWarning, warn_user

    count = given.get("count", 1)
    if not chain.scaled and count > min(chain.beads, MAX_STRIKERS):
        warn_user(
            f"--striker {count} is a number of striking beads; for a mass, write, for example, "
            f"--striker '{count} g'",
            InputWarning,
        )


def under_gravity(chain: Chain, gravity: str) -> Chain:
    """The chain under another gravity."""
    return chain.replace(gravity=_with_unit(chain, gravity, "--gravity", "m/s^2"))


def compressed(chain: Chain, force: str) -> Chain:
    """The chain under a static force; free ends are then held by this force."""
    given = _with_unit(chain, force, "--precompression", "N")
    walls = chain.left_wall is not None and chain.right_wall is not None
    return chain.replace(precompression=given, held_by="walls" if walls else "force")


def _with_unit(chain: Chain, text: str, option: str, unit: str) -> str | float:
    """A number of a scaled chain, or text with a unit."""
    if not chain.scaled:
        require_unit(option, text, unit)
    return as_typed(text)


def before_wall(chain: Chain, name: str) -> Chain:
    """The chain in front of the wall of ``--wall NAME``; with a free end for ``none``."""
    if name != "none":
        return chain.replace(right_wall=_wall_named(name, chain))
    # A free end is held by the constant force, as that of --precompression.
    held = {"held_by": "force"} if chain.precompression else {}
    return chain.replace(right_wall=None, **held)


def _wall_named(name: str, chain: Chain) -> Wall:
    """The wall of ``--wall NAME``."""
    from ..chain.laws.elastic import Elastic
    from ..chain.walls import Wall
    from ..errors import InputError
    from ..store.text_forms import wall_from_text

    if name == "same":
        return Wall()
    if name == "rigid":
        return Wall.rigid()
    if chain.scaled:
        raise click.UsageError(
            f"--wall {name} requires --material; a scaled chain has the walls same, rigid and none"
        )
    given = wall_from_text("--wall", name)
    if given.pop("loss", None):
        given["loss"] = Elastic()
    try:
        return Wall(**given)
    except InputError as error:
        words = on_command_line(str(error))
        kinds = (
            "--wall must be same, rigid, none, a material or a stiffness such as '5 kN/mm': "
            if "material" in given
            else ""
        )
        raise click.UsageError(f"{kinds}{words}") from None


def wall_with_loss(text: str, chain: Chain) -> Wall:
    """The right wall with the law of ``--wall-loss``."""
    from dataclasses import replace

    if chain.right_wall is None:
        raise click.UsageError("--wall-loss is that of the contact with a wall: add --wall")
    return replace(chain.right_wall, loss=law_from(text, chain, "--wall-loss"))


def _pairs(texts: list[str]) -> list[tuple[str, str]]:
    """Keys and values of texts such as ``alpha=1.2``."""
    parts = (each.partition("=") for each in texts)
    return [(key.strip(), value.strip()) for key, _, value in parts]


def _law_with_restitution(
    name: str, given: list[str], chain: Chain, option: str, *, own_law: bool
) -> Loss:
    """The law of ``viscoelastic, restitution=0.93, speed=0.8 m/s, contact=2``.

    A height of fall can replace the speed, and the contact can be ``wall``.
    """
    from ..chain.bead_names import wall_number, walls_of
    from ..chain.laws.base import LAWS
    from ..chain.laws.given_restitution import usual_contact
    from ..errors import InputError

    values: dict[str, Any] = {key: as_typed(value) for key, value in _pairs(given)}
    _replace_height(values, chain, option)
    if not {"restitution", "speed"} <= values.keys():
        raise click.UsageError(
            f"{option} {name} with a restitution needs its speed, too: write {option} "
            f"'{name}, restitution=0.93, speed=0.8 m/s'"
        )
    if not chain.scaled:
        _require_unit_of_speed(option, values["speed"])
    coefficient, speed = values.pop("restitution"), values.pop("speed")
    wall = option == "--wall-loss"
    contact = values.pop("contact", chain.beads if wall else usual_contact(chain))
    contact = int(contact) if isinstance(contact, float) and contact.is_integer() else contact
    at = wall_number(chain, contact)
    if at is not None:
        # The left wall is bead 0, and its contact has this number, too.
        contact = max(at - 1, 0)
    elif contact in (0, chain.beads):
        at = contact + (contact > 0)
    if at is not None:
        given_wall = chain.right_wall if at else chain.left_wall
        own_law = own_law or (given_wall is not None and given_wall.loss is not None)
    try:
        law = LAWS[name].from_restitution(
            coefficient, speed=speed, chain=chain, contact=contact, given=values
        )
        side = next((side for side, number in walls_of(chain).items() if number == at), "")
        place = f"{contact} ({side} wall)" if side and not wall else f"{contact}"
        where = "all contacts between beads have"
        if wall:
            where = "the wall has"
        elif side and not own_law:
            where = "all contacts, including this one, have"
        words = _law_in_words(law, chain)
        click.echo(f"{option}: {words} from the restitution in contact {place}; {where} this law",
                   err=True)  # fmt: skip
        return law
    except InputError as error:
        raise click.UsageError(f"{option} {name}: {error}") from None


def _require_unit_of_speed(option: str, speed: object) -> None:
    if isinstance(speed, float) and speed:
        raise click.UsageError(
            f"{option}: speed={speed:g} has no unit; write, for example, speed={speed:g} m/s"
        )


def _replace_height(values: dict[str, Any], chain: Chain, option: str) -> None:
    """Replace a height of fall among the values of a law by the speed after it."""
    from ..chain.strikers import speed_of_fall

    if "height" not in values:
        return
    what = f"height of {option}"
    if "speed" in values:
        raise click.UsageError(f"{option} has a speed and a height to fall from: omit one")
    if chain.scaled:
        raise click.UsageError(f"{what} requires a chain in SI units: give the speed")
    height = values.pop("height")
    require_unit(what, str(height), "m", "mm")
    values["speed"] = f"{speed_of_fall(what, height)!r} m/s"


def _law_in_words(law: Loss, chain: Chain) -> str:
    """Such as ``viscoelastic, relaxation time 0.8164 us``."""
    from ..chain.laws.given_numbers import given_numbers
    from ..representation import measure

    numbers = [
        f"{called} {measure(value, unit, chain.units).rstrip()}"
        for called, (value, unit) in given_numbers(law).items()
    ]
    switches = [
        name for name, about in law.parameters().items() if about.boolean and getattr(law, name)
    ]
    return ", ".join([law.name, *numbers, *switches])


def law_from(text: str, chain: Chain, option: str = "--loss", *, own_law: bool = False) -> Loss:
    """The law of an option: ``restitution=0.96``, or ``velocity-power=2,alpha=1.2``.

    The right wall has a law of its own in the chain, or from another option (``own_law``).
    """
    from ..chain.laws.base import LAWS
    from ..errors import InputError
    from ..units import UNITS
    from ..validation.objects import check_choice

    reject_decimal_comma(option, text)
    first, *others = text.split(",")
    name, equals, value = (part.strip() for part in first.partition("="))
    check_choice(f"law of {option}", name, LAWS)
    parameters = LAWS[name].parameters()
    pairs = _pairs(others)
    if not equals and {"restitution", "speed", "height"} & {key for key, _ in pairs}:
        return _law_with_restitution(name, others, chain, option, own_law=own_law)
    if equals and not parameters:
        raise click.UsageError(f"the law {name} has no parameters: write {option} {name}")
    required = [each.name for each in fields(LAWS[name]) if each.default is MISSING]
    if required and not equals:
        raise click.UsageError(
            f"{option} {name} requires the value of its {required[0]}: write {option} "
            f"{name}=VALUE, as in {option} restitution=0.96"
        )
    given = [*([(next(iter(parameters), ""), value)] if equals else []), *pairs]
    values: dict[str, Any] = {}
    for key, value in given:
        about = parameters.get(key)
        values[key] = BOOLEANS.get(value, as_typed(value))
        number = isinstance(values[key], float) and not chain.scaled
        if number and about is not None and about.dimension:
            raise click.UsageError(
                f"{key} = {value} of {option} {name} has no unit; write, for example, {option} "
                f"'{name}={value} {UNITS[about.dimension][:3][-1]}'"
            )
    try:
        return LAWS[name](**values)
    except InputError as error:
        raise click.UsageError(f"{option} {text}: {error}") from None

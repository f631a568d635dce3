"""Names of the parameters of a fit as words, for the axes of figures."""

from __future__ import annotations

from typing import Final

from ..errors import InputError
from ..fitting.names import Name, parse_name
from .titles import printed_name

# Words for the keys of names; the item in brackets follows.
WORDS: Final = {
    "stiffness": "stiffness factor", "struck_by.velocity": "striker velocity",
    "materials.young": "modulus of {}", "materials.poisson": "Poisson's ratio of {}",
    "materials.density": "density of {}", "radius": "radius of ball\N{NO-BREAK SPACE}{}",
    "mass": "mass of ball\N{NO-BREAK SPACE}{}",
    "gap": "gap {}", "loss.time": "relaxation time", "loss.coefficient": "restitution",
    "loss.gamma": "damping", "highpass": "high-pass", "gain": "gain of {}",
    "offset": "offset of {}", "delay": "delay of {}", "time_offset": "time offset",
}  # fmt: skip


def parameter_in_words(text: str) -> str:
    """A name such as ``materials[steel].young`` as words, ``modulus of steel``."""
    try:
        name = parse_name(text)
    except InputError:
        return text
    # A number stays in the line of its ball.
    item = name.item.replace(" ", "\N{NO-BREAK SPACE}")
    if name.key.startswith("materials."):
        item = printed_name(item)
    if name.key in ("gap", "stiffness"):
        item = item.replace("-", "\N{EN DASH}")
    pattern = WORDS.get(name.key, _of_part(name))
    words = pattern.format(item) if item else pattern.removesuffix(" of {}")
    if item and "{}" not in pattern:
        words = f"{words} {item}"
    return f"{words}, shot {name.shot}" if name.shot else words


def _of_part(name: Name) -> str:
    """Words for a key without an entry, such as that of a wall or of a parameter of a loss."""
    part, _, field = name.key.rpartition(".")
    words = WORDS.get(f"loss.{field}" if "loss" in part else field, field).replace("_", " ")
    end = part.removesuffix(".loss").replace("_", " ")
    of_wall = end.endswith("wall")
    return f"{words.removesuffix(' factor') if of_wall else words}{f' of {end}' if of_wall else ''}"

"""Tables of all keys of chain files, generated from the schema with which files are checked."""

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from importlib import resources
from typing import Any

from hertzchain.designs.balls import SHIPPED, inch_fraction, load_balls
from hertzchain.fitting.settings import KEYS
from hertzchain.store.chain_schema import chain_schema

Keys = Sequence[Mapping[str, Any]]
PER = {"bead": "one per bead", "contact": "one per contact", "row": "one per row", "item": "list"}
# Kinds of values whose name is not a type.
WORDS = {"signal": "text"}


def chain_file_page() -> str:
    """Return a page in Markdown with one section for each table of a chain file."""
    return "\n".join([
        "# Keys of chain files",
        "",
        "[Chain files](../how-to/chain_files.md) explains how to write a chain file. "
        "This page lists every table and key. It is generated from the schema with which files "
        "are checked. Units are those of chains with materials, "
        'where text with a unit, such as `"5 mm"`, is also accepted; scaled chains accept plain '
        "numbers. An empty default means that the value follows from other keys.",
        "",
        *_sections(),
        *_fit_section(),
    ])  # fmt: skip


# Symbols of the constants of the modified BCA.
SYMBOLS = {"ratio": r"$\rho$", "c0": "$c_0$", "x": "$x$", "d0": "$d_0$", "y": "$y$"}


def calibration_table() -> str:
    """Return a table in Markdown of the constants of the modified BCA, from the shipped file."""
    text = resources.files("hertzchain.theory").joinpath("calibrated.toml").read_text("utf-8")
    rows = [
        "| taper | rates | constants | velocity error: largest | rms |",
        "|---|---|---|---|---|",
    ]
    for part in text.split("[corrections.")[1:]:
        taper, _, body = part.partition("]")
        values = tomllib.loads(body)
        spread = dict(re.findall(r"^(\w+) = .*# \+- (\S+)", body, re.M))
        constants = ", ".join(
            f"{SYMBOLS[name]} = {value:g} ± {spread[name]}" for name, value in values.items()
        )
        rates = re.search(r"# (.+?); beads", body)[1]
        largest, rms = re.search(r"largest (\S+), rms (\S+)", body).groups()
        rows.append(f"| {taper} | {rates} | {constants} | {largest} | {rms} |")
    return "\n".join(rows) + "\n"


def ball_table() -> str:
    """Return a table in Markdown of the sizes in the catalogue of balls, from the shipped file."""
    sizes: dict[str, list[str]] = {}
    for ball in load_balls(SHIPPED):
        inch = inch_fraction(ball.diameter)
        size = f"{1e3 * ball.diameter:g}" + (f" ({inch} in)" if inch else "")
        sizes.setdefault(ball.material.name, []).append(size)
    rows = ["| material | diameters [mm] |", "|---|---|"]
    rows += [f"| {name} | {', '.join(values)} |" for name, values in sizes.items()]
    return "\n".join(rows) + "\n"


def _sections() -> Iterator[str]:
    for name, section in chain_schema()["sections"].items():
        yield from (f"## `[{name}]`", "", f"{_capitalised(section['description'])}.", "")
        if section["repeated"]:
            yield from (f"Several tables are written as `[[{name}]]`.", "")
        if section["texts"]:
            texts = ", ".join(f'`"{text}"`' for text in section["texts"])
            key = name.removeprefix("chain.")
            option = f"--{key}" if key in ("cap", "loss") else "--wall"
            yield from (f"Instead of the table, `{key}` can be text as for `{option}` on the "
                        f"command line: {texts}.", "")  # fmt: skip
        if section["keys"]:
            yield from _table(section["keys"])
        for value, keys in section.get("variants", {}).items():
            chosen = f'With `{section["variant_key"]} = "{value}"`'
            if keys:
                yield from (f"{chosen}:", "")
                yield from _table(keys)
            else:
                yield from (f"{chosen} there are no further keys.", "")


def _fit_section() -> Iterator[str]:
    yield from ("## `[fit]`", "", "Settings of a [fit](../how-to/fit.md) of the chain to measured "
                "traces; other commands do not use them. [Names of parameters]"
                "(../how-to/fit_options.md#names-of-parameters) lists the names.", "")  # fmt: skip
    yield from ("| key | value | meaning |", "|---|---|---|")
    for name, (value, meaning) in KEYS.items():
        yield f"| `{name}` | {value} | {meaning} |"
    yield ""


def _table(keys: Keys) -> Iterator[str]:
    yield "| key | value | unit | default | meaning |"
    yield "|---|---|---|---|---|"
    for key in keys:
        cells = f"`{key['name']}`", _value(key), key["unit"], _default(key), key["description"]
        yield f"| {' | '.join(cells)} |"
    yield ""


def _value(key: Mapping[str, Any]) -> str:
    """Type, choices, bounds and length of a value."""
    choices = ", ".join(f"`{choice}`" for choice in key["choices"])
    kind = choices or WORDS.get(key["kind"], key["kind"])
    symbols = {"above": ">", "least": "≥", "most": "≤", "below": "<"}
    bounds = [f"{symbol} {key[name]:g}" for name, symbol in symbols.items() if name in key]
    several = [PER[key["per"]] + (", or one for all" if key["one_for_all"] else "")
               for _ in range(bool(key["per"]))]  # fmt: skip
    return "; ".join([kind, *bounds, *several])


def _default(key: Mapping[str, Any]) -> str:
    if key["required"]:
        return f"required, or `{key['unless']}`" if key["unless"] else "required"
    default = key["default"]
    if default is None:
        return ""
    return f"`{str(default).lower() if isinstance(default, bool) else default}`"


def _capitalised(text: str) -> str:
    return text[:1].upper() + text[1:]

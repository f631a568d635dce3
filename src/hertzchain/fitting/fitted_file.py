"""The fitted chain as a chain file with units, strikers, results and settings of a next fit."""

from __future__ import annotations

import dataclasses
import math
import textwrap
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from ..chain.cap import Cap
from ..chain.chain import Chain
from ..chain.laws import Loss
from ..chain.materials import RIGID, Material, catalogue
from ..chain.striker_properties import SPHERE
from ..chain.walls import Wall
from ..errors import InputError
from ..store.chain_as_toml import chain_as_toml
from ..store.chain_files import chain_from
from ..store.toml_files import toml_key, toml_text
from ..traces.traces import Traces
from .names import TIME_OFFSET, Name
from .parameters import Parameter

# Digits of numbers: errors of fits are much larger than the rounding.
DIGITS: Final = 7
ROUNDING: Final = 1e-6
WIDTH: Final = 90
# Units of quantities in the file.
UNITS: Final = {"s": (1e6, "us"), "m": (1e6, "um"), "m/s": (1.0, "m/s"), "N": (1.0, "N")}


def fitted_toml(
    chain: Chain, rows: Sequence[tuple[str, str]], verdict: str,
    parameters: Sequence[Parameter], values: Mapping[str, float], traces: Traces,
) -> str:  # fmt: skip
    """Chain file with a fitted chain, the results as comments, and the settings of the fit."""
    comments = [f"# {line}" for line in _comments(rows, verdict)]
    text = readable_chain(chain) or chain_as_toml(chain)
    return "\n".join((*comments, "", text, "", *_settings(parameters, values, traces))) + "\n"


def _comments(rows: Sequence[tuple[str, str]], verdict: str) -> Iterator[str]:
    width = max(len(name) for name, _ in rows)
    yield "Chain fitted to measured traces; factors of stiffness are those of the nominal chain:"
    for name, row in rows:
        yield f"  {name:<{width}}  {row}"
    yield from textwrap.wrap(verdict, WIDTH)


def _settings(
    parameters: Sequence[Parameter], values: Mapping[str, float], traces: Traces
) -> Iterator[str]:
    """Table [fit]: the names, the priors, and the values that do not belong to the chain."""
    yield "[fit]"
    yield from _free([*map(str, parameters)])
    coupled = {signal.name: "AC" for _, signal in traces if signal.coupling == "AC"}
    if coupled:
        yield f"coupling = {toml_text(coupled)}"
    clocks = [_measure(shot.time_offset, "s") for shot in traces.shots if shot.clock is not None]
    if len(clocks) == len(traces.shots):
        yield f"time_offset = {_text(clocks[0] if len({*clocks}) == 1 else clocks)}"
    units = {str(each): _unit_in_file(each.name, values) for each in parameters}
    known = [each for each in parameters if each.prior is not None]
    if known:
        yield from ("", "[fit.prior]")
        for each in known:
            prior = [_shown(each, x / units[str(each)]) for x in each.prior or ()]
            yield f"{toml_key(str(each))} = {_text(prior)}"
    start = [each for each in parameters if not each.of_chain or each.shot]
    fixed = {} if len(clocks) == len(traces.shots) else _known_offsets(traces)
    if start or fixed:
        yield from ("", "[fit.start]")
        for key, text in fixed.items():
            yield f"{toml_key(key)} = {_text(text)}"
        for each in start:
            value = values[str(each)] / units[str(each)]
            yield f"{toml_key(str(each))} = {_text(_shown(each, value))}"


def _known_offsets(traces: Traces) -> dict[str, Any]:
    """Time offsets of the shots that have a known one; as starts of others, they are fixed."""
    return {
        str(Name(TIME_OFFSET, shot=str(k))): _measure(shot.time_offset, "s")
        for k, shot in enumerate(traces.shots, start=1)
        if shot.clock is not None
    }


def _unit_in_file(name: Name, values: Mapping[str, float]) -> float:
    """Factor of a stiffness in the chain of the file, that of the first shot; otherwise 1."""
    if name.key != "stiffness":
        return 1.0
    common = values.get(str(replace(name, shot="")), 1.0)
    return values.get(str(replace(name, shot="1")), common)


def _free(names: Sequence[str]) -> Iterator[str]:
    """List of the names, on several lines if necessary."""
    texts = [toml_text(each) for each in names]
    whole = f"free = [{', '.join(texts)}]"
    if len(whole) <= WIDTH:
        yield whole
        return
    yield "free = ["
    line = "   "
    for each in texts:
        if len(line) + len(each) > WIDTH:
            yield line
            line = "   "
        line += f" {each},"
    yield from (line, "]")


def _shown(parameter: Parameter, value: float) -> Any:
    """Number or text with the unit of a parameter."""
    return _measure(value, parameter.kind.unit)


def _measure(value: float, unit: str) -> Any:
    if unit not in UNITS:
        return value
    factor, name = UNITS[unit]
    return f"{factor * value:.{DIGITS}g} {name}"


def readable_chain(chain: Chain) -> str:
    """Text of a chain in SI units, to seven digits; empty if it has other features."""
    single = isinstance(chain.exponents, float) and (
        chain.loss is None or isinstance(chain.loss, Loss)
    )
    if chain.materials is None or chain.units != "SI" or not single:
        return ""
    if "masses" in chain.given or chain.drive or chain.scatter is not None:
        return ""
    lines = ["[chain]", *_items(_beads(chain))]
    for k in range(chain.strikers - 1, -1, -1):
        lines += ["", "[[chain.struck_by]]", *_items(_striker(chain, k))]
    if chain.cap is not None:
        lines += ["", "[chain.cap]", *_items(_cap(chain, chain.cap))]
    for name in ("left_wall", "right_wall"):
        wall: Wall | None = getattr(chain, name)
        if wall is not None:
            if wall.loss is not None:
                return ""
            lines += ["", f"[chain.{name}]", *_items(_wall(wall))]
    if isinstance(chain.loss, Loss):
        lines += ["", "[chain.loss]", *_items(_law(chain.loss))]
    lines += _materials(chain)
    text = "\n".join(lines)
    return text if _same(chain, text) else ""


def _items(entries: Mapping[str, Any]) -> list[str]:
    """Lines of a table; stiffness has the unit N/m^p, which no text can have."""
    about = {"stiffness": "  # N/m^p"}
    return [f"{key} = {_text(value)}{about.get(key, '')}" for key, value in entries.items()]


def _text(value: Any) -> str:
    """TOML of a value, of which numbers have no more digits than necessary."""
    if isinstance(value, list):
        return f"[{', '.join(map(_text, value))}]"
    if isinstance(value, float):
        mantissa, _, power = f"{value:.{DIGITS}g}".partition("e")
        return mantissa + (f"e{int(power)}" if power else "")
    return toml_text(value)


def _beads(chain: Chain) -> dict[str, Any]:
    """Keys of [chain], without strikers; lists of contacts and velocities include a cap."""
    balls = chain._balls
    behind = slice(balls.start, None)
    found: dict[str, Any] = {"diameters": _one(2e3 * chain.radii[balls], "mm")}
    kinds = [each.name for each in (chain.materials or ())[balls]]
    found["materials"] = kinds[0] if len(set(kinds)) == 1 else kinds
    if not isinstance(found["diameters"], list):
        found["beads"] = len(chain.radii[balls])
    if "stiffness" in chain.given:
        found["stiffness"] = _one(chain.stiffness[behind])
    if chain.exponents != 1.5:
        found["exponent"] = float(chain.exponents)
    if chain.gaps[behind].any():
        found["gaps"] = [_measure(each, "m") for each in chain.gaps[behind].tolist()]
    if chain.velocities[behind].any():
        found["velocities"] = [_measure(each, "m/s") for each in chain.velocities[behind].tolist()]
    if chain.precompression:
        found |= {"precompression": _measure(chain.precompression, "N"), "held_by": chain.held_by}
    return found | ({"gravity": chain.gravity} if chain.gravity else {})


def _one(values: ArrayLike, unit: str = "") -> Any:
    """One value if all are equal, otherwise a list; text with the unit, if there is one."""
    shown = [
        f"{each:.{DIGITS}g} {unit}" if unit else float(f"{each:.{DIGITS}g}")
        for each in np.asarray(values).tolist()
    ]
    return shown[0] if len(set(shown)) == 1 else shown


def _striker(chain: Chain, k: int) -> dict[str, Any]:
    assert chain.materials is not None
    found: dict[str, Any] = {"velocity": _measure(float(chain.velocities[k]), "m/s")}
    first = chain.strikers
    own = chain.striker_properties[k] if chain.striker_properties else SPHERE
    if own.mass is not None:
        found["mass"] = f"{1e3 * own.mass:.{DIGITS}g} g"
    if own.flat:
        found["radius"] = math.inf
    elif chain.radii[k] != chain.radii[first] or own.mass is not None:
        found["diameter"] = f"{2e3 * chain.radii[k]:.{DIGITS}g} mm"
    if chain.materials[k] != chain.materials[first]:
        found["material"] = chain.materials[k].name
    if "stiffness" in chain.given or own.stiffness is not None:
        found["stiffness"] = float(chain.stiffness[k])
    if chain.gaps[k]:
        found["gap"] = _measure(float(chain.gaps[k]), "m")
    return found


def _cap(chain: Chain, cap: Cap) -> dict[str, Any]:
    assert chain.materials is not None
    found: dict[str, Any] = {"mass": f"{1e3 * float(chain.masses[-1]):.{DIGITS}g} g"}
    if chain.materials[-1] != chain.materials[-2]:
        found["material"] = chain.materials[-1].name
    return found | ({} if cap.stiffness is None else {"stiffness": cap.stiffness})


def _wall(wall: Wall) -> dict[str, Any]:
    found: dict[str, Any] = {}
    if wall.material == RIGID:
        found["rigid"] = True
    elif wall.material is not None:
        found["material"] = wall.material.name
    if wall.stiffness is not None:
        found["stiffness"] = wall.stiffness
    if wall.gap:
        found["gap"] = _measure(wall.gap, "m")
    return found | ({} if wall.exponent is None else {"exponent": wall.exponent})


def _law(law: Loss) -> dict[str, Any]:
    found: dict[str, Any] = {"law": law.name}
    for item in dataclasses.fields(law):
        value = getattr(law, item.name)
        if item.name not in law.parameters() or value is None or value == item.default:
            continue
        unit = {"time": "s", "length": "m"}.get(item.metadata.get("scale", "1"), "")
        found[item.name] = value if isinstance(value, bool) else _measure(value, unit)
    return found


def _materials(chain: Chain) -> list[str]:
    """Tables of the materials that are not those of the catalogue."""
    walls = [wall.material for wall in (chain.left_wall, chain.right_wall) if wall is not None]
    known, lines = catalogue(), []
    for each in dict.fromkeys((*(chain.materials or ()), *walls)):
        if isinstance(each, Material) and each != RIGID and known.get(each.name) != each:
            lines += ["", f"[materials.{toml_key(each.name)}]", *_items(_constants(each))]
    return lines


def _constants(material: Material) -> dict[str, Any]:
    values = {each.name: getattr(material, each.name) for each in dataclasses.fields(material)}
    return {key: each for key, each in values.items() if key != "name" and each not in (None, "")}


def _same(chain: Chain, text: str) -> bool:
    """Whether the chain read back is the same, except for rounding."""
    try:
        read = chain_from(tomllib.loads(text))
    except (InputError, tomllib.TOMLDecodeError):
        return False
    names = ("radii", "masses", "velocities", "gaps", "contact_stiffness", "contact_exponents")
    alike = all(
        np.shape(a) == np.shape(b) and np.allclose(a, b, rtol=ROUNDING, atol=0.0)
        for a, b in ((getattr(read, name), getattr(chain, name)) for name in names)
    )
    return alike and _alike(read, chain)


def _alike(read: Chain, chain: Chain) -> bool:
    """Whether laws, supports, materials and walls are the same, except for rounding."""

    def numbers(each: Chain) -> list[float]:
        walls = [wall for wall in (each.left_wall, each.right_wall) if wall is not None]
        bodies = [*(each.materials or ()), *(wall.material for wall in walls)]
        values = [
            *(getattr(law, name) for law in each.contact_losses for name in law.parameters()),
            *(wall.gap for wall in walls), each.precompression, each.gravity,
            *(value for body in bodies if body is not None
              for value in (body.young, body.poisson, body.density, body.yield_strength)),
        ]  # fmt: skip
        return [np.nan if value is None else float(value) for value in values]

    def words(each: Chain) -> Sequence[object]:
        return each.held_by, each.strikers, [law.name for law in each.contact_losses]

    first, second = numbers(read), numbers(chain)
    return (
        words(read) == words(chain)
        and len(first) == len(second)
        and bool(np.allclose(first, second, rtol=ROUNDING, atol=0.0, equal_nan=True))
    )

"""Free parameters of a fit, by name: starts, bounds, priors, and names with wildcards."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from ..chain.chain import Chain
from ..errors import InputError, short_repr, unknown_name_error
from ..representation import listed
from ..traces.traces import Traces
from ..units import STANDARD_GRAVITY
from ..validation.numbers import number, real_numbers
from ..validation.objects import check_list
from .chain_parameters import (
    Kind,
    UnknownParameterError,
    kind_of,
    known_names,
    value_of,
)
from .gain_units import gains_in_si
from .law_parameters import loss_parameters
from .names import Name, parse_name, to_free
from .sensors import COMMON_ONLY, SENSOR_KINDS

# Numbers of balls in names.
DIGITS: Final = re.compile(r"[0-9]+")
TIME: Final = Kind("s", typical=1e-6, step=1e-2)
# Constants that determine the stiffness of Hertz contacts.
ELASTIC: Final = ("materials.young", "materials.poisson")
# Symbols of textbooks, and how the names that they stand for begin.
SYMBOLS: Final = {
    "E": "materials[", "young": "materials[", "modulus": "materials[", "k": "stiffness",
    "v": "struck_by", "v0": "struck_by", "velocity": "struck_by", "speed": "struck_by",
    "gap": "gap[", "gaps": "gap[", "radius": "radius[", "R": "radius[", "mass": "mass[",
    "m": "mass[", "t0": "time_offset", "loss": "loss.", "e": "loss.",
}  # fmt: skip
Priors = Mapping[str, tuple[float | str, float | str]]


@dataclass(frozen=True)
class Parameter:
    """A free parameter.

    Attributes
    ----------
    name : Name
        Its name.
    kind : Kind
        Unit, bounds and typical size.
    start : float
        Value from which a fit starts.
    prior : tuple of float or None
        Value and standard deviation from other measurements.
    """

    name: Name
    kind: Kind
    start: float
    prior: tuple[float, float] | None = None

    def __str__(self) -> str:
        return str(self.name)

    @property
    def shot(self) -> int | None:
        """Index of its shot; `None` for a parameter that all shots have in common."""
        return int(self.name.shot) - 1 if self.name.shot else None

    @property
    def of_chain(self) -> bool:
        """Whether the parameter belongs to the chain, not to the sensors or the clock."""
        return is_of_chain(self.name)


def is_of_chain(name: Name) -> bool:
    """Whether a parameter of this name belongs to the chain."""
    return name.key not in SENSOR_KINDS and name.key != "time_offset"


def default_names(traces: Traces, chain: Chain) -> list[str]:
    """Names of the parameters that are free by default."""
    each_shot = "@*" if len(traces.shots) > 1 else ""
    names = ["stiffness"]
    if "struck_by.velocity" in known_names(chain):
        names.append(f"struck_by.velocity{each_shot}")
    names += [f"loss.{name}" for name in loss_parameters(chain)]
    unknown = [k for k, shot in enumerate(traces.shots, start=1) if shot.clock is None]
    if len(unknown) == len(traces.shots):
        names.append(f"time_offset{each_shot}")
    else:
        names += [f"time_offset@{k}" for k in unknown]
    voltages = dict.fromkeys(signal.name for _, signal in traces if not signal.calibrated)
    return names + [f"gain[{name}]" for name in voltages]


def free_parameters(
    traces: Traces,
    chains: Sequence[Chain],
    free: Sequence[str] | None,
    priors: Priors,
    start: Mapping[str, float],
    optional: Collection[str] = (),
) -> list[Parameter]:
    """Check names, priors and starts, and return the parameters."""
    asked = default_names(traces, chains[0]) if free is None else check_list("free", free, "names")
    names: dict[Name, None] = {}
    for text in asked:
        for name in expanded(_parsed(text, traces, chains[0]), traces):
            if name in names:
                raise InputError(f"parameter {str(name)!r} is free twice; name it once")
            names[name] = None
    if not names:
        raise InputError("no parameter is free; name at least one, such as 'stiffness'")
    for name in names:
        kind_and_value(name, traces, chains)  # unknown names are reported before others
    known_priors = _checked_priors(priors, traces, chains, names, optional)
    _check_gains(names, traces)
    _check_moduli(names)
    starts = {}
    for text, value in start.items():
        for name in expanded(parse_name(text), traces):
            if name in names:
                unit = kind_and_value(name, traces, chains)[0].unit_of_text
                if name.key == "gain":
                    value = gains_in_si(f"start of {name}", value, name.item, traces)
                starts[name] = number(f"start of {name}", value, unit=unit)
            elif text not in optional:
                raise unknown_name_error("free parameter", str(name), map(str, names))
    exponent_free = any(name.key.endswith("exponent") for name in names)
    return [
        _parameter(name, traces, chains, known_priors.get(name), starts, exponent_free)
        for name in names
    ]


def _check_gains(names: Collection[Name], traces: Traces) -> None:
    """Raise `InputError` if the gain of a sensor without calibration is not free."""
    free = {(name.item, name.shot) for name in names if name.key == "gain"}
    fixed, others = dict[str, int](), dict[str, int]()
    for shot, signal in traces:
        ways = {(item, part) for item in ("", signal.name) for part in ("", str(shot + 1))}
        if not signal.calibrated and not free & ways:
            own = any(item == signal.name for item, _ in free)
            (others if own else fixed)[signal.name] = shot + 1
    if others:
        name, shot = next(iter(others.items()))
        raise InputError(
            f"the gain of {name} is free in some shots, but not in shot {shot}: free "
            f"'gain[{name}]' for all shots, or 'gain[{name}]@*' for each"
        )
    if fixed:
        these, gains = ("is", "its gain") if len(fixed) == 1 else ("are", "their gains")
        raise InputError(
            f"{listed([*fixed])} {these} in V without calibration, so {gains} must be free: "
            f"{to_free(['gain[*]'])}"
        )


def _check_moduli(names: Collection[Name]) -> None:
    """Raise `InputError` if constants of Hertz's law are free together with the exponent."""
    elastic = [f"'{name}'" for name in names if name.key in ELASTIC]
    if elastic and any(name.key == "exponent" for name in names):
        raise InputError(
            f"{listed(elastic)} cannot be free together with 'exponent', because materials "
            "determine the stiffness of Hertz contacts (exponent 1.5) only; free 'stiffness' "
            "instead"
        )


def _parsed(text: object, traces: Traces, chain: Chain) -> Name:
    """Parse the name of a free parameter; the error lists the names that exist."""
    meant = SYMBOLS.get(text, ()) if isinstance(text, str) else ()
    every = every_name(traces, chain)
    near = [name for name in every if name.startswith(meant)] if meant else []
    try:
        if not near or text in every:
            return parse_name(text)
    except InputError:
        if not isinstance(text, str):
            raise
    hint = f" (did you mean {near[0]!r}?)" if near else ""
    raise InputError(f"unknown parameter {short_repr(text)}{hint}: choose from {', '.join(every)}")


def every_name(traces: Traces, chain: Chain) -> list[str]:
    """Names of the parameters of a chain and its sensors, those of the sensors for the first."""
    first = traces.names[0]
    of_sensors = [name if name in COMMON_ONLY else f"{name}[{first}]" for name in SENSOR_KINDS]
    return [*known_names(chain), "time_offset", *of_sensors]


def _without_shot(name: Name, count: int) -> str:
    """That a parameter belongs to a shot that the data do not have."""
    advice = f"remove '@{name.shot}', or give the data of this shot"
    there = "is only one shot" if count == 1 else f"are only {count} shots"
    return f"{name} belongs to shot {name.shot}, but there {there}: {advice}"


def expanded(name: Name, traces: Traces) -> list[Name]:
    """Parameters to which a name refers; ``*`` denotes each shot or sensor."""
    count = len(traces.shots)
    shots = [name.shot]
    if name.shot == "*":
        shots = [str(k) for k in range(1, count + 1)] if count > 1 else [""]
    elif name.shot and not 1 <= int(name.shot) <= count:
        raise InputError(_without_shot(name, count))
    elif name.shot == "1" and count == 1:
        shots = [""]
    items = list(traces.names) if name.item == "*" else [name.item]
    return [Name(name.key, item, shot) for shot in shots for item in items]


def _check_height(text: object, given: object) -> None:
    """Reject the prior of a height of fall, and name that of the velocity, v^2 = 2 g h."""
    if not (isinstance(text, str) and text.partition("@")[0] == "struck_by.height"):
        return
    velocity = text.replace("height", "velocity")
    advice = (
        f"give {velocity!r} instead, with v = sqrt(2 g h) and the error v/(2 h) times that of h"
    )
    if isinstance(given, Sequence) and not isinstance(given, str) and len(given) == 2:
        height, error = (number(f"prior of {text}", each, unit="m", least=0.0) for each in given)
        if height > 0.0:
            speed = math.sqrt(2.0 * STANDARD_GRAVITY * height)
            advice = (
                f"give {velocity!r} with the value {speed:.4g} m/s and the error "
                f"{0.5 * speed * error / height:.2g} m/s instead, from v = sqrt(2 g h)"
            )
    raise InputError(f"a fit has no parameter for a height: {advice}")


def _checked_priors(
    priors: Priors,
    traces: Traces,
    chains: Sequence[Chain],
    names: Mapping[Name, None],
    optional: Collection[str],
) -> dict[Name, tuple[float, float]]:
    if not isinstance(priors, Mapping):
        raise InputError(
            "priors must be a mapping such as {'struck_by.velocity': (0.3, 0.003)}, got "
            f"{short_repr(priors)}"
        )
    found: dict[Name, tuple[float, float]] = {}
    for text, given in priors.items():
        _check_height(text, given)
        asked = [
            name for name in expanded(parse_name(text), traces)
            if name in names or text not in optional
        ]  # fmt: skip
        for name in asked:
            if name not in names:
                kind_and_value(name, traces, chains)  # unknown names are reported as such
                raise InputError(
                    f"{str(name)!r} has a prior but is not free: {to_free([name])}, or "
                    f"remove the prior; free are {', '.join(map(str, names))}"
                )
        if not asked:
            continue
        unit = kind_and_value(asked[0], traces, chains)[0].unit_of_text
        mean, sigma = _pair(text, given, asked, traces, unit)
        for name in asked:
            if name in found and abs(found[name][0] - mean) > 5.0 * (found[name][1] + sigma):
                raise InputError(
                    f"two priors of {str(name)!r} exclude each other: {found[name][0]:g} +- "
                    f"{found[name][1]:g} and {mean:g} +- {sigma:g}; keep one"
                )
            found[name] = mean, sigma
    return found


def _pair(
    text: str, given: Any, names: Sequence[Name], traces: Traces, unit: str | None
) -> tuple[float, float]:
    """Value and standard deviation of a prior."""
    for name in names:
        if name.key == "gain" and not isinstance(given, str):
            given = gains_in_si(f"prior of {text}", given, name.item, traces)
    pair = []
    if not isinstance(given, str):
        pair = real_numbers(f"prior of {text}", given, unit=unit).ravel().tolist()
    if len(pair) != 2 or not pair[1] > 0.0 or not math.isfinite(sum(pair)):
        raise InputError(
            f"the prior of {text!r} must be a value and its standard deviation > 0, such as "
            f"(0.3, 0.003), got {short_repr(given)}"
        )
    return pair[0], pair[1]


def priors_of_gains(priors: Priors, traces: Traces) -> dict[str, tuple[float, float]]:
    """Priors of the gains of sensors, by the name of the sensor."""
    found: dict[str, tuple[float, float]] = {}
    for text, given in priors.items():
        if (name := parse_name(text)).key == "gain":
            # A gain that all sensors have in common is that of each.
            every = Name("gain", name.item or "*", name.shot)
            asked = [each for each in expanded(every, traces) if each.item in traces.names]
            if asked:
                pair = _pair(text, given, asked, traces, SENSOR_KINDS["gain"].unit_of_text)
                found |= {each.item: pair for each in asked}
    return found


def _parameter(
    name: Name,
    traces: Traces,
    chains: Sequence[Chain],
    prior: tuple[float, float] | None,
    starts: Mapping[Name, float],
    exponent_free: bool,
) -> Parameter:
    kind, value = kind_and_value(name, traces, chains)
    if name.key.endswith("wall.stiffness") and exponent_free:
        kind = replace(kind, unit="N/m^p")
    if prior is not None:
        if _wrong_sign(kind, prior[0]):
            raise InputError(f"the prior of {name} must be {_allowed(kind)}, got {prior[0]:g}")
        if not kind.lower - 3.0 * prior[1] <= prior[0] <= kind.upper + 3.0 * prior[1]:
            raise InputError(
                f"the prior of {str(name)!r}, {prior[0]:g} +- {prior[1]:g}, and its bounds, "
                f"{kind.lower:g} to {kind.upper:g}, exclude each other; change the prior"
            )
        value = prior[0]
    if name in starts:
        value = starts[name]
        if not kind.lower <= value <= kind.upper or _wrong_sign(kind, value):
            raise InputError(f"the start of {name} must be {_allowed(kind)}, got {value:g}")
    return Parameter(name, kind, min(max(value, kind.lower), kind.upper), prior)


def _wrong_sign(kind: Kind, value: float) -> bool:
    return kind.factor and (value == 0.0 if kind.signed else value <= 0.0)


def _allowed(kind: Kind) -> str:
    """Values of a parameter, in words."""
    if kind.signed:
        return "other than 0"
    if math.isfinite(kind.lower) and math.isfinite(kind.upper):
        return f"from {kind.lower:g} to {kind.upper:g}"
    if kind.factor and not kind.lower > 0.0:
        return "above 0"
    return f"at least {kind.lower:g}" if math.isfinite(kind.lower) else f"at most {kind.upper:g}"


def kind_and_value(name: Name, traces: Traces, chains: Sequence[Chain]) -> tuple[Kind, float]:
    """Kind of a parameter, and its nominal value."""
    if name.key == "time_offset":
        return TIME, traces.shots[int(name.shot or 1) - 1].time_offset
    if name.key in SENSOR_KINDS:
        if name.item and (name.item not in traces.names or name.key in COMMON_ONLY):
            known = [f"{name.key}[{each}]" for each in traces.names]
            raise unknown_name_error(
                "parameter", str(name), known if name.key not in COMMON_ONLY else [name.key]
            )
        return SENSOR_KINDS[name.key], 1.0 if name.key == "gain" else 0.0
    chain = chains[int(name.shot) - 1 if name.shot else 0]
    try:
        return kind_of(chain, name), value_of(chain, name)
    except UnknownParameterError:
        # The parameters of the sensors are known, too.
        known = [_with_own_place(each, name, traces, chain) for each in every_name(traces, chain)]
        raise unknown_name_error("parameter", str(name), known) from None


def _with_own_place(known: str, name: Name, traces: Traces, chain: Chain) -> str:
    """A known name with the balls or the sensor of an unknown one instead of its example."""
    example = parse_name(known)
    if not name.item or DIGITS.sub("0", example.item) != DIGITS.sub("0", name.item):
        return known
    own = replace(example, item=name.item)
    if own.key in SENSOR_KINDS:
        return str(own) if own.item in traces.names else known
    try:
        value_of(chain, own)
    except InputError:
        return known  # There is no such ball.
    return str(own)

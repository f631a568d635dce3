"""Two names of a quantity: ``wall_force.peak`` of a run, and ``wall_peak_force`` of a column."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, Final

from ..errors import InputError, alternatives, names_meant, unknown_name_error
from .quantities import (
    BODY_QUANTITIES,
    FINAL_QUANTITIES,
    QUANTITIES,
    SENSOR_QUANTITIES,
    WALL_QUANTITIES,
)

# Full names, and those of the columns of tables, datasets and files.
_OF_RUNS: Final = {
    **{f"wall_force.{each.attribute}": name for name, each in WALL_QUANTITIES.items()},
    **{
        f"body_force.{name.removeprefix('body_').removesuffix('_force')}": name
        for name in BODY_QUANTITIES
    },
    **{
        f"sensor.{name.removeprefix('sensor_').replace('_so_far', '')}": name
        for name in SENSOR_QUANTITIES
    },
    **{name.replace("final_", "final."): name for name in FINAL_QUANTITIES if "final_" in name},
}
# The attributes of a `SensorForce` are accepted, too.
_ATTRIBUTES: Final = {
    f"sensor.{each.attribute}": name
    for name, each in SENSOR_QUANTITIES.items()
    if f"sensor.{each.attribute}" not in _OF_RUNS
}
COLUMNS: Final[Mapping[str, str]] = MappingProxyType(
    {**_OF_RUNS, **_ATTRIBUTES, **{f"pulse.{name}": name for name in QUANTITIES}}
)
_FULL_NAMES: Final = {column: name for name, column in _OF_RUNS.items()}
_FULL_NAMES.update({name: _FULL_NAMES[column] for name, column in _ATTRIBUTES.items()})


def column_name(name: Any) -> Any:
    """Name of the column of a quantity; anything else is returned unchanged."""
    return COLUMNS.get(name, name) if isinstance(name, str) else name


def full_name(name: str) -> str:
    """Name of a quantity of a wall, a body, a sensor or the last state, from another name of it."""
    return _FULL_NAMES.get(name, name)


def unknown_quantity_error(name: object, known: Sequence[str]) -> InputError:
    """Error for an unknown quantity, with the full names of those that are known."""
    full = [*map(full_name, known)]
    return unknown_name_error("quantity", name, full, meant=full_names_meant(name, known))


def full_names_meant(name: object, known: Sequence[str]) -> str:
    """Full names that an unknown one may mean, from both names of each quantity."""
    near = names_meant(name, dict.fromkeys([*map(full_name, known), *known]))
    return alternatives(dict.fromkeys(map(full_name, near)))

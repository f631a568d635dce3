"""Derivatives of simulated quantities by central differences, for laws without exact ones."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..chain.chain import Chain
from ..chain.walls import Wall
from ..collision import Array
from ..errors import InputError, ModelRangeWarning, SimulationError
from ..pulse.quantity_names import COLUMNS
from ..recorded_warnings import ignore_warnings
from ..simulation.run_table import RunTable
from ..simulation.simulate_many import tabulate_runs
from ..validation.objects import Progress
from .equation import is_linear
from .kinks import PART, mislead
from .names import Name
from .parameters import MATERIAL
from .relative import value_of_parameter

# Relative step, and tolerance.  Derivatives of forces, velocities and arrivals of 12 steel balls
# that yield change by 1e-5 to 1e-4 of the largest one if the step is a third of it; with steps
# below 1e-4, errors of the integration dominate.
STEP, RTOL = 1e-3, 1e-9
# A second step, twice as large, shows the error, and a large one the kinks.
STEPS: Final = (STEP, 2.0 * STEP, PART)
FACTORS: Final = tuple(1.0 + sign * step for step in STEPS for sign in (1, -1))
FIELDS: Final = ("radii", "masses", "stiffness", "velocities")


@dataclass(frozen=True, eq=False)
class Differences:
    """Derivatives of a quantity by differences with two steps."""

    value: float
    slopes: dict[str, Array]
    # Those with the larger step.
    others: dict[str, Array]
    # Parameters of which a change by 1% has another effect.
    kinks: tuple[str, ...]

    def relative_error(self, found: Mapping[str, Array]) -> float:
        """Largest difference between both steps, relative to the largest derivative of an array."""
        errors = [RTOL / STEP]
        for name, values in found.items():
            known = np.isfinite(values)
            if known.any() and (largest := float(np.abs(values[known]).max())) > 0.0:
                errors.append(float(np.abs(values - self.others[name])[known].max()) / largest)
        return max(errors) if math.isfinite(self.value) else math.nan


def needs_differences(chain: Chain) -> bool:
    """Whether the force of a contact is not linear in its closing speed."""
    return chain.drive is None and not all(map(is_linear, chain.contact_losses))


def differences(
    chain: Chain, names: Sequence[Name], to: Sequence[str], *, until: float | None,
    rtol: float | None, max_steps: int | None, progress: Progress | None,
) -> tuple[list[Differences], Array]:  # fmt: skip
    """Simulate a chain and six others for each entry of the parameters that is not 0.

    Returns derivatives of each quantity, and the largest overlaps of the chain.
    """
    columns = [_column(name) for name in names]
    places = {each: np.flatnonzero(_entries(chain, each)) for each in to}
    chains = [
        changed(chain, each, int(k), factor)
        for factor in FACTORS for each, some in places.items() for k in some
    ]  # fmt: skip
    sensors = sorted({name.bead for name in names if name.group == "sensor" and name.bead})
    options: dict[str, Any] = {"keep": columns, "sensors": sensors, "until": until,
                               "rtol": rtol or RTOL, "max_steps": max_steps}  # fmt: skip
    with ignore_warnings(ModelRangeWarning):
        # Each chain would warn.
        own = tabulate_runs([chain], **options)
        if own.reasons:
            raise SimulationError(own.reasons[0])
        others = tabulate_runs(chains, check_range=False, progress=progress, **options)
    found = []
    for name, column in zip(names, columns, strict=True):
        values = [_values(table, name, column) for table in (own, others)]
        found.append(_differences(chain, places, float(values[0][0]), values[1]))
    return found, own._overlaps[0]


def _column(name: Name) -> str:
    """Name of a quantity in tables of simulations."""
    column = COLUMNS.get(f"{name.group}.{name.item}")
    if column is None:
        raise InputError(
            f"{name} has exact derivatives only, which this loss does not permit; use "
            "wall_force.peak or a quantity of the leading pulse, such as velocity@last"
        )
    return column


def _entries(chain: Chain, name: str) -> Array:
    """Values of a parameter of each bead or contact; others have no differences."""
    if name not in (*FIELDS, *MATERIAL):
        raise InputError(
            f"{name} has exact derivatives only, which this loss does not permit; use "
            f"{', '.join((*FIELDS, *MATERIAL))}, or change it in separate simulations"
        )
    # Materials without a known yield strength have no contacts that yield.
    return np.nan_to_num(value_of_parameter(chain, name))


def changed(chain: Chain, name: str, index: int, factor: float) -> Chain:
    """The chain with one entry of a parameter multiplied by a factor."""
    if name in FIELDS:
        values = getattr(chain, name).copy()
        values[index] *= factor
        walls = _walls_of_known_stiffness(chain) if name == "stiffness" else {}
        return chain.replace(**{name: values}, **walls)
    assert chain.materials is not None
    materials = list(chain.materials)
    own = materials[index]
    materials[index] = replace(own, **{name: factor * getattr(own, name)})
    return chain.replace(materials=materials)


def _walls_of_known_stiffness(chain: Chain) -> dict[str, Wall]:
    """Walls with their present stiffness, which scaled chains of given stiffness do not imply."""
    walls = {"left_wall": (chain.left_wall, 0), "right_wall": (chain.right_wall, -1)}
    return {
        name: replace(wall, stiffness=float(chain.contact_stiffness[contact]))
        for name, (wall, contact) in walls.items() if chain.scaled and wall is not None
    }  # fmt: skip


def _values(table: RunTable, name: Name, column: str) -> Array:
    """Values of a quantity in all chains."""
    values = table[column]
    if values.ndim == 1:
        return values
    assert name.bead is not None
    place = table.sensors.index(name.bead) if name.group == "sensor" else name.bead - 1
    return np.asarray(values[:, place])


def _differences(
    chain: Chain, places: Mapping[str, NDArray[np.int64]], value: float, values: Array
) -> Differences:
    """Derivatives from the values of the chain and of the others, in their order."""
    blocks = values.reshape(len(STEPS), 2, -1)
    begins = np.cumsum([0, *(len(some) for some in places.values())])
    kept: tuple[dict[str, Array], dict[str, Array]] = ({}, {})
    kinks = []
    for (name, some), begin in zip(places.items(), begins, strict=False):
        own, part = value_of_parameter(chain, name), blocks[:, :, begin : begin + len(some)]
        for slopes, (larger, smaller), step in zip(kept, part, STEPS, strict=False):
            slopes[name] = np.full(own.shape, math.nan)
            slopes[name][some] = (larger - smaller) / (2.0 * step) / own[some]
        if len(some) and mislead(PART * own[some] * kept[0][name][some], *(part[2] - value)):
            kinks.append(name)
    return Differences(value, *kept, tuple(kinks))

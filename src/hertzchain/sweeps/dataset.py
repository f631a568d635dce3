"""The dataset of a sweep: its variables, coordinates and attributes, and a store in memory."""

from __future__ import annotations

import platform
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import __version__
from ..chain.hertz_ratios import CONTACTS_YIELD
from ..chain.stiff_walls import TOO_STIFF
from ..errors import IncompleteWarning, ModelRangeWarning, warn_user
from ..pulse.quantities import BODY_QUANTITIES
from ..simulation.sensor_force import HALF
from ..store.sweep_layout import STATUS, Variable
from ..store.sweep_store import FAILED, MEANINGS, plain_text
from .assumed_yield import assumed_by
from .axes import Axis
from .batches import Result
from .free_faces import has_free_face
from .kept import PER_PLACE, PER_RUN
from .placed import REFLECTION, placed
from .plan import Plan

if TYPE_CHECKING:
    import xarray as xr


class MemoryStore:
    """Results in memory, for sweeps without a store on disk."""

    def __init__(self, variables: Mapping[str, Variable], attributes: Mapping[str, Any]) -> None:
        self.variables, self.attributes = variables, attributes
        self.arrays = {name: _empty_array(variable) for name, variable in variables.items()}

    def write(self, batch: int, region: tuple[slice, ...], columns: Mapping[str, Any]) -> None:
        """Write a batch."""
        del batch
        sizes = tuple(part.stop - part.start for part in region)
        for name, values in columns.items():
            target = self.arrays[name]
            target[region] = np.asarray(values).reshape(sizes + target.shape[len(region) :])

    def open(self) -> xr.Dataset:
        """All results as a dataset."""
        import xarray as xr

        kept: dict[str, Any] = {}
        coordinates: dict[str, Any] = {}
        for name, variable in self.variables.items():
            group = kept if variable.values is None else coordinates
            group[name] = variable.dimensions, self.arrays[name], dict(variable.attributes)
        return plain_text(xr.Dataset(kept, coords=coordinates, attrs=self.attributes))


def _empty_array(variable: Variable) -> Any:
    if variable.values is not None:
        return variable.values
    if variable.dtype == "str":
        return np.full(variable.shape, "", np.dtypes.StringDType())
    return np.full(variable.shape, np.nan if variable.dtype == "f8" else 0, variable.dtype)


def variables_of(plan: Plan) -> dict[str, Variable]:
    """Arrays of the dataset of a sweep, by name."""
    return batch_variables(plan) | _coordinates(plan)


def bytes_of(plan: Plan) -> int:
    """Number of bytes of all results of a sweep, without text and coordinates."""
    return sum(variable.size for variable in batch_variables(plan).values())


def batch_variables(plan: Plan) -> dict[str, Variable]:
    """Arrays of which each batch writes a part, by name."""
    found = {name: _kept(plan, name) for name in plan.variables}
    if plan.may_be_outside_range:
        label = {"long_name": "1 where the method is used outside its range"}
        found["outside_range"] = _by_method(plan, "i1", label)
    if may_end := _may_end_too_early(plan):
        label = {"long_name": f"1 where {' or '.join(may_end)}"}
        found["incomplete"] = _by_method(plan, "i1", label)
    if plan.keeps_wall:
        label = {
            "long_name": "1 where the largest force on the wall may be sensitive to small changes"
        }
        found["sensitive"] = _by_method(plan, "i1", label)
    label = {
        "long_name": "why the method failed, or why values are missing or inaccurate; "
        "otherwise empty"
    }
    found["reason"] = _by_method(plan, "str", label)
    if plan.ragged:
        count = {"long_name": "number of beads"}
        found["beads"] = Variable(plan.dimensions, plan.shape, plan.block, "i8", count)
    # The status is written last wherever variables are written in order.
    found[STATUS] = _by_method(plan, "i1", {
        "long_name": "status of the point",
        "flag_values": list(range(len(MEANINGS))), "flag_meanings": " ".join(MEANINGS),
    })  # fmt: skip
    return found


def _may_end_too_early(plan: Plan) -> list[str]:
    """Kept quantities that are incomplete if a run ends too early, as clauses."""
    kept = plan.specification.keep
    found = {
        "the largest force on the wall is incomplete": plan.keeps_wall,
        "the largest force on the cap is incomplete": any(each in BODY_QUANTITIES for each in kept),
        "waves have not passed the contacts of a reflection": any(
            (at := placed(each)) is not None and at.column in REFLECTION for each in kept
        ),
    }
    return [words for words, possible in found.items() if possible]


def _by_method(plan: Plan, dtype: str, attributes: dict[str, Any]) -> Variable:
    """A variable with one value for each point and method."""
    methods = len(plan.specification.methods)
    return Variable(
        (*plan.dimensions, "approach"),
        (*plan.shape, methods),
        (*plan.block, methods),
        dtype,
        attributes,
    )


def attributes_of(plan: Plan) -> dict[str, str]:
    """Attributes of the dataset: the specification and the versions of packages."""
    assumed = assumed_by(plan)
    return {
        "title": plan.specification.title,
        "units": plan.units,
        **({"yield_pressure": assumed} if assumed else {}),
        "specification": plan.specification.as_json(),
        "hertzchain_version": __version__,
        "python_version": platform.python_version(),
        **{f"{name}_version": version(name) for name in ("numpy", "numba", "scipy", "zarr")},
    }


def columns_of(plan: Plan, result: Result) -> Mapping[str, Any]:
    """Arrays of one batch, by the name of their variable."""
    columns = {**result.columns, STATUS: result.status}
    if any(any(reasons) for reasons in result.reason):
        columns["reason"] = np.array(result.reason, dtype=np.dtypes.StringDType())
    if plan.may_be_outside_range:
        columns["outside_range"] = result.outside_range
    if _may_end_too_early(plan):
        columns["incomplete"] = result.incomplete
    if plan.keeps_wall:
        columns["sensitive"] = result.sensitive
    if plan.ragged:
        columns["beads"] = result.beads
    return columns


def _kept(plan: Plan, name: str) -> Variable:
    spec = plan.specification
    if name in PER_RUN:
        return _by_method(plan, "f8", PER_RUN[name].attributes(plan.units))
    if (at := placed(name)) is not None:
        attributes = at.quantity.attributes(plan.units)
        label = f"{attributes['long_name']}, {at.where}"
        half = {"free_face": HALF} if has_free_face(plan, at) else {}
        return _by_method(plan, "f8", {**attributes, "long_name": label, **half})
    if name.startswith("worst_error_of_"):
        what = name.removeprefix("worst_error_of_")
        label = f"largest error of {what} relative to {spec.reference}, k >= 2"
        return _by_method(plan, "f8", {"long_name": label})
    quantity = PER_PLACE[name.removeprefix("relative_error_of_")]
    attributes = quantity.attributes(plan.units)
    if name not in PER_PLACE:
        label = f"error of {quantity.name} relative to {spec.reference}"
        attributes = {"long_name": label}
    one = _by_method(plan, "f8", attributes)
    if spec.at == "last":
        return one
    beads = len(_beads_kept(plan, contact=quantity.per == "contact"))
    return replace(
        one, dimensions=(*one.dimensions, quantity.per), shape=(*one.shape, beads),
        chunk=(*one.chunk, beads),
    )  # fmt: skip


def _beads_kept(plan: Plan, *, contact: bool) -> Sequence[int]:
    at = plan.specification.at
    return at if isinstance(at, tuple) else range(1, plan.longest + 1 - contact)


def _coordinates(plan: Plan) -> dict[str, Variable]:
    spec = plan.specification
    methods = np.array(spec.methods, dtype=np.dtypes.StringDType())
    found = {"approach": _coordinate("approach", methods, {"long_name": "method"})}
    for name, axis in zip(plan.names, spec.axes, strict=True):
        along = "point" if plan.zipped else name
        found[name] = _coordinate(along, axis.coordinate(), _axis_labels(axis, plan))
    if plan.zipped:
        numbers = np.arange(1, plan.points + 1)
        found["point"] = _coordinate("point", numbers, {"long_name": "number of the point"})
    for along in ("bead", "contact"):
        if any(along in _kept(plan, name).dimensions for name in plan.variables):
            numbers = np.asarray(_beads_kept(plan, contact=along == "contact"))
            found[along] = _coordinate(along, numbers, {"long_name": f"{along} k, from 1"})
    return found


def _axis_labels(axis: Axis, plan: Plan) -> dict[str, str]:
    labels = {"long_name": axis.long_name}
    if axis.coordinate().dtype.kind in "if":
        known = axis.si_unit if plan.units == "SI" else None
        if unit := axis.unit or known:
            labels["units"] = unit
    return labels


def _coordinate(along: str, values: np.ndarray[Any, Any], attributes: dict[str, Any]) -> Variable:
    dtype = {"i": "i8", "f": "f8"}.get(values.dtype.kind, "str")
    return Variable((along,), values.shape, values.shape, dtype, attributes, values)


def warn_outside_range(found: xr.Dataset) -> None:
    """Warn once if points are outside the range of a method or of Hertz's law, or of a spring."""
    reasons = found.reason.values.astype("T")
    stiff, yielding = (
        int((np.strings.find(reasons, words) >= 0).sum()) for words in (TOO_STIFF, CONTACTS_YIELD)
    )
    if stiff:
        warn_user(
            f"at {stiff} of {found.reason.size} points, the spring of a {TOO_STIFF} (see variable "
            "reason)",
            ModelRangeWarning,
        )
    if "outside_range" not in found:
        return
    outside = int((found["outside_range"] == 1).sum())
    if outside:
        warn_user(
            f"{outside} of {found['outside_range'].size} points are outside the validity range of "
            "a method or of Hertz's law (variable outside_range)"
            + f"; at {yielding}, {CONTACTS_YIELD} (variable reason)"
            * bool(yielding),
            ModelRangeWarning,
        )


def warn_failures(found: xr.Dataset) -> None:
    """Warn once if points failed, with the first reason."""
    failed = found.status.values == FAILED
    points = int(failed.any(axis=-1).sum())
    if points:
        first = dict(zip(found.status.dims, np.argwhere(failed)[0], strict=True))
        at = found.reason.isel(first)
        place = ", ".join(f"{name} = {value.item()}" for name, value in at.coords.items())
        warn_user(
            f"{points} of {failed[..., 0].size} points failed (status {FAILED}, values NaN, see "
            f"variable reason), the first at {place}: {at.item()}",
            IncompleteWarning,
        )

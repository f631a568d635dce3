"""What the store of a sweep holds: its variables, coordinates and attributes."""

from __future__ import annotations

import platform
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from typing import Any

import numpy as np

from hertzchain import __version__
from hertzchain.pulse.quantities import PER_CONTACT, QUANTITIES, SI_UNITS, Quantity
from hertzchain.store.sweep_layout import STATUS, Variable
from hertzchain.store.sweep_store import MEANINGS
from hertzchain.sweeps.axes import Axis
from hertzchain.sweeps.plan import Plan
from hertzchain.sweeps.specification import WALL_QUANTITIES
from hertzchain.sweeps.work import Result
from hertzchain.units import UNITS


def variables_of(plan: Plan) -> dict[str, Variable]:
    """Arrays of the store of a sweep, by name.

    Parameters
    ----------
    plan : Plan
        What is swept.

    Returns
    -------
    dict of str to Variable

    Examples
    --------
    >>> from hertzchain.sweeps.reading import read_specification
    >>> chain, axes = {"taper": "uniform"}, {"beads": [20, 40]}
    >>> found = variables_of(Plan(read_specification({"chain": chain, "axes": axes})))
    >>> found["velocity"].dimensions, found["velocity"].shape
    (('beads', 'by', 'bead'), (2, 1, 40))
    """
    return _by_batch(plan) | _coordinates(plan)


def bytes_of(plan: Plan) -> int:
    """Bytes of all results of a sweep, text and coordinates left out.

    Parameters
    ----------
    plan : Plan
        What is swept.

    Returns
    -------
    int

    Examples
    --------
    >>> from hertzchain.sweeps.reading import read_specification
    >>> chain, axes = {"taper": "uniform"}, {"beads": [20, 40]}
    >>> bytes_of(Plan(read_specification({"chain": chain, "axes": axes})))
    642
    """
    return sum(variable.size for variable in _by_batch(plan).values())


def _by_batch(plan: Plan) -> dict[str, Variable]:
    found = {name: _kept(plan, name) for name in plan.variables}
    if plan.judged:
        said = {"long_name": "1 where the method says it is outside its range"}
        found["outside_range"] = _by_method(plan, "i1", said)
    if plan.walled:
        said = {"long_name": "1 where the largest force on the wall is not complete"}
        found["incomplete"] = _by_method(plan, "i1", said)
    why = {"long_name": "why the method failed, or values are missing; empty if neither"}
    found["reason"] = _by_method(plan, "str", why)
    if plan.ragged:
        count = {"long_name": "number of beads", "units": "1"}
        found["beads"] = Variable(plan.dimensions, plan.shape, plan.block, "i8", count)
    # The status goes last wherever they are written in order.
    found[STATUS] = _by_method(plan, "i1", {
        "long_name": "what became of the point",
        "flag_values": list(range(len(MEANINGS))), "flag_meanings": " ".join(MEANINGS),
    })  # fmt: skip
    return found


def _by_method(plan: Plan, dtype: str, attributes: dict[str, Any]) -> Variable:
    """One value for each point and method."""
    methods = len(plan.specification.methods)
    return Variable(
        (*plan.dimensions, "by"), (*plan.shape, methods), (*plan.block, methods), dtype, attributes
    )


def attributes_of(plan: Plan) -> dict[str, str]:
    """Attributes of the dataset: the whole specification and the versions.

    Parameters
    ----------
    plan : Plan
        What is swept.

    Returns
    -------
    dict of str to str

    Examples
    --------
    >>> from hertzchain.sweeps.reading import read_specification
    >>> chain, axes = {"taper": "uniform"}, {"beads": [20, 40]}
    >>> attributes_of(Plan(read_specification({"chain": chain, "axes": axes})))["units"]
    'scaled'
    """
    return {
        "title": plan.specification.title,
        "units": plan.units,
        "specification": plan.specification.as_json(),
        "hertzchain_version": __version__,
        "python_version": platform.python_version(),
        **{f"{name}_version": version(name) for name in ("numpy", "numba", "scipy", "zarr")},
    }


def columns_of(plan: Plan, result: Result) -> Mapping[str, Any]:
    """The arrays of one batch, as the store takes them.

    Parameters
    ----------
    plan : Plan
        What is swept.
    result : Result
        What the batch gave.

    Returns
    -------
    mapping of str to array_like

    Examples
    --------
    >>> from hertzchain.sweeps.reading import read_specification
    >>> from hertzchain.sweeps.work import run_batch
    >>> chain, axes = {"taper": "uniform"}, {"beads": [20, 40]}
    >>> plan = Plan(read_specification({"chain": chain, "axes": axes}))
    >>> sorted(columns_of(plan, run_batch(plan.specification.as_json(), 0)))
    ['status', 'velocity']
    """
    columns = {**result.columns, STATUS: result.status}
    if any(any(reasons) for reasons in result.reason):
        columns["reason"] = np.array(result.reason, dtype=np.dtypes.StringDType())
    if plan.judged:
        columns["outside_range"] = result.outside_range
    if plan.walled:
        columns["incomplete"] = result.incomplete
    if plan.ragged:
        columns["beads"] = result.beads
    return columns


def _kept(plan: Plan, name: str) -> Variable:
    spec, si = plan.specification, plan.units == "SI"
    if name in WALL_QUANTITIES:
        _, what, unit = WALL_QUANTITIES[name]
        attributes = {"long_name": what, "units": unit if si else "1"}
        return _by_method(plan, "f8", attributes)
    if name.startswith("worst_error_of_"):
        what = name.removeprefix("worst_error_of_")
        told = f"largest relative error of {what}, k >= 2, against {spec.reference}"
        return _by_method(plan, "f8", {"long_name": told, "units": "1"})
    quantity: Quantity = name.removeprefix("relative_error_of_")  # type: ignore[assignment]
    if name in QUANTITIES:
        symbol, description = QUANTITIES[quantity]
        attributes = {"long_name": description, "symbol": symbol}
        attributes["units"] = SI_UNITS[quantity] if si else "1"
    else:
        told = f"relative error of {quantity} against {spec.reference}"
        attributes = {"long_name": told, "units": "1"}
    one = _by_method(plan, "f8", attributes)
    if spec.at == "last":
        return one
    beads = len(_beads_kept(plan, contact=quantity in PER_CONTACT))
    along = "contact" if quantity in PER_CONTACT else "bead"
    return replace(
        one, dimensions=(*one.dimensions, along), shape=(*one.shape, beads),
        chunk=(*one.chunk, beads),
    )  # fmt: skip


def _beads_kept(plan: Plan, *, contact: bool) -> Sequence[int]:
    at = plan.specification.at
    return at if isinstance(at, tuple) else range(1, plan.longest + 1 - contact)


def _coordinates(plan: Plan) -> dict[str, Variable]:
    spec = plan.specification
    methods = np.array(spec.methods, dtype=np.dtypes.StringDType())
    found = {"by": _coordinate("by", methods, {"long_name": "method"})}
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
        known = axis.dimension if plan.units == "SI" else None
        labels["units"] = UNITS[known][0] if known else "1"
    return labels


def _coordinate(along: str, values: np.ndarray[Any, Any], attributes: dict[str, Any]) -> Variable:
    dtype = {"i": "i8", "f": "f8"}.get(values.dtype.kind, "str")
    return Variable((along,), values.shape, values.shape, dtype, attributes, values)

"""Results of fits and forecasts as JSON documents and as labelled datasets."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ..collision import Array
from ..validation.json_types import finite
from .constants import FixedConstant
from .model import Model
from .shown_values import unit_of_parameter

if TYPE_CHECKING:
    import xarray as xr

    from .result import FitResult


def parameters_document(model: Model, values: Array, errors: Array) -> dict[str, Any]:
    """Value, error and unit of each parameter."""
    triples = zip(model.parameters, values, errors, strict=True)
    return {
        str(each): {"value": value, "error": error, "unit": unit_of_parameter(each, model.traces)}
        for each, value, error in triples
    }


def constants_document(constants: Sequence[FixedConstant]) -> list[dict[str, Any]]:
    """Changes of the parameters per 1% of each constant that is taken as exact."""
    return [{"name": each.name, "changes_per_percent": each.changes} for each in constants]


def result_document(result: FitResult) -> dict[str, Any]:
    """Plain values; numbers that do not exist are `None`."""
    found: dict[str, Any] = finite({
        "parameters": parameters_document(result.model, result.estimates, result.sigmas),
        "correlation": result.correlation.tolist(),
        "restitution": result.restitution and result.restitution.as_dict(),
        "chi2": result.chi2, "degrees_of_freedom": result.goodness.freedom,
        "samples": result.goodness.samples,
        "effective_samples": result.goodness.effective_samples,
        "bic": result.bic(), "converged": result.converged, "reason": result.reason,
        "chi2_per_sample": result.chi2_per_sample,
        "describes": result.describes, "explained": result.explained,
        "undetermined": list(result.undetermined),
        "held_by_priors": [each.as_dict() for each in result.held],
        "prior_deviations": result.prior_deviations,
        "prior_conflict": result.prior_conflict,
        "without_priors": [each.as_dict() for each in result.without_priors],
        "warnings": list(result.warnings),
        "effects": [
            dataclasses.asdict(each) | {"present": each.present} for each in result.effects
        ],
        "constants": constants_document(result.constants),
        "simulations": result.simulations,
    })  # fmt: skip
    return found


def result_dataset(result: FitResult) -> xr.Dataset:
    """Data, fit, and values with errors, units and correlations."""
    data = result.traces.to_xarray()
    names = list(data.data_vars)
    flat = [each for shot in result.predicted for each in shot]
    for name, fitted in zip(names, flat, strict=True):
        data[f"{name}_fit"] = (data[name].dims, fitted, data[name].attrs)
    data = data.assign_coords(parameter=list(result.names), other_parameter=list(result.names))
    data["value"] = ("parameter", result.estimates)
    data["error"] = ("parameter", result.sigmas)
    data["correlation"] = (("parameter", "other_parameter"), result.correlation)
    units = [unit_of_parameter(each, result.traces) for each in result.model.parameters]
    data = data.assign_coords(unit=("parameter", units))
    return data.assign_attrs(
        chi2=result.chi2, bic=result.bic(), describes=int(result.describes), verdict=result.verdict
    )

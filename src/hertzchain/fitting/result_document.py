"""Results of fits and forecasts as JSON documents."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ..collision import Array
from ..validation.json_types import finite
from .constants import FixedConstant

if TYPE_CHECKING:
    from .result import FitResult


def parameters_document(names: Sequence[str], values: Array, errors: Array) -> dict[str, Any]:
    """Value and error of each parameter."""
    triples = zip(names, values, errors, strict=True)
    return {name: {"value": value, "error": error} for name, value, error in triples}


def constants_document(constants: Sequence[FixedConstant]) -> list[dict[str, Any]]:
    """Changes of the parameters per 1% of each constant that is taken as exact."""
    return [{"name": each.name, "changes_per_percent": each.changes} for each in constants]


def result_document(result: FitResult) -> dict[str, Any]:
    """Plain values; numbers that do not exist are `None`."""
    found: dict[str, Any] = finite({
        "parameters": parameters_document(result.names, result.estimates, result.sigmas),
        "correlation": result.correlation.tolist(),
        "chi2": result.chi2, "degrees_of_freedom": result.goodness.freedom,
        "samples": result.goodness.samples,
        "effective_samples": result.goodness.effective_samples,
        "bic": result.bic(), "converged": result.converged, "reason": result.reason,
        "chi2_per_sample": result.chi2_per_sample,
        "describes": result.describes, "prior_deviations": result.prior_deviations,
        "prior_conflict": result.prior_conflict, "warnings": list(result.warnings),
        "effects": [
            dataclasses.asdict(each) | {"present": each.present} for each in result.effects
        ],
        "constants": constants_document(result.constants),
        "simulations": result.simulations,
    })  # fmt: skip
    return found

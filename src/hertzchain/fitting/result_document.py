"""The result of a fit as a JSON document."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

from ..validation.json_types import finite

if TYPE_CHECKING:
    from .result import FitResult


def result_document(result: FitResult) -> dict[str, Any]:
    """Plain values; numbers that do not exist are `None`."""
    found: dict[str, Any] = finite({
        "parameters": {
            name: {"value": value, "error": error}
            for name, value, error in zip(
                result.names, result.estimates, result.sigmas, strict=True
            )
        },
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
        "constants": [
            {"name": each.name, "changes_per_percent": each.changes} for each in result.constants
        ],
        "simulations": result.simulations,
    })  # fmt: skip
    return found

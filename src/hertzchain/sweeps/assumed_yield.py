"""The yield pressure that the chains of a sweep assume."""

from __future__ import annotations

from ..chain.laws.elastic_plastic import ElasticPlastic
from ..chain.yield_pressure import ASSUMED_PRESSURE, assumes_pressure
from .plan import Plan, tried_chains


def assumed_by(plan: Plan) -> str:
    """That chains of a sweep yield at an assumed pressure; empty if it is given."""
    if f'"{ElasticPlastic.name}' not in plan.specification.as_json():
        return ""  # no chain needs to be made
    return ASSUMED_PRESSURE if any(map(assumes_pressure, tried_chains(plan))) else ""

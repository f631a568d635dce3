"""The result of a design as a chain file, a table of beads, plain types and a dataset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..chain.chain import Chain
from ..store.chain_as_toml import chain_as_toml, chain_document
from ..validation.json_types import finite
from .allowed_sizes import at_bounds
from .compared_in_words import reference_remarks
from .comparison import (
    GIVEN,
    better_if_yielding,
    compared,
    compared_chains,
    equal_balls,
    objective_if_yielding,
    references_in_words,
)
from .ends_of_search import no_better, not_met_with_given
from .limits_if_yielding import (
    met_if_yielding,
    violated_if_fully_plastic,
    violated_only_if_yielding,
)
from .measures import Measure
from .sizes_in_words import order_in_words

if TYPE_CHECKING:
    import xarray as xr

    from .result import DesignResult
    from .verified import Verified


def chain_text(result: DesignResult) -> str:
    """Chain file of the result."""
    return chain_as_toml(result.chain) + "\n"


def bead_table(chain: Chain) -> str:
    """CSV with one row per bead, which `hertzchain.load_chain` reads; without a cap."""
    if chain.cap is not None:
        chain = chain.replace(precompression=0.0)[:-1]
    si = chain.units == "SI"
    columns = {"bead": [str(k) for k in range(1, chain.beads + 1)]}
    name, factor = ("diameter [mm]", 2e3) if si else ("radius", 1.0)
    columns[name] = [f"{factor * each:.10g}" for each in chain.radii]
    if not chain._follows("masses").all():
        name, factor = ("mass [g]", 1e3) if si else ("mass", 1.0)
        columns[name] = [f"{factor * each:.10g}" for each in chain.masses]
    if si and chain.materials is not None:
        columns["material"] = [each.name for each in chain.materials]
    rows = [",".join(columns), *map(",".join, zip(*columns.values(), strict=True))]
    return "\n".join(rows) + "\n"


def _balls(result: DesignResult) -> dict[str, Any]:
    """Beads in their order, parts, and the chain as the tables of a chain file."""
    parts = [
        {"count": count, "ball": name, "price": price}
        for (count, name), price in zip(result.parts, result.part_prices, strict=True)
    ]
    return _beads(result.chain) | {"parts": parts}


def _beads(chain: Chain) -> dict[str, Any]:
    """Beads in their order, and the chain as the tables of a chain file."""
    return {
        "radii": chain.radii.tolist(),
        "masses": chain.masses.tolist(),
        "materials": None if chain.materials is None else [each.name for each in chain.materials],
        "chain_file": chain_document(chain),
    }


def _range_of_yield(found: Verified) -> dict[str, Any]:
    """Whether the values with contacts that yield are within the range of their law."""
    if not found.yields:
        return {"yielding_overlap_ratio": None, "yielding_within_range": None}
    return {
        "yielding_overlap_ratio": found.yielding_overlap_ratio,
        "yielding_within_range": not found.yielding_outside_range,
    }


def _fully_plastic(found: Verified) -> dict[str, Any] | None:
    """Values at the largest possible yield pressure, if a smaller one is assumed."""
    harder = found.fully_plastic
    if harder is None:
        return None
    return {
        "values": dict(harder.values),
        "overlap_ratio": harder.overlap_ratio,
        "within_range": not harder.outside_range,
        "peak_of_second_hit": harder.second_peak,
    }


def _reference(result: DesignResult, found: Verified, balls: str = "") -> dict[str, Any]:
    """A chain to compare with, and whether contacts that yield reverse the comparison."""
    both = compared(result, found)
    return {
        "value": both.value,
        "value_with_yielding_contacts": both.value_if_yielding,
        "yielding_reverses_comparison": both.reversed if both.within_range else None,
        **_range_of_yield(found),
        "at_fully_plastic_pressure": _fully_plastic(found),
        "constraints_met": both.met,
        "constraints_not_met_with_yielding_contacts": [
            str(each) for each in violated_only_if_yielding(result.problem, found)
        ],
        "remarks": reference_remarks(result, found),
        "scattered": dict(found.scattered),
        "peak_of_second_hit": found.second_peak,
        "balls": balls or None,
        "chain_file": chain_document(found.chain),
    }


def _better_if_yielding(result: DesignResult) -> dict[str, Any] | None:
    """The runner-up that is better than the design with contacts that yield."""
    place = better_if_yielding(result)
    if place is None:
        return None
    found = result.runners_up[place]
    return {
        "runner_up": place + 1,
        "value": result.objective_of(found),
        "value_with_yielding_contacts": objective_if_yielding(result, found),
    } | _beads(found.chain)


def _point(point: DesignResult) -> dict[str, Any]:
    """A point of a Pareto front."""
    found = point.verified
    return {
        "values": dict(point.values),
        "hertz_range_kept": not found.outside_range,
        "with_yielding_contacts": dict(found.yielding),
        **_range_of_yield(found),
        "at_fully_plastic_pressure": _fully_plastic(found),
        "peak_of_second_hit": found.second_peak,
    } | _balls(point)


def as_dict(result: DesignResult) -> dict[str, Any]:
    """Plain types; numbers that are not finite are None."""
    problem = result.problem
    best, median = result.spread
    given = compared_chains(result).get(GIVEN)
    remarks = [*not_met_with_given(result), *no_better(result), *at_bounds(result)]
    document = {
        "objective": str(problem.objective),
        "statistic": None if problem.scatter is None else problem.scatter.statistic,
        "value": result.value,
        "unit": result.unit,
        "values": dict(result.values),
        "rtol": result.verified.rtol,
        "hertz_range_kept": not result.verified.outside_range,
        "forces_predicted": not result.verified.not_a_prediction,
        "with_yielding_contacts": dict(result.verified.yielding),
        **_range_of_yield(result.verified),
        "at_fully_plastic_pressure": _fully_plastic(result.verified),
        "constraints_not_met_at_fully_plastic_pressure": [
            str(each) for each in violated_if_fully_plastic(problem, result.verified)
        ],
        "dents": result.verified.dents or None,
        "peak_of_second_hit": result.verified.second_peak,
        "better_if_yielding": _better_if_yielding(result),
        "constraints_met": result.met,
        "constraints_met_with_yielding_contacts": met_if_yielding(result),
        "constraints": [str(each) for each in problem.requirements],
        "references": {
            words: _reference(result, result.references[name], equal_balls(result, name))
            for words, name in zip(references_in_words(result), result.references, strict=True)
        },
        "given_chain": None if given is None else _reference(result, given),
        "bounds": [str(each) for each in result.bounds],
        "promise": None if result.promise is None else dict(
            zip(("value", "error"), result.promise, strict=True)
        ),
        "scattered": dict(result.verified.scattered),
        "method": result.method,
        "starts": len(result.finals),
        "best_start": best,
        "median_start": median,
        "starts_outside_constraints": int((~result.finals_met).sum()),
        "simulations": result.runs,
        "gradients": result.gradients,
        "rejected": result.rejected,
        "seconds": result.seconds,
        **_balls(result),
        "order": order_in_words(result) if problem.discrete and result.chain.materials else None,
        "totals": {key: Measure(key).from_chain(result.chain, 0.0)
                   for key in ("length", "mass")},
        "optima": [result.objective_of(each) for each in result.optima],
        "front": [*map(_point, result.front)],
        "front_is_complete": result.front_is_complete if result.front else None,
        "remarks": [each.strip() for each in remarks],
        "notes": list(result.notes),
    }  # fmt: skip
    found: dict[str, Any] = finite(document)
    return found


def dataset(result: DesignResult) -> xr.Dataset:
    """The result, its runners-up and the chains to compare with."""
    import xarray as xr

    named = [("result", result.verified)]
    named += [(f"runner-up {i}", each) for i, each in enumerate(result.runners_up, start=1)]
    named += [(f"optimum {i}", each) for i, each in enumerate(result.optima, start=1)]
    named += [(f"front {i}", point.verified) for i, point in enumerate(result.front, start=1)]
    named += list(references_in_words(result).items())
    most = max(found.chain.beads for _, found in named)
    data: dict[str, Any] = {}
    scaled = result.chain.scaled
    for name, unit in (("radii", "m"), ("masses", "kg")):
        rows = np.full((len(named), most), np.nan)
        for row, (_, found) in zip(rows, named, strict=True):
            values = getattr(found.chain, name)
            row[: len(values)] = values
        data[name] = (("design", "bead"), rows, {} if scaled else {"units": unit})
    for each in result.problem.measures:
        column = [found.values[str(each)] for _, found in named]
        known = not scaled and each.unit != "1"
        data[_variable(each)] = ("design", column, {"units": each.unit} if known else {})
    return xr.Dataset(
        data,
        {"design": [name for name, _ in named], "bead": np.arange(1, most + 1)},
        {"objective": str(result.problem.objective), "method": result.method,
         "simulations": result.runs, "notes": "\n".join(result.notes)},
    )  # fmt: skip


def _variable(each: Measure) -> str:
    return str(each).replace(".", "_").replace("@", "_at_")

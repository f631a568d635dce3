"""Summary, plain types and dataset of the result of a design."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ..representation import counted, measure
from ..validation.json_types import finite
from .ball_choice import BallSpace
from .measures import Measure
from .verified import Verified, met

if TYPE_CHECKING:
    import xarray as xr

    from .result import DesignResult


def summary(result: DesignResult) -> str:
    """Text of several lines."""
    problem, best = result.problem, result.value
    lines = [*_heading(result)]
    lines += [f"  {text}" for text in _starts(result)]
    for name, found in references_in_words(result).items():
        other = result.objective_of(found)
        ratio = best / other if other else math.nan
        unmet = "" if met(problem, found.values) else ", which does NOT meet the constraints"
        lines.append(f"  {name}: {result._shown(other)}{unmet}; this design: {ratio:.1%} of "
                     f"this value{_yielding(result, found)}")  # fmt: skip
    if result.promise is not None:
        value, error = result.promise
        lines.append(f"  the local-rate law promised {value:.6g} with an estimated error of "
                     f"{error:.1g}")  # fmt: skip
    lines += [_requirement(result, i) for i in range(len(problem.requirements))]
    lines += [f"  bound: {bound}" for bound in result.bounds]
    for name, value in result.verified.scattered.items():
        unit = next((m.unit for m in problem.measures if name.endswith(f" of {m}")), "1")
        shown = measure(value, unit, "scaled" if unit == "1" else result.chain.units)
        lines.append(f"  with scatter, 400 new samples: {name} {shown}")
    if result.parts:
        lines.append("parts:")
        lines += [f"  {count} x {name}" for count, name in result.parts]
    if result.discrete and result.chain.materials is not None:
        lines.append(f"order: {_order(result)}")
    if result.optima:
        lines.append("local optima:")
        lines += [f"  {_point(result, i)}" for i in range(len(result.optima))]
    if result.front:
        lines.append("Pareto front:")
        names = [str(each.single) for each in problem.objectives]
        lines += [
            "  " + ", ".join(f"{name} {point.values[name]:.5g}" for name in names)
            for point in result.front
        ]
    lines += [f"note: {note}" for note in result.notes]
    return "\n".join(lines)


def _heading(result: DesignResult) -> list[str]:
    """The value, and what its verification covers."""
    problem, found = result.problem, result.verified
    value = result._shown(result.value)
    first = f"{_first_upper(str(problem.objective))}: {value}"
    if not result.met:
        first = ("No chain meets the constraints; the trial that violates them least has "
                 f"{problem.objective.single or 'the score'} {value.strip()}")  # fmt: skip
    limits = found.hertz_range
    if limits is None:
        kept = ""
    elif limits.violations:
        kept = "; contacts left the range of Hertz's law (see the notes)"
    else:
        kept = "; all contacts stayed within the range of Hertz's law"
    lines = [first, f"  verified: the integration was repeated at rtol {found.rtol:g}{kept}"]
    if found.yielding and math.isfinite(result._objective(found.yielding)):
        lines.append(f"  the same chain with contacts that yield, loss=ElasticPlastic(): "
                     f"{_yielding_value(result, found)}")  # fmt: skip
    return lines


def _yielding_value(result: DesignResult, found: Verified) -> str:
    return result._shown(result._objective(found.yielding)).strip()


def _yielding(result: DesignResult, found: Verified) -> str:
    if not found.yielding or not math.isfinite(result._objective(found.yielding)):
        return ""
    return f" ({_yielding_value(result, found)} with contacts that yield)"


def _first_upper(text: str) -> str:
    return text[:1].upper() + text[1:]


def search_in_words(result: DesignResult) -> str:
    """The choices or starts of which the design is the best."""
    if (choices := _choices(result)) is None:
        return f"best of {counted(len(result.finals), 'start')}"
    done, count = choices
    if done >= count:
        return f"best of all {counted(count, 'simulated choice')}"
    return f"best of the first {done} of {count} choices"


def _choices(result: DesignResult) -> tuple[int, int] | None:
    """Numbers of simulated and of all choices of an enumeration."""
    if not isinstance(result.problem.space, BallSpace) or result.method != "enumerate":
        return None
    scatter = result.problem.scatter
    done = result.runs // (1 if scatter is None else scatter.samples)
    return done, int(result.problem.space.count)


def _starts(result: DesignResult) -> list[str]:
    if (choices := _choices(result)) is not None:
        done, count = choices
        if done >= count:
            return [search_in_words(result)]
        return [f"{search_in_words(result)}: the budget was used up before all were tried; give a "
                "larger budget, or method 'genetic'"]  # fmt: skip
    work = counted(result.runs, "simulation")
    if result.gradients:
        work += f", {counted(result.gradients, 'gradient')}"
    if result.rejected:
        work += f", {counted(result.rejected, 'trial')} rejected"
    if len(result.finals) == 0:
        return [f"no search was completed: the budget was used up in {work}, which began with the "
                "chains to compare with; give a larger budget"]  # fmt: skip
    starts = counted(len(result.finals), "start")
    best, median = result.spread
    spread = f" (best {best:.4g}, median {median:.4g})" if len(result.finals) > 1 else ""
    return [f"best of {starts}{spread} by method {result.method!r}, in {work} and "
            f"{result.seconds:.0f} s"]  # fmt: skip


def _requirement(result: DesignResult, index: int) -> str:
    each = result.problem.requirements[index]
    value = result.values[str(each.measure)]
    met = each.excess(value) <= 1e-6
    return f"  {each}: {each.shown(value)}{'' if met else ', NOT met'}"


def _order(result: DesignResult) -> str:
    """Balls from the first to the last, each with the number of equal neighbours."""
    chain, radii = result.chain, result.chain.radii
    balls = [f"{2e3 * radius:g} mm {kind.name}"
             for radius, kind in zip(radii, chain.materials or (), strict=True)]  # fmt: skip
    moving = chain.velocities != 0.0
    groups = itertools.groupby(zip(moving.tolist(), balls, strict=True))
    runs = []
    for (arrives, ball), members in groups:
        count = len(list(members))
        runs.append((f"{count} x " if count > 1 else "") + ball + " (arrives)" * arrives)
    return ", ".join(runs)


def _point(result: DesignResult, index: int) -> str:
    found = result.optima[index]
    (block,) = result.problem.space.blocks  # type: ignore[union-attr]
    size = getattr(found.chain, block.field)[block.places[0]]
    return f"{block.field} {size:.6g}: {result._shown(result.objective_of(found))}"


def as_dict(result: DesignResult) -> dict[str, Any]:
    """Plain types; numbers that are not finite are None."""
    problem = result.problem
    best, median = result.spread
    document = {
        "objective": str(problem.objective),
        "value": result.value,
        "unit": result.unit,
        "values": dict(result.values),
        "rtol": result.verified.rtol,
        "hertz_range_kept": result.verified.hertz_range is None
        or not result.verified.hertz_range.violations,
        "with_yielding_contacts": dict(result.verified.yielding),
        "constraints_met": result.met,
        "constraints": [str(each) for each in problem.requirements],
        "references": {
            name: result.objective_of(found)
            for name, found in references_in_words(result).items()
        },
        "bounds": [str(each) for each in result.bounds],
        "promise": None if result.promise is None else dict(
            zip(("value", "error"), result.promise, strict=True)
        ),
        "scattered": dict(result.verified.scattered),
        "method": result.method,
        "starts": len(result.finals),
        "best_start": best,
        "median_start": median,
        "simulations": result.runs,
        "gradients": result.gradients,
        "rejected": result.rejected,
        "seconds": result.seconds,
        "radii": result.chain.radii.tolist(),
        "masses": result.chain.masses.tolist(),
        "parts": [{"count": count, "ball": name} for count, name in result.parts],
        "optima": [result.objective_of(each) for each in result.optima],
        "front": [dict(point.values) for point in result.front],
        "notes": list(result.notes),
    }  # fmt: skip
    found: dict[str, Any] = finite(document)
    return found


def references_in_words(result: DesignResult) -> dict[str, Verified]:
    """The references, with the numbers of chains of which they are the best."""

    def described(name: str) -> str:
        tried = result.compared[name]
        return f"best {name} (of {tried} tried)" if tried > 1 else name

    return {described(name): found for name, found in result.references.items()}


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
        data[name] = (("design", "bead"), rows, {"units": "1" if scaled else unit})
    for each in result.problem.measures:
        column = [found.values[str(each)] for _, found in named]
        data[_variable(each)] = ("design", column, {"units": "1" if scaled else each.unit})
    return xr.Dataset(
        data,
        {"design": [name for name, _ in named], "bead": np.arange(1, most + 1)},
        {"objective": str(result.problem.objective), "method": result.method,
         "simulations": result.runs, "notes": "\n".join(result.notes)},
    )  # fmt: skip


def _variable(each: Measure) -> str:
    return str(each).replace(".", "_").replace("@", "_at_")

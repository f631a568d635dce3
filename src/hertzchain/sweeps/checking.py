"""A sweep is checked before anything is computed: all that is wrong, each with its path."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress

from hertzchain.chain.chain import Chain
from hertzchain.checks import has_unit
from hertzchain.errors import InputError, SimulationError
from hertzchain.pulse.quantities import QUANTITIES
from hertzchain.sweeps.methods import INTEGRATIONS, pulse_by
from hertzchain.sweeps.plan import Plan, spread
from hertzchain.sweeps.reading import raise_all
from hertzchain.sweeps.specification import WALL_QUANTITIES
from hertzchain.sweeps.warned import recorded


def check_plan(plan: Plan, heading: str = "") -> None:
    """Refuse a sweep of which a method, or a value of an axis, can give nothing.

    Parameters
    ----------
    plan : Plan
        The sweep.
    heading : str
        What errors are about.

    Raises
    ------
    InputError
        All of them, each with its path.  What fails only together with some of the other
        values is a failed point, and no error.

    Examples
    --------
    >>> from hertzchain.sweeps.reading import read_specification
    >>> chain, axes = {"taper": "uniform"}, {"beads": [20, 40]}
    >>> check_plan(Plan(read_specification({"chain": chain, "axes": axes})))
    """
    with recorded():
        problems = (
            _bad_values(plan) or _bad_units(plan) or _bad_requests(plan) or _never_predicted(plan)
        )
    raise_all(problems, heading)


def _bad_requests(plan: Plan) -> list[str]:
    """Methods and quantities that these chains cannot give."""
    spec, problems = plan.specification, []
    if isinstance(spec.at, tuple) and spec.at[-1] > plan.longest:
        problems.append(f"sweep.at: there is no bead {spec.at[-1]} in {plan.longest} beads")
    if any(name in WALL_QUANTITIES for name in spec.keep) and not _has_wall(plan):
        problems.append("sweep.keep: the chains have no right wall: give right_wall in [chain]")
    for place, method in enumerate(spec.methods, start=1):
        if method != "simulate" and (reason := _refusal(plan, method)):
            problems.append(f"sweep.methods[{place}]: {reason}")
    return problems


def _bad_values(plan: Plan) -> list[str]:
    """Values of an axis with which no chain can be made, whatever the others are."""
    if plan.zipped:
        reasons = [plan.trial(index).reason for index in plan.tried()]
        return [f"axes: {reasons[0]}"] if all(reasons) else []
    ends = (0,) * len(plan.shape), tuple(n - 1 for n in plan.shape)
    problems = []
    for place, axis in enumerate(plan.specification.axes):
        bad = {}
        for i in spread(len(axis)):
            places = ((*end[:place], i, *end[place + 1 :]) for end in ends)
            reasons = [plan.trial(index).reason for index in places]
            if all(reasons):
                bad[i] = reasons[0]
        if len(bad) == len(spread(len(axis))) > 1:
            problems.append(f"axes.{axis.long_name}: with every value, {next(iter(bad.values()))}")
        else:
            problems += [f"axes.{axis.long_name}[{i + 1}]: {why}" for i, why in bad.items()]
    return list(dict.fromkeys(problems))


def _bad_units(plan: Plan) -> list[str]:
    """A quantity has one unit in a dataset, and none in scaled chains."""
    spec = plan.specification
    with_unit = [f"axes.{axis.long_name}" for axis in spec.axes if axis.has_units]
    with_unit += [f"method.{name}" for name, value in spec.options.items() if has_unit(value)]
    if with_unit and plan.units == "scaled":
        said = "has a unit, but the chains are in scaled variables: give plain numbers"
        return [f"{name}: {said}" for name in with_unit]
    for found in map(plan.trial, plan.tried()):
        if not found.reason and found.units != plan.units:
            return ["axes: some chains are in SI units, others scaled: sweep them apart"]
    return []


def _refusal(plan: Plan, method: str) -> str:
    """Why a method gives nothing for the first and the last chain; empty if it does."""
    reason = ""
    for chain in _chains(plan):
        try:
            pulse_by(method, chain)
        except InputError as error:
            reason = reason or str(error)
        except SimulationError:
            return ""
        else:
            return ""
    return reason


def _chains(plan: Plan) -> list[Chain]:
    """The first and the last chain that there is, of those that are tried."""
    tried = [*plan.tried()]
    ends = (
        next((i for i in way if not plan.trial(i).reason), None) for way in (tried, tried[::-1])
    )
    return [plan.chain(index) for index in dict.fromkeys(ends) if index is not None]


def _never_predicted(plan: Plan) -> list[str]:
    """Kept quantities that none of the methods gives."""
    spec = plan.specification
    wanted = {name for name in (*spec.keep, *spec.errors) if name in QUANTITIES}
    if set(spec.methods) & {*INTEGRATIONS}:
        wanted &= {"velocity_error"}
    if not wanted:
        return []
    given = {name for method in spec.methods for name in _columns(plan, method)}
    return [
        f"sweep.keep: no method gives {name}: {', '.join(spec.methods)}"
        for name in sorted(wanted - given)
    ]


def _columns(plan: Plan, method: str) -> Iterable[str]:
    """Quantities that a theory gives; all where none of the chains tried tells."""
    if method in INTEGRATIONS:
        return ()
    for chain in _chains(plan):
        with suppress(InputError, SimulationError):
            return pulse_by(method, chain).columns()
    return QUANTITIES


def _has_wall(plan: Plan) -> bool:
    return any(plan.trial(index).walled for index in plan.tried())

"""The problem of a design: a chain, an objective, variables, constraints and scatter."""

from __future__ import annotations

import copy
import dataclasses
import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ..chain.chain import Chain
from ..chain.feature_support import require_chain
from ..errors import InputError, short_repr
from ..representation import counted, short
from ..simulation.state import fingerprint
from ..simulation.time_scales import closing_speed
from ..validation.keywords import checked_fields, checked_methods
from ..validation.numbers import number
from ..validation.objects import check_choice, check_type
from .ball_choice import BallChoice, OrderChoice
from .ball_space import BallSpace
from .default_limits import default_requirements
from .measures import PULSE, SHARES, Measure
from .models import MODELS
from .objective import Objective, objectives_from
from .requirements import Requirement, requirements_from
from .scatter import scatter_from
from .size_space import SizeSpace, size_space
from .sizes import Sizes

if TYPE_CHECKING:
    from .verified import Verified

Variable = Sizes | BallChoice | OrderChoice
Space = SizeSpace | BallSpace


@checked_methods
@checked_fields
@dataclass(frozen=True, eq=False, repr=False)
class Design:
    r"""A problem for `hertzchain.design`.

    Attributes
    ----------
    chain : Chain
        The chain with its impact, walls and losses; everything that does not vary is fixed.
    minimise, maximise : str, mapping or list, optional
        A measure, such as ``"wall_force.peak"``, ``"velocity@90"``, ``"energy_share@last"`` or
        ``"arrival@20"`` (`hertzchain.designs.measures`); a mapping from measures to weights, whose
        weighted sum is the objective; or a list of two measures for a Pareto front.
    match : mapping, optional
        A curve instead: values by bead of one quantity, such as ``{"velocity": [...]}``.
    vary : sequence
        Variables: results of `hertzchain.vary`.
    subject_to : mapping
        Constraints by measure, such as ``{"length": "<= 60 mm", "yield_ratio": "<= 1"}``.  Of
        chains with materials, ``{"overlap_ratio": "<= 0.1"}``, beyond which forces are not a
        prediction, is added unless the impact has too little energy for such overlaps, or a limit
        of this ratio is given, such as ``"<= 10"``.
    scatter : Scatter or mapping, optional
        Deviations of manufactured beads; objective and constraints are then means or CVaR.
    until : float, optional
        Stop time of the simulations [scaled, or s]; by default as in `simulate_many`.
    model : str
        ``"simulation"``, or a theory by which trials are evaluated: ``"hard-sphere"``, ``"bca"`` or
        ``"local-rate"``.  The result is verified by the simulation in any case.

    Raises
    ------
    InputError
        If the chain does not have a measure, variables leave nothing to vary or overlap,
        constraints exclude each other, or large and small values of a measure are both bad but
        its CVaR is the mean of one end.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(20).replace(right_wall=hc.Wall())
    >>> hc.Design(chain, minimise="wall_force.peak", vary=[hc.vary.radii(0.5, 1.0)])
    Design(smallest wall_force.peak: 19 variables; no constraints)
    """

    chain: Chain
    minimise: Any = None
    maximise: Any = None
    match: Any = None
    vary: Any = ()
    subject_to: Any = field(default_factory=dict)
    scatter: Any = None
    until: float | None = None
    model: str = "simulation"
    objectives: tuple[Objective, ...] = field(init=False)
    requirements: tuple[Requirement, ...] = field(init=False)
    space: Space = field(init=False)
    # Measures of all objectives, which a part of a Pareto problem keeps.
    reported: tuple[Measure, ...] = field(init=False)
    # 1 for measures of which large values are bad, and -1 if small ones are.
    bad_sides: dict[Measure, int] = field(init=False)

    def __post_init__(self) -> None:
        require_chain("Design", self.chain)
        check_choice("model", self.model, ("simulation", *MODELS))
        chain = self.chain
        objectives = objectives_from(chain, self.minimise, self.maximise, self.match)
        object.__setattr__(self, "objectives", objectives)
        reported = tuple(m for each in objectives for m in each.measures)
        object.__setattr__(self, "reported", reported)
        object.__setattr__(self, "vary", _variables_from(self.vary))
        object.__setattr__(self, "space", _space(chain, self.vary))
        requirements = requirements_from(self.subject_to, chain)
        measures = (*reported, *(each.measure for each in requirements))
        requirements += default_requirements(chain, measures, self.model, self.space)
        object.__setattr__(self, "requirements", requirements)
        object.__setattr__(self, "scatter", scatter_from(self.scatter))
        if self.scatter is not None:
            self.scatter._check(chain)
        object.__setattr__(self, "bad_sides", self._bad_sides())
        if self.until is not None:
            until = number("until", self.until, unit=chain._unit("s"), above=0.0)
            object.__setattr__(self, "until", until)
        self._check_impact()
        self._check_end()
        self._check_prices()
        self._check_model()

    def _bad_sides(self) -> dict[Measure, int]:
        sides: dict[Measure, set[int]] = {measure: set() for measure in self.measures}
        for objective in self.objectives:
            if objective.targets is None:
                for measure, weight in zip(objective.measures, objective.weights, strict=True):
                    sides[measure] |= {int(np.sign(weight))} - {0}
        for each in self.requirements:
            sides[each.measure].add(each.sign)
        for measure, found in sides.items():
            if len(found) > 1 and self.scatter and self.scatter.tail and not measure.of_chain:
                raise InputError(
                    f"large and small values of {measure} are both bad here, but "
                    f"{self.scatter.statistic} is the mean of one end: give a limit in one "
                    "direction, or a scatter with measure 'mean'"
                )
        return {measure: min(found, default=1) for measure, found in sides.items()}

    def _check_impact(self) -> None:
        """Raise `InputError` if a simulation would begin with beads that only move apart."""
        chain, velocities = self.chain, self.chain.velocities
        loaded = chain.drive is not None or chain.gravity or chain.precompression
        if loaded or all(each.of_chain for each in self.measures):
            return
        if closing_speed(chain) > 0.0:
            return
        k = int(np.argmin(velocities))
        if velocities[k] < 0.0:
            speed = f"{velocities[k]:g}{' m/s' if chain.units == 'SI' else ''}"
            raise InputError(
                "no bead moves towards another bead or a wall: the velocity of bead "
                f"{k + 1} is {speed}; give a positive velocity"
            )

    def _check_end(self) -> None:
        for each in self.measures:
            if self.until is None and not each.ends(self.chain):
                raise InputError(
                    f"{each} has no natural end in a chain with a right wall, precompression or "
                    "gravity, because waves return; give until"
                )

    def _check_model(self) -> None:
        if self.model == "simulation":
            return
        for each in self.measures:
            if not (each.of_chain or each.key in (*PULSE, *SHARES)):
                raise InputError(f"the model {self.model!r} does not give {each}")

    def _check_prices(self) -> None:
        used = any(measure.key == "price" for measure in self.measures)
        space = self.space
        if used and not (
            isinstance(space, BallSpace) and all(b.price == b.price for b in space.balls)
        ):
            raise InputError(
                "price needs balls of a catalogue that all have one: vary balls of your "
                "supplier's CSV file, with a column price"
            )

    @property
    def objective(self) -> Objective:
        """The objective; of a Pareto front, the first one."""
        return self.objectives[0]

    @property
    def tie_breaker(self) -> Requirement | None:
        """The limit that decides between chains with the same number of beads.

        It is the first one on a simulated measure: the chain that is farthest within it is better.
        """
        single = self.objective.single
        if len(self.objectives) > 1 or single is None or single.key != "beads":
            return None
        simulated = (
            each for each in self.requirements if not (each.measure.of_chain or each.default)
        )
        return next(simulated, None)

    @property
    def measures(self) -> tuple[Measure, ...]:
        """All measures of objectives and constraints, once each."""
        limited = [each.measure for each in self.requirements]
        return tuple(dict.fromkeys([*self.reported, *limited]))

    def evaluate(self, chain: Chain) -> Verified:
        """Simulate any chain, and return its values of all measures of this problem.

        Parameters
        ----------
        chain : Chain
            A chain in the units of the problem; it need not have the sizes that may vary.

        Returns
        -------
        Verified
            ``values`` by the name of the measure, as of the result of `hertzchain.design`; the
            price is NaN.  `DesignResult.objective_of` accepts chains, too.

        Raises
        ------
        InputError
            If the chain does not have a measure, such as a force on a wall or a bead of that
            number, or is in other units.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(20).replace(right_wall=hc.Wall())
        >>> problem = hc.Design(chain, minimise="wall_force.peak", vary=[hc.vary.radii(0.5, 1.0)])
        >>> taper = hc.Chain.tapered("forward-linear", 0.02, beads=20)
        >>> values = problem.evaluate(taper.replace(right_wall=hc.Wall())).values
        >>> {name: round(value, 4) for name, value in values.items()}
        {'wall_force.peak': 1.0761}
        """
        from .verified import quietly

        check_type("chain", chain, Chain)
        if chain.units != self.chain.units:
            raise InputError(
                f"the chain is in {chain.units} units, and that of the problem in "
                f"{self.chain.units} units; convert it with Scales"
            )
        objectives_from(chain, self.minimise, self.maximise, self.match)
        requirements_from(self.subject_to, chain)
        return quietly(self, chain, math.nan, 0)

    @property
    def has_kinks(self) -> bool:
        """Whether derivatives of the objective or a constraint jump."""
        return self.scatter is not None or any(each.has_kinks for each in self.measures)

    @property
    def discrete(self) -> bool:
        """Whether balls or their order vary."""
        return isinstance(self.space, BallSpace)

    def _with_limit(self, requirement: Requirement, first: int) -> Design:
        """One objective of a Pareto front, with a limit on the other."""
        return self._only(first)._with(requirements=(*self.requirements, requirement))

    def _only(self, index: int) -> Design:
        """The problem with one objective of a Pareto front."""
        return self._with(objectives=(self.objectives[index],))

    def _with(self, **parts: Any) -> Design:
        """The problem with other objectives, requirements or scatter."""
        found = copy.copy(self)
        for name, part in parts.items():
            object.__setattr__(found, name, part)
        return found

    @property
    def identity(self) -> str:
        """A text that differs for different problems: a hash of each setting."""
        balls = self.space.balls if isinstance(self.space, BallSpace) else ()
        settings = {
            "chain": fingerprint(self.chain), "minimise": self.minimise,
            "maximise": self.maximise, "match": self.match,
            "vary": [dataclasses.astuple(each) for each in self.vary],
            "balls": balls, "subject_to": dict(self.subject_to), "scatter": self.scatter,
            "until": self.until, "model": self.model,
            "default limits": [str(each) for each in self.requirements if each.default],
        }  # fmt: skip
        return " ".join(
            f"{name}={hashlib.sha256(repr(value).encode()).hexdigest()[:12]}"
            for name, value in settings.items()
        )

    def __repr__(self) -> str:
        limits = "; ".join(map(str, self.requirements)) or "no constraints"
        size = self.space.size
        about = " against ".join(map(str, self.objectives))
        what = f"{size} places" if self.discrete else counted(size, "variable")
        scatter = "" if self.scatter is None else f"{self.scatter.measure} of scatter"
        return short("Design", about, what, limits, scatter)


def _variables_from(vary: Any) -> tuple[Variable, ...]:
    found = [vary] if isinstance(vary, Variable) else vary
    if not isinstance(found, Sequence) or isinstance(found, str):
        raise InputError(
            f"vary must be a list of variables, such as hc.vary.radii(0.5, 1), got "
            f"{short_repr(vary)}"
        )
    for each in found:
        if not isinstance(each, Variable):
            raise InputError(f"vary must have variables of hc.vary, got {short_repr(each)}")
    return tuple(found)


def _space(chain: Chain, given: tuple[Variable, ...]) -> Space:
    if not given:
        raise InputError("vary has no variables; give at least one, such as hc.vary.radii(0.5, 1)")
    sizes = [each for each in given if isinstance(each, Sizes)]
    if len(sizes) == len(given):
        return size_space(chain, sizes)
    if len(given) > 1:
        raise InputError(
            "balls of a catalogue, or their order, cannot vary together with other variables: "
            "design one after the other"
        )
    (one,) = given
    assert not isinstance(one, Sizes)
    return one.space(chain)

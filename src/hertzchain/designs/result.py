"""The result of a design: the chain, its verified numbers, and how they were found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import nan
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import NDArray

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError, unavailable_without
from ..representation import short
from ..validation.entries import NoEntries
from ..validation.keywords import checked_methods
from ..validation.objects import check_choice, check_type
from .ball_space import BallSpace
from .bounds import Bound
from .measures import in_words
from .problem import Design
from .verified import Verified, quietly

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@checked_methods
@dataclass(frozen=True, eq=False, repr=False)
class DesignResult(NoEntries):
    """The best chain that was found; the result of `hertzchain.design`.

    Attributes
    ----------
    problem : Design
        The problem.
    verified : Verified
        Chain and numbers, from a simulation with tight tolerance that is independent of the search.
    met : bool
        Whether the verified numbers meet all constraints.
    expected : float
        Objective during the search; with a scatter, its mean or CVaR.
    promise : tuple of float or None
        Value and estimated relative error that the local-rate law promised, if it was used.
    references : mapping of str to Verified
        Chains to compare with, by name: the best ``"chain of equal sizes"``, ``"chain with equal
        varying sizes"`` or ``"fast change to equal sizes"`` (if other sizes are given) and
        ``"taper"``; the best ``"row of equal balls"``, or ``"equal balls in the places that
        vary"``, or, if there are too few balls for these, ``"row of balls sorted by size"``, the
        ``"given row"``, and the best ``"geometric taper"`` of balls of one material; or the
        ``"given order"``.
    compared : mapping of str to int
        Number of chains of which each reference is the best.
    bounds : tuple of Bound
        Bounds of the measures from conservation laws, if there are any.
    method : str
        The method.
    finals : ndarray
        Objectives at the ends of all starts; with a scatter, their mean or CVaR.
    finals_met : ndarray of bool
        Whether these ends meet all constraints.
    optima : tuple of Verified
        All local optima, best first, if one variable was scanned.
    runners_up : tuple of Verified
        Further designs, best first.
    history : ndarray, shape (n, 2)
        Number of simulations and best objective, at each improvement.
    front : tuple of DesignResult
        Points of a Pareto front, if there are two objectives.
    runs, gradients, rejected : int
        Numbers of simulations, gradients, and trials that could not be simulated.
    seconds : float
        Time used.
    notes : tuple of str
        Remarks, one sentence each.
    parts : tuple of (int, str)
        Number and name of each kind of ball to buy, if balls of a catalogue vary.
    part_prices : tuple of float
        Price of one ball of each of these kinds; NaN if it is unknown.
    met_in_search : bool
        Whether the values of the search, with a scatter those of its samples, meet all constraints.
    candidates : ndarray
        Objectives of all simulated choices that meet the constraints, of the method
        ``"enumerate"``; empty for others.
    """

    problem: Design
    verified: Verified
    met: bool
    expected: float
    promise: tuple[float, float] | None
    references: Mapping[str, Verified]
    compared: Mapping[str, int]
    bounds: tuple[Bound, ...]
    method: str
    finals: Array
    finals_met: NDArray[np.bool_]
    optima: tuple[Verified, ...]
    runners_up: tuple[Verified, ...]
    history: Array
    front: tuple[DesignResult, ...]
    runs: int
    gradients: int
    rejected: int
    seconds: float
    notes: tuple[str, ...]
    parts: tuple[tuple[int, str], ...] = field(default=())
    part_prices: tuple[float, ...] = field(default=())
    met_in_search: bool = True
    candidates: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def chain(self) -> Chain:
        """The chain that was found."""
        return self.verified.chain

    @property
    def values(self) -> dict[str, float]:
        """Verified values of all measures, by name [scaled, or SI]."""
        return self.verified.values

    @property
    def value(self) -> float:
        """Verified value of the objective: of its measure, or the score of several."""
        return self.objective_of(self.verified)

    def objective_of(self, found: Verified | Chain) -> float:
        """Value of the objective of any chain, such as one of the references.

        Parameters
        ----------
        found : Chain or Verified
            A chain, which is simulated (`Design.evaluate`), or one whose numbers are known.

        Raises
        ------
        InputError
            If it is neither, or as for `Design.evaluate`.

        Examples
        --------
        >>> import hertzchain as hc
        >>> radii = hc.vary.radii(0.5, 1.0, by="common")
        >>> problem = hc.Design(hc.Chain.uniform(5), maximise="velocity@last", vary=[radii])
        >>> found = hc.design(problem, budget=200)
        >>> found.objective_of(found.verified) == found.value
        True
        >>> round(found.objective_of(hc.Chain.uniform(5)), 3)
        0.989
        """
        if isinstance(found, Chain):
            found = self.problem.evaluate(found)
        check_type("found", found, Verified, "give a chain, or one of the references")
        return self._objective(found.values)

    def _objective(self, values: Mapping[str, float]) -> float:
        objective = self.problem.objective
        if objective.single is not None:
            return values[str(objective.single)]
        row = np.array([[values[str(each)] for each in objective.measures]])
        return float(objective.score(row)[0])

    @cached_property
    def _initial(self) -> Verified:
        """Numbers of the chain of the problem."""
        from .yield_range import with_yield_range

        found = quietly(self.problem, self.problem.chain, nan, None)
        return with_yield_range(self.problem, found)

    @property
    def yield_range(self) -> tuple[float, float] | None:
        """Objective at the smallest and at the largest possible yield pressure.

        These are 1.6 and 2.8 times the yield strength.  `None` if no contacts of the design yield
        at an assumed pressure; see also `Verified.fully_plastic`.
        """
        from .comparison import objective_if_fully_plastic, objective_if_yielding

        if self.verified.fully_plastic is None:
            return None
        found = self.verified
        return objective_if_yielding(self, found), objective_if_fully_plastic(self, found)

    @property
    def front_is_complete(self) -> bool:
        """Whether all choices of balls or orders were simulated, and no point was missed."""
        space, scatter = self.problem.space, self.problem.scatter
        if not isinstance(space, BallSpace) or (scatter is not None and self.method == "genetic"):
            return False
        return self.runs >= space.count * (1 if scatter is None else scatter.samples)

    @property
    def unit(self) -> str:
        """Unit of the value; empty in scaled variables."""
        single = self.problem.objective.single
        unit = "1" if single is None else single.unit
        return "" if unit == "1" or self.chain.scaled else unit

    @property
    def spread(self) -> tuple[float, float]:
        """Best and median objective of all starts that end within the constraints, or NaN."""
        finite = self.finals[np.isfinite(self.finals) & self.finals_met]
        sign = self._sign
        if not len(finite):
            return np.nan, np.nan
        return sign * float(finite.min()), sign * float(np.median(finite))

    @property
    def _sign(self) -> float:
        return self.problem.objective.sign

    def _shown(self, value: float) -> str:
        """A value of the objective with its unit."""
        return in_words(value, self.unit, "SI" if self.unit else "scaled")

    def summary(self) -> str:
        """Text of several lines: value, comparison, constraints, bounds, parts and remarks.

        Examples
        --------
        >>> import hertzchain as hc
        >>> radii = hc.vary.radii(0.5, 1.0, by="common")
        >>> problem = hc.Design(hc.Chain.uniform(5), maximise="velocity@last", vary=[radii])
        >>> found = hc.design(problem, budget=200)
        >>> print(found.summary().splitlines()[0])
        Largest velocity@last: 1.969
        """
        from .report import summary

        return summary(self)

    def as_dict(self) -> dict[str, Any]:
        """Plain types, as written by ``hertzchain design --json``.

        Examples
        --------
        >>> import hertzchain as hc
        >>> radii = hc.vary.radii(0.5, 1.0, by="common")
        >>> problem = hc.Design(hc.Chain.uniform(5), maximise="velocity@last", vary=[radii])
        >>> found = hc.design(problem, budget=200)
        >>> found.as_dict()["method"]
        'scan'
        """
        from .exports import as_dict

        return as_dict(self)

    def to_toml(self) -> str:
        """Chain file of the chain that was found; `hertzchain.load_chain` reads it.

        Balls of a catalogue, and those whose order varies, are described by their diameters.

        Examples
        --------
        >>> import hertzchain as hc
        >>> radii = hc.vary.radii(0.5, 1.0, by="common")
        >>> problem = hc.Design(hc.Chain.uniform(5), maximise="velocity@last", vary=[radii])
        >>> found = hc.design(problem, budget=200)
        >>> found.to_toml().splitlines()[0]
        '[chain]'
        """
        from .exports import chain_text

        return chain_text(self)

    def to_csv(self) -> str:
        """Table with one row per bead, which `hertzchain.load_chain` reads: size and material.

        Examples
        --------
        >>> import hertzchain as hc
        >>> radii = hc.vary.radii(0.5, 1.0, by="common")
        >>> problem = hc.Design(hc.Chain.uniform(5), maximise="velocity@last", vary=[radii])
        >>> found = hc.design(problem, budget=200)
        >>> found.to_csv().splitlines()[:2]
        ['bead,radius', '1,1']
        """
        from .exports import bead_table

        return bead_table(self.chain)

    def to_xarray(self) -> xr.Dataset:
        """Labelled dataset of the chains and their measures.

        Returns
        -------
        xarray.Dataset
            Radii and masses by ``design`` and ``bead``, and each measure by ``design``: the result,
            its runners-up and the chains to compare with.

        Examples
        --------
        >>> import hertzchain as hc
        >>> radii = hc.vary.radii(0.5, 1.0, by="common")
        >>> problem = hc.Design(hc.Chain.uniform(5), maximise="velocity@last", vary=[radii])
        >>> found = hc.design(problem, budget=200)
        >>> found.to_xarray()["radii"].dims
        ('design', 'bead')
        """
        from .exports import dataset

        return dataset(self)

    @cached_property
    @unavailable_without
    def sensitivity(self) -> Array:
        r"""Derivatives :math:`\partial \ln V/\partial \ln R_k` of the objective V, shape (N,)."""
        from .sensitivity import sensitivity

        return sensitivity(self.problem, self.chain)

    @cached_property
    @unavailable_without
    def changes(self) -> tuple[Array, Array]:
        """Relative changes of the objective if one radius grows, or shrinks, by 1%, each (N,).

        They are simulated.  Where several maxima of a force are equal, as at many designs, both
        may be positive, and the derivatives in `sensitivity` hold only for much smaller changes.
        """
        from .sensitivity import changes

        return changes(self.problem, self.chain, 0.01)

    @overload
    def plot(self) -> Figure: ...
    @overload
    def plot(self, kind: str, *, ax: Axes | None = None) -> Axes: ...
    def plot(self, kind: str | None = None, *, ax: Axes | None = None) -> Axes | Figure:
        """Plot the result in four panels, or one of them.

        Parameters
        ----------
        kind : str, optional
            ``"beads"`` or ``"forces"`` of the design and of the best reference that meets the
            constraints, or of the given chain if there is none or if it is better (only of the
            design if both are the same chain);
            ``"history"``, the best objective over the number of simulations, or of the method
            ``"enumerate"`` the distribution over all choices that meet the constraints;
            ``"sensitivity"``, the changes of the objective if the radius of a bead changes by 1%;
            or ``"front"``, of two objectives.  By default the first three and one of the others.
        ax : matplotlib.axes.Axes, optional
            Axes to draw one kind into.  By default, a new figure is created.

        Returns
        -------
        matplotlib.figure.Figure or matplotlib.axes.Axes
            The figure of four panels, or the axes of one kind.

        Raises
        ------
        InputError
            For another kind, or for axes without a kind.

        Examples
        --------
        >>> import hertzchain as hc
        >>> radii = hc.vary.radii(0.5, 1.0, by="common")
        >>> problem = hc.Design(hc.Chain.uniform(5), maximise="velocity@last", vary=[radii])
        >>> found = hc.design(problem, budget=200)
        >>> len(found.plot().axes)
        4
        >>> found.plot("history").get_xlabel()
        'simulations'
        """
        from ..plotting import designs

        if kind is None:
            if ax is not None:
                raise InputError("ax takes one kind of plot; give it, such as 'beads'")
            return designs.plot_design(self)
        check_choice("kind of plot", kind, designs.KINDS)
        return designs.KINDS[kind](self, ax=ax)

    def __repr__(self) -> str:
        from .report import constraints_in_words, search_in_words

        return short(
            "DesignResult",
            f"{self.problem.objective}: {self._shown(self.value)}",
            search_in_words(self),
            constraints_in_words(self),
            f"{self.runs} simulations",
            "outside Hertz's range" if self.verified.outside_range else "",
        )

    def _repr_html_(self) -> str:
        from ..notebook.designs import design_html

        return design_html(self)

"""Distribution of a quantity over chains whose beads deviate at random."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ..chain.chain import Chain
from ..chain.feature_support import require_chain
from ..chain.hertz_range import HertzRange, hertz_range
from ..chain.hertz_ratios import MAX_SPEED_RATIO
from ..chain.stiff_walls import stiff_wall_notes
from ..collision import Array
from ..errors import InputError, ModelRangeWarning, SimulationError, warn_user
from ..frozen import Frozen
from ..recorded_warnings import ignore_warnings
from ..representation import counted, listed, short
from ..representation import measure as with_unit
from ..simulation.run_table import RunTable
from ..simulation.yielding import WithYield
from ..validation.keywords import checked_arguments, checked_methods
from ..validation.numbers import number, whole_number
from ..validation.objects import Progress, callback
from .measured import measured
from .measures import Measure, label_in, measure_of, notes_on
from .scatter import Scatter, scatter_from
from .yielding import value_if_yielding, yielding_note

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes


@checked_methods
@dataclass(frozen=True, eq=False)
class Distribution(Frozen):
    """Values of a quantity for many chains with random deviations; result of `distribution`.

    Attributes
    ----------
    chain : Chain
        The chain without deviations.
    scatter : Scatter
        The deviations.
    quantity : str
        Name of the quantity, such as ``"wall_force.peak"``.
    nominal : float
        Its value for the chain without deviations [scaled, or SI].
    values : ndarray, shape (M,)
        Its values for the other chains [scaled, or SI].
    failed : int
        Number of chains without a value, which are not among the ``values``.
    outside_range : int
        Number of random chains of materials that left the range of Hertz's law at any time of the
        run (`RunTable.outside_range`).
    reason : str
        Why the first of the failed chains has no value; empty if none failed.
    yielding : float
        Value of the chain without deviations with `ElasticPlastic` contacts, if its elastic ones
        exceed the pressure at first yield; otherwise NaN.
    yielding_overlap_ratio : float
        Largest overlap / radius of the run with these contacts; NaN without one.  Beyond 0.1,
        ``yielding`` is outside the range of the law.
    """

    chain: Chain
    scatter: Scatter
    quantity: str
    nominal: float
    values: Array
    failed: int = 0
    outside_range: int = 0
    reason: str = ""
    yielding: float = math.nan
    yielding_overlap_ratio: float = math.nan
    _stiff_walls: tuple[str, ...] = field(default=(), repr=False)

    @property
    def mean(self) -> float:
        """Mean of the values."""
        return float(self.values.mean())

    @property
    def standard_deviation(self) -> float:
        """Standard deviation of the values, estimated from the sample (n - 1)."""
        return float(self.values.std(ddof=1))

    @property
    def unit(self) -> str:
        """Unit of the values; ``"1"`` if they have none, or if the chain is scaled."""
        return self._measure.unit if self.chain.units == "SI" else "1"

    @property
    def label(self) -> str:
        """The quantity in words, such as ``peak force on the wall``."""
        return label_in(self.chain, self._measure)

    @property
    def _measure(self) -> Measure:
        return measure_of(self.chain, self.quantity)

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per value; ``attrs["units"]`` has the unit ("1": scaled).

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(5).replace(right_wall=hc.Wall())
        >>> scatter = hc.Scatter(radius=0.02, samples=20)
        >>> len(hc.distribution(chain, "wall_force.peak", scatter).to_dataframe())
        20
        """
        import pandas as pd

        table = pd.DataFrame({self.quantity: self.values})
        table.attrs["units"] = {self.quantity: self.unit}
        return table

    def _few_values_note(self, percents: Sequence[float]) -> str:
        """Which of these percentiles the values do not determine; an empty text if all are.

        On average, less than one of the values is beyond such a percentile.
        """
        count = len(self.values)
        few = [each for each in percents if count * min(each, 100.0 - each) < 100.0]
        if not few:
            return ""
        needed = math.ceil(100.0 / min(min(each, 100.0 - each) for each in few))
        return (
            f"{count} chains do not determine the percentiles "
            f"{listed([f'{each:g}%' for each in few])}; at least {needed} do"
        )

    @property
    def _with_yield(self) -> WithYield:
        return WithYield(self.yielding, self.yielding_overlap_ratio)

    @property
    def _yielding_note(self) -> str:
        """The nominal value with contacts that yield; an empty text if elastic ones do not."""
        if math.isnan(self.yielding):
            return ""
        note = yielding_note("the nominal one", self._measure, self.nominal, self._with_yield)
        return f"all values are those of elastic contacts; {note} (loss=ElasticPlastic())"

    def percentile(self, percent: float) -> float:
        """Value below which a percentage of the chains is.

        It needs at least 20 values for 5% and 95%, and 100 for 1% and 99%; with fewer, it is only
        between the two most extreme ones.

        Parameters
        ----------
        percent : float
            From 0 to 100.

        Returns
        -------
        float
            With linear interpolation between the values, as `numpy.percentile`.

        Raises
        ------
        InputError
            If the percentage is outside its range.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(10).replace(right_wall=hc.Wall())
        >>> found = hc.distribution(chain, "wall_force.peak", hc.Scatter(radius=0.01, samples=20))
        >>> found.percentile(10) < found.percentile(90)
        True
        """
        return float(np.percentile(self.values, number("percent", percent, least=0.0, most=100.0)))

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Plot a histogram of the values with the nominal value, the mean and the median.

        Of at least 20 values, the percentiles 5% and 95% are marked, too.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw into.  By default, a new figure is created.

        Returns
        -------
        matplotlib.axes.Axes

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(10).replace(right_wall=hc.Wall())
        >>> found = hc.distribution(chain, "wall_force.peak", hc.Scatter(radius=0.01, samples=20))
        >>> found.plot().get_ylabel()
        'number of chains, of 20'
        """
        from ..plotting.distributions import plot_distribution

        return plot_distribution(self, ax=ax)

    def _repr_html_(self) -> str:
        from ..notebook.designs import distribution_html

        return distribution_html(self)

    def __repr__(self) -> str:
        nominal, mean, deviation = (
            with_unit(value, self.unit, "scaled" if self.unit == "1" else "SI")
            for value in (self.nominal, self.mean, self.standard_deviation)
        )
        outside = self.outside_range
        return short(
            "Distribution", f"{self.quantity} of {len(self.values)} random chains",
            f"mean {mean}", f"standard deviation {deviation}", f"nominal {nominal}",
            f"{counted(self.failed, 'chain')} failed" if self.failed else "",
            f"{counted(outside, 'chain')} outside Hertz's range" if outside else "",
            *notes_on(self.chain, [self._measure]), *self._stiff_walls, self._yielding_note,
        )  # fmt: skip


@checked_arguments("distribution")
def distribution(
    chain: Chain,
    quantity: str,
    scatter: Scatter,
    *,
    until: float | str | None = None,
    seed: int = 1,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Distribution:
    r"""Simulate chains with random deviations, and collect a quantity.

    The radius of bead k is :math:`R_k e^{\sigma z_k}` with a standard normal :math:`z_k`, or, for
    a grade of ISO 3290-1, uniformly distributed within its tolerance.  Masses and contacts follow
    from the radii; all else is as in the given chain.  The radii of strikers and caps do not
    deviate.  Without strikers, bead 1 is the projectile: if its radius deviates, so do
    the momentum and energy of the impact.  To study the other beads only, use ``beads="2:"``.
    Random gaps are :math:`s |z|` with a standard normal :math:`z`, between beads that deviate.
    A random speed of the impact is :math:`v e^{\sigma z}`, and a random modulus or yield strength
    :math:`E e^{\sigma z}` has one z for all balls, strikers and walls of a material.

    Values of a scaled chain are in the units of the chain without deviations.

    Parameters
    ----------
    chain : Chain
        The chain without deviations.
    quantity : str
        Name such as ``"wall_force.peak"``, ``"velocity@20"``, ``"arrival@last"`` or, for a sensor
        in a ball, ``"sensor.largest@ball 4"``; all those of `Design` are available.
    scatter : Scatter
        Deviations, with the number of chains, ``samples``.  Its ``measure`` is not used.
    until : float or str, optional
        Stop time of the simulations; by default they end when the quantity is complete.
    seed : int
        Seed of the random numbers.
    threads : int, optional
        Number of threads, by default one for each processor.
    progress : callable, optional
        Called as ``progress(chains_done, chains)``.

    Returns
    -------
    Distribution

    Raises
    ------
    InputError
        If the chain does not have the quantity or cannot have the scatter.
    SimulationError
        If fewer than two chains have a value.

    Warns
    -----
    ModelRangeWarning
        If chains exceed the limits of Hertz's law.

    See Also
    --------
    disorder : Theory of the mean and spread of the leading pulse, without simulations.
    gradient : Derivatives, from which the spread of small deviations follows.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(10).replace(right_wall=hc.Wall())
    >>> found = hc.distribution(chain, "wall_force.peak", hc.Scatter(radius=0.01, samples=100))
    >>> f"{found.nominal:.3f}, {found.mean:.3f} +- {found.standard_deviation:.3f}"
    '1.244, 1.241 +- 0.028'

    Gaps of some micrometres between steel balls:

    >>> balls = hc.Chain.from_materials("5 mm", "steel-52100", beads=10, right_wall=hc.Wall())
    >>> row = balls.struck_by(velocity="0.1 m/s")
    >>> found = hc.distribution(row, "wall_force.peak", hc.Scatter(gaps="5 um"))
    >>> f"{found.nominal:.1f} N, {found.percentile(5):.1f} to {found.percentile(95):.1f} N"
    '25.7 N, 26.4 to 26.6 N'
    """
    require_chain("distribution", chain)
    callback("progress", progress)
    deviations = scatter_from(scatter)
    if deviations is None:
        raise InputError("a distribution needs a scatter, such as Scatter(radius=0.01)")
    measure = measure_of(chain, quantity)
    if until is not None:
        until = number("until", until, unit=chain._unit("s"), above=0.0)
    elif not measure.ends(chain):
        raise InputError(
            f"{measure} has no natural end in a chain with a right wall, precompression or "
            "gravity, because waves return; use a quantity of the leading pulse, such as "
            f"velocity@{measure.bead or 'last'}, or give until"
        )
    whole_number("seed", seed, least=0)
    chains = [chain, *deviations.sample(chain, seed)]
    with ignore_warnings(ModelRangeWarning):
        # Chains with losses would warn one by one.
        simulated = measured(
            chains, [measure], until=until, threads=threads, progress=progress, check_range=True
        )
    outside = _outside_range(chains, simulated.table)
    nominal, found = simulated.values[0, 0], simulated.values[1:, 0]
    good = found[np.isfinite(found)]
    missing = f"{measure} is not complete at the end of the run"
    if not np.isfinite(nominal):
        reasons = {} if simulated.table is None else simulated.table.reasons
        raise SimulationError(
            f"the chain without deviations has no {measure}: {reasons.get(0, missing)}"
        )
    if len(good) < 2:
        raise SimulationError(f"fewer than two chains have a value of {measure}")
    good.setflags(write=False)
    failed = len(found) - len(good)
    table = simulated.table
    overlaps = None if table is None else table._overlaps[0, : chain.beads + 1]
    reason = next(iter(simulated.reasons), missing) if failed else ""
    return Distribution(
        chain, deviations, str(measure), float(nominal), good, failed, outside, reason,
        *value_if_yielding(chain, measure, overlaps, until)[:2],
        () if overlaps is None else stiff_wall_notes(chain, overlaps),
    )  # fmt: skip


def _outside_range(chains: Sequence[Chain], table: RunTable | None) -> int:
    """Number of random chains outside the range of Hertz's law; warns of the worst one.

    Without a table of the runs, overlaps are those of isolated collisions.
    """
    if chains[0].units != "SI" or chains[0].materials is None:
        return 0
    exceeded = {}
    for i, chain in enumerate(chains):
        found = hertz_range(chain) if table is None else table._hertz_range(i)
        if found is not None and found.violations:
            exceeded[i] = found
    outside = len(exceeded) - (0 in exceeded)
    if exceeded:
        worst = max(exceeded, key=lambda i: _excess(exceeded[i]))
        which = f"random chain {worst}" if worst else "the chain without deviations"
        warn_user(
            f"{outside} of {len(chains) - 1} random chains exceed the limits of Hertz's law; in "
            f"the worst, {which}, {exceeded[worst].violations[0]}",
            ModelRangeWarning,
        )
    return outside


def _excess(found: HertzRange) -> tuple[float, ...]:
    """Factors by which the limits of Hertz's law are exceeded, in the order of `violations`."""
    overlap = np.nan_to_num(found.overlap_ratio / found.overlap_limit).max()
    ratios = found.largest_yield_ratio, overlap, found.speed_ratio / MAX_SPEED_RATIO
    return tuple(np.fmax(ratios, 1.0).tolist())

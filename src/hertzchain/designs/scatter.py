"""Scatter of beads, materials and impacts, and the measure of risk that a design minimises."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, Final

import numpy as np

from ..chain.chain import Chain
from ..chain.impact_speed import at_other_speeds, check_impact, relative_deviation
from ..chain.random_materials import (
    Spread,
    check_random_materials,
    spread_from,
    spread_in_words,
    with_random_materials,
)
from ..chain.random_radii import (
    BALL_GRADES,
    check_scatter,
    checked_size_of_gaps,
    random_draws,
    relative_scatter,
    with_deviations,
)
from ..chain.scattered_radii import scatter_in_words
from ..collision import Array
from ..errors import InputError, short_repr
from ..representation import measure as with_unit
from ..validation.keywords import checked_fields, checked_methods
from ..validation.numbers import whole_number
from ..validation.objects import check_choice, check_type, text

# Causes whose scatter is a relative standard deviation, in words.
_RELATIVE: Final = {"speed": "speed", "young": "modulus", "yield_strength": "yield strength"}
_CVAR: Final = re.compile(r"cvar(\d\d?)")


@checked_fields
@checked_methods
@dataclass(frozen=True)
class Scatter:
    r"""Random deviations of a chain, and how a measure is summarised.

    The deviations are those of `Chain.with_scatter`: all beads but strikers and a cap deviate, and
    samples of a scaled chain are in the units of the chain without deviations.  Gaps are
    half-normal, :math:`s |z|` with a standard normal :math:`z`, between beads that deviate.

    Attributes
    ----------
    radius : float, optional
        Standard deviation of the logarithm of each radius, and hence diameter, such as 0.01 or
        ``"1%"``.
    grade : int, optional
        Grade of ISO 3290-1 instead, for chains in SI units; see `Chain.with_scatter`.
    measure : str
        ``"mean"``, or ``"cvar90"``: the mean of the worst 10%, with any whole number of percent.
    samples : int
        Number of samples, the same for all trial designs.
    beads : str or list of int, optional
        Beads that deviate, such as ``"2:"``, which keeps a projectile; by default all but
        strikers and a cap.
    gaps : float or str, optional
        Scale s of the gaps between these beads [scaled, or m], such as ``"5 um"``, alone or in
        addition to deviations of the radii.
    speed : float, optional
        Standard deviation of the logarithm of the speed of the impact, such as 0.02 or ``"2%"``,
        alone or in addition.  All velocities of a chain are multiplied by the same random factor.
    young : float or mapping from str to float, optional
        Standard deviation of the logarithm of Young's modulus, such as 0.05 or ``"5%"``, alone or
        in addition, for chains with materials.  It is a property of a material, not of a ball: in
        each sample, all balls, strikers and walls of one material have the same random factor, and
        those of different materials have independent ones.  A mapping has one by material, such as
        ``{"nylon": "20%", "others": "1%"}``; a material without an entry does not deviate.
        ``beads`` has no effect on it.
    yield_strength : float or mapping from str to float, optional
        The same for the yield strength, if contacts yield (`ElasticPlastic`).

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.Scatter(radius=0.01, measure="cvar80").statistic
    'CVaR80'
    """

    radius: float | None = None
    grade: int | None = None
    measure: str = "cvar90"
    samples: int = 40
    beads: Any = None
    gaps: float | str | None = None
    speed: float | None = None
    young: Spread | None = field(default=None, hash=False)
    yield_strength: Spread | None = field(default=None, hash=False)

    def __post_init__(self) -> None:
        both = self.radius is not None and self.grade is not None
        given = self.radius, self.grade, self.gaps, *(getattr(self, key) for key in _RELATIVE)
        if both or all(each is None for each in given):
            raise InputError(
                "Scatter needs either radius, such as 0.01, or grade, such as 100, or only gaps, "
                "such as '5 um', or speed, young or yield_strength, such as 0.02"
            )
        for key in _RELATIVE:
            if (value := getattr(self, key)) is not None:
                if key == "speed":
                    spread: Spread = relative_deviation("speed of a scatter", value)
                else:
                    spread = spread_from(f"{key} of a scatter", value)
                object.__setattr__(self, key, spread)
        if self.gaps is not None:
            # The chain, which is not known here, decides about the unit.
            checked_size_of_gaps("gaps of a scatter", self.gaps, "m")
        if self.radius is not None:
            spread = relative_scatter("scatter of the radius", self.radius, above=0.0)
            object.__setattr__(self, "radius", spread)
        elif self.grade is not None:
            check_choice("ball grade", str(self.grade), map(str, BALL_GRADES))
        if text("measure of a scatter", self.measure) != "mean" and not self.tail:
            raise InputError(
                f"measure of a scatter must be 'mean' or, for example, 'cvar90', got "
                f"{self.measure!r}"
            )
        whole_number("samples of a scatter", self.samples, least=2, most=10_000)
        if isinstance(self.beads, list):
            object.__setattr__(self, "beads", tuple(self.beads))

    @property
    def tail(self) -> float:
        """Part of the samples in the mean of the worst; 0 for the mean of all."""
        found = _CVAR.fullmatch(self.measure)
        return 1.0 - int(found[1]) / 100 if found and int(found[1]) > 0 else 0.0

    def sample(self, chain: Chain, seed: int = 1) -> list[Chain]:
        """Chains with random deviations.

        Parameters
        ----------
        chain : Chain
            The chain without deviations; masses and contacts of the others follow from their
            radii.
        seed : int
            Seed of the random numbers.

        Returns
        -------
        list of Chain
            As many as ``samples``.

        Raises
        ------
        InputError
            If the chain cannot have the scatter.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chains = hc.Scatter(radius=0.01, samples=3, beads="2:").sample(hc.Chain.uniform(9))
        >>> [float(chain.radii[0]) for chain in chains]
        [1.0, 1.0, 1.0]
        """
        check_type("chain", chain, Chain)
        return self._chains(chain, self._draws(whole_number("seed", seed, least=0), chain.beads))

    @property
    def _of_materials(self) -> dict[str, Spread]:
        """Standard deviations of constants of materials."""
        found = {"young": self.young, "yield_strength": self.yield_strength}
        return {key: value for key, value in found.items() if value is not None}

    def _check(self, chain: Chain) -> float | None:
        """Raise `InputError` if a chain cannot have the scatter; the size of the gaps."""
        if self.speed is not None:
            check_impact(chain)
        for constant, spread in self._of_materials.items():
            check_random_materials(chain, constant, spread)
        return check_scatter(chain, self.radius, self.grade, self.gaps, self.beads)

    def _draws(self, seed: int, beads: int, samples: int | None = None) -> Array:
        """Random numbers of radii, gaps, the speed and materials, shape (samples, beads, 5)."""
        count = samples or self.samples
        rng = np.random.default_rng(seed)
        # Walls can have two further materials.
        rows = beads + 2 if self._of_materials else beads
        draws = np.zeros((count, rows, 5))
        draws[:, :beads, :2] = random_draws(rng, (count, beads), self.grade, self.gaps)
        # Those of radii and gaps depend neither on the speed nor on materials.
        if self.speed is not None:
            draws[:, :, 2] = rng.standard_normal(count)[:, np.newaxis]
        if self._of_materials:
            draws[:, :, 3:] = rng.standard_normal((count, rows, 2))
        return draws

    def _chains(self, chain: Chain, draws: Array) -> list[Chain]:
        """The chain with deviations; a shorter chain has the first draws of each row."""
        gaps = self._check(chain)
        chains = with_deviations(
            chain, draws[:, : chain.beads], self.radius, self.grade, gaps, self.beads
        )
        if self.speed is not None:
            chains = at_other_speeds(chains, self.speed, draws[:, 0, 2])
        if not self._of_materials:
            return chains
        spreads = {"young": self.young or 0.0, "yield_strength": self.yield_strength or 0.0}
        return with_random_materials(chains, spreads, draws[..., 3:])

    def _causes(self, units: str) -> dict[str, Scatter]:
        """Scatters with one of the causes each, by their words."""
        causes = "radius", "grade", "gaps", *_RELATIVE
        given = [key for key in causes if getattr(self, key) is not None]
        found = {}
        for own in given:
            others: dict[str, Any] = {key: None for key in given if key != own}
            alone = replace(self, **others)
            found[alone._in_words(units)] = alone
        return found

    def _in_words(self, units: str) -> str:
        """Such as ``1% scatter, random gaps (5 um)``."""
        radii = (
            ""
            if self.radius is None and self.grade is None
            else scatter_in_words(self.radius, self.grade)
        )
        size = self.gaps
        if isinstance(size, float | int):
            size = with_unit(size, "m", units)
        given = ((words, getattr(self, key)) for key, words in _RELATIVE.items())
        others = [f"{key} {spread_in_words(value)}" for key, value in given if value is not None]
        return ", ".join(filter(None, (radii, f"random gaps ({size})" if size else "", *others)))

    def _repr_html_(self) -> str:
        from ..notebook.designs import scatter_html

        return scatter_html(self)

    @property
    def statistic(self) -> str:
        """The measure in words: ``"mean"`` or, for example, ``"CVaR90"``."""
        return self.measure.replace("cvar", "CVaR")

    def _worst(self, values: Array, sign: float) -> Any:
        """Indices of the samples that count, for values of which large (sign 1) are bad."""
        return worst(values, sign, self.tail)

    def _counted(self, samples: int) -> int:
        """Number of the samples that count."""
        return _counted(samples, self.tail)


def worst(values: Array, sign: float, tail: float) -> Any:
    """Indices of the worst part of samples, of which large (sign 1) are bad; all without a tail."""
    order = np.argsort(sign * values, kind="stable")
    return order[len(values) - _counted(len(values), tail) :]


def _counted(samples: int, tail: float) -> int:
    return max(1, round(tail * samples)) if tail else samples


def scatter_from(given: object) -> Scatter | None:
    """A scatter, or a mapping of its attributes."""
    if given is None or isinstance(given, Scatter):
        return given
    if not isinstance(given, Mapping):
        raise InputError(
            f"scatter must be a Scatter, such as Scatter(radius=0.01), got {short_repr(given)}"
        )
    known = tuple(item.name for item in fields(Scatter))
    for name in given:
        check_choice("attribute of a scatter", name, known)
    return Scatter(**given)

"""Chains on which the scoreboard compares theories with the simulation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from ..calibration import BEADS, RATES
from ..chain.chain import Chain
from ..chain.tapers import PAPER_TAPERS, rate_symbol
from ..errors import InputError, unknown_name_error
from ..representation import short
from ..validation.keywords import checked_arguments
from .unseen_tapers import is_smooth, unseen_radii

Group = Literal["paper", "beyond", "smooth", "rough"]

GROUPS: Final[dict[Group, str]] = {
    "paper": "the paper's tapers, at its rates",
    "beyond": "the paper's tapers, beyond its rates",
    "smooth": "unseen tapers, smooth",
    "rough": "unseen tapers, not smooth",
}
RATES_BEYOND: Final[dict[str, tuple[float, ...]]] = {
    "backward-linear": (1.0,),
    "backward-exponential": (0.12, 0.2, 0.3),
    "forward-linear": (0.0095,),
    "forward-exponential": (0.08, 0.1, 0.12),
}
# First beads of the ranges over which errors are summarised.
FIRST_BEADS: Final = (2, 10)
# Number of last beads that are affected by the free end; its effect on all others is below 1e-9.
FREE_END: Final = 3


@dataclass(frozen=True, eq=False)
class Case:
    """A chain on which theories are evaluated.

    Attributes
    ----------
    name : str
        Short description of the chain.
    family : str
        Family of chains that share a row of the table.
    group : str
        Group of families, a key of `GROUPS`.
    chain : Chain
        The chain.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.evaluation.Case("equal", "equal", "smooth", hc.Chain.uniform(30)).last_bead
    27
    """

    name: str
    family: str
    group: Group
    chain: Chain

    def __repr__(self) -> str:
        return short("Case", self.name, self.group, self.chain.description)

    def __post_init__(self) -> None:
        if self.group not in GROUPS:
            raise unknown_name_error("group", self.group, GROUPS)
        if self.last_bead < max(FIRST_BEADS):
            raise InputError(
                f"{self.name} has {self.chain.beads} beads; chains for the evaluation of theories "
                f"must have at least {max(FIRST_BEADS) + FREE_END}"
            )

    @property
    def last_bead(self) -> int:
        """Last bead (or contact) that is evaluated, N - 3."""
        return self.chain.beads - FREE_END


@checked_arguments("paper_cases")
def paper_cases() -> list[Case]:
    """Return the paper's four tapers, at its rates and beyond them.

    Returns
    -------
    list of Case
        Chains of 100 beads.

    Examples
    --------
    >>> import hertzchain as hc
    >>> print(hc.evaluation.paper_cases()[0].name, "|", hc.evaluation.paper_cases()[-1].family)
    backward-linear, S = 0.1 | forward-exponential, q = 0.08..0.12
    """
    found = []
    groups: tuple[tuple[Group, dict[str, tuple[float, ...]]], ...] = (
        ("paper", RATES), ("beyond", RATES_BEYOND),
    )  # fmt: skip
    for group, rates_of in groups:
        for taper in PAPER_TAPERS:
            rates, symbol = rates_of[taper], rate_symbol(taper)
            span = f"{rates[0]:g}" if len(rates) == 1 else f"{rates[0]:g}..{rates[-1]:g}"
            for rate in rates:
                chain = Chain.tapered(taper, rate, beads=BEADS)
                name = f"{taper}, {symbol} = {rate:g}"
                found.append(Case(name, f"{taper}, {symbol} = {span}", group, chain))
    return found


@checked_arguments("unseen_cases")
def unseen_cases() -> list[Case]:
    """Return the tapers to which no theory was fitted, smooth ones first.

    Returns
    -------
    list of Case
        Chains of 100 beads.

    Examples
    --------
    >>> import hertzchain as hc
    >>> len(hc.evaluation.unseen_cases())
    20
    """
    found = [
        Case(name, name, "smooth" if is_smooth(radii) else "rough", Chain.from_radii(radii))
        for name, radii in unseen_radii(BEADS).items()
    ]
    return sorted(found, key=lambda case: case.group != "smooth")

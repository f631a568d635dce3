"""Parameters whose errors come from priors more than from the data, by name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ..collision import Array
from ..representation import short
from .weak_directions import WeakDirection, grouped

# A prior holds a parameter if more than this fraction of the variance comes from priors.  With one
# parameter, this is the ratio of its variance to that of its prior, and the prior holds it if it is
# narrower than the data.
HELD: Final = 0.5
# A prior is named if it contributes at least this fraction of the largest contribution.
MIN_PART: Final = 0.5


@dataclass(frozen=True)
class HeldByPriors:
    """A parameter whose error comes from priors more than from the data.

    The estimate is a linear function of the data and of the values of the priors near the optimum,
    so that its variance is a sum of theirs.

    Attributes
    ----------
    name : str
        Name of the parameter, which need not have a prior of its own.
    share : float
        Fraction of its variance that comes from priors, above 0.5.  The square root is the fraction
        of its standard error that uncertain priors alone would cause.
    priors : dict
        Fraction of the variance that comes from each prior, largest first.
    """

    name: str
    share: float
    priors: dict[str, float]

    @property
    def main(self) -> tuple[str, ...]:
        """The priors that contribute most."""
        least = MIN_PART * max(self.priors.values())
        return tuple(name for name, part in self.priors.items() if part >= least)

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {"name": self.name, "share": self.share, "priors": self.priors}

    def __str__(self) -> str:
        return _sentence([self])

    def __repr__(self) -> str:
        return short("HeldByPriors", str(self))


def held_by_priors(
    names: Sequence[str], jacobian: Array, priors: Sequence[str], change: Array
) -> tuple[HeldByPriors, ...]:
    """Parameters that priors hold, from the derivatives of all residuals, those of priors last.

    ``change`` has the derivatives of the parameters with respect to the variables.  The estimate
    is the product of a pseudo-inverse and the residuals, whose variances are 1.
    """
    if not priors:
        return ()
    scale = np.linalg.norm(jacobian, axis=0)
    scale[scale == 0.0] = 1.0
    inverse = np.linalg.pinv(jacobian / scale, rcond=1e-12)
    squares = (change @ (inverse / scale[:, None])) ** 2
    found = []
    for name, row in zip(names, squares, strict=True):
        total = float(row.sum())
        parts = row[-len(priors) :] / (total or 1.0)
        if parts.sum() > HELD:
            order = np.argsort(-parts, kind="stable")
            shares = {priors[k]: float(parts[k]) for k in order}
            found.append(HeldByPriors(name, float(parts.sum()), shares))
    return tuple(found)


def prior_notes(held: Sequence[HeldByPriors], weak: Sequence[WeakDirection]) -> list[str]:
    """One sentence for all parameters that the same priors hold.

    Parameters of weak directions are omitted, which name the priors that fix them.
    """
    named = {name for each in weak for name in each.weights}
    groups: dict[frozenset[str], list[HeldByPriors]] = {}
    for each in held:
        if each.name not in named:
            groups.setdefault(frozenset(each.main), []).append(each)
    return [_sentence(group) for group in groups.values()]


def _sentence(group: Sequence[HeldByPriors]) -> str:
    """The parameters, the priors that hold them, and what would reduce their errors."""
    names, priors = [each.name for each in group], list(group[0].main)
    several = len(names) > 1
    # At most 99%, because the data contribute, too.
    shares = [min(each.share, 0.99) for each in group]
    low, high = (f"{100.0 * end(shares):.0f}" for end in (min, max))
    part = f"{low}%" if low == high else f"{low} to {high}%"
    if names == priors and not several:
        source, measured = "its prior", "it"
    else:
        measured = grouped(priors)
        source = f"the prior{'s' if len(priors) > 1 else ''} of {measured}"
        if len(group[0].priors) > len(priors):
            each_of = "those" if len(priors) > 1 else "that"
            source = f"priors, above all from {each_of} of {measured}"
    return (
        f"{part} of the variance{'s' if several else ''} of {grouped(names)} "
        f"come{'' if several else 's'} from {source}: a separate, more accurate measurement of "
        f"{measured} would reduce {'these errors' if several else 'this error'} more than less "
        "noise"
    )

"""Combinations of parameters that the data do not determine, by name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ..collision import Array
from ..representation import listed, short

# Relative error along a direction above which it is reported; fraction of the largest singular
# value below which a direction cannot be distinguished from an exact degeneracy.
WEAK, EXACT_PART = 1.0, 3e-6
# Smallest weight of a parameter that is named, relative to the largest.
MIN_WEIGHT: Final = 0.1
# Fraction of the size of a parameter below which a change relative to its value has no meaning.
NEAR_ZERO: Final = 0.01


@dataclass(frozen=True)
class WeakDirection:
    """Parameters that can change together without a change of the predicted signals.

    Attributes
    ----------
    weights : dict
        Changes of the parameters relative to their values; the largest is 1.
    error : float
        Relative error along the direction from the data only, without priors.
    exact : bool
        Whether the data do not depend on the direction at all.
    fixed_by : tuple of str
        Parameters whose priors fix the direction.
    """

    weights: dict[str, float]
    error: float
    exact: bool
    fixed_by: tuple[str, ...]

    def __str__(self) -> str:
        alone = len(self.weights) == 1
        text = self._one() if alone else self._several()
        if not self.fixed_by:
            return (
                f"{text}: fix it, or give it a prior"
                if alone
                else (f"{text}; fix one of them, or give it a prior")
            )
        them = "it" if alone else "them"
        priors, fix = ("priors", "fix") if len(self.fixed_by) > 1 else ("prior", "fixes")
        return f"{text}; only the {priors} of {grouped(list(self.fixed_by))} {fix} {them}"

    def _one(self) -> str:
        return (
            f"the data {'do not' if self.exact else 'hardly'} depend on {next(iter(self.weights))}"
        )

    def _several(self) -> str:
        names = grouped(list(self.weights))
        what = "a combination" if len(self.weights) == 2 else "combinations"
        first = f"the data determine only {what} of {names}"
        if not self.exact:
            first = f"the data hardly determine {names} separately"
        then = "stay the same" if self.exact else "hardly change"
        return (
            f"{first}: signals {then} if the relative changes of these are in the ratio "
            f"{self._ratio()}"
        )

    def _ratio(self) -> str:
        """Weights, of which the first is positive; that of several gains once if it is the same."""
        sign = np.copysign(1.0, next(iter(self.weights.values())))
        shown = {name: f"{sign * weight:.2g}" for name, weight in self.weights.items()}
        gains = [name for name in shown if name.startswith("gain[")]
        if len({shown[name] for name in gains}) == 1:
            first, *others = gains
            shown["the gains"] = shown.pop(first)
            for name in others:
                del shown[name]
        return " : ".join(shown.values())

    def __repr__(self) -> str:
        return short("WeakDirection", str(self))


def grouped(names: list[str]) -> str:
    """Names in a sentence; several gains are "the gains"."""
    gains = [name for name in names if name.startswith("gain[")]
    if len(gains) > 1:
        names = [name for name in names if name not in gains] + ["the gains"]
    return listed(names)


def weak_directions(
    names: Sequence[str], jacobian: Array, values: Array, sizes: Array, priors: dict[str, float]
) -> tuple[WeakDirection, ...]:
    """Weak directions from the derivatives of the data with respect to the parameters.

    ``sizes`` are the sizes to which errors are relative; ``priors`` the standard deviations of
    the priors, relative to the sizes.  Weights are relative to values, except for those near zero.
    """
    relative = np.where(np.abs(values) > NEAR_ZERO * np.abs(sizes), values, sizes)
    scaled = jacobian * sizes
    _, singular, rows = np.linalg.svd(scaled, full_matrices=False)
    found = []
    for value, row in zip(singular, rows, strict=True):
        exact = value <= EXACT_PART * singular[0]
        if not exact and value * WEAK > 1.0:
            continue
        row = row / row[np.argmax(np.abs(row))]
        weights = {
            name: float(weight)
            for name, weight in zip(names, row, strict=True)
            if abs(weight) > MIN_WEIGHT
        }
        fixed = tuple(
            name for name in weights if name in priors and priors[name] < WEAK * abs(weights[name])
        )
        changes = dict(zip(names, row * sizes / relative, strict=True))
        largest = changes[max(weights, key=lambda name: abs(changes[name]))]
        weights = {name: float(changes[name] / largest) for name in weights}
        error = float(1.0 / value) if value > 0.0 else np.inf
        found.append(WeakDirection(weights, error, bool(exact), fixed))
    return tuple(found)

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
# Smallest weight with which a prior fixes an exact direction, above errors of derivatives.
PRIOR_WEIGHT: Final = 1e-3
# Broader priors than the best one, by this factor, are not named if no prior is narrow.
BROADER: Final = 10.0
# Times, whose values may be zero, so that their changes are not relative, and the unit of these.
TIMES: Final = ("delay", "lag", "time_offset")
MICROSECOND: Final = 1e-6


@dataclass(frozen=True)
class WeakDirection:
    """Parameters that can change together without a change of the predicted signals.

    Attributes
    ----------
    weights : dict
        Changes of the parameters relative to their values, and of delays, lags and time offsets
        in microseconds, or in any unit if all are times; the largest is 1.
    error : float
        Relative error along the direction from the data only, without priors.
    exact : bool
        Whether the data do not depend on the direction at all.
    fixed_by : tuple of str
        Parameters whose priors fix the direction.
    undetermined : tuple of str
        Parameters of a direction with ``fixed_by`` that are also in a direction that nothing fixes.
    """

    weights: dict[str, float]
    error: float
    exact: bool
    fixed_by: tuple[str, ...]
    undetermined: tuple[str, ...] = ()

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
        text = f"{text}; only the {priors} of {grouped(list(self.fixed_by))} {fix} {them}"
        if not self.undetermined:
            return text
        are = "is" if len(self.undetermined) == 1 else "are"
        return f"{text}, except {grouped(list(self.undetermined))}, which {are} not determined"

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
        return f"{first}: signals {then} if {self._changes()} are in the ratio {self._ratio()}"

    def _changes(self) -> str:
        """The changes to which the weights belong."""
        times = [name for name in self.weights if is_time(name)]
        if len(times) == len(self.weights):
            return "the changes of these"
        if times:
            return f"the relative changes of these, and the changes of {listed(times)} in us,"
        return "the relative changes of these"

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


def is_time(name: str) -> bool:
    """Whether a parameter is a delay, a lag or a time offset."""
    return name.partition("[")[0] in TIMES


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
    the priors, relative to the sizes.  Weights are relative to values, except for those near zero
    and for times.
    """
    relative = np.where(np.abs(values) > NEAR_ZERO * np.abs(sizes), values, sizes)
    relative = np.where([is_time(name) for name in names], MICROSECOND, relative)
    scaled = jacobian * sizes
    _, singular, rows = np.linalg.svd(scaled, full_matrices=False)
    no_effect = singular <= EXACT_PART * singular[0]
    rows[no_effect] = _separated(rows[no_effect], [name in priors for name in names])
    found = []
    for value, row, exact in zip(singular, rows, no_effect, strict=True):
        if not exact and value * WEAK > 1.0:
            continue
        row = row / row[np.argmax(np.abs(row))]
        changes = dict(zip(names, (row * sizes / relative).tolist(), strict=True))
        named = _named(dict(zip(names, row.tolist(), strict=True)), changes)
        error = float(1.0 / value) if value > 0.0 else np.inf
        errors = {
            name: priors[name] / abs(weight)
            for name, weight in zip(names, row, strict=True)
            if name in priors and abs(weight) > PRIOR_WEIGHT
        }
        fixed = _fixed_by(errors, named, np.inf if exact else error)
        largest = changes[max(named, key=lambda name: abs(changes[name]))]
        weights = {name: changes[name] / largest for name in named}
        found.append(WeakDirection(weights, error, bool(exact), fixed))
    return tuple(found)


def _separated(rows: Array, with_prior: Sequence[bool]) -> Array:
    """The same space of exact directions, as directions that priors affect, and others.

    Without this, one prior would seem to fix all directions that contain its parameter.
    """
    parts = rows[:, with_prior]
    if len(rows) < 2 or not parts.size:
        return rows
    left, sizes, _ = np.linalg.svd(parts)
    if int((sizes > PRIOR_WEIGHT).sum()) in (0, len(rows)):
        return rows
    return np.asarray(left.T @ rows)


def _named(row: dict[str, float], changes: dict[str, float]) -> list[str]:
    """Parameters whose part in a direction matters; times are compared with other times."""
    large = {name for name, weight in row.items() if abs(weight) > MIN_WEIGHT}
    least = MIN_WEIGHT * max(
        (abs(changes[name]) for name in large if is_time(name)), default=np.inf
    )
    return [name for name in row if name in large or (is_time(name) and abs(changes[name]) > least)]


def _fixed_by(errors: dict[str, float], named: Sequence[str], of_data: float) -> tuple[str, ...]:
    """Parameters whose priors fix a direction, from the errors along it with each prior alone.

    Priors that leave an error above `WEAK` fix it, too, if the data alone leave a larger one.
    """
    narrow = tuple(name for name in errors if name in named and errors[name] < WEAK)
    if narrow:
        return narrow
    least = min(errors.values(), default=np.inf)
    return tuple(
        name for name, each in errors.items() if each < of_data and each <= BROADER * least
    )

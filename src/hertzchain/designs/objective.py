"""The objective of a design: a measure, a weighted sum of measures, or a curve to match."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError, short_repr
from ..validation.numbers import number, real_numbers
from .measures import CURVES, Measure, check_name, measure_of


@dataclass(frozen=True, eq=False)
class Objective:
    r"""A score to minimise, from the values :math:`V_i` of measures.

    It is :math:`\sum_i w_i V_i`, or :math:`\sum_i (V_i/T_i - 1)^2` with the targets T of a curve.
    """

    measures: tuple[Measure, ...]
    weights: Array
    targets: Array | None = None

    def __str__(self) -> str:
        if self.targets is not None:
            return f"deviation from the curve of {self.measures[0].key}"
        if len(self.measures) == 1:
            name, least = str(self.measures[0]), self.weights[0] > 0.0
            if name.startswith(("largest", "smallest")):
                return f"{'minimum' if least else 'maximum'} of {name}"
            return f"{'smallest' if least else 'largest'} {name}"
        return " + ".join(
            f"{w:g} {m}" for w, m in zip(self.weights, self.measures, strict=True)
        )  # fmt: skip

    @property
    def single(self) -> Measure | None:
        """The measure, if there is only one."""
        return self.measures[0] if len(self.measures) == 1 and self.targets is None else None

    @property
    def sign(self) -> float:
        """-1 if a single measure is maximised, otherwise 1."""
        return 1.0 if self.single is None else float(np.sign(self.weights[0]))

    def score(self, values: Array) -> Array:
        """Scores of rows of values, shape (C,)."""
        if self.targets is None:
            return np.asarray(values @ self.weights)
        return np.asarray(((values / self.targets - 1.0) ** 2).sum(axis=-1))

    def slope(self, values: Array) -> Array:
        """Derivatives of the score with respect to the values."""
        if self.targets is None:
            return self.weights
        return np.asarray(2.0 * (values / self.targets - 1.0) / self.targets)


def objectives_from(
    chain: Chain, minimise: Any, maximise: Any, match: Any
) -> tuple[Objective, ...]:
    """Read the objective; two names are two objectives of a Pareto front."""
    given = [each for each in (minimise, maximise, match) if each is not None]
    if len(given) != 1:
        raise InputError(
            "a design has one of minimise, maximise and match, such as minimise = "
            f"'wall_force.peak', got {len(given) or 'none'}"
        )
    if match is not None:
        return (_curve(chain, match),)
    sign, what = (1.0, minimise) if minimise is not None else (-1.0, maximise)
    if not isinstance(what, str | Mapping | list | tuple):
        raise InputError(
            f"the objective must be the name of a measure, such as 'wall_force.peak', got "
            f"{short_repr(what)}"
        )
    if isinstance(what, list | tuple):
        if len(what) != 2:
            raise InputError(f"a Pareto front has two objectives, got {len(what)}")
        for name in what:
            if not isinstance(name, str):
                raise InputError(
                    "each objective of a Pareto front must be the name of a measure, such as "
                    f"'wall_force.peak', got {short_repr(name)}"
                )
        first, second = (_of({name: 1.0}, sign, chain) for name in what)
        if first.single == second.single:
            raise InputError(
                f"a Pareto front needs two different measures, got {first.single} twice"
            )
        return first, second
    return (_of(what if isinstance(what, Mapping) else {what: 1.0}, sign, chain),)


def _of(weights: Mapping[Any, Any], sign: float, chain: Chain) -> Objective:
    if not weights:
        raise InputError("the objective has no measures: give a name, such as 'wall_force.peak'")
    for name, weight in weights.items():
        check_name(name, weight)
    measures = tuple(measure_of(chain, name) for name in weights)
    values = [sign * number(f"weight of {m}", w)
              for m, w in zip(measures, weights.values(), strict=True)]  # fmt: skip
    if not any(values):
        raise InputError("all weights of the objective are 0: give at least one")
    return Objective(measures, np.array(values))


def _curve(chain: Chain, match: object) -> Objective:
    """A curve of one quantity by bead; NaN where it is not prescribed."""
    if not isinstance(match, Mapping) or len(match) != 1:
        raise InputError(
            "match must be a mapping of one quantity to its values by bead, such as "
            f"{{'velocity': [...]}}, got {short_repr(match)}"
        )
    ((name, curve),) = match.items()
    if name not in CURVES:
        raise InputError(f"the curve to match must be one of {', '.join(CURVES)}, got {name!r}")
    values = np.atleast_1d(np.asarray(curve, float) if _has_nan(curve) else real_numbers(
        "value to match", curve))  # fmt: skip
    measures = [Measure(name, k) for k in range(1, len(values) + 1) if np.isfinite(values[k - 1])]
    targets = values[np.isfinite(values)]
    if not measures or not (targets != 0.0).all():
        raise InputError("the curve to match needs at least one value other than 0 and NaN")
    for each in measures:
        each.check(chain)
    return Objective(tuple(measures), np.ones(len(measures)), targets)


def _has_nan(curve: Any) -> bool:
    try:
        return bool(np.isnan(np.asarray(curve, float)).any())
    except (TypeError, ValueError):
        return False

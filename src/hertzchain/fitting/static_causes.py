"""Gravity and precompression that the chain of a fit does not have, as causes of residuals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Final
from weakref import WeakKeyDictionary

from ..chain.chain import Chain
from ..errors import InputError
from ..traces.amplitudes import extreme, from_level
from ..traces.coupling import resolved_coupling
from ..units import STANDARD_GRAVITY
from .causes import Cause, Refit, is_free, try_further
from .chain_parameters import with_motion
from .model import Model, make_model
from .names import Name, to_free
from .result import FitResult

# Standard errors by which a fitted component of gravity may exceed standard gravity.
ALLOWED: Final = 3.0
# Largest error of gravity, in the same multiple and relative, with which a row is called vertical.
CERTAIN: Final = 0.1
# Start of a precompression, as a part of the largest measured force.
PART_OF_PEAK: Final = 0.03
GRAVITY: Final = (
    "if the row is not horizontal, give gravity, its component along the row towards the last "
    f"ball (gravity = {STANDARD_GRAVITY:.3g} if the row is vertical and struck from above)"
)
PRECOMPRESSION: Final = (
    f"if the row is compressed, give precompression in the chain, and {to_free(['precompression'])}"
)


# Fits with gravity by the fit without it, which both functions below use.
_WITH_GRAVITY: Final[WeakKeyDictionary[FitResult, list[Cause]]] = WeakKeyDictionary()


def vertical_row(result: FitResult, start: Mapping[str, float], refit: Refit) -> Iterator[Cause]:
    """The fit with gravity if its value is that of a vertical row.

    It is tried before searches for odd balls and gaps, which take many times as long.
    """
    for cause in _with_gravity(result, start, refit):
        value, error = (each["gravity"] for each in (cause.result.values, cause.result.errors))
        if abs(abs(value) - STANDARD_GRAVITY) < ALLOWED * error < CERTAIN * STANDARD_GRAVITY:
            yield cause


def static_causes(result: FitResult, start: Mapping[str, float], refit: Refit) -> Iterator[Cause]:
    """The fits with gravity and with a precompression, if the chains have neither."""
    yield from _with_gravity(result, start, refit)
    if _has_static_forces(result.model) or not (forces := _measured_forces(result)):
        return
    first = PART_OF_PEAK * max(forces)
    cause = _with_static(result, Name("precompression"), first, start, refit)
    if cause is not None:
        yield replace(cause, advice=PRECOMPRESSION)


def _has_static_forces(model: Model) -> bool:
    """Whether a chain has gravity or a precompression, or may get one in the fit."""
    return any(chain.gravity or chain.precompression for chain in model.chains) or any(
        is_free(key, model) for key in ("gravity", "precompression")
    )


def _with_gravity(result: FitResult, start: Mapping[str, float], refit: Refit) -> list[Cause]:
    """The fits with gravity that is not larger than the standard one, made once."""
    if result not in _WITH_GRAVITY:
        _WITH_GRAVITY[result] = [*_fits_with_gravity(result, start, refit)]
    return _WITH_GRAVITY[result]


def _fits_with_gravity(
    result: FitResult, start: Mapping[str, float], refit: Refit
) -> Iterator[Cause]:
    if _has_static_forces(result.model):
        return
    for first in _accelerations(result):
        cause = _with_static(result, Name("gravity"), first, start, refit)
        if cause is not None:
            value, error = (each["gravity"] for each in (cause.result.values, cause.result.errors))
            if abs(value) < STANDARD_GRAVITY + ALLOWED * error:
                yield replace(cause, advice=GRAVITY)


def _measured_forces(result: FitResult) -> list[float]:
    """Largest forces of the signals whose gains are known."""
    model, values = result.model, result.model.values(result.variables)
    gains = [(signal, model.gain(shot, signal, values)) for shot, signal in result.traces]
    return [
        abs(extreme(from_level(signal)) / gain) for signal, gain in gains
        if signal.place.quantity == "force" and (signal.calibrated or gain != 1.0)
    ]  # fmt: skip


def _accelerations(result: FitResult) -> list[float]:
    """Starts of gravity, towards the walls that can carry the weight."""
    ends = (STANDARD_GRAVITY, result.chain.right_wall), (-STANDARD_GRAVITY, result.chain.left_wall)
    return [start for start, wall in ends if wall is not None]


def _with_static(
    result: FitResult, name: Name, value: float, start: Mapping[str, float], refit: Refit
) -> Cause | None:
    """The fit with a static force, which AC coupling hides; the derivative at zero is infinite.

    Large static forces spoil the optimum without them, so that it may be a poor start.
    """
    try:
        model = _model_with(result, name, value)
        near = try_further(result, (name,), refit, model, neutral=0.0)
        if near is not None and near.result.describes:
            return near
        far = try_further(result, (name,), refit, model, neutral=0.0, start=start)
        found = [each for each in (near, far) if each is not None]
        return min(found, key=lambda each: each.result.chi2, default=None)
    except InputError:
        # The weight or the precompression has no support.
        return None


def _model_with(result: FitResult, name: Name, start: float) -> Model:
    """The model of the chains with a static force, and the coupling that the levels then show."""
    model, values = result.model, result.model.values(result.variables)
    chains = tuple(_with_value(chain, name, start) for chain in model.chains)
    traces = resolved_coupling(
        model.traces, chains, lambda shot, signal: model.gain(shot, signal, values)
    )
    return make_model(traces, chains, model.parameters, model.simulator)


def _with_value(chain: Chain, name: Name, value: float) -> Chain:
    if name.key == "precompression" and None in (chain.left_wall, chain.right_wall):
        chain = chain.replace(precompression=value, held_by="force")
    return with_motion(chain, {name: value})

"""Fit a chain and its sensors to measured traces."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..chain.chain import Chain
from ..errors import InputError
from ..representation import counted, listed
from ..traces.coupling import coupling_notes, resolved_coupling
from ..traces.files import load_traces
from ..traces.spikes import spikes, without_spikes
from ..traces.traces import Traces, with_time_offset
from ..validation.keywords import checked_arguments
from ..validation.numbers import whole_number
from ..validation.objects import Progress, callback, check_bool
from .cap_notes import cap_notes
from .causes import Refit
from .chain_parameters import following
from .clocks import clock_notes, with_clocks
from .coarse_sampling import sampling_notes
from .diagnosis import as_misread, diagnosed, first_misread, quickly_diagnosed
from .flat_valleys import along_valleys
from .least_squares import Solution, solve, solve_again
from .misread_columns import inversion_notes
from .misread_times import nominal_pulses
from .model import Model, make_model
from .names import ENDS, Name
from .parameters import Parameter, Priors, free_parameters
from .prior_conflicts import bound_notes, conflict_notes
from .problem import Problem
from .result import FitResult
from .sensor_comparison import pulse_widths
from .settings import Settings, for_sensors, load_experiment
from .silent_sensors import undetermined
from .simulations import Simulator, range_notes
from .starts import with_gains
from .symmetry import units_of
from .systematics import effects_of
from .uncertainty import Uncertainty, large_error_notes, uncertainty
from .unused_parameters import check_used
from .weights import (
    correlations,
    goodness_of_problem,
    remaining_weights,
    small_residual_notes,
)
from .without_priors import with_fits_without_priors

TimeOffset = float | str | Sequence[float | str] | None
# A function of a result, the values from which it starts, and a function that fits.
Diagnosis = Callable[[FitResult, Mapping[str, float], Refit], FitResult]
Path_ = str | os.PathLike[str]
TracesLike = Traces | Path_ | Sequence[Path_]
ChainLike = Chain | Path_ | Sequence[Chain]
# A parameter is at a bound if its variable is within this relative distance of it.
AT_BOUND = 1e-6


@checked_arguments("fit")
def fit(
    traces: TracesLike,
    chain: ChainLike,
    *,
    free: Sequence[str] | None = None,
    also_free: Sequence[str] | None = None,
    priors: Priors | None = None,
    start: Mapping[str, float] | None = None,
    time_offset: TimeOffset = None,
    begin: float | str | None = None,
    until: float | str | None = None,
    starts: int = 4,
    diagnose: bool = True,
    progress: Progress | None = None,
) -> FitResult:
    r"""Fit a chain and its sensors to measured traces.

    Minimises, over the free parameters :math:`\theta`,

    .. math::

        \sum_{i} \frac{[y_i - f_i(\theta)]^2}{\sigma_i^2}
        + \sum_{j} \frac{(\theta_j - \mu_j)^2}{s_j^2}

    with the samples y and their noise :math:`\sigma_i`, the simulated signals f after the sensor
    model (`hertzchain.fitting.sensors`), and the priors.  Changes of stiffness, velocity, gains and
    time offsets require no simulation if the exact scaling symmetry of chains holds
    (`hertzchain.fitting.symmetry`).

    Parameters
    ----------
    traces : Traces, path-like or sequence of path-like
        The data; paths are read by `hertzchain.load_traces`, one shot per file.
    chain : Chain, path-like or sequence of Chain
        The chain with nominal values, in SI units; one for all shots or one for each.  The table
        ``[fit]`` of a chain file gives ``free``, ``prior``, ``start``, ``time_offset`` and
        ``coupling``; arguments replace them.
    free : sequence of str, optional
        Names of the free parameters.  By default, the stiffness of all contacts (a factor, which
        does not include linear springs of walls), the striker's velocity, the parameters of the
        loss law, the time offset and the gains of sensors without calibration.  Of the chain:
        ``stiffness``, ``exponent``, ``loss.time``, ..., ``stiffness[8-9]``, ``gap[8-9]``,
        ``struck_by.velocity``, ``materials[NAME].young``,
        ``loss[8-9].time``, ``radius[8]``, ``mass[8]``, ``mass[5,10]`` (common), ``cap.mass``,
        ``precompression``, ``gravity``, ``right_wall.stiffness``, ...; balls are counted without
        strikers.  Of the sensors: ``gain[ball 6]``, ``gain[*]`` for each, ``offset[...]``,
        ``delay[...]``, ``lag``, ``highpass`` (1/time constant), ``crosstalk``.  Of the clock:
        ``time_offset``.  With several shots, ``NAME@2`` is of the second shot and ``NAME@*`` of
        each.
    also_free : sequence of str, optional
        Names that are free in addition to those of ``free``, of the chain file, or by default, such
        as ``["gap[8-9]"]``.
    priors : mapping, optional
        Value and standard deviation by name, such as ``{"struck_by.velocity": (0.3, 0.003)}``.
    start : mapping, optional
        Values from which to start, by name; by default those of the priors or the chain.  That of
        a ``time_offset`` that is not free is its value.
    time_offset : float, str or sequence, optional
        Known time of the data at which the simulation begins [s], such as ``"-50 us"``, for all
        shots or for each.  It is fixed unless ``time_offset`` is in ``free``, and the fit then
        starts from it.  By default, it is that of the table ``[fit]``, or the start of the drive if
        the chain file reads it from the file of the traces; otherwise it is free.
    begin, until : float or str, optional
        First and last time of the data to fit [s], such as ``"550 us"``; by default those of the
        record.  `Traces.between` selects the same samples.
    starts : int
        Largest number of starts, 1 to 6; more than one is used only if the first fit is poor or has
        not converged.  If a loss is free, a coarse scan over a tenth to five times its start then
        chooses one more start.
    diagnose : bool
        Whether further fits look for the cause if the model does not describe the data, which takes
        some minutes of processor time.  Without them, ``result.advice`` names only wrong columns,
        another number of balls and the zeros of sensors.
    progress : callable, optional
        Called as ``progress(simulations, 0)`` after each simulation.

    Returns
    -------
    FitResult
        Returned even if the search did not converge; check ``result.converged`` and
        ``result.reason``.

    Raises
    ------
    InputError
        For an unknown parameter or sensor, a parameter without any effect, priors that exclude each
        other, fewer samples than parameters, or a chain in scaled variables.
    SimulationError
        If the chain cannot be simulated with the values from which the fit starts.

    Examples
    --------
    Four sensors in a row of 20 steel balls; the data are synthetic:

    >>> import hertzchain as hc
    >>> traces, chain_file = hc.example_experiment()
    >>> result = hc.fit(traces, chain_file)
    >>> result.describes
    True
    """
    search = diagnosed if check_bool("diagnose", diagnose) else without_search
    return fit_experiment(
        traces, chain, search, free=free, also_free=also_free, priors=priors, start=start,
        time_offset=time_offset, begin=begin, until=until, starts=starts, progress=progress,
    )  # fmt: skip


def without_search(result: FitResult, start: Mapping[str, float], refit: Refit) -> FitResult:
    """The result with the advice that is found quickly."""
    return quickly_diagnosed(result, start, refit)[0]


def fit_experiment(
    traces: Any, chain: Any, diagnose: Diagnosis, *, free: Sequence[str] | None = None,
    also_free: Sequence[str] | None = None, priors: Priors | None = None,
    start: Mapping[str, float] | None = None, time_offset: TimeOffset = None,
    begin: float | str | None = None, until: float | str | None = None, starts: int = 4,
    progress: Progress | None = None,
) -> FitResult:  # fmt: skip
    """Fit as `fit` does, and diagnose the result with a function."""
    data, chains, settings = load_experiment(traces, chain, load_traces)
    callback("progress", progress)
    if begin is not None or until is not None:
        data = data.between(begin, until)
    settings = for_sensors(settings, data).updated(free, priors, start, time_offset)
    data = with_time_offset(data, time_offset)
    data, settings = with_clocks(data, settings.with_more(also_free, data, chains[0]))
    count = whole_number("starts", starts, least=1, most=6)
    problem = problem_of(data, chains, settings, progress)
    wrong = first_misread(problem, settings.start, fitted)
    if wrong is not None:
        result = as_misread(_at_values_of(problem, wrong.result), wrong)
    else:
        result = diagnose(fitted(problem, settings.start, count), settings.start, fitted)
        result = with_fits_without_priors(result, fitted)
    # Later simulations, such as those of scans and posteriors, report their own progress.
    result.model.simulator.progress = None
    return result


def fit_with(
    data: Traces, chains: Sequence[Chain], settings: Settings, starts: int,
    progress: Progress | None = None,
) -> FitResult:  # fmt: skip
    """Fit with checked traces and chains."""
    return fitted(problem_of(data, chains, settings, progress), settings.start, starts)


def problem_of(
    data: Traces, chains: Sequence[Chain], settings: Settings, progress: Progress | None = None
) -> Problem:
    """The problem of checked traces and chains."""
    parameters = free_parameters(
        data, chains, settings.free, settings.priors, settings.start, settings.optional
    )
    if data.samples <= len(parameters):
        raise InputError(
            f"{len(parameters)} parameters cannot be fitted to {data.samples} samples; free fewer"
        )
    check_used(parameters, data, chains)
    places = list({signal.name: signal.place for _, signal in data}.values())
    simulator = Simulator(places, None if progress is None else lambda done: progress(done, 0))
    model = _without_spikes(make_model(data, chains, parameters, simulator))
    return Problem(_coupled(model, settings.start))


def _at_values_of(problem: Problem, other: FitResult) -> FitResult:
    """A result without a search, at the values of the fit to data in another unit."""
    variables = other.variables
    solution = Solution(
        variables, problem.residuals(variables), problem.jacobian(variables), False,
        "not begun", 1,
    )  # fmt: skip
    return result_of(problem, solution)


def fitted(problem: Problem, start: Mapping[str, float], starts: int) -> FitResult:
    """Solve a problem; times and stiffness are aligned first, unless their start is given."""
    values = {each.name: _nonzero_loss(problem.model, each) for each in problem.model.parameters}
    values = with_gains(problem.model, values, start)
    problem = _with_signs(problem, values)
    align = not any(each.startswith(("time_offset", "stiffness")) for each in start)
    solution = solve(problem, values, starts, align=align)
    good = goodness_of_problem(problem, solution.residuals)
    correlated = correlations(problem, solution.residuals)
    # Residuals of a wrong model are correlated, too, but they do not measure the noise.
    if good.accepted and np.any(correlated != 1.0):
        problem.set_correlated(correlated)
        solution = solve_again(problem, solution)
    return result_of(problem, along_valleys(problem, solution))


def _without_spikes(model: Model) -> Model:
    """The model without single samples far from their neighbours, if the pulses are wider."""
    shots = list(model.traces.shots)
    for index, shot in enumerate(shots):
        if any(len(spikes(signal)) for signal in shot.signals):
            shots[index] = without_spikes(shot, pulse_widths(*nominal_pulses(model, index)[1:]))
    return replace(model, traces=Traces(tuple(shots)))


def _coupled(model: Model, start: Mapping[str, float]) -> Model:
    """The model with the coupling that the levels of its signals show, at the first gains."""
    values = with_gains(
        model, {each.name: _nonzero_loss(model, each) for each in model.parameters}, start
    )
    traces = resolved_coupling(
        model.traces, model.chains, lambda shot, signal: model.gain(shot, signal, values)
    )
    return replace(model, traces=traces)


def _nonzero_loss(model: Model, parameter: Parameter) -> float:
    """Start of a parameter; instead of a zero loss, where derivatives vanish, a typical one."""
    if "loss." not in parameter.name.key or parameter.start != parameter.kind.lower:
        return parameter.start
    if parameter.kind.scale == "1":
        return parameter.start + parameter.kind.typical
    unit = units_of(model.chains[parameter.shot or 0]).scales.unit(parameter.kind.scale)
    return parameter.kind.typical * unit


def _with_signs(problem: Problem, values: Mapping[Name, float]) -> Problem:
    """The problem whose parameters start with the signs of these values, which they keep."""
    parameters = tuple(
        replace(each, start=math.copysign(each.start, values[each.name]))
        if each.kind.signed else each
        for each in problem.model.parameters
    )  # fmt: skip
    if parameters == problem.model.parameters:
        return problem
    return Problem(replace(problem.model, parameters=parameters))


def result_of(problem: Problem, solution: Solution) -> FitResult:
    """The result at a solution."""
    model, variables = problem.model, solution.variables
    values = model.values(variables)
    names = tuple(map(str, model.names))
    count = len(problem.data)
    good = goodness_of_problem(problem, solution.residuals)
    weights = remaining_weights(problem, solution.residuals)
    jacobian, residuals = weights[:, None] * solution.jacobian, weights * solution.residuals
    low, high = problem.bounds()
    bound = (variables - low < AT_BOUND * np.maximum(1.0, np.abs(low))) | (
        high - variables < AT_BOUND * np.maximum(1.0, np.abs(high))
    )
    found = uncertainty(problem, variables, jacobian, bound)
    estimates, sigmas, weak = found.estimates, found.sigmas, found.weak
    chains = tuple(model.chain(shot, values) for shot in range(len(model.chains)))
    at_bounds = tuple(name for name, there in zip(names, bound, strict=True) if there)
    notes = conflict_notes(model.parameters, model.traces, values, sigmas)
    of_silent = undetermined(
        model.parameters, model.traces, *(
            dict(zip(names, each.tolist(), strict=True)) for each in (estimates, sigmas)
        ),
    )  # fmt: skip
    ends = tuple(each for each in at_bounds if each not in of_silent)
    notes += (*_other_shots(model), *_notes(model, found, ends))
    if good.skipped:
        notes += (
            f"{counted(good.skipped, 'sample')} next to jumps of the force "
            f"{'is' if good.skipped == 1 else 'are'} not used",
        )
    effects = effects_of(problem, values, jacobian, residuals)
    simulations = model.simulator.count
    duration = float(model.traces.shots[0].times[-1] - model.traces.shots[0].times[0])
    notes += (
        *inversion_notes(_gains(model, values)),
        *coupling_notes(model.traces, chains, lambda k, each: model.gain(k, each, values)),
        *small_residual_notes(problem, solution.residuals),
        *range_notes(chains[0], duration), *cap_notes(model, chains, values),
        *_sampling_notes(model, values),
        *filter(None, (solution.note,)),
    )  # fmt: skip
    penalty = float(solution.residuals[count:] @ solution.residuals[count:])
    return FitResult(
        names, estimates, sigmas, found.covariance, good, solution.converged, solution.reason, weak,
        effects, at_bounds, chains, notes, simulations, solution.starts, penalty,
        problem, variables, solution.jacobian, solution.residuals, scan=solution.scan,
        held=found.held,
    )  # fmt: skip


def _sampling_notes(model: Model, values: Mapping[Name, float]) -> list[str]:
    """Notes on shots with few samples during a pulse."""
    shots = model.traces.shots
    return [
        note for k, shot in enumerate(shots)
        for note in sampling_notes(
            shot, model.predict_shot(k, values), number=k + 1 if len(shots) > 1 else None
        )
    ]  # fmt: skip


def _gains(model: Model, values: Mapping[Name, float]) -> dict[str, float]:
    """Gains of sensors without calibration, by sensor; the smallest of all shots."""
    found: dict[str, float] = {}
    for shot, signal in model.traces:
        if not signal.calibrated:
            gain = model.gain(shot, signal, values)
            found[signal.name] = min(gain, found.get(signal.name, gain))
    return found


def _other_shots(model: Model) -> list[str]:
    """Notes on parameters of sensors and the clock that are free in some shots only."""
    shots = {str(k) for k in range(1, len(model.chains) + 1)}
    known = {str(k) for k, each in enumerate(model.traces.shots, start=1) if each.clock}
    free: dict[Name, set[str]] = {}
    for name in model.names:
        if name.key in ("gain", "time_offset"):
            free.setdefault(replace(name, shot=""), set()).add(name.shot)
    return [
        f"{name} is free in shot {listed(sorted(own))} only, and fixed at "
        f"{1 if name.key == 'gain' else 0} in shot {listed(sorted(shots - own))}: free "
        f"'{name}@*' for a value in each shot"
        for name, own in free.items()
        if "" not in own and own | (known if name.key == "time_offset" else set()) != shots
    ]


def _notes(model: Model, found: Uncertainty, at_bounds: tuple[str, ...]) -> tuple[str, ...]:
    """Notes on unused samples, bounds, large errors and failed runs, one sentence each."""
    notes = [*clock_notes(model.traces), *model.traces.notes()]
    notes += bound_notes(at_bounds)
    notes += large_error_notes(model, found)
    if {"stiffness", "exponent"} <= {name.key for name in model.names}:
        notes.append(
            f"stiffness is the factor of the forces at an overlap of {1e6 * model.reference:.3g} "
            "um, at which the exponent does not change them"
        )
    if any(name.key == "exponent" for name in model.names):
        follow = following(model.chains[0], model.names)
        notes += [
            f"{end.replace('_', ' ')} has its own exponent, which does not follow that of the beads"
            for end, same in zip(ENDS, follow, strict=True) if not same
        ]  # fmt: skip
    if model.simulator.failed:
        notes.append(f"{model.simulator.failed} trial runs failed and were rejected")
    return tuple(notes)

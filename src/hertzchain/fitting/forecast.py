"""Forecast the errors of a fit to the signals of a planned experiment."""

from __future__ import annotations

import math
import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Final

import numpy as np

from ..chain.bead_names import CAP, bead_number, numbered_bead, wall_number
from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError, short_repr
from ..recorded_warnings import ignore_warnings
from ..representation import SUMMARY_WIDTH, counted, folded, measure, short
from ..traces.headers import UNITS, header_of, in_volts, positive_noise
from ..traces.noise import check_names_of_noise, given_noise
from ..traces.places import Place, place_named
from ..traces.signals import Shot, Signal
from ..traces.traces import Traces, with_coupling, with_time_offset
from ..validation.json_types import finite
from ..validation.keywords import checked_arguments, checked_methods
from ..validation.numbers import number
from ..validation.objects import check_list, check_type
from .clocks import with_clocks
from .constants import FixedConstant, Optimum, fixed_constants
from .crossings import later_until, pulse_duration
from .flat_valleys import derivatives_at
from .held_by_priors import prior_notes
from .model import Model, Values, make_model
from .parameters import Parameter, Priors, free_parameters
from .planned_gains import CONVERTED, recorded_in_volts
from .planned_notes import planned_notes
from .problem import Problem
from .result_document import constants_document, parameters_document
from .settings import Settings, for_sensors, load_chain_and_settings
from .shown_values import shown_value, unit_of_parameter
from .simulations import Simulator, passing_time
from .summary_width import summary_width
from .uncertainty import Estimates, large_error_notes, uncertainty
from .unused_parameters import check_used
from .weak_directions import WeakDirection

# Largest number of samples; the derivatives of all of them are in memory.
MAX_SAMPLES: Final = 2_000_000
# Recommended samples per pulse: residuals of fewer do not show what a model lacks.
WELL_RESOLVED: Final = 10


@checked_methods
@dataclass(frozen=True, eq=False)
class Forecast(Estimates):
    """Expected errors of a fit to the signals of a planned experiment.

    Attributes
    ----------
    names : tuple of str
        Names of the free parameters.
    estimates, sigmas : ndarray
        Their assumed values and expected standard errors in SI units; factors have no unit.  The
        error is infinite if the data do not determine the parameter.
    covariance : ndarray
        Covariance of the values.
    weak : tuple of WeakDirection
        Combinations of parameters that the data do not determine.
    held : tuple of HeldByPriors
        Parameters whose errors come from priors more than from the data.
    sensors : tuple of str
        Names of the sensors.
    interval, duration : float
        Sampling interval, and time from the impact to the last sample [s].
    samples : int
        Number of samples of all sensors.
    pulse_durations : ndarray
        Time during which the signal of each sensor exceeds half of its maximum, around this maximum
        [s]; NaN if the signal does not rise and fall within the duration.
    notes : tuple of str
        Further remarks, one sentence each.
    """

    weak: tuple[WeakDirection, ...]
    sensors: tuple[str, ...]
    interval: float
    duration: float
    samples: int
    pulse_durations: Array
    notes: tuple[str, ...]
    problem: Problem = field(repr=False)
    variables: Array = field(repr=False)
    jacobian: Array = field(repr=False)

    @property
    def model(self) -> Model:
        """The model with which the signals are predicted."""
        return self.problem.model

    @cached_property
    def constants(self) -> tuple[FixedConstant, ...]:
        """Constants of the chain, gains and sampling interval that are taken as exact."""
        model, residuals = self.problem.model, np.zeros(len(self.jacobian))
        chain = model.chain(0, model.values(self.variables))
        return fixed_constants(Optimum(
            self.problem, self.variables, self.jacobian, residuals, self.estimates, self.sigmas,
            (chain,),
        ))  # fmt: skip

    @property
    def samples_per_pulse(self) -> Array:
        """Samples of each sensor during its pulse, at half of the maximum."""
        return self.pulse_durations / self.interval

    @property
    def recommended_interval(self) -> float:
        """Longest sampling interval with ten samples in the shortest pulse [s]; or NaN."""
        known = self.pulse_durations[np.isfinite(self.pulse_durations)]
        return float(known.min()) / WELL_RESOLVED if len(known) else math.nan

    @property
    def warnings(self) -> tuple[str, ...]:
        """Weak directions, priors and constants that matter, and notes, one sentence each."""
        constants = [each.note for each in self.constants if each.note]
        weak = (*(str(each) for each in self.weak), *prior_notes(self.held, self.weak))
        return (*weak, *constants, *self.notes)

    def rows(self) -> list[tuple[str, str]]:
        """Name, and value with error and unit, of each parameter.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.from_materials("5 mm", "brass", beads=12).struck_by(velocity="0.1 m/s")
        >>> plan = hc.forecast(chain, ["ball 5"], noise=0.02, interval="1 us", free=["stiffness"])
        >>> plan.rows()
        [('stiffness', '1.00000 +- 0.00019')]
        """
        triples = zip(self.model.parameters, self.estimates, self.sigmas, strict=True)
        return [
            (str(each), shown_value(
                each, self.model.traces, value, sigma, at_bound=False, digits=4
            ))
            for each, value, sigma in triples
        ]  # fmt: skip

    def summary(self, *, width: int | None = SUMMARY_WIDTH) -> str:
        """Values with errors and all remarks, as text.

        Parameters
        ----------
        width
            Number of columns at which lines are broken; None keeps each sentence on one line.

        Returns
        -------
        str

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.from_materials("5 mm", "brass", beads=12).struck_by(velocity="0.1 m/s")
        >>> plan = hc.forecast(chain, ["ball 5"], noise=0.02, interval="1 us", until="300 us")
        >>> print(plan.summary().splitlines()[0])
        3 parameters from 301 samples of 1 sensor, every 1 us for 300 us
        """
        longest = max(map(len, self.names))
        rows = [f"  {name:<{longest}}  {row}" for name, row in self.rows()]
        lines = "\n".join((self._about, *rows, self._pulses, *self.warnings))
        return folded(lines, summary_width(width))

    @property
    def _about(self) -> str:
        sensors = counted(len(self.sensors), "sensor")
        return (
            f"{counted(len(self.names), 'parameter')} from {self.samples} samples of {sensors}, "
            f"every {measure(self.interval, 's')} for {measure(self.duration, 's')}"
        )

    @property
    def _pulses(self) -> str:
        """Durations of all pulses, their samples, and the recommended interval."""
        shown = [
            f"{name} {measure(duration, 's', digits=3)}, {counted(int(samples), 'sample')}"
            if math.isfinite(duration) else f"{name} not complete"
            for name, duration, samples in zip(
                self.sensors, self.pulse_durations, self.samples_per_pulse, strict=True
            )
        ]  # fmt: skip
        advice = later_until(self.sensors, self.pulse_durations)
        if math.isfinite(self.recommended_interval):
            longest = measure(self.recommended_interval, "s", digits=3)
            advice = f" (at least {WELL_RESOLVED} are recommended: every {longest} or less){advice}"
        return f"pulse at half of its maximum: {'; '.join(shown)}{advice}"

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON: numbers that do not exist are `None`.

        Returns
        -------
        dict

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.from_materials("5 mm", "brass", beads=12).struck_by(velocity="0.1 m/s")
        >>> plan = hc.forecast(chain, ["ball 5"], noise=0.02, interval="1 us", free=["stiffness"])
        >>> plan.as_dict()["sensors"]
        ['ball 5']
        """
        model = self.problem.model
        found: dict[str, Any] = finite({
            "parameters": parameters_document(model, self.estimates, self.sigmas),
            "correlation": self.correlation.tolist(), "sensors": list(self.sensors),
            "samples": self.samples, "interval": self.interval, "duration": self.duration,
            "pulse_durations": dict(zip(self.sensors, self.pulse_durations.tolist(), strict=True)),
            "samples_per_pulse": dict(
                zip(self.sensors, self.samples_per_pulse.tolist(), strict=True)
            ),
            "recommended_interval": self.recommended_interval,
            "held_by_priors": [each.as_dict() for each in self.held],
            "warnings": list(self.warnings), "constants": constants_document(self.constants),
        })  # fmt: skip
        return found

    def _repr_html_(self) -> str:
        from ..notebook.fits import forecast_html

        return forecast_html(self)

    def __repr__(self) -> str:
        return short("Forecast", self._about, *(f"{name} {row}" for name, row in self.rows()))


@checked_arguments("forecast")
def forecast(
    chain: Chain | str | os.PathLike[str],
    sensors: Sequence[str],
    *,
    noise: float | str | Mapping[str, float | str],
    interval: float | str,
    free: Sequence[str] | None = None,
    also_free: Sequence[str] | None = None,
    priors: Priors | None = None,
    start: Mapping[str, float] | None = None,
    until: float | str | None = None,
) -> Forecast:
    r"""Forecast the errors of a fit to the signals of a planned experiment.

    The chain is simulated with the assumed values of the free parameters :math:`\theta`.  The
    derivatives J of the signals :math:`f_i` at the times of the samples determine the smallest
    covariance that an unbiased estimate from these data can have (the Cramér-Rao bound):

    .. math::

        C = (J^T W J + P)^{-1}, \quad J_{ij} = \frac{\partial f_i}{\partial\theta_j}, \quad
        W_{ii} = \sigma_i^{-2}, \quad P_{jj} = s_j^{-2}

    with the noise :math:`\sigma_i` of independent samples and the standard deviations :math:`s_j`
    of the priors.  `hertzchain.fit` reaches this bound if the noise is small enough for the signals
    to be linear functions of the parameters within their errors.

    Parameters
    ----------
    chain : Chain or path-like
        The chain with assumed values, in SI units.  The table ``[fit]`` of a chain file gives
        ``free``, ``prior``, ``start``, ``time_offset`` and ``coupling``; arguments replace them.
    sensors : sequence of str
        Places of the sensors, such as ``"ball 7"``, ``"wall"`` and ``"ball 3 velocity"``.  A sensor
        without calibration is ``"ball 7 [V]"``, or has a noise in V, such as ``"2 mV"``, or a free
        gain with a unit, such as ``"20 mV/N"``, which also converts a noise in N; a prior or
        ``start`` gives its gain in V/N, or, for a velocity, in V s/m.
    noise : float, str or mapping
        Standard deviation of a sample of all sensors, or by name, in N, m/s or V, or with a unit;
        the name ``"*"`` has all others.
    interval : float or str
        Sampling interval [s].
    free, also_free, priors : optional
        Free parameters and their priors, as for `hertzchain.fit`.
    start : mapping, optional
        Assumed values by name; by default those of the priors or the chain.
    until : float or str, optional
        Time from the impact to the last sample [s].  By default 1.5 times the time in which the
        pulse passes the chain.

    Returns
    -------
    Forecast

    Raises
    ------
    InputError
        For an unknown parameter or sensor, a parameter without any effect, a signal that does not
        exceed its noise, fewer samples than parameters, or a chain in scaled variables.
    SimulationError
        If the chain cannot be simulated.

    Notes
    -----
    The first sample is that of the impact.  Correlated noise and errors of constants that are taken
    as exact are not included; `Forecast.constants` has the influence of the latter.

    Examples
    --------
    Which error does the stiffness have with one sensor and with two?

    >>> import hertzchain as hc
    >>> balls = hc.Chain.from_materials("5 mm", "brass", beads=20).struck_by(velocity="0.1 m/s")
    >>> chain = balls.replace(right_wall=hc.Wall(), loss=hc.Restitution(0.96))
    >>> free = ["stiffness", "loss.coefficient", "time_offset"]
    >>> for sensors in (["ball 7"], ["ball 7", "wall"]):
    ...     plan = hc.forecast(chain, sensors, noise="0.02 N", interval="1 us", free=free)
    ...     print(plan.rows()[0])
    ('stiffness', '1.00000 +- 0.00050')
    ('stiffness', '1.00000 +- 0.00010')
    """
    settings = Settings()
    if isinstance(chain, str | os.PathLike):
        chain, settings = load_chain_and_settings(chain)
    check_type("chain", chain, Chain, "or give the path of a chain file")
    if chain.scaled:
        raise InputError(
            "the noise of sensors is in SI units, but the chain is in scaled variables; build it "
            "with Chain.from_materials"
        )
    planned = planned_traces(chain, sensors, noise, interval, until)
    traces = with_coupling(planned, settings.coupling)
    with ignore_warnings():  # of other sensors in the chain file: a plan compares several sets
        settings = for_sensors(settings, traces).updated(free, priors, start)
    settings = settings.with_more(also_free, settings.timed(traces), chain)
    traces, of_gains = recorded_in_volts(traces, settings)
    traces, settings = with_clocks(settings.timed(traces), settings)
    if traces.shots[0].clock is not None:
        traces = with_time_offset(traces, 0.0)  # the first sample is that of the impact
    return _forecast(traces, chain, settings, of_gains, given=until is not None)


def _forecast(
    traces: Traces, chain: Chain, settings: Settings, of_gains: tuple[str, ...], *, given: bool
) -> Forecast:
    """Errors from derivatives at the values from which a fit would start."""
    parameters = free_parameters(
        traces, (chain,), settings.free, settings.priors, settings.start, settings.optional
    )
    _check_gains(parameters, traces, settings.start)
    if traces.samples <= len(parameters):
        raise InputError(
            f"{len(parameters)} parameters cannot be fitted to {traces.samples} samples; free "
            "fewer, or use a shorter interval"
        )
    check_used(parameters, traces, (chain,))
    (shot,) = traces.shots
    simulator = Simulator([each.place for each in shot.signals])
    problem = Problem(make_model(traces, (chain,), parameters, simulator))
    model, duration = problem.model, float(shot.times[-1])
    values = {each.name: each.start for each in parameters}
    variables = model.variables(values)
    for signal, seen in zip(shot.signals, model.predict(values)[0], strict=True):
        if np.ptp(seen) < signal.sigma:
            raise InputError(
                f"the signal of {signal.name} does not exceed its noise within "
                f"{measure(duration, 's')}; give a later until, or check the noise"
            )
    if problem.jumps:
        problem.skip_next_to_jumps(variables, more=False)
    jacobian = derivatives_at(problem, variables)
    found = uncertainty(problem, variables, jacobian, np.zeros(len(variables), bool))
    notes = (
        *of_gains, *large_error_notes(model, found),
        *planned_notes(model, values, duration, given=given),
    )  # fmt: skip
    return Forecast(
        tuple(map(str, model.names)), found.estimates, found.sigmas, found.covariance, found.weak,
        traces.names, float(shot.times[1]), duration, traces.samples,
        _pulse_durations(model, values, duration), notes, problem, variables, jacobian,
        held=found.held,
    )  # fmt: skip


def _pulse_durations(model: Model, values: Values, duration: float) -> Array:
    """Durations of the pulses of all sensors, from the saved times of the simulation."""
    simulator = model.simulator
    run = simulator.signals(model.chain(0, values), duration)
    times = run.spacing * np.arange(len(run.columns))
    times = times[: int(np.searchsorted(times, duration, side="right"))]
    columns = [simulator.column(run, each)[: len(times)] for each in model.traces.shots[0].signals]
    return np.array([pulse_duration(times, each - each[0]) for each in columns])


def planned_traces(
    chain: Chain, sensors: object, noise: Any, interval: object, until: object
) -> Traces:
    """Traces with the times, places, units and noise of the planned signals."""
    step = number("interval", interval, unit="s", above=0.0)
    last = passing_time(chain) if until is None else number("until", until, unit="s", above=0.0)
    if not math.isfinite(last):
        raise InputError("the time in which a pulse passes this chain is not known; give until")
    places = [_place(each, chain, noise) for each in check_list("sensors", sensors, "names")]
    if not places:
        raise InputError("there is no sensor; name at least one, such as 'ball 6'")
    count = int(last / step * (1.0 + 1e-12)) + 1
    if not 2 <= count <= MAX_SAMPLES // len(places):
        size = "short" if count > 2 else "long"
        raise InputError(
            f"an interval of {measure(step, 's')} is too {size} for {measure(last, 's')}: each "
            f"sensor must have from 2 to {MAX_SAMPLES // len(places)} samples, not {count}"
        )
    check_names_of_noise(noise, [place.name for place, _ in places])
    signals = []
    for place, unit in places:
        own = given_noise(noise, place.name)
        if own is None:
            raise InputError(f"{place.name} has no noise; give noise for each sensor")
        sigma = positive_noise(place.name, own, unit, CONVERTED)
        signals.append(Signal(place, unit, np.zeros(count), np.ones(count, bool), sigma, 0, 0.0))
    return Traces((Shot(step * np.arange(count), tuple(signals)),))


def _place(text: object, chain: Chain, noise: Any) -> tuple[Place, str]:
    """Place of a sensor in a chain, and the unit of its signal, by default that of its noise."""
    try:
        if isinstance(text, str) and text.strip().endswith("]"):
            place, unit, _ = header_of(text)
        else:
            place, unit = place_named(str(text)), ""
    except InputError:
        raise InputError(
            "sensors must be names such as 'ball 6', 'bead 7', 'wall', 'ball 3 velocity' or, "
            f"without calibration, 'ball 6 [V]', got {short_repr(text)}"
        ) from None
    unit = unit or ("V" if in_volts(given_noise(noise, place.name)) else UNITS[place.quantity])
    if place.body in ("left", "right"):
        wall_number(chain, "load cell" if place.cell else f"{place.body} wall")
    elif place.body == CAP:
        bead_number(chain, CAP)
    else:
        numbered_bead(chain, place.body, place.number)
    return place, unit


def _check_gains(parameters: Sequence[Parameter], traces: Traces, start: Collection[str]) -> None:
    """Raise `InputError` if neither a prior nor a start gives the gain of a sensor in V."""
    volts = {item for _, each in traces if not each.calibrated for item in ("", each.name)}
    for each in parameters:
        known = each.prior is not None or str(each) in start
        if each.name.key == "gain" and not known and each.name.item in volts:
            unit = f" in {unit}" if (unit := unit_of_parameter(each, traces)) else ""
            known_as = f"such as {{{str(each)!r}: 0.01}}"
            raise InputError(f"{each} is not known: give it a prior{unit}, or a start {known_as}")

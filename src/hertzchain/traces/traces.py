"""Measured traces: signals of sensors over time, in one or several shots."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError, short_repr, unknown_name_error
from ..representation import counted, short, shown_signal
from ..validation.keywords import checked_arguments, checked_fields, checked_methods
from ..validation.numbers import number, real_numbers
from ..validation.objects import check_choice, check_list, check_type
from .headers import header_of
from .noise import check_names_of_noise
from .notes import trace_notes
from .places import by_usual_name, usual_name
from .shots import check_times, made_again, make_shot, shot_between
from .signals import Clock, Shot, Signal, merged_shots

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes

COUPLINGS = ("AC", "DC")


@checked_fields
@checked_methods
@dataclass(frozen=True, eq=False)
class Traces:
    """Measured traces; `hertzchain.load_traces` reads them from CSV files.

    Attributes
    ----------
    shots : tuple of Shot
        One for each impact.

    Examples
    --------
    >>> import hertzchain as hc
    >>> import numpy as np
    >>> times = 1e-6 * np.arange(60)
    >>> pulse = np.exp(-(((times - 40e-6) / 5e-6) ** 2))
    >>> hc.Traces.from_arrays(times, {"ball 6 [N]": 30.0 * pulse}, noise=0.1)
    Traces(1 shot, ball 6: 60 samples, every 1 us; noise 0.1 N)
    """

    shots: tuple[Shot, ...]

    def __post_init__(self) -> None:
        shots = check_list("shots", self.shots, "shots")
        for shot in shots:
            check_type("shot", shot, Shot, "hc.Traces.from_arrays makes traces from arrays")
        if not shots:
            raise InputError("there must be at least one shot, got none")
        object.__setattr__(self, "shots", tuple(shots))

    @classmethod
    @checked_arguments("Traces.from_arrays")
    def from_arrays(
        cls,
        times: ArrayLike,
        signals: Mapping[str, ArrayLike],
        *,
        noise: float | Mapping[str, float] | None = None,
        coupling: str | Mapping[str, str] | None = None,
    ) -> Traces:
        """One shot from arrays.

        Parameters
        ----------
        times : array_like, shape (n,)
            Increasing times [s].
        signals : mapping
            Samples by sensor and unit, such as ``"ball 6 [N]"``; NaN where one is missing, and
            infinite where the signal is beyond the range of the digitiser.
        noise : float or mapping, optional
            Standard deviation of the noise of all sensors, or by name, in N, m/s or V, or with
            a unit; the name ``"*"`` has all others.  By default it is estimated for each sensor
            from the samples before its own pulse arrives.
        coupling : {"AC", "DC"} or mapping, optional
            Whether the signals of all sensors, or by name, contain the static force of a
            precompressed chain (``"DC"``) or not (``"AC"``, also for piezoelectric sensors).  By
            default, this is decided by their mean before the pulse.

        Returns
        -------
        Traces

        Raises
        ------
        InputError
            If times do not increase, lengths differ, a name or unit is unknown, a signal is
            constant, saturated during its pulse, or has too few samples before the pulse.

        Examples
        --------
        >>> import hertzchain as hc
        >>> times = [0.0, 1e-6, 2e-6, 3e-6]
        >>> hc.Traces.from_arrays(times, {"wall [kN]": [0.0, 0.01, 0.02, 0.01]}, noise=0.1)
        Traces(1 shot, wall: 4 samples, every 1 us; noise 0.1 N)
        """
        moments = real_numbers("time", times, "sample", unit="s")
        check_times(moments)
        if not isinstance(signals, Mapping):
            raise InputError(
                "signals must be a mapping such as {'ball 6 [N]': samples}, got "
                f"{short_repr(signals)}"
            )
        columns = {}
        for header, given in signals.items():
            place, unit, factor = header_of(header)
            columns[place, unit] = factor * real_numbers(header, given, "sample")
        check_names_of_noise(noise, [place.name for place, _ in columns])
        return with_coupling(cls((make_shot(moments, columns, noise),)), coupling)

    def __add__(self, other: Traces) -> Traces:
        return Traces(self.shots + other.shots)

    def merge(self, other: Traces) -> Traces:
        """Combine sensors that were recorded together, such as one file for each channel.

        Noises that were not given are estimated again, because a sensor may pick up the pulses of
        the others.

        Parameters
        ----------
        other : Traces
            Signals of other sensors, in the same shots and at the same times.

        Returns
        -------
        Traces

        Raises
        ------
        InputError
            If shots or times differ, a sensor is in both, or too few samples are before the pulse.

        Examples
        --------
        >>> import hertzchain as hc
        >>> times = [0.0, 1e-6, 2e-6]
        >>> first = hc.Traces.from_arrays(times, {"ball 6 [N]": [0.0, 4.0, 1.0]}, noise=0.1)
        >>> second = hc.Traces.from_arrays(times, {"wall [N]": [0.0, 0.5, 7.0]}, noise=0.1)
        >>> first.merge(second).names
        ('ball 6', 'wall')
        """
        check_type("other", other, Traces, "hc.load_traces returns them")
        return merged(self, other, "shots")

    def with_scaled_times(self, factor: float) -> Traces:
        """Multiply all times, such as those that are recorded in another unit than they state.

        Parameters
        ----------
        factor : float
            Positive factor, such as 0.001 for milliseconds that were read as seconds.

        Raises
        ------
        InputError
            If the factor is not positive and finite.

        Examples
        --------
        >>> import hertzchain as hc
        >>> read = hc.Traces.from_arrays([0.0, 1e-3, 2e-3], {"wall [N]": [0, 5, 1]}, noise=0.1)
        >>> read.with_scaled_times(0.001)
        Traces(1 shot, wall: 3 samples, every 1 us; noise 0.1 N)
        """
        factor = number("factor", factor, unit="", above=0.0)
        return Traces(tuple(shot.with_scaled_times(factor) for shot in self.shots))

    def between(self, begin: float | str | None = None, until: float | str | None = None) -> Traces:
        """Select the samples from one time of the data to another.

        Select earlier samples if the chain does not describe later ones, such as those after the
        cap of a load cell has left its wall.  The noise is measured again if ``begin`` omits
        samples before the pulse.

        Parameters
        ----------
        begin, until : float or str, optional
            First and last time of the data [s], or with a unit, such as ``"550 us"``.  By default,
            those of the record.

        Returns
        -------
        Traces

        Raises
        ------
        InputError
            If fewer than two samples remain, or too few before the pulse to measure the noise.

        Examples
        --------
        >>> import hertzchain as hc
        >>> read = hc.Traces.from_arrays([0.0, 1e-6, 2e-6], {"wall [N]": [0, 5, 1]}, noise=0.1)
        >>> read.between(until="1 us")
        Traces(1 shot, wall: 2 samples, every 1 us; noise 0.1 N)
        """
        first = -math.inf if begin is None else number("begin", begin, unit="s")
        last = math.inf if until is None else number("until", until, unit="s")
        return Traces(tuple(shot_between(shot, first, last) for shot in self.shots))

    def __iter__(self) -> Iterator[tuple[int, Signal]]:
        """Pairs of the index of the shot and the signal."""
        for index, shot in enumerate(self.shots):
            yield from ((index, signal) for signal in shot.signals)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all sensors."""
        return tuple(dict.fromkeys(signal.name for _, signal in self))

    @property
    def samples(self) -> int:
        """Number of valid samples."""
        return sum(int(signal.valid.sum()) for _, signal in self)

    def notes(self) -> tuple[str, ...]:
        """Remarks on bad, missing, saturated and rounded samples, missing rows and uneven steps.

        Returns
        -------
        tuple of str
            One sentence each.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.Traces.from_arrays([0.0, 1e-6, 3e-6], {"wall [N]": [0, 5, 1]}, noise=0.1).notes()
        ('shot 1 is sampled unevenly, every 1 to 2 us; nothing is resampled',)
        """
        return trace_notes(self.shots)

    def to_xarray(self) -> xr.Dataset:
        """Labelled dataset: one variable per shot and sensor.

        Returns
        -------
        xarray.Dataset
            Variables such as ``ball_6`` (``ball_6_shot_2``) over ``time`` (``time_2``), with units
            and noise as attributes.

        Examples
        --------
        >>> import hertzchain as hc
        >>> traces = hc.Traces.from_arrays([0.0, 1e-6], {"wall [N]": [0.0, 5.0]}, noise=0.1)
        >>> traces.to_xarray()["wall"].attrs["units"]
        'N'
        """
        import xarray as xr

        variables: dict[str, Any] = {}
        coordinates: dict[str, Any] = {}
        for index, shot in enumerate(self.shots, start=1):
            time = "time" if index == 1 else f"time_{index}"
            coordinates[time] = (time, shot.times, {"units": "s"})
            for signal in shot.signals:
                name = signal.name.replace(" ", "_") + (f"_shot_{index}" if index > 1 else "")
                about = {"units": signal.unit, "noise": signal.noise, "digitiser_step": signal.step}
                variables[name] = (time, np.where(signal.valid, signal.values, np.nan), about)
        return xr.Dataset(variables, coords=coordinates)

    def to_dataframe(self) -> pd.DataFrame:
        """Table of all samples that are used, one row per shot and time.

        Returns
        -------
        pandas.DataFrame
            Columns ``shot``, ``time`` and one per sensor, which is NaN where a sample is missing or
            not used; ``attrs["units"]`` has their units, those of sensors in the first shot.

        Examples
        --------
        >>> import hertzchain as hc
        >>> traces = hc.Traces.from_arrays([0.0, 1e-6], {"wall [N]": [0.0, 5.0]}, noise=0.1)
        >>> traces.to_dataframe().attrs["units"]
        {'time': 's', 'wall': 'N'}
        """
        import pandas as pd

        parts = [
            pd.DataFrame({"shot": index, "time": shot.times} | {
                each.name: np.where(each.valid, each.values, np.nan) for each in shot.signals
            })
            for index, shot in enumerate(self.shots, start=1)
        ]  # fmt: skip
        table = pd.concat(parts, ignore_index=True)
        units = {signal.name: signal.unit for _, signal in reversed([*self])}
        table.attrs["units"] = {"time": "s"} | {name: units[name] for name in self.names}
        return table

    def plot(self, *, legend: bool = True, ax: Axes | None = None) -> Axes:
        """Plot all signals over time; samples that are not used are crossed out.

        Parameters
        ----------
        legend : bool
            Whether the axes have a legend.
        ax : matplotlib.axes.Axes, optional
            Axes to draw into; by default those of a new figure.

        Returns
        -------
        matplotlib.axes.Axes

        Examples
        --------
        >>> import hertzchain as hc
        >>> traces = hc.Traces.from_arrays([0.0, 1e-6], {"wall [N]": [0.0, 5.0]}, noise=0.1)
        >>> traces.plot().get_xlabel()
        'time [µs]'
        """
        from ..plotting.fits import plot_traces

        return plot_traces(self, legend=legend, ax=ax)

    def _repr_html_(self) -> str:
        from ..notebook.fits import traces_html

        return traces_html(self)

    def __repr__(self) -> str:
        shot = self.shots[0]
        steps = 1e6 * np.diff(shot.times)
        noises = ", ".join(
            dict.fromkeys(shown_signal(signal.sigma, signal.unit) for _, signal in self)
        )
        every = f"{len(shot.times)} samples, every {np.median(steps):.3g} us"
        about = f"{counted(len(self.shots), 'shot')}, {', '.join(self.names)}"
        return short("Traces", about, every, f"noise {noises}", *self.notes())


def merged(first: Traces, second: Traces, what: str) -> Traces:
    """Traces with the sensors of two, which messages call shots or channels."""
    if len(first.shots) != len(second.shots):
        raise InputError(
            f"traces of {counted(len(first.shots), 'shot')} cannot be merged with "
            f"{counted(len(second.shots), 'shot')}; both must have the same shots"
        )
    shots = zip(first.shots, second.shots, strict=True)
    return Traces(tuple(made_again(merged_shots(one, other, what)) for one, other in shots))


def with_coupling(traces: Traces, coupling: Any) -> Traces:
    """Traces whose sensors have a coupling: one for all, or by name; `None` changes nothing."""
    if coupling is None:
        return traces
    if isinstance(coupling, Mapping):
        for name in coupling:
            if usual_name(name) not in traces.names:
                raise unknown_name_error("sensor of coupling", str(name), traces.names)
        given = by_usual_name(coupling)
    else:
        given = dict.fromkeys(traces.names, coupling)
    for name, value in given.items():
        check_choice(f"coupling of {name}", value, COUPLINGS)
    return mapped(
        traces, lambda _, each: replace(each, coupling=given.get(each.name, each.coupling))
    )


def with_time_offset(traces: Traces, time_offset: Any) -> Traces:
    """Traces with a known time offset, one for all shots or for each; `None` changes nothing."""
    if time_offset is None:
        return traces
    count = len(traces.shots)
    given = list(time_offset) if isinstance(time_offset, list | tuple) else [time_offset] * count
    if len(given) != count:
        raise InputError(
            f"time_offset has {counted(len(given), 'value')}, but there are "
            f"{counted(count, 'shot')}; give one value for all, or one for each"
        )
    clocks = [Clock(number("time_offset", each, unit="s")) for each in given]
    pairs = zip(traces.shots, clocks, strict=True)
    return Traces(tuple(replace(shot, clock=clock) for shot, clock in pairs))


def mapped(traces: Traces, change: Callable[[int, Signal], Signal]) -> Traces:
    """Traces with the signals that a function of shot and signal returns."""
    return Traces(tuple(
        replace(shot, signals=tuple(change(index, signal) for signal in shot.signals))
        for index, shot in enumerate(traces.shots)
    ))  # fmt: skip

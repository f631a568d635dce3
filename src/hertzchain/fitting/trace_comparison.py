"""Comparison of data with a simulation, without any fit."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ..collision import Array
from ..errors import InputError
from ..representation import short
from ..simulation.run import Run
from ..validation.numbers import number
from ..validation.objects import check_type
from .coupling import coupling_notes, resolved_coupling, static_force
from .sensors import sampled
from .traces import Signal, Traces

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class TraceComparison:
    """Measured signals and those of a run at the same times.

    Attributes
    ----------
    traces : Traces
        The data, of one shot.
    signals : tuple of ndarray
        Simulated signals at the times of the data [N or m/s]; NaN beyond the end of the run.
    time_offset : float
        Time of the data at which the simulation begins [s].
    notes : tuple of str
        Sensors whose signal does not contain the static force, in a sentence.
    """

    traces: Traces
    signals: tuple[Array, ...] = field(repr=False)
    time_offset: float
    notes: tuple[str, ...] = ()

    @property
    def differences(self) -> dict[str, float]:
        """Rms of data minus simulation, relative to the largest simulated value, by sensor.

        Uncalibrated sensors are first scaled to the simulation.
        """
        return {signal.name: self._difference(i) for i, signal in enumerate(self._signals)}

    @property
    def _signals(self) -> tuple:  # type: ignore[type-arg]
        return self.traces.shots[0].signals

    @property
    def scales(self) -> tuple[float, ...]:
        """Factors of the simulation that fit the data best; 1 for calibrated sensors."""
        return tuple(map(self._scale, range(len(self.signals))))

    def _scale(self, i: int) -> float:
        signal, model = self._signals[i], self.signals[i]
        if signal.calibrated:
            return 1.0
        ok = signal.valid & np.isfinite(model)
        return float(signal.values[ok] @ model[ok] / (model[ok] @ model[ok]))

    def _difference(self, i: int) -> float:
        signal, model = self._signals[i], self._scale(i) * self.signals[i]
        ok = signal.valid & np.isfinite(model)
        rest = signal.values[ok] - model[ok]
        return float(np.sqrt(np.mean(rest**2)) / np.abs(model[ok]).max())

    def plot(self) -> Figure:
        """Plot data and simulation, one panel per sensor.

        Returns
        -------
        matplotlib.figure.Figure

        Examples
        --------
        >>> import hertzchain as hc
        >>> traces, chain = hc.example_experiment()
        >>> run = hc.simulate(hc.load_chain(chain), until=600e-6, times=1201)
        >>> len(run.compare(traces).plot().axes)
        4
        """
        from ..plotting.fits import plot_comparison

        return plot_comparison(self)

    def __repr__(self) -> str:
        rows = ", ".join(f"{name} {value:.2%}" for name, value in self.differences.items())
        offset = f"time offset {1e6 * self.time_offset:.4g} us"
        return short("TraceComparison", f"rms difference over peak: {rows}", offset, *self.notes)


def compare_traces(
    run: Run, traces: Traces, *, time_offset: float | None = None
) -> TraceComparison:
    """Compare a run with measured traces of one shot; `hertzchain.Run.compare` documents it."""
    check_type("traces", traces, Traces, "hc.load_traces returns them")
    if run.chain.scaled:
        raise InputError(
            "traces are in SI units, but the run is in scaled variables; simulate a chain of "
            "Chain.from_materials"
        )
    if len(run.times) < 20:
        raise InputError(
            f"the run has {len(run.times)} saved times, too few to compare; give simulate times of "
            "at least 20"
        )
    if len(traces.shots) != 1:
        raise InputError(
            f"there are {len(traces.shots)} shots; compare a run with one shot: Traces(shots[:1])"
        )
    traces = resolved_coupling(traces, [run.chain])
    shot = traces.shots[0]
    grid = np.linspace(run.times[0], run.times[-1], len(run.times))
    columns = [np.interp(grid, run.times, _signal_of(run, signal)) for signal in shot.signals]
    spacing = float(grid[1] - grid[0])
    if time_offset is not None:
        time_offset = number("time_offset", time_offset, unit="s")
    else:
        time_offset = _best_offset(shot, columns, spacing)
    moments = shot.times - time_offset - run.times[0]
    inside = moments <= grid[-1] - grid[0]
    if not inside.any():
        raise InputError(
            f"with time_offset = {time_offset:g} s, the run ends before the first sample of the "
            "traces; give another one, or simulate for longer"
        )
    signals = []
    for column in columns:
        values = np.full(len(moments), np.nan)
        values[inside] = sampled(column, spacing, moments[inside])
        signals.append(values)
    notes = coupling_notes(traces, [run.chain])
    return TraceComparison(traces, tuple(signals), float(time_offset), notes)


def _signal_of(run: Run, signal: Signal) -> Array:
    """Simulated signal of a sensor; with AC coupling, without the static force."""
    found = signal.place.signal(run)
    return found - static_force(signal.place, run.chain) if signal.coupling == "AC" else found


def _best_offset(shot, columns: list[Array], spacing: float) -> float:  # type: ignore[no-untyped-def]
    """Time offset of the largest cross-correlation."""
    from scipy.signal import correlate

    total: Array | float = 0.0
    count = int((shot.times[-1] - shot.times[0]) / spacing) + 1
    grid = shot.times[0] + spacing * np.arange(count)
    for signal, column in zip(shot.signals, columns, strict=True):
        seen = np.interp(grid, shot.times[signal.valid], signal.values[signal.valid])
        total = total + correlate(seen, column) / (np.std(seen) * np.linalg.norm(column) + 1e-300)
    best = int(np.argmax(total)) - (len(columns[0]) - 1)
    return float(shot.times[0] + best * spacing)

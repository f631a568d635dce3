"""HTML representations of traces, their comparison with a run, fits, laws and defects."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from typing import Final

import numpy as np

from ..collision import Array
from ..fitting.defect_scan import DefectScan
from ..fitting.forecast import Forecast
from ..fitting.goodness import NO_ERRORS
from ..fitting.loss_comparison import LossComparison
from ..fitting.posterior import Posterior
from ..fitting.result import FitResult
from ..fitting.sensor_comparison import HEADINGS, MEASURED_HEADINGS
from ..fitting.trace_comparison import TraceComparison
from ..representation import counted
from ..traces.signals import Shot
from ..traces.traces import Traces
from .drawing import (
    COLOURS,
    COLUMNS,
    Curve,
    axis_unit,
    chart,
    engineering,
    legend,
    note,
    numbers,
    page,
    sentence,
    table,
    thinned,
)

# Sensors whose signals are drawn, and the heights of the figures of each of several.
MAX_SENSORS: Final = 6
HEIGHT: Final = 130
RESIDUAL_HEIGHT: Final = 100
# Approximate number of points of a simulated curve, which is smooth.
MODEL_POINTS: Final = 200
# Columns of all figures of signals, in each of which the smallest and the largest sample are drawn.
SIGNAL_COLUMNS: Final = 450
# Points of all figures of residuals.
RESIDUAL_POINTS: Final = 450
MEASURED, MODEL, RESIDUAL, BAND = COLOURS[0], COLOURS[1], COLOURS[2], COLOURS[5]


def traces_html(traces: Traces) -> str:
    """First signals, and noise and unused samples of each sensor."""
    rows = [
        (signal.name, f"{index + 1}", counted(int(signal.valid.sum()), "sample"),
         engineering(float(np.nanmax(np.abs(signal.values))), signal.unit),
         engineering(signal.sigma, signal.unit))
        for index, signal in traces
    ]  # fmt: skip
    step = float(np.median(np.diff(traces.shots[0].times)))
    shown = {
        "shots": f"{len(traces.shots)}",
        "samples": f"{len(traces.shots[0].times)}",
        "every": engineering(step, "s"),
    }
    return page(
        "Traces", ", ".join(traces.names),
        *_figures(traces.shots), numbers(shown),
        table(("sensor", "shot", "used", "largest", "noise"), rows), *_notes(traces.notes()),
    )  # fmt: skip


def trace_comparison_html(found: TraceComparison) -> str:
    """Data and simulation of the first sensors, and the table of all."""
    headings = MEASURED_HEADINGS if found.exchanged else HEADINGS
    cells = [each.measured_cells if found.exchanged else each.cells for each in found.sensors]
    shown = {} if found.exchanged else {
        "time offset": found.time_offset_text,
        "found by": "least squares" if found.clock is None else found.clock.reason,
        "compared": f"{found.covered:.0%} of the record",
    }  # fmt: skip
    return page(
        "TraceComparison", "data and simulation", *_notes([found._statement]),
        legend((("data", MEASURED), ("simulation", MODEL))),
        *_figures(found.traces.shots, [found.scaled]), numbers(shown), table(
            headings, [(each.name, *own) for each, own in zip(found.sensors, cells, strict=True)]
        ),
        *_notes(found.notes[found.exchanged :]),
    )  # fmt: skip


def fit_html(result: FitResult) -> str:
    """The verdict, data, fit and residuals of the first sensors, the parameters and all notes."""
    residuals = [values for *_, values in result.residuals()]
    verdict = result.verdict.replace(NO_ERRORS, NO_ERRORS.replace("above", "below"))
    per_sample = result.chi2_per_sample
    local = [result.restitution.row] if result.restitution else []
    about = f"{counted(len(result.names), 'parameter')} from {result.traces.samples} samples"
    return page(
        "FitResult", about, *_notes((verdict,), _names(result)),
        legend((("data", MEASURED), ("fit", MODEL), ("residual / noise", RESIDUAL),
                ("±2σ of the noise", BAND))),
        *_figures(result.traces.shots, result.predicted, residuals),
        table(("parameter", "value"), [*result.rows(), *local]),
        numbers({f"chi2 per sample, {name}": f"{value:.3g}" for name, value in per_sample.items()}),
        *_notes((*result.warnings, result._loss_note), _names(result)),
    )  # fmt: skip


def forecast_html(plan: Forecast) -> str:
    """Expected errors of all parameters, and all notes."""
    return page(
        "Forecast",
        plan._about,
        table(("parameter", "value"), plan.rows()),
        *_notes((plan._pulses, *plan.warnings), _names(plan)),
    )


def loss_comparison_html(compared: LossComparison) -> str:
    """All laws with BIC, chi-squared and parameters, and what the data decide."""
    rows = []
    for each in compared.fits:
        if each.result is None:
            rows.append((each.law, "failed", "", each.reason))
            continue
        values = [f"{name} = {row}" for name, row in each.result.rows() if "loss" in name]
        delta = each.bic - compared.fits[0].bic
        rows.append(
            (each.law, f"{delta:.1f}", f"{each.result.chi2:.1f}{each.mark}", ", ".join(values))
        )
    return page(
        "LossComparison", counted(len(rows), "law"),
        table(("law", "delta BIC", "chi2", "parameters"), rows), *_notes(compared._notes),
    )  # fmt: skip


def defect_scan_html(scan: DefectScan) -> str:
    """Part of chi-squared that each defect would explain, and the best of them."""
    place = np.arange(1.0, len(scan.names) + 1.0)
    curve = Curve(place, np.maximum(scan.improvements, 0.0), scan.kind)
    shown = {"largest at": scan.best, "reduction of chi2": f"{scan.improvements.max():.4g}",
             "chi2 of the fit": f"{scan.chi2:.4g}"}  # fmt: skip
    text = scan._rivals if scan.found else f"no {scan.kind} explains more than noise would"
    return page(
        "DefectScan", scan.kind,
        chart([curve], f"{scan.kind}, from {scan.names[0]} to {scan.names[-1]}",
              "reduction of chi2", whole=True),
        numbers(shown), *_notes((text,)),
    )  # fmt: skip


def posterior_html(posterior: Posterior) -> str:
    """Mean and standard deviation of each parameter."""
    rows = table(("parameter", "mean and error"), posterior._rows())
    about = counted(len(posterior.samples), "sample")
    return page("Posterior", about, rows, *_notes(filter(None, [posterior._too_short()])))


def _figures(
    shots: Sequence[Shot],
    models: Sequence[Sequence[Array]] = (),
    residuals: Sequence[Array] = (),
) -> list[str]:
    """Signals, models and residuals of the first sensors of the shots over time."""
    signals = [(shot, i, each) for shot, data in enumerate(shots)
               for i, each in enumerate(data.signals)]  # fmt: skip
    count = min(len(signals), MAX_SENSORS)
    parts, columns, drawn = [], min(SIGNAL_COLUMNS // count, COLUMNS), [0, 0]
    for number, (shot, i, signal) in enumerate(signals[:count]):
        factor, second = axis_unit(shots[shot].times, "s", "SI")
        times, time = factor * shots[shot].times, f"time{second}"
        unit, label = axis_unit(signal.values, signal.unit, "SI")
        seen = np.where(signal.valid, signal.values, np.nan)
        curves = [
            Curve(*thinned(times, unit * seen, columns), "data", MEASURED, broad=bool(models))
        ]
        if models:
            model = models[shot][i]
            kept = slice(None, None, max(len(model) // MODEL_POINTS, 1))
            curves.append(Curve(times[kept], unit * model[kept], "", MODEL))
        name = signal.name + (f", shot {shot + 1}" if len(shots) > 1 else "")
        parts.append(chart(curves, time, f"{name}{label}", height=HEIGHT))
        if residuals:
            # Extremes of columns would all be at the edges of the band.
            some = slice(None, None, -(-len(times) // (RESIDUAL_POINTS // count)))
            rest = times[some], residuals[number][some]
            for k, each in enumerate((rest[1], residuals[number])):
                drawn[k] += int(np.isfinite(each).sum())
            curve = Curve(*rest, "", RESIDUAL, separate=True)
            parts.append(chart([_band(times), curve], time, "residual", height=RESIDUAL_HEIGHT))
    if (hidden := len(signals) - count) > 0:
        text = f"{counted(hidden, 'more signal')} {'is' if hidden == 1 else 'are'} not shown here"
        parts.append(note(f"{text}; plot() shows all."))
    if drawn[0] < drawn[1]:
        parts.append(note(f"{drawn[0]} of {drawn[1]} residuals are drawn; plot() shows all."))
    return parts


def _band(times: Array) -> Curve:
    """Two standard deviations on both sides of 0."""
    two = np.full(2, 2.0)
    return Curve(times[[0, -1]], two, "", BAND, base=-two, broad=True)


def _notes(texts: Iterable[str], names: Collection[str] = ()) -> list[str]:
    return [note(sentence(text, names)) for text in texts if text]


def _names(found: FitResult | Forecast) -> set[str]:
    """Names of parameters, and of constants that are taken as exact, with which notes may begin."""
    return {*found.names, *(each.name for each in found.constants)}

"""The figure and the progress of a search for defects."""

import re

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.cli.defect_lines import trying
from hertzchain.fitting.defect_fits import candidates_of, fit_of_defect
from hertzchain.fitting.defect_scan import defect_names
from hertzchain.plotting.defects import plot_fitted_defects


def row(diameters):
    balls = hc.Chain.from_materials(0.5e-3 * np.array(diameters), "steel-52100")
    struck = balls.struck_by(velocity="0.3 m/s").replace(loss=hc.Viscoelastic("0.6 us"))
    return struck.replace(right_wall=hc.Wall())


@pytest.fixture(scope="module")
def scan():
    """Scan of a fit to traces of a row whose fifth ball is 3% smaller."""
    times = 1e-6 * np.arange(300)
    run = hc.simulate(row([10.0] * 4 + [9.7] + [10.0] * 3), times=times)
    noise = 0.1 * np.random.default_rng(1).standard_normal((2, 400))
    ball, wall = np.pad([run.sensor("ball 3"), run.sensor("wall")], ((0, 0), (100, 0))) + noise
    columns = {"ball 3 [N]": ball, "wall [N]": wall}
    traces = hc.Traces.from_arrays(1e-6 * np.arange(400), columns)
    free = ["stiffness", "loss.time", "time_offset"]
    return hc.scan_defects(hc.fit(traces, row([10.0] * 8), free=free, diagnose=False), "bead")


@pytest.mark.long
def test_a_much_lighter_ball_is_found():
    whole = row([10.0] * 8)
    times = 1e-6 * np.arange(300)
    light = whole.replace(masses=whole.masses * np.where(np.arange(9) == 5, 0.4, 1.0))
    run = hc.simulate(light, times=times)
    noise = 0.1 * np.random.default_rng(1).standard_normal((2, 400))
    ball, wall = np.pad([run.sensor("ball 3"), run.sensor("wall")], ((0, 0), (100, 0))) + noise
    traces = hc.Traces.from_arrays(1e-6 * np.arange(400), {"ball 3 [N]": ball, "wall [N]": wall})
    free = ["stiffness", "loss.time", "time_offset"]
    scan = hc.scan_defects(hc.fit(traces, whole, free=free, diagnose=False), "bead")
    assert scan.best == "radius[5]"
    found = fit_of_defect(scan, 1)
    assert found.names[-1] == "mass[5]"
    assert found.values["mass[5]"] == pytest.approx(light.masses[5], rel=0.01)


def test_the_figure_shows_the_fitted_ball_and_both_fits(scan):
    fit = fit_of_defect(scan, 1)
    figure = plot_fitted_defects([scan], {"bead": fit})
    upper, lower = figure.axes
    labels = [text.get_text() for text in upper.get_legend().get_texts()]
    (label,) = (each for each in labels if each.startswith("fitted: "))
    value, error = map(float, re.fullmatch(r"fitted: ball 5, (\S+) ± (\S+) mm", label).groups())
    assert value == pytest.approx(9.7, abs=3.0 * error)
    (star,) = (line for line in upper.lines if line.get_marker() == "*")
    assert star.get_xdata()[0] == 5
    assert star.get_ydata()[0] == pytest.approx(fit.chi2)
    curves = {line.get_label(): line.get_ydata() for line in lower.lines}
    index = ["ball 3", "wall"].index(lower.get_title().partition(",")[0])
    assert curves["fit with ball 5"] == pytest.approx(fit.predicted[0][index])
    assert curves["fit without a defect"] == pytest.approx(scan.result.predicted[0][index])
    # The largest change is visible.
    change = np.abs(curves["fit with ball 5"] - curves["fit without a defect"])
    low, high = lower.get_xlim()
    assert low <= np.argmax(change) <= high


def test_without_a_fitted_defect_the_figure_is_that_of_the_scan(scan):
    (axes,) = plot_fitted_defects([scan], {}).axes
    assert axes.get_ylabel() == r"$\chi^2$ with one defect"


def test_the_progress_names_the_defect_that_is_tried(scan):
    assert defect_names(scan.result, "bead") == list(scan.names)
    assert defect_names(scan.result, "gap")[:2] == ["gap[0-1]", "gap[1-2]"]
    words = trying("defects fitted", candidates_of(scan))
    assert words(0) == f"defects fitted, now {scan.best}"
    assert words(len(scan.names)) == "defects fitted"

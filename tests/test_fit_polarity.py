"""Fits and comparisons of sensors without calibration that are inverted; the data are SciPy's."""

import numpy as np
import pytest
from scipy_row import FREE, TRUTH, chain, recorded

import hertzchain as hc
from hertzchain.fitting.misread_columns import misread_columns
from hertzchain.fitting.model import make_model
from hertzchain.fitting.parameters import free_parameters
from hertzchain.fitting.simulations import Simulator

pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
GAINS = {"ball 5": -0.0213, "ball 10": 0.0197, "wall": 1.0}
INVERTED = "ball 5 is inverted: its gain is negative"
ROW = [*FREE, "gain[ball 5]", "gain[ball 10]"]


def traces(gains=GAINS, level=0.0):
    """Signals in N, or, of sensors in balls, in V after their gains, above a constant level."""
    times, columns = recorded()
    seen = {}
    for name, gain in gains.items():
        unit = "N" if name == "wall" else "V"
        seen[f"{name} [{unit}]"] = gain * columns[f"{name} [N]"] + level * (unit == "V")
    return hc.Traces.from_arrays(times, seen)


@pytest.fixture(scope="module")
def fitted():
    return hc.fit(traces(), chain(), free=ROW)


def test_the_sign_of_a_gain_is_that_of_the_data(fitted):
    assert fitted.describes
    truth = TRUTH | {f"gain[{name}]": gain for name, gain in GAINS.items() if name != "wall"}
    deviations = [(fitted.values[name] - truth[name]) / fitted.errors[name] for name in ROW]
    assert np.abs(deviations).max() < 3.5
    assert INVERTED in fitted.notes
    assert not any("ball 10 is inverted" in note for note in fitted.notes)


def test_inversion_changes_nothing_else(fitted):
    same = hc.fit(traces({name: abs(gain) for name, gain in GAINS.items()}), chain(), free=ROW)
    # Only the noise of the inverted channel has another sign.
    assert np.abs(fitted.estimates[:4] - same.estimates[:4]) == pytest.approx(0.0, abs=1e-9)
    assert not any("inverted" in note for note in same.notes)


def test_weak_directions_are_those_of_the_magnitudes_of_gains():
    free = [*ROW, "gain[wall]"]
    inverted, same = (
        hc.fit(traces(gains), chain(), free=free).weak[0].weights
        for gains in (GAINS, {name: abs(gain) for name, gain in GAINS.items()})
    )
    # Velocity, stiffness and gains are scaled together: 1 : 1/2 is that of Hertz contacts.
    assert inverted == pytest.approx(same, abs=1e-3)
    assert abs(inverted["struck_by.velocity"] / inverted["stiffness"]) == pytest.approx(2, rel=1e-2)


@pytest.mark.parametrize("gains", [
    {"ball 5": -0.02}, {"ball 5": -0.02, "ball 10": -0.03}, {"ball 5": -0.02, "ball 10": 0.03},
])  # fmt: skip
def test_fits_without_a_calibrated_sensor_align_inverted_signals(gains):
    free = ["stiffness", "loss.time", "time_offset", *(f"gain[{name}]" for name in gains)]
    known = chain().replace(velocities=chain().velocities * 0.25 / 0.26)
    result = hc.fit(traces(gains), known, free=free)
    assert result.describes
    for name, gain in gains.items():
        error = result.errors[f"gain[{name}]"]
        assert result.values[f"gain[{name}]"] == pytest.approx(gain, abs=4.0 * error)


def test_negative_starts_and_priors_of_gains_are_accepted():
    for options in (
        {"start": {"gain[ball 5]": -0.02}}, {"priors": {"gain[ball 5]": (-0.021, 0.002)}},
    ):  # fmt: skip
        result = hc.fit(traces(), chain(), free=ROW, **options)
        assert result.values["gain[ball 5]"] == pytest.approx(GAINS["ball 5"], rel=0.01)


def test_a_gain_of_zero_and_priors_of_the_wrong_sign_are_rejected():
    with pytest.raises(hc.InputError, match=r"start of gain\[ball 5\] must be other than 0, got 0"):
        hc.fit(traces(), chain(), free=ROW, start={"gain[ball 5]": 0.0})
    with pytest.raises(hc.InputError, match=r"prior of struck_by.velocity must be above 0, got -0"):
        hc.fit(traces(), chain(), free=ROW, priors={"struck_by.velocity": (-0.2, 0.01)})


def test_loss_laws_are_compared_on_inverted_channels():
    laws = ["viscoelastic", "elastic"]
    compared = hc.compare_losses(traces(), chain(), laws=laws, free=ROW)
    assert [each.law for each in compared.fits] == laws
    assert compared.best.values["gain[ball 5]"] < 0.0


def test_the_start_of_a_gain_does_not_depend_on_a_constant_level():
    free = [*ROW, "offset[ball 5]", "offset[ball 10]"]
    result = hc.fit(traces(level=0.6), chain(), free=free)
    assert result.describes
    assert result.values["gain[ball 5]"] == pytest.approx(GAINS["ball 5"], rel=0.01)


def test_larger_reflected_waves_do_not_suggest_an_inverted_velocity():
    row = chain(loss=None)
    run = hc.simulate(row, times=np.arange(0.0, 6e-4, 1e-6))
    signal = np.pad(run.velocity(9), (60, 0))
    signal += 1e-4 * np.random.default_rng(2).standard_normal(len(signal))
    larger = np.where(signal < 0.0, 1.3 * signal, signal)
    assert -larger.min() > larger.max()
    for values, words in ((larger, []), (-signal, ["the opposite sign of ball 8 velocity"])):
        times = 1e-6 * np.arange(len(values))
        data = hc.Traces.from_arrays(times, {"ball 8 velocity [m/s]": values})
        parameters = free_parameters(data, [row], ["time_offset"], {}, {"time_offset": 60e-6})
        model = make_model(data, [row], parameters, Simulator([data.shots[0].signals[0].place]))
        assert [each.what for each in misread_columns(model)] == words


def test_an_inverted_velocity_sensor_that_sees_the_reflected_wave_is_recognised():
    # The reflected wave is nearly as large as the incident one, but of the other sign.
    row = chain(loss=None)
    run = hc.simulate(row, times=np.arange(0.0, 6e-4, 1e-6))
    rng = np.random.default_rng(2)
    signal = np.pad(-3.0 * run.velocity(9), (60, 0))
    signal += 1e-4 * rng.standard_normal(len(signal))
    data = hc.Traces.from_arrays(1e-6 * np.arange(len(signal)), {"ball 8 velocity [V]": signal})
    result = hc.fit(data, row, free=["time_offset", "gain[ball 8 velocity]"])
    assert result.values["gain[ball 8 velocity]"] == pytest.approx(-3.0, rel=1e-3)
    assert result.rows()[1][1].endswith(" V s/m")
    assert result.values["time_offset"] == pytest.approx(60e-6, abs=1e-7)


def test_a_comparison_states_that_a_channel_is_inverted():
    found = hc.simulate(chain(), until=6e-4, times=3000).compare(traces())
    assert INVERTED in found.notes
    assert found.sensors[0].scale < 0.0 < found.sensors[1].scale


def test_crests_of_inverted_channels_are_drawn(fitted):
    crest = fitted.plot().axes[2]
    # In the panels of a crest, data and model are within the highest 30%.
    data, model = (line.get_ydata() for line in crest.lines)
    assert model.min() == pytest.approx(fitted.predicted[0][0].min())
    assert model.max() < 0.69 * model.min() < 0.0
    assert np.abs(data - model).max() < 6.0 * fitted.traces.shots[0].signals[0].noise


def test_signals_in_several_units_are_drawn_relative_to_their_largest_values():
    axes = traces().plot()
    heights = [np.nanmax(np.abs(line.get_ydata())) for line in axes.lines if len(line.get_ydata())]
    assert heights == pytest.approx([1.0, 1.0, 1.0])
    largest = np.abs(traces().shots[0].signals[0].values).max()
    assert f"ball 5: {1e3 * largest:.3g} mV" in axes.get_legend_handles_labels()[1]
    assert axes.get_ylabel() == "signal / largest value"
    same = traces({"ball 5": 0.1, "ball 10": 0.2}).plot()
    assert same.get_ylabel() == "signal [V]"


def test_comparisons_of_three_sensors_have_no_empty_place_and_a_legend_above():
    figure = hc.simulate(chain(), until=6e-4, times=3000).compare(traces()).plot()
    figure.canvas.draw()
    assert len(figure.axes) == 6
    top = max(axes.get_position().y1 for axes in figure.axes)
    (legend,) = figure.legends
    assert legend.get_window_extent().y0 > top * figure.bbox.height
    boxes = [axes.title.get_window_extent() for axes in figure.axes if axes.get_title()]
    assert not any(legend.get_window_extent().overlaps(box) for box in boxes)
    assert figure.axes[-1].get_xlabel() == "time [µs]"


def test_gains_of_single_shots_start_from_their_own_signals():
    plain = {name: abs(gain) for name, gain in GAINS.items()}
    shots = hc.Traces((traces(plain).shots[0], traces().shots[0]))
    free = [*FREE, "gain[ball 5]@*", "gain[ball 10]"]
    found = hc.fit(shots, chain(), free=free)
    assert found.describes
    for shot, gain in (("1", 0.0213), ("2", -0.0213)):
        name = f"gain[ball 5]@{shot}"
        assert abs(found.values[name] - gain) < 3.5 * found.errors[name]
    assert INVERTED in found.notes

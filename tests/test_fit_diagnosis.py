"""Causes that a fit names if the model does not describe the data, which are from SciPy."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lsim
from scipy_row import BALLS, BEFORE, FREE, RADIUS, SPACING, TRUTH, chain, forces, recorded, traces

import hertzchain as hc
from hertzchain.cli.postponed_diagnosis import cause_of_misfit
from hertzchain.cli.wording import on_command_line
from hertzchain.fitting.advice import DEFECTS, LAWS, considered, nothing_explains
from hertzchain.fitting.constant_causes import with_exponent
from hertzchain.fitting.diagnosis import _further, without_tested
from hertzchain.fitting.fit import fit_experiment
from hertzchain.fitting.fit import fitted as solved
from hertzchain.fitting.free_causes import with_losses
from hertzchain.fitting.steps import STEPS, Step

DESCRIBES = "and the model describes the data"
NOTHING = "none of the effects tested explains the residuals ("
A, B, WALL = "ball 5 [N]", "ball 10 [N]", "wall [N]"


def fitted(change=None, **options):
    result = hc.fit(traces(change=change, **options), chain(), free=FREE)
    assert not result.describes
    return result


def refitted(change, free):
    """A fit that follows the advice, which must recover the truth."""
    result = hc.fit(traces(change=change), chain(), free=[*FREE, *free])
    assert result.describes
    deviations = [(result.values[name] - TRUTH[name]) / result.errors[name] for name in FREE]
    assert np.abs(deviations).max() < 3.5
    return result


@pytest.mark.long
def test_offsets_are_named():
    def change(columns):
        return columns | {A: columns[A] + 0.6, WALL: columns[WALL] - 0.4}

    result = fitted(change)
    (advice,) = result.advice
    assert DESCRIBES in advice
    assert "offset[ball 5] = 0.6" in advice or "offset[ball 5] = 0.59" in advice
    assert "offset[ball 10]" not in advice
    assert "add 'offset[*]' to the free parameters" in advice
    found = refitted(change, ["offset[*]"])
    assert abs(found.values["offset[wall]"] + 0.4) < 3.5 * found.errors["offset[wall]"]


@pytest.mark.long
def test_one_offset_is_named_alone():
    (advice,) = fitted(lambda columns: columns | {B: columns[B] + 0.3}).advice
    assert "add 'offset[ball 10]' to" in advice


@pytest.mark.parametrize("size", [pytest.param(0.5, marks=pytest.mark.long), 0.2])
def test_a_second_pulse_is_named_with_its_time_and_size(size):
    delay = round(120e-6 / SPACING)

    def change(columns):
        late = {name: np.pad(each, (delay, 0))[: len(each)] for name, each in columns.items()}
        return {name: each + size * late[name] for name, each in columns.items()}

    result = fitted(change)
    (advice,) = result.advice
    assert DESCRIBES in advice
    words = r"there is a second pulse at t = ([\d.]+) us in ball 5, about (\d+)% of the first"
    time, percent = map(float, re.search(words, advice).groups())
    assert "a second blow of the hammer or striker, or for a gap between balls" in advice
    seen = traces().shots[0]
    onset = seen.times[np.argmax(seen.signals[0].values > 0.05 * seen.signals[0].values.max())]
    assert time == pytest.approx(1e6 * onset + 120.0, abs=8.0)
    assert percent == pytest.approx(100.0 * size, rel=0.25)
    stiffness = re.search(r"stiffness\s+=?\s*([\d.]+)", advice)
    assert float(stiffness[1]) == pytest.approx(TRUTH["stiffness"], rel=0.02)


def test_another_start_is_advised_if_the_search_has_not_converged():
    result = hc.fit(traces(), chain(), free=FREE)
    assert "another start" not in considered(result)
    text = considered(replace(result, converged=False))
    assert text.startswith("Consider another start (start={'loss.time': ...}), gaps, odd balls")
    assert "another start (--start 'loss.time=...')" in on_command_line(text)


def two_shots(change, free, first=None):
    """A fit to two shots, whose columns may differ from those of SciPy."""
    shots = [traces(seed, change=each).shots[0] for seed, each in enumerate((first, change))]
    return hc.fit(hc.Traces(tuple(shots)), chain(), free=free)


EACH = [f"{name}@*" if name in ("struck_by.velocity", "time_offset") else name for name in FREE]


@pytest.mark.long
@pytest.mark.parametrize(
    ("change", "free", "name", "true"),
    [
        (lambda c: c | {B: 1.1 * c[B]}, [], "gain[ball 10]@2", 1.1),
        (lambda c: c | {B: c[B] + 0.3}, [], "offset[ball 10]@2", 0.3),
        # The common offset is that of the first shot.
        (lambda c: c | {B: c[B] + 0.3}, ["offset[ball 10]"], "offset[ball 10]@2", 0.3),
        # Those of the first shot are free alone.
        (lambda c: c | {B: c[B] + 0.3}, ["offset[*]@1"], "offset[ball 10]@2", 0.3),
        (lambda c: c | {B: np.roll(c[B], 5)}, [], "delay[ball 10]@2", 5e6 * SPACING),
    ],
    ids=["gain", "offset", "common offset", "offsets of the first shot", "delay"],
)  # fmt: skip
def test_an_effect_of_one_shot_is_named(change, free, name, true):
    result = two_shots(change, [*EACH, *free])
    assert not result.describes
    (advice,) = result.advice
    assert f"add '{name}' to the free parameters" in advice
    assert DESCRIBES in advice
    value, error = map(float, re.findall(r"\]@2 = (\S+) \+- (\S+) ", advice.replace(",", " "))[0])
    assert abs(value - true) < 3.5 * error < 0.1 * true
    found = two_shots(change, [*EACH, *free, name])
    assert found.describes
    for key in ("stiffness", "loss.time"):
        assert abs(found.values[key] - TRUTH[key]) < 3.5 * found.errors[key]


@pytest.mark.long
def test_offsets_of_all_sensors_in_one_shot_are_named():
    def change(columns):
        return columns | {A: columns[A] + 0.6, WALL: columns[WALL] - 0.4}

    (advice,) = two_shots(change, EACH).advice
    assert "add 'offset[*]@2' to the free parameters" in advice
    assert DESCRIBES in advice
    (advice,) = two_shots(change, [*EACH, "offset[ball 10]@2"]).advice
    assert "add 'offset[ball 5]@2' and 'offset[wall]@2' to the free parameters" in advice


@pytest.mark.long
def test_different_offsets_of_one_sensor_in_each_shot_are_named():
    result = two_shots(
        lambda c: c | {B: c[B] + 0.3}, EACH, lambda c: c | {B: c[B] - 0.3}
    )  # fmt: skip
    (advice,) = result.advice
    assert "add 'offset[ball 10]@*' to the free parameters" in advice
    assert DESCRIBES in advice


@pytest.mark.long
def test_levels_of_single_shots_are_named():
    shots = [
        traces(seed, gap=0.5e-6, change=change).shots[0]
        for seed, change in enumerate((None, lambda c: c | {A: c[A] + 0.2}))
    ]
    level, other = hc.fit(hc.Traces(tuple(shots)), chain(), free=EACH).advice
    assert level.startswith("before the pulse of shot 2, ball 5 is at ")
    assert "add 'offset[ball 5]@2' to the free parameters" in level
    assert NOTHING in other


@pytest.mark.long
@pytest.mark.parametrize(
    ("options", "name"),
    [({"before": BEFORE + 5}, "time_offset"), ({"velocity": 0.26}, "struck")],
)
def test_common_parameters_that_differ_between_shots_are_named(options, name):
    name = next(each for each in FREE if each.startswith(name))
    shots = [traces(seed, **each).shots[0] for seed, each in enumerate(({}, options))]
    free = [each for each in EACH if not each.startswith(name)]
    (advice,) = hc.fit(hc.Traces(tuple(shots)), chain(), free=[*free, name]).advice
    assert f"free '{name}@*' instead of '{name}'" in advice
    assert DESCRIBES in advice


@pytest.mark.long
def test_parameters_of_each_shot_are_not_tried_in_common():
    free = [each for each in EACH if each != "loss.time"]
    result = two_shots(None, [*free, "loss.time@*", "exponent@*"])
    assert list(with_losses(result, {}, solved)) == list(with_exponent(result, {}, solved)) == []


@pytest.mark.long
def test_chi2_is_stated_for_each_sensor():
    result = fitted(lambda columns: columns | {B: columns[B] + 0.3})
    found = result.chi2_per_sample
    # An offset of 3 times the noise adds 9, as far as the other parameters do not absorb it.
    assert 5.0 < found["ball 10"] < 10.5
    assert max(found["ball 5"], found["wall"]) < 2.0
    assert f"ball 10 {found['ball 10']:.3g}" in result.summary(width=None)
    total = sum(found[s.name] * s.valid.sum() for _, s in result.traces)
    assert total == pytest.approx(result.chi2, rel=1e-9)
    assert result.as_dict()["chi2_per_sample"] == found


@pytest.mark.parametrize(
    ("change", "words"),
    [
        pytest.param(
            lambda c: c | {A: c[B], B: c[A]}, "the columns of ball 5 and ball 10 exchanged",
            marks=pytest.mark.long,
        ),
        (lambda c: c | {A: c[WALL], B: c[A], WALL: c[B]},
         "the columns of ball 5, ball 10 and wall in the order in which the pulse arrives"),
        pytest.param(
            lambda c: c | {A: -c[A]}, "the opposite sign of ball 5", marks=pytest.mark.long
        ),
        (lambda c: c | {A: -c[A], WALL: -c[WALL]}, "the opposite sign of ball 5 and wall"),
        (lambda c: c | {A: 1e-3 * c[A]}, "the values of ball 5 multiplied by 1000"),
        (lambda c: c | {WALL: 1e3 * c[WALL]}, "the values of wall multiplied by 0.001"),
        pytest.param(
            lambda c: c | {WALL: 10.0 * c[WALL]}, "the values of wall multiplied by 0.1",
            marks=pytest.mark.long,
        ),
        pytest.param(
            lambda c: c | {A: 0.01 * c[A], WALL: 10.0 * c[WALL]},
            "the values of ball 5 multiplied by 100 and the values of wall multiplied by 0.1",
            marks=pytest.mark.long,
        ),
        pytest.param(
            lambda c: c | {B: 2.0 * c[B]}, "gain[ball 10] = 2", marks=pytest.mark.long
        ),
    ],
    ids=["two columns", "three columns", "sign", "two signs", "kN", "mN", "x10 probe", "two probes",
         "gain"],
)  # fmt: skip
def test_misread_columns_are_named(change, words):
    (advice,) = fitted(change).advice
    assert words in advice or words.replace("= 2", "= 1.99") in advice
    assert DESCRIBES in advice


@pytest.mark.long
def test_exchanged_columns_are_named_without_advice_on_units_if_there_is_another_error():
    # The signal of the wall is late by three samples, so that no order describes the data.
    times, columns = recorded()
    columns = columns | {A: columns[B], B: columns[A], WALL: np.roll(columns[WALL], 3)}
    volts = {name.replace("[N]", "[V]"): 0.02 * values for name, values in columns.items()}
    gains = ("gain[ball 5]", "gain[ball 10]", "gain[wall]")
    result = hc.fit(
        hc.Traces.from_arrays(times, volts), chain(), free=[*FREE, *gains], starts=1,
        priors=dict.fromkeys(gains, (0.02, 0.001)), diagnose=False,
    )  # fmt: skip
    assert "the columns of ball 5 and ball 10 exchanged" in result.advice[0]
    assert DESCRIBES not in result.advice[0]
    assert result.misread
    summary = result.summary(width=None)
    assert "from its prior" not in summary
    assert "the unit in its header" not in summary


@pytest.mark.long
def test_another_exponent_is_named_rather_than_a_lag():
    result = fitted(exponent=1.45)
    (advice,) = result.advice
    assert "with exponent = 1.4" in advice
    assert DESCRIBES in advice
    assert "lag" not in advice


@pytest.mark.long
@pytest.mark.parametrize("gap", [0.1e-6, 0.5e-6])
def test_a_small_gap_is_named_and_no_effect_of_sensors(gap):
    (advice,) = fitted(gap=gap).advice
    assert advice.startswith("with gap[8-9] = ")
    assert DESCRIBES in advice
    assert float(advice.split(" = ")[1].split()[0]) == pytest.approx(1e6 * gap, rel=0.1)


def test_the_progress_names_the_cause_that_is_tried(monkeypatch, capsys):
    assert all(each.shown or each.words for each in STEPS)
    simulator = SimpleNamespace(trying="")
    result = SimpleNamespace(model=SimpleNamespace(simulator=simulator))

    class Postponed:
        """A diagnosis of one step with 120 simulations."""

        def diagnosed(self, result, progress):
            def tried(*_):
                progress(120, 0)
                return ()

            monkeypatch.setattr("hertzchain.fitting.diagnosis.STEPS", (Step(tried, "one gap"),))
            _further(result, {}, None, [], {})
            simulator.trying = ""
            return result

    monkeypatch.setattr("hertzchain.cli.progress.SECONDS_PER_LINE", 0.0)
    assert cause_of_misfit(result, {}, Postponed(), as_json=False) is result
    assert capsys.readouterr().err.splitlines()[-2:] == [
        "trying one gap; simulations of the search: 120",
        "simulations of the search: 120 in total",
    ]


def test_causes_that_were_tried_are_listed_in_few_words():
    row = chain()
    result = fit_experiment(traces(gap=0.5e-6), row, lambda found, *_: found, free=FREE)
    advice = nothing_explains(result, [each.words for each in STEPS], ["a level"])
    assert advice.startswith(f"even with separate offsets, {NOTHING}effects of the sensors, other ")
    assert len(advice.partition("(")[2].partition("). Consider")[0].split()) < 50
    assert "(scan_defects)" in advice
    assert "--" not in advice
    (rest,) = without_tested(replace(result, advice=(advice,)), DEFECTS, LAWS).advice
    assert rest.endswith(
        "Consider the exponent of the wall, and the sizes and materials of striker, balls and wall"
    )


@pytest.mark.long
def test_a_wrong_zero_does_not_hide_a_gap():
    (advice,) = fitted(lambda columns: columns | {A: columns[A] + 0.1}, gap=0.5e-6).advice
    assert advice.startswith("with offset[ball 5] = ")
    assert DESCRIBES in advice
    offset, gap = (float(advice.split(f"{name}] = ")[1].split()[0]) for name in ("ball 5", "8-9"))
    assert offset == pytest.approx(0.1, abs=0.02)
    assert gap == pytest.approx(0.5, rel=0.1)


@pytest.mark.long
def test_a_highpass_is_named_and_confirmed():
    data, file = hc.example_experiment()
    free = ["stiffness", "struck_by.velocity", "loss.time", "time_offset", "gain[*]"]
    result = hc.fit(data, hc.load_chain(file), free=free,
                    priors={"struck_by.velocity": (0.3, 0.003)})  # fmt: skip
    (advice,) = result.advice
    # The truth of tools/example_traces.py is 1/(6 ms).
    assert "with highpass = 17" in advice
    assert DESCRIBES in advice


@pytest.mark.long
@pytest.mark.parametrize("loss", [None, hc.Viscoelastic(0.05e-6)])
def test_a_missing_or_fixed_loss_is_named(loss):
    free = [name for name in FREE if name != "loss.time"]
    result = hc.fit(traces(), chain(loss=loss), free=free)
    assert not result.describes
    (advice,) = result.advice
    assert DESCRIBES in advice
    assert ("add a loss to the chain" in advice) == (loss is None)
    assert "'loss.time'" in advice
    # The advice states the true time, and following it recovers the truth.
    assert float(advice.split("loss.time = ")[1].split()[0]) == pytest.approx(0.6, abs=0.005)
    law = hc.Viscoelastic(0.6e-6) if loss is None else loss
    found = hc.fit(traces(), chain(loss=law), free=[*free, "loss.time"])
    deviations = [(found.values[name] - TRUTH[name]) / found.errors[name] for name in FREE]
    assert np.abs(deviations).max() < 3.5


@pytest.mark.long
@pytest.mark.parametrize(("change", "words"), [(-1, "one ball more"), (1, "one ball fewer")])
def test_a_wrong_number_of_balls_is_named(change, words):
    row = hc.Chain.from_materials(RADIUS, "steel-52100", beads=BALLS + change)
    wrong = row.struck_by(velocity=0.26).replace(
        right_wall=hc.Wall.of("steel-304"), loss=hc.Viscoelastic(0.4e-6)
    )
    (advice,) = hc.fit(traces(), wrong, free=FREE).advice
    assert advice.startswith(f"with {words} ({BALLS}), chi2 falls from ")
    assert DESCRIBES in advice
    assert "check the number of balls" in advice


def after_sensors(lag, rate):
    """Signals of SciPy after the lag and the high-pass of sensors."""
    times = SPACING * np.arange(len(forces()["wall"]))
    found = {}
    for name, force in forces().items():
        force = lsim(([1.0], [lag, 1.0]), force, times)[1]
        found[name] = lsim(([1.0, 0.0], [1.0, rate]), force, times)[1]
    return found


@pytest.mark.long
def test_the_advised_lag_is_that_of_another_fit():
    data = traces(signals=after_sensors(2e-6, 0.0), noise=0.2)
    result = hc.fit(data, chain(), free=FREE)
    assert result.describes
    (advice,) = result.advice
    assert advice in result.summary(width=None)
    value, error = map(float, re.findall(r"with lag = (\S+) \+- (\S+) us", advice)[0])
    assert abs(value - 2.0) < 3.0 * error < 0.6
    again = hc.fit(data, chain(), free=[*FREE, "lag"])
    assert f"with lag = {dict(again.rows())['lag']}, " in advice
    # The shift is that between both fits, too.
    shift = abs(again.values["loss.time"] - result.values["loss.time"]) / result.errors["loss.time"]
    assert f"loss.time moves by {shift:.1f} sigma" in advice


@pytest.mark.long
def test_sensors_with_several_effects_are_not_described():
    def drifting(columns):
        part = np.linspace(0.0, 1.0, len(columns[WALL]))
        drift = 0.5 * part + 0.15 * np.sin(2.0 * np.pi * 1.1 * part)
        return {name: values + drift for name, values in columns.items()}

    data = traces(1, signals=after_sensors(2e-6, 333.0), noise=0.13, before=170, change=drifting)
    result = hc.fit(data, chain(), free=FREE)
    # The residuals are slow, and so is the noise before the pulse, which contains the drift.
    assert result.goodness.effective_samples < 100.0
    assert result.goodness.correlation == 0.0
    # With the independent residuals alone, the error of chi-squared would be 40%.
    assert result.goodness.excess > 10.0
    assert not result.describes
    assert not result.goodness.undecided
    assert "the model does not describe the data" in result.verdict
    assert not any("with exponent" in each for each in result.advice)


@pytest.mark.long
def test_a_parameter_near_its_fixed_value_is_not_a_cause():
    good = hc.fit(traces(), chain(), free=FREE)
    assert list(with_exponent(good, {}, solved)) == []
    # It can be fitted, with an error that contains the true value of 1.5.
    free = hc.fit(traces(), chain(), free=[*FREE, "exponent"])
    assert abs(free.values["exponent"] - 1.5) < 2.0 * free.errors["exponent"] < 0.01
    (cause,) = with_exponent(fitted(exponent=1.45), {}, solved)
    assert "exponent = 1.4" in cause.what


def test_a_good_fit_has_no_advice():
    result = hc.fit(traces(), chain(), free=FREE)
    assert result.describes
    assert result.advice == ()
    assert max(result.chi2_per_sample.values()) < 1.3


@pytest.mark.long
@pytest.mark.parametrize(("name", "column"), [("ball 10", B), ("wall", WALL)])
def test_the_delay_of_one_sensor_is_named(name, column):
    def late(columns):
        # A whole number of samples; the values before the pulse are independent noise.
        return columns | {column: np.roll(columns[column], 5)}

    (advice,) = fitted(late).advice
    assert DESCRIBES in advice
    assert f"add 'delay[{name}]' to the free parameters" in advice
    value, error = map(float, re.findall(r"delay\S* *\d*\] = (\S+) \+- (\S+) us", advice)[0])
    assert abs(value - 1e6 * 5 * SPACING) < 3.5 * error < 0.2
    refitted(late, [f"delay[{name}]"])


@pytest.mark.long
@pytest.mark.parametrize("heavier", [1.15, 0.9])
def test_another_mass_of_the_balls_with_sensors_is_named(heavier):
    (advice,) = fitted(heavier=heavier).advice
    assert "with another mass of the balls with sensors, mass[5,10] = " in advice
    assert DESCRIBES in advice
    value, error = map(float, re.findall(r"= (\S+) \+- (\S+) kg", advice)[0])
    mass = 7780.0 * 4.0 / 3.0 * np.pi * RADIUS**3 * heavier
    assert abs(value - mass) < 3.5 * error < 5e-3 * mass
    # Following the advice recovers the truth from the nominal mass.
    found = hc.fit(traces(heavier=heavier), chain(), free=[*FREE, "mass[5,10]"])
    assert found.describes
    deviations = [(found.values[name] - TRUTH[name]) / found.errors[name] for name in FREE]
    assert np.abs(deviations).max() < 3.5
    assert found.chain.masses[[5, 10]] == pytest.approx(found.values["mass[5,10]"])
    assert found.chain.masses[6] == chain().masses[6]


@pytest.mark.parametrize("name", ["gap[3-40]", "mass[17]"])
def test_messages_count_balls_and_cap_separately(name):
    capped = chain(right_wall=hc.Wall("50 kN/mm", exponent=1)).with_cap("5 g")
    what = "a contact" if "gap" in name else "a ball"
    words = f"{name} is not {what} of this chain, whose balls are 1 to 15, and whose cap is 16"
    with pytest.raises(hc.InputError, match=re.escape(words)):
        hc.fit(traces(), capped, free=[*FREE, name])


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("mass[5,16]", "mass[5,16] are not balls of this chain, whose balls are 1 to 15"),
        ("mass[5,]", "mass[5,] are not balls of this chain"),
        ("gap[3-40]", "gap[3-40] is not a contact of this chain, whose balls are 1 to 15; name"),
        ("radius[4,5]", "radius[4,5] requires balls of one radius, but theirs are 0.005 to 0.006"),
    ],
)
def test_balls_with_one_mass_are_checked(name, words):
    row = chain().replace(radii=np.where(np.arange(BALLS + 1) == 5, 6e-3, RADIUS))
    with pytest.raises(hc.InputError, match=re.escape(words)):
        hc.fit(traces(), row, free=[*FREE, name])


@pytest.mark.long
def test_a_gross_error_of_an_amplitude_is_named_before_the_effects_that_remain():
    result = fitted(lambda c: c | {WALL: 10.0 * c[WALL], A: c[A] + 0.5})
    first, *rest = result.advice
    assert "the values of wall multiplied by 0.1" in first
    assert "check the attenuation of the probe (x1, x10, x100)" in first
    assert re.match(r"after that, with offset\[ball 5\] = 0\.(49|50)", rest[0])

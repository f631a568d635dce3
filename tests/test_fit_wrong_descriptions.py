"""Wrong descriptions of an experiment that a fit names; the forces are from SciPy."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline
from scipy_row import BEFORE, FREE, POISSON, RADIUS, TRUTH, VELOCITY, YOUNG, chain, recorded, traces

import hertzchain as hc
from hertzchain.fitting import free_causes
from hertzchain.fitting.fit import problem_of
from hertzchain.fitting.misread_places import OtherPlace, likely_places
from hertzchain.fitting.settings import Settings
from hertzchain.traces.places import place_named


@pytest.mark.long
@pytest.mark.parametrize(("wrong", "right"), [("ball 4", "ball 5"), ("ball 11", "ball 10")])
def test_a_sensor_one_ball_away_is_named(wrong, right):
    def renamed(columns):
        return {
            f"{wrong} [N]" if name == f"{right} [N]" else name: each
            for name, each in columns.items()
        }

    result = hc.fit(traces(change=renamed), chain(), free=FREE)
    assert not result.describes
    (advice,) = result.advice
    assert f"with the sensor {wrong!r} in {right} instead, chi2 falls" in advice
    assert "and the model describes the data" in advice
    # Waves that return from the wall exclude a missing ball, which would look like the first case.
    assert advice.endswith("counted")


@pytest.mark.long
def test_a_softer_wall_is_named():
    softer = 100e9
    result = hc.fit(traces(wall_young=softer), chain(), free=FREE)
    assert not result.describes
    (advice,) = result.advice
    assert "and the model describes the data" in advice
    assert "add 'right_wall.stiffness' to the free parameters" in advice
    digits = re.findall(r"right_wall.stiffness = \((\S+) \+- (\S+)\)e\+09", advice)[0]
    value, error = (1e9 * float(each) for each in digits)
    # The factor of the data belongs to all contacts.
    compliance = (1.0 - POISSON**2) * (1.0 / YOUNG + 1.0 / softer)
    expected = 4.0 / 3.0 * RADIUS**0.5 / compliance * TRUTH["stiffness"]
    assert abs(value - expected) < 3.5 * error < 0.01 * expected


@pytest.mark.long
@pytest.mark.parametrize("dynamic", [False, True])
def test_missing_gravity_is_named(monkeypatch, dynamic):
    """Without a search for odd balls, and for sensors with AC coupling, which hide the weight."""
    monkeypatch.setattr("hertzchain.fitting.row_causes._base", None)

    def change(columns):
        levels = {name: each[:BEFORE].mean() * dynamic for name, each in columns.items()}
        return {name: each - levels[name] for name, each in columns.items()}

    data = traces(gravity=9.81, noise=0.05, change=change)
    result = hc.fit(data, chain(), free=FREE)
    assert not result.describes
    advice = result.advice[0]
    assert "and the model describes the data" in advice
    assert "give gravity, its component along the row towards the last ball" in advice
    value, error = map(float, re.search(r"gravity = (\S+) \+- (\S+) m/s\^2", advice).groups())
    assert abs(value - 9.81) < 3.5 * error < 1.0
    vertical = hc.fit(data, chain().replace(gravity=9.81), free=FREE)
    assert vertical.describes


@pytest.mark.long
def test_offsets_of_sensors_are_named_instead_of_a_common_one():
    levels = {"ball 5 [N]": 0.25, "ball 10 [N]": -0.3, "wall [N]": 0.1}

    def change(columns):
        return {name: each + levels[name] for name, each in columns.items()}

    result = hc.fit(traces(change=change), chain(), free=[*FREE, "offset"])
    assert not result.describes
    (advice,) = result.advice
    assert "and the model describes the data: free 'offset[*]' instead of 'offset'" in advice
    assert hc.fit(traces(change=change), chain(), free=[*FREE, "offset[*]"]).describes


@pytest.mark.long
@pytest.mark.parametrize("gain", [None, 0.02])
def test_a_missing_precompression_is_named(gain):
    """Also by sensors in volts, whose gains are fitted."""
    # The force holds the bead that strikes, too.
    row = hc.Chain.from_materials(RADIUS, "steel-52100", beads=16).replace(
        right_wall=hc.Wall.of("steel-304"), loss=hc.Viscoelastic(0.4e-6),
        velocities=[VELOCITY] + [0.0] * 15,
    )  # fmt: skip
    free = ["stiffness", "loss.time", "time_offset"]
    names = {"ball 5 [N]": "bead 6 [N]", "ball 10 [N]": "bead 11 [N]", "wall [N]": "wall [N]"}

    def renamed(columns):
        named = {names[name]: each for name, each in columns.items()}
        if gain is None:
            return named
        return {name.replace("[N]", "[V]"): gain * each for name, each in named.items()}

    priors = {}
    if gain is not None:
        priors = {f"gain[{name[:-4]}]": (1.02 * gain, 0.05 * gain) for name in names.values()}
    result = hc.fit(
        traces(static=5.0, change=renamed), row, free=[*free, *priors], priors=priors or None
    )
    assert not result.describes
    advice = result.advice[0]
    value, error = map(float, re.search(r"precompression = (\S+) \+- (\S+) N", advice).groups())
    assert abs(value - 5.0) < 3.5 * error < 0.5
    assert "give precompression in the chain" in advice


@pytest.mark.long
def test_the_modulus_of_one_of_two_materials_is_named():
    nominal = hc.material("steel-52100")
    soft = hc.Material("soft", nominal.density, 0.9 * YOUNG, POISSON)
    balls = np.where(np.arange(16) < 8, "front", "back")
    kinds = {"back": nominal, "front": soft}
    row = chain()
    wrong = row.replace(materials=[
        hc.Material(name, nominal.density, kinds[name].young, POISSON) for name in balls.tolist()
    ])  # fmt: skip
    (advice,) = hc.fit(traces(), wrong, free=FREE).advice
    assert re.search(r"materials\[(front|back)\].young = ", advice)
    assert "and the model describes the data" in advice


@pytest.mark.long
@pytest.mark.parametrize(("factor", "words"), [(2.0, "divided by 2"), (0.5, "multiplied by 2")])
def test_a_wrong_sampling_interval_is_named_if_the_fit_is_far_from_a_prior(factor, words):
    """Another interval is the same as another stiffness and velocity, except for the prior."""
    times, columns = recorded()
    data = hc.Traces.from_arrays(factor * times, columns)
    options = {"free": FREE, "priors": {"struck_by.velocity": (VELOCITY, 0.01 * VELOCITY)}}
    result = hc.fit(data, chain(), **options)
    assert result.describes
    assert result.prior_conflict
    (advice,) = result.advice
    assert advice.startswith(f"with all times {words}, the fit also agrees with the priors: ")
    ((value, error),) = re.findall(r"struck_by\.velocity +(\S+) \+- (\S+) m/s", advice)
    assert abs(float(value) - VELOCITY) < 4.0 * float(error) < 0.01 * VELOCITY
    action, _, _ = advice.partition(". The values are then\n")
    assert action.endswith(
        f"sampling interval; traces.with_scaled_times({1.0 / factor:g}) corrects them"
    )


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in (1, 2, 3))]
)
def test_a_slightly_stiffer_wall_is_no_noise(seed):
    """Its effect is about that of noise of the times, but another fit removes all of it."""
    priors = {"struck_by.velocity": (VELOCITY, 0.01 * VELOCITY)}
    data = traces(np.random.default_rng(seed), wall_young=201e9)
    (advice,) = hc.fit(data, chain(), free=[*FREE, "gain[*]"], priors=priors).advice
    assert re.search(r"with right_wall.stiffness = \S+ \+- \S+ N/um\^1\.5, chi2", advice)
    assert "add 'right_wall.stiffness' to the free parameters" in advice
    assert "noise" not in advice


@pytest.mark.long
def test_random_errors_of_times_are_named():
    """Each row has an error of its time; the file states even times."""
    rng = np.random.default_rng(6)
    times, columns = recorded(noise=0.0)
    error = 0.3e-6
    moved = times + error * rng.standard_normal(len(times))
    seen = {name: make_interp_spline(times, each, k=3)(moved) for name, each in columns.items()}
    noisy = {name: each + 0.05 * rng.standard_normal(len(each)) for name, each in seen.items()}
    (advice,) = hc.fit(hc.Traces.from_arrays(times, noisy), chain(), free=FREE).advice
    (size,) = re.findall(r"random errors of (\S+) us in the times of the samples", advice)
    # The number of steep samples of three sensors is several hundred.
    assert float(size) == pytest.approx(1e6 * error, rel=0.1)


@pytest.mark.long
def test_a_noise_proportional_to_the_signal_is_named():
    rng = np.random.default_rng(7)

    def change(columns):
        return {
            name: each * (1.0 + 0.02 * rng.standard_normal(len(each)))
            for name, each in columns.items()
        }

    (advice,) = hc.fit(traces(change=change), chain(), free=FREE).advice
    (size,) = re.findall(r"a noise of (\S+) times the signal", advice)
    assert float(size) == pytest.approx(0.02, rel=0.1)


@pytest.mark.long
def test_a_stiffer_wall_is_named_if_only_priors_fix_the_gains():
    """The error of the stiffness of the wall is then that of the priors, larger than its change."""

    def volts(columns):
        return {name.replace("[N]", "[V]"): 0.02 * force for name, force in columns.items()}

    data = traces(np.random.default_rng(0), wall_young=215e9, change=volts)
    priors = {f"gain[{name}]": (0.02, 1e-3) for name in ("ball 5", "ball 10", "wall")}
    priors["struck_by.velocity"] = (VELOCITY, 0.05 * VELOCITY)
    (advice,) = hc.fit(data, chain(), free=[*FREE, "gain[*]"], priors=priors).advice
    assert "add 'right_wall.stiffness' to the free parameters" in advice
    assert "the model describes the data" in advice


def test_places_are_tried_until_one_describes_the_data(monkeypatch):
    """The ball that agrees best with the nominal chain may not be the right one."""
    data = traces(
        change=lambda found: {"ball 4 [N]": found["ball 5 [N]"], "wall [N]": found["wall [N]"]}
    )
    settings = Settings(free=FREE).with_more(None, data, chain())
    model = problem_of(data, [chain()], settings).model
    likely = likely_places(model)
    assert likely[0].place.name == "ball 5"
    assert len(likely) <= 3
    for sizes, tried, place in ([90, 80, 70], 3, 2), ([90, 10, 0], 2, 1), ([90, 95, 99], 3, 0):
        names = [f"ball {k}" for k in range(1, 4)]
        others = [OtherPlace("ball 5", place_named(each), each) for each in names]
        fits = iter([SimpleNamespace(chi2=each, describes=each <= 10) for each in sizes])
        monkeypatch.setattr(free_causes, "likely_places", lambda _, others=others: others)
        monkeypatch.setattr(free_causes, "Problem", lambda each: each)
        monkeypatch.setattr(free_causes, "_other_count", lambda *_: "")
        (cause,) = free_causes.other_places(
            SimpleNamespace(model=None), {}, lambda *_, fits=fits: next(fits)
        )
        assert cause.what == f"the sensor 'ball 5' in {names[place]} instead"
        assert len(list(fits)) == 3 - tried
